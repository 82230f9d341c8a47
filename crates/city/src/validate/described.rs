//! Identity and description: every kind is there, every id is unique, and features say what the other rules rely on.

use super::ValidationReport;
use crate::Until;
use crate::export::LayoutFile;
use crate::export::layout_file::{Feature, Geometry, Properties};
use geom::{Point, Vec2};
use std::collections::{BTreeMap, BTreeSet};

/// Checks `ids` and `S`.
pub fn check(file: &LayoutFile, until: Until, report: &mut ValidationReport) {
    check_ids(file, report);
    if file.about.is_none() {
        report.add("S", &[], None, "the file lacks its `plat` member (format, seed, units)".into());
    }
    for kind in expected(until) {
        if !report.features.contains_key(*kind) {
            report.add("S", &[], None, format!("no {kind} in the file"));
        }
    }
    for feature in &file.features {
        check_feature(feature, report);
    }
    check_degrees(file, report);
}

/// Each crossing says how many streets end there: V1, as streets meet at crossings.
fn check_degrees(file: &LayoutFile, report: &mut ValidationReport) {
    let of_kind = |kind: &'static str| file.features.iter().filter(move |f| f.properties.kind.as_deref() == Some(kind));
    let mut arms: BTreeMap<&str, u32> = BTreeMap::new();
    for street in of_kind("street") {
        let ends = [&street.properties.from, &street.properties.to];
        ends.into_iter().flatten().for_each(|end| *arms.entry(end).or_default() += 1);
    }
    for crossing in of_kind("crossing") {
        let Some(id) = crossing.properties.id.as_deref() else { continue };
        let met = arms.get(id).copied().unwrap_or(0);
        let message = match crossing.properties.degree {
            Some(degree) if degree == f64::from(met) => continue,
            Some(degree) => format!("crossing {id} says degree {degree}, but {met} streets end there"),
            None => format!("crossing {id} does not say its degree; {met} streets end there"),
        };
        let place = if let Geometry::Point([x, y]) = crossing.geometry {
            Point::try_from_metres(Vec2::new(x, y))
        } else {
            None
        };
        report.add("V1", &[("crossing", id)], place, message);
    }
}

fn expected(until: Until) -> &'static [&'static str] {
    let all = &["street", "crossing", "block", "parcel", "building"];
    match until {
        Until::Streets => &all[..3],
        Until::Parcels => &all[..4],
        Until::Buildings => all,
    }
}

fn check_ids(file: &LayoutFile, report: &mut ValidationReport) {
    let mut seen: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for (n, feature) in file.features.iter().enumerate() {
        let properties = &feature.properties;
        let Some(kind) = properties.kind.as_deref() else { continue };
        *report.features.entry(kind.to_owned()).or_default() += 1;
        match properties.id.as_deref() {
            None => report.add("ids", &[], None, format!("{kind}: feature {n} has no id")),
            Some(id) if !seen.entry(kind).or_default().insert(id) => {
                report.add("ids", &[(kind, id)], None, format!("{kind} {id}: used twice"));
            }
            Some(_) => {}
        }
    }
}

fn check_feature(feature: &Feature, report: &mut ValidationReport) {
    let properties = &feature.properties;
    let id = properties.id.as_deref().unwrap_or("without id");
    let kind = properties.kind.as_deref().unwrap_or_default();
    let mut bad = |message: String| report.add("S", &[(kind, id)], None, format!("{kind} {id} {message}"));
    match kind {
        "street" => check_street(properties, &mut bad),
        "parcel" if properties.block.is_none() || properties.access.is_none() => {
            bad("lacks its block or its access list".into());
        }
        "building"
            if properties.parcel.is_none()
                || properties.height.is_none_or(|height| height.is_nan() || height <= 0.0) =>
        {
            bad("lacks its parcel or a height".into());
        }
        _ => {}
    }
}

fn check_street(street: &Properties, bad: &mut impl FnMut(String)) {
    if !street.width.is_some_and(|width| (1.0..=100.0).contains(&width)) {
        let width = street.width.map_or("no width".into(), |width| format!("width {width}"));
        bad(format!("has {width}, not one of 1 to 100 m"));
    }
    if street.level != 0.0 && !(street.bridge || street.tunnel) {
        bad(format!("is on level {} but neither bridge nor tunnel", street.level));
    }
    if street.class.is_none() {
        bad("has no class".into());
    }
}
