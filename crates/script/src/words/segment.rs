//! Constraints of one's own: `constrain(segment, p)`.

use super::tally::Tally;
use super::{Looks, chance, method, property, within};
use crate::fault::{Complaint, Fault, Faults};
use crate::host::{Caller, Handle, Located, numeric};
use crate::names::hint;
use crate::plan::MapRef;
use crate::rule::{Rule, RuleKind};
use geom::{Angle, Point, Vec2};
use rhai::{Dynamic, Engine};
use std::fmt;
use std::sync::Arc;
use streets::Classes;
use streets::growth::{Constrain, Draft, Field, Fields};

/// What is told of a constraint that refuses everything that it is asked about: in a class of streets, or in a quarter. Where it
/// agrees elsewhere that is no mistake.
pub const REFUSES_EVERYTHING: &str = "this constraint refuses every street";

/// A local constraint that a rule decides: what the growth kernel asks.
pub struct ConstraintPattern {
    caller: Caller<Drafting>,
    classes: Arc<Classes>,
    faults: Arc<Faults>,
    tally: Tally,
}

impl Drop for ConstraintPattern {
    /// At the end of the stage it is known whether the rule admitted anything.
    fn drop(&mut self) {
        let hint = "a street stays as it is unless segment.refuse(…) is called: is a comparison the wrong way round?";
        self.tally.warn(self.caller.rule(), RuleKind::Constrain, REFUSES_EVERYTHING, hint, &self.faults);
    }
}

impl fmt::Debug for ConstraintPattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ConstraintPattern").field("rule", self.caller.rule()).finish_non_exhaustive()
    }
}

/// What `segment` stands for during a call.
#[derive(Clone, Debug)]
struct Drafting {
    draft: Draft,
    classes: Arc<Classes>,
    looks: Looks,
}

impl Located for Drafting {
    fn place(&self) -> Vec2 {
        self.draft.from
    }
}

impl ConstraintPattern {
    /// The constraint of a rule with `constrain(segment, p)`; what goes wrong is reported to `faults`.
    pub fn new(rule: Rule, classes: Arc<Classes>, faults: Arc<Faults>) -> Self {
        let caller = Caller::new(rule, RuleKind::Constrain);
        Self { caller, classes, faults, tally: Tally::default() }
    }
}

impl Constrain for ConstraintPattern {
    fn is_in_vain(&self) -> bool {
        self.tally.is_in_vain()
    }

    fn has_agreed(&self) {
        self.tally.count(true);
    }

    /// On a fault the street is refused. Reasons carry the rule's name.
    fn constrain(&self, draft: &mut Draft) {
        let classes = self.classes.clone();
        let refuse = |why: &str| -> Arc<str> { format!("{}: {why}", self.caller.rule().name()).into() };
        match self.caller.call(Drafting { draft: draft.clone(), classes, looks: Looks::default() }) {
            Ok(left) => {
                *draft = left.draft;
                self.tally.count(draft.refused.is_none());
                draft.refused = draft.refused.take().map(|why| refuse(&why));
            }
            Err(fault) => {
                self.tally.count(true);
                let fault: Fault = *fault;
                draft.refuse(refuse("the rule failed"));
                self.faults.report(fault.at(draft.from));
            }
        }
    }
}

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Handle<Drafting>>("segment");
    properties(engine);
    questions(engine);
    answers(engine);
}

fn properties(engine: &mut Engine) {
    property::<Drafting, f64>(engine, "from_x", "East of its start, m.", |d| d.draft.from.x);
    property::<Drafting, f64>(engine, "from_y", "North of its start, m.", |d| d.draft.from.y);
    property::<Drafting, f64>(engine, "to_x", "East of its end, m.", |d| d.draft.to.x);
    property::<Drafting, f64>(engine, "to_y", "North of its end, m.", |d| d.draft.to.y);
    property::<Drafting, f64>(engine, "length", "Its length, m.", |d| d.draft.length());
    property::<Drafting, f64>(engine, "heading", "Its heading, ° counter-clockwise from east.", |d| {
        d.draft.heading.wrapped().to_degrees()
    });
    property::<Drafting, String>(engine, "class", "The name of its class: `highway`, `major`, `minor`.", |d| {
        d.classes.info(d.draft.class).name.clone()
    });
    property::<Drafting, i64>(engine, "level", "0 on the ground, above it on a bridge, below it in a tunnel.", |d| {
        i64::from(d.draft.level)
    });
    property::<Drafting, bool>(engine, "meets_street", "Whether it ends on another street.", |d| d.draft.meets_street);
    property::<Drafting, f64>(engine, "slope", "Its grade from end to end, rise over run.", |d| d.draft.grade().abs());
    property::<Drafting, f64>(engine, "density", "People per km² at its end; 1 without a map `density`.", |d| {
        d.draft.fields.density.at(d.draft.to)
    });
    chance::<Drafting>(engine, |d| d.draft.seed);
}

fn questions(engine: &mut Engine) {
    method!(engine, "map"(name) "The value of a map of the site at the segment's end.", Drafting,
        |d, name| Ok(field(&d.draft.fields, name)?.at(d.draft.to)));
    method!(engine, "map"(name, share) "The value of a map at a share of the segment's length, from 0 to 1.", Drafting, |d, name, share| {
        let share = within("the share", share, 0.0, 1.0, "")?;
        Ok(field(&d.draft.fields, name)?.at(d.draft.at_share(share)))
    });
    method!(engine, "distance_to"(name) "Metres from the nearest place of the segment to what a map marks; endless without a map `parks`.", Drafting, |d, name| {
        // It looks along the whole segment, about every metre.
        d.looks.take(1.0 + d.draft.length())?;
        let name = map_name(name)?;
        match d.draft.fields.distance_to(&name, d.draft.from, d.draft.to) {
            Some(metres) => Ok(metres),
            // A site without that map has none.
            None if name == "parks" => Ok(f64::INFINITY),
            None => Err(missing(&d.draft.fields, &name)),
        }
    });
    method!(engine, "has_map"(name) "Whether the site has a map.", Drafting, |d, name| {
        Ok(d.draft.fields.maps.contains_key(&map_name(name)?))
    });
}

/// The name of a map, told by itself or as a parameter.
pub(super) fn map_name(name: &Dynamic) -> Result<String, Complaint> {
    let map = name.read_lock::<MapRef>().map(|map| map.name.clone());
    let name = map.or_else(|| name.clone().into_string().ok());
    name.ok_or_else(|| Complaint::new("a map is asked for by its name"))
}

/// The complaint that growth knows no map of a name.
pub(super) fn missing(fields: &Fields, name: &str) -> Complaint {
    no_map_of(fields.maps.keys().map(String::as_str), name)
}

/// The complaint that a site with these maps has none of a name.
pub(super) fn no_map_of<'a>(known: impl Iterator<Item = &'a str> + Clone, name: &str) -> Complaint {
    let bare =
        "it has none at all: maps lie in the folder of site(\"maps\"), or are drawn, site(#{ density: |x, y| … })";
    let near = hint(name, known.clone()).or_else(|| known.clone().next().is_none().then(|| bare.to_owned()));
    Complaint::new(format!("the site has no map `{name}`")).maybe_hint(near)
}

/// A map of the site, by its name or as a parameter.
fn field<'a>(fields: &'a Fields, name: &Dynamic) -> Result<&'a Field, Complaint> {
    let name = map_name(name)?;
    fields.maps.get(&name).ok_or_else(|| missing(fields, &name))
}

fn answers(engine: &mut Engine) {
    method!(engine, "turn"(degrees) "Turns the segment about its start, counter-clockwise.", Drafting, |d, degrees| {
        d.draft.turn(Angle::degrees(within("the turn", degrees, -180.0, 180.0, "°")?));
        Ok(())
    });
    method!(engine, "shorten"(metres) "Takes so many metres off its end.", Drafting, |d, metres| {
        let metres = numeric("the metres to take off", metres)?;
        let left = d.draft.length() - metres;
        cut(&mut d.draft, left, "a segment is shortened by at least nothing and less than its length")
    });
    method!(engine, "cut_to"(metres) "Cuts it to a length in metres.", Drafting, |d, metres| {
        let length = numeric("the length", metres)?;
        cut(&mut d.draft, length, "a segment is cut to a length above 0 and at most its own")
    });
    method!(engine, "end_at"(x, y) "Lets it end at a place, in metres.", Drafting, |d, x, y| {
        let place = Vec2::new(numeric("x", x)?, numeric("y", y)?);
        let far = || Complaint::new("a segment cannot end more than 500 km away");
        Point::try_from_metres(place).ok_or_else(far)?;
        d.draft.end_at(place);
        Ok(())
    });
    method!(engine, "refuse"(why) "The segment is not laid; the report says why.", Drafting, |d, why| {
        let text = why.clone().into_string();
        let text = text.map_err(|_| Complaint::new("say why in a text: segment.refuse(\"too close to a park\")"))?;
        d.draft.refuse(text.into());
        Ok(())
    });
}

fn cut(draft: &mut Draft, length: f64, rule: &str) -> Result<(), Complaint> {
    let whole = draft.length();
    if !(length > 0.0 && length <= whole) {
        return Err(Complaint::new(rule).hint(format!("it is {whole:.1} m long")));
    }
    if length < whole {
        draft.cut_to(length);
    }
    Ok(())
}
