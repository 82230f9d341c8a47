//! The planar street graph.
//!
//! After every public operation no two segments of a level meet but at a common node, and what does not meet keeps
//! [`geom::tolerance::SEPARATION`] (V1, V2). A segment carries one *claim* for each street that runs along it; a node
//! is *pinned* by the streets that turn or end there, and an unpinned node is a mere crossing that goes away with
//! either of its streets.
//!
//! Levels: nodes belong to no level. A segment keeps its distance from every node if it lies on the ground, and from
//! nodes of its own level otherwise; so a bridge passes over crossings, and its ends are crossings of the ground.

mod check;
mod index;
mod insert;
pub mod oracle;
mod query;
mod remove;
mod store;
mod stored;
mod transaction;

pub use check::{Breach, CheckLevel, Rule, SharpAngle, Violation};
pub use insert::{Crowding, Insertion, NewSegment, Refusal};
pub use query::CrossingAhead;
pub use store::{Claim, HalfKey, Node, NodeKey, Segment, SegmentKey, StreetGraph};
