//! The extended L-system kernel (PM01 §3): rules propose, the kernel disposes.
//!
//! [`grow`] derives majors in a graph; [`grow_quarter`] fills one quarter as a pure function of it, so that many can
//! run at once, and [`attach`] puts the results into the graph in an order of its own. Every proposal has a lineage
//! (which tip proposed it in which slot), from which the ids of streets and nodes are made.

pub mod fields;
pub mod tip;

mod blend;
mod chain;
mod constraints;
mod demand;
mod distances;
mod given;
mod goal;
mod grade;
mod ground;
mod judge;
mod keeping;
mod kernel;
mod lineage;
mod log;
mod mask;
mod merge;
mod near;
mod outside;
mod own;
mod peaks;
mod prune;
mod quarter;
mod queue;
mod rim;
mod rings;
mod seat;
mod senses;
mod settings;
mod slots;
mod smooth;
mod steer;
mod varying;
mod weight;
mod zone;

pub use blend::{Blend, BlendPart};
pub use fields::{Field, Fields, Fit, Rise};
pub use given::grow_from_streets;
mod span;

pub use chain::{Bridge, Chain, Duplicate, Extend, Legal, Length, MOST_STEPS, Over, Slope, Step, TurnSearch};
pub use constraints::{BRIDGE_SPACING, Constraints};
pub use distances::Distances;
pub use goal::Goal;
pub use keeping::Keeps;
pub use kernel::grow;
pub use lineage::Branch;
pub use log::{Accepted, GrowthLog, Lineage, MOST_REASONS, Outcome, Refusals, Refused, RefusedProposal, Stopped};
pub use mask::Area;
pub use merge::{Dropped, MergeLog, attach};
pub use outside::grow_outside;
pub use own::{Constrain, Draft, Own};
pub use peaks::{Peak, Peaks};
pub use prune::{prune_dead_ends, prune_networks};
pub use quarter::{Attachment, QuarterGrowth, QuarterSettings, grow_quarter};
pub use rim::rim_mask;
pub use rings::Rings;
pub use settings::{Growth, Limits, SeedPoint};
pub use smooth::{Smoothed, Smoothing, smooth};
pub use steer::Steer;
pub use tip::{GrowthRules, Home, Slot, Slots, Tip};
pub use varying::{Quantity, Varying};
pub use weight::Weight;
pub use zone::Zones;

#[cfg(test)]
mod tests;
