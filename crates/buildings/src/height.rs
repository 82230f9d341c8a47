//! How high one builds where many people live.

/// Height of a floor in metres, floor to floor.
const FLOOR: f64 = 3.2;

/// Parapet and roof build-up in metres.
const ROOF: f64 = 0.8;

/// Floor space in m² that one inhabitant asks of a parcel: home, work and services, with the half of the land that is
/// streets, parks and water carried by the other half.
const SPACE_PER_PERSON: f64 = 100.0;

/// Share of a parcel that its building covers.
const COVERAGE: f64 = 0.45;

/// Most that a building may exceed the side of a square of its parcel's area: slender towers are few.
const SLENDERNESS: f64 = 6.0;

/// A height in metres for a building on a parcel of `area` m² where `density` people live on a km².
///
/// Floors are what holds the people: density × space per person ÷ coverage, which gives 6.7 at Manhattan's 30,000
/// people per km², times a factor drawn by `chance` in [0, 1) from a Pareto tail, 0.85 · (1 − chance)^−0.3. So half
/// of the buildings there have 7 floors or fewer, nine tenths 11 or fewer, one in a hundred 23 or more, and one in a
/// thousand 45. No building is higher than six times the side of a square of its parcel's area. One floor at least;
/// input that is not a number counts as none.
pub fn height_from_density(density: f64, area: f64, chance: f64) -> f64 {
    let [density, area] = [density, area].map(|value| if value.is_finite() { value.max(0.0) } else { 0.0 });
    let chance = if chance.is_finite() { chance.clamp(0.0, 0.999_9) } else { 0.0 };
    let mean_floors = density / 1e6 * SPACE_PER_PERSON / COVERAGE;
    let floors = mean_floors * 0.85 * libm::pow(1.0 - chance, -0.3);
    let most_floors = (SLENDERNESS * area.sqrt() - ROOF) / FLOOR;
    floors.round().min(most_floors.floor()).max(1.0) * FLOOR + ROOF
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn floors(density: f64, area: f64, chance: f64) -> f64 {
        ((height_from_density(density, area, chance) - ROOF) / FLOOR).round()
    }

    #[test]
    fn manhattan_is_as_documented() {
        assert_eq!([0.5, 0.9, 0.99, 0.999].map(|chance| floors(30_000.0, 5000.0, chance)), [7.0, 11.0, 23.0, 45.0]);
    }

    #[test]
    fn thin_people_live_low_and_small_parcels_carry_no_towers() {
        assert_eq!(floors(1_000.0, 800.0, 0.9), 1.0);
        assert!(height_from_density(100_000.0, 100.0, 0.999) <= 60.0);
        assert_eq!(height_from_density(f64::NAN, f64::INFINITY, f64::NAN), FLOOR + ROOF);
    }

    proptest! {
        #[test]
        fn heights_are_sound_and_grow_with_density(
            density in 0.0..200_000.0f64, more in 0.0..50_000.0f64, area in 0.0..1e5f64, chance in 0.0..1.0f64,
        ) {
            let height = height_from_density(density, area, chance);
            prop_assert!(height.is_finite() && (4.0..2000.0).contains(&height));
            prop_assert!(height_from_density(density + more, area, chance) >= height);
        }
    }
}
