use super::*;
use crate::export::geojson::write_layout;
use crate::export::layout_file::{Feature, Geometry, parse_layout};
use crate::export::samples::small_city;

fn good() -> LayoutFile {
    let mut bytes = Vec::new();
    write_layout(&small_city(), &mut bytes).unwrap();
    parse_layout(&bytes, Path::new("good.geojson")).unwrap()
}

fn first<'a>(file: &'a mut LayoutFile, kind: &str) -> &'a mut Feature {
    nth(file, kind, 0)
}

fn nth<'a>(file: &'a mut LayoutFile, kind: &str, n: usize) -> &'a mut Feature {
    file.features.iter_mut().filter(|feature| feature.properties.kind.as_deref() == Some(kind)).nth(n).unwrap()
}

fn rings(feature: &mut Feature) -> &mut Vec<Vec<[f64; 2]>> {
    let Geometry::Polygon(rings) = &mut feature.geometry else { panic!("a polygon") };
    rings
}

fn line(feature: &mut Feature) -> &mut Vec<[f64; 2]> {
    let Geometry::LineString(line) = &mut feature.geometry else { panic!("a line") };
    line
}

fn shift(feature: &mut Feature, by: [f64; 2]) {
    for at in rings(feature).iter_mut().flatten() {
        *at = [at[0] + by[0], at[1] + by[1]];
    }
}

/// The rules violated after a change to a good layout.
fn broken_by(change: impl FnOnce(&mut LayoutFile)) -> Vec<&'static str> {
    let mut file = good();
    change(&mut file);
    check(&file, Until::Buildings).counts.into_keys().collect()
}

#[test]
fn a_good_layout_violates_nothing() {
    let report = check(&good(), Until::Buildings);
    assert!(report.is_valid(), "{report}");
    assert!(report.notes.is_empty());
    assert_eq!(report.features["block"], 12);
    assert!(report.to_string().ends_with("violations: 0"));
}

#[test]
fn ids_must_be_there_and_unique() {
    assert_eq!(broken_by(|file| first(file, "district").properties.id = None), ["ids"]);
    assert_eq!(
        broken_by(|file| {
            let twin = first(file, "district").clone();
            file.features.push(twin);
        }),
        ["ids"]
    );
}

#[test]
fn features_must_say_what_they_are() {
    assert_eq!(broken_by(|file| first(file, "street").properties.class = None), ["S"]);
    assert_eq!(broken_by(|file| first(file, "street").properties.width = Some(0.5)), ["S"]);
    assert_eq!(broken_by(|file| first(file, "building").properties.height = Some(0.0)), ["S"]);
    assert_eq!(broken_by(|file| first(file, "parcel").properties.access = None), ["S"]);
    assert_eq!(broken_by(|file| first(file, "street").properties.level = -1.0), ["S"]);
    assert_eq!(broken_by(|file| file.features.retain(|f| f.properties.kind.as_deref() != Some("building"))), ["S"]);
}

#[test]
fn until_says_what_must_be_there() {
    let mut file = good();
    file.features.retain(|feature| !matches!(feature.properties.kind.as_deref(), Some("parcel" | "building")));
    assert!(check(&file, Until::Streets).is_valid());
    assert_eq!(check(&file, Until::Parcels).counts["S"], 1);
    assert_eq!(check(&file, Until::Buildings).counts["S"], 2);
}

#[test]
fn streets_end_on_their_crossings() {
    assert_eq!(broken_by(|file| first(file, "street").properties.from = Some("nowhere".into()))[0], "V1");
    let moved = broken_by(|file| line(first(file, "street"))[0][0] += 0.5);
    assert!(moved.contains(&"V1"), "{moved:?}");
}

#[test]
fn streets_meet_at_shared_crossings_only() {
    let crossing = |file: &mut LayoutFile| {
        let middle = |l: &[[f64; 2]]| [(l[0][0] + l[1][0]) / 2.0, (l[0][1] + l[1][1]) / 2.0];
        let other = middle(line(nth(file, "street", 3)));
        line(nth(file, "street", 0)).insert(1, other);
    };
    let rules = broken_by(crossing);
    assert!(rules.contains(&"V1"), "{rules:?}");
    let doubled = broken_by(|file| {
        let mut twin = first(file, "street").clone();
        twin.properties.id = Some("twin".into());
        file.features.push(twin);
    });
    assert_eq!(doubled, ["V1"]);
    let looped = broken_by(|file| {
        let line = line(first(file, "street"));
        let (a, b) = (line[0], line[1]);
        let at = |t: f64, off: f64| {
            [a[0] + (b[0] - a[0]) * t - (b[1] - a[1]) * off, a[1] + (b[1] - a[1]) * t + (b[0] - a[0]) * off]
        };
        *line = vec![a, at(0.6, 0.05), at(0.6, -0.05), at(0.4, 0.05), b];
    });
    assert!(looped.contains(&"V1"), "{looped:?}");
    let folded = broken_by(|file| {
        let line = line(first(file, "street"));
        let (a, b) = (line[0], line[1]);
        let beyond = [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0];
        *line = vec![a, b, beyond, b];
    });
    assert!(folded.contains(&"V1"), "{folded:?}");
}

#[test]
fn other_levels_may_pass() {
    let over = |level: f64| {
        broken_by(|file| {
            let (a, b) = (line(nth(file, "street", 0))[0], line(nth(file, "street", 3))[1]);
            let mut bridge = first(file, "street").clone();
            bridge.properties.id = Some("flyover".into());
            (bridge.properties.level, bridge.properties.bridge) = (level, true);
            let ends = [(a, "from"), (b, "to")].map(|(at, _)| at);
            let id_at = |file: &LayoutFile, at: [f64; 2]| {
                file.features.iter().find(|f| f.geometry == Geometry::Point(at)).and_then(|f| f.properties.id.clone())
            };
            bridge.properties.from = id_at(file, ends[0]);
            bridge.properties.to = id_at(file, ends[1]);
            *line(&mut bridge) = ends.to_vec();
            for crossing in
                file.features.iter_mut().filter(|f| ends.iter().any(|at| f.geometry == Geometry::Point(*at)))
            {
                crossing.properties.degree = crossing.properties.degree.map(|degree| degree + 1.0);
            }
            file.features.push(bridge);
        })
    };
    assert!(over(2.0).is_empty(), "{:?}", over(2.0));
    assert!(over(0.0).contains(&"V1"));
}

#[test]
fn crossings_say_how_many_streets_end_there() {
    let degree = |degree: Option<f64>| broken_by(|file| first(file, "crossing").properties.degree = degree);
    assert_eq!(degree(Some(7.0)), ["V1"]);
    assert_eq!(degree(None), ["V1"]);
    let gone = broken_by(|file| {
        let at = file.features.iter().position(|f| f.properties.kind.as_deref() == Some("street")).unwrap();
        file.features.remove(at);
    });
    assert_eq!(gone, ["V1"]);
    let mut file = good();
    first(&mut file, "crossing").properties.degree = Some(7.0);
    let report = check(&file, Until::Buildings);
    assert!(report.violations[0].message.contains("says degree 7, but"), "{}", report.violations[0]);
    assert!(report.violations[0].place.is_some());
}

#[test]
fn crossings_keep_their_distance() {
    let near = |offset: f64| {
        broken_by(|file| {
            let line = line(first(file, "street"));
            let (a, b) = (Vec2::from_array(line[0]), Vec2::from_array(line[1]));
            let at = a.midpoint(b) + (b - a).normalize().perp() * offset;
            let mut feature = first(file, "crossing").clone();
            feature.properties.id = Some("near".into());
            feature.properties.degree = Some(0.0);
            feature.geometry = Geometry::Point(at.to_array());
            file.features.push(feature);
        })
    };
    assert_eq!(near(0.03), ["V2"]);
    assert!(near(0.2).is_empty());
    let pair = broken_by(|file| {
        let mut feature = first(file, "crossing").clone();
        feature.properties.id = Some("twin".into());
        feature.properties.degree = Some(0.0);
        file.features.push(feature);
    });
    assert_eq!(pair, ["V2"]);
}

#[test]
fn polygons_must_be_valid() {
    let bow_tie = |kind: &'static str| {
        broken_by(move |file| {
            let ring = &mut rings(first(file, kind))[0];
            ring.swap(1, 2);
        })
    };
    assert!(bow_tie("quarter").contains(&"V4"));
    assert!(bow_tie("block").contains(&"V4"));
    assert!(bow_tie("parcel").contains(&"V5"));
    assert!(bow_tie("building").contains(&"V22"));
    let flat = broken_by(|file| rings(first(file, "parcel"))[0].truncate(2));
    assert!(flat.contains(&"V5"), "{flat:?}");
    let line_like = broken_by(|file| first(file, "parcel").geometry = Geometry::Nothing);
    assert!(line_like.contains(&"V5"), "{line_like:?}");
    let hole_outside = broken_by(|file| {
        let hole = rings(nth(file, "block", 5))[0].clone();
        rings(first(file, "block")).push(hole);
    });
    assert!(hole_outside.contains(&"V4"), "{hole_outside:?}");
    let tiny_edge = broken_by(|file| {
        let ring = &mut rings(first(file, "parcel"))[0];
        let next = [ring[0][0] + 0.004, ring[0][1]];
        ring.insert(1, next);
    });
    assert!(tiny_edge.contains(&"V5"), "{tiny_edge:?}");
}

#[test]
fn areas_keep_out_of_their_like() {
    assert!(broken_by(|file| shift(first(file, "block"), [5.0, 0.0])).contains(&"V4"));
    assert!(broken_by(|file| shift(first(file, "parcel"), [1.0, 0.0])).contains(&"V6"));
    let doubled = broken_by(|file| {
        let mut twin = first(file, "building").clone();
        twin.properties.id = Some("twin".into());
        file.features.push(twin);
    });
    assert_eq!(doubled, ["V22"]);
    // A sliver of 4 mm is rounding, not overlap.
    assert!(broken_by(|file| shift(first(file, "parcel"), [0.004, 0.0])).is_empty());
}

#[test]
fn land_keeps_out_of_the_roadway() {
    let wide = broken_by(|file| nth(file, "street", 1).properties.width = Some(90.0));
    assert_eq!(wide, ["V7"]);
}

#[test]
fn parts_lie_in_what_they_belong_to() {
    assert_eq!(broken_by(|file| first(file, "parcel").properties.block = Some("none".into())), ["V8"]);
    assert_eq!(broken_by(|file| first(file, "building").properties.parcel = Some("none".into())), ["V22"]);
    let other_block = broken_by(|file| {
        let other = nth(file, "block", 7).properties.id.clone();
        let mine = first(file, "parcel").properties.block.clone();
        first(file, "parcel").properties.block =
            if other == mine { nth(file, "block", 8).properties.id.clone() } else { other };
    });
    assert_eq!(other_block, ["V8"]);
    assert!(broken_by(|file| shift(first(file, "building"), [15.0, 0.0])).contains(&"V22"));
}

#[test]
fn what_is_built_has_access() {
    let built = |file: &mut LayoutFile, access: Vec<String>| {
        let such = |f: &&mut Feature| f.properties.usage.as_deref() == Some("built");
        file.features.iter_mut().find(such).unwrap().properties.access = Some(access);
    };
    assert_eq!(broken_by(|file| built(file, Vec::new())), ["V10"]);
    assert_eq!(broken_by(|file| built(file, vec!["no such street".into()])), ["V10"]);
}

#[test]
fn inner_parcels_need_no_access() {
    let inner = |file: &mut LayoutFile| {
        let such = |f: &&mut Feature| f.properties.usage.as_deref() == Some("built");
        let parcel = &mut file.features.iter_mut().find(such).unwrap().properties;
        (parcel.access, parcel.inner) = (Some(Vec::new()), true);
    };
    assert!(broken_by(inner).is_empty());
}

#[test]
fn witnesses_name_the_place() {
    let mut file = good();
    shift(first(&mut file, "parcel"), [1.0, 0.0]);
    let report = check(&file, Until::Buildings);
    let overlap = report.violations.iter().find(|violation| violation.rule == "V6").unwrap();
    assert_eq!(overlap.ids.len(), 2);
    assert!(overlap.place.is_some() && overlap.message.contains("overlap by"));
    let json = report.to_json();
    assert_eq!(json["violation_count"]["V6"], report.counts["V6"]);
    assert!(json["violations"]["V6"][0]["place"][0].is_number());
}

#[test]
fn positions_off_the_lattice_are_noted() {
    let mut file = good();
    shift(first(&mut file, "building"), [0.0001, 0.0]);
    let report = check(&file, Until::Buildings);
    assert!(report.is_valid());
    assert_eq!(report.notes.len(), 1);
    let mut far = good();
    shift(first(&mut far, "building"), [1e9, 0.0]);
    assert!(check(&far, Until::Buildings).counts.contains_key("V22"));
}
