//! Maps of options: `#{ width: 30 }`, every key known, every value checked.

use super::numbers::differs;
use crate::fault::Complaint;
use crate::host::{kind_of, numeric};
use crate::names::hint;
use crate::param::{Param, Unit, Value};
use geom::Vec2;
use rhai::{Array, Dynamic, Map, Variant};

/// What is said of a value by place where one value must hold everywhere.
const EVERYWHERE: &str =
    "give it one value, no map and no by_district(…); the value of a parameter of constraints may differ by district";

/// The options given to a word.
pub(crate) struct Options {
    what: &'static str,
    map: Map,
}

impl Options {
    /// Takes options; keys that the word does not know are refused.
    pub fn new(what: &'static str, map: Map, known: &[&'static str]) -> Result<Self, Complaint> {
        if let Some(key) = map.keys().find(|key| !known.contains(&key.as_str())) {
            let message = format!("{what} has no option `{key}`");
            return Err(Complaint::new(message).maybe_hint(hint(key, known.iter().copied())).key(key.as_str()));
        }
        Ok(Self { what, map })
    }

    /// An option as it is; none where it is not given.
    pub fn take(&mut self, key: &str) -> Option<Dynamic> {
        self.map.remove(key)
    }

    /// Whether an option is given.
    pub fn has(&self, key: &str) -> bool {
        self.map.contains_key(key)
    }

    /// An option that must be given.
    pub fn need(&mut self, key: &str) -> Result<Dynamic, Complaint> {
        let what = self.what;
        self.take(key).ok_or_else(|| Complaint::new(format!("{what} needs `{key}: …`")))
    }

    /// A finite number.
    pub fn number(&mut self, key: &str) -> Result<Option<f64>, Complaint> {
        let value = self.take(key);
        value.map(|value| numeric(&format!("`{key}`"), &value).map_err(|c| c.key(key))).transpose()
    }

    /// A number in a range.
    pub fn within(&mut self, key: &str, low: f64, high: f64, unit: &str) -> Result<Option<f64>, Complaint> {
        let value = self.take(key);
        let read = |value: Dynamic| {
            let everywhere = differs(&value).then(|| EVERYWHERE.to_owned());
            let number = super::within(&format!("`{key}`"), &value, low, high, unit);
            number.map_err(|wrong| if everywhere.is_some() { wrong.maybe_hint(everywhere) } else { wrong }.key(key))
        };
        value.map(read).transpose()
    }

    /// A number in a range that may differ by place.
    pub fn by_place(&mut self, key: &str, low: f64, high: f64) -> Result<Option<Value>, Complaint> {
        let param = Param::number(key, Unit::Plain, (low, high));
        let read = |value: Dynamic| param.domain.read_value(&value, &param.default);
        let told = |(message, help)| Complaint::new(format!("`{key}` {message}")).maybe_hint(help).key(key);
        self.take(key).map(|value| read(value).map_err(told)).transpose()
    }

    /// A value of a type that has a name in words.
    pub fn of<T: Variant + Clone>(&mut self, key: &str, kind: &str) -> Result<Option<T>, Complaint> {
        self.take(key).map(|value| cast(value, key, kind)).transpose()
    }

    /// Yes or no.
    pub fn flag(&mut self, key: &str) -> Result<Option<bool>, Complaint> {
        self.of::<bool>(key, "true or false")
    }

    /// A text.
    pub fn text(&mut self, key: &str) -> Result<Option<String>, Complaint> {
        let value = self.take(key);
        value.map(|value| text(value, key)).transpose()
    }

    /// A list.
    pub fn list(&mut self, key: &str) -> Result<Array, Complaint> {
        Ok(self.of::<Array>(key, "a list […]")?.unwrap_or_default())
    }

    /// A map.
    pub fn map(&mut self, key: &str) -> Result<Map, Complaint> {
        Ok(self.of::<Map>(key, "a map #{ … }")?.unwrap_or_default())
    }

    /// A seed: a whole number from 0.
    pub fn seed(&mut self) -> Result<Option<u64>, Complaint> {
        let value = self.take("seed");
        value.map(|value| seed(&value)).transpose()
    }

    /// A place in metres, `[x, y]`.
    pub fn place(&mut self, key: &str) -> Result<Option<Vec2>, Complaint> {
        let value = self.take(key);
        value.map(|value| pair(value).map_err(|c| c.key(key))).transpose()
    }

    /// Two lengths in metres, `[width, height]`.
    pub fn size(&mut self, key: &str) -> Result<Option<Vec2>, Complaint> {
        let value = self.take(key);
        value.map(|value| size(value).map_err(|c| c.key(key))).transpose()
    }
}

/// An option that is one of a few words.
pub(crate) fn word<T: Copy>(options: &mut Options, key: &str, words: &[(&str, T)]) -> Result<Option<T>, Complaint> {
    let Some(text) = options.text(key)? else { return Ok(None) };
    let names: Vec<&str> = words.iter().map(|(name, _)| *name).collect();
    let wrong = || {
        let message = format!("`{key}` must be one of {}, not `{text}`", crate::names::listed(&names));
        Complaint::new(message).maybe_hint(hint(&text, names.iter().copied())).key(key)
    };
    words.iter().find(|(name, _)| *name == text).map(|(_, value)| Some(*value)).ok_or_else(wrong)
}

/// A value of a type.
pub(crate) fn cast<T: Variant + Clone>(value: Dynamic, key: &str, kind: &str) -> Result<T, Complaint> {
    let given = kind_of(&value);
    let quoted = (value.is_string() && kind != "a text").then(|| "numbers, true and false stand without quotes".into());
    let is_bare_rule = kind == "streets(…)" && given == "a rule";
    let bare = is_bare_rule.then(|| format!("write {key}: streets(#{{ pattern: rule(\"…\") }})"));
    let help = differs(&value).then(|| EVERYWHERE.to_owned()).or(quoted).or(bare);
    let wrong = || Complaint::new(format!("`{key}` must be {kind}, not {given}")).maybe_hint(help).key(key);
    value.try_cast::<T>().ok_or_else(wrong)
}

/// A text.
pub(crate) fn text(value: Dynamic, key: &str) -> Result<String, Complaint> {
    let everywhere = differs(&value).then(|| EVERYWHERE.to_owned());
    value.into_string().map_err(|_| Complaint::new(format!("`{key}` must be a text")).maybe_hint(everywhere).key(key))
}

fn seed(value: &Dynamic) -> Result<u64, Complaint> {
    let whole = value.as_int().ok().and_then(|whole| u64::try_from(whole).ok());
    whole.ok_or_else(|| Complaint::new("`seed` must be a whole number from 0").key("seed"))
}

/// `[x, y]` in metres.
pub(crate) fn pair(value: Dynamic) -> Result<Vec2, Complaint> {
    let wrong = || Complaint::new("a point is written [x, y] in metres");
    let list = value.into_array().map_err(|_| wrong())?;
    let [x, y] = <[Dynamic; 2]>::try_from(list).map_err(|_| wrong())?;
    Ok(Vec2::new(numeric("x", &x)?, numeric("y", &y)?))
}

fn size(value: Dynamic) -> Result<Vec2, Complaint> {
    let size = pair(value).map_err(|_| Complaint::new("a size is written [width, height] in metres"))?;
    let good = size.cmpgt(Vec2::ZERO).all() && geom::Point::try_from_metres(size).is_some();
    if good {
        Ok(size)
    } else {
        Err(Complaint::new("a size must be above 0 and below 500 km").hint("width and height in metres: [3000, 2000]"))
    }
}
