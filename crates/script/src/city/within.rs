//! Where the streets of a stage grow: on a map, in a polygon, in chosen quarters; and how far outside all quarters.

use super::streets::on_lattice;
use crate::fault::{Complaint, Refusal};
use crate::host::{kind_of, number};
use crate::plan::{MapRef, Rim, Within};
use crate::words::options::Options;
use geom::{Point, Polygon};
use rhai::{Array, Dynamic, Engine, FuncRegistration, Map};
use std::sync::Arc;

/// Widest rim that may be asked for, metres.
const WIDEST_RIM: f64 = 100_000.0;

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Within>("an area");
    FuncRegistration::new("polygon")
        .with_params_info(["[[x, y], …]"])
        .with_comments(["/// The ground inside a polygon, in metres."])
        .register_into_engine(engine, |points: Array| Ok::<_, Refusal>(Within::Polygon(Arc::new(polygon(points)?))));
    FuncRegistration::new("quarters_at")
        .with_params_info(["[[x, y], …]"])
        .with_comments(["/// The quarters that contain one of these places."])
        .register_into_engine(engine, |places: Array| Ok::<_, Refusal>(quarters_at(places)?));
    FuncRegistration::new("quarters_in")
        .with_params_info(["\"district\""])
        .with_comments(["/// The quarters whose middle lies in a district, or in one of a list of them."])
        .register_into_engine(engine, |names: Dynamic| Ok::<_, Refusal>(quarters_in(names)?));
}

/// A polygon through points in metres, on the lattice, counter-clockwise.
pub(super) fn polygon(points: Array) -> Result<Polygon, Complaint> {
    let corner = |point| on_lattice(point).map(Point::from_metres);
    let mut ring: Vec<Point> = points.into_iter().map(corner).collect::<Result<_, _>>()?;
    if ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    let polygon = Polygon::new(ring, Vec::new());
    if polygon.outer.len() >= 3 && polygon.is_valid() {
        return Ok(polygon);
    }
    let help = "name its corners one after the other: [[0, 0], [900, 0], [400, 700]]";
    Err(Complaint::new("a polygon needs at least three corners, and its rim must not cross itself").hint(help))
}

fn quarters_at(places: Array) -> Result<Within, Complaint> {
    if places.is_empty() {
        return Err(Complaint::new("quarters_at names no place").hint("quarters_at([[1200, 800]])"));
    }
    Ok(Within::QuartersAt(places.into_iter().map(on_lattice).collect::<Result<_, _>>()?))
}

fn quarters_in(names: Dynamic) -> Result<Within, Complaint> {
    let names = if names.is_array() { names.into_array().unwrap_or_default() } else { vec![names] };
    let wrong = || Complaint::new("quarters_in takes the name of a district, or a list of names");
    let names: Vec<String> =
        names.into_iter().map(|name| name.into_string().map_err(|_| wrong())).collect::<Result<_, _>>()?;
    if names.is_empty() {
        return Err(wrong().hint("quarters_in([\"old town\", \"harbour\"])"));
    }
    Ok(Within::QuartersIn(names))
}

/// What `within: …` of a stage says.
pub(super) fn within_of(value: Dynamic) -> Result<Within, Complaint> {
    let given = kind_of(&value);
    if let Some(map) = value.clone().try_cast::<MapRef>() {
        return Ok(Within::Map(map));
    }
    if let Some(within) = value.clone().try_cast::<Within>() {
        return Ok(within);
    }
    let wrong = || {
        let help = "site.map(\"…\"), polygon([[x, y], …]), quarters_at([[x, y], …]) or quarters_in(\"district\")";
        Complaint::new(format!("`within` must be a map, a polygon or a choice of quarters, not {given}")).hint(help)
    };
    let points: Array = value.try_cast().ok_or_else(|| wrong().key("within"))?;
    polygon(points).map(|polygon| Within::Polygon(Arc::new(polygon))).map_err(|wrong| wrong.key("within"))
}

/// What `rim: 300` or `rim: #{ width: 300, bulge: 0.4 }` says.
pub(super) fn rim_of(value: Dynamic) -> Result<Rim, Complaint> {
    let map = match value.clone().try_cast::<Map>() {
        Some(map) => map,
        None if number(&value).is_some() => Map::from([("width".into(), value)]),
        None => {
            let message = format!("`rim` must be a number of metres, not {}", kind_of(&value));
            return Err(Complaint::new(message).hint("rim: 300, or rim: #{ width: 300, bulge: 0.4 }").key("rim"));
        }
    };
    let mut options = Options::new("rim", map, &["width", "bulge"])?;
    let width = options.within("width", 0.0, WIDEST_RIM, " m").map_err(|wrong| wrong.key("rim"))?;
    let none = || Complaint::new("`rim` needs a width").hint("rim: #{ width: 300 }").key("rim");
    let bulge = options.within("bulge", 0.0, 1.0, "").map_err(|wrong| wrong.key("rim"))?;
    Ok(Rim { width: width.ok_or_else(none)?, bulge: bulge.unwrap_or(0.0) })
}
