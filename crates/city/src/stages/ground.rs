//! What parcel and building rules may ask of a place: the maps of the site and the streets around.

use super::Context;
use crate::Site;
use geom::{Point, Vec2};
use script::{Ground, StreetSide};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::{Class, StreetGraph, StreetId};

/// Side of a cell of the index of streets, metres.
const CELL: f64 = 256.0;

/// A site with its streets, as rules see them.
#[derive(Debug)]
pub(crate) struct CityGround {
    site: Arc<Site>,
    /// By class name.
    lines: BTreeMap<String, Lines>,
    /// Class (the most important where they differ) and greatest width of each street.
    streets: BTreeMap<StreetId, (Class, f64)>,
    classes: Vec<Arc<str>>,
}

impl CityGround {
    /// Indexes all streets.
    pub fn new(context: &Context, graph: &StreetGraph) -> Self {
        let mut lines: BTreeMap<String, Lines> =
            graph.classes().iter().map(|(_, info)| (info.name.clone(), Lines::default())).collect();
        let mut streets: BTreeMap<StreetId, (Class, f64)> = BTreeMap::new();
        for (key, segment) in graph.segments_unsorted() {
            let claim = segment.leading();
            let width = 2.0 * f64::from(segment.half_width()) / Point::UNITS_PER_METRE;
            let known = streets.entry(claim.street).or_insert((claim.class, width));
            *known = (known.0.min(claim.class), known.1.max(width));
            let (from, to) = graph.line(key.forward());
            if let Some(lines) = lines.get_mut(&graph.classes().info(claim.class).name) {
                lines.add(from.metres(), to.metres());
            }
        }
        let classes = graph.classes().iter().map(|(_, info)| info.name.as_str().into()).collect();
        Self { site: context.sources.site.clone(), lines, streets, classes }
    }

    /// Streets with the length fronted, as rules see them.
    pub fn sides(&self, access: &[(StreetId, f64)]) -> Vec<StreetSide> {
        let side = |&(street, length): &(StreetId, f64)| {
            let &(class, width) = self.streets.get(&street)?;
            Some(StreetSide { class: self.classes.get(usize::from(class.0))?.clone(), width, length })
        };
        access.iter().filter_map(side).collect()
    }
}

/// A question about streets that a rule asked while a part of a stage ran, with what it was told.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Read {
    class: String,
    at: Vec2,
    metres: Option<f64>,
}

thread_local! {
    /// The questions asked on this thread, while somebody listens.
    static READS: RefCell<Option<Vec<Read>>> = const { RefCell::new(None) };
}

/// Does some work on this thread, and tells what it asked about streets. Maps do not count: they are the site's.
pub(crate) fn reading<T>(work: impl FnOnce() -> T) -> (T, Vec<Read>) {
    let before = READS.replace(Some(Vec::new()));
    let result = work();
    (result, READS.replace(before).unwrap_or_default())
}

impl CityGround {
    /// Whether questions would be told the same as before.
    pub fn would_tell(&self, reads: &[Read]) -> bool {
        reads.iter().all(|Read { class, at, metres }| self.metres(class, *at) == *metres)
    }

    /// Class and greatest width of a street, as rules see them.
    pub fn street(&self, id: StreetId) -> Option<(Class, f64)> {
        self.streets.get(&id).copied()
    }

    fn metres(&self, class: &str, at: Vec2) -> Option<f64> {
        self.lines.get(class).map(|lines| lines.distance(at))
    }
}

impl Ground for CityGround {
    fn map(&self, name: &str, at: Vec2) -> Option<f64> {
        self.site.map(name).map(|map| map.bilinear(at))
    }

    fn zone(&self, name: &str, at: Vec2) -> Option<f64> {
        self.site.map(name).map(|map| map.nearest(at))
    }

    fn maps(&self) -> Vec<String> {
        self.site.maps.keys().cloned().collect()
    }

    fn distance(&self, class: &str, at: Vec2) -> Option<f64> {
        let metres = self.metres(class, at);
        READS.with_borrow_mut(|reads| {
            if let Some(reads) = reads {
                reads.push(Read { class: class.to_owned(), at, metres });
            }
        });
        metres
    }

    fn classes(&self) -> Vec<String> {
        self.lines.keys().cloned().collect()
    }
}

/// Straight pieces of streets in a grid of cells.
#[derive(Debug, Default)]
struct Lines {
    lines: Vec<(Vec2, Vec2)>,
    cells: BTreeMap<(i64, i64), Vec<u32>>,
}

fn cell(at: Vec2) -> (i64, i64) {
    ((at.x / CELL).floor() as i64, (at.y / CELL).floor() as i64)
}

impl Lines {
    fn add(&mut self, from: Vec2, to: Vec2) {
        let (low, high) = (cell(from.min(to)), cell(from.max(to)));
        for place in (low.0..=high.0).flat_map(|x| (low.1..=high.1).map(move |y| (x, y))) {
            self.cells.entry(place).or_default().push(self.lines.len() as u32);
        }
        self.lines.push((from, to));
    }

    /// Metres to the nearest piece: ring by ring of cells, until no farther ring can hold a nearer one.
    fn distance(&self, at: Vec2) -> f64 {
        let (x, y) = cell(at);
        let far = |&(cx, cy): &(i64, i64)| (cx - x).abs().max((cy - y).abs());
        let Some(last) = self.cells.keys().map(far).max() else { return f64::INFINITY };
        let mut best = f64::INFINITY;
        for ring in 0..=last {
            // What lies beyond this ring is at least so far away.
            if best <= (ring - 1).max(0) as f64 * CELL {
                break;
            }
            for place in around((x, y), ring) {
                let lines = self.cells.get(&place).into_iter().flatten();
                best = lines.fold(best, |best, &line| best.min(distance_to(self.lines[line as usize], at)));
            }
        }
        best
    }
}

/// The cells of a square ring.
fn around((x, y): (i64, i64), ring: i64) -> impl Iterator<Item = (i64, i64)> {
    let rows = [y - ring, y + ring].into_iter().take(if ring == 0 { 1 } else { 2 });
    let columns = [x - ring, x + ring].into_iter().take(if ring == 0 { 0 } else { 2 });
    let along = rows.flat_map(move |row| (x - ring..=x + ring).map(move |column| (column, row)));
    along.chain(columns.flat_map(move |column| (y - ring + 1..y + ring).map(move |row| (column, row))))
}

fn distance_to((from, to): (Vec2, Vec2), at: Vec2) -> f64 {
    let along = to - from;
    let share = ((at - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    at.distance(from + along * share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use geom::Seed;

    #[test]
    fn the_nearest_piece_is_found_by_rings_as_by_trying_all() {
        let draw = |n: u64| Vec2::new(Seed(1).range(2 * n, -3000.0, 5000.0), Seed(1).range(2 * n + 1, 0.0, 900.0));
        let mut lines = Lines::default();
        (0..40).for_each(|n| lines.add(draw(n), draw(n) + draw(n + 500) * 0.1));
        for n in 1000..1300 {
            let brute = lines.lines.iter().map(|&line| distance_to(line, draw(n))).fold(f64::INFINITY, f64::min);
            assert_eq!(lines.distance(draw(n)), brute);
        }
        assert_eq!(Lines::default().distance(Vec2::ZERO), f64::INFINITY);
    }
}
