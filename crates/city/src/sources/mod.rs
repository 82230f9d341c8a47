//! All reading of files: maps of a site, and streets of real places.
//!
//! Whatever is wrong with a file is a [`SourceError`] that names the file, the place in it and what to do. Positions
//! leave this module in the local frame: x east, y north, metres from the south-west corner of the site.

mod district_map;
mod district_polygons;
mod error;
mod geojson_streets;
mod import;
mod imported;
mod maps;
mod osm;
mod osm_pbf;
mod osm_xml;
mod pixels;
mod projection;
mod sidecar;
mod suggest;

pub use district_map::{DistrictMap, Legend};
pub use district_polygons::{DistrictFile, parse_districts, read_districts};
pub use error::SourceError;
pub use geojson_streets::{GeoJsonFrame, parse_geojson_streets, read_geojson_streets};
pub(crate) use import::import_id;
pub use import::{ImportLog, ImportOptions, RefusedStreet, into_graph, lay_streets};
pub use imported::{ImportedStreet, StreetFile, class_of, class_width, file_key};
pub(crate) use maps::has_legend;
pub use maps::{
    KNOWN_MAPS, MAX_MAP_SIDE, MapOptions, flat_site, load_map, load_site, load_site_with, map_names, map_size,
};
pub use osm::{parse_osm_pbf, parse_osm_xml, read_osm};
pub use pixels::PixelMap;
pub(crate) use pixels::floor_of;
pub use projection::{Frame, Projection, ProjectionError};
pub use suggest::nearest_names;
