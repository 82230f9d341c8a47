//! Cleaning a piece of land, always inwards: what is given back lies within what came.

use super::LEAST_DOUBLED_AREA;
use geom::polygon::Location;
use geom::predicates::{cut, orient};
use geom::tolerance::PARCEL_EDGE;
use geom::{Bounds, Point, Polygon, boolean};

/// Rounds of cleaning before what is still unclean is given up.
const ROUNDS: usize = 6;

/// The clean parts of a polygon: simple rings that touch nowhere, no short edges, at least 1 m² each.
pub(super) fn cleaned(land: Polygon) -> Vec<Polygon> {
    let mut done = Vec::new();
    let mut open = vec![land];
    for _ in 0..ROUNDS {
        for polygon in std::mem::take(&mut open) {
            let original = polygon.clone();
            match collapsed(polygon) {
                Some(polygon) if polygon.doubled_area() < LEAST_DOUBLED_AREA => {}
                Some(polygon) if polygon.is_simple() => done.push(polygon),
                Some(polygon) => open.extend(untangled(polygon, original)),
                None => {}
            }
        }
        if open.is_empty() {
            break;
        }
    }
    done
}

/// What is left of a polygon whose rings touch, or that cut into itself when it was made from `original`.
fn untangled(polygon: Polygon, original: Polygon) -> Vec<Polygon> {
    let spots = touching(&polygon);
    if spots.is_empty() {
        return boolean::intersection(&[polygon], &[original]);
    }
    boolean::difference(&[polygon], &spots)
}

/// Small squares round the points where rings touch.
fn touching(polygon: &Polygon) -> Vec<Polygon> {
    let square = |p: Point| Polygon::rectangle(Bounds::between(p, p).grown(PARCEL_EDGE));
    let rings: Vec<&[Point]> = polygon.rings().collect();
    let touches = |i: usize, p: Point| {
        let mut others = rings.iter().enumerate().filter(|&(j, _)| j != i);
        others.any(|(_, ring)| on_ring(ring, p))
    };
    let corners = rings.iter().enumerate().flat_map(|(i, ring)| ring.iter().map(move |&p| (i, p)));
    corners.filter(|&(i, p)| rings.len() > 1 && touches(i, p)).map(|(_, p)| square(p)).collect()
}

fn on_ring(ring: &[Point], p: Point) -> bool {
    Polygon { outer: ring.to_vec(), holes: Vec::new() }.locate(p) == Location::OnRim
}

/// The polygon without edges shorter than [`PARCEL_EDGE`]; `None` when nothing is left. May cut into itself.
fn collapsed(polygon: Polygon) -> Option<Polygon> {
    let outer = collapsed_ring(polygon.outer)?;
    let hole = |ring: Vec<Point>| collapsed_ring(ring.clone()).unwrap_or_else(|| square_hole(&ring));
    Some(Polygon { outer, holes: polygon.holes.into_iter().map(hole).collect() })
}

/// A hole too small to have clean edges becomes the square around it.
fn square_hole(ring: &[Point]) -> Vec<Point> {
    let bounds = Bounds::of(ring.iter().copied()).expect("a hole has corners").grown(PARCEL_EDGE);
    let mut corners = Polygon::rectangle(bounds).outer;
    corners.reverse();
    corners
}

fn collapsed_ring(mut ring: Vec<Point>) -> Option<Vec<Point>> {
    // Each step takes a corner away, or widens a spike, which happens at most once an edge.
    for _ in 0..2 * ring.len() {
        ring = geom::polygon::without_collinear(&ring);
        if ring.len() < 3 {
            return None;
        }
        let Some(short) = shortest_short_edge(&ring) else { return Some(ring) };
        if ring.len() == 3 {
            return None;
        }
        collapse_edge(&mut ring, short);
    }
    None
}

fn shortest_short_edge(ring: &[Point]) -> Option<usize> {
    let limit = i64::from(PARCEL_EDGE) * i64::from(PARCEL_EDGE);
    let length = |i: usize| ring[i].distance_squared(ring[(i + 1) % ring.len()]);
    (0..ring.len()).filter(|&i| length(i) < limit).min_by_key(|&i| length(i))
}

/// Takes away the edge from corner `i`, so that the land on its left only shrinks.
fn collapse_edge(ring: &mut Vec<Point>, i: usize) {
    let n = ring.len();
    let j = (i + 1) % n;
    let (a, b, c, d) = (ring[(i + n - 1) % n], ring[i], ring[j], ring[(i + 2) % n]);
    let (lost_b, lost_c) = (orient(a, b, c), orient(b, c, d));
    if lost_b > 0 && (lost_c <= 0 || lost_b <= lost_c) {
        ring.remove(i);
    } else if lost_c > 0 {
        ring.remove(j);
    } else {
        match mitre_tip(a, b, c, d) {
            Some(tip) => {
                ring[i] = tip;
                ring.remove(j);
            }
            None => (ring[i], ring[j]) = apart(b, c),
        }
    }
}

/// Where the edges `a b` and `c d` on either side of a short one meet: the nearest lattice point right of neither;
/// `None` where that is far.
fn mitre_tip(a: Point, b: Point, c: Point, d: Point) -> Option<Point> {
    let limit = 4 * i64::from(PARCEL_EDGE);
    let meeting = cut(a, b, c, d).filter(|tip| tip.distance_squared(b) < limit * limit)?;
    let around = (-2..=2).flat_map(|x| (-2..=2).map(move |y| Point::new(meeting.x + x, meeting.y + y)));
    let inside = around.filter(|&tip| orient(a, b, tip) >= 0 && orient(c, d, tip) >= 0);
    inside.min_by_key(|tip| (tip.distance_squared(meeting), *tip))
}

/// The ends of a short edge moved apart along the longer of its axes.
fn apart(b: Point, c: Point) -> (Point, Point) {
    let (dx, dy) = b.to(c);
    let step = |d: i64, other: i64| if d.abs() >= other.abs() { PARCEL_EDGE * d.signum() as i32 } else { 0 };
    let (x, y) = (step(dx, dy), step(dy, dx));
    let held = |v: i32| v.clamp(-Point::LIMIT, Point::LIMIT);
    (Point::new(held(b.x - x), held(b.y - y)), Point::new(held(c.x + x), held(c.y + y)))
}
