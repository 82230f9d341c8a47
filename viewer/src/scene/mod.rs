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
use std::sync::{Arc, OnceLock};

/// Everything there is to draw of a city.
#[derive(Debug)]
pub struct Scene {
    /// The site.
    pub site: Bounds,
    /// What is built on: the streets' bounds, or the site's.
    pub extent: Bounds,
    /// On a map.
    pub map: MapScene,
    /// In space; made after the map where there is nothing to see yet.
    model: OnceLock<ModelScene>,
    /// Below the map.
    pub ground: Arc<Ground>,
    /// What the city was made from, stage by stage, as far as that is known.
    digests: Digests,
}

impl Scene {
    /// The map of a city that nothing was shown of yet: the model takes longer, and can be added.
    pub fn of_map(gpu: &Gpu, city: &City, colour_by: ColourBy) -> Self {
        let (map, ground) =
            rayon::join(|| MapScene::of(gpu, city, colour_by, None), || Arc::new(map::ground(gpu, city)));
        Self::with(city, map, OnceLock::new(), ground)
    }

    /// Adds the model of the city; one that is there stays.
    pub fn add_model(&self, gpu: &Gpu, city: &City, cache: &Cache) {
        self.model.get_or_init(|| ModelScene::of(gpu, &city::export::glb::model(city, cache), None));
    }

    /// The city in space, once it was made.
    pub fn model(&self) -> Option<&ModelScene> {
        self.model.get()
    }

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
            || ModelScene::of_part(gpu, &model, before.and_then(Self::model), sight),
        );
        let kept = before.filter(|scene| are_same(scene.digests.site, city.digests.site));
        let ground = kept.map_or_else(|| Arc::new(map::ground(gpu, city)), |scene| scene.ground.clone());
        Self::with(city, map, model.into(), ground)
    }

    fn with(city: &City, map: MapScene, model: OnceLock<ModelScene>, ground: Arc<Ground>) -> Self {
        let extent = city.graph.bounds().unwrap_or(city.site.bounds);
        Self { site: city.site.bounds, extent, map, model, ground, digests: city.digests }
    }
}

/// Whether two things are known to be made from the same.
fn are_same(before: Option<Id>, now: Option<Id>) -> bool {
    before.is_some() && before == now
}
