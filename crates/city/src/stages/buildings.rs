//! Buildings: one parcel at a time.

use super::ground::{CityGround, Read, reading};
use super::keep::{Rules, Silence};
use super::land::{Land, inner_place};
use super::{ByPlace, Context, Origins, shape};
use crate::{BuildError, Landmark, Stage};
use buildings::{Building, Envelope, LEAST_HEIGHT, Setbacks, StartShape, footprint, raise};
use geom::{Digest, Id, Polygon};
use layout::{Parcel, Use};
use rayon::prelude::*;
use script::{BuildingChoice, BuildingPattern, Plan, Rule, ShapeContext};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The buildings of a city, with the names that they refer to by number.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Buildings {
    /// By id.
    pub all: Arc<Vec<Building>>,
    /// Those of streets, then those of buildings.
    pub origins: Origins,
}

/// Derives the buildings of all parcels that may carry one.
pub(crate) fn derive(
    context: &Context,
    land: &Land,
    ground: &Arc<CityGround>,
    origins: &Origins,
) -> Result<Arc<Buildings>, BuildError> {
    context.stage_of_blocks(|keys| keys.buildings, |silence| raise_all(context, land, ground, origins.clone(), silence))
}

fn raise_all(
    context: &Context,
    land: &Land,
    ground: &Arc<CityGround>,
    mut origins: Origins,
    silence: &Silence,
) -> Result<Buildings, BuildError> {
    let plan = &context.sources.plan;
    let own: Vec<Plan> = plan.quarters.keys().map(|&id| plan.in_quarter(Some(id)).into_owned()).collect();
    let plans = std::iter::once(plan).chain(&own);
    let rules: Vec<&Rule> =
        plans.flat_map(|plan| plan.buildings.iter().chain(plan.district_buildings.values())).collect();
    if rules.is_empty() {
        origins.of("plain");
        return Ok(Buildings { all: Arc::default(), origins });
    }
    let numbers: BTreeMap<&str, u16> = rules.into_iter().map(|rule| (rule.name(), origins.of(rule.name()))).collect();
    let patterns = ByPlace::of(context, "buildings", |rule| {
        let origin = numbers.get(rule.name()).copied().unwrap_or_default();
        (BuildingPattern::new(rule, context.faults.clone()), origin)
    });
    context.progress.begin(Stage::Buildings, land.parcels.len() as u64);
    let (rules, on) = (Rules::of(context, |digests| digests.buildings), OnBlocks::of(land));
    let raise_block = |&(block, ref parcels): &(usize, Vec<&Parcel>)| {
        let quarter = land.blocks[block].quarter;
        let key = rules.as_ref().and_then(|rules| {
            let mut digest = Digest::new("buildings of a block");
            digest.id(land.keys.get(block).copied()??).id(rules.at(quarter));
            digest.value(&(context.seed(quarter), &numbers));
            Some(digest.finish())
        });
        let make = || {
            let choose = |parcel: &&Parcel| choose(context, land, ground, &patterns, parcel, quarter);
            let (chosen, reads) = reading(|| parcels.iter().filter_map(choose).collect::<Vec<_>>());
            let footprints = footprints(context, land.keys.get(block).copied().flatten(), &chosen);
            let raised = chosen.iter().zip(footprints.iter()).filter_map(|(chosen, of)| chosen.raised(of.clone()?));
            KeptBuildings { buildings: raised.collect(), reads }
        };
        if context.cancel.is_cancelled() {
            return Default::default();
        }
        let is_valid = |kept: &KeptBuildings| ground.would_tell(&kept.reads);
        let kept = silence.over(|| context.part(key, is_valid, make));
        context.progress.advance(parcels.len() as u64);
        kept
    };
    let mut all: Vec<Building> = Vec::with_capacity(land.parcels.len());
    let raised: Vec<Arc<KeptBuildings>> = on.blocks.par_iter().map(raise_block).collect();
    context.check()?;
    raised.into_iter().for_each(|kept| all.extend_from_slice(&kept.buildings));
    // What landmarks keep is told apart by all blocks together.
    let of_landmarks = on.landmarks.iter().filter_map(|(parcel, quarter)| {
        let chosen = choose(context, land, ground, &patterns, parcel, *quarter)?;
        chosen.raised(footprint(&chosen.shape, &chosen.envelope)?)
    });
    all.extend(of_landmarks);
    all.sort_by_key(|building| building.id);
    context.progress.end(Stage::Buildings, &format!("{} buildings", all.len()));
    Ok(Buildings { all: all.into(), origins })
}

/// The buildings of a block with what their rules asked about streets.
#[derive(Default)]
struct KeptBuildings {
    buildings: Vec<Building>,
    reads: Vec<Read>,
}

/// The parcels of each block that may carry buildings.
struct OnBlocks<'a> {
    /// With the positions of the blocks.
    blocks: Vec<(usize, Vec<&'a Parcel>)>,
    /// Those of landmarks, with their quarters.
    landmarks: Vec<(&'a Parcel, Option<Id>)>,
}

impl<'a> OnBlocks<'a> {
    fn of(land: &'a Land) -> Self {
        let of_landmarks: BTreeSet<Id> =
            land.landmarks.iter().flat_map(|landmark| &landmark.parcels).copied().collect();
        let places: BTreeMap<Id, usize> = land.blocks.iter().enumerate().map(|(i, block)| (block.id, i)).collect();
        let mut by_block: Vec<Vec<&Parcel>> = vec![Vec::new(); land.blocks.len()];
        let mut landmarks = Vec::new();
        for parcel in land.parcels.iter().filter(|parcel| parcel.usage == Use::Built) {
            let Some(&block) = places.get(&parcel.block) else { continue };
            if of_landmarks.contains(&parcel.id) {
                landmarks.push((parcel, land.blocks[block].quarter));
            } else {
                by_block[block].push(parcel);
            }
        }
        let blocks = by_block.into_iter().enumerate().filter(|(_, parcels)| !parcels.is_empty()).collect();
        Self { blocks, landmarks }
    }
}

/// What a rule wants to stand on a parcel.
struct Chosen {
    shape: StartShape,
    envelope: Envelope,
    origin: u16,
}

impl Chosen {
    fn raised(&self, footprint: Polygon) -> Option<Building> {
        raise(&self.shape, &self.envelope, footprint).map(|building| Building { origin: self.origin, ..building })
    }
}

/// The footprints of what was chosen for the parcels of a block. They know nothing of heights: who turns those alone, or
/// writes a rule another way, need not wait for them again.
fn footprints(context: &Context, block: Option<Id>, chosen: &[Chosen]) -> Arc<Vec<Option<Polygon>>> {
    let key = block.map(|block| {
        let mut digest = Digest::new("footprints of a block");
        digest.id(block);
        for Chosen { shape, envelope, .. } in chosen {
            digest.id(shape.parcel);
            let numbers = match envelope.setbacks {
                Setbacks::Even(setback) => [setback, f64::NAN, f64::NAN, envelope.coverage],
                Setbacks::Sides { front, side, rear } => [front, side, rear, envelope.coverage],
            };
            digest.bytes(&numbers.map(f64::to_le_bytes).concat());
        }
        digest.finish()
    });
    context.cache.part(key, || chosen.iter().map(|chosen| footprint(&chosen.shape, &chosen.envelope)).collect())
}

/// Asks the rule of a parcel.
fn choose(
    context: &Context,
    land: &Land,
    ground: &Arc<CityGround>,
    patterns: &ByPlace<(BuildingPattern, u16)>,
    parcel: &Parcel,
    quarter: Option<Id>,
) -> Option<Chosen> {
    let place = inner_place(&parcel.polygon);
    let (pattern, origin) = patterns.at(quarter, &context.district(place))?;
    let about = built_shape(context, &land.landmarks, ground, parcel, quarter);
    let (density, max_height) = (about.density, about.max_height);
    let BuildingChoice::Extrude(envelope) = pattern.choose(about) else { return None };
    let envelope = limited(envelope, max_height)?;
    Some(Chosen { shape: start_shape(context, parcel, density), envelope, origin: *origin })
}

/// What `build` knows of a parcel.
pub(crate) fn built_shape(
    context: &Context,
    landmarks: &[Landmark],
    ground: &Arc<CityGround>,
    parcel: &Parcel,
    quarter: Option<Id>,
) -> ShapeContext {
    let seed = context.seed(quarter).purpose("buildings").of(parcel.id);
    let landmark = landmarks.iter().find(|landmark| landmark.parcels.contains(&parcel.id));
    let landmark = landmark.map_or_else(String::new, |landmark| landmark.name.clone());
    ShapeContext { landmark, ..shape::of_parcel(context, ground, parcel, seed) }
}

/// What a building on a parcel starts from.
pub(crate) fn start_shape(context: &Context, parcel: &Parcel, density: f64) -> StartShape {
    StartShape {
        parcel: parcel.id,
        outline: parcel.polygon.clone(),
        fronts: shape::fronts(parcel),
        density,
        ground: heights(context, &parcel.polygon),
    }
}

/// What a rule asks for, with the height that may stand there; nothing where none may.
pub(crate) fn limited(envelope: Envelope, max_height: f64) -> Option<Envelope> {
    let height = envelope.height.min(max_height);
    (max_height >= LEAST_HEIGHT).then_some(Envelope { height, ..envelope })
}

/// Lowest and highest ground on an outline, metres.
fn heights(context: &Context, outline: &Polygon) -> (f64, f64) {
    let heights = outline.outer.iter().map(|corner| context.sources.site.elevation(corner.metres()));
    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| (low.min(height), high.max(height)))
}
