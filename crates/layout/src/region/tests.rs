use super::*;
use crate::samples::{antenna, block, blocks, nasty, rectangle, ring, street};
use geom::predicates;
use proptest::prelude::*;

/// Whether `p` lies in the open strip of a body, its ends flat; exact.
fn in_body(body: &Body, p: Point) -> bool {
    let along = i128::from(predicates::dot(body.from, body.to, p));
    let across = i128::from(predicates::orient(body.from, body.to, p));
    let (length_squared, half) = (i128::from(body.from.distance_squared(body.to)), i128::from(body.half_width.max(0)));
    0 < along && along < length_squared && across * across < half * half * length_squared
}

/// The exact body, shrunk to whole units: what no region may overlap.
fn inner_strip(body: &Body) -> Option<Polygon> {
    // Three units below the width asked for the drawn-out strip lies inside the exact body.
    let half = body.half_width - 3;
    let shrunk = Reach { left: half, right: half, before: -3, after: -3 };
    let long = body.from.distance_squared(body.to) > 100 * 100;
    (half > 10 && long)
        .then(|| strip(body.from, body.to, shrunk))
        .flatten()
        .map(|ring| Polygon::new(ring.into(), vec![]))
}

fn check_regions(block: &Block) -> Result<(), TestCaseError> {
    let land = buildable(block);
    for (i, region) in land.regions.iter().enumerate() {
        prop_assert_eq!(region.ordinal, i as u32);
        prop_assert!(region.polygon.is_simple());
        prop_assert!(region.polygon.doubled_area() >= LEAST_DOUBLED_AREA);
        prop_assert_eq!(region.frontage.len(), 1 + region.polygon.holes.len());
        for (ring, streets) in region.polygon.rings().zip(&region.frontage) {
            prop_assert_eq!(ring.len(), streets.len());
        }
        for (a, b) in region.polygon.edges() {
            prop_assert!(a.distance_squared(b) >= 256);
        }
        for body in &block.bodies {
            for p in region.polygon.rings().flatten() {
                prop_assert!(!in_body(body, *p), "corner {p:?} in {body:?}");
            }
            if let Some(strip) = inner_strip(body) {
                prop_assert!(boolean::intersection(std::slice::from_ref(&region.polygon), &[strip]).is_empty());
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn regions_keep_off_every_body(block in blocks()) {
        check_regions(&block)?;
        for region in &buildable(&block).regions {
            prop_assert!(region.frontage.iter().flatten().all(Option::is_some), "an edge on no street");
        }
    }

    #[test]
    fn nasty_blocks_make_clean_regions(block in nasty()) {
        let land = buildable(&block);
        prop_assert!(land.regions.iter().all(|region| region.polygon.is_simple()));
    }

    #[test]
    fn little_is_dropped(block in blocks()) {
        let land = buildable(&block);
        // Pieces under 1 m², and less than 16 LSB of each corner.
        let corners: usize = block.bodies.len() + land.regions.iter().map(|r| r.polygon.outer.len()).sum::<usize>();
        prop_assert!(land.dropped >= 0 && land.dropped < LEAST_DOUBLED_AREA * (1 + corners as i128), "{land:?}");
    }
}

#[test]
fn a_rectangle_loses_half_the_width_of_each_street() {
    let block = block(rectangle(100.0, 60.0), &[4.0, 8.0]);
    let land = buildable(&block);
    let [region] = &land.regions[..] else { panic!("one region") };
    let (half_x, half_y) = (8 * 1024 + 2, 4 * 1024 + 2);
    let (east, north) = (100 * 1024 - half_x, 60 * 1024 - half_y);
    let corner = Point::new;
    assert_eq!(
        region.polygon.outer,
        [corner(half_x, half_y), corner(east, half_y), corner(east, north), corner(half_x, north)]
    );
    assert_eq!(region.frontage, [[0, 1, 2, 3].map(|n| Some(street(n))).to_vec()]);
    assert_eq!(land.dropped, 0);
    let lengths: f64 = region.access().iter().map(|(_, length)| length).sum();
    assert_eq!((region.access().len(), lengths), (4, region.polygon.perimeter()));
}

#[test]
fn a_block_narrower_than_its_streets_leaves_nothing() {
    assert_eq!(buildable(&block(rectangle(100.0, 10.0), &[6.0])), Buildable::default());
    assert_eq!(buildable(&block(Polygon::default(), &[6.0])), Buildable::default());
}

#[test]
fn an_outward_corner_is_covered() {
    // An L: at its inner corner (40, 40) the two bodies leave a square open that the corner piece fills.
    let corners = ring(&[(0.0, 0.0), (80.0, 0.0), (80.0, 40.0), (40.0, 40.0), (40.0, 80.0), (0.0, 80.0)]);
    let land = buildable(&block(Polygon::new(corners, vec![]), &[5.0]));
    let off = 5 * 1024 + 2;
    let tip = Point::new(40 * 1024 - off, 40 * 1024 - off);
    assert!(land.regions[0].polygon.outer.contains(&tip), "{:?}", land.regions[0].polygon);
    assert_eq!(land.regions[0].polygon.outer.len(), 6);
}

#[test]
fn a_dead_end_is_kept_off_all_round() {
    let mut block = block(rectangle(100.0, 100.0), &[5.0]);
    block.bodies.push(antenna((50.0, 0.0), (50.0, 40.0), 3.0));
    let region = &buildable(&block).regions[0];
    let top = Point::new(53 * 1024 + 2, 43 * 1024 + 2);
    assert!(region.polygon.outer.contains(&top));
    assert_eq!(region.frontage[0].iter().filter(|s| **s == Some(street(1000))).count(), 3);
}

#[test]
fn a_free_standing_tree_makes_a_hole() {
    let mut block = block(rectangle(100.0, 100.0), &[5.0]);
    let mut free = antenna((40.0, 50.0), (60.0, 50.0), 3.0);
    free.before = Joint::Capped;
    block.bodies.push(free);
    let region = &buildable(&block).regions[0];
    assert_eq!((region.polygon.holes.len(), region.frontage.len()), (1, 2));
}
