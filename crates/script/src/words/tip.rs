//! Street patterns: `propose(tip, p)`.

mod senses;

use super::options::Options;
use super::segment::{map_name, missing};
use super::tally::Tally;
use super::{Looks, chance, method, property, within};
use crate::fault::{Complaint, Faults};
use crate::host::{Caller, Handle, Located, numeric};
use crate::rule::{Rule, RuleKind};
use geom::{Angle, Vec2};
use rhai::{Dynamic, Engine, FuncRegistration, Map};
use std::sync::Arc;
use streets::Classes;
use streets::growth::{GrowthRules, Rings, Slot, Slots, Steer, Tip};

/// What is told of a rule that proposes nothing where it is asked: in a class of streets, or in a quarter. Where it grows streets
/// elsewhere that is no mistake.
pub const PROPOSES_NOTHING: &str = "this rule proposes nothing, anywhere";

/// A street pattern that a rule decides: what the growth kernel calls.
pub struct StreetPattern {
    caller: Caller<Growing>,
    origin: u16,
    classes: Arc<Classes>,
    faults: Arc<Faults>,
    tally: Tally,
}

impl Drop for StreetPattern {
    /// At the end of the stage it is known whether the rule proposed anything.
    fn drop(&mut self) {
        let hint = "fill a slot: tip.ahead(80), tip.branch_left(80), tip.branch_right(80) or tip.fork(80, 80)";
        self.tally.warn(self.rule(), RuleKind::Streets, PROPOSES_NOTHING, hint, &self.faults);
    }
}

/// What `tip` stands for during a call.
#[derive(Clone, Debug)]
struct Growing {
    tip: Tip,
    classes: Arc<Classes>,
    looks: Looks,
}

impl Located for Growing {
    fn place(&self) -> Vec2 {
        self.tip.place()
    }
}

impl StreetPattern {
    /// The pattern of a rule with `propose(tip, p)`. Streets carry `origin`; what goes wrong is reported to `faults`.
    pub fn new(rule: Rule, origin: u16, classes: Arc<Classes>, faults: Arc<Faults>) -> Self {
        let caller = Caller::new(rule, RuleKind::Streets);
        Self { caller, origin, classes, faults, tally: Tally::default() }
    }

    /// The rule.
    pub fn rule(&self) -> &Rule {
        self.caller.rule()
    }
}

impl GrowthRules for StreetPattern {
    fn is_in_vain(&self) -> bool {
        self.tally.is_in_vain()
    }

    /// On a fault the tip ends: its slots stay empty.
    fn propose(&self, tip: &mut Tip) {
        tip.slots = Slots::default();
        let asked = Growing { tip: tip.clone(), classes: self.classes.clone(), looks: Looks::default() };
        match self.caller.call(asked) {
            Ok(grown) => {
                self.tally.count(!grown.tip.slots.is_empty());
                tip.slots = grown.tip.slots;
            }
            Err(fault) => {
                self.tally.count(true);
                self.faults.report(fault.at(tip.place()));
            }
        }
    }

    fn origin(&self) -> u16 {
        self.origin
    }
}

/// Longest street that a rule may propose in one go, in metres.
const LONGEST: f64 = 10_000.0;
/// Widest right-of-way, in metres.
const WIDEST: f64 = 200.0;
/// Longest delay, in derivation steps.
const LATEST: f64 = 1_000_000.0;

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Handle<Growing>>("tip").register_type_with_name::<Steer>("a field of headings");
    fields(engine);
    properties(engine);
    questions(engine);
    senses::register(engine);
    proposals(engine);
}

fn fields(engine: &mut Engine) {
    let cross = |heading: Dynamic, folds: i64| field(&heading, folds);
    FuncRegistration::new("cross").with_params_info(["heading", "folds"]).register_into_engine(engine, cross);
    FuncRegistration::new("cross")
        .with_params_info(["heading"])
        .with_comments([
            "/// Four headings at right angles, one of them `heading` (degrees): a tip turns onto the nearest.",
        ])
        .register_into_engine(engine, |heading: Dynamic| field(&heading, 4));
    FuncRegistration::new("raster")
        .with_params_info(["heading", "along", "across"])
        .with_comments([
            "/// A raster of blocks `along` metres long (towards `heading`) and `across` metres wide, through (0, 0).",
        ])
        .register_into_engine(engine, |heading: Dynamic, along: Dynamic, across: Dynamic| {
            raster(&heading, &along, &across, Vec2::ZERO)
        });
    FuncRegistration::new("raster")
        .with_params_info(["heading", "along", "across", "x", "y"])
        .with_comments(["/// The same with a crossing at (x, y)."])
        .register_into_engine(engine, |heading: Dynamic, along: Dynamic, across: Dynamic, x: Dynamic, y: Dynamic| {
            raster(&heading, &along, &across, Vec2::new(numeric("x", &x)?, numeric("y", &y)?))
        });
    FuncRegistration::new("rings")
        .with_params_info(["x", "y", "#{ inner, spacing, rays, arc, chord }"])
        .with_comments([
            "/// Rings and rays around (x, y): ends settle on rings, `spacing` apart, and rays, about `arc` apart.",
        ])
        .register_into_engine(engine, |x: Dynamic, y: Dynamic, options: Map| {
            Ok::<_, crate::fault::Refusal>(rings(Vec2::new(numeric("x", &x)?, numeric("y", &y)?), options)?)
        });
}

fn rings(centre: Vec2, options: Map) -> Result<Steer, Complaint> {
    let mut options = Options::new("rings", options, &["inner", "spacing", "rays", "arc", "chord"])?;
    let mut metres = |key: &str| options.within(key, 5.0, LONGEST, " m");
    let (inner, spacing, arc, chord) = (metres("inner")?, metres("spacing")?, metres("arc")?, metres("chord")?);
    let spacing = spacing.ok_or_else(|| Complaint::new("rings needs `spacing: …`"))?;
    let arc = arc.unwrap_or(spacing);
    Ok(Steer::Rings(Rings {
        centre,
        inner: inner.unwrap_or(spacing),
        spacing,
        rays: options.within("rays", 5.0, 64.0, "")?.unwrap_or(8.0).round() as u32,
        arc,
        chord: chord.unwrap_or(arc),
    }))
}

fn field(heading: &Dynamic, folds: i64) -> Result<Steer, crate::fault::Refusal> {
    let folds = u32::try_from(folds).ok().filter(|folds| (1..=360).contains(folds));
    let folds = folds.ok_or_else(|| Complaint::new("a field has from 1 to 360 folds"))?;
    Ok(Steer::Cross { heading: Angle::degrees(numeric("the heading", heading)?), folds })
}

fn raster(heading: &Dynamic, along: &Dynamic, across: &Dynamic, origin: Vec2) -> Result<Steer, crate::fault::Refusal> {
    let heading = Angle::degrees(numeric("the heading", heading)?);
    let along = within("the length of a block", along, 1.0, LONGEST, " m")?;
    let across = within("the width of a block", across, 1.0, LONGEST, " m")?;
    Ok(Steer::Raster { heading, along, across, origin })
}

fn properties(engine: &mut Engine) {
    property::<Growing, f64>(engine, "x", "How far east it is, m.", |g| g.tip.place().x);
    property::<Growing, f64>(engine, "y", "How far north it is, m.", |g| g.tip.place().y);
    property::<Growing, f64>(engine, "heading", "Its heading after steering, ° counter-clockwise from east.", |g| {
        g.tip.steered().wrapped().to_degrees()
    });
    property::<Growing, f64>(engine, "density", "People per km² here; 1 without a map `density`.", |g| {
        g.tip.density()
    });
    property::<Growing, f64>(engine, "elevation", "Metres above the sea; 0 without a map `elevation`.", |g| {
        g.tip.elevation()
    });
    property::<Growing, i64>(engine, "age", "Segments since its street began.", |g| i64::from(g.tip.age));
    property::<Growing, i64>(engine, "generation", "Branchings since the seed: 0 on the seed's own street.", |g| {
        i64::from(g.tip.generation)
    });
    property::<Growing, i64>(engine, "step", "The derivation step at which it is asked.", |g| i64::from(g.tip.step));
    property::<Growing, f64>(engine, "street_length", "Metres since its street began.", |g| g.tip.length);
    property::<Growing, f64>(engine, "width", "Right-of-way of its street, m.", |g| g.tip.width);
    property::<Growing, f64>(engine, "home_heading", "Direction of the longest side of its quarter, °.", |g| {
        g.tip.home.heading.wrapped().to_degrees()
    });
    property::<Growing, f64>(engine, "home_x", "East of the middle of its quarter, m.", |g| g.tip.home.at.x);
    property::<Growing, f64>(engine, "home_y", "North of the middle of its quarter, m.", |g| g.tip.home.at.y);
    property::<Growing, bool>(engine, "is_seed", "Whether nothing has grown here yet.", |g| g.tip.is_seed);
    property::<Growing, String>(engine, "district", "The district here; an empty text where there is none.", |g| {
        g.tip.district().to_owned()
    });
    property::<Growing, String>(engine, "class", "The name of its class: `highway`, `major`, `minor`.", |g| {
        g.classes.info(g.tip.class).name.clone()
    });
    chance::<Growing>(engine, |g| g.tip.seed);
}

fn questions(engine: &mut Engine) {
    method!(engine, "map"(name) "The value of a map of the site at the tip.", Growing, |g, name| {
        let name = map_name(name)?;
        let field = g.tip.fields.maps.get(&name);
        field.map(|field| field.at(g.tip.place())).ok_or_else(|| missing(&g.tip.fields, &name))
    });
    method!(engine, "has_map"(name) "Whether the site has a map.", Growing, |g, name| {
        Ok(g.tip.fields.maps.contains_key(&map_name(name)?))
    });
    method!(engine, "runs_along"(heading) "Whether the tip runs nearer to a heading (degrees) than across it.", Growing,
        |g, heading| Ok(g.tip.runs_along(Angle::degrees(numeric("the heading", heading)?))));
}

fn proposals(engine: &mut Engine) {
    method!(engine, "steer"(field) "Turns onto the nearest heading of a field: `cross(…)`, `raster(…)` or `rings(…)`.", Growing, |g, field| {
        let steer = field.read_lock::<Steer>().map(|steer| *steer);
        let kind = || Complaint::new(format!("tip.steer takes cross(…), raster(…) or rings(…), not {}", crate::host::kind_of(field)));
        g.tip.steer(steer.ok_or_else(kind)?);
        Ok(())
    });
    method!(engine, "ahead"(length) "The street goes on for so many metres.", Growing,
        |g, length| put(&mut g.tip.slots.ahead, length, None));
    method!(engine, "branch_left"(length) "A street branches off to the left.", Growing,
        |g, length| put(&mut g.tip.slots.left, length, None));
    method!(engine, "branch_right"(length) "A street branches off to the right.", Growing,
        |g, length| put(&mut g.tip.slots.right, length, None));
    method!(engine, "fork"(ahead, aside) "The street goes on for `ahead` metres and branches off to both sides for `aside`.", Growing, |g, ahead, aside| {
        put(&mut g.tip.slots.ahead, ahead, None)?;
        put(&mut g.tip.slots.left, aside, None)?;
        put(&mut g.tip.slots.right, aside, None)
    });
    slot_with_options(engine, "ahead", |g, length, options| put(&mut g.tip.slots.ahead, length, Some(options)));
    slot_with_options(engine, "branch_left", |g, length, options| put(&mut g.tip.slots.left, length, Some(options)));
    slot_with_options(engine, "branch_right", |g, length, options| put(&mut g.tip.slots.right, length, Some(options)));
}

/// Registers a word that fills a slot with options.
fn slot_with_options(
    engine: &mut Engine,
    name: &str,
    fill: fn(&mut Growing, &Dynamic, &Dynamic) -> Result<(), Complaint>,
) {
    FuncRegistration::new(name)
        .with_params_info(["this", "length", "#{ turn, delay, width }"])
        .with_comments(["/// With a turn (degrees, further than to the side it leaves to), a delay (steps; below 0 not at all), a width (metres)."])
        .register_into_engine(engine, move |this: &mut Handle<Growing>, length: Dynamic, options: Dynamic| {
            this.with(|growing| fill(growing, &length, &options))
        });
}

/// Fills a slot.
fn put(slot: &mut Option<Slot>, length: &Dynamic, options: Option<&Dynamic>) -> Result<(), Complaint> {
    let length = numeric("the length of a street", length)?;
    if !(length > 0.0 && length <= LONGEST) {
        let message = "the length of a street must be above 0 and at most 10 km";
        return Err(Complaint::new(message).hint(format!("it was {length} m")));
    }
    let bare = Slot { length, turn: Angle::ZERO, delay: 0, width: None };
    *slot = Some(options.map_or(Ok(bare), |options| with_options(bare, options))?);
    Ok(())
}

fn with_options(bare: Slot, options: &Dynamic) -> Result<Slot, Complaint> {
    let map = options.clone().try_cast::<Map>();
    let map = map.ok_or_else(|| Complaint::new("options are written #{ turn: 10, delay: 2, width: 20 }"))?;
    let mut options = Options::new("a street", map, &["turn", "delay", "width"])?;
    Ok(Slot {
        turn: Angle::degrees(options.within("turn", -180.0, 180.0, "°")?.unwrap_or(0.0)),
        delay: options.within("delay", -LATEST, LATEST, " steps")?.unwrap_or(0.0).round() as i32,
        width: options.within("width", 0.5, WIDEST, " m")?,
        ..bare
    })
}
