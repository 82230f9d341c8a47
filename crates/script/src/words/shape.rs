//! Building rules: `build(shape, p)`.

use super::options::Options;
use super::{chance, property, within};
use crate::fault::{Complaint, Faults, Refusal};
use crate::host::{Caller, Handle, Located};
use crate::rule::{Rule, RuleKind};
use geom::{Seed, Vec2};
use rhai::{Dynamic, Engine, FuncRegistration, Map};
use std::sync::Arc;

/// What a building rule knows of a parcel.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeContext {
    /// Area of the parcel, m².
    pub area: f64,
    /// Length of its frontage on streets, metres.
    pub frontage: f64,
    /// People per km² there.
    pub density: f64,
    /// Greatest height allowed there, metres; endless where nothing says so.
    pub max_height: f64,
    /// A place inside it, metres: for messages.
    pub place: Vec2,
    /// The district there; empty where there is none.
    pub district: String,
    /// Its chance.
    pub seed: Seed,
}

/// What a building rule decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BuildingChoice {
    /// The parcel, less a setback, raised to a height; metres.
    Extrude {
        /// Height above the highest ground.
        height: f64,
        /// Distance kept free along the parcel's rim.
        setback: f64,
    },
    /// Nothing is built.
    None,
}

impl BuildingChoice {
    /// What stands on a parcel whose rule failed: a plain box of two floors.
    pub const PLAIN: Self = Self::Extrude { height: 6.0, setback: 0.0 };
}

/// A building rule, ready to be asked from any thread.
pub struct BuildingPattern {
    caller: Caller<Asked>,
    faults: Arc<Faults>,
}

/// What `shape` stands for during a call.
#[derive(Clone, Debug)]
struct Asked {
    shape: ShapeContext,
    choice: BuildingChoice,
}

impl Located for Asked {
    fn place(&self) -> Vec2 {
        self.shape.place
    }
}

impl BuildingPattern {
    /// The pattern of a rule with `build(shape, p)`; what goes wrong is reported to `faults`.
    pub fn new(rule: Rule, faults: Arc<Faults>) -> Self {
        Self { caller: Caller::new(rule, RuleKind::Buildings), faults }
    }

    /// What stands on a parcel: nothing when the rule decides nothing, a plain box on a fault.
    pub fn choose(&self, shape: ShapeContext) -> BuildingChoice {
        let place = shape.place;
        match self.caller.call(Asked { shape, choice: BuildingChoice::None }) {
            Ok(asked) => asked.choice,
            Err(fault) => {
                self.faults.report(fault.at(place));
                BuildingChoice::PLAIN
            }
        }
    }
}

/// Highest building that a rule may ask for, metres.
const HIGHEST: f64 = 3_000.0;
/// Widest setback, metres.
const WIDEST_SETBACK: f64 = 1_000.0;

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Handle<Asked>>("shape");
    property::<Asked, f64>(engine, "area", |a| a.shape.area);
    property::<Asked, f64>(engine, "frontage", |a| a.shape.frontage);
    property::<Asked, f64>(engine, "density", |a| a.shape.density);
    property::<Asked, f64>(engine, "max_height", |a| a.shape.max_height);
    property::<Asked, String>(engine, "district", |a| a.shape.district.clone());
    property::<Asked, f64>(engine, "x", |a| a.shape.place.x);
    property::<Asked, f64>(engine, "y", |a| a.shape.place.y);
    chance::<Asked>(engine, |a| a.shape.seed);
    FuncRegistration::new("none")
        .with_params_info(["this"])
        .with_comments(["/// Nothing is built."])
        .register_into_engine(engine, |this: &mut Handle<Asked>| choose(this, || Ok(BuildingChoice::None)));
    FuncRegistration::new("extrude")
        .with_params_info(["this", "height"])
        .with_comments(["/// Raises the parcel to a height in metres."])
        .register_into_engine(engine, |this: &mut Handle<Asked>, height: Dynamic| {
            choose(this, || extrude(&height, Map::new()))
        });
    FuncRegistration::new("extrude")
        .with_params_info(["this", "height", "#{ setback }"])
        .with_comments(["/// The same, keeping a distance from the parcel's rim."])
        .register_into_engine(engine, |this: &mut Handle<Asked>, height: Dynamic, options: Map| {
            choose(this, || extrude(&height, options))
        });
}

fn choose(this: &Handle<Asked>, choice: impl FnOnce() -> Result<BuildingChoice, Complaint>) -> Result<(), Refusal> {
    this.with(|asked| {
        asked.choice = choice()?;
        Ok(())
    })
}

fn extrude(height: &Dynamic, options: Map) -> Result<BuildingChoice, Complaint> {
    let height = within("the height", height, 0.1, HIGHEST, " m")?;
    let mut options = Options::new("shape.extrude", options, &["setback"])?;
    let setback = options.within("setback", 0.0, WIDEST_SETBACK, " m")?.unwrap_or(0.0);
    Ok(BuildingChoice::Extrude { height, setback })
}
