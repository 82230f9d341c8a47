//! How far it is to what maps mark.

use super::{Field, Fields};
use geom::{Raster, Vec2};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// The distances of maps by name, each made when it is first asked for; `None` where a map marks nothing. Shared by all
/// that grows on the same maps.
#[derive(Clone, Debug, Default)]
pub struct Distances(Arc<Mutex<BTreeMap<String, Option<Arc<Raster>>>>>);

impl Distances {
    fn of(&self, name: &str, map: &Raster) -> Option<Arc<Raster>> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known.get(name) {
            return found.clone();
        }
        let distances = map.distances().map(Arc::new);
        known.insert(name.to_owned(), distances.clone());
        distances
    }
}

impl Fields {
    /// Metres from a line to the nearest place that a map of the site marks (more than one half), to half a cell of the
    /// map; infinite where it marks none, `None` where there is no such map.
    pub fn distance_to(&self, name: &str, from: Vec2, to: Vec2) -> Option<f64> {
        let map = match self.maps.get(name)? {
            Field::Map(map) => map,
            field => return Some(if field.at(to) > 0.5 { 0.0 } else { f64::INFINITY }),
        };
        let distances = self.distances.of(name, map);
        Some(distances.map_or(f64::INFINITY, |distances| nearest(&distances, from, to)))
    }
}

/// The least value along a line of a field that changes by no more than one goes.
fn nearest(distances: &Raster, from: Vec2, to: Vec2) -> f64 {
    let (finest, length) = (distances.pixel_size() / 4.0, (to - from).length());
    let (mut nearest, mut along) = (distances.bilinear(to), 0.0);
    while along < length {
        let here = distances.bilinear(from.lerp(to, along / length));
        nearest = nearest.min(here);
        along += (here - nearest).max(finest);
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use geom::{Bounds, Point};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn is_right_to_half_a_cell(marked in prop::collection::vec(0usize..400, 1..6), x in 0.0f64..100.0, y in 0.0f64..100.0,
                                   dx in -60.0f64..60.0, dy in -60.0f64..60.0) {
            let cell = 5.0;
            let values = (0..400).map(|i| if marked.contains(&i) { 1.0 } else { 0.0 }).collect();
            let map = Arc::new(Raster::new(20, 20, cell, Vec2::ZERO, values).unwrap());
            let bounds = Bounds::between(Point::new(0, 0), Point::new(102_400, 102_400));
            let fields = Fields { maps: [("m".to_owned(), Field::Map(map))].into(), ..Fields::plain(bounds) };
            let (from, to) = (Vec2::new(x, y), (Vec2::new(x + dx, y + dy)).clamp(Vec2::ZERO, Vec2::splat(100.0)));
            let told = fields.distance_to("m", from, to).expect("a map");
            let centre = |i: usize| Vec2::new((i % 20) as f64 + 0.5, 19.5 - (i / 20) as f64) * cell;
            let to_cell = |p: Vec2, i: usize| ((p - centre(i)).abs() - cell / 2.0).max(Vec2::ZERO).length();
            let truth = (0..=400).map(|k| from.lerp(to, f64::from(k) / 400.0));
            let truth = truth.flat_map(|p| marked.iter().map(move |&i| to_cell(p, i))).fold(f64::INFINITY, f64::min);
            prop_assert!((told - truth).abs() <= cell * 0.75, "{told} {truth}");
        }
    }

    #[test]
    fn maps_without_marks_are_infinitely_far() {
        let bounds = Bounds::between(Point::new(0, 0), Point::new(1024, 1024));
        let map = Raster::new(2, 2, 1.0, Vec2::ZERO, vec![0.0; 4]).unwrap();
        let maps = [("none".to_owned(), Field::Map(Arc::new(map))), ("all".to_owned(), Field::Constant(1.0))].into();
        let fields = Fields { maps, ..Fields::plain(bounds) };
        let ask = |name: &str| fields.distance_to(name, Vec2::ZERO, Vec2::ONE);
        assert_eq!((ask("none"), ask("all"), ask("other")), (Some(f64::INFINITY), Some(0.0), None));
    }
}
