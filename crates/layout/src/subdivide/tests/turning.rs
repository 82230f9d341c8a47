//! A region turned by a quarter is divided in the same way, turned: nothing depends on where north is.

use super::*;
use crate::samples::{quads, stars};

fn turned(p: Point) -> Point {
    Point::new(-p.y, p.x)
}

/// The region turned about the origin, its ring from its least corner on as [`buildable`] gives it.
fn turned_region(region: &Region) -> Region {
    let mut turned_region = region.clone();
    let ring = &mut turned_region.polygon.outer;
    ring.iter_mut().for_each(|p| *p = turned(*p));
    let least = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap_or(0);
    ring.rotate_left(least);
    turned_region.frontage[0].rotate_left(least);
    turned_region
}

/// Parcels turned, by id.
fn parcels_by_id(division: Division, turn: bool) -> Vec<Parcel> {
    let mut parcels = division.parcels;
    for parcel in parcels.iter_mut().filter(|_| turn) {
        let ring = &mut parcel.polygon.outer;
        ring.iter_mut().for_each(|p| *p = turned(*p));
        let least = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap_or(0);
        ring.rotate_left(least);
        parcel.sides.rotate_left(least);
    }
    parcels.sort_by_key(|parcel| parcel.id);
    parcels
}

fn check_turning(block: &Block, settings: &RecursiveSettings) -> Result<(), TestCaseError> {
    for region in buildable(block).regions.iter().filter(|region| region.polygon.holes.is_empty()) {
        let mut region = region.clone();
        let mut expected = parcels_by_id(recursive(&region, settings).unwrap(), false);
        for _ in 0..3 {
            region = turned_region(&region);
            expected = parcels_by_id(Division { parcels: expected, trimmed: 0 }, true);
            let found = parcels_by_id(recursive(&region, settings).unwrap(), false);
            prop_assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(&expected) {
                prop_assert_eq!(found, expected);
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_turned_block_has_its_parcels_turned(
        polygon in prop_oneof![quads(), stars()], widths in prop::collection::vec(2.0..14.0f64, 1..4),
        settings in settings(),
    ) {
        check_turning(&block(polygon, &widths), &settings)?;
    }

    #[test]
    fn so_has_an_upright_rectangle(width in 40..250i32, height in 40..250i32, settings in settings()) {
        check_turning(&block(rectangle(f64::from(width), f64::from(height)), &[6.0]), &settings)?;
        check_turning(&block(rectangle(f64::from(width), f64::from(width)), &[6.0]), &settings)?;
    }
}
