//! What can be said about something at once, from the city alone.

use crate::scene::{Element, ElementKind};
use city::City;
use geom::{Point, Polygon};
use script::PresetTarget;

/// The ground of something; of a street the line in the middle, there and back.
pub fn polygon_of(city: &City, element: &Element) -> Option<Polygon> {
    match element.kind {
        ElementKind::Building => Some(city.buildings.iter().find(|b| b.id == element.id)?.footprint.clone()),
        ElementKind::Parcel => Some(city.parcels.iter().find(|p| p.id == element.id)?.polygon.clone()),
        ElementKind::Block => Some(city.blocks.iter().find(|b| b.id == element.id)?.polygon.clone()),
        ElementKind::Quarter => Some(city.quarters.iter().find(|q| q.id == element.id)?.polygon.clone()),
        ElementKind::Street => {
            let run = city.runs.iter().find(|run| run.id == element.id)?;
            let line: Vec<Point> = run.nodes.iter().map(|&key| city.graph.at(key)).collect();
            Some(Polygon { outer: line.iter().copied().chain(line.iter().rev().copied()).collect(), holes: Vec::new() })
        }
    }
}

/// How many metres high something stands; of a parcel what stands on it.
pub fn height_of(city: &City, element: &Element) -> Option<f64> {
    let building = city.buildings.iter().find(|building| match element.kind {
        ElementKind::Building => building.id == element.id,
        ElementKind::Parcel => building.parcel == element.id,
        ElementKind::Block | ElementKind::Quarter | ElementKind::Street => false,
    });
    building.map(|building| building.height)
}

/// What people may want to know first: names with values.
pub fn facts(city: &City, element: &Element) -> Vec<(&'static str, String)> {
    let origin = |origin: u16| city.origins.get(usize::from(origin)).cloned();
    let area = |polygon: &Polygon| format!("{:.0} m²", polygon.area());
    let mut facts = vec![("id", element.id.to_string())];
    match element.kind {
        ElementKind::Building => {
            let Some(building) = city.buildings.iter().find(|b| b.id == element.id) else { return facts };
            facts.push(("height", format!("{:.1} m", building.height)));
            facts.push(("footprint", area(&building.footprint)));
            facts.extend(origin(building.origin).map(|rule| ("rule", rule)));
            facts.push(("parcel", building.parcel.to_string()));
        }
        ElementKind::Street => {
            let Some(run) = city.runs.iter().find(|run| run.id == element.id) else { return facts };
            let places: Vec<_> = run.nodes.iter().map(|&key| city.graph.at(key).metres()).collect();
            let length: f64 = places.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
            facts.extend(city.street_names.get(&run.street).map(|name| ("name", name.clone())));
            facts.push(("class", city.graph.classes().info(run.class).name.clone()));
            facts.push(("width", format!("{:.1} m", f64::from(run.half_width) / 512.0)));
            facts.push(("length", format!("{length:.0} m")));
            let (first, last) =
                (places.first().copied().unwrap_or_default(), places.last().copied().unwrap_or_default());
            let rise = city.site.elevation(last) - city.site.elevation(first);
            facts.push(("grade", format!("{:.1} %", 100.0 * rise.abs() / length.max(1.0))));
            if run.level != 0 {
                facts.push((if run.level > 0 { "bridge" } else { "tunnel" }, format!("level {}", run.level)));
            }
            facts.extend(origin(run.origin).map(|rule| ("rule", rule)));
        }
        ElementKind::Parcel => {
            let Some(parcel) = city.parcels.iter().find(|p| p.id == element.id) else { return facts };
            facts.push(("area", area(&parcel.polygon)));
            facts.push(("use", city::export::geojson::use_name(parcel.usage).to_owned()));
            facts.push(("streets", parcel.access.len().to_string()));
            let tags: Vec<String> = parcel.tags.iter().map(|tag| tag.to_string()).collect();
            facts.extend((!tags.is_empty()).then(|| ("tags", tags.join(", "))));
        }
        ElementKind::Block => {
            let Some(block) = city.blocks.iter().find(|b| b.id == element.id) else { return facts };
            facts.push(("area", area(&block.polygon)));
            let parcels = city.parcels.iter().filter(|parcel| parcel.block == block.id).count();
            facts.push(("parcels", parcels.to_string()));
        }
        ElementKind::Quarter => {
            let Some(quarter) = city.quarters.iter().find(|q| q.id == element.id) else { return facts };
            facts.push(("area", format!("{:.2} km²", quarter.polygon.area() / 1e6)));
            let blocks = city.blocks.iter().filter(|block| block.quarter == Some(quarter.id)).count();
            facts.push(("blocks", blocks.to_string()));
        }
    }
    facts
}

/// What people call what a preset is laid on, or a value set in.
pub fn target_name(target: &PresetTarget) -> String {
    match target {
        PresetTarget::City => "the whole city".into(),
        PresetTarget::Class(class) => (*class).to_owned(),
        PresetTarget::District(name) => format!("district {name}"),
        PresetTarget::Quarter(id) => format!("quarter {}", &id.to_string()[..6]),
    }
}
