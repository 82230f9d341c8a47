//! V1 and V2: streets meet at shared crossings only, and crossings keep their distance. Exact.

use super::ValidationReport;
use super::ground::{Ground, Street};
use super::index::Grid;
use geom::predicates::{cut, meets, on_segment, within};
use geom::{Bounds, Point, tolerance};

/// One straight piece of a street.
struct Piece {
    street: usize,
    /// Its place along the street.
    index: usize,
    a: Point,
    b: Point,
}

/// Checks V1 and V2.
pub fn check(ground: &Ground<'_>, report: &mut ValidationReport) {
    check_ends(ground, report);
    let pieces = pieces(ground);
    let grid = Grid::new(pieces.iter().map(|piece| Bounds::between(piece.a, piece.b)).collect());
    check_meetings(ground, &pieces, &grid, report);
    check_separation(ground, &pieces, &grid, report);
    check_crossings_apart(ground, report);
}

fn pieces(ground: &Ground<'_>) -> Vec<Piece> {
    let of_street = |(street, line): (usize, &Street<'_>)| {
        let pieces = line.pieces().enumerate().map(move |(index, (a, b))| Piece { street, index, a, b });
        pieces.collect::<Vec<_>>()
    };
    ground.streets.iter().enumerate().flat_map(of_street).collect()
}

/// Each end of a street lies on the crossing that it names, and no piece is shorter than the separation.
fn check_ends(ground: &Ground<'_>, report: &mut ValidationReport) {
    for street in &ground.streets {
        let who = [("street", street.id)];
        let ends = [street.line[0], street.line[street.line.len() - 1]];
        for ((end, name), at) in ["from", "to"].into_iter().zip(street.ends()).zip(ends) {
            match name.and_then(|name| ground.crossings.get(name)) {
                None => {
                    let message = format!("street {} names no known crossing in '{end}'", street.id);
                    report.add("V1", &who, Some(at), message);
                }
                Some(&crossing) if crossing != at => {
                    let (off, name) = (crossing.distance(at), name.unwrap_or_default());
                    report.add(
                        "V1",
                        &who,
                        Some(at),
                        format!("street {} ends {off:.3} m off its crossing {name}", street.id),
                    );
                }
                Some(_) => {}
            }
        }
        let least = i64::from(tolerance::SEPARATION) * i64::from(tolerance::SEPARATION);
        for (a, b) in street.pieces().filter(|(a, b)| a.distance_squared(*b) < least) {
            report.add("V2", &who, Some(a), format!("street {} has a piece of {:.3} m", street.id, a.distance(b)));
        }
    }
}

fn check_meetings(ground: &Ground<'_>, pieces: &[Piece], grid: &Grid, report: &mut ValidationReport) {
    // One report for two streets that meet, not one for each two pieces.
    let mut reported = std::collections::BTreeSet::new();
    grid.for_pairs(|i, j| {
        let (p, q) = (&pieces[i], &pieces[j]);
        let (s, t) = (&ground.streets[p.street], &ground.streets[q.street]);
        if s.level() != t.level() || !meets(p.a, p.b, q.a, q.b) || may_meet(ground, p, q) {
            return;
        }
        if !reported.insert((p.street, q.street)) {
            return;
        }
        let place = Some(place_of_meeting(p, q));
        if p.street == q.street {
            report.add("V1", &[("street", s.id)], place, format!("street {} crosses itself", s.id));
        } else {
            let message = format!("streets {} and {} meet away from a shared crossing", s.id, t.id);
            report.add("V1", &[("street", s.id), ("street", t.id)], place, message);
        }
    });
}

/// Whether two pieces that meet do so in one common end only, and where they are allowed to.
fn may_meet(ground: &Ground<'_>, p: &Piece, q: &Piece) -> bool {
    let common: Vec<Point> = [p.a, p.b].into_iter().filter(|end| [q.a, q.b].contains(end)).collect();
    let &[at] = common.as_slice() else { return false };
    let far = |piece: &Piece| if piece.a == at { piece.b } else { piece.a };
    if on_segment(p.a, p.b, far(q)) || on_segment(q.a, q.b, far(p)) {
        return false;
    }
    let (s, t) = (&ground.streets[p.street], &ground.streets[q.street]);
    if p.street == q.street {
        let closes = p.index.abs_diff(q.index) + 2 == s.line.len() && s.line[0] == at && s.line.last() == Some(&at);
        return p.index.abs_diff(q.index) == 1 || closes;
    }
    let is_here = |name: &&str| ground.crossings.get(name).is_some_and(|&crossing| crossing == at);
    s.ends().into_iter().flatten().filter(is_here).any(|name| t.ends().contains(&Some(name)))
}

fn place_of_meeting(p: &Piece, q: &Piece) -> Point {
    let touching = [(q.a, p), (q.b, p), (p.a, q), (p.b, q)];
    let touch = touching.into_iter().find(|(end, piece)| on_segment(piece.a, piece.b, *end));
    touch.map_or_else(|| cut(p.a, p.b, q.a, q.b).unwrap_or(p.a), |(end, _)| end)
}

/// A crossing keeps the separation from streets on the ground that do not end there.
fn check_separation(ground: &Ground<'_>, pieces: &[Piece], grid: &Grid, report: &mut ValidationReport) {
    for (&id, &at) in &ground.crossings {
        let mut close = Vec::new();
        grid.for_near(&Bounds::between(at, at).grown(tolerance::SEPARATION), |i| {
            let piece = &pieces[i];
            let street = &ground.streets[piece.street];
            let foreign = street.level() == 0.0 && !street.ends().contains(&Some(id));
            if foreign && within(piece.a, piece.b, at, tolerance::SEPARATION) {
                close.push(piece.street);
            }
        });
        close.sort_unstable();
        close.dedup();
        for street in close.into_iter().map(|i| ground.streets[i].id) {
            let message = format!("crossing {id} lies less than the separation from street {street}");
            report.add("V2", &[("crossing", id), ("street", street)], Some(at), message);
        }
    }
}

fn check_crossings_apart(ground: &Ground<'_>, report: &mut ValidationReport) {
    let crossings: Vec<(&str, Point)> = ground.crossings.iter().map(|(&id, &at)| (id, at)).collect();
    let around = |&(_, at): &(&str, Point)| Bounds::between(at, at).grown(tolerance::SEPARATION);
    let least = i64::from(tolerance::SEPARATION) * i64::from(tolerance::SEPARATION);
    Grid::new(crossings.iter().map(around).collect()).for_pairs(|i, j| {
        let ((a, from), (b, to)) = (crossings[i], crossings[j]);
        if from.distance_squared(to) < least {
            let message = format!("crossings {a} and {b} are {:.3} m apart", from.distance(to));
            report.add("V2", &[("crossing", a), ("crossing", b)], Some(from), message);
        }
    });
}
