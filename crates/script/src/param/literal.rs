//! Plain values of parameters.

use super::value::plain;
use super::{ByDistrict, DistrictValues, Domain, MapValue, Param, Unit, Value};
use crate::host::number;
use crate::names::{hint, listed};
use crate::plan::MapRef;
use rhai::Dynamic;
use std::fmt;
use std::sync::Arc;

/// A plain value.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal {
    /// A number in the unit of its parameter.
    Number(f64),
    /// A whole number.
    Whole(i64),
    /// One of the words of a choice.
    Choice(String),
    /// Yes or no.
    Flag(bool),
    /// A map of the site, by name.
    Map(MapRef),
    /// Red, green, blue.
    Colour([u8; 3]),
}

impl Literal {
    /// The value as a script receives it.
    pub(crate) fn to_dynamic(&self) -> Dynamic {
        match self {
            Self::Number(number) => Dynamic::from_float(*number),
            Self::Whole(whole) => Dynamic::from_int(*whole),
            Self::Choice(word) => word.clone().into(),
            Self::Flag(flag) => Dynamic::from_bool(*flag),
            Self::Map(map) => Dynamic::from(map.clone()),
            Self::Colour(_) => self.to_string().into(),
        }
    }
}

impl fmt::Display for Literal {
    /// As it is written behind `--set name=`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(f, "{number}"),
            Self::Whole(whole) => write!(f, "{whole}"),
            Self::Choice(word) => write!(f, "{word}"),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Map(map) => write!(f, "{}", map.name),
            Self::Colour([r, g, b]) => write!(f, "#{r:02x}{g:02x}{b:02x}"),
        }
    }
}

/// Why a value does not fit a parameter: what is wrong, and a hint.
pub(crate) type Misfit = (String, Option<String>);

impl Domain {
    /// Reads a value that a city script gives: the same everywhere, from a map, or by district, where `default` is what
    /// holds on ground that nothing is said about.
    pub(crate) fn read_value(&self, value: &Dynamic, default: &Literal) -> Result<Value, Misfit> {
        if let Some(value) = value.read_lock::<Value>() {
            // A parameter of a rule that is asked once hands its value on.
            return Ok(value.clone());
        }
        if let Some(values) = value.read_lock::<ByDistrict>() {
            let read = |value: &Dynamic| self.read_value(value, default);
            let (named, other) = values.read(read, || default.clone().into())?;
            return Ok(Value::District(Arc::new(DistrictValues { named, other })));
        }
        if let Domain::Number { .. } | Domain::Whole { .. } = self {
            let map = value.read_lock::<MapRef>().map(|map| plain(&map));
            if let Some(map) = map.or_else(|| value.read_lock::<MapValue>().map(|map| map.clone())) {
                return Ok(Value::Map(map));
            }
        }
        self.read_dynamic(value).map(Value::Constant)
    }

    /// Reads a value that a script gives.
    fn read_dynamic(&self, value: &Dynamic) -> Result<Literal, Misfit> {
        let literal = match self {
            Self::Number { .. } => number(value).map(Literal::Number),
            Self::Whole { .. } => whole(value).map(Literal::Whole),
            Self::Flag => value.as_bool().ok().map(Literal::Flag),
            Self::Map if value.is::<MapRef>() => value.clone().try_cast().map(Literal::Map),
            Self::Choice(_) | Self::Map | Self::Colour => {
                value.as_immutable_string_ref().ok().and_then(|text| self.word(&text))
            }
        };
        let is_plain = matches!(self, Self::Number { .. } | Self::Whole { .. } | Self::Flag);
        let quoted = is_plain && value.is_string();
        let help = quoted.then(|| "numbers, true and false stand without quotes".to_owned());
        let wrong = || (format!("must be {}, not {}", self.wanted(), crate::host::kind_of(value)), help);
        self.check(literal.ok_or_else(wrong)?)
    }

    /// Reads a value as it is written behind `--set name=`.
    pub(super) fn read_text(&self, text: &str) -> Result<Literal, Misfit> {
        let text = text.trim();
        let literal = match self {
            Self::Number { .. } => text.parse().ok().map(Literal::Number),
            Self::Whole { .. } => text.parse().ok().map(Literal::Whole),
            Self::Flag => text.parse().ok().map(Literal::Flag),
            Self::Choice(_) | Self::Map | Self::Colour => self.word(text),
        };
        self.check(literal.ok_or_else(|| (format!("must be {}, not `{text}`", self.wanted()), None))?)
    }

    /// A text as a value; `None` where it cannot be one.
    fn word(&self, text: &str) -> Option<Literal> {
        match self {
            Self::Choice(_) => Some(Literal::Choice(text.to_owned())),
            Self::Map => Some(Literal::Map(MapRef { name: text.to_owned() })),
            Self::Colour => colour(text).map(Literal::Colour),
            _ => None,
        }
    }

    /// Holds a value against ranges and words.
    pub(crate) fn check(&self, literal: Literal) -> Result<Literal, Misfit> {
        // Whole numbers do wherever numbers do.
        let literal = match (self, literal) {
            (Self::Number { .. }, Literal::Whole(whole)) => Literal::Number(whole as f64),
            (_, literal) => literal,
        };
        let inside = match (self, &literal) {
            (Self::Number { range: (low, high), .. }, Literal::Number(x)) => x.is_finite() && low <= x && x <= high,
            (Self::Whole { range: (low, high) }, Literal::Whole(x)) => low <= x && x <= high,
            (Self::Choice(words), Literal::Choice(word)) => words.contains(word),
            (Self::Flag, Literal::Flag(_)) | (Self::Map, Literal::Map(_)) | (Self::Colour, Literal::Colour(_)) => true,
            _ => false,
        };
        if inside {
            return Ok(literal);
        }
        let near = match (self, &literal) {
            (Self::Choice(words), Literal::Choice(word)) => hint(word, words.iter().map(String::as_str)),
            (Self::Number { unit: Unit::Ratio, range }, Literal::Number(x)) if *x > 1.0 && x / 100.0 <= range.1 => {
                Some(format!("a ratio is a share of 1: {x} % is {}", x / 100.0))
            }
            (Self::Number { unit, range }, Literal::Number(x)) if !x.is_nan() => {
                let (end, which) = if *x < range.0 { (range.0, "least") } else { (range.1, "most") };
                end.is_finite().then(|| format!("{end}{} is the {which}", unit.suffix()))
            }
            (Self::Whole { range }, Literal::Whole(x)) => {
                let (end, which) = if *x < range.0 { (range.0, "least") } else { (range.1, "most") };
                Some(format!("{end} is the {which}"))
            }
            _ => None,
        };
        Err((format!("must be {}, not {literal}", self.wanted()), near))
    }

    /// What a person may write, in words.
    pub fn wanted(&self) -> String {
        match self {
            Self::Number { unit, range } if range.0.is_finite() || range.1.is_finite() => {
                format!("a number from {} to {}{}", range.0, range.1, unit.suffix())
            }
            Self::Number { .. } => "a finite number".into(),
            Self::Whole { range: (i64::MIN, i64::MAX) } => "a whole number".into(),
            Self::Whole { range: (low, high) } => format!("a whole number from {low} to {high}"),
            Self::Choice(words) => {
                format!("one of {}", listed(&words.iter().map(String::as_str).collect::<Vec<_>>()))
            }
            Self::Flag => "true or false".into(),
            Self::Map => "the name of a map".into(),
            Self::Colour => "a colour such as #c0ffee".into(),
        }
    }
}

impl Param {
    /// The default with its unit, and the range: for listings.
    pub fn describe(&self) -> String {
        let unit = if let Domain::Number { unit, .. } = &self.domain { unit.suffix() } else { "" };
        format!("{}{unit} ({})", self.default, self.domain.wanted())
    }
}

/// A whole number, also when written as `3.0`.
fn whole(value: &Dynamic) -> Option<i64> {
    let exact = |x: f64| (x == x.round() && x.abs() < 9e15).then_some(x as i64);
    value.as_int().ok().or_else(|| value.as_float().ok().and_then(exact))
}

/// `#rrggbb`.
pub(crate) fn colour(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.is_ascii())?;
    let part = |i: usize| u8::from_str_radix(digits.get(i..i + 2)?, 16).ok();
    Some([part(0)?, part(2)?, part(4)?])
}
