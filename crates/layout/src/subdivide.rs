//! Division of a region into parcels by recursive cuts (PM01 §3.4, with the candidates and scores of
//! algorithms: parcel subdivision, recursive).

mod chord;
mod holes;
mod map;
mod outline;
mod repair;

use crate::region::LEAST_DOUBLED_AREA;
use crate::{Block, Parcel, Region, Use, buildable};
use chord::{Chord, End, Line, chord};
use geom::Seed;
use geom::polygon::OrientedBox;
use map::{LandMap, NO_STREET};
use outline::{Measure, Outline};
use smallvec::SmallVec;

/// How stretched (see [`Measure::stretch`]) a piece may be made by a cut: a rectangle of 1 : 7.
const MOST_STRETCH: f64 = 2.3;

/// From this many times the wanted area on, a piece is cut even where that leaves badly shaped ones.
const ROUGH_FROM: f64 = 2.0;

/// A piece that stays larger than this many times the wanted area, for want of any cut, is open land and no parcel for
/// one building.
const MOST_OVERSIZE: f64 = 8.0;

/// Most reflex corners of a piece that cuts are tried at, the sharpest first.
const MOST_REFLEX: usize = 4;

/// What a recursive division aims at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecursiveSettings {
    /// Least area of a parcel, m²: no cut makes a smaller one.
    pub least_area: f64,
    /// Area up to which a piece is not cut any more, m².
    pub most_area: f64,
    /// Least length of frontage on one street that counts as access, metres.
    pub least_frontage: f64,
    /// How far cuts stray from the middle, as a share of the length they cut: 0 to 0.4.
    pub irregularity: f64,
    /// Chance.
    pub seed: Seed,
}

impl Default for RecursiveSettings {
    fn default() -> Self {
        Self { least_area: 150.0, most_area: 900.0, least_frontage: 8.0, irregularity: 0.1, seed: Seed(0) }
    }
}

/// Settings that make no sense.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// Not a number in its range.
    #[error("{name} is {value}; it must lie between {low} and {high} {unit}")]
    OutOfRange {
        /// Which setting.
        name: &'static str,
        /// What it was.
        value: f64,
        /// Least value.
        low: f64,
        /// Greatest value.
        high: f64,
        /// In what.
        unit: &'static str,
    },
    /// The least area is greater than the most.
    #[error("least_area ({least} m²) is greater than most_area ({most} m²)")]
    AreasCrossed {
        /// Least area, m².
        least: f64,
        /// Most area, m².
        most: f64,
    },
}

impl RecursiveSettings {
    /// Whether the settings make sense.
    pub fn check(&self) -> Result<(), SettingsError> {
        let within = |name, value: f64, low, high, unit| {
            let outside = SettingsError::OutOfRange { name, value, low, high, unit };
            if value >= low && value <= high { Ok(()) } else { Err(outside) }
        };
        within("least_area", self.least_area, 0.0, 1e9, "m²")?;
        within("most_area", self.most_area, 4.0, 1e9, "m²")?;
        within("least_frontage", self.least_frontage, 0.0, 1e4, "m")?;
        within("irregularity", self.irregularity, 0.0, 0.4, "of the length cut")?;
        if self.least_area > self.most_area {
            return Err(SettingsError::AreasCrossed { least: self.least_area, most: self.most_area });
        }
        Ok(())
    }

    fn has_access(&self, measure: &Measure) -> bool {
        let longest = measure.longest_frontage();
        longest > 0.0 && longest >= self.least_frontage
    }

    /// Whether a piece can be built on: large and wide enough, and on a street.
    fn is_sound(&self, measure: &Measure) -> bool {
        measure.area >= self.least_area && measure.width() * 2.0 >= self.least_frontage && self.has_access(measure)
    }
}

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

/// Divides a region: cuts pieces in two while they are larger than `most_area` and a good cut exists; then joins pieces
/// that are too small, too thin or without access to a neighbour, or else leaves them open.
pub fn recursive(region: &Region, settings: &RecursiveSettings) -> Result<Division, SettingsError> {
    settings.check()?;
    if region.polygon.outer.len() < 3 {
        return Ok(Division::default());
    }
    let mut map = LandMap::new(region);
    holes::cut_holes(&mut map);
    divide(&mut map, settings);
    let measures = repair::Lots::new(&mut map, settings).repair();
    let parcel = |face| parcel(&map, region, settings, face, &measures[face as usize]);
    Ok(Division { parcels: map.live_faces().map(parcel).collect(), trimmed: map.trimmed })
}

fn parcel(map: &LandMap, region: &Region, settings: &RecursiveSettings, face: u32, measure: &Measure) -> Parcel {
    let mut polygon = map.polygon(face);
    let least = polygon.outer.iter().enumerate().min_by_key(|(_, p)| **p).map_or(0, |(i, _)| i);
    polygon.outer.rotate_left(least);
    let mut access: Vec<_> =
        measure.frontage.iter().map(|&(street, length)| (map.streets[usize::from(street)], length)).collect();
    access.sort_by_key(|&(street, _)| street);
    let is_oversize = measure.area > MOST_OVERSIZE * settings.most_area;
    let built = settings.is_sound(measure) && polygon.holes.is_empty() && !is_oversize;
    let usage = if built { Use::Built } else { Use::Open };
    Parcel { id: map.faces[face as usize].path, block: region.block, polygon, access, usage }
}

/// Cuts all faces until none asks for more.
fn divide(map: &mut LandMap, settings: &RecursiveSettings) {
    let mut outline = Outline::default();
    let mut open: Vec<u32> = map.live_faces().collect();
    open.reverse();
    while let Some(face) = open.pop() {
        if map.faces[face as usize].rims.len() > 1 {
            continue;
        }
        outline.load(map, face);
        let whole = Measure::of_face(map, face);
        if whole.area <= settings.most_area {
            continue;
        }
        let seed = settings.seed.of(map.faces[face as usize].path);
        if let Some(best) = best_chord(map, &outline, &whole, settings, seed) {
            open.push(cut(map, &outline, &best));
            open.push(face);
        }
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

/// The chord with the least cost; the first of equals.
fn best_chord(
    map: &LandMap,
    outline: &Outline,
    whole: &Measure,
    settings: &RecursiveSettings,
    seed: Seed,
) -> Option<Chord> {
    let best_of = |lines: &[Line], most_stretch: f64| {
        let mut best: Option<(f64, Chord)> = None;
        for &line in lines {
            let Some(chord) = chord(map, outline, line) else { continue };
            let Some(cost) = cost(outline, whole, &chord, most_stretch, settings) else { continue };
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, chord));
            }
        }
        best.map(|(_, chord)| chord)
    };
    let stray = |ordinal: u64| settings.irregularity * seed.range(ordinal, -1.0, 1.0);
    let around = outline.smallest_box();
    let (lines, spare) = (lines(outline, &around, stray), spare_lines(&around));
    let most_stretch = MOST_STRETCH.max(whole.stretch());
    let shapely = best_of(&lines, most_stretch).or_else(|| best_of(&spare, most_stretch));
    // A large crooked piece may have no cut into well-shaped ones; what a rough cut leaves is cut on.
    let is_large = whole.area > ROUGH_FROM * settings.most_area;
    shapely.or_else(|| {
        let rough = || best_of(&lines, f64::INFINITY).or_else(|| best_of(&spare, f64::INFINITY));
        is_large.then(rough).flatten()
    })
}

/// Lines worth trying: across the long and the short side of the smallest rectangle, straight in from the longest
/// frontage, and on from reflex corners.
fn lines(outline: &Outline, around: &OrientedBox, stray: impl Fn(u64) -> f64) -> SmallVec<[Line; 12]> {
    let mut lines: SmallVec<[Line; 12]> = SmallVec::new();
    lines.push(box_line(around, false, stray(0)));
    lines.push(box_line(around, true, stray(1)));
    lines.extend(frontage_line(outline, stray(2)));
    for i in sharpest_reflex(outline) {
        let (before, after) = outline.arms(i);
        lines.extend([Line::From(i, before.normalize_or_zero()), Line::From(i, -after.normalize_or_zero())]);
    }
    lines
}

/// What to try where nothing else goes: off the middle, either way.
fn spare_lines(around: &OrientedBox) -> [Line; 8] {
    let shifts = [
        (false, -0.15),
        (false, 0.15),
        (true, -0.15),
        (true, 0.15),
        (false, -0.3),
        (false, 0.3),
        (true, -0.3),
        (true, 0.3),
    ];
    shifts.map(|(along, off)| box_line(around, along, off))
}

/// A line square to the long side of the smallest rectangle around the outline (or `along` it), `off` the middle by a
/// share of the extent.
fn box_line(around: &OrientedBox, along: bool, off: f64) -> Line {
    if along {
        Line::Through(around.centre + around.axis.perp() * (2.0 * around.half.y * off), around.axis)
    } else {
        Line::Through(around.centre + around.axis * (2.0 * around.half.x * off), around.axis.perp())
    }
}

/// The line straight in from the middle of the longest edge that lies on a street.
fn frontage_line(outline: &Outline, off: f64) -> Option<Line> {
    let edge = |i: usize| outline.arms(i).1;
    let fronting = (0..outline.len()).filter(|&i| outline.streets[i] != NO_STREET);
    let longest =
        fronting.max_by(|&i, &j| edge(i).length_squared().total_cmp(&edge(j).length_squared()).then(j.cmp(&i)))?;
    let (along, inwards) = (edge(longest), edge(longest).perp().try_normalize()?);
    // A metre in, so that the place lies on the inner stretch and not on its end.
    Some(Line::Through(outline.places[longest] + along * (0.5 + off) + inwards, inwards))
}

/// The corners that turn right most, sharpest first.
fn sharpest_reflex(outline: &Outline) -> SmallVec<[usize; MOST_REFLEX]> {
    let turn = |&i: &usize| {
        let (before, after) = outline.arms(i);
        before.normalize_or_zero().dot(after.normalize_or_zero())
    };
    let mut reflex: SmallVec<[usize; 16]> = (0..outline.len()).filter(|&i| outline.is_reflex(i)).collect();
    reflex.sort_by(|i, j| turn(i).total_cmp(&turn(j)).then(i.cmp(j)));
    reflex.into_iter().take(MOST_REFLEX).collect()
}

/// How bad a cut is: unequal halves, stretched pieces, lost access; better where it ends at a reflex corner. `None`
/// for a cut that must not be.
fn cost(
    outline: &Outline,
    whole: &Measure,
    chord: &Chord,
    most_stretch: f64,
    settings: &RecursiveSettings,
) -> Option<f64> {
    let place = |end: &End| (end.edge, outline.place(end.at));
    let (from, to) = (place(&chord.from), place(&chord.to));
    let pieces = [outline.measure_part(to, from), outline.measure_part(from, to)];
    let least_area = settings.least_area.max(least_piece());
    if pieces.iter().any(|piece| piece.area < least_area || piece.stretch() > most_stretch) {
        return None;
    }
    let landlocked = pieces.iter().filter(|piece| !settings.has_access(piece)).count();
    let lost = if settings.has_access(whole) { landlocked } else { 0 };
    if lost > 0 && whole.area <= 2.0 * settings.most_area {
        return None;
    }
    let imbalance = (pieces[0].area - pieces[1].area).abs() / whole.area;
    let stretch: f64 = pieces.iter().map(|piece| piece.stretch() - 1.0).sum();
    let resolved = [&chord.from, &chord.to].iter().filter(|end| end.corner && outline.is_reflex(end.edge)).count();
    Some(imbalance + 0.5 * stretch + lost as f64 - 0.4 * resolved as f64)
}

/// The least area of a piece in m², just above what is kept as land at all.
fn least_piece() -> f64 {
    1.001 * (LEAST_DOUBLED_AREA / 2) as f64 / (1u64 << 20) as f64
}

#[cfg(test)]
mod tests;
