//! Values by place, resolved on the maps and districts of a site.

use super::{Domain, Literal, MapValue, Misfit, Param, Value};
use crate::names::{hint, listed};
use geom::Vec2;
use rhai::Dynamic;
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::growth::{Field, Fit};
use streets::{Districts, PerDistrict};

/// What values by place are read from.
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// The maps of the site, by name.
    pub maps: BTreeMap<String, Field>,
    /// Its districts.
    pub districts: Arc<Districts>,
}

/// A value by place, ready to be asked.
#[derive(Clone, Debug)]
pub(super) enum Placed {
    Number(Field),
    Whole(Field),
    Other(PerDistrict<Dynamic>),
}

impl Placed {
    /// The value at a place in metres, as a script receives it.
    pub fn at(&self, place: Vec2) -> Dynamic {
        match self {
            Self::Number(field) => Dynamic::from_float(field.at(place)),
            Self::Whole(field) => Dynamic::from_int(field.at(place).round() as i64),
            Self::Other(values) => values.at(place).clone(),
        }
    }
}

impl Places {
    /// Whether a value can be read here, and lies in its range everywhere.
    pub(crate) fn check(&self, param: &Param, value: &Value) -> Result<(), Misfit> {
        match value {
            Value::Constant(_) => Ok(()),
            Value::Map(map) => self.check_map(param, map),
            Value::District(values) => {
                let names: Vec<&str> = self.districts.names().iter().map(String::as_str).collect();
                if let Some(unknown) = values.named.keys().find(|name| !names.contains(&name.as_str())) {
                    return Err(unknown_district(unknown, &names));
                }
                values.all().try_for_each(|value| self.check(param, value))
            }
        }
    }

    fn check_map(&self, param: &Param, value: &MapValue) -> Result<(), Misfit> {
        let name = &value.map.name;
        let Some(field) = self.fitted(value, Fit::NONE) else {
            let near = hint(name, self.maps.keys().map(String::as_str));
            return Err((format!("is read from a map `{name}`, which the site does not have"), near));
        };
        let (low, high) = field.range();
        let fits = |end: f64| match param.domain {
            Domain::Whole { .. } => param.domain.check(Literal::Whole(end.round() as i64)).is_ok(),
            _ => param.domain.check(Literal::Number(end)).is_ok(),
        };
        if fits(low) && fits(high) {
            return Ok(());
        }
        let message = format!("must be {}, but `{value}` goes from {low} to {high}", param.domain.wanted());
        let help = "spread a map of 0 to 1 over a range with .between(low, high), cut its values off with .clamp(low, high), \
                    or change them with .scale(factor, offset)";
        Err((message, Some(help.into())))
    }

    /// A number by place, whatever its range; it has been checked.
    pub fn number(&self, value: &Value) -> Field {
        self.field(&Param::plain(), value)
    }

    /// A map as a field of numbers, fitted once more.
    fn fitted(&self, value: &MapValue, limits: Fit) -> Option<Field> {
        let fit = value.fit.held(limits.low, limits.high);
        match self.maps.get(&value.map.name)? {
            Field::Map(raster) => Some(Field::Fitted(raster.clone(), fit)),
            Field::Constant(number) => Some(Field::Constant(fit.of(*number))),
            Field::Fitted(..) | Field::District(_) | Field::Raised(..) => None,
        }
    }

    /// A value that differs by place, ready to be asked; `None` for one that is the same everywhere.
    pub(super) fn resolve(&self, param: &Param, value: &Value) -> Option<Placed> {
        if value.constant().is_some() {
            return None;
        }
        match param.domain {
            Domain::Number { .. } => Some(Placed::Number(self.field(param, value))),
            Domain::Whole { .. } => Some(Placed::Whole(self.field(param, value))),
            _ => Some(Placed::Other(self.others(param, value)?)),
        }
    }

    /// A number by place. Rounding of a map's values never leads out of the range.
    pub(crate) fn field(&self, param: &Param, value: &Value) -> Field {
        let default = number(&param.default);
        match value {
            Value::Constant(literal) => Field::Constant(number(literal)),
            Value::Map(map) => self.fitted(map, limits(&param.domain)).unwrap_or(Field::Constant(default)),
            Value::District(values) => {
                let own = |name: &str| values.named.get(name).map(|value| self.field(param, value));
                let other = self.field(param, &values.other);
                Field::District(Arc::new(PerDistrict::new(self.districts.clone(), own, other)))
            }
        }
    }

    /// Values that are no numbers, by district.
    fn others(&self, param: &Param, value: &Value) -> Option<PerDistrict<Dynamic>> {
        let Value::District(values) = value else { return None };
        let ready = |value: &Value| value.constant().unwrap_or(&param.default).to_dynamic();
        let own = |name: &str| values.named.get(name).map(ready);
        Some(PerDistrict::new(self.districts.clone(), own, ready(&values.other)))
    }
}

/// The complaint about a district that is not there.
pub(crate) fn unknown_district(name: &str, known: &[&str]) -> Misfit {
    let message = format!("differs in `{name}`, but the city has no district of that name");
    let help = match known {
        [] => Some("tell the districts: city(#{ districts: site.districts(\"districts\", #{ … }), … })".into()),
        known => hint(name, known.iter().copied()).or_else(|| Some(format!("there are {}", listed(known)))),
    };
    (message, help)
}

fn number(literal: &Literal) -> f64 {
    match literal {
        Literal::Number(number) => *number,
        Literal::Whole(whole) => *whole as f64,
        _ => 0.0,
    }
}

fn limits(domain: &Domain) -> Fit {
    let (low, high) = match domain {
        Domain::Number { range, .. } => *range,
        Domain::Whole { range: (low, high) } => (*low as f64, *high as f64),
        _ => (f64::NEG_INFINITY, f64::INFINITY),
    };
    Fit { low, high, ..Fit::NONE }
}
