//! Parameters: what a rule declares, what a person gives, what the rule receives.

mod declare;
mod literal;
mod set;

pub(crate) use declare::{Declared, register};
pub use literal::Literal;
pub(crate) use literal::colour;
pub(crate) use set::Params;
pub use set::{ParamError, ParamSet};

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

/// What a parameter is set to.
///
/// Today the same everywhere; a value by map, district or quarter is to become another variant.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Value {
    /// The same everywhere.
    Constant(Literal),
}

impl Value {
    /// The value where it is the same everywhere.
    pub fn constant(&self) -> &Literal {
        match self {
            Self::Constant(literal) => literal,
        }
    }
}

impl From<Literal> for Value {
    fn from(literal: Literal) -> Self {
        Self::Constant(literal)
    }
}
