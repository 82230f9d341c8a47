//! A finished city: what every export and view reads.

use crate::{Digests, Site};
use buildings::Building;
use geom::{Id, Polygon, Vec2};
use layout::{Block, Parcel};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::runs::Run;
use streets::{StreetGraph, StreetId};

/// A named or identified area.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    /// Identity: a quarter's signature, a district's name hashed.
    pub id: Id,
    /// Name, for districts.
    pub name: Option<String>,
    /// Its ground.
    pub polygon: Polygon,
}

/// A place that stands out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Landmark {
    /// Identity: its name hashed.
    pub id: Id,
    /// Its name.
    pub name: String,
    /// Its middle, in metres.
    pub at: Vec2,
    /// Its ground, as it was asked for.
    pub ground: Polygon,
    /// The parcels it became, the largest first: one, where no street that was there before crosses it; none where no block
    /// lies around it.
    pub parcels: Vec<Id>,
}

/// A finished city. Derived, never saved; all lists by id.
#[derive(Clone, Debug)]
pub struct City {
    /// The city's name, from its folder.
    pub name: String,
    /// The seed it was built with.
    pub seed: u64,
    /// Whom maps of it must name, e.g. contributors of imported streets.
    pub credits: Vec<String>,
    /// Where it stands.
    pub site: Arc<Site>,
    /// Its streets.
    pub graph: Arc<StreetGraph>,
    /// What claims, parcels and buildings refer to by `origin`: rule or input names.
    pub origins: Vec<String>,
    /// Names of streets that have one.
    pub street_names: BTreeMap<StreetId, String>,
    /// Streets between crossings.
    pub runs: Vec<Run>,
    /// Quarters.
    pub quarters: Vec<Area>,
    /// Districts.
    pub districts: Vec<Area>,
    /// Landmarks.
    pub landmarks: Vec<Landmark>,
    /// Blocks.
    pub blocks: Arc<Vec<Block>>,
    /// Parcels; empty when built until streets.
    pub parcels: Arc<Vec<Parcel>>,
    /// Buildings; empty when built until streets or parcels.
    pub buildings: Arc<Vec<Building>>,
    /// What parts of it were made from, where that was found out: so that parts of its files can be kept.
    pub digests: Digests,
}
