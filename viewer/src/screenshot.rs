//! Pictures without a window.

use crate::render::{Camera, Gpu, GpuError, Look, MapCamera, Overlay, Renderer, Target};
use crate::scene::{ColourBy, Scene};
use crate::shown::{Layers, shown};
use city::export::write_atomically;
use city::{Built, Cache, City};
use std::path::Path;

/// What a picture shows.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Its size in pixels.
    pub size: [u32; 2],
    /// Where one looks from; all of the city from above when none.
    pub camera: Option<Camera>,
    /// What is shown.
    pub layers: Layers,
    /// How.
    pub look: Look,
    /// What streets are coloured by.
    pub colour_by: ColourBy,
    /// A map laid over, with its opacity.
    pub overlay: Option<(String, f32)>,
}

impl Default for Picture {
    fn default() -> Self {
        let layers = Layers::default();
        Self { size: [1600, 1000], camera: None, layers, look: Look::default(), colour_by: None, overlay: None }
    }
}

/// Where to look at a scene from, to see all of it.
pub fn whole_map(scene: &Scene, size: [u32; 2]) -> Camera {
    Camera::Map(MapCamera::over(scene.extent, size.map(|side| side as f32)))
}

/// Writes a picture as a PNG file, whole or not at all.
///
/// # Errors
/// When it cannot be packed or written.
pub fn save(picture: &image::RgbaImage, path: &Path) -> Result<(), String> {
    let mut png = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut png, image::ImageFormat::Png).map_err(|error| error.to_string())?;
    write_atomically(path, |out| out.write_all(png.get_ref())).map_err(|error| error.to_string())
}

/// Draws a city.
///
/// # Errors
/// When the device cannot.
pub fn picture(gpu: &Gpu, built: &Built, wish: &Picture) -> Result<image::RgbaImage, GpuError> {
    let scene = Scene::of(gpu, &built.city, &Cache::none(), wish.colour_by, None);
    of_scene(gpu, &scene, &built.city, wish)
}

/// The same of a scene that was made before, whatever its streets are coloured by.
///
/// # Errors
/// When the device cannot.
pub fn of_scene(gpu: &Gpu, scene: &Scene, city: &City, wish: &Picture) -> Result<image::RgbaImage, GpuError> {
    let target = Target::new(gpu, wish.size)?;
    let map = wish.overlay.as_ref().and_then(|(name, opacity)| Some((city.site.map(name)?, *opacity)));
    let overlay = map.map(|(map, opacity)| Overlay::of(gpu, map, opacity));
    let camera = wish.camera.unwrap_or_else(|| whole_map(scene, wish.size));
    let mut renderer = Renderer::new(gpu.clone());
    renderer.draw(&target, &camera, &shown(scene, None, &camera, &wish.layers, overlay.as_ref(), wish.look));
    target.read(gpu)
}
