//! What stages hang on: a change of the plan shows in the digests of the stages it matters to, and in no others.

use crate::common;
use script::{Plan, PlanDigests, heard};

const CITY: &str = r#"
city(#{
    site: site(#{ size: [500, 500] }),
    seed: 1,
    given: [line([[0, 0], [500, 500]])],
    majors: streets(#{ pattern: rule("streets/grid"), width: 20 }),
    minors: streets(#{ pattern: rule("streets/grid"), constraints: rule("constraints/standard"), width: 10 }),
    parcels: rule("parcels/recursive"),
    buildings: rule("buildings/extruded"),
    quarters: #{ "00000000000000000000000000000007": #{ seed: 5 } },
});
"#;

fn digests(text: &str) -> PlanDigests {
    common::city(text).expect("a plan").plan.digests()
}

/// Which of the four differ.
fn changed(before: PlanDigests, after: PlanDigests) -> [bool; 4] {
    let parts = |digests: PlanDigests| [digests.arterials, digests.minors, digests.parcels, digests.buildings];
    std::array::from_fn(|i| parts(before)[i] != parts(after)[i])
}

#[test]
fn a_change_shows_where_it_matters() {
    let before = digests(CITY);
    assert_eq!(before, digests(CITY));
    let edits: [(&str, &str, [bool; 4]); 10] = [
        ("seed: 1", "seed: 2", [true, false, false, false]),
        ("[500, 500]])]", "[500, 400]])]", [true, false, false, false]),
        ("rule(\"streets/grid\"), width: 20", "rule(\"streets/grid\"), width: 22", [true, false, false, false]),
        // The width of minors is that of a street around a landmark.
        ("width: 10", "width: 12", [true, true, false, false]),
        (
            "constraints: rule(\"constraints/standard\")",
            "constraints: rule(\"constraints/standard\", #{ snap: 9 })",
            [false, true, false, false],
        ),
        ("seed: 5", "seed: 6", [false, true, false, false]),
        ("#{ seed: 5 }", "#{ preset: preset(\"campus\") }", [false, true, false, false]),
        (
            "rule(\"parcels/recursive\")",
            "rule(\"parcels/recursive\", #{ least_area: 99 })",
            [false, false, true, false],
        ),
        ("rule(\"buildings/extruded\")", "rule(\"buildings/extruded\", #{ high: 9 })", [false, false, false, true]),
        ("size: [500, 500]", "size: [600, 500]", [false; 4]),
    ];
    for (from, to, expected) in edits {
        let edited = CITY.replacen(from, to, 1);
        assert_ne!(edited, CITY, "{from}");
        assert_eq!(changed(before, digests(&edited)), expected, "{to}");
    }
}

#[test]
fn what_is_set_afterwards_counts_too() {
    let mut plan: Plan = common::city(CITY).expect("a plan").plan;
    let before = plan.digests();
    plan.set("minors.pattern.block_width=90").expect("set");
    assert_eq!(changed(before, plan.digests()), [false, true, false, false]);
}

#[test]
fn faults_prints_and_marks_are_heard() {
    let faults = script::Faults::default();
    assert_eq!(heard(|| 5), (5, true));
    assert!(!heard(|| faults.report(script::Fault::new("a.rhai", "no"))).1);
    // What another thread does is not this one's.
    let of_another =
        || std::thread::scope(|scope| drop(scope.spawn(|| faults.report(script::Fault::new("a", "b"))).join()));
    assert!(heard(of_another).1);
}
