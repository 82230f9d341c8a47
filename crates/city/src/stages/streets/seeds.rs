//! Where highways and majors start.

use super::Context;
use geom::{Point, Vec2};
use script::StreetPlan;
use streets::growth::{Fields, Goal};
use streets::{Class, Classes};

/// The places to start at, in their order: those that the plan names; else for highways the peaks of density, at least
/// `reseed` metres apart, and for majors the densest place, then an even spread over the site. All are legal and wanted.
pub(super) fn of(
    context: &Context,
    class: Class,
    plan: &StreetPlan,
    fields: &Fields,
    goal: &Goal,
    reseed: f64,
) -> Vec<Point> {
    if !plan.seeds.is_empty() {
        return plan.seeds.iter().copied().map(Point::from_metres).collect();
    }
    let size = context.sources.site.bounds.size();
    let places = spread(size, (reseed / 3.0).min(size.max_element() / 8.0).max(1.0));
    let wanted: Vec<Vec2> = places.filter(|&place| fields.is_legal(place) && goal.is_met(place)).collect();
    if class == Classes::HIGHWAY { peaks(&wanted, size, fields, reseed) } else { densest_first(wanted, size, goal) }
}

/// The middles of the cells of a grid over the site.
fn spread(size: Vec2, step: f64) -> impl Iterator<Item = Vec2> {
    let (columns, rows) = ((size.x / step).ceil() as i64, (size.y / step).ceil() as i64);
    let place = move |row: i64, column: i64| Vec2::new((column as f64 + 0.5) * step, (row as f64 + 0.5) * step);
    (0..rows).flat_map(move |row| (0..columns).map(move |column| place(row, column)))
}

/// Densest first; equal ones from the middle of the site outwards, then by place.
fn densest_first(places: Vec<Vec2>, size: Vec2, goal: &Goal) -> Vec<Point> {
    let middle = Point::from_metres(size / 2.0);
    let mut places: Vec<_> =
        places.into_iter().map(|place| (goal.density.at(place), Point::from_metres(place))).collect();
    places.sort_by(|(a, p), (b, q)| {
        let from_middle = |at: &Point| at.distance_squared(middle);
        b.total_cmp(a).then_with(|| from_middle(p).cmp(&from_middle(q))).then_with(|| p.cmp(q))
    });
    places.into_iter().map(|(_, place)| place).collect()
}

/// Places denser than all others within `apart` metres. They are ranked by density and nearness to the middle of the
/// site (SCH10 §4.2.1, where the formula favours the rim although the text wants the middle).
fn peaks(places: &[Vec2], size: Vec2, fields: &Fields, apart: f64) -> Vec<Point> {
    let middle = size / 2.0;
    let rank = |place: Vec2| {
        let nearness = 1.0 - (place - middle).length() / middle.length();
        fields.density.at(place).max(0.0) * nearness
    };
    let mut ranked: Vec<_> = places.iter().map(|&place| (rank(place), Point::from_metres(place), place)).collect();
    ranked.sort_by(|(a, p, _), (b, q, _)| b.total_cmp(a).then_with(|| p.cmp(q)));
    let mut peaks: Vec<(Point, Vec2)> = Vec::new();
    for (i, &(_, at, place)) in ranked.iter().enumerate() {
        let is_near = |other: Vec2| (other - place).length() < apart;
        // Ranked higher and near: this place lies on the flank of another.
        if !ranked[..i].iter().any(|&(.., other)| is_near(other)) {
            peaks.push((at, place));
        }
    }
    peaks.into_iter().map(|(at, _)| at).collect()
}
