//! A finished city: what every export and view reads.

use crate::Site;
use buildings::Building;
use geom::{Id, Polygon};
use layout::{Block, Parcel};
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
    pub graph: StreetGraph,
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
    /// Blocks.
    pub blocks: Vec<Block>,
    /// Parcels; empty when built until streets.
    pub parcels: Vec<Parcel>,
    /// Buildings; empty when built until streets or parcels.
    pub buildings: Vec<Building>,
}
