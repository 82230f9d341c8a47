//! Maps of a city while it grew (PM01 figure 9).

use super::map::{self, MapError};
use super::{MapOptions, with_credits};
use crate::{Cache, City, Trace};
use std::sync::Arc;
use streets::runs::runs;

/// The name of a step's map without its ending.
pub fn step_name(step: u32) -> String {
    format!("map-step-{step}")
}

/// The map of a city after a derivation step, as files with their content: `map-step-28.svg` and `.png`. All steps show
/// the same ground, that of the finished city.
///
/// # Errors
/// See [`MapError`].
pub fn step_maps(
    city: &City,
    trace: &Trace,
    step: u32,
    options: &MapOptions,
) -> Result<Vec<(String, Vec<u8>)>, MapError> {
    let then = city_after(city, trace, step);
    let title = format!("{}, after {step} step{}", map::title(city, options), if step == 1 { "" } else { "s" });
    let extent = options.extent.or(city.graph.bounds());
    let options = with_credits(city, &MapOptions { title: Some(title), extent, ..options.clone() });
    let mut svg = Vec::new();
    // Writing to memory does not fail.
    let _ = map::write_svg(&then, &options, &Cache::none(), &mut svg);
    let png = map::png(&then, &options, &Cache::none())?;
    Ok(vec![(step_name(step) + ".svg", svg), (step_name(step) + ".png", png)])
}

/// The streets of a city after a step; nothing stands beside them yet.
pub fn city_after(city: &City, trace: &Trace, step: u32) -> City {
    let graph = trace.after(step);
    City {
        name: city.name.clone(),
        seed: city.seed,
        credits: city.credits.clone(),
        site: city.site.clone(),
        runs: runs(&graph),
        graph: graph.into(),
        origins: city.origins.clone(),
        street_names: city.street_names.clone(),
        quarters: Vec::new(),
        districts: city.districts.clone(),
        landmarks: city.landmarks.clone(),
        blocks: Arc::default(),
        parcels: Arc::default(),
        buildings: Arc::default(),
        digests: crate::Digests::default(),
    }
}
