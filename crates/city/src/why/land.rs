//! Why a quarter, block, parcel or building is there.

use super::lineage::{distance_to, logs};
use super::{Answer, Evidence, Found, asked, derived, ground};
use crate::City;
use crate::export::layout_file::Properties;
use geom::{Id, Vec2};
use std::collections::{BTreeMap, BTreeSet};
use streets::StreetId;
use streets::runs::Run;

/// Streets of a rim that are told one by one.
const MOST_STREETS: usize = 12;
/// Streets run along a rim that lie so close to it, metres.
const ON_RIM: f64 = 0.01;

/// Explains a quarter: what closes it, and what grew in it.
pub fn explain_quarter(found: &Found, evidence: &Evidence, answer: &mut Answer) {
    let city = &evidence.built.city;
    let id = found.id.parse::<Id>().ok();
    let Some(quarter) = city.quarters.iter().find(|quarter| Some(quarter.id) == id) else { return };
    answer.tell("what", format!("{} closed by highways, majors and the like", hectares(quarter.polygon.area())));
    let middles = |run: &Run| {
        let at = |node| city.graph.at(node).metres();
        run.nodes.windows(2).map(|pair| at(pair[0]).midpoint(at(pair[1]))).collect::<Vec<_>>()
    };
    let edges: Vec<_> = quarter.polygon.edges().collect();
    let is_on_rim = |at: &Vec2| edges.iter().any(|edge| distance_to(*at, *edge) <= ON_RIM);
    let closing = city.runs.iter().filter(|run| middles(run).iter().any(is_on_rim)).map(|run| run.street);
    tell_streets(closing.collect(), city, answer);
    answer.tell("blocks", city.blocks.iter().filter(|block| block.quarter == id).count().to_string());
    let plan = &evidence.sources.plan;
    if let Some(seed) = plan.seed_in(quarter.id) {
        answer.tell("seed", format!("{seed}, its own"));
    }
    if let Some(own) = plan.quarters.get(&quarter.id).filter(|own| !own.set.is_empty()) {
        answer.tell("own values", own.set.keys().cloned().collect::<Vec<_>>().join(", "));
    }
    ground::tell_rules(answer, evidence.sources, "minors", id);
    let Some(trace) = &evidence.built.trace else { return };
    for log in logs(trace).iter().filter(|log| log.quarter == id) {
        answer.tell("grown", format!("{} pieces of {} accepted", log.log.accepted.len(), log.stage));
        for (reason, count) in log.log.refusals.iter() {
            answer.tell("refused", format!("{count} × {reason}"));
        }
        for (why, count) in &log.log.reasons {
            answer.tell("by rules", format!("{count} × {why}"));
        }
    }
    if let Some(id) = id {
        asked::tell_quarter(id, trace, evidence, answer);
    }
}

/// Tells the streets that close something.
fn tell_streets(streets: BTreeSet<StreetId>, city: &City, answer: &mut Answer) {
    for street in streets.iter().take(MOST_STREETS) {
        let run = city.runs.iter().find(|run| run.street == *street);
        let said = run.map(|run| {
            let class = &city.graph.classes().info(run.class).name;
            let origin = city.origins.get(usize::from(run.origin)).map_or("", String::as_str);
            format!("{class} {street}, by {origin}")
        });
        answer.tell("closed by", said.unwrap_or_else(|| street.to_string()));
    }
    if streets.len() > MOST_STREETS {
        answer.tell("closed by", format!("{} streets more", streets.len() - MOST_STREETS));
    }
}

/// Explains a block: the streets that close it.
pub fn explain_block(found: &Found, evidence: &Evidence, answer: &mut Answer) {
    let city = &evidence.built.city;
    let id = found.id.parse::<Id>().ok();
    let Some(block) = city.blocks.iter().find(|block| Some(block.id) == id) else { return };
    answer.tell("what", format!("{} closed by {} streets", hectares(block.polygon.area()), block.streets.len()));
    answer.tell("quarter", block.quarter.map_or("outside all quarters".into(), |quarter| quarter.to_string()));
    tell_streets(block.streets.iter().copied().collect(), city, answer);
    let inside = evidence.layout.features.iter().filter(|f| f.properties.block.as_deref() == Some(&found.id));
    let mut uses: BTreeMap<&str, usize> = BTreeMap::new();
    inside.for_each(|parcel| *uses.entry(parcel.properties.usage.as_deref().unwrap_or("unknown")).or_default() += 1);
    if !uses.is_empty() {
        let counts: Vec<String> = uses.iter().map(|(usage, count)| format!("{count} {usage}")).collect();
        answer.tell("parcels", counts.join(", "));
    }
    ground::tell_rules(answer, evidence.sources, "parcels", block.quarter);
    derived::tell_block(block, evidence, answer);
}

/// Explains a parcel: its block, what it fronts, and why it is open where it is.
pub fn explain_parcel(found: &Found, evidence: &Evidence, answer: &mut Answer) {
    let city = &evidence.built.city;
    let id = found.id.parse::<Id>().ok();
    let Some(parcel) = city.parcels.iter().find(|parcel| Some(parcel.id) == id) else { return };
    let usage = crate::export::geojson::use_name(parcel.usage);
    answer.tell("what", format!("{usage}, {:.0} m²", parcel.polygon.area()));
    let landmark = city.landmarks.iter().find(|landmark| landmark.parcels.contains(&parcel.id));
    if let Some(landmark) = landmark {
        answer.tell("landmark", format!("the ground of `{}`, which the city script keeps whole", landmark.name));
    }
    answer.tell("block", parcel.block.to_string());
    for (street, metres) in &parcel.access {
        answer.tell("fronts", format!("street {street} for {metres:.1} m"));
    }
    if !parcel.tags.is_empty() {
        answer.tell("tags", parcel.tags.join(", "));
    }
    match parcel.usage {
        layout::Use::Built => {}
        _ if landmark.is_some() => answer.tell("why", "the landmark says what it is for"),
        _ if parcel.access.is_empty() => answer.tell("why", "it fronts no street, so nothing can be built on it"),
        // What is told step by step says why.
        _ => {}
    }
    let quarter = city.blocks.iter().find(|block| block.id == parcel.block).and_then(|block| block.quarter);
    ground::tell_rules(answer, evidence.sources, "parcels", quarter);
    if parcel.usage == layout::Use::Built {
        let building = evidence.layout.features.iter().find(|f| f.properties.parcel.as_deref() == Some(&found.id));
        let id = building.and_then(|building| building.properties.id.clone());
        answer.tell("building", id.unwrap_or_else(|| "none".into()));
    }
    derived::tell_parcel(parcel, evidence, answer);
}

/// Explains a building: its parcel, its height, and the rule that raised it.
pub fn explain_building(found: &Found, evidence: &Evidence, answer: &mut Answer) {
    let city = &evidence.built.city;
    let id = found.id.parse::<Id>().ok();
    let Some(building) = city.buildings.iter().find(|building| Some(building.id) == id) else { return };
    answer.tell("what", format!("{:.1} m high on {:.0} m²", building.height, building.footprint.area()));
    answer.tell("parcel", building.parcel.to_string());
    if let Some(origin) = city.origins.get(usize::from(building.origin)) {
        answer.tell("made by", origin.clone());
    }
    let says: Option<&Properties> = evidence.layout.features.get(found.features[0]).map(|feature| &feature.properties);
    let then = says.and_then(|says| says.height).filter(|height| (height - building.height).abs() > 1e-6);
    if let Some(then) = then {
        answer.differs.push(format!("the building is {then} m high in the layout, {} m now", building.height));
    }
    let parcel = city.parcels.iter().find(|parcel| parcel.id == building.parcel);
    let block = parcel.and_then(|parcel| city.blocks.iter().find(|block| block.id == parcel.block));
    ground::tell_rules(answer, evidence.sources, "buildings", block.and_then(|block| block.quarter));
    match parcel {
        // Whoever asks about a place may mean what was asked there of the block or the parcel.
        Some(parcel) if found.is_place => derived::tell_parcel(parcel, evidence, answer),
        Some(parcel) => derived::tell_built(parcel, block, evidence, answer),
        None => {}
    }
}

fn hectares(square_metres: f64) -> String {
    format!("{:.2} ha", square_metres / 10_000.0)
}
