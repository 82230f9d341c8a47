//! Values of parameters that differ from place to place.

use super::{Literal, Misfit};
use crate::fault::{Complaint, Refusal};
use crate::host::numeric;
use crate::plan::MapRef;
use rhai::{Dynamic, Engine, FuncRegistration, Map};
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use streets::growth::Fit;

/// What a parameter is set to.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Value {
    /// The same everywhere.
    Constant(Literal),
    /// A number read from a map of the site.
    Map(MapValue),
    /// Another value in each district.
    District(Arc<DistrictValues>),
}

/// A number read from a map: its value at a place, fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct MapValue {
    /// The map.
    pub map: MapRef,
    /// From its values to the parameter's.
    pub fit: Fit,
}

/// Values by district.
#[derive(Clone, Debug, PartialEq)]
pub struct DistrictValues {
    /// By the district's name.
    pub named: BTreeMap<String, Value>,
    /// On all other ground.
    pub other: Value,
}

impl Value {
    /// The value in one district, or outside all of them: a constant or a map.
    pub(crate) fn in_district(&self, name: Option<&str>) -> &Self {
        match self {
            Self::District(values) => {
                name.and_then(|name| values.named.get(name)).unwrap_or(&values.other).in_district(name)
            }
            Self::Constant(_) | Self::Map(_) => self,
        }
    }

    /// The value where it is the same everywhere.
    pub fn constant(&self) -> Option<&Literal> {
        match self {
            Self::Constant(literal) => Some(literal),
            Self::Map(_) | Self::District(_) => None,
        }
    }

    /// Every plain value in it.
    pub(crate) fn constants(&self) -> Box<dyn Iterator<Item = &Literal> + '_> {
        match self {
            Self::Constant(literal) => Box::new(std::iter::once(literal)),
            Self::Map(_) => Box::new(std::iter::empty()),
            Self::District(values) => Box::new(values.all().flat_map(Self::constants)),
        }
    }

    /// The maps it is read from.
    pub fn maps(&self) -> Vec<&MapRef> {
        match self {
            Self::Constant(Literal::Map(map)) => vec![map],
            Self::Constant(_) => Vec::new(),
            Self::Map(value) => vec![&value.map],
            Self::District(values) => values.all().flat_map(Self::maps).collect(),
        }
    }

    /// The districts it names.
    pub fn districts(&self) -> Vec<&str> {
        match self {
            Self::Constant(_) | Self::Map(_) => Vec::new(),
            Self::District(values) => {
                let nested = values.all().flat_map(Self::districts);
                values.named.keys().map(String::as_str).chain(nested).collect()
            }
        }
    }
}

impl DistrictValues {
    /// All values: those of districts by name, then the other.
    pub fn all(&self) -> impl Iterator<Item = &Value> {
        self.named.values().chain([&self.other])
    }
}

impl From<Literal> for Value {
    fn from(literal: Literal) -> Self {
        Self::Constant(literal)
    }
}

impl fmt::Display for Value {
    /// As people read it: `90`, `map width × 160 + 40`, `20 in old town, else -29`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Constant(literal) => literal.fmt(f),
            Self::Map(value) => value.fmt(f),
            Self::District(values) => {
                values.named.iter().try_for_each(|(name, value)| write!(f, "{value} in {name}, "))?;
                write!(f, "else {}", values.other)
            }
        }
    }
}

impl fmt::Display for MapValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Fit { scale, offset, low, high } = self.fit;
        write!(f, "map {}", self.map.name)?;
        if (scale, offset) != (1.0, 0.0) {
            write!(f, " × {scale} + {offset}")?;
        }
        if low.is_finite() || high.is_finite() { write!(f, " held between {low} and {high}") } else { Ok(()) }
    }
}

/// `by_district(#{ … }, other)`: values or rules by the name of their district.
#[derive(Clone, Debug)]
pub(crate) struct ByDistrict {
    pub named: BTreeMap<String, Dynamic>,
    pub other: Option<Dynamic>,
}

impl ByDistrict {
    /// Every value read alike; `other` takes the place of one that is not given.
    pub fn read<T>(
        &self,
        read: impl Fn(&Dynamic) -> Result<T, Misfit>,
        other: impl FnOnce() -> T,
    ) -> Result<(BTreeMap<String, T>, T), Misfit> {
        let told = |name: &str, (message, help): Misfit| (format!("{message} (in `{name}`)"), help);
        let named = self.named.iter().map(|(name, value)| {
            let value = read(value).map_err(|misfit| told(name, misfit))?;
            Ok::<_, Misfit>((name.clone(), value))
        });
        let named = named.collect::<Result<_, _>>()?;
        let other = self
            .other
            .as_ref()
            .map_or_else(|| Ok(other()), |value| read(value).map_err(|wrong| told("all else", wrong)))?;
        Ok((named, other))
    }
}

/// Gives an engine the words that make values by place: `by_district`, and what fits a map's values.
pub(crate) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<ByDistrict>("by_district(…)").register_type_with_name::<MapValue>("a fitted map");
    FuncRegistration::new("by_district")
        .with_params_info(["#{ district: value }", "other"])
        .with_comments(["/// A value for each district, and another for all other ground."])
        .register_into_engine(engine, |named: Map, other: Dynamic| Ok::<_, Refusal>(by_district(named, Some(other))?));
    FuncRegistration::new("by_district")
        .with_params_info(["#{ district: value }"])
        .with_comments(["/// The same; all other ground keeps the parameter's default."])
        .register_into_engine(engine, |named: Map| Ok::<_, Refusal>(by_district(named, None)?));
    fits(engine);
}

fn by_district(named: Map, other: Option<Dynamic>) -> Result<ByDistrict, Complaint> {
    if named.is_empty() {
        return Err(Complaint::new("by_district names no district").hint("by_district(#{ harbour: 20 }, 10)"));
    }
    Ok(ByDistrict { named: named.into_iter().map(|(name, value)| (name.into(), value)).collect(), other })
}

fn fits(engine: &mut Engine) {
    fit(
        engine,
        "scale",
        ["this", "factor", "offset"],
        "The map's value times `factor`, plus `offset`.",
        |fit, factor, offset| Ok(fit.scaled(factor, offset)),
    );
    fit(
        engine,
        "between",
        ["this", "low", "high"],
        "A map of 0 to 1 spread from `low` to `high`.",
        |fit, low, high| Ok(fit.held(0.0, 1.0).scaled(high - low, low)),
    );
    fit(
        engine,
        "clamp",
        ["this", "low", "high"],
        "The map's value, held between `low` and `high`.",
        |fit, low, high| {
            let message = "the range runs from high to low";
            if low > high {
                Err(Complaint::new(message).hint("write .clamp(low, high)"))
            } else {
                Ok(fit.held(low, high))
            }
        },
    );
    let scale = |value: MapValue, factor: &Dynamic| -> Result<MapValue, Refusal> {
        Ok(MapValue { fit: value.fit.scaled(numeric("the factor", factor)?, 0.0), ..value })
    };
    FuncRegistration::new("scale")
        .with_params_info(["this", "factor"])
        .register_into_engine(engine, move |map: &mut MapRef, factor: Dynamic| scale(plain(map), &factor));
    FuncRegistration::new("scale")
        .with_params_info(["this", "factor"])
        .register_into_engine(engine, move |value: &mut MapValue, factor: Dynamic| scale(value.clone(), &factor));
}

/// A map's values as they are.
pub(crate) fn plain(map: &MapRef) -> MapValue {
    MapValue { map: map.clone(), fit: Fit::NONE }
}

/// Registers a word that fits the values of a map, plain or fitted already.
fn fit(
    engine: &mut Engine,
    name: &str,
    info: [&str; 3],
    doc: &str,
    change: fn(Fit, f64, f64) -> Result<Fit, Complaint>,
) {
    let (first, second) = (format!("`{}`", info[1]), format!("`{}`", info[2]));
    let fitted = move |value: MapValue, a: &Dynamic, b: &Dynamic| -> Result<MapValue, Refusal> {
        Ok(MapValue { fit: change(value.fit, numeric(&first, a)?, numeric(&second, b)?)?, ..value })
    };
    let other = fitted.clone();
    FuncRegistration::new(name)
        .with_params_info(info)
        .with_comments([format!("/// {doc}")])
        .register_into_engine(engine, move |map: &mut MapRef, a: Dynamic, b: Dynamic| fitted(plain(map), &a, &b));
    FuncRegistration::new(name)
        .with_params_info(info)
        .register_into_engine(engine, move |value: &mut MapValue, a: Dynamic, b: Dynamic| other(value.clone(), &a, &b));
}
