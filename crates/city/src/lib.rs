//! The whole: sources, stages, report, export, and the `plat` command.
//!
//! [`load`] reads a city script into a [`Loaded`] plan, [`Loaded::read`] reads what the plan names, [`build`] makes the
//! city, [`export::write_all`] writes it.

pub mod build;
mod cache;
pub mod changes;
mod check;
mod copy;
pub mod export;
pub mod load;
pub mod measure;
pub mod model;
pub mod progress;
pub mod report;
pub mod site;
pub mod sources;
mod stages;
pub mod testing;
pub mod trace;
pub mod validate;
pub mod watch;
pub mod why;

pub use build::{BuildError, Built, Settings, Until, build, build_with, with_threads};
pub use cache::{Cache, Digests};
pub use changes::Changes;
pub use check::{Checked, check, rule_host};
pub use copy::{CopyError, copy_city};
pub use load::{LoadError, Loaded, PresetError, Sources, load, load_as_written};
pub use model::{Area, City, Landmark};
pub use progress::{Cancel, Progress, Silent, Stage};
pub use report::{BuiltFrom, CallReport, FaultReport, MarkReport, Report};
pub use site::Site;
pub use trace::Trace;
pub use watch::Watch;
