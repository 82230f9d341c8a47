//! `landmark(#{ … })`: places that stand out (SCH10 §3.3, markers).

use super::streets::{class, on_lattice};
use super::within::polygon;
use crate::fault::{Complaint, Refusal};
use crate::host::number;
use crate::plan::Landmark;
use crate::words::options::{Options, pair, word};
use geom::{Angle, Point, Polygon, Vec2, boolean};
use layout::Use;
use rhai::{Array, Dynamic, Engine, FuncRegistration, Map};

/// Everything that `landmark(…)` knows.
const KEYS: &[&str] = &["name", "at", "size", "heading", "outline", "attract", "reach", "parcel", "around"];
/// What a parcel may be for.
const USES: [(&str, Use); 4] = [("built", Use::Built), ("open", Use::Open), ("park", Use::Park), ("plaza", Use::Plaza)];
/// Side of the square around a place, where the script says nothing, metres: a church with its yard.
const SIDE: f64 = 60.0;
/// Shortest and longest side of a ground told by a size, metres.
const SIDES: (f64, f64) = (4.0, 20_000.0);
/// Least area of a ground told by an outline, m².
const LEAST_AREA: f64 = 16.0;
/// How far a landmark is felt, where the script says nothing, metres.
const REACH: f64 = 1500.0;
/// Most that a landmark may draw, as a multiple of the densest place.
const STRONGEST: f64 = 100.0;

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Landmark>("a landmark");
    FuncRegistration::new("landmark")
        .with_params_info(["#{ name, at, size, heading, outline, attract, reach, parcel, around }"])
        .with_comments([
            "/// A place that stands out: streets keep off its ground and are led to it, and it becomes one parcel.",
        ])
        .register_into_engine(engine, |options: Map| Ok::<_, Refusal>(landmark(options)?));
}

fn landmark(options: Map) -> Result<Landmark, Complaint> {
    let mut options = Options::new("landmark", options, KEYS)?;
    let name = options.text("name")?.map(|name| name.trim().to_owned()).filter(|name| !name.is_empty());
    let nameless = || {
        let help = "landmark(#{ name: \"Cathedral\", at: [1200, 800] })";
        Complaint::new("a landmark needs a `name`: it is known by it").hint(help).key("name")
    };
    Ok(Landmark {
        name: name.ok_or_else(nameless)?,
        ground: ground(&mut options)?,
        attract: options.within("attract", 0.0, STRONGEST, "")?.unwrap_or(1.0),
        reach: options.within("reach", 10.0, 100_000.0, " m")?.unwrap_or(REACH),
        usage: word(&mut options, "parcel", &USES)?.unwrap_or(Use::Plaza),
        around: options.text("around")?.map(|name| class(&name, "around")).transpose()?,
    })
}

/// An outline, or a rectangle around a place.
fn ground(options: &mut Options) -> Result<Polygon, Complaint> {
    let outline = options.of::<Array>("outline", "a list of corners [[x, y], …]")?;
    let (at, size, heading) = (options.take("at"), options.take("size"), options.number("heading")?);
    match (outline, at) {
        (Some(_), at) if at.is_some() || size.is_some() || heading.is_some() => {
            let help = "a polygon needs no `at`, `size` or `heading`";
            Err(Complaint::new("a landmark has either an `outline` or a place").hint(help).key("outline"))
        }
        (Some(corners), _) => outlined(corners).map_err(|wrong| wrong.key("outline")),
        (None, Some(at)) => {
            let at = on_lattice(at).map_err(|wrong| wrong.key("at"))?;
            Ok(rectangle(at, size.map_or(Ok(Vec2::splat(SIDE)), size_of)?, heading.unwrap_or(0.0)))
        }
        (None, None) => {
            let help = "at: [x, y] with a size, or outline: [[x, y], …]";
            Err(Complaint::new("a landmark needs a place").hint(help))
        }
    }
}

fn outlined(corners: Array) -> Result<Polygon, Complaint> {
    let polygon = polygon(corners)?;
    if polygon.area() >= LEAST_AREA {
        return Ok(polygon);
    }
    Err(Complaint::new(format!("a landmark covers at least {LEAST_AREA} m², not {:.1}", polygon.area())))
}

/// One number for a square, two for a rectangle.
fn size_of(value: Dynamic) -> Result<Vec2, Complaint> {
    let wrong = || Complaint::new("a size is a number of metres, or [width, height]").key("size");
    let size = match number(&value) {
        Some(side) => Vec2::splat(side),
        None => pair(value).map_err(|_| wrong())?,
    };
    let good = size.cmpge(Vec2::splat(SIDES.0)).all() && size.cmple(Vec2::splat(SIDES.1)).all();
    let message = || format!("the sides of a landmark must lie between {} and {} m", SIDES.0, SIDES.1);
    if good { Ok(size) } else { Err(Complaint::new(message()).key("size")) }
}

/// The rectangle around a place, its width along a heading in degrees.
fn rectangle(at: Vec2, size: Vec2, heading: f64) -> Polygon {
    let along = Angle::degrees(heading).unit() * (size.x / 2.0);
    let across = Angle::degrees(heading).unit().perp() * (size.y / 2.0);
    let corners = [-along - across, along - across, along + across, across - along];
    Polygon::new(corners.map(|corner| Point::from_metres(at + corner)).to_vec(), Vec::new())
}

/// Whether landmarks can stand beside each other: each with a name and ground of its own.
pub(super) fn check_landmarks(landmarks: &[Landmark]) -> Result<(), Complaint> {
    for (i, landmark) in landmarks.iter().enumerate() {
        for other in &landmarks[..i] {
            if other.name == landmark.name {
                let message = format!("two landmarks are called `{}`", landmark.name);
                return Err(Complaint::new(message).hint("each is known by a name of its own"));
            }
            let shared =
                boolean::intersection(std::slice::from_ref(&other.ground), std::slice::from_ref(&landmark.ground));
            if !shared.is_empty() {
                let message = format!("the grounds of `{}` and `{}` overlap", other.name, landmark.name);
                return Err(Complaint::new(message).hint("make them smaller, or one landmark of both"));
            }
        }
    }
    Ok(())
}
