//! The streets around a proposal, gathered once, and the questions the local constraints ask of them. What is answered
//! here only shapes a proposal; that the graph stays planar is the business of the insertion.

use super::slots::RimSlots;
use crate::{Class, SegmentKey, StreetGraph};
use geom::{Bounds, Point, predicates, tolerance};

/// Largest sine of the angle at which two lines count as near-parallel (20.5°).
const PARALLEL_SINE: f64 = 0.35;
/// Share of the shorter of two near-parallel lines that must lie beside the other for the two to be duplicates.
const DUPLICATE_SHARE: f64 = 0.5;
/// A place this close (LSB) to a segment lies on it: the rounding of the place plus that of the segment's ends.
const ON_LINE: i32 = 3;

/// A line that passes a crossing closer than this (LSB) may be led through it: cuts with two of its streets would come to
/// lie closer than the laying distance.
const PASSED: i32 = 3 * tolerance::LAYING;

/// Segments of the ground near a proposal.
#[derive(Clone, Debug)]
pub(super) struct Near {
    /// The class of what grows.
    class: Class,
    lines: Vec<Line>,
    /// Bridges and tunnels: they count where they come down.
    raised: Vec<Line>,
}

/// A segment: its ends, and half its right-of-way in LSB.
#[derive(Clone, Copy, Debug)]
struct Line {
    a: Point,
    b: Point,
    half_width: i32,
    /// Whether it bounds the quarter of what grows: streets come to its slots only.
    is_rim: bool,
}

impl Line {
    /// Where a street that comes to a place on this one ends.
    fn place(&self, at: Point, slots: &RimSlots) -> Point {
        if self.is_rim { slots.slot(self.a, self.b, at) } else { at }
    }
}

/// Where a line first meets the streets around.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Met {
    /// How far from the start the street is met, squared.
    pub away: i64,
    /// The place, rounded, or the slot there.
    pub at: Point,
    /// Whether it is a crossing that is there already, rather than a street between two.
    pub is_node: bool,
}

impl Near {
    /// Nothing yet, for streets of a class.
    pub fn of(class: Class) -> Self {
        Self { class, lines: Vec::new(), raised: Vec::new() }
    }

    /// Gathers the segments whose box overlaps the box. The order is that of keys: answers do not depend on
    /// it.
    pub fn gather(&mut self, graph: &StreetGraph, bounds: Bounds) {
        self.gather_where(graph, bounds, |_| true);
    }

    /// The same for segments that `admit` admits.
    pub fn gather_where(&mut self, graph: &StreetGraph, bounds: Bounds, admit: impl Fn(SegmentKey) -> bool) {
        self.lines.clear();
        self.raised.clear();
        self.add_where(graph, bounds, admit);
    }

    /// Adds such segments to those that are known.
    pub fn add_where(&mut self, graph: &StreetGraph, bounds: Bounds, admit: impl Fn(SegmentKey) -> bool) {
        let (lines, raised) = (&mut self.lines, &mut self.raised);
        let closes = |class| graph.classes().info(class).closes_quarters;
        let has_rims = !closes(self.class);
        graph.for_segments_near(bounds, |key| {
            if !admit(key) {
                return;
            }
            let segment = graph.segment(key);
            let (a, b) = graph.line(key.forward());
            let found = if segment.level == 0 { &mut *lines } else { &mut *raised };
            let is_rim = has_rims && closes(segment.class());
            found.push(Line { a, b, half_width: segment.half_width(), is_rim });
        });
    }

    fn all(&self) -> impl Iterator<Item = &Line> {
        self.lines.iter().chain(&self.raised)
    }

    /// All lines, with whether they lie on the ground: of others only the ends are met.
    fn with_level(&self) -> impl Iterator<Item = (&Line, bool)> {
        self.lines.iter().map(|line| (line, true)).chain(self.raised.iter().map(|line| (line, false)))
    }

    /// The first street that the line from `from` to `to` crosses, or crossing that it passes closer than `snap` LSB,
    /// there the crossing. Streets that `from` lies on, and crossings closer than `least` to it, are passed over.
    pub fn first_met(&self, (from, to): (Point, Point), snap: i32, least: i32, slots: &RimSlots) -> Option<Met> {
        let mut best: Option<Met> = None;
        let mut offer = |away: i64, at: Point, is_node: bool| {
            if best.is_none_or(|met| (away, at) < (met.away, met.at)) {
                best = Some(Met { away, at, is_node });
            }
        };
        let length_squared = from.distance_squared(to) as f64;
        let touch_share = f64::from(tolerance::LAYING) / length_squared.sqrt();
        let (reach, least_share) = (f64::from(snap) * length_squared.sqrt(), f64::from(least) / length_squared.sqrt());
        for (line, is_on_ground) in self.with_level() {
            let (a, b) = (line.a, line.b);
            let sides = [a, b].map(|end| predicates::orient(from, to, end));
            for (end, side) in [a, b].into_iter().zip(sides) {
                let share = predicates::dot(from, to, end) as f64 / length_squared;
                if (side as f64).abs() < reach && share >= least_share && share <= 1.0 {
                    offer(from.distance_squared(end), end, true);
                }
            }
            if !is_on_ground
                || a == from
                || b == from
                || (sides[0] > 0 && sides[1] > 0)
                || (sides[0] < 0 && sides[1] < 0)
            {
                continue;
            }
            let (before, after) = (predicates::orient(a, b, from), predicates::orient(a, b, to));
            if before == 0 || (before > 0) == (after > 0) && after != 0 {
                continue;
            }
            let share = before as f64 / (before - after) as f64;
            if share > touch_share
                && let Some(at) = predicates::cut(from, to, a, b)
            {
                offer(from.distance_squared(at), line.place(at, slots), false);
            }
        }
        best
    }

    /// The crossing nearest to `p`, closer than `snap` LSB and other than `except`.
    pub fn node_within(&self, p: Point, snap: i32, except: Point) -> Option<Point> {
        let limit = i64::from(snap) * i64::from(snap);
        let ends = self.all().flat_map(|line| [line.a, line.b]).filter(|&end| end != except);
        let nearest = ends.map(|end| (end.distance_squared(p), end)).min()?;
        (nearest.0 < limit).then_some(nearest.1)
    }

    /// The place nearest to `p` on a street closer than `snap` LSB that does not start at `except`.
    pub fn foot_within(&self, p: Point, snap: i32, except: Point, slots: &RimSlots) -> Option<Point> {
        let lines = self.lines.iter().filter(|line| line.a != except && line.b != except);
        let close = lines.filter(|line| predicates::within(line.a, line.b, p, snap));
        let feet = close.map(|line| (predicates::foot(line.a, line.b, p), line));
        let nearest = feet.min_by_key(|(foot, line)| (foot.distance_squared(p), *foot, line.a.min(line.b)));
        nearest.map(|(foot, line)| line.place(foot, slots))
    }

    /// Whether a street is crossed on the way from `from` to `to`.
    pub fn is_crossed(&self, from: Point, to: Point) -> bool {
        self.lines.iter().any(|line| predicates::crosses_properly(from, to, line.a, line.b))
    }

    /// Whether a street ends at `p`.
    pub fn has_node_at(&self, p: Point) -> bool {
        self.lines.iter().any(|line| line.a == p || line.b == p)
    }

    /// Whether a street lies closer than `reach` LSB to `p`.
    pub fn has_street_within(&self, p: Point, reach: i32) -> bool {
        self.lines.iter().any(|line| predicates::within(line.a, line.b, p, reach))
    }

    /// Whether a line of that half width runs along a street: near-parallel, and more than half of the shorter of the
    /// two lies closer than `width` LSB to the other, or so close that their roadways overlap. Symmetric in the two.
    pub fn is_duplicate(&self, from: Point, to: Point, half_width: i32, width: i32) -> bool {
        self.lines.iter().any(|line| {
            let width = width.max(half_width.saturating_add(line.half_width));
            are_duplicates((from, to), (line.a, line.b), f64::from(width))
        })
    }

    /// Whether more than half of a line runs so along streets, whatever pieces their crossings make of them.
    pub fn runs_along(&self, from: Point, to: Point, half_width: i32, width: i32) -> bool {
        let beside = self.lines.iter().filter(|line| are_parallel((from, to), (line.a, line.b))).map(|line| {
            let width = width.max(half_width.saturating_add(line.half_width));
            share_beside((line.a, line.b), (from, to), f64::from(width)).max(0.0)
        });
        beside.sum::<f64>() > DUPLICATE_SHARE
    }

    /// Whether the line from `at` to `to` makes an angle at `at` with a street there whose cosine exceeds `cosine`.
    pub fn is_sharp(&self, at: Point, to: Point, cosine: f64) -> bool {
        let direction = at.to(to);
        let is_near = |other: (i64, i64)| is_within(direction, other, cosine);
        let comes_down =
            |line: &Line| (line.a == at && is_near(at.to(line.b))) || (line.b == at && is_near(at.to(line.a)));
        self.raised.iter().any(comes_down)
            || self.lines.iter().any(|&Line { a, b, .. }| {
                if a == at {
                    is_near(a.to(b))
                } else if b == at {
                    is_near(b.to(a))
                } else {
                    let is_on =
                        Bounds::between(a, b).grown(ON_LINE).contains(at) && predicates::within(a, b, at, ON_LINE);
                    is_on && (is_near(a.to(b)) || is_near(b.to(a)))
                }
            })
    }

    /// Whether the line from `from` to `to` makes such an angle between its ends: with streets at a crossing so close to
    /// it that it will be led through, and, where `crosses`, with streets that it crosses.
    pub fn is_sharp_between(&self, from: Point, to: Point, cosine: f64, crosses: bool) -> bool {
        let direction = from.to(to);
        self.with_level().any(|(&Line { a, b, .. }, is_on_ground)| {
            let is_narrow = || is_within(direction, a.to(b), cosine) || is_within(direction, b.to(a), cosine);
            let is_cut = || is_on_ground && crosses && predicates::crosses_properly(from, to, a, b);
            is_narrow() && (is_passed(from, to, a) || is_passed(from, to, b) || is_cut())
        })
    }

    /// Whether a line from `from` to `to` leaves at most `most` streets in each crossing that it ends or, on the
    /// ground, passes.
    pub fn has_room(&self, from: Point, to: Point, most: u32, is_on_ground: bool) -> bool {
        let has_room = |at: Point, more: u32| self.arms(at) + more <= most;
        let crosses = |line: &Line| most < 4 && predicates::crosses_properly(from, to, line.a, line.b);
        let ends = || self.all().flat_map(|line| [line.a, line.b]);
        has_room(from, 1)
            && has_room(to, 1)
            && !(is_on_ground && self.lines.iter().any(crosses))
            && !(is_on_ground && ends().any(|end| is_passed(from, to, end) && !has_room(end, 2)))
    }

    /// How many streets meet at a place: 2 in the middle of one.
    fn arms(&self, at: Point) -> u32 {
        let ends = |line: &&Line| line.a == at || line.b == at;
        let raised = self.raised.iter().filter(ends).count();
        let on_ground = self.lines.iter().map(|line| match ends(&line) {
            true => 1,
            false => 2 * u32::from(predicates::within(line.a, line.b, at, ON_LINE)),
        });
        on_ground.sum::<u32>() + raised as u32
    }
}

/// Whether a line passes a crossing between its ends so close that it may be led through it.
fn is_passed(from: Point, to: Point, end: Point) -> bool {
    let around = Bounds::between(from, to).grown(PASSED);
    end != from && end != to && around.contains(end) && predicates::within(from, to, end, PASSED)
}

/// Whether the angle between two directions has a greater cosine.
pub(super) fn is_within(direction: (i64, i64), other: (i64, i64), cosine: f64) -> bool {
    let dot = (direction.0 * other.0 + direction.1 * other.1) as f64;
    dot > cosine * (norm_squared(direction) * norm_squared(other)).sqrt()
}

/// Whether two lines keep the laying distance from each other, so that neither is led through an end of the other.
pub(super) fn are_apart((a, b): (Point, Point), (c, d): (Point, Point)) -> bool {
    let is_near = |p, x, y| predicates::within(x, y, p, tolerance::LAYING);
    let is_near_end = is_near(c, a, b) || is_near(d, a, b) || is_near(a, c, d) || is_near(b, c, d);
    !is_near_end && !predicates::meets(a, b, c, d)
}

fn norm_squared(v: (i64, i64)) -> f64 {
    (v.0 * v.0 + v.1 * v.1) as f64
}

fn are_parallel(one: (Point, Point), other: (Point, Point)) -> bool {
    let (u, v) = (one.0.to(one.1), other.0.to(other.1));
    let cross = (u.0 * v.1 - u.1 * v.0) as f64;
    cross.abs() < PARALLEL_SINE * (norm_squared(u).sqrt() * norm_squared(v).sqrt())
}

fn are_duplicates(one: (Point, Point), other: (Point, Point), width: f64) -> bool {
    if !are_parallel(one, other) {
        return false;
    }
    let [length, other_length] = [one, other].map(|(a, b)| norm_squared(a.to(b)).sqrt());
    // Lines of equal length are held against each other both ways, so that the answer does not depend on their order.
    (length >= other_length && share_beside(one, other, width) > DUPLICATE_SHARE)
        || (other_length >= length && share_beside(other, one, width) > DUPLICATE_SHARE)
}

/// The share of `short` that lies beside `long`: between its ends, and at most `width` off it.
fn share_beside(long: (Point, Point), short: (Point, Point), width: f64) -> f64 {
    let squared = long.0.distance_squared(long.1) as f64;
    let along = [short.0, short.1].map(|p| predicates::dot(long.0, long.1, p) as f64);
    let across = [short.0, short.1].map(|p| predicates::orient(long.0, long.1, p) as f64);
    let reach = width * squared.sqrt();
    let share = clip((0.0, 1.0), along, 0.0, squared);
    let share = clip(share, across, -reach, reach);
    share.1 - share.0
}

/// The part of the parameter range where a value that goes linearly from `values[0]` to `values[1]` lies in
/// `low..=high`; an empty range has its ends in the wrong order or equal.
fn clip(range: (f64, f64), values: [f64; 2], low: f64, high: f64) -> (f64, f64) {
    let change = values[1] - values[0];
    if change == 0.0 {
        return if (low..=high).contains(&values[0]) { range } else { (0.0, 0.0) };
    }
    let (a, b) = ((low - values[0]) / change, (high - values[0]) / change);
    (range.0.max(a.min(b)), range.1.min(a.max(b)))
}
