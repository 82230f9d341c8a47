//! Outlines of cells, traced exactly: every component of cells that share sides becomes one valid polygon.

use super::Cells;
use crate::polygon::{ring_doubled_area, without_collinear};
use crate::{Point, Polygon};
use std::collections::BTreeMap;

/// A crossing of two lines of the grid: column, row from the south.
type Corner = (u32, u32);

/// A stretch of a component's rim, the component on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Side {
    component: u32,
    from: Corner,
    to: Corner,
}

impl Cells {
    /// The outlines of all labels: by label, then by their first corner. Areas add up exactly, outlines are valid and
    /// have no collinear corners. Cells of one label that touch in a corner only belong to different outlines.
    pub fn polygons(&self) -> Vec<(u16, Polygon)> {
        let components = self.components();
        let mut sides = self.sides(&components);
        sides.sort_unstable();
        let mut found: Vec<(u16, Polygon)> = sides
            .chunk_by(|a, b| a.component == b.component)
            .filter_map(|own| Some((self.runs[own[0].component as usize].label?, self.outline(own))))
            .collect();
        found.sort_by(|(a, p), (b, q)| a.cmp(b).then_with(|| p.outer.first().cmp(&q.outer.first())));
        found
    }

    /// For each run, the first run of those it hangs together with by shared sides.
    fn components(&self) -> Vec<u32> {
        let mut parents: Vec<u32> = (0..self.runs.len() as u32).collect();
        for row in 1..self.height() {
            self.for_contacts(row, |_, _, below, above| {
                if self.label(below).is_some() && self.label(below) == self.label(above) {
                    join(&mut parents, below, above);
                }
            });
        }
        (0..parents.len() as u32).map(|run| root(&mut parents, run)).collect()
    }

    fn label(&self, run: u32) -> Option<u16> {
        self.runs[run as usize].label
    }

    /// Calls `meet(from column, to column, run below, run above)` for every stretch of the line below a row.
    fn for_contacts(&self, row: usize, mut meet: impl FnMut(u32, u32, u32, u32)) {
        let (mut below, mut above, mut from) = (self.starts[row - 1], self.starts[row], 0);
        while below < self.starts[row] && above < self.starts[row + 1] {
            let (a, b) = (self.runs[below].end, self.runs[above].end);
            let to = a.min(b);
            meet(from, to, below as u32, above as u32);
            from = to;
            below += usize::from(a == to);
            above += usize::from(b == to);
        }
    }

    /// Every stretch where a component ends.
    fn sides(&self, components: &[u32]) -> Vec<Side> {
        let mut sides = Vec::new();
        let mut add = |run: u32, from: Corner, to: Corner| {
            if self.label(run).is_some() {
                sides.push(Side { component: components[run as usize], from, to });
            }
        };
        let height = self.height();
        for row in 0..height {
            let (south, north) = (row as u32, row as u32 + 1);
            for (run, (west, east, _)) in (self.starts[row] as u32..).zip(self.spans(row)) {
                add(run, (west, north), (west, south));
                add(run, (east, south), (east, north));
                if row == 0 {
                    add(run, (west, south), (east, south));
                }
                if row + 1 == height {
                    add(run, (east, north), (west, north));
                }
            }
            if row > 0 {
                self.for_contacts(row, |west, east, below, above| {
                    if components[below as usize] != components[above as usize] {
                        add(below, (east, south), (west, south));
                        add(above, (west, south), (east, south));
                    }
                });
            }
        }
        sides
    }

    /// The polygon of a component's sides, which are sorted.
    fn outline(&self, sides: &[Side]) -> Polygon {
        let mut used = vec![false; sides.len()];
        let mut polygon = Polygon::default();
        for first in 0..sides.len() {
            if used[first] {
                continue;
            }
            for ring in simple_loops(&walk(sides, &mut used, first)) {
                let ring = self.ring(&ring);
                if ring_doubled_area(&ring) > 0 {
                    polygon.outer = ring;
                } else {
                    polygon.holes.push(ring);
                }
            }
        }
        polygon.holes.sort();
        polygon
    }

    /// Corners as lattice points, from the least one on, without those in the middle of a straight side.
    fn ring(&self, corners: &[Corner]) -> Vec<Point> {
        let points = corners.iter().map(|&(x, y)| Point::new(self.columns[x as usize], self.rows[y as usize]));
        let mut ring = without_collinear(&points.collect::<Vec<_>>());
        let least = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap_or(0);
        ring.rotate_left(least);
        ring
    }
}

/// Follows sides from one on until it is reached again.
fn walk(sides: &[Side], used: &mut [bool], first: usize) -> Vec<Corner> {
    let mut corners = Vec::new();
    let mut at = first;
    while !used[at] {
        used[at] = true;
        corners.push(sides[at].from);
        let next = sides.partition_point(|side| side.from < sides[at].to);
        let leaving = (next..sides.len()).take_while(|&i| sides[i].from == sides[at].to);
        // Where two leave, one was taken already or either will do: loops are made simple afterwards.
        at = leaving.into_iter().find(|&i| !used[i]).unwrap_or(first);
    }
    corners
}

/// Parts a closed walk into loops that pass no corner twice.
fn simple_loops(corners: &[Corner]) -> Vec<Vec<Corner>> {
    let (mut loops, mut path) = (Vec::new(), Vec::<Corner>::new());
    let mut places: BTreeMap<Corner, usize> = BTreeMap::new();
    for &corner in corners {
        if let Some(&start) = places.get(&corner) {
            path[start..].iter().for_each(|passed| _ = places.remove(passed));
            loops.push(path.split_off(start));
        }
        places.insert(corner, path.len());
        path.push(corner);
    }
    loops.push(path);
    loops
}

/// The least run that a run is joined with.
fn root(parents: &mut [u32], run: u32) -> u32 {
    let mut at = run;
    while parents[at as usize] != at {
        parents[at as usize] = parents[parents[at as usize] as usize];
        at = parents[at as usize];
    }
    at
}

fn join(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}
