//! What `plat-view` takes on its command line.

use crate::render::{Camera, Gpu, Look, MapCamera, OrbitCamera};
use crate::scene::By;
use crate::screenshot::{Picture, picture, save};
use city::{Cache, Cancel, Settings, Silent, build_with, load};
use clap::Parser;
use geom::Vec2;
use std::fmt;
use std::path::{Path, PathBuf};

/// Opens a city in a window: presets and parameters to turn, and rules that are live.
#[derive(Parser, Debug)]
#[command(name = "plat-view", version)]
pub struct Arguments {
    /// The city: a folder with a city.rhai, or the script itself; a choice of cities when none.
    pub city: Option<PathBuf>,
    /// Looks rules up here after the city's own folder and before the library.
    #[arg(long, value_name = "DIR")]
    pub rules: Option<PathBuf>,
    /// Draws a picture without a window, and ends.
    #[arg(long, requires_all = ["city", "out"])]
    pub screenshot: bool,
    /// The picture's file.
    #[arg(short, long, value_name = "PNG", requires = "screenshot")]
    pub out: Option<PathBuf>,
    /// Its size in pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1600x1000", value_parser = size)]
    pub size: [u32; 2],
    /// Draws the model in space rather than the map.
    #[arg(long, requires = "screenshot")]
    pub model: bool,
    /// Where to look from: EAST,NORTH,METRES_PER_PIXEL on a map; with --model EAST,NORTH,DISTANCE,HEADING,PITCH.
    #[arg(long, value_name = "NUMBERS", value_delimiter = ',', allow_negative_numbers = true, requires = "screenshot")]
    pub camera: Vec<f64>,
    /// Colours the streets of the map.
    #[arg(long, value_enum, value_name = "WHAT", alias = "color-by", requires = "screenshot")]
    pub colour_by: Option<By>,
    /// Lays a map of the site over the picture, with an opacity: density or density=0.5.
    #[arg(long, value_name = "MAP[=OPACITY]", requires = "screenshot")]
    pub overlay: Option<String>,
    /// Draws no shadows.
    #[arg(long, requires = "screenshot")]
    pub no_shadows: bool,
    /// Draws no silhouettes.
    #[arg(long, requires = "screenshot")]
    pub no_silhouettes: bool,
}

/// Why the program ends, and with which status: those of `plat`.
#[derive(Debug)]
pub struct Failure {
    /// 2 for bad usage, 3 where input or output failed.
    pub status: u8,
    /// What to tell.
    pub message: String,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

fn usage(message: impl Into<String>) -> Failure {
    Failure { status: 2, message: message.into() }
}

fn failed(error: &dyn fmt::Display) -> Failure {
    Failure { status: 3, message: error.to_string() }
}

/// Most pixels of a picture.
const MOST_PIXELS: u64 = 64_000_000;

fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once(['x', '×']).and_then(|(w, h)| Some([w.trim().parse().ok()?, h.trim().parse().ok()?]));
    let fits = |sides: &[u32; 2]| sides.iter().all(|side| (1..=16_384).contains(side));
    // Several layers with several samples each: more takes all memory there is.
    let is_paid = |[width, height]: &[u32; 2]| u64::from(*width) * u64::from(*height) <= MOST_PIXELS;
    sides.filter(fits).filter(is_paid).ok_or_else(|| {
        format!("`{text}` is no size: write 1600x1000, at most 16384 each way and 64 million pixels in all")
    })
}

/// Does what the command line asks for.
///
/// # Errors
/// See [`Failure`].
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    match (&arguments.city, &arguments.out) {
        (Some(city), Some(out)) if arguments.screenshot => screenshot(arguments, city, out),
        _ => crate::app::open(arguments).map_err(|error| failed(&error)),
    }
}

fn screenshot(arguments: &Arguments, city: &Path, out: &Path) -> Result<(), Failure> {
    if out.extension().is_none_or(|ending| !ending.eq_ignore_ascii_case("png")) {
        return Err(usage(format!("--out: {} is no name of a PNG file\n  hint: end it in .png", out.display())));
    }
    // Found out before the city is built.
    if let Some(folder) = out.parent().filter(|folder| !folder.as_os_str().is_empty() && !folder.is_dir()) {
        return Err(failed(&format!("--out: there is no folder {}", folder.display())));
    }
    let camera = camera_of(arguments)?;
    let overlay = arguments.overlay.as_deref().map(overlay_of).transpose()?;
    let gpu = Gpu::headless().map_err(|error| failed(&error))?;
    let loaded = load(city, arguments.rules.as_deref()).map_err(|error| failed(&error))?;
    let sources = loaded.read().map_err(|error| failed(&error))?;
    if let Some((name, _)) = &overlay
        && sources.site.map(name).is_none()
    {
        let known: Vec<&str> = sources.site.maps.keys().map(String::as_str).collect();
        let hint = if known.is_empty() { "it has none".into() } else { format!("it has {}", known.join(", ")) };
        return Err(usage(format!("--overlay: the site has no map `{name}`\n  hint: {hint}")));
    }
    if let Some(map) = arguments.colour_by.and_then(By::map)
        && sources.site.map(map).is_none()
    {
        return Err(usage(format!("--colour-by: the site has no map `{map}`\n  hint: class and rule need none")));
    }
    let built = build_with(&sources, Settings::default(), &Cache::none(), &Silent, &Cancel::default());
    let built = built.map_err(|error| failed(&error))?;
    let camera = camera.or_else(|| {
        let bounds = built.city.graph.bounds().unwrap_or(built.city.site.bounds);
        let middle = (bounds.min.metres() + bounds.max.metres()) / 2.0;
        arguments.model.then(|| Camera::Orbit(OrbitCamera::over(bounds, built.city.site.elevation(middle))))
    });
    let camera = camera.map(|camera| on_ground(camera, &built.city));
    let silhouettes = if arguments.no_silhouettes { 0.0 } else { Look::default().silhouettes };
    let look = Look { shadows: !arguments.no_shadows, silhouettes, ..Look::default() };
    let wish =
        Picture { size: arguments.size, camera, look, colour_by: arguments.colour_by, overlay, ..Picture::default() };
    let drawn = picture(&gpu, &built, &wish).map_err(|error| failed(&error))?;
    save(&drawn, out).map_err(|error| failed(&error))
}

/// A camera whose target stands on the ground of a city.
fn on_ground(camera: Camera, city: &city::City) -> Camera {
    match camera {
        Camera::Orbit(orbit) => {
            let place = orbit.target.truncate();
            Camera::Orbit(OrbitCamera { target: place.extend(city.site.elevation(place)), ..orbit })
        }
        map @ Camera::Map(_) => map,
    }
}

fn camera_of(arguments: &Arguments) -> Result<Option<Camera>, Failure> {
    let numbers = arguments.camera.as_slice();
    if numbers.iter().any(|number| !number.is_finite()) {
        return Err(usage("--camera: numbers must be finite"));
    }
    match (numbers, arguments.model) {
        ([], _) => Ok(None),
        (&[x, y, scale], false) if scale > 0.0 => Ok(Some(Camera::Map(MapCamera { centre: Vec2::new(x, y), scale }))),
        (&[x, y, distance, heading, pitch], true) if distance > 0.0 => {
            let target = Vec2::new(x, y).extend(0.0);
            Ok(Some(Camera::Orbit(OrbitCamera { target, distance, heading, pitch: pitch.clamp(2.0, 89.5) })))
        }
        (_, false) => Err(usage("--camera: write EAST,NORTH,METRES_PER_PIXEL, such as 4000,9000,1.5")),
        (_, true) => Err(usage("--camera: write EAST,NORTH,DISTANCE,HEADING,PITCH, such as 4000,9000,1200,30,35")),
    }
}

fn overlay_of(text: &str) -> Result<(String, f32), Failure> {
    let (name, opacity) = text.split_once('=').unwrap_or((text, "0.6"));
    let opacity = opacity.parse::<f32>().ok().filter(|share| (0.0..=1.0).contains(share));
    let wrong = || usage(format!("--overlay: `{text}` tells no opacity from 0 to 1, as in density=0.5"));
    Ok((name.to_owned(), opacity.ok_or_else(wrong)?))
}
