//! After the cuts: pieces that are too small, too thin, or without access join a neighbour; what lies landlocked joins
//! to courts.

use super::map::{LandMap, OUTSIDE};
use super::outline::Measure;
use super::{DivisionStep, Inner, RecursiveSettings, convexity};
use geom::Point;
use smallvec::SmallVec;

/// How stretched (see [`Measure::stretch`]) a piece may become by joining: a rectangle of 1 : 9.
const MOST_STRETCH: f64 = 2.8;

/// The pieces of a map with their measures, by face.
pub(super) struct Lots<'a> {
    map: &'a mut LandMap,
    settings: &'a RecursiveSettings,
    measures: Vec<Measure>,
    tell: &'a mut dyn FnMut(DivisionStep),
}

/// What a join is for.
#[derive(Clone, Copy, PartialEq)]
enum Aim {
    /// Make an unsound piece part of a sound one.
    Soundness,
    /// Make one court of landlocked pieces.
    Court,
}

impl<'a> Lots<'a> {
    /// The pieces of a map.
    pub fn new(map: &'a mut LandMap, settings: &'a RecursiveSettings, tell: &'a mut dyn FnMut(DivisionStep)) -> Self {
        let measures = (0..map.faces.len() as u32).map(|face| Measure::of_face(map, face)).collect();
        Self { map, settings, measures, tell }
    }

    /// Joins what should be joined; gives the measures by face.
    pub fn repair(mut self) -> Vec<Measure> {
        if self.settings.join {
            self.join_all(Aim::Soundness);
        }
        if self.settings.inner == Inner::Open {
            self.join_all(Aim::Court);
        }
        self.measures
    }

    fn join_all(&mut self, aim: Aim) {
        // Each round but the last takes one face away at least.
        loop {
            let mut joined = false;
            for face in 0..self.map.faces.len() as u32 {
                joined |= self.is_live(face) && self.join(face, aim);
            }
            if !joined {
                return;
            }
        }
    }

    fn is_live(&self, face: u32) -> bool {
        !self.map.faces[face as usize].rims.is_empty()
    }

    /// Joins a face to the best neighbour if it needs one and there is one.
    fn join(&mut self, face: u32, aim: Aim) -> bool {
        let measure = &self.measures[face as usize];
        let needs = match aim {
            Aim::Soundness => !self.settings.is_sound(measure) && !self.may_lack_access(face),
            Aim::Court => !self.settings.has_access(measure),
        };
        if !needs {
            return false;
        }
        let suits = |other: &u32| self.suits(face, *other, aim) && self.joint(face, *other).is_some();
        let Some(other) = self.neighbours(face).into_iter().find(suits) else { return false };
        let Some(joint) = self.joint(face, other) else { return false };
        let [piece, to] = [face, other].map(|face| self.map.faces[face as usize].path);
        let area = self.measures[face as usize].area;
        (self.tell)(DivisionStep::Join { piece, to, area, is_court: aim == Aim::Court });
        self.merge(face, other, joint);
        true
    }

    /// Whether a face lacks nothing but access, which it may.
    fn may_lack_access(&self, face: u32) -> bool {
        let seed = self.settings.seed.of(self.map.faces[face as usize].path);
        self.settings.is_roomy(&self.measures[face as usize]) && !self.settings.forces_access(seed)
    }

    /// Neighbours of a face, longest shared border first.
    fn neighbours(&self, face: u32) -> SmallVec<[u32; 8]> {
        let mut shared: SmallVec<[(u32, f64); 8]> = SmallVec::new();
        for half in self.map.halves_of(face) {
            let other = self.map.half(half ^ 1).face;
            let length = self.map.start(half).distance(self.map.end(half));
            match shared.iter_mut().find(|(known, _)| *known == other) {
                Some((_, sum)) => *sum += length,
                None => shared.push((other, length)),
            }
        }
        shared.retain(|&mut (other, _)| other != OUTSIDE && other != face);
        shared.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        shared.into_iter().map(|(other, _)| other).collect()
    }

    /// Whether joining the two serves the aim.
    fn suits(&self, face: u32, other: u32, aim: Aim) -> bool {
        let (a, b) = (&self.measures[face as usize], &self.measures[other as usize]);
        match aim {
            Aim::Court => !self.settings.has_access(b),
            Aim::Soundness => {
                let small = a.area + b.area <= 2.0 * self.settings.most_area;
                let has_access = self.settings.has_access(a) || self.settings.has_access(b);
                small && (has_access || self.settings.inner == Inner::Built)
            }
        }
    }

    /// The first and the last half of `face` along `other`, if they share one stretch and make one simple piece that is
    /// not too stretched.
    fn joint(&self, face: u32, other: u32) -> Option<(u32, u32)> {
        let borders = |half: u32| self.map.half(half ^ 1).face == other;
        let starts_stretch = |&half: &u32| borders(half) && !borders(self.map.half(half).prev);
        let mut starts = self.map.halves_of(face).filter(starts_stretch);
        let first = starts.next()?;
        if starts.next().is_some() {
            return None;
        }
        let last = self.map.rim(first).take_while(|&half| borders(half)).last()?;
        let length: f64 = self.map.rim(first).take_while(|&half| borders(half)).map(|h| self.length(h)).sum();
        (self.touch_nowhere_else(other, first, last)
            && !self.is_stretched(face, other, length)
            && !self.is_concave(face, other))
        .then_some((first, last))
    }

    fn length(&self, half: u32) -> f64 {
        self.map.start(half).distance(self.map.end(half))
    }

    fn is_stretched(&self, face: u32, other: u32, shared: f64) -> bool {
        let (a, b) = (&self.measures[face as usize], &self.measures[other as usize]);
        let perimeter = a.perimeter + b.perimeter - 2.0 * shared;
        let joined = Measure { area: a.area + b.area, perimeter, ..Measure::default() };
        joined.stretch() > MOST_STRETCH.max(b.stretch())
    }

    /// Whether the two together would be more concave than is asked for, and than the larger one is already.
    fn is_concave(&self, face: u32, other: u32) -> bool {
        let least = self.settings.least_convexity;
        if least <= 0.0 {
            return false;
        }
        let corners = |face: u32| self.map.halves_of(face).map(|half| self.map.start(half));
        let area = |face: u32| self.measures[face as usize].area;
        let both: SmallVec<[Point; 32]> = corners(face).chain(corners(other)).collect();
        let alone: SmallVec<[Point; 32]> = corners(other).collect();
        convexity(area(face) + area(other), &both) < least.min(convexity(area(other), &alone))
    }

    /// Whether the face of `first` has no corner in common with another but those of the stretch up to `last`.
    fn touch_nowhere_else(&self, other: u32, first: u32, last: u32) -> bool {
        let corner = |half: u32| self.map.half(half).origin;
        // The rest of the rim starts at the end of the stretch, which the two do share.
        let rest = self.map.rim(self.map.half(last).next).take_while(|&half| half != first).skip(1);
        let ours: SmallVec<[u32; 16]> = rest.map(corner).collect();
        !self.map.halves_of(other).any(|half| ours.contains(&corner(half)))
    }

    /// Makes `face` part of `other`, taking away the border from half `first` to half `last`.
    fn merge(&mut self, face: u32, other: u32, (first, last): (u32, u32)) {
        let map = &mut *self.map;
        let (before, after) = (map.half(first).prev, map.half(last).next);
        let (other_before, other_after) = (map.half(last ^ 1).prev, map.half(first ^ 1).next);
        let mut link = |from: u32, to: u32| {
            map.halves[from as usize].next = to;
            map.halves[to as usize].prev = from;
        };
        link(before, other_after);
        link(other_before, after);
        map.assign(after, other);
        map.faces[face as usize].rims.clear();
        map.faces[other as usize].rims[0] = after;
        self.measures[other as usize] = Measure::of_face(self.map, other);
    }
}
