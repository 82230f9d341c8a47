//! Parcel rules: `subdivide(block, p)`.

use super::options::Options;
use super::{chance, property};
use crate::fault::{Complaint, Faults, Refusal};
use crate::host::{Caller, Handle, Located};
use crate::rule::{Rule, RuleKind};
use geom::{Seed, Vec2};
use layout::RecursiveSettings;
use rhai::{Engine, FuncRegistration, Map};
use std::sync::Arc;

/// What a parcel rule knows of a block.
#[derive(Clone, Debug, PartialEq)]
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
    /// Its chance.
    pub seed: Seed,
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
    property::<Asked, f64>(engine, "area", |a| a.block.area);
    property::<Asked, f64>(engine, "perimeter", |a| a.block.perimeter);
    property::<Asked, f64>(engine, "density", |a| a.block.density);
    property::<Asked, String>(engine, "district", |a| a.block.district.clone());
    property::<Asked, f64>(engine, "x", |a| a.block.place.x);
    property::<Asked, f64>(engine, "y", |a| a.block.place.y);
    chance::<Asked>(engine, |a| a.block.seed);
    word(engine, "whole", "The block becomes one parcel that may carry a building.", ParcelChoice::Whole);
    word(engine, "open", "The block becomes one parcel that stays open.", ParcelChoice::Open);
    FuncRegistration::new("recursive")
        .with_params_info(["this", "#{ least_area, most_area, least_frontage, irregularity }"])
        .with_comments(["/// The block is cut until parcels are small enough (areas in m², frontage in metres)."])
        .register_into_engine(engine, |this: &mut Handle<Asked>, options: Map| -> Result<(), Refusal> {
            this.with(|asked| {
                asked.choice = Some(ParcelChoice::Recursive(recursive(options, asked.block.seed)?));
                Ok(())
            })
        });
}

fn word(engine: &mut Engine, name: &str, doc: &str, choice: ParcelChoice) {
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
    let known = ["least_area", "most_area", "least_frontage", "irregularity"];
    let mut options = Options::new("block.recursive", options, &known)?;
    let default = RecursiveSettings { seed, ..RecursiveSettings::default() };
    let settings = RecursiveSettings {
        least_area: options.number("least_area")?.unwrap_or(default.least_area),
        most_area: options.number("most_area")?.unwrap_or(default.most_area),
        least_frontage: options.number("least_frontage")?.unwrap_or(default.least_frontage),
        irregularity: options.number("irregularity")?.unwrap_or(default.irregularity),
        seed,
    };
    settings.check().map_err(|error| Complaint::new(error.to_string()))?;
    Ok(settings)
}
