//! Numbers that a constraint is told: one for everywhere, or one that differs by place.

use super::options::Options;
use super::within;
use crate::fault::Complaint;
use crate::param::{ByDistrict, MapValue, Param, Places, Unit, Value};
use crate::plan::MapRef;
use rhai::Dynamic;
use streets::growth::{Quantity, Varying};

/// Where a number lies, and what it counts.
#[derive(Clone, Copy)]
pub(super) struct Range {
    pub low: f64,
    pub high: f64,
    /// Unit behind it: ` m`, `°` or nothing.
    pub unit: &'static str,
}

impl Range {
    pub const fn of(low: f64, high: f64, unit: &'static str) -> Self {
        Self { low, high, unit }
    }
}

/// A number of a step that differs by place.
#[derive(Clone, Debug)]
pub(super) struct Differing {
    quantities: Vec<Quantity>,
    param: Param,
    value: Value,
}

impl Differing {
    /// Read from a site.
    pub fn on(&self, places: &Places) -> Result<Vec<Varying>, Complaint> {
        let what = &self.param.name;
        let wrong = |(message, hint)| Complaint::new(format!("{what} {message}")).maybe_hint(hint);
        places.check(&self.param, &self.value).map_err(wrong)?;
        let values = places.field(&self.param, &self.value);
        Ok(self.quantities.iter().map(|&quantity| Varying { quantity, values: values.clone() }).collect())
    }
}

/// Reads the numbers of a step, and keeps those that differ by place.
#[derive(Default)]
pub(super) struct Numbers(pub Vec<Differing>);

impl Numbers {
    /// A number; one that differs by place stands for some number of its range, and is kept.
    pub fn read(
        &mut self,
        what: &str,
        value: &Dynamic,
        range: Range,
        quantities: &[Quantity],
    ) -> Result<f64, Complaint> {
        if !differs(value) {
            return within(what, value, range.low, range.high, range.unit);
        }
        let param = Param::number(what, Unit::Plain, (range.low, range.high));
        let wrong = |(message, hint)| Complaint::new(format!("{what} {message}")).maybe_hint(hint);
        let value = param.domain.read_value(value, &param.default).map_err(wrong)?;
        value.constants().try_for_each(|constant| param.domain.check(constant.clone()).map(|_| ())).map_err(wrong)?;
        self.0.push(Differing { quantities: quantities.to_vec(), param, value });
        Ok(1.0_f64.max(range.low).min(range.high))
    }

    /// An option, where it is given.
    pub fn option(
        &mut self,
        options: &mut Options,
        key: &str,
        range: Range,
        quantities: &[Quantity],
    ) -> Result<Option<f64>, Complaint> {
        let value = options.take(key);
        let read = |value: Dynamic| self.read(&format!("`{key}`"), &value, range, quantities);
        value.map(read).transpose().map_err(|wrong| wrong.key(key))
    }

    /// Whether a number differs by place.
    pub fn has(&self, quantity: Quantity) -> bool {
        self.0.iter().any(|differing| differing.quantities.contains(&quantity))
    }
}

/// Whether a value differs by place.
pub(super) fn differs(value: &Dynamic) -> bool {
    value.is::<Value>() || value.is::<ByDistrict>() || value.is::<MapRef>() || value.is::<MapValue>()
}
