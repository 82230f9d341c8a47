//! What of a scene is shown.

use crate::render::{Camera, Kind, Look, Overlay, Shown};
use crate::scene::{LayerKind, MapScene, Scene};
use city::export::glb::Group;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// What is switched on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Layers {
    /// Of the map.
    pub map: BTreeSet<LayerKind>,
    /// Whether land with its hills is shown below the map; without it neither water nor parks are.
    pub ground: bool,
    /// Whether water is told from land there.
    #[serde(default = "yes")]
    pub water: bool,
    /// Whether the site's parks are shown there.
    #[serde(default = "yes")]
    pub parks: bool,
    /// Classes of streets that are not shown, by name.
    #[serde(default)]
    pub classes_off: BTreeSet<String>,
    /// Whether places that rules marked, or where they went wrong, are shown on the map.
    #[serde(default = "yes")]
    pub marks: bool,
    /// Of the model: terrain, streets, parks, buildings.
    pub model: [bool; 4],
}

fn yes() -> bool {
    true
}

/// The parts of a model with what people call them, in the order of [`Layers::model`].
pub const MODEL_PARTS: [(Group, &str); 4] = [
    (Group::Terrain, "Terrain"),
    (Group::Streets, "Streets in 3D"),
    (Group::Green, "Parks in 3D"),
    (Group::Buildings, "Buildings in 3D"),
];

impl Default for Layers {
    fn default() -> Self {
        use LayerKind::{Blocks, Buildings, Green, Landmarks, Parcels, Streets};
        let map = [Blocks, Green, Parcels, Buildings, Streets, Landmarks].into();
        let (ground, water, parks) = (true, true, true);
        Self { map, ground, water, parks, classes_off: BTreeSet::new(), marks: true, model: [true; 4] }
    }
}

/// Metres to the pixel from which borders of parcels would only be grey.
const NO_PARCELS: f64 = 3.0;

/// What there is to draw of a scene, seen by a camera; on the map another one, where one is given.
pub fn shown<'a>(
    scene: &'a Scene,
    map_now: Option<&'a MapScene>,
    camera: &Camera,
    layers: &Layers,
    overlay: Option<&'a Overlay>,
    look: Look,
) -> Shown<'a> {
    let chunks = match camera {
        Camera::Map(map) => {
            let is_shown = |layer, class: Option<&str>| {
                let is_fine = layer != LayerKind::Parcels || map.scale < NO_PARCELS;
                layers.map.contains(&layer) && is_fine && class.is_none_or(|class| !layers.classes_off.contains(class))
            };
            map_now.unwrap_or(&scene.map).chunks(is_shown).map(|(chunk, kind)| (&**chunk, kind)).collect()
        }
        Camera::Orbit(_) => {
            let parts = MODEL_PARTS.iter().zip(layers.model).filter(|(_, is_on)| *is_on);
            let chunks = scene.model().into_iter().flat_map(|model| {
                let groups = parts.clone();
                groups.flat_map(|((group, _), _)| model.chunks(*group))
            });
            chunks.map(|chunk| (&**chunk, Kind::Solid)).collect()
        }
    };
    let is_map = matches!(camera, Camera::Map(_));
    Shown {
        site: scene.site,
        chunks,
        overlay,
        ground: (is_map && layers.ground).then_some((&*scene.ground, [layers.water, layers.parks])),
        look,
        background: if is_map { [0xe4, 0xe2, 0xdc] } else { [0xc9, 0xd8, 0xe4] },
    }
}
