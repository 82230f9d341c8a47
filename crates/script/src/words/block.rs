//! Parcel rules: `subdivide(block, p)`.

use super::ground::{self, BareGround, Ground, Placed, StreetSide};
use super::options::{Options, word};
use super::{chance, property};
use crate::fault::{Complaint, Faults, Refusal};
use crate::host::{Caller, Handle, Located};
use crate::rule::{Rule, RuleKind};
use geom::{Seed, Vec2};
use layout::{Inner, RecursiveSettings, SettingsError, Squared};
use rhai::{Engine, FuncRegistration, Map};
use std::sync::Arc;

/// What a parcel rule knows of a block.
#[derive(Clone, Debug)]
pub struct BlockContext {
    /// Area that parcels can cover, m².
    pub area: f64,
    /// Length of its rim, metres.
    pub perimeter: f64,
    /// People per km² there.
    pub density: f64,
    /// A place inside it, metres: for maps and messages.
    pub place: Vec2,
    /// The district there; empty where there is none.
    pub district: String,
    /// Long and short side of the smallest rectangle around it, metres.
    pub extent: Vec2,
    /// Its longest side, edges that hardly turn counted as one, metres.
    pub longest_side: f64,
    /// The streets it fronts, by id.
    pub streets: Vec<StreetSide>,
    /// The land around.
    pub ground: Arc<dyn Ground>,
    /// Its chance.
    pub seed: Seed,
}

impl BlockContext {
    /// A square block of so many m² on bare land without streets.
    pub fn bare(area: f64, seed: Seed) -> Self {
        let side = area.max(0.0).sqrt();
        Self {
            area,
            perimeter: 4.0 * side,
            density: 0.0,
            place: Vec2::ZERO,
            district: String::new(),
            extent: Vec2::splat(side),
            longest_side: side,
            streets: Vec::new(),
            ground: Arc::new(BareGround),
            seed,
        }
    }
}

/// What a parcel rule decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParcelChoice {
    /// Recursive cuts.
    Recursive(RecursiveSettings),
    /// One parcel that may carry a building.
    Whole,
    /// One parcel that stays open.
    Open,
}

/// A parcel rule, ready to be asked from any thread.
pub struct ParcelPattern {
    caller: Caller<Asked>,
    faults: Arc<Faults>,
}

/// What `block` stands for during a call.
#[derive(Clone, Debug)]
struct Asked {
    block: BlockContext,
    choice: Option<ParcelChoice>,
}

impl Located for Asked {
    fn place(&self) -> Vec2 {
        self.block.place
    }
}

impl Placed for Asked {
    fn ground(&self) -> &dyn Ground {
        &*self.block.ground
    }

    fn streets(&self) -> &[StreetSide] {
        &self.block.streets
    }
}

impl ParcelPattern {
    /// The pattern of a rule with `subdivide(block, p)`; what goes wrong is reported to `faults`.
    pub fn new(rule: Rule, faults: Arc<Faults>) -> Self {
        Self { caller: Caller::new(rule, RuleKind::Parcels), faults }
    }

    /// What becomes of a block. On a fault, or when the rule decides nothing, it becomes one parcel.
    pub fn choose(&self, block: BlockContext) -> ParcelChoice {
        let place = block.place;
        match self.caller.call(Asked { block, choice: None }) {
            Ok(asked) => asked.choice.unwrap_or(ParcelChoice::Whole),
            Err(fault) => {
                self.faults.report(fault.at(place));
                ParcelChoice::Whole
            }
        }
    }
}

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Handle<Asked>>("block");
    property::<Asked, f64>(engine, "area", "Area that parcels can cover, m².", |a| a.block.area);
    property::<Asked, f64>(engine, "perimeter", "Length of its rim, m.", |a| a.block.perimeter);
    property::<Asked, f64>(engine, "density", "People per km² at its middle; 0 without a map `density`.", |a| {
        a.block.density
    });
    property::<Asked, String>(
        engine,
        "district",
        "The district at its middle; an empty text where there is none.",
        |a| a.block.district.clone(),
    );
    property::<Asked, f64>(engine, "length", "Long side of the smallest rectangle around it, m.", |a| a.block.extent.x);
    property::<Asked, f64>(engine, "width", "Short side of that rectangle, m.", |a| a.block.extent.y);
    property::<Asked, f64>(
        engine,
        "longest_side",
        "Its longest side, edges that hardly turn counted as one, m.",
        |a| a.block.longest_side,
    );
    property::<Asked, f64>(
        engine,
        "rectangularity",
        "Share of the smallest rectangle around it that it fills, 0 to 1.",
        |a| a.block.area / (a.block.extent.x * a.block.extent.y),
    );
    chance::<Asked>(engine, |a| a.block.seed);
    ground::register::<Asked>(engine);
    decision(engine, "whole", "The block becomes one parcel that may carry a building.", ParcelChoice::Whole);
    decision(engine, "open", "The block becomes one parcel that stays open.", ParcelChoice::Open);
    FuncRegistration::new("recursive")
        .with_params_info(["this", "#{ least_area, most_area, spread, least_frontage, irregularity, forced_access, least_convexity, squared, join, inner }"])
        .with_comments(["/// The block is cut until parcels are small enough (areas in m², frontage in metres)."])
        .register_into_engine(engine, |this: &mut Handle<Asked>, options: Map| -> Result<(), Refusal> {
            this.with(|asked| {
                asked.choice = Some(ParcelChoice::Recursive(recursive(options, asked.block.seed)?));
                Ok(())
            })
        });
}

fn decision(engine: &mut Engine, name: &str, doc: &str, choice: ParcelChoice) {
    FuncRegistration::new(name).with_params_info(["this"]).with_comments([format!("/// {doc}")]).register_into_engine(
        engine,
        move |this: &mut Handle<Asked>| -> Result<(), Refusal> {
            this.with(|asked| {
                asked.choice = Some(choice);
                Ok(())
            })
        },
    );
}

fn recursive(options: Map, seed: Seed) -> Result<RecursiveSettings, Complaint> {
    let mut options = Options::new("block.recursive", options, &RECURSIVE)?;
    let default = RecursiveSettings { seed, ..RecursiveSettings::default() };
    let mut number = |key: &'static str, value: f64| Ok::<_, Complaint>(options.number(key)?.unwrap_or(value));
    let settings = RecursiveSettings {
        least_area: number("least_area", default.least_area)?,
        most_area: number("most_area", default.most_area)?,
        spread: number("spread", default.spread)?,
        least_frontage: number("least_frontage", default.least_frontage)?,
        irregularity: number("irregularity", default.irregularity)?,
        forced_access: number("forced_access", default.forced_access)?,
        least_convexity: number("least_convexity", default.least_convexity)?,
        squared: word(&mut options, "squared", &SQUARED)?.unwrap_or(default.squared),
        join: options.flag("join")?.unwrap_or(default.join),
        inner: word(&mut options, "inner", &INNER)?.unwrap_or(default.inner),
        seed,
    };
    settings.check().map_err(|error| complaint_of(&error))?;
    Ok(settings)
}

/// Which option is to blame, and what it is where it is not told.
fn complaint_of(error: &SettingsError) -> Complaint {
    let default = RecursiveSettings::default();
    match error {
        SettingsError::OutOfRange { name, .. } => Complaint::new(error.to_string()).maybe_hint(usual(name)).key(*name),
        SettingsError::AreasCrossed { .. } => {
            let (least, most) = (default.least_area, default.most_area);
            let help = format!("what is not told is as it is usual: least_area {least} m², most_area {most} m²");
            Complaint::new(error.to_string()).hint(help).key("least_area")
        }
    }
}

/// What an option is where it is not told.
fn usual(name: &str) -> Option<String> {
    let default = RecursiveSettings::default();
    let value = match name {
        "least_area" => default.least_area,
        "most_area" => default.most_area,
        "spread" => default.spread,
        "least_frontage" => default.least_frontage,
        "irregularity" => default.irregularity,
        "forced_access" => default.forced_access,
        "least_convexity" => default.least_convexity,
        _ => return None,
    };
    Some(format!("it is {value} where it is not told"))
}

/// The options of `recursive`.
const RECURSIVE: [&str; 10] = [
    "least_area",
    "most_area",
    "spread",
    "least_frontage",
    "irregularity",
    "forced_access",
    "least_convexity",
    "squared",
    "join",
    "inner",
];

const SQUARED: [(&str, Squared); 3] = [("best", Squared::Best), ("side", Squared::Side), ("street", Squared::Street)];

const INNER: [(&str, Inner); 2] = [("open", Inner::Open), ("built", Inner::Built)];
