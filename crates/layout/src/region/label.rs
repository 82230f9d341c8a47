//! Whose border an edge lies on. Booleans forget where an edge came from, so it is found again by place: an edge of a
//! region lies within rounding of a piece's border, or within a collapsed edge of it.

use super::Piece;
use geom::tolerance::PARCEL_EDGE;
use geom::{Bounds, Point, Vec2};
use streets::StreetId;

/// The street of each edge of a ring, by the corner it starts at.
pub(super) fn streets_of_edges(ring: &[Point], pieces: &[Piece]) -> Vec<Option<StreetId>> {
    let next = |i: usize| ring[(i + 1) % ring.len()];
    ring.iter().enumerate().map(|(i, &a)| street_of(a, next(i), pieces)).collect()
}

fn street_of(a: Point, b: Point, pieces: &[Piece]) -> Option<StreetId> {
    let near = Bounds::between(a, b).grown(PARCEL_EDGE);
    let mut best: Option<(f64, StreetId)> = None;
    for piece in pieces.iter().filter(|piece| piece.bounds.overlaps(&near)) {
        for (c, d) in geom::polygon::ring_edges(&piece.ring) {
            let Some(off) = deviation(a, b, c, d) else { continue };
            if best.is_none_or(|(least, street)| (off, piece.street) < (least, street)) {
                best = Some((off, piece.street));
            }
        }
    }
    best.map(|(_, street)| street)
}

/// How far the edge `a b` lies off the border `c d`, in LSB, when it runs along it.
fn deviation(a: Point, b: Point, c: Point, d: Point) -> Option<f64> {
    let vector = |from: Point, to: Point| {
        let (x, y) = from.to(to);
        Vec2::new(x as f64, y as f64)
    };
    let border = vector(c, d);
    let length = border.length();
    let unit = border.try_normalize()?;
    let place = |p: Point| {
        let v = vector(c, p);
        (unit.dot(v), unit.perp_dot(v).abs())
    };
    let ((along_a, off_a), (along_b, off_b)) = (place(a), place(b));
    let slack = f64::from(PARCEL_EDGE) + 2.0;
    let middle = (along_a + along_b) / 2.0;
    let beside = off_a.max(off_b) <= slack && (-slack..=length + slack).contains(&middle);
    beside.then_some(off_a + off_b)
}
