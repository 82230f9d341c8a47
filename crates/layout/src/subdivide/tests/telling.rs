//! The steps that a division tells lead to what it gives.

use super::*;

/// What the steps leave of the pieces, and which of them they leave open.
fn replayed(steps: &[DivisionStep], settings: &RecursiveSettings) -> Result<[BTreeSet<geom::Id>; 2], TestCaseError> {
    let looked_at = |step: &DivisionStep| match step {
        DivisionStep::Look { piece, .. } => Some(*piece),
        _ => None,
    };
    let (mut pieces, mut open) = (steps.iter().filter_map(looked_at).collect::<BTreeSet<_>>(), BTreeSet::new());
    for step in steps {
        match *step {
            DivisionStep::Look { piece, area, outcome: Looked::Cut { ends: [from, to], parts }, .. } => {
                prop_assert!(pieces.remove(&piece) && from != to && area >= settings.least_area);
                prop_assert!(parts.iter().all(|part| pieces.contains(part)), "both parts are looked at");
            }
            DivisionStep::Look { area, wanted, outcome, .. } => {
                let is_as_wanted = area <= wanted && settings.least_convexity <= 0.0;
                prop_assert!(!is_as_wanted || outcome == Looked::Kept);
                prop_assert!(area <= wanted || outcome == Looked::NoCut);
            }
            DivisionStep::Join { piece, to, .. } => prop_assert!(pieces.remove(&piece) && pieces.contains(&to)),
            DivisionStep::Open { piece, .. } => prop_assert!(open.insert(piece)),
        }
    }
    Ok([pieces, open])
}

proptest! {
    #[test]
    fn steps_lead_to_the_parcels(block in blocks(), settings in settings()) {
        for region in &buildable(&block).regions {
            let mut steps = Vec::new();
            let division = recursive_telling(region, &settings, &mut |step| steps.push(step)).unwrap();
            prop_assert_eq!(&division, &recursive(region, &settings).unwrap());
            let ids = |usage: &[Use]| {
                division.parcels.iter().filter(|parcel| usage.contains(&parcel.usage)).map(|parcel| parcel.id).collect()
            };
            prop_assert_eq!(replayed(&steps, &settings)?, [ids(&[Use::Built, Use::Open]), ids(&[Use::Open])]);
        }
    }
}
