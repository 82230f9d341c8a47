//! Declared parameters with their present values.

use super::{Literal, Param, Value};
use crate::names::hint;
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
}

impl ParamSet {
    /// All at their defaults.
    pub(crate) fn new(declared: Vec<Param>) -> Self {
        let values: Vec<Value> = declared.iter().map(|param| param.default.clone().into()).collect();
        Self::of(declared.into(), values)
    }

    fn of(declared: Arc<[Param]>, values: Vec<Value>) -> Self {
        let ready = Params(values.iter().map(|value| value.constant().to_dynamic()).collect());
        Self { declared, values: values.into(), ready }
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
        self.with_read(name, |param| param.domain.check(literal))
    }

    /// A copy with one parameter read from text, as behind `--set`.
    pub fn with_text(&self, name: &str, text: &str) -> Result<Self, ParamError> {
        self.with_read(name, |param| param.domain.read_text(text))
    }

    /// A copy with one parameter set by a script.
    pub(crate) fn with_dynamic(&self, name: &str, value: &Dynamic) -> Result<Self, ParamError> {
        self.with_read(name, |param| param.domain.read_dynamic(value))
    }

    fn with_read(
        &self,
        name: &str,
        read: impl FnOnce(&Param) -> Result<Literal, super::literal::Misfit>,
    ) -> Result<Self, ParamError> {
        let names = self.declared.iter().map(|param| param.name.as_str());
        let Some(at) = names.clone().position(|declared| declared == name) else {
            return Err(ParamError { message: format!("there is no parameter `{name}`"), hint: hint(name, names) });
        };
        let literal = read(&self.declared[at])
            .map_err(|(message, hint)| ParamError { message: format!("`{name}` {message}"), hint })?;
        let mut values = self.values.to_vec();
        values[at] = literal.into();
        Ok(Self::of(self.declared.clone(), values))
    }

    /// What a script gets as `p`.
    pub(crate) fn ready(&self) -> Params {
        self.ready.clone()
    }
}

/// `p`: the values of a rule's parameters, by the position of their declaration.
#[derive(Clone, Debug)]
pub(crate) struct Params(Arc<[Dynamic]>);

impl Params {
    /// Gives an engine the getters for the parameters of its rule: `p` then costs one count of a reference to copy, where a
    /// map would be copied entry by entry.
    pub fn register(engine: &mut Engine, declared: &[Param]) {
        engine.register_type_with_name::<Self>("p");
        for (at, param) in declared.iter().enumerate() {
            engine.register_get(&param.name, move |p: &mut Self| p.0.get(at).cloned().unwrap_or_default());
        }
    }
}
