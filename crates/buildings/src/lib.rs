//! One parcel to one building. `buildings` sees one start shape at a time: parallel, cacheable, order-free.

pub mod extrusion;
pub mod height;

pub use extrusion::extrude;
pub use height::height_from_density;

use geom::{Id, Polygon};

/// What a building stands on: one parcel, as its rule sees it.
#[derive(Clone, Debug, PartialEq)]
pub struct StartShape {
    /// The parcel.
    pub parcel: Id,
    /// Its outline.
    pub outline: Polygon,
    /// Population density there, people per km².
    pub density: f64,
    /// Ground elevation in metres: lowest and highest on the outline.
    pub ground: (f64, f64),
}

/// A building without detail: a footprint raised to a height.
#[derive(Clone, Debug, PartialEq)]
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
