//! Land: blocks from faces, parcels from blocks, each block by itself.

use super::ground::{CityGround, Read, reading};
use super::keep::{Rules, Silence};
use super::{ByPlace, Context, Outlines, landmarks, shape};
use crate::{BuildError, Landmark, Site, Stage, cache};
use geom::polygon::min_area_box;
use geom::{Bounds, Digest, Id, Point, Polygon, Vec2};
use layout::{
    Block, BlockSource, DivisionStep, Parcel, Parted, Region, Use, buildable, longest_side, part_grounds,
    recursive_telling,
};
use rayon::prelude::*;
use script::{AssignPattern, BlockContext, ParcelChoice, ParcelPattern, RuleKind, ShapeContext};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::sync::Arc;
use streets::StreetGraph;

/// Blocks and parcels of a city, by id.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Land {
    pub blocks: Arc<Vec<Block>>,
    pub parcels: Arc<Vec<Parcel>>,
    /// Twice the area in LSB² that neither parcels nor rights-of-way cover: slivers.
    pub trimmed: i128,
    /// How many parcels stay open.
    pub open: usize,
    /// Landmarks with their parcels, by id.
    pub landmarks: Vec<Landmark>,
    /// For each block what its parcels are kept by, where they were divided as parts of a build that keeps them.
    pub keys: Vec<Option<Id>>,
}

/// Derives blocks alone.
pub(crate) fn derive_blocks(context: &Context, graph: &StreetGraph, outlines: &Outlines) -> Result<Land, BuildError> {
    let source = BlockSource::new(graph, &outlines.blocks, &outlines.quarters);
    let block = |face| (!context.cancel.is_cancelled()).then(|| source.block(face));
    let faces = &outlines.blocks.faces;
    let is_wanted = |&face: &usize| {
        context.within.is_none_or(|bounds| {
            let corners = faces[face].sides.iter().map(|side| side.from);
            Bounds::of(corners).is_some_and(|around| around.overlaps(&bounds))
        })
    };
    let blocks: Option<Vec<Block>> = (0..faces.len()).into_par_iter().filter(is_wanted).map(block).collect();
    let blocks = blocks.ok_or(BuildError::Cancelled)?;
    let landmarks = landmarks::settle(&context.sources.plan.landmarks, Vec::new()).0;
    Ok(Land { blocks: blocks.into(), parcels: Arc::default(), trimmed: 0, open: 0, landmarks, keys: Vec::new() })
}

/// Derives blocks and parcels.
pub(crate) fn derive(
    context: &Context,
    graph: &StreetGraph,
    outlines: &Outlines,
    ground: &Arc<CityGround>,
) -> Result<Arc<Land>, BuildError> {
    context.stage_of_blocks(
        |keys| keys.land,
        |silence| {
            let land = derive_blocks(context, graph, outlines)?;
            divide_all(context, land, ground, silence)
        },
    )
}

fn divide_all(
    context: &Context,
    mut land: Land,
    ground: &Arc<CityGround>,
    silence: &Silence,
) -> Result<Land, BuildError> {
    let plan = &context.sources.plan;
    let patterns = ByPlace::of(context, "parcels", |rule| Patterns {
        assign: rule
            .kinds()
            .contains(&RuleKind::Assign)
            .then(|| AssignPattern::new(rule.clone(), context.faults.clone())),
        parcels: ParcelPattern::new(rule, context.faults.clone()),
    });
    context.progress.begin(Stage::Parcels, land.blocks.len() as u64);
    let (grounds, rules) = (landmarks::grounds(&plan.landmarks), Rules::of(context, |digests| digests.parcels));
    let divide = |block: &Block| {
        if context.cancel.is_cancelled() {
            return (None, Default::default());
        }
        let key = rules.as_ref().and_then(|rules| block_key(context, rules, ground, block));
        let make = || {
            let (divided, reads) = reading(|| divide(context, ground, &patterns, &grounds, block));
            KeptBlock { divided, reads }
        };
        let kept = silence.over(|| context.part(key, |kept: &KeptBlock| ground.would_tell(&kept.reads), make));
        context.progress.advance(1);
        (key.map(|key| Digest::new("divided").id(key).value(&kept.reads).finish()), kept)
    };
    let divided: Vec<(Option<Id>, Arc<KeptBlock>)> = land.blocks.par_iter().map(divide).collect();
    context.check()?;
    let (mut parcels, mut parts) = (Vec::new(), Vec::new());
    for (key, kept) in divided {
        let KeptBlock { divided, .. } = Arc::unwrap_or_clone(kept);
        land.keys.push(key);
        parcels.extend(divided.parcels);
        parts.extend(divided.landmarks);
        land.trimmed += divided.trimmed;
    }
    let (settled, of_landmarks) = landmarks::settle(&plan.landmarks, parts);
    land.landmarks = settled;
    parcels.extend(of_landmarks);
    parcels.sort_by_key(|parcel| parcel.id);
    land.parcels = parcels.into();
    land.open = land.parcels.iter().filter(|parcel| parcel.usage != Use::Built).count();
    let outcome = format!("{} parcels in {} blocks", land.parcels.len(), land.blocks.len());
    context.progress.end(Stage::Parcels, &outcome);
    Ok(land)
}

/// What a block's parcels are kept by: all that its rules can see but what they ask about streets farther off.
fn block_key(context: &Context, rules: &Rules, ground: &CityGround, block: &Block) -> Option<Id> {
    let streets: BTreeSet<_> = block.bodies.iter().map(|body| body.street).collect();
    let streets: Vec<_> = streets.into_iter().map(|street| (street, ground.street(street))).collect();
    let mut digest = Digest::new("block");
    digest.id(rules.at(block.quarter)).bytes(&cache::bytes_of(block)?);
    digest.value(&(streets, context.seed(block.quarter)));
    Some(digest.finish())
}

/// A block's parcels with what its rules asked about streets.
#[derive(Clone, Default)]
struct KeptBlock {
    divided: Divided,
    reads: Vec<Read>,
}

/// What a block is divided into.
#[derive(Clone, Default)]
struct Divided {
    parcels: Vec<Parcel>,
    /// Parts of landmarks, with the position of the landmark; their ids are still to be told.
    landmarks: Vec<(usize, Parcel)>,
    /// Twice the area in LSB² of the slivers.
    trimmed: i128,
}

/// Divides one block as its rule says, region by region, after what landmarks keep of it.
fn divide(
    context: &Context,
    ground: &Arc<CityGround>,
    patterns: &ByPlace<Patterns>,
    grounds: &[Polygon],
    block: &Block,
) -> Divided {
    let land = parted(block, grounds);
    let usage = |landmark: usize| context.sources.plan.landmarks[landmark].usage;
    let keep = |(landmark, region): &(usize, Region)| (*landmark, landmark_parcel(region, usage(*landmark)));
    let mut parcels = Vec::new();
    let mut trimmed = land.dropped;
    for region in &land.rest {
        let patterns = patterns.at(block.quarter, &district_of(context, region));
        let mut divided =
            divide_region(context, ground, patterns.map(|patterns| &patterns.parcels), block, region, &mut |_| {});
        if let Some(pattern) = patterns.and_then(|patterns| patterns.assign.as_ref())
            && divided.cover == Cover::Land
        {
            divided.parcels.iter_mut().for_each(|parcel| assign(context, ground, pattern, block.quarter, parcel));
        }
        parcels.extend(divided.parcels);
        trimmed += divided.trimmed;
    }
    Divided { parcels, landmarks: land.kept.iter().map(keep).collect(), trimmed }
}

/// What of a block can be divided, without what landmarks keep.
pub(crate) fn parted(block: &Block, grounds: &[Polygon]) -> Parted {
    part_grounds(block, buildable(block), grounds)
}

/// What a region of a block is divided into, before parcels are assigned what they are for.
pub(crate) struct DividedRegion {
    pub cover: Cover,
    /// What the rule said, where it was asked and there is one.
    pub choice: Option<ParcelChoice>,
    pub parcels: Vec<Parcel>,
    /// Twice the area in LSB² of the slivers.
    trimmed: i128,
}

/// Divides a region as its rule says, telling the steps of that.
pub(crate) fn divide_region(
    context: &Context,
    ground: &Arc<CityGround>,
    pattern: Option<&ParcelPattern>,
    block: &Block,
    region: &Region,
    tell: &mut dyn FnMut(DivisionStep),
) -> DividedRegion {
    let one = |usage| whole(region, region.ordinal as usize, usage);
    let undivided = |cover, choice, parcel| DividedRegion { cover, choice, parcels: vec![parcel], trimmed: 0 };
    let cover = cover(&context.sources.site, &region.polygon);
    match cover {
        Cover::Land => {}
        Cover::Park => return undivided(cover, None, Parcel { usage: Use::Park, ..one(Use::Park) }),
        Cover::Water => return undivided(cover, None, one(Use::Open)),
    }
    let about = block_context(context, ground, block, region);
    let seed = about.seed;
    let choice = pattern.map(|pattern| pattern.choose(about));
    match choice {
        Some(ParcelChoice::Recursive(settings)) => {
            match recursive_telling(region, &layout::RecursiveSettings { seed, ..settings }, tell) {
                Ok(division) => DividedRegion { cover, choice, parcels: division.parcels, trimmed: division.trimmed },
                // Settings are checked where the rule gives them; what slips through leaves the region whole.
                Err(_) => undivided(cover, choice, one(Use::Built)),
            }
        }
        Some(ParcelChoice::Open) => undivided(cover, choice, one(Use::Open)),
        Some(ParcelChoice::Whole) | None => undivided(cover, choice, one(Use::Built)),
    }
}

/// What the rules of a place decide about blocks.
struct Patterns {
    parcels: ParcelPattern,
    /// What parcels are for, where the rule says so.
    assign: Option<AssignPattern>,
}

/// Asks a rule what a parcel that may be built on is for.
fn assign(
    context: &Context,
    ground: &Arc<CityGround>,
    pattern: &AssignPattern,
    quarter: Option<Id>,
    parcel: &mut Parcel,
) {
    if parcel.usage != Use::Built {
        return;
    }
    let told = pattern.assign(assigned_shape(context, ground, quarter, parcel));
    parcel.usage = told.usage.unwrap_or(parcel.usage);
    parcel.tags = told.tags;
}

/// What `assign` knows of a parcel.
pub(crate) fn assigned_shape(
    context: &Context,
    ground: &Arc<CityGround>,
    quarter: Option<Id>,
    parcel: &Parcel,
) -> ShapeContext {
    shape::of_parcel(context, ground, parcel, context.seed(quarter).purpose("assign").of(parcel.id))
}

/// What a landmark keeps of a block: it stays what it is meant for, even behind others.
fn landmark_parcel(region: &Region, usage: Use) -> Parcel {
    Parcel { usage, ..whole(region, 0, usage) }
}

/// What covers most of a region, by samples inside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cover {
    Land,
    Park,
    Water,
}

/// Samples along each side of a region's box when asking what covers it.
const COVER_SAMPLES: u32 = 8;

fn cover(site: &Site, region: &Polygon) -> Cover {
    let Some(bounds) = region.bounds() else { return Cover::Land };
    let (low, size) = (bounds.min.metres(), bounds.size());
    let share = |i: u32| (f64::from(i) + 0.5) / f64::from(COVER_SAMPLES);
    let grid = (0..COVER_SAMPLES * COVER_SAMPLES).map(|i| (share(i % COVER_SAMPLES), share(i / COVER_SAMPLES)));
    let places =
        grid.map(|(x, y)| low + Vec2::new(x, y) * size).filter(|&place| region.contains(Point::from_metres(place)));
    let (mut all, mut parks, mut water) = (0, 0, 0);
    for place in places {
        all += 1;
        parks += u32::from(site.map("parks").is_some_and(|map| map.mask(place)));
        water += u32::from(site.map("land").is_some_and(|map| !map.mask(place)));
    }
    match () {
        () if 2 * water > all => Cover::Water,
        () if 2 * parks > all => Cover::Park,
        () => Cover::Land,
    }
}

/// What `subdivide` knows of a region of a block.
pub(crate) fn block_context(
    context: &Context,
    ground: &Arc<CityGround>,
    block: &Block,
    region: &Region,
) -> BlockContext {
    let (polygon, place) = (&region.polygon, inner_place(&region.polygon));
    BlockContext {
        area: polygon.area(),
        perimeter: polygon.perimeter(),
        density: context.density(place),
        place,
        district: context.district(place),
        extent: min_area_box(&polygon.outer).half * 2.0,
        longest_side: longest_side(&polygon.outer),
        streets: ground.sides(&region.access()),
        ground: ground.clone(),
        seed: context.seed(block.quarter).purpose("parcels").of(block.id).child(u64::from(region.ordinal)),
    }
}

/// The district of a region.
pub(crate) fn district_of(context: &Context, region: &Region) -> String {
    context.district(inner_place(&region.polygon))
}

/// The centroid, or the inner point farthest from the rim where that lies outside.
pub(crate) fn inner_place(polygon: &Polygon) -> Vec2 {
    let centroid = polygon.centroid();
    if polygon.contains(Point::from_metres(centroid)) { centroid } else { polygon.pole(1.0).metres() }
}

/// A region as one parcel.
fn whole(region: &Region, ordinal: usize, usage: Use) -> Parcel {
    let id = Id::root("whole region", &[region.block.0, ordinal as u128]);
    let access = region.access();
    let usage = if access.is_empty() { Use::Open } else { usage };
    let index = |street| access.iter().position(|(known, _)| *known == street).map(|index| index as u16);
    let sides = region.frontage.first().map(|ring| ring.iter().map(|street| street.and_then(index)).collect());
    let sides = sides.unwrap_or_default();
    Parcel { id, block: region.block, polygon: region.polygon.clone(), access, sides, usage, tags: Vec::new() }
}
