//! Parcel and building rules, and what is left of a failing one.

mod common;

use common::rule;
use geom::{Seed, Vec2};
use layout::RecursiveSettings;
use script::{BlockContext, BuildingChoice, BuildingPattern, Fault, Faults, ParcelChoice, ParcelPattern, ShapeContext};
use std::sync::Arc;

const SEED: Seed = Seed(11);
const PLACE: Vec2 = Vec2::new(5.0, 6.0);

fn subdivided(body: &str) -> (ParcelChoice, Vec<Fault>) {
    let faults = Arc::new(Faults::default());
    let rule = rule(&format!("fn subdivide(block, p) {{ {body} }}")).unwrap_or_else(|fault| panic!("{fault}"));
    let block = BlockContext {
        area: 1200.0,
        perimeter: 140.0,
        density: 900.0,
        place: PLACE,
        district: String::new(),
        seed: SEED,
    };
    (ParcelPattern::new(rule, faults.clone()).choose(block), faults.sorted())
}

fn built(body: &str) -> (BuildingChoice, Vec<Fault>) {
    let faults = Arc::new(Faults::default());
    let rule = rule(&format!("fn build(shape, p) {{ {body} }}")).unwrap_or_else(|fault| panic!("{fault}"));
    let shape = ShapeContext {
        area: 300.0,
        frontage: 20.0,
        density: 900.0,
        max_height: 50.0,
        place: PLACE,
        district: String::new(),
        seed: SEED,
    };
    (BuildingPattern::new(rule, faults.clone()).choose(shape), faults.sorted())
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
    };
    assert_eq!(subdivided(told), (ParcelChoice::Recursive(wanted), vec![]));
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
    let wanted = BuildingChoice::Extrude { height: 50.0, setback: 0.0 };
    assert_eq!(built("shape.extrude(min(shape.area, shape.max_height))"), (wanted, vec![]));
    let wanted = BuildingChoice::Extrude { height: 20.0 + SEED.range(1, 2.0, 4.0), setback: 2.5 };
    assert_eq!(built("shape.extrude(shape.frontage + shape.chance(1, 2, 4), #{ setback: 2.5 })"), (wanted, vec![]));
}

#[test]
fn a_failing_rule_leaves_a_plain_box() {
    for (body, message) in [
        ("shape.extrude(0);", "the height must lie between 0.1 and 3000 m"),
        ("shape.extrude(9, #{ setbakc: 1 });", "shape.extrude has no option `setbakc`"),
        ("shape.none(); throw \"no\";", "no"),
    ] {
        let (choice, faults) = built(body);
        assert_eq!((choice, faults[0].message.as_str()), (BuildingChoice::PLAIN, message), "{body}");
    }
}
