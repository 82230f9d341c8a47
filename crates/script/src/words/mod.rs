//! The words of the rule language: what `tip`, `block` and `shape` can be asked and told.

mod block;
mod chain;
mod ground;
pub(crate) mod marks;
mod numbers;
mod once;
pub(crate) mod options;
mod parcel;
mod segment;
mod shape;
mod tally;
mod tip;

pub use block::{BlockContext, ParcelChoice, ParcelPattern};
pub(crate) use chain::chain_of;
pub use ground::{BareGround, Ground, StreetSide};
pub use marks::Marked;
pub(crate) use once::{density, goal_of};
pub use parcel::{AssignPattern, Assigned};
pub use segment::{ConstraintPattern, REFUSES_EVERYTHING};
pub use shape::{BuildingChoice, BuildingPattern, ShapeContext};
pub use tip::{PROPOSES_NOTHING, StreetPattern};

use crate::fault::{Complaint, Refusal};
use crate::host::Handle;
use crate::plan::MapRef;
use geom::Seed;
use rhai::{Dynamic, Engine, FuncRegistration, RhaiNativeFunc};

/// Gives an engine all words that rules may use.
pub(crate) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<MapRef>("a map of the site");
    getter(engine, "name", "What the map is called.", |map: &mut MapRef| map.name.clone());
    tip::register(engine);
    block::register(engine);
    parcel::register(engine);
    shape::register(engine);
    once::register(engine);
    chain::register(engine);
    segment::register(engine);
    #[cfg(test)]
    engine.register_fn("fail_inside", || -> () { panic!("as the test wants") });
}

/// Registers a method of a handle: its name, the names of its arguments, what it does.
macro_rules! method {
    ($engine:expr, $name:literal ( $($argument:ident),* ) $doc:literal, $context:ty, $work:expr) => {
        rhai::FuncRegistration::new($name)
            .with_params_info(["this", $(stringify!($argument)),*])
            .with_comments([concat!("/// ", $doc)])
            .register_into_engine($engine, |this: &mut crate::host::Handle<$context> $(, $argument: rhai::Dynamic)*| {
                this.with(|value| {
                    let work: fn(&mut $context $(, method!(@ $argument))*) -> Result<_, crate::fault::Complaint> = $work;
                    work(value $(, &$argument)*)
                })
            });
    };
    (@ $argument:ident) => { &rhai::Dynamic };
}
pub(crate) use method;

/// Registers a property of a handle: its name, what it says with its unit, how it is read.
pub(crate) fn property<C, R>(engine: &mut Engine, name: &str, doc: &str, read: fn(&C) -> R)
where
    C: Send + 'static,
    R: rhai::Variant + Clone,
{
    getter(engine, name, doc, move |this: &mut Handle<C>| -> Result<R, Refusal> { this.with(|value| Ok(read(value))) });
}

/// Registers a property of any value.
pub(crate) fn getter<A: 'static, const N: usize, const X: bool, R, const F: bool>(
    engine: &mut Engine,
    name: &str,
    doc: &str,
    read: impl RhaiNativeFunc<A, N, X, R, F> + Send + Sync + 'static,
) where
    R: rhai::Variant + Clone,
{
    FuncRegistration::new_getter(name).with_comments([format!("/// {doc}")]).register_into_engine(engine, read);
}

/// Registers `chance(n)` and `chance(n, low, high)`: keyed chance, the same at every call with the same number.
pub(crate) fn chance<C: Send + 'static>(engine: &mut Engine, seed: fn(&C) -> Seed) {
    let unit = move |this: &mut Handle<C>, n: i64| this.with(|value| Ok(seed(value).unit(n as u64)));
    let comment = ["/// A number from 0 to below 1, drawn for the number n: the same n, the same draw."];
    FuncRegistration::new("chance")
        .with_params_info(["this", "n"])
        .with_comments(comment)
        .register_into_engine(engine, unit);
    let range = move |this: &mut Handle<C>, n: i64, low: Dynamic, high: Dynamic| {
        this.with(|value| {
            let (low, high) = (crate::host::numeric("low", &low)?, crate::host::numeric("high", &high)?);
            Ok(seed(value).range(n as u64, low, high))
        })
    };
    let info = ["this", "n", "low", "high"];
    FuncRegistration::new("chance").with_params_info(info).register_into_engine(engine, range);
}

/// How many places a call may look at with words that look far: of about the time that its operations may take.
const MOST_LOOKS: f64 = 1_000_000.0;

/// The places that a call has looked at so far. A word that looks at thousands of them is one operation to Rhai.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Looks(f64);

impl Looks {
    /// Takes in what a word is about to look at.
    pub fn take(&mut self, places: f64) -> Result<(), Complaint> {
        self.0 += places;
        if self.0 <= MOST_LOOKS {
            return Ok(());
        }
        let message = "the call looks at too many places";
        Err(Complaint::new(message).hint("is there a loop around a word that looks far? Look nearer, or less often"))
    }
}

/// A number of a range, or the complaint that it is not.
pub(crate) fn within(what: &str, value: &Dynamic, low: f64, high: f64, unit: &str) -> Result<f64, Complaint> {
    let number = crate::host::numeric(what, value)?;
    if number >= low && number <= high {
        return Ok(number);
    }
    // The value stands in the hint, so that a thousand different values are one fault.
    let message = format!("{what} must lie between {low} and {high}{unit}");
    Err(Complaint::new(message).hint(format!("it was {number}")))
}
