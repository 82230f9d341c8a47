//! The plane and its numbers: lattice points, exact predicates, polygons, rasters, meshes, seeds.
//!
//! Persistent positions are integers ([`Point`]); whatever decides topology is an exact integer predicate
//! ([`predicates`]); floats ([`Vec2`]) carry measures and pictures only. Nothing here knows a word of cities.
//!
//! Conventions, said once: y points up, angles run counter-clockwise from east, outer rings are counter-clockwise and
//! holes clockwise, rings are not closed (the last vertex is not repeated).

pub mod angle;
pub mod boolean;
pub mod cells;
pub mod digest;
pub mod id;
pub mod mesh;
pub mod point;
pub mod polygon;
pub mod predicates;
pub mod raster;
pub mod seed;
pub mod strip;
pub mod tolerance;
pub mod triangulate;

pub use angle::Angle;
pub use cells::Cells;
pub use digest::Digest;
pub use glam::DVec2 as Vec2;
pub use glam::DVec3 as Vec3;
pub use id::Id;
pub use mesh::Mesh;
pub use point::{Bounds, Point};
pub use polygon::Polygon;
pub use raster::Raster;
pub use seed::Seed;
pub use triangulate::{Triangulation, triangulate};
