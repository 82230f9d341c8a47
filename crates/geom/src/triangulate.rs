//! Triangles of polygons, by constrained Delaunay triangulation.

use crate::polygon::ring_edges;
use crate::predicates::orient;
use crate::{Point, Polygon};
use spade::handles::{DirectedEdgeHandle, FaceHandle, FixedVertexHandle, InnerTag};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, Point2, Triangulation as _};
use thiserror::Error;

/// Triangles that cover a polygon exactly.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Triangulation {
    /// The polygon's corners, each once.
    pub points: Vec<Point>,
    /// Indices into `points`, counter-clockwise; sorted, and each triangle starts with its least index.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a polygon has no triangulation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TriangulateError {
    /// The polygon has no area.
    #[error("the polygon has no area")]
    NoArea,
    /// An edge crosses another edge.
    #[error("the edge from {from:?} to {to:?} crosses another edge")]
    Crossing {
        /// Start of the edge.
        from: Point,
        /// End of the edge.
        to: Point,
    },
    /// Rings overlap, or lie outside or inside each other where they should not.
    #[error("the rings do not bound one area")]
    NotSimple,
}

impl Triangulation {
    /// The corners of a triangle, counter-clockwise.
    pub fn corners(&self, triangle: [u32; 3]) -> [Point; 3] {
        triangle.map(|i| self.points[i as usize])
    }

    /// Twice the sum of areas in LSB²; exact.
    pub fn doubled_area(&self) -> i128 {
        let doubled = |&t| {
            let [a, b, c] = self.corners(t);
            i128::from(orient(a, b, c))
        };
        self.triangles.iter().map(doubled).sum()
    }
}

type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;
type Edge<'a> = DirectedEdgeHandle<'a, Point2<f64>, (), CdtEdge<()>, ()>;
type Face<'a> = FaceHandle<'a, InnerTag, Point2<f64>, (), CdtEdge<()>, ()>;

/// Divides a polygon into triangles with its own corners only; their areas sum up to the polygon's exactly. Rings may
/// touch in points. Translating the polygon translates the result.
///
/// # Errors
/// See [`TriangulateError`].
pub fn triangulate(polygon: &Polygon) -> Result<Triangulation, TriangulateError> {
    let doubled_area = polygon.doubled_area();
    if doubled_area <= 0 {
        return Err(TriangulateError::NoArea);
    }
    let (cdt, points) = constrained(polygon)?;
    let mut triangles = triangles_inside(&cdt);
    triangles.sort_unstable();
    let result = Triangulation { points, triangles };
    // Catches every ring that is not where it should be, exactly.
    if result.doubled_area() == doubled_area { Ok(result) } else { Err(TriangulateError::NotSimple) }
}

/// The triangulation of the convex hull with all edges in it, and the points by vertex index.
fn constrained(polygon: &Polygon) -> Result<(Cdt, Vec<Point>), TriangulateError> {
    let mut cdt = Cdt::new();
    let mut points = Vec::new();
    let base = polygon.outer[0];
    let mut rings: Vec<Vec<FixedVertexHandle>> = Vec::with_capacity(1 + polygon.holes.len());
    for ring in polygon.rings() {
        rings.push(ring.iter().map(|&p| insert(&mut cdt, &mut points, base, p)).collect());
    }
    for (ring, handles) in polygon.rings().zip(&rings) {
        let ends = handles.iter().zip(handles.iter().cycle().skip(1));
        for ((from, to), (&a, &b)) in ring_edges(ring).zip(ends) {
            if a == b {
                continue;
            }
            if !cdt.can_add_constraint(a, b) {
                return Err(TriangulateError::Crossing { from, to });
            }
            cdt.add_constraint(a, b);
        }
    }
    Ok((cdt, points))
}

/// Inserts a point, or finds it where rings touch. Coordinates are exact in f64 and spade's predicates are exact, so
/// nothing is lost on the way.
fn insert(cdt: &mut Cdt, points: &mut Vec<Point>, base: Point, p: Point) -> FixedVertexHandle {
    let (x, y) = base.to(p);
    let vertex = cdt.insert(Point2::new(x as f64, y as f64)).expect("lattice coordinates are finite and small");
    if vertex.index() == points.len() {
        points.push(p);
    }
    vertex
}

/// The faces that lie an odd number of edges away from the outside, found by walking inwards.
fn triangles_inside(cdt: &Cdt) -> Vec<[u32; 3]> {
    let mut inside: Vec<Option<bool>> = vec![None; cdt.num_all_faces()];
    let outward = |rim: Edge<'_>| if rim.is_outer_edge() { rim.fix() } else { rim.fix().rev() };
    let mut frontier: Vec<_> = cdt.convex_hull().map(|rim| (outward(rim), false)).collect();
    while let Some((edge, here)) = frontier.pop() {
        let edge = cdt.directed_edge(edge);
        let Some(face) = edge.rev().face().as_inner() else { continue };
        if inside[face.index()].is_none() {
            let there = here != edge.is_constraint_edge();
            inside[face.index()] = Some(there);
            frontier.extend(face.adjacent_edges().map(|next| (next.fix(), there)));
        }
    }
    cdt.inner_faces().filter(|face| inside[face.index()] == Some(true)).map(corners_of).collect()
}

/// Vertex indices of a face, counter-clockwise from the least.
fn corners_of(face: Face<'_>) -> [u32; 3] {
    let mut corners = face.vertices().map(|vertex| vertex.index() as u32);
    let least = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
    corners.rotate_left(least);
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boolean::difference;
    use crate::polygon::samples::{grid_rectangles, holed, scribble, shift, shifted, star};
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    fn ring(points: &[(i32, i32)]) -> Vec<Point> {
        points.iter().map(|&(x, y)| Point::new(x, y)).collect()
    }

    fn square() -> Vec<Point> {
        ring(&[(0, 0), (12, 0), (12, 12), (0, 12)])
    }

    /// Counter-clockwise triangles, whose inner edges meet in pairs and whose other edges are the polygon's.
    fn covers(result: &Triangulation, polygon: &Polygon) -> bool {
        let mut edges = BTreeSet::new();
        for &t in &result.triangles {
            let [a, b, c] = result.corners(t);
            if orient(a, b, c) <= 0 || ![(a, b), (b, c), (c, a)].into_iter().all(|edge| edges.insert(edge)) {
                return false;
            }
        }
        let rim: BTreeSet<_> = edges.iter().copied().filter(|&(a, b)| !edges.contains(&(b, a))).collect();
        rim == polygon.edges().collect() && result.doubled_area() == polygon.doubled_area()
    }

    #[test]
    fn no_area_is_refused() {
        let refused = |polygon: &Polygon| triangulate(polygon).unwrap_err();
        assert_eq!(refused(&Polygon::default()), TriangulateError::NoArea);
        assert_eq!(refused(&Polygon::new(ring(&[(3, 3)]), Vec::new())), TriangulateError::NoArea);
        assert_eq!(refused(&Polygon::new(ring(&[(0, 0), (5, 5), (9, 9)]), Vec::new())), TriangulateError::NoArea);
        assert_eq!(refused(&Polygon::new(square(), vec![square()])), TriangulateError::NoArea);
    }

    #[test]
    fn what_is_not_simple_is_refused() {
        let refused = |polygon: &Polygon| triangulate(polygon).unwrap_err();
        let bow = Polygon::new(ring(&[(0, 0), (9, 9), (10, 0), (0, 7)]), Vec::new());
        assert!(matches!(refused(&bow), TriangulateError::Crossing { .. }));
        let hole_outside = Polygon::new(square(), vec![ring(&[(14, 0), (18, 0), (18, 4)])]);
        assert_eq!(refused(&hole_outside), TriangulateError::NotSimple);
        let twice = Polygon::new(square(), vec![ring(&[(2, 2), (4, 2), (4, 4)]), ring(&[(2, 2), (4, 2), (4, 4)])]);
        assert_eq!(refused(&twice), TriangulateError::NotSimple);
    }

    #[test]
    fn holes_may_touch() {
        let touching = vec![ring(&[(0, 6), (4, 4), (6, 6)]), ring(&[(6, 6), (9, 4), (9, 9)])];
        let polygon = Polygon::new(square(), touching);
        assert!(polygon.is_valid());
        let result = triangulate(&polygon).unwrap();
        assert_eq!(result.points.len(), 9, "the point where the holes touch is there once");
        assert_eq!(result.doubled_area(), polygon.doubled_area());
    }

    #[test]
    fn a_square_is_two_triangles() {
        let result = triangulate(&Polygon::new(square(), Vec::new())).unwrap();
        assert_eq!(result.points, square());
        assert_eq!(result.triangles.len(), 2);
    }

    #[test]
    fn works_at_the_rim_of_the_lattice() {
        let limit = Point::LIMIT;
        let corners = ring(&[(-limit, -limit), (limit, -limit), (limit, limit), (-limit, limit)]);
        let polygon = Polygon::new(corners, vec![ring(&[(0, 0), (1, 0), (0, 1)])]);
        assert!(covers(&triangulate(&polygon).unwrap(), &polygon));
    }

    proptest! {
        #[test]
        fn triangles_cover_exactly(polygon in prop_oneof![star(), holed()]) {
            let result = triangulate(&polygon).unwrap();
            prop_assert!(covers(&result, &polygon));
            let corners: BTreeSet<Point> = polygon.rings().flatten().copied().collect();
            prop_assert_eq!(result.points.iter().copied().collect::<BTreeSet<_>>(), corners);
        }

        #[test]
        fn pinched_shapes_are_covered(a in grid_rectangles(2), b in grid_rectangles(2)) {
            for polygon in difference(&a, &b) {
                prop_assert_eq!(triangulate(&polygon).unwrap().doubled_area(), polygon.doubled_area());
            }
        }

        #[test]
        fn moves_along(polygon in prop_oneof![star(), holed()], by in shift()) {
            let result = triangulate(&polygon).unwrap();
            let moved = triangulate(&shifted(&polygon, by)).unwrap();
            prop_assert_eq!(moved.triangles, result.triangles);
        }

        #[test]
        fn any_rings_give_the_area_or_an_error(outer in scribble(), hole in scribble()) {
            let polygon = Polygon::new(outer, vec![hole]);
            match triangulate(&polygon) {
                Ok(result) => prop_assert_eq!(result.doubled_area(), polygon.doubled_area()),
                Err(_) => prop_assert!(!polygon.is_valid()),
            }
        }
    }
}
