//! `site.districts("districts", #{ … })` and `districts_from("districts.geojson")`.

use super::site::SiteHandle;
use crate::fault::{Complaint, Refusal};
use crate::host::is_inside;
use crate::param::colour;
use crate::plan::DistrictPlan;
use crate::words::options::text;
use rhai::{Engine, FuncRegistration, Map};
use std::collections::BTreeMap;

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<DistrictPlan>("districts");
    FuncRegistration::new("districts")
        .with_params_info(["this", "map", "#{ name: \"#rrggbb\" }"])
        .with_comments([
            "/// Named areas of the site from a colour map: each name has its colour, `none` that of other ground.",
        ])
        .register_into_engine(engine, |site: &mut SiteHandle, map: &str, legend: Map| {
            Ok::<_, Refusal>(of_map(site, map, legend)?)
        });
    FuncRegistration::new("districts")
        .with_params_info(["this", "map"])
        .with_comments(["/// The same, with the `legend` in the map's sidecar."])
        .register_into_engine(engine, |site: &mut SiteHandle, map: &str| {
            Ok::<_, Refusal>(DistrictPlan::Map { map: site.map(map)?, legend: BTreeMap::new() })
        });
    FuncRegistration::new("districts_from")
        .with_params_info(["file"])
        .with_comments([
            "/// Named areas of the site from the polygons of a GeoJSON file beside the script, each with a `name`.",
        ])
        .register_into_engine(engine, |file: &str| Ok::<_, Refusal>(of_file(file)?));
}

fn of_map(site: &SiteHandle, map: &str, legend: Map) -> Result<DistrictPlan, Complaint> {
    let map = site.map(map)?;
    if legend.is_empty() {
        return Err(Complaint::new("the legend names no district").hint("#{ harbour: \"#2980b9\" }"));
    }
    let mut read: BTreeMap<String, [u8; 3]> = BTreeMap::new();
    for (name, value) in legend {
        let text = text(value, &name)?;
        let wrong =
            || Complaint::new(format!("`{name}` must be a colour such as #c0ffee, not `{text}`")).key(name.as_str());
        let own = colour(&text).ok_or_else(wrong)?;
        if name.trim().is_empty() {
            return Err(Complaint::new("a district needs a name")
                .hint("ground of no district is called `none`")
                .key(name.as_str()));
        }
        if let Some((other, _)) = read.iter().find(|(_, colour)| **colour == own) {
            let message = format!("`{other}` and `{name}` have the same colour {text}");
            return Err(Complaint::new(message).hint("each district has a colour of its own").key(name.as_str()));
        }
        read.insert(name.into(), own);
    }
    Ok(DistrictPlan::Map { map, legend: read })
}

fn of_file(file: &str) -> Result<DistrictPlan, Complaint> {
    if !is_inside(file) {
        return Err(Complaint::new(format!("`{file}` is not a file below the script's folder")));
    }
    if !file.ends_with(".geojson") && !file.ends_with(".json") {
        let help = "districts come from .geojson files, or from a colour map: site.districts(\"districts\", #{ … })";
        return Err(Complaint::new(format!("`{file}` is no file of districts")).hint(help));
    }
    Ok(DistrictPlan::File(file.to_owned()))
}
