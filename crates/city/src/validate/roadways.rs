//! V7: parcels and buildings keep out of the right-of-way of every street on the ground.

use super::areas::separable;
use super::ground::{Area, Ground, Street};
use super::index::Grid;
use super::{SLIVER_M, ValidationReport};
use geom::boolean::intersection;
use geom::point::units;
use geom::strip::{Reach, strip, wedge};
use geom::{Bounds, Point, Polygon};

/// Less than this much of a roadway (m²) under a parcel is rounding.
const ALLOWED_M2: f64 = 0.05;

/// A strip is drawn up to three LSB too wide by its rounding.
const STRIP_ROUNDING: i32 = 3;

/// Checks V7.
pub fn check(ground: &Ground<'_>, report: &mut ValidationReport) {
    for (kind, areas) in [("parcel", &ground.parcels), ("building", &ground.buildings)] {
        let sound: Vec<&Area<'_>> = areas.iter().filter(|area| area.sound).collect();
        let grid = Grid::new(sound.iter().map(|area| area.bounds).collect());
        for street in ground.streets.iter().filter(|street| street.level() == 0.0) {
            check_street(street, kind, &sound, &grid, report);
        }
    }
}

fn check_street(street: &Street<'_>, kind: &str, areas: &[&Area<'_>], grid: &Grid, report: &mut ValidationReport) {
    let mut touched: Vec<(usize, Polygon)> = Vec::new();
    for piece in roadway(street) {
        let Some(bounds) = Bounds::of(piece.iter().copied()) else { continue };
        grid.for_near(&bounds, |i| {
            if !separable(&piece, &areas[i].polygon.outer) {
                touched.push((i, Polygon::new(piece.clone(), Vec::new())));
            }
        });
    }
    touched.sort_by_key(|&(i, _)| i);
    for group in touched.chunk_by(|a, b| a.0 == b.0) {
        let area = areas[group[0].0];
        let pieces: Vec<Polygon> = group.iter().map(|(_, piece)| piece.clone()).collect();
        let common = intersection(std::slice::from_ref(&area.polygon), &pieces);
        let covered: f64 = common.iter().map(Polygon::area).sum();
        if covered > ALLOWED_M2 {
            let place = common.iter().max_by(|a, b| a.area().total_cmp(&b.area())).map(|piece| piece.pole(SLIVER_M));
            let message = format!("{kind} {} lies {covered:.2} m² in the roadway of street {}", area.id, street.id);
            report.add("V7", &[(kind, area.id), ("street", street.id)], place, message);
        }
    }
}

/// The right-of-way less a sliver all along, as convex pieces: a strip for each straight piece, a wedge at each bend,
/// square at the ends.
fn roadway(street: &Street<'_>) -> Vec<Vec<Point>> {
    let width = street.says.width.filter(|width| width.is_finite()).unwrap_or(0.0).clamp(0.0, 1000.0);
    let half = units((width / 2.0 - SLIVER_M).max(SLIVER_M)).saturating_sub(STRIP_ROUNDING).max(1);
    let reach = Reach { left: half, right: half, before: -STRIP_ROUNDING, after: -STRIP_ROUNDING };
    let strips = street.pieces().filter_map(|(a, b)| strip(a, b, reach)).map(Vec::from);
    let bends = street.line.windows(3).filter_map(|at| wedge(at[0], at[1], at[2], half, half));
    strips.chain(bends).collect()
}
