//! Districts from the polygons of a GeoJSON file.

use super::error::{SourceError, read_bytes};
use super::geojson_streets::{features_of, position_of, says_metres};
use super::projection::Frame;
use geom::{Bounds, Point, Polygon, boolean};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use streets::Districts;

/// What a file of districts holds.
#[derive(Clone, Debug, Default)]
pub struct DistrictFile {
    /// The districts, by name in alphabetical order.
    pub districts: Districts,
    /// What is wrong with it, but not so that it could not be read.
    pub warnings: Vec<String>,
}

/// Ground that two districts share is told from so many m² on; rounding alone makes less.
const TOLD_OVERLAP: f64 = 1.0;

/// Reads the Polygon and MultiPolygon features of a file, each with a `name`: several of one name are one district.
/// Coordinates are longitude and latitude, laid into `frame`, or local metres where the top level has
/// `"plat": {"units": "m"}`. What lies outside `bounds` is cut off; where districts overlap, the first one of the file
/// keeps the ground. Of Plat's own layouts the features of kind `district` are read.
///
/// # Errors
/// [`SourceError`] for what is not a FeatureCollection, has no district on the site, a feature without a name, or a
/// position that is none.
pub fn read_districts(path: &Path, frame: Option<Frame>, bounds: Bounds) -> Result<DistrictFile, SourceError> {
    parse_districts(path, &read_bytes(path)?, frame, bounds)
}

/// [`read_districts`] of bytes at hand; `path` only names them in errors.
///
/// # Errors
/// See [`read_districts`].
pub fn parse_districts(
    path: &Path,
    bytes: &[u8],
    frame: Option<Frame>,
    bounds: Bounds,
) -> Result<DistrictFile, SourceError> {
    let hint = "districts are a GeoJSON FeatureCollection of Polygons, each with a property `name`";
    let collection: Value = serde_json::from_slice(bytes).map_err(|error| SourceError::json(path, &error, hint))?;
    let features = features_of(path, &collection, hint)?;
    let metres = says_metres(&collection);
    if !metres && frame.is_none() {
        let hint = "give the site a crs in the sidecars of its maps, such as EPSG:32618, or write local metres with \
                    \"plat\": {\"units\": \"m\"} at the top of the file";
        return Err(SourceError::kind(
            path,
            "is in degrees, but where the site lies on Earth is not known",
            hint.into(),
        ));
    }
    let mut reader = Reader { path, frame: frame.filter(|_| !metres), bounds, parts: Vec::new(), warnings: Vec::new() };
    for (i, feature) in features.iter().enumerate() {
        reader.feature(i + 1, feature)?;
    }
    reader.finish()
}

/// One polygon of a district.
struct Part {
    name: String,
    bounds: Bounds,
    polygon: Polygon,
}

struct Reader<'a> {
    path: &'a Path,
    /// How degrees are laid; none for metres.
    frame: Option<Frame>,
    bounds: Bounds,
    parts: Vec<Part>,
    warnings: Vec<String>,
}

impl Reader<'_> {
    fn feature(&mut self, number: usize, feature: &Value) -> Result<(), SourceError> {
        let property = |key: &str| feature.get("properties").and_then(|properties| properties.get(key)?.as_str());
        if property("kind").is_some_and(|kind| kind != "district") {
            return Ok(());
        }
        let geometry = feature.get("geometry").unwrap_or(&Value::Null);
        let coordinates = geometry.get("coordinates").unwrap_or(&Value::Null);
        let polygons = match geometry.get("type").and_then(Value::as_str) {
            Some("Polygon") => vec![coordinates],
            Some("MultiPolygon") => coordinates.as_array().into_iter().flatten().collect(),
            other => {
                let kind = other.unwrap_or("none");
                self.warnings.push(format!("feature {number} is left out: its geometry is {kind}, not a Polygon"));
                return Ok(());
            }
        };
        let name = property("name").map(str::trim).filter(|name| !name.is_empty());
        let nameless = || SourceError::record(self.path, format!("feature {number}"), "has no property `name`");
        let name = name.ok_or_else(nameless)?.to_owned();
        for rings in polygons {
            let polygon = self.polygon(number, rings)?;
            self.add(number, &name, polygon);
        }
        Ok(())
    }

    /// The polygon of some rings, on the lattice.
    fn polygon(&self, number: usize, rings: &Value) -> Result<Polygon, SourceError> {
        let blame = |what: &str| SourceError::record(self.path, format!("feature {number}"), what);
        let rings = rings.as_array().ok_or_else(|| blame("has no list of rings"))?;
        let mut read = Vec::with_capacity(rings.len());
        let mut ordinal = 0;
        for ring in rings {
            let positions = ring.as_array().ok_or_else(|| blame("has no list of positions"))?;
            let mut points = Vec::with_capacity(positions.len());
            for position in positions {
                ordinal += 1;
                points.push(self.point(number, ordinal, position)?);
            }
            // GeoJSON closes its rings.
            if points.first() == points.last() {
                points.pop();
            }
            read.push(points);
        }
        let mut rings = read.into_iter();
        let outer = rings.next().ok_or_else(|| blame("has no ring"))?;
        Ok(Polygon::new(outer, rings.collect()))
    }

    fn point(&self, number: usize, ordinal: usize, position: &Value) -> Result<Point, SourceError> {
        let blame = |what| SourceError::record(self.path, format!("feature {number}, position {ordinal}"), what);
        let at = position_of(self.path, self.frame.is_none(), number, ordinal, position)?;
        let metres = match &self.frame {
            Some(frame) => frame.local(at.x, at.y).map_err(|error| blame(error.to_string()))?,
            None => at,
        };
        let far = || blame(format!("{metres} lies more than 524 km from the corner of the site"));
        Point::try_from_metres(metres).ok_or_else(far)
    }

    /// Takes what a polygon covers of the site and of no earlier district.
    fn add(&mut self, number: usize, name: &str, polygon: Polygon) {
        if polygon.outer.len() < 3 || !polygon.is_valid() {
            self.warnings
                .push(format!("feature {number}, `{name}`, crosses itself or has no area: mended as well as possible"));
        }
        let on_site = boolean::intersection(&[polygon], &[Polygon::rectangle(self.bounds)]);
        if on_site.is_empty() {
            self.warnings.push(format!("feature {number}, `{name}`, lies outside the site"));
            return;
        }
        for own in on_site {
            let Some(bounds) = own.bounds() else { continue };
            let near: Vec<&Part> = self.parts.iter().filter(|part| part.bounds.overlaps(&bounds)).collect();
            for part in near.iter().filter(|part| part.name != name) {
                let shared: f64 =
                    boolean::intersection(std::slice::from_ref(&own), std::slice::from_ref(&part.polygon))
                        .iter()
                        .map(Polygon::area)
                        .sum();
                if shared >= TOLD_OVERLAP {
                    let first = &part.name;
                    self.warnings.push(format!(
                        "feature {number}, `{name}`, overlaps `{first}` on {shared:.0} m²: the ground stays with `{first}`"
                    ));
                }
            }
            let taken: Vec<Polygon> = near.iter().map(|part| part.polygon.clone()).collect();
            let free = boolean::difference(&[own], &taken);
            self.parts.extend(
                free.into_iter()
                    .filter_map(|polygon| Some(Part { name: name.to_owned(), bounds: polygon.bounds()?, polygon })),
            );
        }
    }

    fn finish(self) -> Result<DistrictFile, SourceError> {
        let mut by_name: BTreeMap<String, Vec<Polygon>> = BTreeMap::new();
        for part in self.parts {
            by_name.entry(part.name).or_default().push(part.polygon);
        }
        if by_name.is_empty() {
            let reason = self.warnings.first().map_or(String::new(), |first| format!("; {first}"));
            let hint = "districts are Polygon features with a property `name`, in longitude and latitude or, with \
                        \"plat\": {\"units\": \"m\"} at the top of the file, in metres from the site's corner";
            return Err(SourceError::kind(self.path, format!("has no district on the site{reason}"), hint.into()));
        }
        let names: Vec<String> = by_name.keys().cloned().collect();
        let whole = |(at, parts): (usize, &Vec<Polygon>)| boolean::union(parts).into_iter().map(move |area| (at, area));
        let areas = by_name.values().enumerate().flat_map(whole).collect();
        Ok(DistrictFile { districts: Districts::of_areas(names, areas), warnings: self.warnings })
    }
}

#[cfg(test)]
mod tests;
