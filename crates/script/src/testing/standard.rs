//! Standard sites: small places with a hill, a shore, a park …, the same for every test.

use crate::city::SiteHandle;
use crate::city::{SiteInfo, drawn_map};
use crate::fault::{Complaint, Refusal};
use crate::host::{kind_of, numeric};
use crate::names::hint;
use crate::plan::SitePlan;
use geom::Vec2;
use rhai::{Array, Dynamic, Engine, FuncRegistration};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Side of a standard site, metres.
pub(crate) const SIDE: f64 = 600.0;

/// Something that a standard site may have.
pub(super) struct Feature {
    /// What it is called.
    pub name: &'static str,
    /// The map that it draws.
    map: &'static str,
    /// Its value at a place, given as shares of the side from the south-west corner; heights for a side of a kilometre.
    at: fn(Vec2) -> f64,
    /// Whether values are heights or lengths, which go with the side.
    is_length: bool,
}

/// All of them. Of two that draw one map the later one counts.
pub(super) const FEATURES: [Feature; 10] = [
    Feature { name: "slope", map: "elevation", at: |at| 100.0 * at.x + 40.0 * at.y, is_length: true },
    Feature { name: "hill", map: "elevation", at: |at| 120.0 * mound(at, Vec2::splat(0.5), 0.5), is_length: true },
    Feature { name: "shore", map: "land", at: |at| yes(at.x < 0.78 + 0.06 * libm::sin(at.y * TAU)), is_length: false },
    Feature { name: "river", map: "land", at: |at| yes((at.x - bend(at.y)).abs() > 0.035), is_length: false },
    Feature { name: "park", map: "parks", at: |at| yes(at.distance(Vec2::new(0.3, 0.62)) < 0.13), is_length: false },
    Feature { name: "people", map: "density", at: |at| 25_000.0 * mound(at, Vec2::splat(0.5), 0.75), is_length: false },
    Feature { name: "centres", map: "density", at: centres, is_length: false },
    Feature { name: "zones", map: "zones", at: |at| 1.0 + (at.x * 3.0).floor().clamp(0.0, 2.0), is_length: false },
    Feature { name: "low", map: "max_height", at: |at| if at.y < 0.5 { 12.0 } else { 300.0 }, is_length: false },
    Feature { name: "old_town", map: "old_town", at: |at| mound(at, Vec2::new(0.3, 0.4), 0.35), is_length: false },
];

fn yes(is_so: bool) -> f64 {
    if is_so { 1.0 } else { 0.0 }
}

/// From 1 at its middle down to 0 at its radius.
fn mound(at: Vec2, middle: Vec2, radius: f64) -> f64 {
    let share = (1.0 - at.distance_squared(middle) / (radius * radius)).max(0.0);
    share * share
}

/// Where the river runs.
fn bend(y: f64) -> f64 {
    0.55 + 0.08 * libm::sin(y * TAU)
}

/// Three centres of population.
fn centres(at: Vec2) -> f64 {
    let peaks = [((0.2, 0.25), 0.22, 20_000.0), ((0.8, 0.4), 0.25, 30_000.0), ((0.35, 0.85), 0.2, 15_000.0)];
    400.0 + peaks.iter().map(|&((x, y), radius, people)| people * mound(at, Vec2::new(x, y), radius)).sum::<f64>()
}

/// A square site with features, as scripts hold it.
pub(super) fn standard(side: f64, names: &[&str]) -> SiteHandle {
    let plan = standard_site(side, names);
    let maps = plan.drawn.keys().cloned().collect();
    SiteHandle::new(plan, SiteInfo { size: Some(Vec2::splat(side)), maps })
}

/// A square site with features.
pub(crate) fn standard_site(side: f64, names: &[&str]) -> SitePlan {
    let mut plan = SitePlan { size: Some(Vec2::splat(side)), ..SitePlan::default() };
    for feature in FEATURES.iter().filter(|feature| names.contains(&feature.name)) {
        let scale = if feature.is_length { side / 1000.0 } else { 1.0 };
        let map = drawn_map(Vec2::splat(side), |at| (feature.at)(at / side) * scale);
        plan.drawn.insert(feature.map.to_owned(), Arc::new(map));
    }
    plan
}

pub(super) fn register(engine: &mut Engine) {
    FuncRegistration::new("standard")
        .with_comments(["/// A flat, empty site of 600 m."])
        .register_into_engine(engine, || standard(SIDE, &[]));
    FuncRegistration::new("standard")
        .with_params_info(["features"])
        .with_comments([
            "/// A site of 600 m with one of these, or a list of them: slope, hill, shore, river, park, people, centres, \
             zones, low, old_town.",
        ])
        .register_into_engine(engine, |features: Dynamic| Ok::<_, Refusal>(standard(SIDE, &features_of(&features)?)));
    FuncRegistration::new("standard")
        .with_params_info(["features", "side"])
        .with_comments(["/// The same, so many metres wide and high."])
        .register_into_engine(engine, |features: Dynamic, side: Dynamic| {
            let side = numeric("the side", &side)?;
            if !(50.0..=5000.0).contains(&side) {
                return Err(Complaint::new("a standard site is from 50 to 5000 m wide").into());
            }
            Ok::<_, Refusal>(standard(side, &features_of(&features)?))
        });
}

/// The features that a text or a list names.
pub(crate) fn features_of(features: &Dynamic) -> Result<Vec<&'static str>, Complaint> {
    let each = features.read_lock::<Array>().map_or_else(|| vec![features.clone()], |list| list.clone());
    each.iter().map(name).collect()
}

fn name(feature: &Dynamic) -> Result<&'static str, Complaint> {
    let given = kind_of(feature);
    let text = feature.clone().into_string();
    let text = text.map_err(|_| Complaint::new(format!("a feature is told by its name, not by {given}")))?;
    let known = FEATURES.iter().map(|feature| feature.name);
    let unknown = || Complaint::new(format!("no standard site has `{text}`")).maybe_hint(hint(&text, known.clone()));
    known.clone().find(|name| *name == text).ok_or_else(unknown)
}
