//! Parcel and building rules, and what is left of a failing one.

use crate::common::rule;
use buildings::{Envelope, Setbacks};
use geom::{Seed, Vec2};
use layout::{Inner, RecursiveSettings, Squared};
use script::{
    BlockContext, BuildingChoice, BuildingPattern, Fault, Faults, Ground, Host, ParcelChoice, ParcelPattern,
    ShapeContext, StreetSide,
};
use std::sync::Arc;

const SEED: Seed = Seed(11);
const PLACE: Vec2 = Vec2::new(5.0, 6.0);

/// Two streets, 20 m of frontage.
fn streets() -> Vec<StreetSide> {
    let side = |class: &str, width, length| StreetSide { class: class.into(), width, length };
    vec![side("minor", 12.0, 12.0), side("major", 30.0, 8.0)]
}

/// A map of zones and one of noise; a major 70 m away.
#[derive(Debug)]
struct Town;

impl Ground for Town {
    fn map(&self, name: &str, at: Vec2) -> Option<f64> {
        (name == "noise").then_some(at.x + 0.25)
    }

    fn zone(&self, name: &str, _: Vec2) -> Option<f64> {
        (name == "zones").then_some(2.0)
    }

    fn maps(&self) -> Vec<String> {
        vec!["noise".into(), "zones".into()]
    }

    fn distance(&self, class: &str, _: Vec2) -> Option<f64> {
        (class == "major").then_some(70.0)
    }

    fn classes(&self) -> Vec<String> {
        vec!["major".into(), "minor".into()]
    }
}

fn parcel() -> ShapeContext {
    ShapeContext {
        extent: Vec2::new(15.0, 20.0),
        is_corner: true,
        streets: streets(),
        density: 900.0,
        max_height: 50.0,
        place: PLACE,
        ground: Arc::new(Town),
        ..ShapeContext::bare(300.0, SEED)
    }
}

fn boxed(height: f64, setback: f64) -> BuildingChoice {
    BuildingChoice::Extrude(Envelope { height, setbacks: Setbacks::Even(setback), coverage: 1.0 })
}

fn subdivided(body: &str) -> (ParcelChoice, Vec<Fault>) {
    let faults = Arc::new(Faults::default());
    let rule = rule(&format!("fn subdivide(block, p) {{ {body} }}")).unwrap_or_else(|fault| panic!("{fault}"));
    let block = BlockContext {
        perimeter: 140.0,
        density: 900.0,
        place: PLACE,
        extent: Vec2::new(40.0, 32.0),
        streets: streets(),
        ground: Arc::new(Town),
        ..BlockContext::bare(1200.0, SEED)
    };
    (ParcelPattern::new(rule, faults.clone()).choose(block), faults.sorted())
}

fn built(body: &str) -> (BuildingChoice, Vec<Fault>) {
    let faults = Arc::new(Faults::default());
    let rule = rule(&format!("fn build(shape, p) {{ {body} }}")).unwrap_or_else(|fault| panic!("{fault}"));
    (BuildingPattern::new(rule, faults.clone()).choose(parcel()), faults.sorted())
}

#[test]
fn blocks_are_known_and_told() {
    assert_eq!(subdivided("block.open()"), (ParcelChoice::Open, vec![]));
    assert_eq!(subdivided("block.whole()"), (ParcelChoice::Whole, vec![]));
    assert_eq!(subdivided(""), (ParcelChoice::Whole, vec![]));
    let told = "block.recursive(#{ least_area: block.area / 10, most_area: block.perimeter * 10, least_frontage: 9, \
                irregularity: block.chance(3) * 0.4 })";
    let wanted = RecursiveSettings {
        least_area: 120.0,
        most_area: 1400.0,
        least_frontage: 9.0,
        irregularity: SEED.unit(3) * 0.4,
        seed: SEED,
        ..RecursiveSettings::default()
    };
    assert_eq!(subdivided(told), (ParcelChoice::Recursive(wanted), vec![]));
}

#[test]
fn every_control_of_the_division_arrives() {
    let told = "block.recursive(#{ spread: 0.3, forced_access: 0.5, least_convexity: 0.9, squared: \"street\", \
                join: false, inner: \"built\" })";
    let wanted = RecursiveSettings {
        spread: 0.3,
        forced_access: 0.5,
        least_convexity: 0.9,
        squared: Squared::Street,
        join: false,
        inner: Inner::Built,
        seed: SEED,
        ..RecursiveSettings::default()
    };
    assert_eq!(subdivided(told), (ParcelChoice::Recursive(wanted), vec![]));
}

/// What a block and a parcel both know of their place: a word, and what it is here.
#[test]
fn places_are_known() {
    for (word, value) in [
        ("map(\"noise\")", 5.25),
        ("zone(\"zones\")", 2.0),
        ("zone", 2.0),
        ("frontage", 20.0),
        ("fronts(\"major\")", 8.0),
        ("street_width", 30.0),
        ("distance(\"major\")", 70.0),
        ("x", 5.0),
        ("y", 6.0),
    ] {
        let body = format!("block.recursive(#{{ least_area: block.{word} }})");
        let (choice, faults) = subdivided(&body);
        let ParcelChoice::Recursive(settings) = choice else { panic!("{word}: {faults:?}") };
        assert_eq!(settings.least_area, value, "{word}");
        assert_eq!(built(&format!("shape.extrude(1 + shape.{word})")), (boxed(1.0 + value, 0.0), vec![]), "{word}");
    }
    let body = "if block.classes == [\"major\", \"minor\"] && block.has_map(\"noise\") && !block.has_map(\"land\") { block.open() }";
    assert_eq!(subdivided(body), (ParcelChoice::Open, vec![]));
}

#[test]
fn blocks_and_parcels_know_their_form() {
    let body = "block.recursive(#{ least_area: block.length, most_area: 100 * block.rectangularity + block.width, \
                least_frontage: block.longest_side })";
    let (choice, faults) = subdivided(body);
    let ParcelChoice::Recursive(settings) = choice else { panic!("{faults:?}") };
    assert_eq!((settings.least_area, settings.least_frontage), (40.0, 1200f64.sqrt()));
    assert!((settings.most_area - (100.0 * 1200.0 / 1280.0 + 32.0)).abs() < 1e-9);
    let body = "if shape.is_corner && !shape.is_inner { shape.extrude(shape.width + 2 * shape.depth) }";
    assert_eq!(built(body), (boxed(55.0, 0.0), vec![]));
}

#[test]
fn envelopes_are_told_by_side() {
    let envelope = |front, side, rear, coverage| {
        BuildingChoice::Extrude(Envelope { height: 9.0, setbacks: Setbacks::Sides { front, side, rear }, coverage })
    };
    let told = "shape.extrude(9, #{ front: 4, side: 2, rear: 6, coverage: 0.5 })";
    assert_eq!(built(told), (envelope(4.0, 2.0, 6.0, 0.5), vec![]));
    assert_eq!(built("shape.extrude(9, #{ rear: 6 })"), (envelope(0.0, 0.0, 6.0, 1.0), vec![]));
}

#[test]
fn what_a_place_does_not_have_is_said_with_a_hint() {
    for (body, message, hint) in [
        ("block.map(\"nose\")", "the site has no map `nose`", "did you mean `noise`?"),
        ("block.zone(\"land\")", "the site has no map `land`", "there are `noise`, `zones`"),
        ("block.distance(\"mayor\")", "there is no street class `mayor`", "did you mean `major`?"),
        (
            "block.recursive(#{ squared: \"sides\" })",
            "`squared` must be one of `best`, `side`, `street`, not `sides`",
            "did you mean `side`?",
        ),
    ] {
        let (_, faults) = subdivided(body);
        assert_eq!((faults[0].message.as_str(), faults[0].hint.as_deref()), (message, Some(hint)), "{body}");
    }
}

/// The height that a rule of the library gives a parcel, 0 for nothing.
fn zoned(change: impl Fn(&mut ShapeContext), sets: &[(&str, &str)]) -> f64 {
    let faults = Arc::new(Faults::default());
    let rule = Host::new(vec![]).rule("buildings/zoned").expect("the library has it");
    let set =
        |rule: script::Rule, (name, text): &(&str, &str)| rule.with_text(name, text).expect("it has this parameter");
    let mut shape = ShapeContext { max_height: f64::INFINITY, density: 20_000.0, ..parcel() };
    (shape.area, shape.extent) = (1600.0, Vec2::splat(40.0));
    change(&mut shape);
    let rule = sets.iter().fold(rule.with_text("empty", "0").expect("it has this parameter"), set);
    let choice = BuildingPattern::new(rule, faults.clone()).choose(shape);
    assert!(faults.is_empty(), "{:?}", faults.sorted());
    if let BuildingChoice::Extrude(envelope) = choice { envelope.height } else { 0.0 }
}

#[test]
fn zones_decide_what_is_built() {
    // The town is all zone 2.
    let as_zone = |zone: &str| zoned(|_| {}, &[(zone, "2"), ("main_street", "0")]);
    let others = [("residential", "7"), ("commercial", "7"), ("skyscraper", "7")];
    let only = |zone: &'static str| {
        let sets: Vec<_> =
            others.into_iter().map(|(name, other)| (name, if name == zone { "2" } else { other })).collect();
        zoned(|_| {}, &[sets.as_slice(), &[("main_street", "0")]].concat())
    };
    let (house, shop, tower) = (only("residential"), only("commercial"), only("skyscraper"));
    assert!(0.0 < house && house < shop && shop < tower, "{house} {shop} {tower}");
    assert_eq!(only("none"), 0.0);
    assert_eq!(as_zone("commercial"), shop);
    // Without a map of zones density decides, and majors bring commerce.
    let by_density = |density: f64, sets: &[(&str, &str)]| {
        zoned(|shape| shape.density = density, &[&[("zones", "nothing")], sets].concat())
    };
    assert!(
        by_density(1000.0, &[]) < by_density(20_000.0, &[]) && by_density(20_000.0, &[]) < by_density(50_000.0, &[])
    );
    assert!(by_density(1000.0, &[]) < by_density(1000.0, &[("main_street", "100")]));
}

#[test]
fn each_limit_of_the_zoned_rule_acts() {
    let tower = [("skyscraper", "2"), ("commercial", "7")];
    let with = |sets: &[(&str, &str)]| zoned(|_| {}, &[&tower, sets].concat());
    let plain = with(&[]);
    assert!(with(&[("tower_floors", "20")]) < plain);
    assert!(with(&[("slenderness", "1")]) <= 40.0);
    assert!(with(&[("tower_area", "5000")]) < plain, "too small for a tower");
    assert_eq!(with(&[("least_area", "5000")]), 0.0);
    assert_eq!(with(&[("empty", "1")]), 0.0);
    assert_eq!(zoned(|shape| shape.max_height = 11.0, &tower), 11.0);
    assert_eq!(zoned(|shape| shape.max_height = 1.0, &tower), 0.0);
}

#[test]
fn a_failing_rule_leaves_one_parcel() {
    let cases = [
        ("block.recursive(#{ least_aera: 3 });", "block.recursive has no option `least_aera`"),
        ("block.recursive(#{ most_area: \"x\" });", "`most_area` must be a number, not a text"),
        (
            "block.recursive(#{ least_area: 900, most_area: 200 });",
            "least_area (900 m²) is greater than most_area (200 m²)",
        ),
        ("block.open(); loop { }", "stopped after 100000 operations"),
    ];
    for (body, message) in cases {
        let (choice, faults) = subdivided(body);
        assert_eq!(choice, ParcelChoice::Whole, "{body}");
        assert_eq!((faults[0].message.as_str(), faults[0].place), (message, Some(PLACE)), "{body}");
    }
}

#[test]
fn shapes_are_known_and_told() {
    assert_eq!(built("shape.none()"), (BuildingChoice::None, vec![]));
    assert_eq!(built(""), (BuildingChoice::None, vec![]));
    assert_eq!(built("shape.extrude(min(shape.area, shape.max_height))"), (boxed(50.0, 0.0), vec![]));
    let wanted = boxed(20.0 + SEED.range(1, 2.0, 4.0), 2.5);
    assert_eq!(built("shape.extrude(shape.frontage + shape.chance(1, 2, 4), #{ setback: 2.5 })"), (wanted, vec![]));
}

#[test]
fn a_failing_rule_leaves_a_plain_box() {
    for (body, message) in [
        ("shape.extrude(0);", "the height must lie between 0.1 and 3000 m"),
        ("shape.extrude(9, #{ setbakc: 1 });", "shape.extrude has no option `setbakc`"),
        ("shape.extrude(9, #{ setback: 1, rear: 3 });", "`setback` holds on all sides, so `rear` says it twice"),
        ("shape.extrude(9, #{ coverage: 2 });", "`coverage` must lie between 0 and 1 of the parcel"),
        ("shape.none(); throw \"no\";", "no"),
    ] {
        let (choice, faults) = built(body);
        assert_eq!((choice, faults[0].message.as_str()), (BuildingChoice::PLAIN, message), "{body}");
    }
}

/// A parameter, another value for it, and what must be set otherwise for it to count.
type Turn = (&'static str, &'static str, &'static [(&'static str, &'static str)]);

/// Whether each parameter of a rule of the library changes what it decides in some of the cases.
fn assert_all_act<C: PartialEq + std::fmt::Debug>(name: &str, turns: &[Turn], decide: impl Fn(script::Rule) -> Vec<C>) {
    let rule = Host::new(vec![]).rule(name).expect("the library has it");
    let known: Vec<&str> = rule.params().iter().map(|(param, _)| param.name.as_str()).collect();
    assert_eq!(known, turns.iter().map(|turn| turn.0).collect::<Vec<_>>(), "{name}: all parameters, in order");
    let set = |rule: script::Rule, (name, text): &(&str, &str)| rule.with_text(name, text).expect("a value in range");
    for (param, text, given) in turns {
        let rule = given.iter().fold(rule.clone(), set);
        let changed = decide(set(rule.clone(), &(param, text)));
        assert_ne!(changed, decide(rule), "{name}: {param} does nothing");
    }
}

/// Land where zones are numbered, and land where density decides.
fn grounds() -> [Arc<dyn Ground>; 2] {
    [Arc::new(Town), Arc::new(script::BareGround)]
}

fn all_blocks(rule: script::Rule) -> Vec<ParcelChoice> {
    let faults = Arc::new(Faults::default());
    let pattern = ParcelPattern::new(rule, faults.clone());
    let mut choices = Vec::new();
    for (area, density) in [(160.0, 500.0), (600.0, 9_000.0), (20_000.0, 20_000.0), (20_000.0, 50_000.0)] {
        for ground in grounds() {
            choices.push(pattern.choose(BlockContext { density, ground, ..BlockContext::bare(area, SEED) }));
        }
    }
    for density in [500.0, 9_000.0] {
        choices.push(pattern.choose(BlockContext { density, ..BlockContext::bare(20_000.0, SEED) }));
    }
    assert!(faults.is_empty(), "{:?}", faults.sorted());
    choices
}

fn all_parcels(rule: script::Rule) -> Vec<BuildingChoice> {
    let faults = Arc::new(Faults::default());
    let pattern = BuildingPattern::new(rule, faults.clone());
    let mut choices = Vec::new();
    for (area, max_height) in [(50.0, 90.0), (300.0, 90.0), (1600.0, 900.0)] {
        for (density, seed) in [(500.0, 1), (9_000.0, 2), (20_000.0, 3), (50_000.0, 4), (50_000.0, 5)] {
            for ground in grounds() {
                let bare = ShapeContext::bare(area, Seed(seed));
                choices.push(pattern.choose(ShapeContext { density, max_height, ground, ..bare }));
            }
        }
    }
    assert!(faults.is_empty(), "{:?}", faults.sorted());
    choices
}

#[test]
fn every_parameter_of_the_parcel_rules_acts() {
    let recursive = [
        ("least_area", "200"),
        ("most_area", "500"),
        ("spread", "0.3"),
        ("least_frontage", "12"),
        ("irregularity", "0.2"),
        ("forced_access", "0.5"),
        ("least_convexity", "0.9"),
        ("squared", "side"),
        ("join", "false"),
        ("inner", "built"),
    ];
    assert_all_act("parcels/recursive", &recursive.map(|(param, text)| -> Turn { (param, text, &[]) }), all_blocks);
    let zoned: [Turn; 12] = [
        ("zones", "nothing", &[]),
        ("residential", "2", &[("commercial", "7")]),
        ("commercial", "7", &[]),
        ("skyscraper", "2", &[]),
        ("busy", "5000", &[]),
        ("crowded", "60000", &[]),
        ("main_street", "100", &[("commercial", "7"), ("residential", "2")]),
        ("house", "400", &[]),
        ("garden", "3000", &[]),
        ("shop", "2000", &[]),
        ("tower", "5000", &[]),
        ("irregularity", "0.3", &[]),
    ];
    assert_all_act("parcels/zoned", &zoned, all_blocks);
}

#[test]
fn every_parameter_of_the_zoned_buildings_acts() {
    let turns: [Turn; 19] = [
        ("zones", "nothing", &[]),
        ("residential", "2", &[("commercial", "7")]),
        ("commercial", "7", &[]),
        ("skyscraper", "2", &[]),
        ("busy", "5000", &[]),
        ("crowded", "60000", &[]),
        ("main_street", "100", &[("commercial", "7"), ("residential", "2")]),
        ("floor", "4", &[]),
        ("house_floors", "9", &[]),
        ("shop_floors", "20", &[]),
        ("tower_floors", "90", &[]),
        ("tower_area", "5000", &[]),
        ("least_area", "400", &[]),
        ("slenderness", "1", &[]),
        ("front", "1", &[]),
        ("side", "1", &[]),
        ("rear", "1", &[]),
        ("coverage", "0.2", &[]),
        ("empty", "0.7", &[]),
    ];
    assert_all_act("buildings/zoned", &turns, all_parcels);
}
