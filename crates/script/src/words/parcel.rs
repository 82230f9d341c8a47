//! What parcels are for: `assign(parcel, p)`, which a parcel rule may have besides `subdivide(block, p)`.

use super::method;
use super::shape::{ShapeContext, Shaped, properties};
use crate::fault::{Complaint, Faults};
use crate::host::{Caller, Handle};
use crate::rule::{Rule, RuleKind};
use layout::Use;
use rhai::{Dynamic, Engine};
use std::collections::BTreeSet;
use std::sync::Arc;

/// What a rule says of a parcel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assigned {
    /// What it is for; as it was divided when none.
    pub usage: Option<Use>,
    /// Words that it carries, in alphabetical order.
    pub tags: Vec<Arc<str>>,
}

/// The `assign` of a parcel rule, ready to be asked from any thread.
pub struct AssignPattern {
    caller: Caller<Assigning>,
    faults: Arc<Faults>,
}

/// What `parcel` stands for during a call.
#[derive(Clone, Debug)]
struct Assigning {
    shape: ShapeContext,
    usage: Option<Use>,
    tags: BTreeSet<Arc<str>>,
}

impl Shaped for Assigning {
    fn shape(&self) -> &ShapeContext {
        &self.shape
    }
}

impl AssignPattern {
    /// The pattern of a rule with `assign(parcel, p)`; what goes wrong is reported to `faults`.
    pub fn new(rule: Rule, faults: Arc<Faults>) -> Self {
        Self { caller: Caller::new(rule, RuleKind::Assign), faults }
    }

    /// What a parcel is for. On a fault it stays as it was divided.
    pub fn assign(&self, shape: ShapeContext) -> Assigned {
        let place = shape.place;
        match self.caller.call(Assigning { shape, usage: None, tags: BTreeSet::new() }) {
            Ok(told) => Assigned { usage: told.usage, tags: told.tags.into_iter().collect() },
            Err(fault) => {
                self.faults.report(fault.at(place));
                Assigned::default()
            }
        }
    }
}

/// Most words that a parcel may carry.
const MOST_TAGS: usize = 16;
/// Longest of them, in characters.
const LONGEST_TAG: usize = 40;
/// What the program itself says of parcels.
const OWN_TAGS: [&str; 1] = ["inner"];

pub(super) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Handle<Assigning>>("parcel");
    properties::<Assigning>(engine);
    method!(engine, "tag"(name) "The parcel carries a word: in layout.geojson, and for building rules.", Assigning, |a, name| {
        a.tags.insert(tag(name)?.into());
        if a.tags.len() > MOST_TAGS { Err(Complaint::new("a parcel carries at most 16 tags")) } else { Ok(()) }
    });
    method!(engine, "open"() "The parcel stays open land.", Assigning, |a| {
        a.usage = Some(Use::Open);
        Ok(())
    });
    method!(engine, "park"() "The parcel becomes a park.", Assigning, |a| {
        a.usage = Some(Use::Park);
        Ok(())
    });
    method!(engine, "plaza"() "The parcel becomes a plaza.", Assigning, |a| {
        a.usage = Some(Use::Plaza);
        Ok(())
    });
}

/// A word that a parcel may carry.
pub(super) fn tag(name: &Dynamic) -> Result<String, Complaint> {
    let text = name.clone().into_string();
    let text = text.map_err(|_| Complaint::new("a tag is a text").hint("parcel.tag(\"shop\")"))?;
    let is_plain = |c: char| c.is_alphanumeric() || "_- ".contains(c);
    if text.is_empty() || text.chars().count() > LONGEST_TAG || !text.chars().all(is_plain) {
        let help = "letters, digits, spaces, - and _, at most 40 of them";
        return Err(Complaint::new("this cannot be a tag").hint(help));
    }
    if OWN_TAGS.contains(&text.as_str()) {
        return Err(
            Complaint::new(format!("`{text}` is what the program itself says of parcels")).hint("take another word")
        );
    }
    Ok(text)
}
