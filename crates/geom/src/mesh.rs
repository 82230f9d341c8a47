//! Triangle meshes.
//!
//! A mesh lies around an origin in the plane: its positions are metres from there, so that `f32` keeps them exact to
//! less than a millimetre within some kilometres. Whatever puts a thing of the plane into a mesh takes that origin.

use crate::polygon::ring_edges;
use crate::triangulate::{TriangulateError, Triangulation, triangulate};
use crate::{Polygon, Vec2, Vec3};
use thiserror::Error;

/// Triangles with shared corners; positions in metres, x east, y up, z south (glTF).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals, one a position.
    pub normals: Vec<[f32; 3]>,
    /// Three a triangle, counter-clockwise seen from outside.
    pub indices: Vec<u32>,
}

/// Why something has no mesh.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum MeshError {
    /// The ground polygon cannot be divided into triangles.
    #[error(transparent)]
    Polygon(#[from] TriangulateError),
    /// Top and base are not finite, or the top is not above the base.
    #[error("the top ({top} m) must lie above the base ({base} m)")]
    Heights {
        /// Lower end in metres.
        base: f64,
        /// Upper end in metres.
        top: f64,
    },
}

/// A place of the plane at a height, as a position in a mesh around `origin`; all in metres.
pub fn position(place: Vec2, height: f64, origin: Vec2) -> Vec3 {
    let from = place - origin;
    Vec3::new(from.x, height, -from.y)
}

/// The solid between two heights above a polygon, in metres: walls with a flat normal each, outward, and a roof; open
/// below. See [`extrude_closed`].
///
/// # Errors
/// See [`MeshError`].
pub fn extrude(polygon: &Polygon, base: f64, top: f64, origin: Vec2) -> Result<Mesh, MeshError> {
    if !(base.is_finite() && top.is_finite() && base < top) {
        return Err(MeshError::Heights { base, top });
    }
    let roof = triangulate(polygon)?;
    let mut mesh = Mesh::default();
    mesh.push_walls(polygon, base, top, origin);
    mesh.push_polygon(&roof, top, origin);
    Ok(mesh)
}

/// The solid of [`extrude`] with a floor that faces down, so that the mesh is closed.
///
/// # Errors
/// See [`MeshError`].
pub fn extrude_closed(polygon: &Polygon, base: f64, top: f64, origin: Vec2) -> Result<Mesh, MeshError> {
    let mut mesh = extrude(polygon, base, top, origin)?;
    mesh.push_floor(&triangulate(polygon)?, base, origin);
    Ok(mesh)
}

impl Mesh {
    /// Whether there is nothing to see.
    pub fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    /// The corners of each triangle.
    pub fn triangles(&self) -> impl Iterator<Item = [[f32; 3]; 3]> {
        self.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]].map(|i| self.positions[i as usize]))
    }

    /// Adds a flat triangle with corners of its own, counter-clockwise seen from outside. One without area, or with
    /// corners that are not finite, adds nothing.
    pub fn push_triangle(&mut self, corners: [Vec3; 3]) {
        let [a, b, c] = corners;
        self.push_flat(&corners, (b - a).cross(c - a), &[0, 1, 2]);
    }

    /// Adds a quadrilateral with corners of its own and one normal, counter-clockwise seen from outside, cut along the
    /// diagonal from the first to the third corner. One without area, or with corners that are not finite, adds nothing.
    pub fn push_quad(&mut self, corners: [Vec3; 4]) {
        let [a, b, c, d] = corners;
        self.push_flat(&corners, (c - a).cross(d - b), &[0, 1, 2, 0, 2, 3]);
    }

    /// Adds a level surface at a height in metres that faces up.
    pub fn push_polygon(&mut self, surface: &Triangulation, height: f64, origin: Vec2) {
        self.push_level(surface, height, origin, Vec3::Y, |triangle| triangle);
    }

    /// Adds a level surface at a height in metres that faces down.
    pub fn push_floor(&mut self, surface: &Triangulation, height: f64, origin: Vec2) {
        self.push_level(surface, height, origin, Vec3::NEG_Y, |[a, b, c]| [a, c, b]);
    }

    /// Adds a wall along every edge of the polygon between two heights in metres, facing away from its inside.
    pub fn push_walls(&mut self, polygon: &Polygon, base: f64, top: f64, origin: Vec2) {
        for (from, to) in polygon.rings().flat_map(ring_edges) {
            let at = |p: crate::Point, height| position(p.metres(), height, origin);
            self.push_quad([at(from, base), at(to, base), at(to, top), at(from, top)]);
        }
    }

    /// Adds all of another mesh around the same origin.
    pub fn append(&mut self, other: &Self) {
        let first = self.next_index();
        self.positions.extend_from_slice(&other.positions);
        self.normals.extend_from_slice(&other.normals);
        self.indices.extend(other.indices.iter().map(|i| first + i));
    }

    /// Moves every position, in metres.
    pub fn translate(&mut self, by: Vec3) {
        for at in &mut self.positions {
            *at = single(Vec3::from_array(at.map(f64::from)) + by);
        }
    }

    /// Volume enclosed in m³, by the divergence theorem; means something for a closed mesh only.
    pub fn volume(&self) -> f64 {
        let six_fold = |t: [[f32; 3]; 3]| {
            let [a, b, c] = t.map(|p| Vec3::from_array(p.map(f64::from)));
            a.dot(b.cross(c))
        };
        self.triangles().map(six_fold).sum::<f64>() / 6.0
    }

    fn push_flat(&mut self, corners: &[Vec3], normal: Vec3, triangles: &[u32]) {
        let Some(normal) = normal.try_normalize() else { return };
        let first = self.next_index();
        self.positions.extend(corners.iter().map(|&at| single(at)));
        self.normals.extend(corners.iter().map(|_| single(normal)));
        self.indices.extend(triangles.iter().map(|i| first + i));
    }

    fn push_level(
        &mut self,
        surface: &Triangulation,
        height: f64,
        origin: Vec2,
        normal: Vec3,
        turn: impl Fn([u32; 3]) -> [u32; 3],
    ) {
        let first = self.next_index();
        self.positions.extend(surface.points.iter().map(|p| single(position(p.metres(), height, origin))));
        self.normals.extend(surface.points.iter().map(|_| single(normal)));
        self.indices.extend(surface.triangles.iter().flat_map(|&t| turn(t)).map(|i| first + i));
    }

    /// The index of the next position.
    fn next_index(&self) -> u32 {
        u32::try_from(self.positions.len()).expect("a mesh has fewer than 2³² positions")
    }
}

fn single(v: Vec3) -> [f32; 3] {
    v.to_array().map(|x| x as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;
    use crate::polygon::samples::{holed, star};
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    fn square() -> Polygon {
        Polygon::rectangle(crate::Bounds::between(Point::new(1024, 2048), Point::new(3072, 5120)))
    }

    /// Every edge has as many twins in the other sense: no gap and no rim.
    fn is_closed(mesh: &Mesh) -> bool {
        let mut balance: BTreeMap<[[u32; 3]; 2], i32> = BTreeMap::new();
        for t in mesh.triangles() {
            // Adding zero makes -0 and 0 one.
            let t = t.map(|corner| corner.map(|x| (x + 0.0).to_bits()));
            for [a, b] in [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]] {
                *balance.entry(if a < b { [a, b] } else { [b, a] }).or_default() += if a < b { 1 } else { -1 };
            }
        }
        balance.values().all(|&n| n == 0)
    }

    /// Normals are unit vectors and point to the side from which triangles run counter-clockwise.
    fn normals_agree(mesh: &Mesh) -> bool {
        let wide = |v: [f32; 3]| Vec3::from_array(v.map(f64::from));
        mesh.positions.len() == mesh.normals.len()
            && mesh.indices.chunks_exact(3).all(|t| {
                let [a, b, c] = [t[0], t[1], t[2]].map(|i| wide(mesh.positions[i as usize]));
                let turn = (b - a).cross(c - a);
                t.iter().all(|&i| {
                    let normal = wide(mesh.normals[i as usize]);
                    (normal.length() - 1.0).abs() < 1e-6 && turn.dot(normal) >= 0.0
                })
            })
    }

    #[test]
    fn a_box_in_gltf_axes() {
        let mesh = extrude_closed(&square(), 10.0, 14.0, Vec2::new(1.0, 1.0)).unwrap();
        assert_eq!(mesh.volume(), 2.0 * 3.0 * 4.0);
        assert_eq!(mesh.positions.len(), 4 * 4 + 4 + 4);
        let range = |axis: usize| {
            let values = mesh.positions.iter().map(|p| p[axis]);
            (values.clone().fold(f32::INFINITY, f32::min), values.fold(f32::NEG_INFINITY, f32::max))
        };
        assert_eq!((range(0), range(1), range(2)), ((0.0, 2.0), (10.0, 14.0), (-4.0, -1.0)));
        assert_eq!(mesh.normals[0], [0.0, 0.0, 1.0], "the south wall looks south, which is +z");
        assert_eq!(mesh.normals[16], [0.0, 1.0, 0.0], "the roof looks up");
        assert!(is_closed(&mesh) && normals_agree(&mesh));
    }

    #[test]
    fn an_open_box_lacks_its_floor() {
        let (open, closed) =
            (extrude(&square(), 0.0, 1.0, Vec2::ZERO), extrude_closed(&square(), 0.0, 1.0, Vec2::ZERO));
        let (open, closed) = (open.unwrap(), closed.unwrap());
        assert!(!is_closed(&open));
        assert_eq!(open.indices.len() + 6, closed.indices.len());
    }

    #[test]
    fn what_has_no_mesh() {
        let upside_down = extrude(&square(), 3.0, 3.0, Vec2::ZERO);
        assert_eq!(upside_down, Err(MeshError::Heights { base: 3.0, top: 3.0 }));
        assert!(matches!(extrude(&square(), 0.0, f64::NAN, Vec2::ZERO), Err(MeshError::Heights { .. })));
        let flat = extrude(&Polygon::default(), 0.0, 3.0, Vec2::ZERO);
        assert_eq!(flat, Err(MeshError::Polygon(TriangulateError::NoArea)));
    }

    #[test]
    fn degenerate_triangles_add_nothing() {
        let mut mesh = Mesh::default();
        mesh.push_triangle([Vec3::ZERO, Vec3::X, Vec3::X * 2.0]);
        mesh.push_triangle([Vec3::ZERO, Vec3::X, Vec3::NAN]);
        mesh.push_quad([Vec3::ZERO; 4]);
        assert!(mesh.is_empty() && mesh.positions.is_empty());
        mesh.push_triangle([Vec3::ZERO, Vec3::X, Vec3::Y]);
        assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 3]);
    }

    #[test]
    fn meshes_append_and_move() {
        let mut mesh = extrude_closed(&square(), 0.0, 1.0, Vec2::ZERO).unwrap();
        let mut other = mesh.clone();
        other.translate(Vec3::new(10.0, 2.0, -3.0));
        assert_eq!(other.positions[0], [11.0, 2.0, -5.0]);
        mesh.append(&other);
        assert_eq!(mesh.volume(), 12.0);
        assert!(is_closed(&mesh) && normals_agree(&mesh));
    }

    proptest! {
        #[test]
        fn solids_are_closed_and_hold_area_times_height(
            polygon in prop_oneof![star(), holed()],
            base in -50.0f64..50.0,
            height in 0.5f64..100.0,
        ) {
            let origin = polygon.bounds().unwrap().min.metres();
            let mesh = extrude_closed(&polygon, base, base + height, origin).unwrap();
            prop_assert!(is_closed(&mesh));
            prop_assert!(normals_agree(&mesh));
            let expected = polygon.area() * height;
            // Heights are rounded to f32; plan positions near the origin are exact.
            prop_assert!((mesh.volume() - expected).abs() <= 1e-4 * expected, "{} {}", mesh.volume(), expected);
        }

        #[test]
        fn an_origin_near_by_keeps_plan_positions_exact(polygon in star(), by in crate::polygon::samples::shift()) {
            let moved = crate::polygon::samples::shifted(&polygon, by);
            let at = |p: &Polygon| extrude(p, 0.0, 5.0, p.outer[0].metres()).unwrap();
            prop_assert_eq!(at(&moved), at(&polygon));
        }
    }
}
