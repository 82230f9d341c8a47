//! Finding what is asked about, and holding it against the city as it is now.

use super::lineage::metres_to;
use super::{Evidence, WhyError};
use crate::export::LayoutFile;
use crate::export::geojson::write_layout;
use crate::export::layout_file::{Feature, Geometry, parse_layout};
use crate::measure::holds;
use crate::{Sources, Until};
use geom::Vec2;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Ids may be cut to this many digits where what is left is one thing's.
const LEAST_PREFIX: usize = 4;

/// What can be asked about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A street between two crossings, or a whole street by its name id.
    Street,
    /// A crossing.
    Crossing,
    /// A quarter.
    Quarter,
    /// A block.
    Block,
    /// A parcel.
    Parcel,
    /// A building.
    Building,
    /// A place where nothing of that lies.
    Place,
}

impl Kind {
    const ALL: [Self; 6] = [Self::Street, Self::Crossing, Self::Quarter, Self::Block, Self::Parcel, Self::Building];

    /// What files call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Street => "street",
            Self::Crossing => "crossing",
            Self::Quarter => "quarter",
            Self::Block => "block",
            Self::Parcel => "parcel",
            Self::Building => "building",
            Self::Place => "place",
        }
    }

    /// How far a city must be built to be asked.
    pub fn until(self) -> Until {
        match self {
            Self::Street | Self::Crossing | Self::Quarter | Self::Place => Until::Streets,
            Self::Block | Self::Parcel => Until::Parcels,
            Self::Building => Until::Buildings,
        }
    }

    fn of(feature: &Feature) -> Option<Self> {
        let name = feature.properties.kind.as_deref()?;
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }
}

/// What was found in a layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// What it is.
    pub kind: Kind,
    /// Its whole id.
    pub id: String,
    /// Where its features stand in the layout: one, or all runs of a street asked for by its name id.
    pub features: Vec<usize>,
    /// Its middle, metres; the place that was asked about.
    pub place: Vec2,
    /// Whether a place was asked about: then what rules were asked there is told, too.
    pub is_place: bool,
}

/// Finds what has an id: a feature, else a whole street by its name id, else the one thing whose id begins so. Of a place
/// (`X,Y` in metres) it finds the smallest thing that lies there.
///
/// # Errors
/// [`WhyError::Unknown`] when there is nothing, or more than one thing.
pub fn find(layout: &LayoutFile, id: &str) -> Result<Found, WhyError> {
    let id = id.trim().to_lowercase();
    if let Some(at) = place_of(&id) {
        let found = found_at(layout, at).map(|found| Found { place: Vec2::from_array(at), is_place: true, ..found });
        return Ok(found.unwrap_or_else(|| bare_place(at)));
    }
    if let Some(found) = exact(layout, &id) {
        return Ok(found);
    }
    let alike: BTreeSet<&str> = ids(layout).filter(|other| other.starts_with(&id)).collect();
    if id.is_empty() {
        return Err(unknown(layout, &id));
    }
    if id.len() < LEAST_PREFIX && !alike.is_empty() {
        let message = format!("`{id}` is too short for an id: {LEAST_PREFIX} digits are the least");
        let some: Vec<&str> = alike.into_iter().take(2).collect();
        return Err(WhyError::Unknown { message, hint: format!("ids that begin so are {}, …", some.join(", ")) });
    }
    let mut alike = alike.into_iter();
    match (alike.next(), alike.next()) {
        (Some(only), None) => exact(layout, only).ok_or_else(|| unknown(layout, &id)),
        (Some(one), Some(two)) => {
            let count = 2 + alike.count();
            let message = format!("{count} ids begin with `{id}`");
            Err(WhyError::Unknown { message, hint: format!("give more digits: {one}, {two}, …") })
        }
        _ => Err(unknown(layout, &id)),
    }
}

/// The place that `X,Y` tells.
fn place_of(text: &str) -> Option<[f64; 2]> {
    let (x, y) = text.split_once(',')?;
    let number = |text: &str| text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    Some([number(x)?, number(y)?])
}

/// How close to a crossing, and to a street's middle, a place is meant for it, metres.
const NEAR: [f64; 2] = [3.0, 10.0];

/// The thing that lies at a place: of several the one that is asked about first.
fn found_at(layout: &LayoutFile, at: [f64; 2]) -> Option<Found> {
    let rank = |feature: &Feature| {
        let kind = Kind::of(feature)?;
        let order = match (kind, &feature.geometry) {
            (Kind::Building, Geometry::Polygon(rings)) if holds(rings, at) => 0,
            (Kind::Crossing, Geometry::Point(point))
                if Vec2::from_array(*point).distance(Vec2::from_array(at)) <= NEAR[0] =>
            {
                1
            }
            (Kind::Parcel, Geometry::Polygon(rings)) if holds(rings, at) => 2,
            (Kind::Street, Geometry::LineString(line)) if distance_to_line(line, at) <= NEAR[1] => 3,
            (Kind::Block, Geometry::Polygon(rings)) if holds(rings, at) => 4,
            (Kind::Quarter, Geometry::Polygon(rings)) if holds(rings, at) => 5,
            _ => return None,
        };
        let far = match &feature.geometry {
            Geometry::LineString(line) => distance_to_line(line, at),
            _ => 0.0,
        };
        Some((order, far))
    };
    let ranked = layout.features.iter().filter_map(|feature| Some((rank(feature)?, feature)));
    let (_, nearest) = ranked.min_by(|((a, p), _), ((b, q), _)| a.cmp(b).then(p.total_cmp(q)))?;
    exact(layout, nearest.properties.id.as_deref()?)
}

fn distance_to_line(line: &[[f64; 2]], at: [f64; 2]) -> f64 {
    let side = |pair: &[[f64; 2]]| (Vec2::from_array(pair[0]), Vec2::from_array(pair[1]));
    line.windows(2).map(|pair| metres_to(Vec2::from_array(at), side(pair))).fold(f64::INFINITY, f64::min)
}

/// A place where nothing lies.
fn bare_place(at: [f64; 2]) -> Found {
    let (id, place) = (format!("{},{}", at[0], at[1]), Vec2::from_array(at));
    Found { kind: Kind::Place, id, features: Vec::new(), place, is_place: true }
}

/// Whether what was found lies on the site of a city: of a place nothing but that can be wrong.
///
/// # Errors
/// [`WhyError::Unknown`] for a place beyond it.
pub fn on_site(found: &Found, sources: &Sources) -> Result<(), WhyError> {
    let (low, high) = (sources.site.bounds.min.metres(), sources.site.bounds.max.metres());
    if !found.is_place || (low.cmple(found.place).all() && found.place.cmple(high).all()) {
        return Ok(());
    }
    let message = format!("({}, {}) does not lie on the site", found.place.x, found.place.y);
    let hint = format!("it reaches from ({:.0}, {:.0}) to ({:.0}, {:.0}) m", low.x, low.y, high.x, high.y);
    Err(WhyError::Unknown { message, hint })
}

fn ids(layout: &LayoutFile) -> impl Iterator<Item = &str> {
    let known = layout.features.iter().filter(|feature| Kind::of(feature).is_some());
    known.flat_map(|feature| feature.properties.id.as_deref().into_iter().chain(feature.properties.street.as_deref()))
}

fn exact(layout: &LayoutFile, id: &str) -> Option<Found> {
    let features = || layout.features.iter().enumerate();
    let own =
        features().find(|(_, feature)| feature.properties.id.as_deref() == Some(id) && Kind::of(feature).is_some());
    if let Some((i, feature)) = own {
        let place = middle(&feature.geometry)?;
        return Some(Found { kind: Kind::of(feature)?, id: id.to_owned(), features: vec![i], place, is_place: false });
    }
    let runs: Vec<usize> =
        features().filter(|(_, feature)| feature.properties.street.as_deref() == Some(id)).map(|(i, _)| i).collect();
    let place = middle(&layout.features[*runs.get(runs.len() / 2)?].geometry)?;
    Some(Found { kind: Kind::Street, id: id.to_owned(), features: runs, place, is_place: false })
}

fn unknown(layout: &LayoutFile, id: &str) -> WhyError {
    let of_no_kind = layout.features.iter().find(|feature| feature.properties.id.as_deref() == Some(id));
    if let Some(kind) = of_no_kind.and_then(|feature| feature.properties.kind.as_deref()) {
        let message = format!("`{id}` is a {kind}: the city script draws it, no rule decides on it");
        let hint = "ask about a street, crossing, quarter, block, parcel or building in it".into();
        return WhyError::Unknown { message, hint };
    }
    let shared = |other: &str| id.bytes().zip(other.bytes()).take_while(|(a, b)| a == b).count();
    let mut near: Vec<(usize, &str)> = ids(layout).map(|other| (shared(other), other)).collect();
    near.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(b.1)));
    near.dedup();
    let near: Vec<&str> = near.into_iter().filter(|(count, _)| *count >= 3).take(3).map(|(_, id)| id).collect();
    let hint = if near.is_empty() { what_there_is(layout) } else { format!("did you mean {}?", near.join(" or ")) };
    WhyError::Unknown { message: format!("nothing in this layout has the id `{id}`"), hint }
}

fn what_there_is(layout: &LayoutFile) -> String {
    let mut counts: BTreeMap<&str, (usize, &str)> = BTreeMap::new();
    for feature in layout.features.iter().filter(|feature| Kind::of(feature).is_some()) {
        if let (Some(kind), Some(id)) = (feature.properties.kind.as_deref(), feature.properties.id.as_deref()) {
            counts.entry(kind).or_insert((0, id)).0 += 1;
        }
    }
    let each: Vec<String> =
        counts.iter().map(|(kind, (count, id))| format!("{count} of kind {kind}, such as {id}")).collect();
    if each.is_empty() { "the layout is empty".into() } else { format!("there are {}", each.join("; ")) }
}

/// The middle of what a feature shows.
fn middle(geometry: &Geometry) -> Option<Vec2> {
    match geometry {
        Geometry::Point(at) => Some(Vec2::from_array(*at)),
        Geometry::LineString(line) => {
            let at = |i: usize| Vec2::from_array(line[i]);
            match line.len() {
                0 => None,
                n if n % 2 == 1 => Some(at(n / 2)),
                n => Some(at(n / 2 - 1).midpoint(at(n / 2))),
            }
        }
        Geometry::Polygon(rings) => crate::measure::place_inside(rings).map(Vec2::from_array),
        Geometry::Nothing | Geometry::Other(_) => None,
    }
}

/// How the layout differs from the city as it is now: in what is asked about, and in its streets as a whole.
pub fn differences(found: &Found, evidence: &Evidence) -> Vec<String> {
    let mut bytes = Vec::new();
    // Writing to memory does not fail, and what is written reads back.
    let now = write_layout(&evidence.built.city, &mut bytes).ok();
    let Some(now) = now.and_then(|()| parse_layout(&bytes, Path::new("the city")).ok()) else { return Vec::new() };
    let kind = found.kind.name();
    let as_now = by_id(&now, kind);
    let mut differs = Vec::new();
    for feature in found.features.iter().map(|&i| &evidence.layout.features[i]) {
        let id = feature.properties.id.as_deref().unwrap_or_default();
        match as_now.get(id) {
            None => differs.push(format!("the city no longer has {kind} {id}")),
            Some(other) if *other != &feature.geometry => {
                differs.push(format!("{kind} {id} now lies elsewhere or has another shape"));
            }
            Some(_) => {}
        }
    }
    let features = found.features.iter().map(|&i| &evidence.layout.features[i]);
    let otherwise: BTreeSet<String> = features.flat_map(|feature| said_otherwise(feature, &now)).collect();
    differs.extend(otherwise);
    if found.kind == Kind::Block {
        let of = |layout| parcels_of(layout, &found.id);
        let (then, now) = (of(evidence.layout), of(&now));
        // A layout that ends before parcels has none.
        if then != now && !then.is_empty() {
            differs.push(format!(
                "the block had {} parcels in the layout and has others now: {}",
                then.len(),
                now.len()
            ));
        }
    }
    let seed = evidence.layout.about.as_ref().and_then(|about| about.seed.clone());
    if let Some(seed) = seed.filter(|seed| *seed != evidence.sources.plan.seed.to_string()) {
        differs.push(format!("the layout has the seed {seed}, what is told the seed {}", evidence.sources.plan.seed));
    }
    let (then, now) = (by_id(evidence.layout, "street"), by_id(&now, "street"));
    let changed = then.iter().filter(|(id, line)| now.get(*id) != Some(line)).count();
    let added = now.keys().filter(|id| !then.contains_key(*id)).count();
    if changed + added > 0 {
        differs.push(format!("{changed} of {} streets of the layout are gone or moved, {added} are new", then.len()));
    }
    differs
}

/// What a feature says otherwise now: its class, width or height, the rule it is of, what it is for, which words it carries.
fn said_otherwise(then: &Feature, now: &LayoutFile) -> Vec<String> {
    let then = &then.properties;
    let same = |feature: &&Feature| feature.properties.kind == then.kind && feature.properties.id == then.id;
    let Some(now) = now.features.iter().find(same).map(|feature| &feature.properties) else { return Vec::new() };
    let kind = then.kind.as_deref().unwrap_or("feature");
    let name = |text: &Option<String>| text.clone().unwrap_or_else(|| "nothing".into());
    let metres = |number: Option<f64>| number.map_or_else(|| "nothing".into(), |metres| format!("{metres} m"));
    let mut differs = Vec::new();
    if then.usage != now.usage {
        differs.push(format!("the {kind} was {} in the layout and is {} now", name(&then.usage), name(&now.usage)));
    }
    let values = [
        ("class", name(&then.class), name(&now.class)),
        ("width", metres(then.width), metres(now.width)),
        ("height", metres(then.height), metres(now.height)),
        ("level", then.level.to_string(), now.level.to_string()),
        ("rule", name(&then.rule), name(&now.rule)),
    ];
    let changed = values.into_iter().filter(|(_, then, now)| then != now);
    differs.extend(
        changed.map(|(what, then, now)| format!("the {kind} had the {what} {then} in the layout and has {now} now")),
    );
    if then.tags != now.tags {
        differs.push(format!("the {kind} carries other tags now"));
    }
    differs
}

/// The parcels of a block, with what they are for.
fn parcels_of(layout: &LayoutFile, block: &str) -> BTreeSet<(Option<String>, Option<String>)> {
    let of = layout.features.iter().filter(|feature| feature.properties.block.as_deref() == Some(block));
    of.map(|feature| (feature.properties.id.clone(), feature.properties.usage.clone())).collect()
}

fn by_id<'a>(layout: &'a LayoutFile, kind: &str) -> BTreeMap<&'a str, &'a Geometry> {
    let such = layout.features.iter().filter(|feature| feature.properties.kind.as_deref() == Some(kind));
    such.filter_map(|feature| Some((feature.properties.id.as_deref()?, &feature.geometry))).collect()
}
