//! Grounds that stay whole: what of a region belongs to one becomes a region of its own, the rest is divided as usual.

use super::{Block, Buildable, Piece, Region, clean, label, pieces_in};
use geom::strip::{Reach, strip};
use geom::{Polygon, boolean};

/// The regions of a block, parted by grounds that stay whole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Parted {
    /// What belongs to grounds: the position of the ground, and the region; by region, then by ground.
    pub kept: Vec<(usize, Region)>,
    /// The rest. A region that no ground reaches is as it was.
    pub rest: Vec<Region>,
    /// Twice the area that was cleaned away besides, in LSB².
    pub dropped: i128,
}

/// Parts the buildable land of a block. No two of `grounds` may overlap.
pub fn part_grounds(block: &Block, land: Buildable, grounds: &[Polygon]) -> Parted {
    let mut parted = Parted { dropped: land.dropped, ..Parted::default() };
    let regions = land.regions.len() as u32;
    let mut pieces = None;
    for region in land.regions {
        let kept = kept_of(&region, grounds);
        if kept.is_empty() {
            parted.rest.push(region);
            continue;
        }
        let pieces = pieces.get_or_insert_with(|| pieces_in(block));
        let taken: Vec<Polygon> = kept.iter().map(|(_, polygon)| polygon.clone()).collect();
        let rest = rest_of(&region.polygon, &taken);
        let area = |polygons: &[Polygon]| polygons.iter().map(Polygon::doubled_area).sum::<i128>();
        parted.dropped += region.polygon.doubled_area() - area(&taken) - area(&rest);
        let labelled = |polygon: Polygon, ordinal: u32| Region {
            block: block.id,
            ordinal,
            frontage: frontage(&polygon, pieces),
            polygon,
        };
        // Further parts count on behind all regions, so that no other region is renamed.
        let ordinal = |part: usize| region.ordinal + part as u32 * regions;
        parted.kept.extend(kept.into_iter().map(|(ground, polygon)| (ground, labelled(polygon, region.ordinal))));
        parted.rest.extend(rest.into_iter().enumerate().map(|(part, polygon)| labelled(polygon, ordinal(part))));
    }
    parted
}

/// What of a region belongs to each ground.
fn kept_of(region: &Region, grounds: &[Polygon]) -> Vec<(usize, Polygon)> {
    let bounds = region.polygon.bounds();
    let reaches = |ground: &Polygon| ground.bounds().zip(bounds).is_some_and(|(a, b)| a.overlaps(&b));
    let near = grounds.iter().enumerate().filter(|(_, ground)| reaches(ground));
    near.flat_map(|(i, ground)| {
        let common = boolean::intersection(std::slice::from_ref(&region.polygon), std::slice::from_ref(ground));
        common.into_iter().flat_map(clean::cleaned).map(move |polygon| (i, polygon))
    })
    .collect()
}

/// A region without what is taken from it, exactly clear of it.
fn rest_of(region: &Polygon, taken: &[Polygon]) -> Vec<Polygon> {
    let without = |removed: &[Polygon]| -> Vec<Polygon> {
        boolean::difference(std::slice::from_ref(region), removed).into_iter().flat_map(clean::cleaned).collect()
    };
    let rest = without(taken);
    if boolean::intersection(&rest, taken).is_empty() {
        return rest;
    }
    // Where borders cut each other, rounding may push one over the other: then a seam of two LSB parts them.
    let seams = taken.iter().flat_map(Polygon::edges).filter_map(|(a, b)| strip(a, b, Reach::default()));
    let seams = seams.map(|ring| Polygon::new(ring.to_vec(), Vec::new()));
    without(&taken.iter().cloned().chain(seams).collect::<Vec<_>>())
}

fn frontage(polygon: &Polygon, pieces: &[Piece]) -> Vec<Vec<Option<streets::StreetId>>> {
    polygon.rings().map(|ring| label::streets_of_edges(ring, pieces)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::buildable;
    use crate::samples::{block, blocks, rectangle, street};
    use geom::Point;
    use geom::tolerance::PARCEL_EDGE;
    use proptest::prelude::*;

    fn doubled_area<'a>(regions: impl Iterator<Item = &'a Region>) -> i128 {
        regions.map(|region| region.polygon.doubled_area()).sum()
    }

    /// A polygon moved by so many metres.
    fn moved(polygon: &Polygon, x: f64, y: f64) -> Polygon {
        let by = Point::new(geom::point::units(x), geom::point::units(y));
        let ring = polygon.outer.iter().map(|p| Point::new(p.x + by.x, p.y + by.y)).collect();
        Polygon::new(ring, Vec::new())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(300))]

        #[test]
        fn grounds_and_the_rest_share_the_land_without_overlap(
            block in blocks(), ground in crate::samples::quads(), x in -150.0..150.0f64, y in -150.0..150.0f64,
        ) {
            let land = buildable(&block);
            let whole = doubled_area(land.regions.iter());
            let lost = land.dropped;
            let ground = moved(&ground, x, y);
            let parted = part_grounds(&block, land, std::slice::from_ref(&ground));
            let kept: Vec<Region> = parted.kept.into_iter().map(|(_, region)| region).collect();
            prop_assert_eq!(doubled_area(kept.iter().chain(&parted.rest)) + parted.dropped - lost, whole);
            let all: Vec<&Region> = kept.iter().chain(&parted.rest).collect();
            for (i, region) in all.iter().enumerate() {
                prop_assert!(region.polygon.is_simple());
                prop_assert!(region.polygon.edges().all(|(a, b)| a.distance(b) >= f64::from(PARCEL_EDGE) / 1024.0));
                prop_assert_eq!(region.frontage.len(), 1 + region.polygon.holes.len());
                for other in &all[..i] {
                    let common = boolean::intersection(
                        std::slice::from_ref(&region.polygon), std::slice::from_ref(&other.polygon));
                    prop_assert!(common.is_empty(), "{common:?}");
                }
            }
            let mut ordinals: Vec<u32> = parted.rest.iter().map(|region| region.ordinal).collect();
            ordinals.sort_unstable();
            ordinals.dedup();
            prop_assert_eq!(ordinals.len(), parted.rest.len());
        }
    }

    #[test]
    fn a_ground_inside_a_block_is_a_region_of_its_own() {
        let block = block(rectangle(200.0, 100.0), &[8.0]);
        let ground = moved(&rectangle(40.0, 30.0), 80.0, 40.0);
        let parted = part_grounds(&block, buildable(&block), &[moved(&ground, 500.0, 0.0), ground.clone()]);
        let [(1, kept)] = parted.kept.as_slice() else { panic!("{:?}", parted.kept) };
        assert_eq!((&kept.polygon, parted.rest.len()), (&ground, 1));
        assert!(kept.access().is_empty() && !parted.rest[0].access().is_empty());
        assert_eq!(parted.rest[0].polygon.holes.len(), 1);
    }

    #[test]
    fn a_ground_at_a_street_fronts_it() {
        let block = block(rectangle(200.0, 100.0), &[8.0]);
        // Its southern part lies in the right-of-way, and is cut off.
        let parted = part_grounds(&block, buildable(&block), &[moved(&rectangle(40.0, 60.0), 80.0, -10.0)]);
        let (_, kept) = &parted.kept[0];
        let [(found, length)] = kept.access()[..] else { panic!("{:?}", kept.access()) };
        assert_eq!((found, length.round()), (street(0), 40.0));
        let untouched = part_grounds(&block, buildable(&block), &[]);
        assert_eq!(untouched.rest, buildable(&block).regions);
    }
}
