//! What the cities that come with Plat promise about their streets, measured on what is built.

use city::measure::{Figure, Maps, Window, measure};
use city::{City, Until};
use geom::{Angle, Raster, Vec2};
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::{Class, Classes};
use suite::{build_with, shipped};

/// A shipped city up to its streets, and its maps.
struct Place {
    name: &'static str,
    city: Arc<City>,
    site: Arc<city::Site>,
}

impl Place {
    fn of(name: &'static str) -> Self {
        let built = build_with(&shipped(name), 2, Until::Streets, |_| {});
        assert!(!built.report.has_faults(), "{name}: {:?}", built.report.faults);
        let sources = city::load(&shipped(name), None).and_then(|loaded| loaded.read());
        let site = sources.unwrap_or_else(|error| panic!("{error}")).site.clone();
        Self { name, city: built.city, site }
    }

    fn map(&self, name: &str) -> Arc<Raster> {
        self.site.map(name).expect("a map of the site").clone()
    }

    /// A figure as `plat stats` tells it.
    fn figure(&self, name: &str, mask: Option<&str>, window: Option<[f64; 4]>) -> f64 {
        let mut bytes = Vec::new();
        city::export::geojson::write_layout(&self.city, &mut bytes).expect("writing to memory does not fail");
        let folder = shipped(self.name);
        let file = city::export::layout_file::parse_layout(&bytes, &folder).expect("our own layout is readable");
        let maps = Maps::read(&folder.join("maps"), mask).expect("shipped maps are readable");
        match measure(&file, &maps, window.map(Window)).expect("our own layout").get(name) {
            Some(Figure::Number(number)) => number,
            other => panic!("{}: {name} is {other:?}", self.name),
        }
    }

    /// The straight pieces of streets of a class in metres, with their level.
    fn pieces(&self, class: Option<Class>) -> Vec<(Vec2, Vec2, i8)> {
        let runs = self.city.runs.iter().filter(|run| class.is_none_or(|class| run.class == class));
        let piece = |pair: &[streets::NodeKey]| [pair[0], pair[1]].map(|node| self.city.graph.at(node).metres());
        let pieces = runs.flat_map(|run| run.nodes.windows(2).map(|pair| (piece(pair), run.level)));
        pieces.map(|([a, b], level)| (a, b, level)).collect()
    }

    /// Streets of a class cut to samples at most `step` metres long: place, heading, metres.
    fn samples(&self, class: Class, step: f64) -> Vec<(Vec2, Angle, f64)> {
        let mut samples = Vec::new();
        for (a, b, _) in self.pieces(Some(class)).into_iter().filter(|(_, _, level)| *level == 0) {
            let (length, heading) = ((b - a).length(), Angle::of(b - a));
            let count = (length / step).ceil().max(1.0) as u32;
            let at = |k: u32| a.lerp(b, (f64::from(k) + 0.5) / f64::from(count));
            samples.extend((0..count).map(|k| (at(k), heading, length / f64::from(count))));
        }
        samples
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Degrees from the nearest of four headings at right angles, from 0 to 45.
fn off_cross(heading: Angle, of: Angle) -> f64 {
    (((heading - of).to_degrees() + 45.0).rem_euclid(90.0) - 45.0).abs()
}

/// The panels of the sheet of patterns: west, south, east, north.
const ORGANIC: [f64; 4] = [120.0, 2120.0, 1880.0, 3880.0];
const GRID: [f64; 4] = [2120.0, 2120.0, 3880.0, 3880.0];
const RADIAL: [f64; 4] = [4120.0, 2120.0, 5880.0, 3880.0];
const TO_GRID: [[f64; 4]; 2] = [[2120.0, 120.0, 3880.0, 1880.0], [4120.0, 120.0, 5880.0, 1880.0]];

fn is_in([west, south, east, north]: [f64; 4], at: Vec2) -> bool {
    west < at.x && at.x < east && south < at.y && at.y < north
}

#[test]
fn the_sheet_of_patterns_shows_each_as_it_is() {
    let place = Place::of("patterns");
    let order = |panel| place.figure("order", Some("panels"), Some(panel));
    assert!(order(GRID) >= 0.95 && order(ORGANIC) <= 0.2, "{} {}", order(GRID), order(ORGANIC));
    let centre = Vec2::new(5000.0, 3000.0);
    let round = place.samples(Classes::MINOR, 1000.0).into_iter().filter(|(at, _, _)| is_in(RADIAL, *at));
    let off: Vec<f64> = round.map(|(at, heading, _)| off_cross(heading, Angle::of(at - centre))).collect();
    assert!(off.len() > 500 && median(off) < 5.0);
}

/// The mean heading of streets around places 50 m apart, where two patterns have weight: a field with four headings.
fn field(samples: &[(Vec2, Angle, f64)], weight: &Raster, panel: [f64; 4]) -> BTreeMap<(i32, i32), Angle> {
    let mut field = BTreeMap::new();
    let of_panel: Vec<_> = samples.iter().filter(|(at, _, _)| is_in(panel, *at)).collect();
    let cells = |low: f64, high: f64| (low / 50.0) as i32 + 2..(high / 50.0) as i32 - 1;
    for (i, j) in cells(panel[0], panel[2]).flat_map(|i| cells(panel[1], panel[3]).map(move |j| (i, j))) {
        let middle = Vec2::new(f64::from(i), f64::from(j)) * 50.0;
        if !(0.02..0.98).contains(&weight.bilinear(middle)) {
            continue;
        }
        let near = of_panel.iter().filter(|(at, _, _)| (*at - middle).length() < 75.0);
        let sum: Vec2 = near.map(|(_, heading, metres)| (*heading * 4.0).unit() * *metres).sum();
        field.insert((i, j), Angle::of(sum) * 0.25);
    }
    field
}

#[test]
fn patterns_blend_into_each_other() {
    let place = Place::of("patterns");
    let (samples, weight) = (place.samples(Classes::MINOR, 10.0), place.map("grid"));
    // An organic town becomes a grid without a seam. Rings cannot everywhere: round their centre the four headings turn
    // once, in the grid not at all, so between the two there must be places that they turn about.
    for (panel, least) in TO_GRID.into_iter().zip([1.0, 0.96]) {
        let field = field(&samples, &weight, panel);
        let neighbours = field.iter().flat_map(|(&(i, j), &here)| [(i + 1, j), (i, j + 1)].map(|next| (here, next)));
        let turns: Vec<f64> =
            neighbours.filter_map(|(here, next)| field.get(&next).map(|&there| off_cross(here, there))).collect();
        let gentle = turns.iter().filter(|turn| **turn < 15.0).count() as f64 / turns.len() as f64;
        assert!(turns.len() > 500 && gentle >= least, "{gentle} of {} turn by less than 15° in 50 m", turns.len());
    }
}

#[test]
fn manhattan_has_bridges_from_shore_to_shore() {
    let place = Place::of("manhattan");
    let land = place.map("land");
    let bridges: Vec<_> = place.city.runs.iter().filter(|run| run.level > 0).collect();
    assert!(bridges.len() >= 4, "{} bridges", bridges.len());
    for bridge in bridges {
        let ends = [bridge.nodes.first(), bridge.nodes.last()].map(|node| place.city.graph.at(*node.expect("an end")));
        let [from, to] = ends.map(|end| end.metres());
        assert!(land.mask(from) && land.mask(to), "a bridge from {from} to {to} ends in the water");
        let is_wet = |k: u32| !land.mask(from.lerp(to, f64::from(k) / 100.0));
        assert!((1..100).any(is_wet), "a bridge from {from} to {to} over land alone");
    }
}

/// Where the water lies, seen from a place: the sum of the ways to all of it within `reach` metres, looked for every
/// 10 m; nothing when there is none.
fn water_from(land: &Raster, at: Vec2, reach: f64) -> Option<Vec2> {
    let steps = (reach / 10.0) as i32;
    let ways =
        (-steps..=steps).flat_map(|i| (-steps..=steps).map(move |j| Vec2::new(f64::from(i), f64::from(j)) * 10.0));
    let wet: Vec<Vec2> = ways.filter(|way| way.length() <= reach && !land.mask(at + *way)).collect();
    (!wet.is_empty()).then(|| wet.into_iter().sum())
}

/// The length of highway within 150 m of water, and the share of it that runs within 20° of the shore.
fn along_the_shore(name: &'static str) -> (f64, f64) {
    let place = Place::of(name);
    let land = place.map("land");
    let (mut near, mut along) = (0.0, 0.0);
    for (at, heading, metres) in place.samples(Classes::HIGHWAY, 20.0) {
        let Some(water) = water_from(&land, at, 150.0) else { continue };
        near += metres;
        let across = heading.unit().dot(Angle::of(water).unit()).abs();
        along += if across < Angle::degrees(20.0).sin() { metres } else { 0.0 };
    }
    (near, along / near)
}

#[test]
fn highways_follow_the_shores_of_cities() {
    for (name, least) in [("riviera_bay", 20_000.0), ("manhattan", 20_000.0)] {
        let (near, share) = along_the_shore(name);
        assert!(near > least && share >= 0.6, "{name}: {share} of {near} m near the water");
    }
}

#[test]
fn andorra_keeps_to_its_slopes() {
    let place = Place::of("andorra");
    let (order, contour) = (place.figure("order", None, None), place.figure("contour_share", None, None));
    assert!(order <= 0.2 && contour >= 0.6, "order {order}, {contour} along the contours");
    let ground = place.map("elevation");
    for (a, b, _) in place.pieces(None).into_iter().filter(|(_, _, level)| *level == 0) {
        let (rise, length) = ((ground.bilinear(b) - ground.bilinear(a)).abs(), (b - a).length());
        assert!(rise <= 0.14 * length + 0.02, "{rise} m over {length} m at {a}");
    }
}
