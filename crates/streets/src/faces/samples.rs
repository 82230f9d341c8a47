//! Graphs for tests: drawn by hand, or at random on a lattice.

use crate::{Claim, Class, Classes, NodeId, NodeKey, StreetGraph, StreetId};
use geom::{Id, Point, Seed, predicates};
use smallvec::{SmallVec, smallvec};
use std::collections::BTreeMap;

/// A drawing of a graph, free of keys: what it says can be built in any order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sketch {
    pub nodes: Vec<Point>,
    pub lines: Vec<Line>,
}

/// A segment of a sketch, from node to node along its street.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    pub ends: [usize; 2],
    pub street: u128,
    pub class: Class,
    pub level: i8,
}

pub(crate) fn street(name: u128) -> StreetId {
    StreetId(Id::root("street", &[name]))
}

/// Numbers in 0..n that depend on the seed, by ordinal.
pub(crate) fn draw(seed: Seed, ordinal: u64, n: usize) -> usize {
    (seed.child(ordinal).0 % n as u64) as usize
}

impl Sketch {
    /// Streets as chains of points, each under its place in the list as name; equal points are one node. Chains must
    /// meet at points of both.
    pub fn of_chains(chains: &[&[(i32, i32)]]) -> Self {
        let mut sketch = Self::default();
        for (name, chain) in chains.iter().enumerate() {
            let nodes: Vec<_> = chain.iter().map(|&(x, y)| sketch.node(Point::new(x, y))).collect();
            let lines = nodes.windows(2).map(|ends| Line::new([ends[0], ends[1]], name as u128));
            sketch.lines.extend(lines);
        }
        sketch
    }

    fn node(&mut self, at: Point) -> usize {
        self.nodes.iter().position(|&node| node == at).unwrap_or_else(|| {
            self.nodes.push(at);
            self.nodes.len() - 1
        })
    }

    /// A random part of a lattice with a diagonal in each cell, for every other seed within a full frame. Rows, columns and diagonals are streets; with
    /// `names` above zero each segment instead belongs to one of so many streets by chance.
    pub fn random(seed: Seed, size: usize, keep: f64, jitter: i32, names: usize) -> Self {
        const STEP: i32 = 4096;
        let moved = |ordinal| seed.purpose("move").range(ordinal, -f64::from(jitter), f64::from(jitter)) as i32;
        let at = |i: usize| ((i % size) as i32 * STEP, (i / size) as i32 * STEP);
        let place = |i: usize| Point::new(at(i).0 + moved(2 * i as u64), at(i).1 + moved(2 * i as u64 + 1));
        let mut lines = Vec::new();
        for i in 0..size * size {
            let (x, y) = (i % size, i / size);
            let is_rising = seed.purpose("diagonal").unit(i as u64) < 0.5;
            let diagonal = if is_rising { [i, i + size + 1] } else { [i + size, i + 1] };
            let steps = [([i, i + 1], x + 1 < size, y), ([i, i + size], y + 1 < size, size + x)];
            let steps = steps.into_iter().chain([(diagonal, x + 1 < size && y + 1 < size, 2 * size + i)]);
            for (slot, (ends, exists, name)) in steps.enumerate() {
                let ordinal = (3 * i + slot) as u64;
                let is_frame = seed.0.is_multiple_of(2) && slot < 2 && [0, size - 1].contains(&[y, x][slot]);
                if exists && (is_frame || seed.purpose("keep").unit(ordinal) < keep) {
                    let name = if names == 0 { name } else { draw(seed.purpose("name"), ordinal, names) };
                    let ends = if names > 0 && ordinal.is_multiple_of(2) { [ends[1], ends[0]] } else { ends };
                    lines.push(Line::new(ends, name as u128));
                }
            }
        }
        Self { nodes: (0..size * size).map(place).collect(), lines }
    }

    /// The same turned by 90° counter-clockwise.
    pub fn turned(&self) -> Self {
        let nodes = self.nodes.iter().map(|p| Point::new(-p.y, p.x)).collect();
        Self { nodes, lines: self.lines.clone() }
    }

    /// The graph. Another seed gives other keys, and other directions of segments, but the same streets.
    pub fn build(&self, order: Seed) -> StreetGraph {
        let mut graph = StreetGraph::new(Classes::default());
        let ends = self.arms();
        let keys: BTreeMap<usize, NodeKey> = shuffled(order, ends.keys().copied())
            .into_iter()
            .map(|i| (i, self.add_node(&mut graph, i, &ends[&i])))
            .collect();
        for i in shuffled(order.child(1), 0..self.lines.len()) {
            let line = &self.lines[i];
            let forward = draw(order, i as u64, 2) == 0;
            let [a, b] = line.ends.map(|end| keys[&end]);
            let claim = Claim { street: street(line.street), class: line.class, half_width: 1024, origin: 0, forward };
            graph.add_segment(if forward { [a, b] } else { [b, a] }, line.level, smallvec![claim]);
        }
        graph.commit();
        graph
    }

    fn add_node(&self, graph: &mut StreetGraph, i: usize, arms: &[(u128, usize)]) -> NodeKey {
        let id = NodeId(Id::root("node", &[i as u128]));
        let key = graph.add_node(id, self.nodes[i], street(arms[0].0));
        let mut names: Vec<u128> = arms.iter().map(|arm| arm.0).collect();
        names.sort_unstable();
        names.dedup();
        for name in names {
            let far: SmallVec<[Point; 4]> =
                arms.iter().filter(|arm| arm.0 == name).map(|arm| self.nodes[arm.1]).collect();
            let passes = |p: &Point| far.iter().any(|q| predicates::on_segment(*p, *q, self.nodes[i]));
            let is_straight = far.iter().all(passes);
            if !is_straight {
                graph.pin(key, street(name));
            }
        }
        key
    }

    /// For each node with segments: the streets of its arms and where they lead.
    fn arms(&self) -> BTreeMap<usize, Vec<(u128, usize)>> {
        let mut arms: BTreeMap<usize, Vec<(u128, usize)>> = BTreeMap::new();
        for line in &self.lines {
            let [a, b] = line.ends;
            arms.entry(a).or_default().push((line.street, b));
            arms.entry(b).or_default().push((line.street, a));
        }
        arms
    }
}

impl Line {
    pub fn new(ends: [usize; 2], street: u128) -> Self {
        Self { ends, street, class: Classes::MAJOR, level: 0 }
    }
}

/// The items in an order that the seed decides.
fn shuffled(seed: Seed, items: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut items: Vec<usize> = items.collect();
    items.sort_by_key(|&item| seed.child(item as u64).0);
    items
}
