//! Measures of how streets join.

use super::scene::Scene;
use super::spread;
use std::collections::BTreeMap;

/// Median metres between crossings: chains through nodes of degree 2 count as one.
pub fn segment_median(scene: &Scene) -> Option<f64> {
    spread::quantile(&lengths_between_crossings(scene), 0.5)
}

/// Standard deviation over mean of the lengths between crossings.
pub fn segment_cv(scene: &Scene) -> Option<f64> {
    spread::variation(&lengths_between_crossings(scene))
}

/// Nodes of degree 3 or more per square kilometre.
pub fn crossings_km2(scene: &Scene) -> f64 {
    ends(scene).values().filter(|arms| arms.len() >= 3).count() as f64 / scene.km2
}

/// Kilometres of street per square kilometre.
pub fn km_per_km2(scene: &Scene) -> f64 {
    piece_metres(scene) / 1000.0 / scene.km2
}

/// The share of nodes of some degree among those of any but 2.
pub fn degree_share(scene: &Scene, degree: usize) -> Option<f64> {
    let degrees: Vec<usize> = ends(scene).values().map(Vec::len).filter(|&degree| degree != 2).collect();
    let such = degrees.iter().filter(|&&other| other == degree).count();
    (!degrees.is_empty()).then(|| such as f64 / degrees.len() as f64)
}

/// The share of street length in the largest network that hangs together.
pub fn largest_component(scene: &Scene) -> Option<f64> {
    let ends = ends(scene);
    let mut seen = vec![false; scene.streets.len()];
    let mut largest: f64 = 0.0;
    for first in 0..scene.streets.len() {
        let (mut waiting, mut length) = (vec![first], 0.0);
        while let Some(street) = waiting.pop() {
            if !std::mem::replace(&mut seen[street], true) {
                length += scene.streets[street].length;
                let joined = [scene.streets[street].from, scene.streets[street].to].map(|end| &ends[end]);
                waiting.extend(joined.into_iter().flatten());
            }
        }
        largest = largest.max(length);
    }
    let all: f64 = scene.streets.iter().map(|street| street.length).sum();
    (all > 0.0).then(|| largest / all)
}

/// The share of length on bridges or in tunnels.
pub fn bridge_share(scene: &Scene) -> Option<f64> {
    // A sum of nothing would be below zero by its sign.
    let raised = scene.pieces.iter().filter(|piece| piece.is_raised).fold(0.0, |sum, piece| sum + piece.length);
    let all = piece_metres(scene);
    (all > 0.0).then(|| raised / all)
}

fn piece_metres(scene: &Scene) -> f64 {
    scene.pieces.iter().map(|piece| piece.length).sum()
}

/// The streets that end at each node; a loop ends there twice.
fn ends<'a>(scene: &Scene<'a>) -> BTreeMap<&'a str, Vec<usize>> {
    let mut ends: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    for (i, street) in scene.streets.iter().enumerate() {
        ends.entry(street.from).or_default().push(i);
        ends.entry(street.to).or_default().push(i);
    }
    ends
}

/// Metres of each chain of streets from crossing to crossing. Rings without a crossing have none.
fn lengths_between_crossings(scene: &Scene) -> Vec<f64> {
    let ends = ends(scene);
    let mut used = vec![false; scene.streets.len()];
    let mut lengths = Vec::new();
    for (&crossing, arms) in ends.iter().filter(|(_, arms)| arms.len() != 2) {
        for &first in arms {
            if !used[first] {
                lengths.push(length_from(scene, &ends, crossing, first, &mut used));
            }
        }
    }
    lengths
}

/// Follows a chain from a crossing to the next.
fn length_from(
    scene: &Scene,
    ends: &BTreeMap<&str, Vec<usize>>,
    crossing: &str,
    first: usize,
    used: &mut [bool],
) -> f64 {
    let (mut here, mut street, mut length) = (crossing, first, 0.0);
    loop {
        used[street] = true;
        let along = &scene.streets[street];
        length += along.length;
        here = if along.from == here { along.to } else { along.from };
        let arms = &ends[here];
        match arms.iter().find(|&&arm| !used[arm]) {
            Some(&next) if arms.len() == 2 => street = next,
            _ => return length,
        }
    }
}
