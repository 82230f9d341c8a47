//! Division of a region into parcels by recursive cuts (PM01 §4.1, SCH10 §4.2.6, with the candidates and scores of
//! algorithms: parcel subdivision, recursive).

mod chord;
mod holes;
mod lines;
mod map;
mod outline;
mod repair;
mod settings;
mod steps;

pub use settings::{Inner, RecursiveSettings, SettingsError, Squared};
pub use steps::{DivisionStep, Looked, WhyOpen};

use crate::region::LEAST_DOUBLED_AREA;
use crate::{Block, Parcel, Region, Use, buildable};
use chord::{Chord, End, Line, is_certified, placed};
use geom::polygon::{convex_hull, ring_doubled_area};
use geom::{Point, Polygon, Seed};
use lines::{lines, spare_lines};
use map::LandMap;
use outline::{Measure, Outline};

/// How stretched (see [`Measure::stretch`]) a piece may be made by a cut: a rectangle of 1 : 7.
const MOST_STRETCH: f64 = 2.3;

/// From this many times the wanted area on, a piece is cut even where that leaves badly shaped ones.
const ROUGH_FROM: f64 = 2.0;

/// A piece that stays larger than this many times the wanted area, for want of any cut, is open land and no parcel for
/// one building.
const MOST_OVERSIZE: f64 = 8.0;

/// What a region or a block became.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Division {
    /// The parcels; they cover the region exactly but for `trimmed`.
    pub parcels: Vec<Parcel>,
    /// Twice the area between the region's rim and the parcels, in LSB²: where a cut ends on the rim its corner is
    /// rounded inwards, by less than 1.5 LSB.
    pub trimmed: i128,
}

/// Divides a block: what [`buildable`] leaves of it, by [`recursive`]. What neither parcels nor rights-of-way cover,
/// less than a square metre a piece, is in `trimmed`.
pub fn subdivide(block: &Block, settings: &RecursiveSettings) -> Result<Division, SettingsError> {
    settings.check()?;
    let land = buildable(block);
    let mut whole = Division { parcels: Vec::new(), trimmed: land.dropped };
    for region in &land.regions {
        let part = recursive(region, settings)?;
        whole.parcels.extend(part.parcels);
        whole.trimmed += part.trimmed;
    }
    Ok(whole)
}

/// Divides a region: cuts pieces in two while they are larger than wanted (or too concave) and a good cut exists; then
/// joins pieces that are too small, too thin or without access to a neighbour, or else leaves them open.
pub fn recursive(region: &Region, settings: &RecursiveSettings) -> Result<Division, SettingsError> {
    recursive_telling(region, settings, &mut |_| {})
}

/// The same, telling what it does step by step.
pub fn recursive_telling(
    region: &Region,
    settings: &RecursiveSettings,
    tell: &mut dyn FnMut(DivisionStep),
) -> Result<Division, SettingsError> {
    settings.check()?;
    if region.polygon.outer.len() < 3 {
        return Ok(Division::default());
    }
    let mut map = LandMap::new(region);
    holes::cut_holes(&mut map);
    divide(&mut map, settings, tell);
    let measures = repair::Lots::new(&mut map, settings, tell).repair();
    let mut parcel = |face| parcel(&map, region, settings, face, &measures[face as usize], tell);
    Ok(Division { parcels: map.live_faces().map(&mut parcel).collect(), trimmed: map.trimmed })
}

fn parcel(
    map: &LandMap,
    region: &Region,
    settings: &RecursiveSettings,
    face: u32,
    measure: &Measure,
    tell: &mut dyn FnMut(DivisionStep),
) -> Parcel {
    let id = map.faces[face as usize].path;
    let mut polygon = map.polygon(face);
    let least = polygon.outer.iter().enumerate().min_by_key(|(_, p)| **p).map_or(0, |(i, _)| i);
    let mut fronted: Vec<_> = measure.frontage.to_vec();
    fronted.sort_by_key(|&(street, _)| street);
    let mut sides = map.sides(face, |street| fronted.iter().position(|&(known, _)| known == street));
    polygon.outer.rotate_left(least);
    sides.rotate_left(least);
    let why_open = why_open(settings, measure, &polygon);
    if let Some(why) = why_open {
        tell(DivisionStep::Open { piece: id, why });
    }
    let usage = if why_open.is_none() { Use::Built } else { Use::Open };
    let access = fronted.into_iter().map(|(street, length)| (map.streets[usize::from(street)], length)).collect();
    Parcel { id, block: region.block, polygon, access, sides, usage, tags: Vec::new() }
}

/// Why nothing may be built on a piece; none where something may.
fn why_open(settings: &RecursiveSettings, measure: &Measure, polygon: &Polygon) -> Option<WhyOpen> {
    let is_inner = measure.frontage.is_empty() && settings.inner == Inner::Built;
    let reasons = [
        (measure.area < settings.least_area, WhyOpen::Small),
        (!settings.is_roomy(measure), WhyOpen::Thin),
        (!settings.has_access(measure) && !is_inner, WhyOpen::Landlocked),
        (!polygon.holes.is_empty(), WhyOpen::Holed),
        (measure.area > MOST_OVERSIZE * settings.most_area, WhyOpen::Oversized),
    ];
    let first = reasons.into_iter().find(|(is_so, _)| *is_so).map(|(_, why)| why);
    first.or_else(|| (!is_convex_enough(settings, measure.area, &polygon.outer)).then_some(WhyOpen::Concave))
}

/// Whether a ring of this area in m² fills enough of its convex hull.
fn is_convex_enough(settings: &RecursiveSettings, area: f64, ring: &[Point]) -> bool {
    settings.least_convexity <= 0.0 || convexity(area, ring) >= settings.least_convexity
}

/// The share of their convex hull that corners around `area` m² fill.
fn convexity(area: f64, corners: &[Point]) -> f64 {
    let hull = ring_doubled_area(&convex_hull(corners)) as f64;
    2.0 * area * Point::UNITS_PER_METRE * Point::UNITS_PER_METRE / hull
}

/// Cuts all faces until none asks for more.
fn divide(map: &mut LandMap, settings: &RecursiveSettings, tell: &mut dyn FnMut(DivisionStep)) {
    let mut outline = Outline::default();
    let mut open: Vec<u32> = map.live_faces().collect();
    open.reverse();
    while let Some(face) = open.pop() {
        if map.faces[face as usize].rims.len() > 1 {
            continue;
        }
        let whole = Measure::of_face(map, face);
        let piece = map.faces[face as usize].path;
        let seed = settings.seed.of(piece);
        let wanted = settings.wanted_area(seed);
        let mut look = |outcome| tell(DivisionStep::Look { piece, area: whole.area, wanted, outcome });
        let is_large = whole.area > wanted;
        if !is_large && settings.least_convexity <= 0.0 {
            look(Looked::Kept);
            continue;
        }
        outline.load(map, face);
        if !is_large && is_convex_enough(settings, whole.area, &outline.points) {
            look(Looked::Kept);
            continue;
        }
        let Some(best) = best_chord(map, &outline, &whole, settings, seed) else {
            look(Looked::NoCut);
            continue;
        };
        let other = cut(map, &outline, &best);
        let parts = [face, other].map(|face| map.faces[face as usize].path);
        look(Looked::Cut { ends: [best.from.at, best.to.at], parts });
        open.push(other);
        open.push(face);
    }
}

/// Cuts a face along a chord; the new face lies right of it.
fn cut(map: &mut LandMap, outline: &Outline, chord: &Chord) -> u32 {
    let mut half = |end: &End| {
        let half = outline.halves[end.edge];
        if end.corner { half } else { map.insert_corner(half, end.at) }
    };
    let (from, to) = (half(&chord.from), half(&chord.to));
    map.split(from, to)
}

/// What is asked of a cut.
#[derive(Clone, Copy)]
struct Demands {
    /// See [`Measure::stretch`].
    most_stretch: f64,
    /// Whether parcels that it leaves must fill enough of their convex hulls.
    convex: bool,
    /// Whether it must not take access from a piece of about the wanted size.
    access: bool,
}

/// The chord with the least cost; the first of equals. Demands are lowered only where nothing meets them.
fn best_chord(
    map: &LandMap,
    outline: &Outline,
    whole: &Measure,
    settings: &RecursiveSettings,
    seed: Seed,
) -> Option<Chord> {
    let around = outline.smallest_box();
    let stray = |ordinal: u64| settings.irregularity * seed.range(ordinal, -1.0, 1.0);
    let (lines, spare) = (lines(outline, &around, settings.squared, stray), spare_lines(&around));
    let best = |demands: Demands| {
        let best_of = |lines: &[Line]| best_of(map, outline, whole, settings, lines, demands);
        best_of(&lines).or_else(|| best_of(&spare))
    };
    let strict = Demands {
        most_stretch: MOST_STRETCH.max(whole.stretch()),
        convex: settings.least_convexity > 0.0,
        access: settings.forces_access(seed),
    };
    let lower = strict.convex && whole.area > settings.wanted_area(seed);
    // A large crooked piece may have no cut into well-shaped ones; what a rough cut leaves is cut on.
    let is_large = whole.area > ROUGH_FROM * settings.most_area;
    let shapely = || best(strict).or_else(|| lower.then(|| best(Demands { convex: false, ..strict })).flatten());
    let rough = || best(Demands { most_stretch: f64::INFINITY, convex: false, ..strict });
    shapely().or_else(|| is_large.then(rough).flatten())
}

fn best_of(
    map: &LandMap,
    outline: &Outline,
    whole: &Measure,
    settings: &RecursiveSettings,
    lines: &[Line],
    demands: Demands,
) -> Option<Chord> {
    let mut best: Option<(f64, Chord)> = None;
    for &line in lines {
        let Some(chord) = placed(map, outline, line) else { continue };
        let Some(cost) = cost(outline, whole, &chord, demands, settings) else { continue };
        if best.is_none_or(|(least, _)| cost < least) && is_certified(map, outline, &chord) {
            best = Some((cost, chord));
        }
    }
    best.map(|(_, chord)| chord)
}

/// How bad a cut is: unequal halves, stretched pieces, lost access; better where it ends at a reflex corner. `None`
/// for a cut that must not be.
fn cost(
    outline: &Outline,
    whole: &Measure,
    chord: &Chord,
    demands: Demands,
    settings: &RecursiveSettings,
) -> Option<f64> {
    let place = |end: &End| (end.edge, outline.place(end.at));
    let (from, to) = (place(&chord.from), place(&chord.to));
    let pieces = [outline.measure_part(to, from), outline.measure_part(from, to)];
    let least_area = settings.least_area.max(least_piece());
    if pieces.iter().any(|piece| piece.area < least_area || piece.stretch() > demands.most_stretch) {
        return None;
    }
    let landlocked = pieces.iter().filter(|piece| !settings.has_access(piece)).count();
    let lost = if settings.has_access(whole) { landlocked } else { 0 };
    if lost > 0 && demands.access && whole.area <= 2.0 * settings.most_area {
        return None;
    }
    let ends = [(chord.to, chord.from), (chord.from, chord.to)];
    let is_concave = |(piece, (first, last)): (&Measure, &(End, End))| {
        piece.area <= settings.most_area
            && !is_convex_enough(settings, piece.area, &outline.corners_of_part(first, last))
    };
    if demands.convex && pieces.iter().zip(&ends).any(is_concave) {
        return None;
    }
    let imbalance = (pieces[0].area - pieces[1].area).abs() / whole.area;
    let stretch: f64 = pieces.iter().map(|piece| piece.stretch() - 1.0).sum();
    let resolved = [&chord.from, &chord.to].iter().filter(|end| end.corner && outline.is_reflex(end.edge)).count();
    let access = lost as f64 * settings.forced_access;
    Some(imbalance + 0.5 * stretch + access - 0.4 * resolved as f64)
}

/// The least area of a piece in m², just above what is kept as land at all.
fn least_piece() -> f64 {
    1.001 * (LEAST_DOUBLED_AREA / 2) as f64 / (1u64 << 20) as f64
}

#[cfg(test)]
mod tests;
