//! Declared parameters with their present values.

use super::places::Placed;
use super::{Literal, Misfit, Param, Places, Value};
use crate::names::hint;
use geom::Vec2;
use rhai::{Dynamic, Engine};
use std::sync::Arc;
use thiserror::Error;

/// Why a parameter cannot be set.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{message}")]
pub struct ParamError {
    /// What is wrong, with the parameter's name, range and unit.
    pub message: String,
    /// What to write instead.
    pub hint: Option<String>,
}

/// The parameters of a rule in the author's order, each with a value. Cheap to clone.
#[derive(Clone, Debug)]
pub struct ParamSet {
    declared: Arc<[Param]>,
    values: Arc<[Value]>,
    /// The values as scripts receive them, ready to be copied.
    ready: Params,
    /// What values by place are read from; they cannot be asked without.
    places: Option<Arc<Places>>,
}

impl ParamSet {
    /// All at their defaults.
    pub(crate) fn new(declared: Vec<Param>) -> Self {
        let values: Vec<Value> = declared.iter().map(|param| param.default.clone().into()).collect();
        Self::of(declared.into(), values.into(), None)
    }

    fn of(declared: Arc<[Param]>, values: Arc<[Value]>, places: Option<Arc<Places>>) -> Self {
        let ready = Params::of(&declared, &values, places.as_deref());
        Self { declared, values, ready, places }
    }

    /// Whether every value can be read on a site and lies in its range everywhere.
    pub(crate) fn check(&self, places: &Places) -> Result<(), ParamError> {
        self.iter().try_for_each(|(param, value)| {
            places.check(param, value).map_err(|(message, hint)| error(&param.name, &message, hint))
        })
    }

    /// The same, its values by place read from a site; they have been checked.
    #[must_use]
    pub(crate) fn on(&self, places: &Arc<Places>) -> Self {
        Self::of(self.declared.clone(), self.values.clone(), Some(places.clone()))
    }

    /// Every parameter with its value, in the author's order.
    pub fn iter(&self) -> impl Iterator<Item = (&Param, &Value)> {
        self.declared.iter().zip(self.values.iter())
    }

    /// The value of a parameter.
    pub fn get(&self, name: &str) -> Option<&Value> {
        self.iter().find(|(param, _)| param.name == name).map(|(_, value)| value)
    }

    /// A copy with one parameter set.
    pub fn with(&self, name: &str, literal: Literal) -> Result<Self, ParamError> {
        self.with_read(name, |param| param.domain.check(literal).map(Value::Constant))
    }

    /// A copy with one parameter set to a value that was read for it.
    pub(crate) fn with_value(&self, name: &str, value: Value) -> Result<Self, ParamError> {
        match value {
            Value::Constant(literal) => self.with(name, literal),
            value => self.with_read(name, |_| Ok(value)),
        }
    }

    /// A copy with one parameter read from text, as behind `--set`.
    pub fn with_text(&self, name: &str, text: &str) -> Result<Self, ParamError> {
        self.with_read(name, |param| param.domain.read_text(text).map(Value::Constant))
    }

    /// A copy with one parameter set by a script.
    pub(crate) fn with_dynamic(&self, name: &str, value: &Dynamic) -> Result<Self, ParamError> {
        self.with_read(name, |param| param.domain.read_value(value, &param.default))
    }

    fn with_read(&self, name: &str, read: impl FnOnce(&Param) -> Result<Value, Misfit>) -> Result<Self, ParamError> {
        let names = self.declared.iter().map(|param| param.name.as_str());
        let Some(at) = names.clone().position(|declared| declared == name) else {
            return Err(ParamError { message: format!("there is no parameter `{name}`"), hint: hint(name, names) });
        };
        let value = read(&self.declared[at]).map_err(|(message, hint)| error(name, &message, hint))?;
        let mut values = self.values.to_vec();
        values[at] = value;
        Ok(Self::of(self.declared.clone(), values.into(), self.places.clone()))
    }

    /// What values by place are read from, once the plan is settled.
    pub(crate) fn places(&self) -> Option<&Places> {
        self.places.as_deref()
    }

    /// The districts in which a value is another than elsewhere.
    pub(crate) fn districts(&self) -> impl Iterator<Item = &str> {
        self.values.iter().flat_map(Value::districts)
    }

    /// The same in one district, or outside all of them: no value differs by district any more.
    #[must_use]
    pub(crate) fn in_district(&self, name: Option<&str>) -> Self {
        let values = self.values.iter().map(|value| value.in_district(name).clone()).collect();
        Self::of(self.declared.clone(), values, self.places.clone())
    }

    /// What a script gets as `p`.
    pub(crate) fn ready(&self) -> Params {
        self.ready.clone()
    }
}

fn error(name: &str, message: &str, hint: Option<String>) -> ParamError {
    ParamError { message: format!("`{name}` {message}"), hint }
}

/// `p`: the values of a rule's parameters, by the position of their declaration.
#[derive(Clone, Debug)]
pub(crate) struct Params {
    /// Values that are the same everywhere; a value by place stands here as itself.
    ready: Arc<[Dynamic]>,
    /// Values by place, where there are any; found when they are read.
    placed: Option<Arc<[Option<Placed>]>>,
    /// Where the call happens, in metres.
    place: Vec2,
}

impl Params {
    fn of(declared: &[Param], values: &[Value], places: Option<&Places>) -> Self {
        let as_told = |value: &Value| match value {
            Value::Constant(literal) => literal.to_dynamic(),
            other => Dynamic::from(other.clone()),
        };
        let resolved = |places: &Places| -> Vec<Option<Placed>> {
            declared.iter().zip(values).map(|(param, value)| places.resolve(param, value)).collect()
        };
        let placed = places.map(resolved).filter(|placed| placed.iter().any(Option::is_some));
        Self { ready: values.iter().map(as_told).collect(), placed: placed.map(Into::into), place: Vec2::ZERO }
    }

    /// Whether any value differs by place.
    pub fn differ(&self) -> bool {
        self.placed.is_some()
    }

    /// For what is asked once for the whole city: a value by place arrives as itself, not as what it is somewhere.
    pub fn as_told(&self) -> Self {
        Self { placed: None, ..self.clone() }
    }

    /// The values at a place in metres.
    pub fn at(&self, place: Vec2) -> Self {
        Self { place, ..self.clone() }
    }

    /// A value that does not differ by place.
    pub fn everywhere(&self, position: usize) -> Option<Dynamic> {
        let is_placed = self.placed.as_ref().is_some_and(|placed| placed.get(position).is_some_and(Option::is_some));
        self.ready.get(position).filter(|_| !is_placed).cloned()
    }

    fn value(&self, position: usize) -> Dynamic {
        let placed = self.placed.as_ref().and_then(|placed| placed.get(position)?.as_ref());
        match placed {
            Some(placed) => placed.at(self.place),
            None => self.ready.get(position).cloned().unwrap_or_default(),
        }
    }

    /// Gives an engine the getters for the parameters of its rule: `p` then costs one count of a reference to copy, where a
    /// map would be copied entry by entry.
    pub fn register(engine: &mut Engine, declared: &[Param]) {
        engine.register_type_with_name::<Self>("p").register_type_with_name::<Value>("a value by place");
        for (position, param) in declared.iter().enumerate() {
            engine.register_get(&param.name, move |p: &mut Self| p.value(position));
        }
    }
}
