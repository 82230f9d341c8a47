//! Landmarks, and where streets of a stage grow, as city scripts tell them.

use crate::common::{city, headline};
use geom::Vec2;
use layout::Use;
use script::{Fault, Plan, Rim, Within};
use streets::Classes;

/// A city with one more option.
fn with(option: &str) -> Result<Plan, Fault> {
    let script = format!(
        "let site = site(\"maps\");\ncity(#{{\n  site: site,\n  \
         districts: site.districts(\"districts\", #{{ harbour: \"#2980b9\", none: \"#ffffff\" }}),\n  {option}\n}});"
    );
    city(&script).map(|evaluated| evaluated.plan)
}

fn plan(option: &str) -> Plan {
    with(option).unwrap_or_else(|fault| panic!("{option}: {fault}"))
}

fn says(option: &str) -> String {
    let fault = with(option).err().unwrap_or_else(|| panic!("`{option}` was taken"));
    format!("{} {}", headline(&fault), fault.hint.unwrap_or_default())
}

#[test]
fn a_landmark_has_ground_and_sensible_values() {
    let plan = plan(
        r#"landmarks: [landmark(#{ name: " Dome ", at: [500, 400] }),
            [landmark(#{ name: "Fort", outline: [[0, 0], [0, 90], [80, 90], [80, 0], [0, 0]], parcel: "park", attract: 0,
                         reach: 900, around: "major" })],
            landmark(#{ name: "Bath", at: [900, 100], size: [40, 20], heading: 90 })],"#,
    );
    let [dome, fort, bath] = plan.landmarks.as_slice() else { panic!("{:?}", plan.landmarks) };
    assert_eq!((dome.name.as_str(), dome.ground.area(), dome.middle()), ("Dome", 3600.0, Vec2::new(500.0, 400.0)));
    assert_eq!((dome.attract, dome.usage, dome.around), (1.0, Use::Plaza, None));
    assert_eq!((fort.ground.area(), fort.usage, fort.around), (7200.0, Use::Park, Some(Classes::MAJOR)));
    assert_eq!((fort.attract, fort.reach), (0.0, 900.0));
    let size = bath.ground.bounds().expect("ground").size();
    assert_eq!(size, Vec2::new(20.0, 40.0), "its width lies along its heading");
    assert!(dome.id() != fort.id());
}

#[test]
fn what_is_no_landmark_is_told_with_a_hint() {
    for (wrong, message) in [
        (r#"#{ at: [500, 400] }"#, "a landmark needs a `name`: it is known by it landmark(#{ name:"),
        (r#"#{ name: "  ", at: [500, 400] }"#, "a landmark needs a `name`"),
        (r#"#{ name: "A" }"#, "a landmark needs a place at: [x, y] with a size"),
        (r#"#{ name: "A", at: [1, 2], outline: [[0, 0], [9, 0], [9, 9]] }"#, "either an `outline` or a place"),
        (r#"#{ name: "A", outline: [[0, 0], [9, 9], [9, 0], [0, 9]] }"#, "its rim must not cross itself"),
        (r#"#{ name: "A", outline: [[0, 0], [2, 0], [0, 2]] }"#, "covers at least 16 m², not 2.0"),
        (r#"#{ name: "A", at: [1, 2], size: 0.5 }"#, "the sides of a landmark must lie between 4 and 20000 m"),
        (r#"#{ name: "A", at: [1, 2], size: "big" }"#, "a size is a number of metres, or [width, height]"),
        (r#"#{ name: "A", at: [1, 2], attract: -1 }"#, "`attract` must lie between 0 and 100"),
        (r#"#{ name: "A", at: [1, 2], parcel: "parc" }"#, "`parcel` must be one of"),
        (r#"#{ name: "A", at: [1, 2], around: "mayor" }"#, "there is no street class `mayor` did you mean `major`?"),
        (r#"#{ name: "A", att: [1, 2] }"#, "landmark has no option `att`"),
    ] {
        let said = says(&format!("landmarks: landmark({wrong}),"));
        assert!(said.contains(message), "{wrong}: {said}");
    }
    let two = |second: &str| {
        says(&format!(r#"landmarks: [landmark(#{{ name: "A", at: [50, 50] }}), landmark(#{{ {second} }})],"#))
    };
    assert!(two(r#"name: "A", at: [500, 500]"#).contains("two landmarks are called `A`"));
    assert!(two(r#"name: "B", at: [90, 90]"#).contains("the grounds of `A` and `B` overlap"));
    assert!(says("landmarks: [7],").contains("`landmarks` must be a landmark(#{ … }) or a list of them"));
}

/// What streets of a class are told to keep to.
fn minors(option: &str) -> script::StreetPlan {
    plan(&format!("minors: streets(#{{ pattern: rule(\"streets/grid\"), {option} }}),")).minors.expect("minors")
}

#[test]
fn stages_keep_to_maps_polygons_and_quarters() {
    let within = |option: &str| minors(option).within.expect("an area");
    assert!(matches!(within("within: site.map(\"borough\")"), Within::Map(map) if map.name == "borough"));
    for option in ["within: [[0, 0], [90, 0], [0, 80]]", "within: polygon([[0, 0], [90, 0], [0, 80], [0, 0]])"] {
        assert!(matches!(within(option), Within::Polygon(polygon) if polygon.area() == 3600.0), "{option}");
    }
    assert_eq!(within("within: quarters_at([[5, 6]])"), Within::QuartersAt(vec![Vec2::new(5.0, 6.0)]));
    assert_eq!(within("within: quarters_in(\"harbour\")"), Within::QuartersIn(vec!["harbour".into()]));
    assert_eq!(minors("").within, None);
    for (wrong, message) in [
        ("within: 7", "`within` must be a map, a polygon or a choice of quarters, not a whole number site.map("),
        ("within: [[0, 0], [9, 9]]", "a polygon needs at least three corners"),
        ("within: quarters_at([])", "quarters_at names no place"),
        ("within: quarters_at([7])", "a point is written [x, y] in metres"),
        ("within: quarters_in(7)", "quarters_in takes the name of a district"),
        ("within: quarters_in(\"habour\")", "minors.within differs in `habour`"),
    ] {
        let said = says(&format!("minors: streets(#{{ pattern: rule(\"streets/grid\"), {wrong} }}),"));
        assert!(said.contains(message), "{wrong}: {said}");
    }
    let said = says("majors: streets(#{ pattern: rule(\"streets/grid\"), within: quarters_in(\"harbour\") }),");
    assert!(said.contains("`majors` cannot keep to quarters"), "{said}");
}

#[test]
fn minors_have_a_rim() {
    assert_eq!(minors("").rim, None);
    assert_eq!(minors("rim: 300").rim, Some(Rim { width: 300.0, bulge: 0.0 }));
    assert_eq!(minors("rim: #{ width: 250.5, bulge: 0.4 }").rim, Some(Rim { width: 250.5, bulge: 0.4 }));
    for (wrong, message) in [
        ("minors: streets(#{ pattern: rule(\"streets/grid\"), rim: -1 }),", "`width` must lie between 0 and 100000 m"),
        ("minors: streets(#{ pattern: rule(\"streets/grid\"), rim: \"wide\" }),", "`rim` must be a number of metres"),
        ("minors: streets(#{ pattern: rule(\"streets/grid\"), rim: #{ bulge: 0.4 } }),", "`rim` needs a width"),
        (
            "minors: streets(#{ pattern: rule(\"streets/grid\"), rim: #{ width: 9, bulge: 2 } }),",
            "`bulge` must lie between 0 and 1",
        ),
        ("highways: streets(#{ pattern: rule(\"streets/grid\"), rim: 300 }),", "`highways` have no rim"),
    ] {
        let said = says(wrong);
        assert!(said.contains(message), "{wrong}: {said}");
    }
}
