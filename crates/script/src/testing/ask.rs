//! One call of a rule: `rule().propose(#{ heading: 10 })`, and so for the function of each kind.

use super::answer;
use super::desk::Desk;
use super::place::Place;
use crate::city::rule_named;
use crate::fault::{Complaint, Faults, Refusal};
use crate::rule::{Rule, RuleKind, Surroundings};
use crate::words::options::{Options, text, word};
use crate::words::{
    AssignPattern, BlockContext, BuildingChoice, BuildingPattern, ConstraintPattern, ParcelChoice, ParcelPattern,
    ShapeContext, StreetPattern, StreetSide,
};
use buildings::{Envelope, Setbacks};
use geom::{Angle, Point, Seed, Vec2};
use layout::{Inner, RecursiveSettings, Squared, Use};
use rhai::{Array, Dynamic, Engine, FuncRegistration, Map};
use std::sync::Arc;
use streets::growth::{Chain, Constrain, Draft, GrowthRules, Home, Own, Slot, Steer, Step, Tip};
use streets::{Class, Classes};

type Answered = Result<Dynamic, Refusal>;

/// Registers the rule that a file's tests are about, and what rules can be asked.
pub(super) fn register(engine: &mut Engine, desk: &Desk, around: &Surroundings, tested: &str) {
    let (own, name) = (around.clone(), tested.to_owned());
    FuncRegistration::new("rule")
        .with_comments(["/// The rule that the tests of this file are about."])
        .register_into_engine(engine, move || Ok::<_, Refusal>(rule_named(&name, Map::new(), &own)?));
    let (own, name) = (around.clone(), tested.to_owned());
    FuncRegistration::new("rule")
        .with_params_info(["#{ parameter: value }"])
        .with_comments(["/// The same, with values of its parameters."])
        .register_into_engine(engine, move |values: Map| Ok::<_, Refusal>(rule_named(&name, values, &own)?));
    let asked: [(RuleKind, &str, &str, Ask); 5] = [
        (RuleKind::Streets, "#{ at, heading, age, is_seed, on, … }", "What the end of a street would do next", propose),
        (RuleKind::Constrain, "#{ from, to, class, on, … }", "What is said of a street that is proposed", constrain),
        (RuleKind::Parcels, "#{ area, width, streets, on, … }", "How a block would be divided", subdivide),
        (RuleKind::Assign, "#{ area, width, streets, on, … }", "What a parcel would be for", assign),
        (RuleKind::Buildings, "#{ area, width, streets, on, … }", "What would stand on a parcel", build),
    ];
    for (kind, form, about, ask) in asked {
        let desk = desk.clone();
        FuncRegistration::new(kind.function())
            .with_params_info(["this", form])
            .with_comments([format!("/// {about}: what `fn {}` answers.", kind.form())])
            .register_into_engine(engine, move |rule: &mut Rule, options: Map| -> Answered {
                decides(rule, kind)?;
                let told = ask(rule, options)?;
                desk.read(kind.function(), &answer::line(&told));
                Ok(told)
            });
    }
    let once: [(RuleKind, &str, AskOnce); 2] = [
        (RuleKind::Goals, "Where streets want to be", goals),
        (RuleKind::Constraints, "What every street keeps to: a list of steps", constraints),
    ];
    for (kind, about, ask) in once {
        let desk = desk.clone();
        FuncRegistration::new(kind.function())
            .with_params_info(["this"])
            .with_comments([format!("/// {about}: what `fn {}` answers.", kind.form())])
            .register_into_engine(engine, move |rule: &mut Rule| -> Answered {
                decides(rule, kind)?;
                let told = ask(rule)?;
                desk.read(kind.function(), &answer::line(&told));
                Ok(told)
            });
    }
}

type Ask = fn(&Rule, Map) -> Result<Dynamic, Complaint>;
type AskOnce = fn(&Rule) -> Result<Dynamic, Complaint>;

fn decides(rule: &Rule, kind: RuleKind) -> Result<(), Complaint> {
    let told = crate::plan::decides(rule, kind);
    told.map_err(|(message, help)| Complaint::new(message).maybe_hint(help))
}

/// The fault of a rule that was asked, if there was one.
fn asked<T>(faults: &Faults, answer: T) -> Result<T, Complaint> {
    match faults.sorted().into_iter().next() {
        Some(fault) => Err(Complaint::of(crate::Fault { place: None, ..fault })),
        None => Ok(answer),
    }
}

fn class_of(options: &mut Options) -> Result<Class, Complaint> {
    let classes = Classes::default();
    let names: Vec<(&str, Class)> = classes.iter().map(|(class, info)| (info.name.as_str(), class)).collect();
    Ok(word(options, "class", &names)?.unwrap_or(Classes::MINOR))
}

fn whole(options: &mut Options, key: &str, other: u32) -> Result<u32, Complaint> {
    Ok(options.within(key, 0.0, 1e9, "")?.map_or(other, |value| value.round() as u32))
}

fn seed_of(options: &mut Options) -> Result<Seed, Complaint> {
    Ok(Seed(options.seed()?.unwrap_or(1)))
}

const TIP: [&str; 13] = [
    "at",
    "heading",
    "age",
    "generation",
    "step",
    "street_length",
    "width",
    "class",
    "is_seed",
    "seed",
    "home",
    "home_heading",
    "on",
];

fn propose(rule: &Rule, options: Map) -> Result<Dynamic, Complaint> {
    let mut options = Options::new("a tip", options, &TIP)?;
    let place = Place::of(options.take("on"))?;
    let at = options.place("at")?.unwrap_or(place.middle());
    let far = || Complaint::new("a tip cannot lie more than 500 km away").key("at");
    let class = class_of(&mut options)?;
    let tip = Tip {
        at: Point::try_from_metres(at).ok_or_else(far)?,
        heading: Angle::degrees(options.number("heading")?.unwrap_or(0.0)),
        is_seed: options.flag("is_seed")?.unwrap_or(false),
        age: whole(&mut options, "age", 3)?,
        generation: whole(&mut options, "generation", 0)?,
        step: whole(&mut options, "step", 10)?,
        length: options.number("street_length")?.unwrap_or(300.0),
        width: options.number("width")?.unwrap_or(12.0),
        home: Home {
            at: options.place("home")?.unwrap_or(place.middle()),
            heading: Angle::degrees(options.number("home_heading")?.unwrap_or(0.0)),
        },
        ..Tip::new(class, seed_of(&mut options)?, place.fields())
    };
    let faults = Arc::new(Faults::default());
    let pattern = StreetPattern::new(place.settled(rule)?, 0, Arc::default(), faults.clone());
    let mut tip = tip;
    pattern.propose(&mut tip);
    // Whether a rule proposes anything at all is no question for one call.
    let slots = asked(&faults, tip.slots)?;
    let slot =
        |slot: Option<Slot>| slot.and_then(Slot::kept).map_or(Dynamic::UNIT, |slot| Dynamic::from(slot_map(slot)));
    let mut map = Map::new();
    map.insert("heading".into(), degrees(tip.steered()));
    map.insert("field".into(), slots.steer.map_or(Dynamic::from(String::new()), |steer| field(steer).into()));
    for (name, value) in [("ahead", slots.ahead), ("left", slots.left), ("right", slots.right)] {
        map.insert(name.into(), slot(value));
    }
    Ok(map.into())
}

fn degrees(angle: Angle) -> Dynamic {
    angle.wrapped().to_degrees().into()
}

fn slot_map(slot: Slot) -> Map {
    let mut map = Map::from([("length".into(), slot.length.into()), ("turn".into(), degrees(slot.turn))]);
    map.insert("delay".into(), i64::from(slot.delay).into());
    map.insert("width".into(), slot.width.map_or(Dynamic::UNIT, Dynamic::from));
    map
}

/// A field as scripts write it.
fn field(steer: Steer) -> String {
    let number = answer::number;
    let heading = |angle: Angle| number(angle.wrapped().to_degrees());
    match steer {
        Steer::Cross { heading: angle, folds } => format!("cross({}, {folds})", heading(angle)),
        Steer::Raster { heading: angle, along, across, origin } => {
            let [along, across, x, y] = [along, across, origin.x, origin.y].map(number);
            format!("raster({}, {along}, {across}, {x}, {y})", heading(angle))
        }
        Steer::Rings(rings) => {
            let [x, y, inner, spacing, arc, chord] =
                [rings.centre.x, rings.centre.y, rings.inner, rings.spacing, rings.arc, rings.chord].map(number);
            format!(
                "rings({x}, {y}, #{{ inner: {inner}, spacing: {spacing}, rays: {}, arc: {arc}, chord: {chord} }})",
                rings.rays
            )
        }
    }
}

fn constrain(rule: &Rule, options: Map) -> Result<Dynamic, Complaint> {
    let mut options =
        Options::new("a segment", options, &["from", "to", "class", "level", "meets_street", "seed", "on"])?;
    let place = Place::of(options.take("on"))?;
    let from = options.place("from")?.unwrap_or(place.middle());
    let to = options.place("to")?.unwrap_or(from + Vec2::new(60.0, 0.0));
    let class = class_of(&mut options)?;
    let mut draft = Draft {
        id: geom::Id::default(),
        from,
        to,
        heading: Angle::of(to - from),
        class,
        level: options.within("level", -10.0, 10.0, "")?.unwrap_or(0.0).round() as i8,
        meets_street: options.flag("meets_street")?.unwrap_or(false),
        seed: seed_of(&mut options)?,
        fields: place.fields(),
        refused: None,
    };
    let faults = Arc::new(Faults::default());
    ConstraintPattern::new(place.settled(rule)?, Arc::default(), faults.clone()).constrain(&mut draft);
    let draft = asked(&faults, draft)?;
    // Reasons carry the rule's name for the report; here it is known.
    let why = draft.refused.as_deref().unwrap_or_default();
    let why = why.strip_prefix(rule.name()).and_then(|rest| rest.strip_prefix(": ")).unwrap_or(why);
    let mut map = Map::from([("refused".into(), why.to_owned().into()), ("length".into(), draft.length().into())]);
    map.insert("heading".into(), degrees(Angle::of(draft.to - draft.from)));
    map.insert("to".into(), vec![Dynamic::from(draft.to.x), Dynamic::from(draft.to.y)].into());
    Ok(map.into())
}

/// The streets that a block or a parcel fronts, a minor as long as its front where nothing is told: `streets: [#{ class: "major", width: 30, length: 40 }]`.
fn sides(options: &mut Options, front: f64) -> Result<Vec<StreetSide>, Complaint> {
    let side = |value: Dynamic| -> Result<StreetSide, Complaint> {
        let map = value.try_cast::<Map>();
        let map =
            map.ok_or_else(|| Complaint::new("a street is told by #{ class: \"major\", width: 30, length: 40 }"))?;
        let mut options = Options::new("a street", map, &["class", "width", "length"])?;
        let class = class_of(&mut options)?;
        let info = Classes::default();
        Ok(StreetSide {
            class: info.info(class).name.as_str().into(),
            width: options.number("width")?.unwrap_or(12.0),
            length: options.number("length")?.unwrap_or(20.0),
        })
    };
    if !options.has("streets") {
        return Ok(vec![StreetSide { class: "minor".into(), width: 12.0, length: front }]);
    }
    options.list("streets")?.into_iter().map(side).collect::<Result<_, _>>().map_err(|wrong| wrong.key("streets"))
}

const BLOCK: [&str; 11] = [
    "area",
    "length",
    "width",
    "longest_side",
    "perimeter",
    "density",
    "district",
    "streets",
    "distances",
    "at",
    "seed",
];

fn subdivide(rule: &Rule, mut options: Map) -> Result<Dynamic, Complaint> {
    let place = Place::of(options.remove("on"))?;
    let mut options = Options::new("a block", options, &BLOCK)?;
    let at = options.place("at")?.unwrap_or(place.middle());
    let area = options.within("area", 0.0, 1e9, " m²")?;
    let (length, width) = (options.number("length")?, options.number("width")?);
    let area = area.unwrap_or(length.unwrap_or(100.0) * width.unwrap_or(80.0));
    let length = length.unwrap_or_else(|| width.map_or(area.sqrt(), |width| area / width));
    let width = width.unwrap_or(area / length);
    let bare = BlockContext::bare(area, seed_of(&mut options)?);
    let block = BlockContext {
        perimeter: options.number("perimeter")?.unwrap_or(2.0 * (length + width)),
        density: options.number("density")?.unwrap_or(place.density(at)),
        place: at,
        district: options.text("district")?.unwrap_or(place.district(at)),
        extent: Vec2::new(length, width),
        longest_side: options.number("longest_side")?.unwrap_or(length),
        streets: sides(&mut options, 2.0 * (length + width))?,
        ground: place.ground(options.map("distances")?)?,
        ..bare
    };
    let faults = Arc::new(Faults::default());
    let choice = ParcelPattern::new(place.settled(rule)?, faults.clone()).choose(block);
    Ok(match asked(&faults, choice)? {
        ParcelChoice::Open => Map::from([("choice".into(), "open".into())]).into(),
        ParcelChoice::Whole => Map::from([("choice".into(), "whole".into())]).into(),
        ParcelChoice::Recursive(settings) => recursive(settings).into(),
    })
}

fn recursive(settings: RecursiveSettings) -> Map {
    let squared = match settings.squared {
        Squared::Best => "best",
        Squared::Side => "side",
        Squared::Street => "street",
    };
    let inner = match settings.inner {
        Inner::Open => "open",
        Inner::Built => "built",
    };
    let numbers = [
        ("least_area", settings.least_area),
        ("most_area", settings.most_area),
        ("spread", settings.spread),
        ("least_frontage", settings.least_frontage),
        ("irregularity", settings.irregularity),
        ("forced_access", settings.forced_access),
        ("least_convexity", settings.least_convexity),
    ];
    let mut map: Map = numbers.into_iter().map(|(name, value)| (name.into(), Dynamic::from(value))).collect();
    map.insert("choice".into(), "recursive".into());
    map.insert("squared".into(), squared.into());
    map.insert("inner".into(), inner.into());
    map.insert("join".into(), settings.join.into());
    map
}

const SHAPE: [&str; 13] = [
    "area",
    "width",
    "depth",
    "is_corner",
    "density",
    "max_height",
    "district",
    "landmark",
    "tags",
    "streets",
    "distances",
    "at",
    "seed",
];

/// A parcel as options tell it.
fn shape(place: &Place, options: Map) -> Result<ShapeContext, Complaint> {
    let mut options = Options::new("a parcel", options, &SHAPE)?;
    let at = options.place("at")?.unwrap_or(place.middle());
    let area = options.within("area", 0.0, 1e9, " m²")?;
    let (width, depth) = (options.number("width")?, options.number("depth")?);
    let area = area.unwrap_or(width.unwrap_or(20.0) * depth.unwrap_or(25.0));
    let width = width.unwrap_or_else(|| depth.map_or(area.sqrt(), |depth| area / depth));
    Ok(ShapeContext {
        extent: Vec2::new(width, depth.unwrap_or(area / width)),
        is_corner: options.flag("is_corner")?.unwrap_or(false),
        streets: sides(&mut options, width)?,
        density: options.number("density")?.unwrap_or(place.density(at)),
        max_height: options.number("max_height")?.unwrap_or(place.max_height(at)),
        place: at,
        district: options.text("district")?.unwrap_or(place.district(at)),
        landmark: options.text("landmark")?.unwrap_or_default(),
        tags: options
            .list("tags")?
            .into_iter()
            .map(|tag| Ok(text(tag, "tags")?.into()))
            .collect::<Result<_, Complaint>>()?,
        ground: place.ground(options.map("distances")?)?,
        ..ShapeContext::bare(area, seed_of(&mut options)?)
    })
}

fn build(rule: &Rule, mut options: Map) -> Result<Dynamic, Complaint> {
    let place = Place::of(options.remove("on"))?;
    let shape = shape(&place, options)?;
    let faults = Arc::new(Faults::default());
    let choice = BuildingPattern::new(place.settled(rule)?, faults.clone()).choose(shape);
    Ok(match asked(&faults, choice)? {
        BuildingChoice::None => Map::from([("height".into(), Dynamic::from(0.0))]).into(),
        BuildingChoice::Extrude(envelope) => envelope_map(envelope).into(),
    })
}

fn assign(rule: &Rule, mut options: Map) -> Result<Dynamic, Complaint> {
    let place = Place::of(options.remove("on"))?;
    let shape = shape(&place, options)?;
    let faults = Arc::new(Faults::default());
    let told = asked(&faults, AssignPattern::new(place.settled(rule)?, faults.clone()).assign(shape))?;
    let usage = match told.usage {
        None | Some(Use::Built) => "built",
        Some(Use::Open) => "open",
        Some(Use::Park) => "park",
        Some(Use::Plaza) => "plaza",
    };
    let tags: Array = told.tags.iter().map(|tag| Dynamic::from(tag.to_string())).collect();
    Ok(Map::from([("usage".into(), usage.into()), ("tags".into(), tags.into())]).into())
}

fn envelope_map(envelope: Envelope) -> Map {
    let (front, side, rear) = match envelope.setbacks {
        Setbacks::Even(distance) => (distance, distance, distance),
        Setbacks::Sides { front, side, rear } => (front, side, rear),
    };
    let numbers = [
        ("height", envelope.height),
        ("front", front),
        ("side", side),
        ("rear", rear),
        ("coverage", envelope.coverage),
    ];
    numbers.into_iter().map(|(name, value)| (name.into(), Dynamic::from(value))).collect()
}

fn goals(rule: &Rule) -> Result<Dynamic, Complaint> {
    let goal = crate::words::goal_of(rule).map_err(Complaint::of)?;
    let number = |value: &crate::Value| match value.constant() {
        Some(crate::Literal::Number(number)) => Dynamic::from(*number),
        _ => Dynamic::from(value.to_string()),
    };
    let mut map = Map::from([("map".into(), goal.map.name.clone().into()), ("consume".into(), goal.consume.into())]);
    map.insert("least".into(), number(&goal.least));
    map.insert("full".into(), goal.full.as_ref().map_or(Dynamic::UNIT, number));
    map.insert("pace".into(), number(&goal.pace));
    Ok(map.into())
}

fn constraints(rule: &Rule) -> Result<Dynamic, Complaint> {
    let own = |rule: &Rule| Own(Arc::new(ConstraintPattern::new(rule.clone(), Arc::default(), Arc::default())));
    let none = Chain::new(Vec::new());
    let chain = crate::words::chain_of(std::slice::from_ref(rule), none, &own).map_err(Complaint::of)?;
    let steps: Array = chain.steps().iter().map(|step| Dynamic::from(step_text(step))).collect();
    Ok(steps.into())
}

/// A step as scripts write it, every value told.
fn step_text(step: &Step) -> String {
    let number = answer::number;
    let degrees = |angle: Angle| number(angle.to_degrees());
    match step {
        Step::Length(length) => format!("length({}, {})", number(length.least), number(length.longest)),
        Step::Legal(legal) => {
            let mut text = format!(
                "legal(#{{ prune: {}, turn_step: {}, turn_most: {}, turn_first: {}",
                number(legal.prune),
                degrees(legal.turns.step),
                degrees(legal.turns.most),
                legal.turns_first
            );
            if let Some(bridge) = legal.bridge {
                text += &format!(
                    ", bridge: {}, bridge_spacing: {}, bridge_over: {:?}, bridge_first: {}",
                    number(bridge.longest),
                    number(bridge.spacing),
                    bridge.over,
                    bridge.is_first
                );
            }
            text + " })"
        }
        Step::Slope(slope) => format!(
            "slope({}, #{{ turn_step: {}, turn_most: {}, hairpin: {}, tunnel: {} }})",
            number(slope.most),
            degrees(slope.turns.step),
            degrees(slope.turns.most),
            slope.has_hairpins,
            number(slope.tunnel)
        ),
        Step::Mask(streets::growth::Area::Map(name)) => format!("mask({name})"),
        Step::Mask(streets::growth::Area::Polygon(polygon)) => format!("mask({} corners)", polygon.outer.len()),
        Step::Crossing => "crossing()".into(),
        Step::Snap(metres) => format!("snap({})", number(*metres)),
        Step::Extend(extend) => format!("extend({}, {})", number(extend.factor), number(extend.most)),
        Step::Join(metres) => format!("join({})", number(*metres)),
        Step::Duplicate(twin) => format!("duplicate({}, #{{ whole: {} }})", number(twin.within), twin.is_whole),
        Step::Angle(angle) => format!("angle({})", degrees(*angle)),
        Step::Arms(count) => format!("arms({count})"),
        Step::Own(_) => "own()".into(),
    }
}
