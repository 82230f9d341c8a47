//! One parcel to one building. `buildings` sees one start shape at a time: parallel, cacheable, order-free.

mod convex;
mod cover;
pub mod extrusion;
pub mod height;
mod sides;

pub use extrusion::{LEAST_HEIGHT, extrude, footprint, kept_setback, raise};
pub use height::height_from_density;
pub use sides::{Side, main_front, sides};

use geom::{Id, Polygon};
use serde::{Deserialize, Serialize};

/// What a building stands on: one parcel, as its rule sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct StartShape {
    /// The parcel.
    pub parcel: Id,
    /// Its outline.
    pub outline: Polygon,
    /// For each edge of the outer ring, by the corner it starts at: whether it lies on a street.
    pub fronts: Vec<bool>,
    /// Population density there, people per km².
    pub density: f64,
    /// Ground elevation in metres: lowest and highest on the outline.
    pub ground: (f64, f64),
}

/// Distances kept free along the rim of a parcel, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setbacks {
    /// The same on all sides; it yields where the parcel is too small for it.
    Even(f64),
    /// By side, kept at any price.
    Sides {
        /// From streets.
        front: f64,
        /// From neighbours beside.
        side: f64,
        /// From what lies behind.
        rear: f64,
    },
}

/// The volume that a building may fill.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Envelope {
    /// Height above the highest ground, metres.
    pub height: f64,
    /// Distances kept free.
    pub setbacks: Setbacks,
    /// Share of the parcel that the footprint may cover at most.
    pub coverage: f64,
}

/// A building without detail: a footprint raised to a height.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Building {
    /// hash(parcel, "building").
    pub id: Id,
    /// Its parcel.
    pub parcel: Id,
    /// Ground polygon, inside the parcel.
    pub footprint: Polygon,
    /// Height in metres above the highest ground.
    pub height: f64,
    /// Ground elevation in metres: lowest and highest.
    pub ground: (f64, f64),
    /// Which rule made it: an index into the table of the city.
    pub origin: u16,
}
