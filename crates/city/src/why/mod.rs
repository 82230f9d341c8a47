//! Why something is in a city: which rule made it, on which values, from what it grew, and what was refused around it.
//!
//! A layout says where things are. Why they are there is known to the growth that made it, which is a pure function: so
//! the city is derived once more with a trace ([`crate::Settings::traces`]) and asked. Where what it gives now differs
//! from the layout, the answer says so.

mod asked;
mod blend;
mod decision;
mod derived;
mod find;
mod ground;
mod land;
mod lineage;
mod street;
mod text;

pub use decision::{DecisionSays, LeftOut, StepSays};
pub use find::{Found, Kind, find, on_site};

use crate::export::LayoutFile;
use crate::{Built, Sources};
use geom::Vec2;
use serde::Serialize;

/// Why nothing can be said.
#[derive(Debug, thiserror::Error)]
pub enum WhyError {
    /// The layout has nothing of that id.
    #[error("{message}\n  hint: {hint}")]
    Unknown {
        /// What was asked for.
        message: String,
        /// Ids that are like it, or what there is.
        hint: String,
    },
}

/// An answer, part by part; empty parts have nothing to say.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Answer {
    /// `street`, `crossing`, `quarter`, `block`, `parcel` or `building`; `place` where none of them lies.
    pub kind: &'static str,
    /// The id.
    pub id: String,
    /// Where it lies, metres.
    pub place: [f64; 2],
    /// How the layout differs from what the city now gives.
    pub differs: Vec<String>,
    /// What there is to say about it in plain words, by topic.
    pub facts: Vec<Fact>,
    /// The rules that decided about it.
    pub rules: Vec<RuleSays>,
    /// The parameters in force there.
    pub parameters: Vec<ParameterSays>,
    /// The maps at its place.
    pub maps: Vec<MapSays>,
    /// What rules did step by step, asked once more about the element: what they read, asked, computed, tested and printed.
    pub decisions: Vec<DecisionSays>,
    /// How a street came to be piece by piece, in the order of growth.
    pub pieces: Vec<PieceSays>,
    /// From what it grew: its street first, then that street's parent, and so on.
    pub lineage: Vec<LineageSays>,
    /// What was proposed at its ends and along it, and refused.
    pub refused: Vec<RefusedSays>,
}

/// A fact in plain words.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fact {
    /// What it is about.
    pub about: &'static str,
    /// What there is to say.
    pub text: String,
}

/// A rule and where it stands.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RuleSays {
    /// Its role in the city, e.g. `minors.pattern`.
    pub role: String,
    /// Its name, e.g. `streets/grid`.
    pub name: String,
    /// Its file.
    pub file: String,
    /// The line where its function begins; none when unknown.
    pub line: Option<u32>,
    /// The function that decides.
    pub function: String,
}

/// A parameter in force.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ParameterSays {
    /// How `--set` addresses it.
    pub address: String,
    /// Its value, with its unit.
    pub value: String,
    /// The value at the place, where it differs from place to place.
    pub here: Option<String>,
    /// What it does.
    pub about: String,
}

/// A map at a place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MapSays {
    /// Its name, or `slope`, or `district`.
    pub name: String,
    /// The value, with its unit.
    pub value: String,
}

/// One accepted proposal.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PieceSays {
    /// Its identity.
    pub lineage: String,
    /// The derivation step, counted through all stages.
    pub step: u32,
    /// Where it starts, metres.
    pub from: [f64; 2],
    /// Where it ends, metres.
    pub to: [f64; 2],
    /// How constraints left it.
    pub outcome: String,
    /// Metres between the end that was proposed and the end it has.
    pub moved: f64,
    /// The patterns that were blended where it starts, the one that led first; none where one decides alone.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub patterns: Vec<PatternSays>,
}

/// A pattern of a blend at a place.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PatternSays {
    /// What addresses call it, e.g. `grid`.
    pub name: String,
    /// Its share of all weight there, from 0 to 1.
    pub share: f64,
    /// Whether it led.
    pub leads: bool,
}

/// A street of a lineage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LineageSays {
    /// The street.
    pub street: String,
    /// The stage that it grew in.
    pub stage: &'static str,
    /// The derivation step at which it began.
    pub step: u32,
    /// Where it began, metres.
    pub at: [f64; 2],
    /// How: `left of …`, `a seed`, …
    pub how: String,
}

/// A proposal that was refused.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RefusedSays {
    /// The derivation step.
    pub step: u32,
    /// `ahead`, `left`, `right` or `back`.
    pub branch: &'static str,
    /// Where it would have started, metres.
    pub from: [f64; 2],
    /// Where it should have ended, metres.
    pub to: [f64; 2],
    /// The constraint that refused it; where a rule did, in the rule's own words.
    pub reason: String,
}

/// What a question is answered from.
struct Evidence<'a> {
    layout: &'a LayoutFile,
    sources: &'a Sources,
    built: &'a Built,
}

/// Says why something of a layout is there. `built` is the city of `sources`, built with a trace as far as [`Kind::until`]
/// says.
pub fn explain(found: &Found, layout: &LayoutFile, sources: &Sources, built: &Built) -> Answer {
    let evidence = Evidence { layout, sources, built };
    let mut answer = Answer {
        kind: found.kind.name(),
        id: found.id.clone(),
        place: found.place.to_array(),
        differs: find::differences(found, &evidence),
        maps: ground::maps_at(sources, found.place),
        ..Answer::default()
    };
    match found.kind {
        Kind::Street => street::explain(found, &evidence, &mut answer),
        Kind::Crossing => street::explain_crossing(found, &evidence, &mut answer),
        Kind::Quarter => land::explain_quarter(found, &evidence, &mut answer),
        Kind::Block => land::explain_block(found, &evidence, &mut answer),
        Kind::Parcel => land::explain_parcel(found, &evidence, &mut answer),
        Kind::Building => land::explain_building(found, &evidence, &mut answer),
        Kind::Place => {}
    }
    if found.is_place {
        asked::tell_place(found.place, &evidence, &mut answer);
    }
    if found.kind == Kind::Place && answer.decisions.is_empty() {
        answer.tell("what", "nothing lies here, and no rule of streets was asked here");
    }
    answer
}

impl Answer {
    fn tell(&mut self, about: &'static str, text: impl Into<String>) {
        self.facts.push(Fact { about, text: text.into() });
    }
}

/// A place to the centimetre, as answers give it.
fn place(at: Vec2) -> [f64; 2] {
    at.to_array().map(|metres| (metres * 100.0).round() / 100.0)
}
