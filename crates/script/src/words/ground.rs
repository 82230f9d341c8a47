//! What `block` and `shape` share: the place they lie at, with its maps and the streets around.

use super::segment::{map_name, no_map_of};
use super::{method, property};
use crate::fault::Complaint;
use crate::host::Located;
use crate::names::hint;
use geom::Vec2;
use rhai::{Array, Dynamic, Engine};
use std::fmt::Debug;
use std::sync::Arc;

/// What rules can ask about a place. The program implements it on its site and streets.
pub trait Ground: Send + Sync + Debug {
    /// The value of a map at a place in metres, between its cells; `None` when the site has no such map.
    fn map(&self, name: &str, at: Vec2) -> Option<f64>;

    /// The value of the map's cell at a place: for maps that number zones. `None` when the site has no such map.
    fn zone(&self, name: &str, at: Vec2) -> Option<f64>;

    /// The names of the site's maps.
    fn maps(&self) -> Vec<String>;

    /// Metres from a place to the nearest street of a class; endless where the city has none of it, `None` for a class
    /// that there is not.
    fn distance(&self, class: &str, at: Vec2) -> Option<f64>;

    /// The names of the street classes.
    fn classes(&self) -> Vec<String>;
}

/// Land without maps, far from all streets, with the usual classes.
#[derive(Clone, Copy, Debug, Default)]
pub struct BareGround;

impl Ground for BareGround {
    fn map(&self, _: &str, _: Vec2) -> Option<f64> {
        None
    }

    fn zone(&self, _: &str, _: Vec2) -> Option<f64> {
        None
    }

    fn maps(&self) -> Vec<String> {
        Vec::new()
    }

    fn distance(&self, class: &str, _: Vec2) -> Option<f64> {
        streets::Classes::default().named(class).map(|_| f64::INFINITY)
    }

    fn classes(&self) -> Vec<String> {
        streets::Classes::default().iter().map(|(_, info)| info.name.clone()).collect()
    }
}

/// A street that a block or a parcel fronts.
#[derive(Clone, Debug, PartialEq)]
pub struct StreetSide {
    /// The name of its class.
    pub class: Arc<str>,
    /// Its right-of-way, metres.
    pub width: f64,
    /// How much of it is fronted, metres.
    pub length: f64,
}

/// Something that lies at a place.
pub(super) trait Placed: Located + Send + 'static {
    fn ground(&self) -> &dyn Ground;
    fn streets(&self) -> &[StreetSide];
}

/// The map that stands for zones where a rule names none.
const ZONES: &str = "zones";

/// Registers what can be asked of a place.
pub(super) fn register<C: Placed>(engine: &mut Engine) {
    property::<C, f64>(engine, "x", "How far east it lies, m.", |c| c.place().x);
    property::<C, f64>(engine, "y", "How far north it lies, m.", |c| c.place().y);
    maps::<C>(engine);
    streets::<C>(engine);
}

fn maps<C: Placed>(engine: &mut Engine) {
    property::<C, f64>(engine, "zone", "The cell's value of the map `zones`; 0 without one.", |c| {
        c.ground().zone(ZONES, c.place()).unwrap_or(0.0)
    });
    method!(engine, "map"(name) "The value of a map of the site there.", C, |c, name| {
        let name = map_name(name)?;
        c.ground().map(&name, c.place()).ok_or_else(|| no_map(c.ground(), &name))
    });
    method!(engine, "zone"(name) "The value of the map's own cell there: for maps that number zones.", C, |c, name| {
        let name = map_name(name)?;
        c.ground().zone(&name, c.place()).ok_or_else(|| no_map(c.ground(), &name))
    });
    method!(engine, "has_map"(name) "Whether the site has a map.", C, |c, name| {
        let name = map_name(name)?;
        Ok(c.ground().maps().contains(&name))
    });
}

fn streets<C: Placed>(engine: &mut Engine) {
    property::<C, f64>(engine, "frontage", "Metres of it that lie on streets.", |c| {
        c.streets().iter().map(|side| side.length).sum()
    });
    property::<C, f64>(engine, "street_width", "Right-of-way of the widest street that it fronts, m.", |c| {
        c.streets().iter().map(|side| side.width).fold(0.0, f64::max)
    });
    property::<C, Array>(engine, "classes", "The names of the classes of the streets that it fronts: a list.", |c| {
        let mut names: Vec<String> = c.streets().iter().map(|side| side.class.to_string()).collect();
        names.sort_unstable();
        names.dedup();
        names.into_iter().map(Dynamic::from).collect()
    });
    method!(engine, "fronts"(class) "Metres of frontage on streets of a class.", C, |c, class| {
        let class = class_name(c.ground(), class)?;
        Ok(c.streets().iter().filter(|side| *side.class == class).map(|side| side.length).sum::<f64>())
    });
    method!(engine, "distance"(class) "Metres to the nearest street of a class; endless where there is none.", C, |c, class| {
        let class = class_name(c.ground(), class)?;
        c.ground().distance(&class, c.place()).ok_or_else(|| no_class(c.ground(), &class))
    });
}

fn no_map(ground: &dyn Ground, name: &str) -> Complaint {
    let known = ground.maps();
    no_map_of(known.iter().map(String::as_str), name)
}

fn class_name(ground: &dyn Ground, class: &Dynamic) -> Result<String, Complaint> {
    let class = class.clone().into_string().map_err(|_| Complaint::new("a street class is asked for by its name"))?;
    if ground.classes().contains(&class) { Ok(class) } else { Err(no_class(ground, &class)) }
}

fn no_class(ground: &dyn Ground, class: &str) -> Complaint {
    let known = ground.classes();
    let near = hint(class, known.iter().map(String::as_str));
    Complaint::new(format!("there is no street class `{class}`")).maybe_hint(near)
}
