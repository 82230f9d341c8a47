//! Slow and plain second opinions: exact rationals instead of the predicates of [`geom`], all pairs instead of an
//! index. For checks and tests only.

use geom::Point;
use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

/// Largest coordinate, in LSB (±1 km), that [`Arrangement`] takes: comparing two of its places then fits i128.
pub const LIMIT: i32 = 1 << 20;

/// A fraction in lowest terms with a positive denominator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ratio {
    numerator: i128,
    denominator: i128,
}

impl Ratio {
    /// The fraction of two whole numbers; the denominator must not be 0.
    pub fn new(numerator: i128, denominator: i128) -> Self {
        let divisor = greatest_divisor(numerator, denominator) * denominator.signum();
        Self { numerator: numerator / divisor, denominator: denominator / divisor }
    }

    /// A whole number.
    pub fn whole(value: i32) -> Self {
        Self { numerator: value.into(), denominator: 1 }
    }

    /// The nearest floating-point number, or one beside it.
    pub fn to_f64(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }

    fn is_part(self) -> bool {
        0 <= self.numerator && self.numerator <= self.denominator
    }
}

impl PartialOrd for Ratio {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ratio {
    fn cmp(&self, other: &Self) -> Ordering {
        (self.numerator * other.denominator).cmp(&(other.numerator * self.denominator))
    }
}

fn greatest_divisor(a: i128, b: i128) -> i128 {
    let (mut a, mut b) = (a.abs(), b.abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

fn vector(a: Point, b: Point) -> (i128, i128) {
    (i128::from(b.x) - i128::from(a.x), i128::from(b.y) - i128::from(a.y))
}

fn cross(a: (i128, i128), b: (i128, i128)) -> i128 {
    a.0 * b.1 - a.1 * b.0
}

fn dot(a: (i128, i128), b: (i128, i128)) -> i128 {
    a.0 * b.0 + a.1 * b.1
}

/// How two segments that are not parallel lie: the parameter of the cut on each, or `None` for parallel ones.
fn parameters(a: Point, b: Point, c: Point, d: Point) -> Option<(Ratio, Ratio)> {
    let (along, other, between) = (vector(a, b), vector(c, d), vector(a, c));
    let denominator = cross(along, other);
    let on = |numerator| Ratio::new(numerator, denominator);
    (denominator != 0).then(|| (on(cross(between, other)), on(cross(between, along))))
}

/// Whether a point lies on a closed segment: at no height above its line, and at a parameter within it.
pub(crate) fn lies_on(a: Point, b: Point, p: Point) -> bool {
    let (line, to) = (vector(a, b), vector(a, p));
    if line == (0, 0) {
        return to == (0, 0);
    }
    cross(line, to) == 0 && Ratio::new(dot(line, to), dot(line, line)).is_part()
}

/// Whether two closed segments have a point in common, by solving for it.
pub(crate) fn meets(a: Point, b: Point, c: Point, d: Point) -> bool {
    match parameters(a, b, c, d) {
        Some((on_first, on_second)) => on_first.is_part() && on_second.is_part(),
        None => lies_on(a, b, c) || lies_on(a, b, d) || lies_on(c, d, a) || lies_on(c, d, b),
    }
}

/// Whether a point lies closer than `radius` to a closed segment: the squared distance as a fraction.
pub(crate) fn within(a: Point, b: Point, p: Point, radius: i32) -> bool {
    let (line, to) = (vector(a, b), vector(a, p));
    let (length, along, reach) = (dot(line, line), dot(line, to), i128::from(radius) * i128::from(radius));
    if along <= 0 || length == 0 {
        return dot(to, to) < reach;
    }
    if along >= length {
        let beyond = vector(b, p);
        return dot(beyond, beyond) < reach;
    }
    // |to|² - along² / length < reach
    dot(to, to) * length - along * along < reach * length
}

/// Disjoint sets of numbers.
pub(crate) struct Sets(Vec<usize>);

impl Sets {
    pub fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    /// Joins the sets of two numbers. Whether they were two.
    pub fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a] = b;
        a != b
    }
}

/// A line of the input lies outside ±[`LIMIT`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a line lies outside the ±{LIMIT} units that the arrangement takes")]
pub struct OutOfRange;

/// A place with rational coordinates, in LSB.
pub type Place = (Ratio, Ratio);

/// The planar arrangement of a set of lines, unrounded. A graph that the lines are inserted into has the same counts
/// whenever nothing in it is snapped, which is certain where `min_separation` is more than twice
/// [`geom::tolerance::LAYING`].
#[derive(Clone, Debug, PartialEq)]
pub struct Arrangement {
    /// Ends, cuts and ends of overlaps, sorted.
    pub nodes: Vec<Place>,
    /// Number of pieces between consecutive nodes; what coincides counts once.
    pub segments: usize,
    /// Number of bounded faces.
    pub faces: usize,
    /// Number of connected components.
    pub components: usize,
    /// Least distance in LSB between two nodes, or between a node and a piece that does not end there; infinite where
    /// there is no such pair.
    pub min_separation: f64,
}

impl Arrangement {
    /// The arrangement of closed lines, in O(n² log n) for the counts. Lines without length are left out.
    pub fn of(lines: &[(Point, Point)]) -> Result<Self, OutOfRange> {
        let in_range = |p: &Point| p.x.abs() <= LIMIT && p.y.abs() <= LIMIT;
        if !lines.iter().all(|(a, b)| in_range(a) && in_range(b)) {
            return Err(OutOfRange);
        }
        let lines: Vec<_> = lines.iter().copied().filter(|(a, b)| a != b).collect();
        let stops: Vec<Vec<Place>> = lines.iter().map(|&line| stops_on(line, &lines)).collect();
        let nodes: BTreeSet<Place> = stops.iter().flatten().copied().collect();
        let slot_of: BTreeMap<Place, usize> = nodes.iter().enumerate().map(|(slot, &place)| (place, slot)).collect();
        let ends = |pair: &[Place]| (slot_of[&pair[0]], slot_of[&pair[1]]);
        let pieces: BTreeSet<(usize, usize)> = stops.iter().flat_map(|stops| stops.windows(2).map(ends)).collect();
        let nodes: Vec<Place> = nodes.into_iter().collect();
        let mut sets = Sets::new(nodes.len());
        let joins = pieces.iter().filter(|&&(a, b)| sets.join(a, b)).count();
        let min_separation = min_separation(&nodes, &pieces);
        let components = nodes.len() - joins;
        let faces = pieces.len() + components - nodes.len();
        Ok(Self { nodes, segments: pieces.len(), faces, components, min_separation })
    }
}

/// The places where a line ends, is cut, or another one's end lies on it; in order along it.
fn stops_on((a, b): (Point, Point), lines: &[(Point, Point)]) -> Vec<Place> {
    let whole = |p: Point| (Ratio::whole(p.x), Ratio::whole(p.y));
    let mut stops = BTreeSet::from([whole(a), whole(b)]);
    for &(c, d) in lines {
        match parameters(a, b, c, d) {
            Some((here, there)) if here.is_part() && there.is_part() => {
                stops.insert(place_at(a, b, here));
            }
            Some(_) => {}
            None => stops.extend([c, d].into_iter().filter(|&p| lies_on(a, b, p)).map(whole)),
        }
    }
    stops.into_iter().collect()
}

fn place_at(a: Point, b: Point, at: Ratio) -> Place {
    let (dx, dy) = vector(a, b);
    let coordinate =
        |from: i32, d: i128| Ratio::new(i128::from(from) * at.denominator + d * at.numerator, at.denominator);
    (coordinate(a.x, dx), coordinate(a.y, dy))
}

fn min_separation(nodes: &[Place], pieces: &BTreeSet<(usize, usize)>) -> f64 {
    let points: Vec<geom::Vec2> = nodes.iter().map(|(x, y)| geom::Vec2::new(x.to_f64(), y.to_f64())).collect();
    let mut least = f64::INFINITY;
    for (i, &p) in points.iter().enumerate() {
        for &q in &points[i + 1..] {
            least = least.min(p.distance(q));
        }
        for &(from, to) in pieces.iter().filter(|&&(from, to)| from != i && to != i) {
            let (a, line) = (points[from], points[to] - points[from]);
            let part = ((p - a).dot(line) / line.length_squared()).clamp(0.0, 1.0);
            least = least.min(p.distance(a + line * part));
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faces::{FaceKind, Faces};
    use crate::graph::{CheckLevel, Crowding, NewSegment};
    use crate::{Claim, Classes, NodeId, StreetGraph, StreetId};
    use geom::{Id, Seed, predicates, tolerance};
    use proptest::prelude::*;

    fn any_point() -> impl Strategy<Value = Point> {
        let coordinate = prop_oneof![-Point::LIMIT..=Point::LIMIT, -9..=9];
        (coordinate.clone(), coordinate).prop_map(|(x, y)| Point::new(x, y))
    }

    fn lines(points: &[(i32, i32, i32, i32)]) -> Vec<(Point, Point)> {
        points.iter().map(|&(a, b, c, d)| (Point::new(a, b), Point::new(c, d))).collect()
    }

    fn counts(lines: &[(Point, Point)]) -> (usize, usize, usize, usize) {
        let found = Arrangement::of(lines).unwrap();
        (found.nodes.len(), found.segments, found.faces, found.components)
    }

    #[test]
    fn a_hash_sign_has_one_face() {
        let hash = lines(&[(0, 1000, 3000, 1000), (0, 2000, 3000, 2000), (1000, 0, 1000, 3000), (2000, 0, 2000, 3000)]);
        assert_eq!(counts(&hash), (12, 12, 1, 1));
        assert_eq!(Arrangement::of(&hash).unwrap().min_separation, 1000.0);
    }

    #[test]
    fn overlaps_count_once() {
        assert_eq!(counts(&lines(&[(0, 0, 300, 0), (100, 0, 400, 0), (50, 0, 50, 0), (0, 90, 9, 90)])), (6, 4, 0, 2));
    }

    #[test]
    fn a_star_meets_in_one_rational_place() {
        let star = lines(&[(0, 0, 3, 3), (3, 0, 0, 3), (0, 1, 3, 2)]);
        let found = Arrangement::of(&star).unwrap();
        let half = Ratio::new(3, 2);
        assert!(found.nodes.contains(&(half, half)));
        assert_eq!((found.nodes.len(), found.segments, found.faces), (7, 6, 0));
    }

    #[test]
    fn what_lies_too_far_is_refused() {
        assert_eq!(Arrangement::of(&lines(&[(0, 0, LIMIT + 1, 0)])), Err(OutOfRange));
    }

    proptest! {
        #[test]
        fn predicates_agree(a in any_point(), b in any_point(), c in any_point(), d in any_point(), radius in 0..2000) {
            prop_assert_eq!(meets(a, b, c, d), predicates::meets(a, b, c, d));
            prop_assert_eq!(lies_on(a, b, c), predicates::on_segment(a, b, c));
            prop_assert_eq!(within(a, b, c, radius), predicates::within(a, b, c, radius));
        }
    }

    /// Lines by chance: on a coarse lattice (many meet in one node, many overlap), anywhere, and through one place.
    fn random_lines(seed: Seed, count: usize, kind: usize) -> Vec<(Point, Point)> {
        let coordinate = |ordinal: u64| match kind {
            0 => (seed.child(ordinal).0 % 7) as i32 * 4096,
            1 => (seed.child(ordinal).0 % 60_000) as i32,
            _ => (seed.child(ordinal).0 % 40) as i32 * 4096 - 80_000,
        };
        let point = |ordinal: usize| Point::new(coordinate(2 * ordinal as u64), coordinate(2 * ordinal as u64 + 1));
        let line = |i: usize| {
            let (a, b) = (point(2 * i), point(2 * i + 1));
            if kind == 2 && i.is_multiple_of(2) { (a, Point::new(-a.x, -a.y)) } else { (a, b) }
        };
        (0..count).map(line).filter(|(a, b)| a != b).collect()
    }

    fn inserted(lines: &[(Point, Point)]) -> StreetGraph {
        let mut graph = StreetGraph::new(Classes::default());
        for (name, &(from, to)) in lines.iter().enumerate() {
            let street = StreetId(Id::root("street", &[name as u128]));
            let claim = Claim { street, class: Classes::MAJOR, half_width: 4096, origin: 0, forward: true };
            let [from_id, to_id] = [0, 1].map(|slot| NodeId(street.0.child(slot)));
            // What is too short or too crowded to lay is not separated either, and then counts are not compared.
            let _ = graph.insert(&NewSegment { from, to, from_id, to_id, claim, level: 0 }, Crowding::Join);
        }
        graph
    }

    #[test]
    fn insertion_agrees_where_nothing_snaps() {
        // `PLAT_ORACLE_SETS=10000` for the long version.
        let sets = std::env::var("PLAT_ORACLE_SETS").ok().and_then(|sets| sets.parse().ok()).unwrap_or(600);
        let mut compared = [0; 3];
        for case in 0..sets {
            let (seed, kind) = (Seed(case), case as usize % 3);
            let lines = random_lines(seed, 2 + (seed.child(9999).0 % 10) as usize, kind);
            let expected = Arrangement::of(&lines).unwrap();
            let graph = inserted(&lines);
            assert_eq!(graph.check(CheckLevel::Brute), [], "case {case}");
            if expected.min_separation > 2.0 * f64::from(tolerance::LAYING) {
                let faces = Faces::of(&graph, FaceKind::Block).faces.len();
                assert_eq!(graph.node_count(), expected.nodes.len(), "case {case}");
                assert_eq!((graph.segment_count(), faces), (expected.segments, expected.faces), "case {case}");
                compared[kind] += 1;
            }
        }
        assert!(compared.iter().all(|&cases| cases > sets / 20), "{compared:?} cases compared");
    }
}
