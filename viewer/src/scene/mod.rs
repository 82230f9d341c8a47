//! A city as chunks to draw: made on the worker's thread, tile by tile; what did not change keeps its chunk.

mod map;
mod model;
mod pick;

pub use map::{By, ColourBy, LayerKind, MapScene};
pub use model::ModelScene;
pub use pick::{Element, ElementKind, at, near_ray};

use crate::render::{Gpu, Ground};
use crate::sight::Sight;
use city::{Cache, City, Digests};
use geom::{Bounds, Id};
use std::sync::Arc;

/// Everything there is to draw of a city.
#[derive(Debug)]
pub struct Scene {
    /// The site.
    pub site: Bounds,
    /// What is built on: the streets' bounds, or the site's.
    pub extent: Bounds,
    /// On a map.
    pub map: MapScene,
    /// In space.
    pub model: ModelScene,
    /// Below the map.
    pub ground: Arc<Ground>,
    /// What the city was made from, stage by stage, as far as that is known.
    digests: Digests,
}

impl Scene {
    /// The scene of a city; chunks that are the same in `before` are taken from there.
    pub fn of(gpu: &Gpu, city: &City, cache: &Cache, colour_by: ColourBy, before: Option<&Self>) -> Self {
        Self::of_part(gpu, city, cache, colour_by, before, None)
    }

    /// The same of a city of which only what is in sight was made: elsewhere all stays as it was before.
    pub fn of_part(
        gpu: &Gpu,
        city: &City,
        cache: &Cache,
        colour_by: ColourBy,
        before: Option<&Self>,
        sight: Option<Sight>,
    ) -> Self {
        let model = city::export::glb::model(city, cache);
        let (map, model) = rayon::join(
            || MapScene::of_part(gpu, city, colour_by, before.map(|scene| (&scene.map, scene.digests)), sight),
            || ModelScene::of_part(gpu, &model, before.map(|scene| &scene.model), sight),
        );
        let kept = before.filter(|scene| are_same(scene.digests.site, city.digests.site));
        Self {
            site: city.site.bounds,
            extent: city.graph.bounds().unwrap_or(city.site.bounds),
            map,
            model,
            ground: kept.map_or_else(|| Arc::new(map::ground(gpu, city)), |scene| scene.ground.clone()),
            digests: city.digests,
        }
    }
}

/// Whether two things are known to be made from the same.
fn are_same(before: Option<Id>, now: Option<Id>) -> bool {
    before.is_some() && before == now
}
