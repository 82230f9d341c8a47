//! Building rules: `build(shape, p)`.

use super::ground::{self, BareGround, Ground, Placed, StreetSide};
use super::options::Options;
use super::parcel::tag;
use super::{chance, method, property, within};
use crate::fault::{Complaint, Faults, Refusal};
use crate::host::{Caller, Handle, Located};
use crate::rule::{Rule, RuleKind};
use buildings::{Envelope, Setbacks};
use geom::{Seed, Vec2};
use rhai::{Array, Dynamic, Engine, FuncRegistration, Map};
use std::sync::Arc;

/// What a building rule knows of a parcel.
#[derive(Clone, Debug)]
pub struct ShapeContext {
    /// Area of the parcel, m².
    pub area: f64,
    /// How far it reaches along its longest front and square to it, metres; of the smallest rectangle where it fronts no
    /// street.
    pub extent: Vec2,
    /// Whether it fronts two streets that meet at its corner.
    pub is_corner: bool,
    /// The streets it fronts, by id.
    pub streets: Vec<StreetSide>,
    /// People per km² there.
    pub density: f64,
    /// Greatest height allowed there, metres; endless where nothing says so.
    pub max_height: f64,
    /// A place inside it, metres: for maps and messages.
    pub place: Vec2,
    /// The district there; empty where there is none.
    pub district: String,
    /// The landmark that stands there; empty where there is none.
    pub landmark: String,
    /// The words that its parcel carries.
    pub tags: Vec<Arc<str>>,
    /// The land around.
    pub ground: Arc<dyn Ground>,
    /// Its chance.
    pub seed: Seed,
}

impl ShapeContext {
    /// A square parcel of so many m² on bare land without streets or limits.
    pub fn bare(area: f64, seed: Seed) -> Self {
        Self {
            area,
            extent: Vec2::splat(area.max(0.0).sqrt()),
            is_corner: false,
            streets: Vec::new(),
            density: 0.0,
            max_height: f64::INFINITY,
            place: Vec2::ZERO,
            district: String::new(),
            landmark: String::new(),
            tags: Vec::new(),
            ground: Arc::new(BareGround),
            seed,
        }
    }
}

/// What a building rule decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BuildingChoice {
    /// A box that fills its envelope.
    Extrude(Envelope),
    /// Nothing is built.
    None,
}

impl BuildingChoice {
    /// What stands on a parcel whose rule failed: a plain box of two floors.
    pub const PLAIN: Self = Self::Extrude(Envelope { height: 6.0, setbacks: Setbacks::Even(0.0), coverage: 1.0 });
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

impl Shaped for Asked {
    fn shape(&self) -> &ShapeContext {
        &self.shape
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
    properties::<Asked>(engine);
    property::<Asked, String>(
        engine,
        "landmark",
        "The name of the landmark that stands there; else an empty text.",
        |a| a.shape.landmark.clone(),
    );
    property::<Asked, Array>(engine, "tags", "The words that the parcel carries: a list of texts.", |a| {
        a.shape.tags.iter().map(|tag| tag.to_string().into()).collect()
    });
    method!(engine, "has_tag"(name) "Whether the parcel carries a word: see `fn assign(parcel, p)`.", Asked, |a, name| {
        let name = tag(name)?;
        Ok(a.shape.tags.iter().any(|tag| **tag == *name))
    });
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
        .with_params_info(["this", "height", "#{ setback, front, side, rear, coverage }"])
        .with_comments(["/// The same, keeping distances from the parcel's rim and to a share of its area."])
        .register_into_engine(engine, |this: &mut Handle<Asked>, height: Dynamic, options: Map| {
            choose(this, || extrude(&height, options))
        });
}

/// What knows a parcel.
pub(super) trait Shaped: Send + 'static {
    fn shape(&self) -> &ShapeContext;
}

impl<C: Shaped> Located for C {
    fn place(&self) -> Vec2 {
        self.shape().place
    }
}

impl<C: Shaped> Placed for C {
    fn ground(&self) -> &dyn Ground {
        &*self.shape().ground
    }

    fn streets(&self) -> &[StreetSide] {
        &self.shape().streets
    }
}

/// Registers what can be asked of a parcel.
pub(super) fn properties<C: Shaped>(engine: &mut Engine) {
    property::<C, f64>(engine, "area", "Area of the parcel, m².", |c| c.shape().area);
    property::<C, f64>(engine, "width", "How far it reaches along its longest front, m.", |c| c.shape().extent.x);
    property::<C, f64>(engine, "depth", "How far it reaches square to that front, m.", |c| c.shape().extent.y);
    property::<C, bool>(engine, "is_corner", "Whether it fronts two streets that meet at its corner.", |c| {
        c.shape().is_corner
    });
    property::<C, bool>(engine, "is_inner", "Whether it fronts no street.", |c| c.shape().streets.is_empty());
    property::<C, f64>(engine, "density", "People per km² there; 0 without a map `density`.", |c| c.shape().density);
    property::<C, f64>(
        engine,
        "max_height",
        "Least value of the map `max_height` on the parcel, m; endless without one.",
        |c| c.shape().max_height,
    );
    property::<C, String>(engine, "district", "The district there; an empty text where there is none.", |c| {
        c.shape().district.clone()
    });
    chance::<C>(engine, |c| c.shape().seed);
    ground::register::<C>(engine);
}

fn choose(this: &Handle<Asked>, choice: impl FnOnce() -> Result<BuildingChoice, Complaint>) -> Result<(), Refusal> {
    this.with(|asked| {
        asked.choice = choice()?;
        Ok(())
    })
}

fn extrude(height: &Dynamic, options: Map) -> Result<BuildingChoice, Complaint> {
    let height = within("the height", height, 0.1, HIGHEST, " m")?;
    let mut options = Options::new("shape.extrude", options, &["setback", "front", "side", "rear", "coverage"])?;
    let by_side = ["front", "side", "rear"].into_iter().find(|key| options.has(key));
    if let (true, Some(key)) = (options.has("setback"), by_side) {
        let message = format!("`setback` holds on all sides, so `{key}` says it twice");
        return Err(Complaint::new(message).hint("write either setback, or front, side and rear").key(key));
    }
    let mut distance = |key| Ok::<_, Complaint>(options.within(key, 0.0, WIDEST_SETBACK, " m")?.unwrap_or(0.0));
    let setbacks = match by_side {
        Some(_) => Setbacks::Sides { front: distance("front")?, side: distance("side")?, rear: distance("rear")? },
        None => Setbacks::Even(distance("setback")?),
    };
    let coverage = options.within("coverage", 0.0, 1.0, " of the parcel")?.unwrap_or(1.0);
    Ok(BuildingChoice::Extrude(Envelope { height, setbacks, coverage }))
}
