//! Blocks, buildable regions and parcels.
//!
//! A [`Block`] holds everything its division needs; [`buildable`] takes the rights-of-way out of it; [`subdivide`] cuts
//! what is left into parcels. Each is a pure function of one block: parallel, cacheable, order-free.

pub mod blocks;
pub mod model;
pub mod region;
mod side;
pub mod subdivide;

pub use blocks::{BlockSource, blocks};
pub use model::{Block, Body, Joint, Parcel, Region, Use};
pub use region::{Buildable, Parted, buildable, part_grounds};
pub use side::longest_side;
pub use subdivide::{
    Division, DivisionStep, Inner, Looked, RecursiveSettings, SettingsError, Squared, WhyOpen, recursive,
    recursive_telling, subdivide,
};

#[cfg(test)]
mod samples;
