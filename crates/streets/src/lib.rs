//! The planar street graph, its faces, and the growth kernel.

pub mod class;
pub mod districts;
pub mod faces;
pub mod graph;
pub mod growth;
pub mod ids;
pub mod runs;

pub use class::{Class, ClassInfo, Classes};
pub use districts::{DistrictArea, Districts, PerDistrict};
pub use graph::{Claim, HalfKey, NodeKey, Segment, SegmentKey, StreetGraph};
pub use ids::{NodeId, SegmentId, StreetId};
