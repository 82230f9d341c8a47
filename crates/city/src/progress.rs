//! How far a build is, and how to stop it. Every stage takes both handles.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The stages of a build, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Given and imported streets enter the graph.
    Import,
    /// Highways grow.
    Highways,
    /// Majors grow.
    Majors,
    /// Quarters are filled with minors.
    Minors,
    /// Blocks are found and divided into parcels.
    Parcels,
    /// Parcels get their buildings.
    Buildings,
    /// Files are written.
    Export,
}

impl Stage {
    /// The word shown for the stage.
    pub fn name(self) -> &'static str {
        match self {
            Self::Import => "import",
            Self::Highways => "highways",
            Self::Majors => "majors",
            Self::Minors => "minors",
            Self::Parcels => "parcels",
            Self::Buildings => "buildings",
            Self::Export => "export",
        }
    }
}

/// Hears how far a build is. Called from many threads.
pub trait Progress: Sync {
    /// A stage begins, with so many parts (0 when not known).
    fn begin(&self, stage: Stage, parts: u64);
    /// So many more parts are done.
    fn advance(&self, parts: u64);
    /// The stage is over; a short sentence on what came out.
    fn end(&self, stage: Stage, outcome: &str);
}

/// Says nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _: Stage, _: u64) {}
    fn advance(&self, _: u64) {}
    fn end(&self, _: Stage, _: &str) {}
}

/// Asks a build to stop. Clones share the flag.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Asks to stop; the build returns soon, having written nothing.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether to stop.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
