//! Reading `layout.geojson` back, forgiving about what a file may get wrong: a property of the wrong type is read as
//! missing, so that [`crate::validate`] can say which feature lacks what. Only text that is no GeoJSON is an error.

use serde::Deserialize;
use serde::de::{self, Deserializer, MapAccess, SeqAccess, Visitor};
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

/// Why a layout could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file could not be opened or read.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The text is not the JSON that a layout is made of.
    #[error("{path}:{line}:{column}: {message}", path = path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1; 0 where the whole line is meant.
        column: usize,
        /// What is wrong.
        message: String,
    },
    /// It is JSON, but not a layout.
    #[error("{path}: {message}", path = path.display())]
    NotALayout {
        /// The file.
        path: PathBuf,
        /// What is missing.
        message: String,
    },
}

/// A layout as its file has it.
#[derive(Clone, Debug, Default)]
pub struct LayoutFile {
    /// What the `plat` member says, if there is one.
    pub about: Option<About>,
    /// The features in file order.
    pub features: Vec<Feature>,
}

/// The `plat` member of a layout: where it comes from.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
pub struct About {
    /// Version of the format.
    #[serde(default)]
    pub format: Option<u32>,
    /// Seed, in decimal.
    #[serde(default)]
    pub seed: Option<String>,
    /// Unit of the coordinates: `m`.
    #[serde(default)]
    pub units: Option<String>,
    /// Coordinate reference system, where known.
    #[serde(default)]
    pub crs: Option<String>,
    /// Where (0, 0) lies in `crs`, where known.
    #[serde(default)]
    pub origin: Option<[f64; 2]>,
}

/// One feature: what it says of itself and where it lies.
#[derive(Clone, Debug, Deserialize)]
pub struct Feature {
    /// What it says of itself.
    #[serde(default)]
    pub properties: Properties,
    /// Where it lies.
    #[serde(default)]
    pub geometry: Geometry,
}

/// The properties that the contract speaks of; what is absent or of the wrong type is `None`.
#[derive(Clone, Debug, Default)]
pub struct Properties {
    /// `street`, `crossing`, …
    pub kind: Option<String>,
    /// Unique within its kind; numbers are read as their text.
    pub id: Option<String>,
    /// The name id of the street a run belongs to.
    pub street: Option<String>,
    /// Street class.
    pub class: Option<String>,
    /// Right-of-way in metres.
    pub width: Option<f64>,
    /// Crossing where a street starts.
    pub from: Option<String>,
    /// Crossing where a street ends.
    pub to: Option<String>,
    /// Level of a street, 0 where it does not say.
    pub level: f64,
    /// Whether it says that it is a bridge.
    pub bridge: bool,
    /// Whether it says that it is a tunnel.
    pub tunnel: bool,
    /// How many streets meet at a crossing.
    pub degree: Option<f64>,
    /// The block of a parcel.
    pub block: Option<String>,
    /// The streets a parcel fronts.
    pub access: Option<Vec<String>>,
    /// What a parcel is for.
    pub usage: Option<String>,
    /// Whether its tags say that it is an inner parcel, which needs no access.
    pub inner: bool,
    /// Its tags.
    pub tags: Vec<String>,
    /// The parcel of a building.
    pub parcel: Option<String>,
    /// Height of a building in metres.
    pub height: Option<f64>,
    /// The rule that laid a street or decided on a building.
    pub rule: Option<String>,
}

/// Where a feature lies, in metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Geometry {
    /// None, or nothing that could be understood; the type it names.
    #[default]
    Nothing,
    /// A geometry of another type than a layout has.
    Other(String),
    /// One position.
    Point([f64; 2]),
    /// A chain of positions.
    LineString(Vec<[f64; 2]>),
    /// Outer ring and holes, as closed as the file has them.
    Polygon(Vec<Vec<[f64; 2]>>),
}

impl Geometry {
    /// The GeoJSON type.
    pub fn name(&self) -> &str {
        match self {
            Self::Nothing => "nothing",
            Self::Other(name) => name,
            Self::Point(_) => "Point",
            Self::LineString(_) => "LineString",
            Self::Polygon(_) => "Polygon",
        }
    }
}

/// Reads a layout.
///
/// # Errors
/// When the file can't be read, is no JSON, or is no feature collection.
pub fn read_layout(path: &Path) -> Result<LayoutFile, ReadError> {
    let bytes = fs::read(path).map_err(|source| ReadError::Io { path: path.into(), source })?;
    parse_layout(&bytes, path)
}

/// Reads a layout from the bytes of a file; `path` is for messages only.
///
/// # Errors
/// When the bytes are no JSON or no feature collection.
pub fn parse_layout(bytes: &[u8], path: &Path) -> Result<LayoutFile, ReadError> {
    let raw: Collection = serde_json::from_slice(bytes).map_err(|error| syntax(path, &error))?;
    let problem = |message: String| ReadError::NotALayout { path: path.into(), message };
    if raw.type_name.as_deref() != Some("FeatureCollection") {
        return Err(problem("not a GeoJSON FeatureCollection".into()));
    }
    let features = raw.features.ok_or_else(|| problem("the collection has no \"features\"".into()))?;
    if let Some(n) = features.iter().position(|feature| feature.properties.kind.is_none()) {
        return Err(problem(format!("feature {n} has no \"kind\" property")));
    }
    Ok(LayoutFile { about: raw.plat, features })
}

fn syntax(path: &Path, error: &serde_json::Error) -> ReadError {
    let text = error.to_string();
    let message = text.split(" at line ").next().unwrap_or(&text).to_owned();
    ReadError::Syntax { path: path.into(), line: error.line(), column: error.column(), message }
}

/// The top level as it is written.
#[derive(Deserialize)]
struct Collection {
    #[serde(rename = "type", default)]
    type_name: Option<String>,
    #[serde(default)]
    plat: Option<About>,
    #[serde(default)]
    features: Option<Vec<Feature>>,
}

/// A property value of any type, kept as far as a layout may need it.
enum Value {
    Text(String),
    Number(f64),
    Flag(bool),
    Texts(Vec<String>),
    /// The keys of a map whose values are true.
    Flags(Vec<String>),
    Nothing,
}

impl Value {
    fn text(self) -> Option<String> {
        if let Self::Text(text) = self { Some(text) } else { None }
    }

    /// A text, or the text of a number: ids of other programs are often numbers.
    fn id(self) -> Option<String> {
        match self {
            Self::Text(text) => Some(text),
            Self::Number(number) => Some(number.to_string()),
            _ => None,
        }
    }

    fn number(self) -> Option<f64> {
        if let Self::Number(number) = self { Some(number) } else { None }
    }

    /// Whether the value counts as said: true, a number but 0, a text but "".
    fn truth(self) -> bool {
        match self {
            Self::Flag(flag) => flag,
            Self::Number(number) => number != 0.0,
            Self::Text(text) => !text.is_empty(),
            Self::Texts(texts) | Self::Flags(texts) => !texts.is_empty(),
            Self::Nothing => false,
        }
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyValue)
    }
}

struct AnyValue;

impl<'de> Visitor<'de> for AnyValue {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("any value")
    }

    fn visit_bool<E>(self, flag: bool) -> Result<Value, E> {
        Ok(Value::Flag(flag))
    }

    fn visit_i64<E>(self, number: i64) -> Result<Value, E> {
        Ok(Value::Number(number as f64))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Value, E> {
        Ok(Value::Number(number as f64))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Value, E> {
        Ok(Value::Number(number))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(Value::Text(text.to_owned()))
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Nothing)
    }

    fn visit_none<E>(self) -> Result<Value, E> {
        Ok(Value::Nothing)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut texts = Vec::new();
        while let Some(item) = items.next_element::<Value>()? {
            texts.extend(item.id());
        }
        Ok(Value::Texts(texts))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        let mut flags = Vec::new();
        while let Some((key, value)) = map.next_entry::<String, Value>()? {
            flags.extend(value.truth().then_some(key));
        }
        Ok(Value::Flags(flags))
    }
}

impl<'de> Deserialize<'de> for Properties {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(AnyProperties)
    }
}

struct AnyProperties;

impl<'de> Visitor<'de> for AnyProperties {
    type Value = Properties;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the properties of a feature")
    }

    fn visit_unit<E>(self) -> Result<Properties, E> {
        Ok(Properties::default())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Properties, A::Error> {
        let mut properties = Properties::default();
        while let Some((key, value)) = map.next_entry::<String, Value>()? {
            properties.set(&key, value);
        }
        Ok(properties)
    }
}

impl Properties {
    fn set(&mut self, key: &str, value: Value) {
        match key {
            "kind" => self.kind = value.text(),
            "id" => self.id = value.id(),
            "street" => self.street = value.id(),
            "class" => self.class = value.text().filter(|class| !class.is_empty()),
            "width" => self.width = value.number(),
            "from" => self.from = value.id(),
            "to" => self.to = value.id(),
            "level" => self.level = value.number().unwrap_or(0.0),
            "bridge" => self.bridge = value.truth(),
            "tunnel" => self.tunnel = value.truth(),
            "degree" => self.degree = value.number(),
            "block" => self.block = value.id(),
            "access" => self.access = if let Value::Texts(texts) = value { Some(texts) } else { None },
            "use" => self.usage = value.text(),
            "tags" => {
                self.tags = if let Value::Flags(flags) = value { flags } else { Vec::new() };
                self.inner = self.tags.iter().any(|tag| tag == "inner");
            }
            "parcel" => self.parcel = value.id(),
            "height" => self.height = value.number(),
            "rule" => self.rule = value.text(),
            _ => {}
        }
    }
}

/// Coordinates of any depth.
enum Coordinates {
    Number(f64),
    Nested(Vec<Coordinates>),
}

impl<'de> Deserialize<'de> for Coordinates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Nest;
        impl<'de> Visitor<'de> for Nest {
            type Value = Coordinates;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("numbers in brackets")
            }
            fn visit_i64<E>(self, number: i64) -> Result<Coordinates, E> {
                Ok(Coordinates::Number(number as f64))
            }
            fn visit_u64<E>(self, number: u64) -> Result<Coordinates, E> {
                Ok(Coordinates::Number(number as f64))
            }
            fn visit_f64<E>(self, number: f64) -> Result<Coordinates, E> {
                Ok(Coordinates::Number(number))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Coordinates, A::Error> {
                let mut nested = Vec::with_capacity(items.size_hint().unwrap_or(2).max(2));
                while let Some(item) = items.next_element()? {
                    nested.push(item);
                }
                Ok(Coordinates::Nested(nested))
            }
        }
        deserializer.deserialize_any(Nest)
    }
}

impl Coordinates {
    fn position(&self) -> Option<[f64; 2]> {
        match self {
            Self::Nested(items) => match items[..] {
                [Self::Number(x), Self::Number(y), ..] => Some([x, y]),
                _ => None,
            },
            Self::Number(_) => None,
        }
    }

    fn chain(&self) -> Option<Vec<[f64; 2]>> {
        if let Self::Nested(items) = self { items.iter().map(Self::position).collect() } else { None }
    }

    fn rings(&self) -> Option<Vec<Vec<[f64; 2]>>> {
        if let Self::Nested(items) = self { items.iter().map(Self::chain).collect() } else { None }
    }
}

impl<'de> Deserialize<'de> for Geometry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct Raw {
            #[serde(rename = "type")]
            type_name: String,
            #[serde(default)]
            coordinates: Option<Coordinates>,
        }
        let Some(raw) = Option::<Raw>::deserialize(deserializer)? else { return Ok(Self::Nothing) };
        let coordinates = raw.coordinates.as_ref();
        let known = match raw.type_name.as_str() {
            "Point" => coordinates.and_then(Coordinates::position).map(Self::Point),
            "LineString" => coordinates.and_then(Coordinates::chain).map(Self::LineString),
            "Polygon" => coordinates.and_then(Coordinates::rings).map(Self::Polygon),
            _ => return Ok(Self::Other(raw.type_name)),
        };
        known.ok_or_else(|| de::Error::custom(format!("the coordinates are not those of a {}", raw.type_name)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<LayoutFile, ReadError> {
        parse_layout(text.as_bytes(), Path::new("x.geojson"))
    }

    #[test]
    fn a_syntax_error_names_line_and_column() {
        let error = parse("{\"type\": \"FeatureCollection\",\n \"features\": [}").unwrap_err();
        assert!(error.to_string().starts_with("x.geojson:2:15: "), "{error}");
    }

    #[test]
    fn coordinates_of_the_wrong_shape_are_refused_where_they_stand() {
        let bad = "{\"type\":\"FeatureCollection\",\"features\":[\n{\"properties\":{\"kind\":\"street\"},\
                   \"geometry\":{\"type\":\"LineString\",\"coordinates\":[1,2]}}]}";
        let error = parse(bad).unwrap_err();
        assert!(matches!(error, ReadError::Syntax { line: 2, .. }), "{error}");
    }

    #[test]
    fn what_is_no_layout_is_said_so() {
        assert!(parse("[]").is_err());
        assert!(parse("{}").unwrap_err().to_string().contains("FeatureCollection"));
        let nameless = "{\"type\":\"FeatureCollection\",\"features\":[{\"properties\":null,\"geometry\":null}]}";
        assert!(parse(nameless).unwrap_err().to_string().contains("feature 0 has no \"kind\""));
    }

    #[test]
    fn a_property_of_the_wrong_type_is_missing() {
        let text = "{\"type\":\"FeatureCollection\",\"features\":[{\"properties\":{\"kind\":\"street\",\"id\":7,\
                    \"width\":\"wide\",\"access\":[1,\"a\",null],\"tags\":{\"a\":[1]},\"bridge\":1},\"geometry\":null}]}";
        let p = &parse(text).unwrap().features[0].properties;
        assert_eq!((p.id.as_deref(), p.width, p.bridge), (Some("7"), None, true));
        assert_eq!(p.access.as_deref(), Some(&["1".to_owned(), "a".to_owned()][..]));
    }
}
