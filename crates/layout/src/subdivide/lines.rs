//! Lines worth cutting along.

use super::chord::Line;
use super::map::NO_STREET;
use super::outline::Outline;
use super::settings::Squared;
use crate::side::longest_run;
use geom::polygon::OrientedBox;
use smallvec::SmallVec;

/// Most reflex corners of a piece that cuts are tried at, the sharpest first.
const MOST_REFLEX: usize = 4;

/// A few lines in the order they are tried.
pub(super) type Lines = SmallVec<[Line; 12]>;

/// Lines in the manner asked for, and on from reflex corners. `stray` shifts a line off the middle by a share of the
/// length, drawn for a number.
pub(super) fn lines(
    outline: &Outline,
    around: &OrientedBox,
    squared: Squared,
    stray: impl Fn(u64) -> f64 + Copy,
) -> Lines {
    let mut lines = match squared {
        Squared::Best => best_lines(outline, around, stray),
        Squared::Side => side_lines(outline, |_| true, stray),
        Squared::Street => {
            let on_street = side_lines(outline, |edge| outline.streets[edge] != NO_STREET, stray);
            if on_street.is_empty() { side_lines(outline, |_| true, stray) } else { on_street }
        }
    };
    for i in sharpest_reflex(outline) {
        let (before, after) = outline.arms(i);
        lines.extend([Line::From(i, before.normalize_or_zero()), Line::From(i, -after.normalize_or_zero())]);
    }
    lines
}

/// Across the long and the short side of the smallest rectangle, straight in from the longest frontage.
fn best_lines(outline: &Outline, around: &OrientedBox, stray: impl Fn(u64) -> f64) -> Lines {
    let mut lines = Lines::new();
    lines.push(box_line(around, false, stray(0)));
    lines.push(box_line(around, true, stray(1)));
    lines.extend(frontage_line(outline, stray(2)));
    lines
}

/// Square to the longest side through its middle region, and along it through the middle of the land behind.
fn side_lines(outline: &Outline, counts: impl Fn(usize) -> bool, stray: impl Fn(u64) -> f64) -> Lines {
    let mut lines = Lines::new();
    let Some((start, end)) = longest_run(&outline.places, counts) else { return lines };
    let Some(along) = (end - start).try_normalize() else { return lines };
    let inwards = along.perp();
    // A metre in, so that the place lies on the inner stretch and not on its end.
    lines.push(Line::Through(start + (end - start) * (0.5 + stray(0)) + inwards, inwards));
    let depth = outline.places.iter().map(|place| inwards.dot(*place - start)).fold(0.0, f64::max);
    lines.push(Line::Through((start + end) / 2.0 + inwards * (depth * (0.5 + stray(1))), along));
    lines
}

/// What to try where nothing else goes: off the middle, either way.
pub(super) fn spare_lines(around: &OrientedBox) -> [Line; 8] {
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
