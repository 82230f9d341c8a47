//! The JSON file beside a map: how large it is, what its pixels mean, where it lies.

use super::error::{SourceError, read_bytes};
use geom::{Point, Vec2};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// What a sidecar may say. Anything else in it is for people.
#[derive(Clone, Debug, Default, Deserialize)]
pub(super) struct Sidecar {
    /// Width and height in metres.
    pub size_m: Option<[f64; 2]>,
    /// Metres per pixel.
    pub pixel_size_m: Option<f64>,
    /// What a pixel means.
    #[serde(default)]
    pub value: PixelValue,
    /// Coordinate reference system, e.g. `EPSG:32618`.
    pub crs: Option<String>,
    /// The rectangle in `crs`.
    pub bounds_crs_m: Option<CrsBounds>,
    /// Of a map of districts: the colour of each name.
    pub legend: Option<BTreeMap<String, String>>,
}

/// value = pixel × scale + offset.
#[derive(Clone, Debug, Deserialize)]
#[serde(default)]
pub(super) struct PixelValue {
    pub scale: f64,
    pub offset: f64,
    /// `mask` reads as 0 or 1; anything else is for people.
    pub units: String,
}

impl Default for PixelValue {
    fn default() -> Self {
        Self { scale: 1.0, offset: 0.0, units: String::new() }
    }
}

/// A rectangle in the coordinate reference system, metres.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub(super) struct CrsBounds {
    pub minx: f64,
    pub miny: f64,
    pub maxx: f64,
    pub maxy: f64,
}

impl CrsBounds {
    pub fn min(&self) -> Vec2 {
        Vec2::new(self.minx, self.miny)
    }

    pub fn size(&self) -> Vec2 {
        Vec2::new(self.maxx - self.minx, self.maxy - self.miny)
    }
}

/// How a map's pixels lie on the ground, checked.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Placement {
    /// Width and height in metres.
    pub size: Vec2,
    /// Metres per pixel.
    pub pixel_size: f64,
}

/// How far a size may miss whole square pixels, in pixels over the whole picture: room for sizes written with few
/// digits, none for pixels that are not square.
const SQUARE_SLACK: f64 = 0.1;

/// Values that a step of a pixel may stand for: outside, a slip of the pen.
const SCALES: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

const FORM: &str = "a sidecar is a JSON object such as {\"pixel_size_m\": 10}";

/// What a field of a sidecar must be.
type Kind = (&'static str, fn(&Value) -> bool);
const NUMBER: Kind = ("a number", Value::is_number);
const TEXT: Kind = ("a text", Value::is_string);
const OBJECT: Kind = ("an object", Value::is_object);
const SIZE: Kind = ("two numbers, [width, height]", |value| {
    value.as_array().is_some_and(|items| items.len() == 2 && items.iter().all(Value::is_number))
});
const TEXTS: Kind = ("names with colours, {\"harbour\": \"#2980b9\"}", |value| {
    value.as_object().is_some_and(|items| items.values().all(Value::is_string))
});

/// The fields that are read, and whether each may be absent or null.
const FIELDS: [(&str, Kind, bool); 13] = [
    ("/pixel_size_m", NUMBER, true),
    ("/size_m", SIZE, true),
    ("/value", OBJECT, false),
    ("/value/scale", NUMBER, false),
    ("/value/offset", NUMBER, false),
    ("/value/units", TEXT, false),
    ("/crs", TEXT, true),
    ("/bounds_crs_m", OBJECT, true),
    ("/bounds_crs_m/minx", NUMBER, false),
    ("/bounds_crs_m/miny", NUMBER, false),
    ("/bounds_crs_m/maxx", NUMBER, false),
    ("/bounds_crs_m/maxy", NUMBER, false),
    ("/legend", TEXTS, true),
];

/// Checks that each field is of its kind, and says which one is not, in the words of the file.
fn check_kinds(path: &Path, text: &str, says: &Value) -> Result<(), SourceError> {
    if !says.is_object() {
        return Err(SourceError::kind(path, format!("is {}, not a JSON object", told(says)), FORM.to_owned()));
    }
    for (field, (wanted, is_good), may_be_null) in FIELDS {
        match says.pointer(field) {
            Some(Value::Null) if may_be_null => {}
            Some(value) if !is_good(value) => {
                return Err(wrong(path, text, field, format!("must be {wanted}, not {}", told(value))));
            }
            _ => {}
        }
    }
    let missing = |field: &&&str| says.pointer(&format!("/bounds_crs_m/{field}")).is_none();
    match ["minx", "miny", "maxx", "maxy"].iter().find(missing) {
        Some(field) if says.get("bounds_crs_m").is_some_and(Value::is_object) => {
            Err(wrong(path, text, "/bounds_crs_m", format!("lacks `{field}`")))
        }
        _ => Ok(()),
    }
}

/// What is wrong with a field, at the place where its name stands.
fn wrong(path: &Path, text: &str, field: &str, what: String) -> SourceError {
    let name = field.trim_start_matches('/').replace('/', ".");
    let key = format!("\"{}\"", field.rsplit('/').next().unwrap_or(field));
    let before = text.find(&key).map_or("", |at| &text[..at]);
    SourceError::Syntax {
        path: path.to_owned(),
        line: before.matches('\n').count() + 1,
        column: before.rsplit('\n').next().unwrap_or("").chars().count() + 1,
        message: format!("`{name}` {what}"),
        hint: FORM.to_owned(),
    }
}

/// A value in few words.
fn told(value: &Value) -> String {
    let text = value.to_string();
    match value {
        Value::Array(_) => "a list".into(),
        Value::Object(_) => "an object".into(),
        Value::Null => "null".into(),
        Value::Bool(_) => text,
        Value::Number(_) => format!("the number {text}"),
        Value::String(_) => format!("the text {text}"),
    }
}

impl Sidecar {
    /// Reads a sidecar; `None` when there is no such file.
    pub fn read(path: &Path) -> Result<Option<Self>, SourceError> {
        if !path.exists() {
            return Ok(None);
        }
        let bytes = read_bytes(path)?;
        let json = |error: &serde_json::Error| SourceError::json(path, error, FORM);
        let says: Value = serde_json::from_slice(&bytes).map_err(|error| json(&error))?;
        check_kinds(path, &String::from_utf8_lossy(&bytes), &says)?;
        serde_json::from_value(says).map(Some).map_err(|error| json(&error))
    }

    /// Size and pixel size of a picture of `width` × `height` pixels; `path` is blamed for what does not fit.
    pub fn placement(&self, path: &Path, width: u32, height: u32) -> Result<Placement, SourceError> {
        let pixels = Vec2::new(f64::from(width), f64::from(height));
        let size = self.size(path, pixels)?;
        let pixel_size = size.x / pixels.x;
        check_square(path, size, pixels)?;
        check_lattice(path, size)?;
        self.check_crs_bounds(path, size, pixel_size)?;
        Ok(Placement { size, pixel_size })
    }

    /// Checks what the pixels mean.
    pub fn check_value(&self, path: &Path) -> Result<(), SourceError> {
        let scale = positive(path, "value.scale", self.value.scale)?;
        if !SCALES.contains(&scale) {
            let rule = format!("it must lie between {:e} and {:e}", SCALES.start(), SCALES.end());
            return Err(SourceError::value(path, "value.scale", scale, &rule));
        }
        if self.value.offset.is_finite() {
            return Ok(());
        }
        Err(SourceError::value(path, "value.offset", self.value.offset, "it must be a finite number"))
    }

    /// Whether pixels are read as 0 or 1.
    pub fn is_mask(&self) -> bool {
        self.value.units == "mask"
    }

    fn size(&self, path: &Path, pixels: Vec2) -> Result<Vec2, SourceError> {
        let by_pixel = self.pixel_size_m.map(|m| positive(path, "pixel_size_m", m).map(|m| pixels * m)).transpose()?;
        let Some([x, y]) = self.size_m else {
            return by_pixel.ok_or_else(|| {
                let hint = "write \"pixel_size_m\": 10 or \"size_m\": [13070, 22900] into it";
                SourceError::kind(path, "does not say how large the map is", hint.to_owned())
            });
        };
        let size = Vec2::new(positive(path, "size_m[0]", x)?, positive(path, "size_m[1]", y)?);
        match by_pixel {
            Some(other) if ((other - size) / (size / pixels)).abs().max_element() > SQUARE_SLACK => {
                let value = format!("[{x}, {y}], but {} × {} pixels of pixel_size_m", pixels.x, pixels.y);
                let rule = format!("they make [{}, {}]", other.x, other.y);
                Err(SourceError::value(path, "size_m", value, &rule))
            }
            _ => Ok(size),
        }
    }

    fn check_crs_bounds(&self, path: &Path, size: Vec2, pixel_size: f64) -> Result<(), SourceError> {
        let Some(bounds) = self.bounds_crs_m else { return Ok(()) };
        let slack = (bounds.size() - size).abs() / pixel_size;
        if bounds.min().is_finite() && slack.max_element() <= SQUARE_SLACK {
            return Ok(());
        }
        let value = format!("{} × {} m", bounds.size().x, bounds.size().y);
        let rule = format!("it must span the map's {} × {} m", size.x, size.y);
        Err(SourceError::value(path, "bounds_crs_m", value, &rule))
    }
}

fn check_square(path: &Path, size: Vec2, pixels: Vec2) -> Result<(), SourceError> {
    let pixel = size / pixels;
    // Written so that what is not a number fails too.
    if (pixel.x * pixels.y - size.y).abs() <= SQUARE_SLACK * pixel.min_element() {
        return Ok(());
    }
    let value = format!("[{}, {}]", size.x, size.y);
    let rule = format!(
        "{} × {} pixels would be {:.4} m wide and {:.4} m high, but pixels must be square",
        pixels.x, pixels.y, pixel.x, pixel.y
    );
    Err(SourceError::value(path, "size_m", value, &rule))
}

/// Refuses a map beyond the lattice, or one that is less than a lattice unit.
pub(super) fn check_lattice(path: &Path, size: Vec2) -> Result<(), SourceError> {
    let far = Point::try_from_metres(size);
    if far.is_some_and(|far| far.x > 0 && far.y > 0) {
        return Ok(());
    }
    let limit = f64::from(Point::LIMIT) / Point::UNITS_PER_METRE;
    let rule = format!("a map must measure between 1 mm and {:.0} km", (limit / 1000.0).floor());
    Err(SourceError::value(path, "the size", format!("{} × {} m", size.x, size.y), &rule))
}

fn positive(path: &Path, what: &str, value: f64) -> Result<f64, SourceError> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(SourceError::value(path, what, value, "it must be a finite number above 0"))
}
