//! The extended L-system kernel (PM01 §3): rules propose, the kernel disposes.
//!
//! [`grow`] derives majors in a graph; [`grow_quarter`] fills one quarter as a pure function of it, so that many can
//! run at once, and [`attach`] puts the results into the graph in an order of its own. Every proposal has a lineage
//! (which tip proposed it in which slot), from which the ids of streets and nodes are made.

pub mod fields;
pub mod tip;

mod constraints;
mod given;
mod goal;
mod ground;
mod kernel;
mod lineage;
mod log;
mod merge;
mod near;
mod outside;
mod prune;
mod quarter;
mod queue;
mod seat;
mod settings;
mod smooth;

pub use constraints::Constraints;
pub use fields::{Field, Fields, Fit};
pub use given::grow_from_streets;
pub use goal::Goal;
pub use kernel::grow;
pub use lineage::Branch;
pub use log::{Accepted, GrowthLog, Lineage, Outcome, Refusals, Refused, RefusedProposal, Stopped};
pub use merge::{Dropped, MergeLog, attach};
pub use outside::grow_outside;
pub use prune::prune_dead_ends;
pub use quarter::{Attachment, QuarterGrowth, QuarterSettings, grow_quarter};
pub use settings::{Growth, Limits, SeedPoint};
pub use smooth::{Smoothed, Smoothing, smooth};
pub use tip::{GrowthRules, Slot, Slots, Steer, Tip};

#[cfg(test)]
mod tests;
