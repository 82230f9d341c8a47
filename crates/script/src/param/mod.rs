//! Parameters: what a rule declares, what a person gives, what the rule receives.

mod declare;
mod literal;
mod places;
mod set;
mod value;

pub(crate) use declare::{Declaration, Declared, misplaced, register};
pub use literal::Literal;
pub(crate) use literal::Misfit;
pub(crate) use literal::colour;
pub use places::Places;
pub(crate) use places::unknown_district;
pub(crate) use set::Params;
pub use set::{ParamError, ParamSet};
pub(crate) use value::{ByDistrict, register as register_values};
pub use value::{DistrictValues, MapValue, Value};

/// What a parameter may be.
#[derive(Clone, Debug, PartialEq)]
pub enum Domain {
    /// A number in a unit.
    Number {
        /// The unit it arrives in.
        unit: Unit,
        /// Least and greatest value.
        range: (f64, f64),
    },
    /// A whole number.
    Whole {
        /// Least and greatest value.
        range: (i64, i64),
    },
    /// One of some words.
    Choice(Vec<String>),
    /// Yes or no.
    Flag,
    /// The name of a map of the site.
    Map,
    /// A colour, `#rrggbb`.
    Colour,
}

/// What a number counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Counter-clockwise from east.
    Degrees,
    /// Metres.
    Metres,
    /// A share: 0.12 is 12 %.
    Ratio,
    /// Nothing in particular.
    Plain,
}

impl Unit {
    /// What is written behind a number: ` m`, `°` or nothing.
    pub fn suffix(self) -> &'static str {
        match self {
            Self::Degrees => "°",
            Self::Metres => " m",
            Self::Ratio | Self::Plain => "",
        }
    }
}

/// A declared parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// Its name.
    pub name: String,
    /// What it may be.
    pub domain: Domain,
    /// What it is when nobody says otherwise.
    pub default: Literal,
    /// What it does, in one line for panels.
    pub about: String,
}

impl Param {
    /// A number of any size.
    pub(crate) fn plain() -> Self {
        Self::number("", Unit::Plain, (f64::NEG_INFINITY, f64::INFINITY))
    }

    /// A number in a range that is 0 or, where 0 is none of it, the least of it unless told.
    pub(crate) fn number(name: &str, unit: Unit, range: (f64, f64)) -> Self {
        let default = Literal::Number(0.0_f64.max(range.0).min(range.1));
        Self { name: name.to_owned(), domain: Domain::Number { unit, range }, default, about: String::new() }
    }
}
