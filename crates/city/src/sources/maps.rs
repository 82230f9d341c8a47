//! Maps folders: grayscale PNG pictures with JSON sidecars, read into a [`Site`].

use super::district_map::DistrictMap;
use super::error::{SourceError, read_bytes};
use super::sidecar::{CrsBounds, Placement, Sidecar, check_lattice};
use super::suggest;
use crate::{Cache, Site};
use geom::{Bounds, Digest, Point, Raster, Vec2};
use image::{ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageError, RgbaImage, codecs::png::PngDecoder};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufReader, Cursor};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Maps that a site knows what to do with; one that is missing means flat, all land, none, constant.
/// A map `districts` is known too, but a picture of colours: see [`DistrictMap`].
pub const KNOWN_MAPS: [&str; 6] = ["elevation", "land", "parks", "density", "zones", "max_height"];

/// Largest width and height of a map, in pixels.
pub const MAX_MAP_SIDE: u32 = 16384;

/// What to take a PNG for that has no sidecar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapOptions {
    /// Width and height in metres.
    pub size_m: [f64; 2],
    /// Value of one grey step.
    pub scale: f64,
    /// Value of black.
    pub offset: f64,
    /// Whether to read 0 or 1 instead: 1 above the middle grey.
    pub mask: bool,
}

/// Reads the maps of a folder: those of [`KNOWN_MAPS`] that are there, and those of `names`, which must be there unless
/// known. `options` say, by map name, what to take a picture without a sidecar for. No other picture is opened. All maps
/// must cover the same rectangle.
///
/// # Errors
/// [`SourceError`] for a missing folder or map, and for files that are no maps or do not fit together.
pub fn load_site(folder: &Path, names: &[&str], options: &BTreeMap<String, MapOptions>) -> Result<Site, SourceError> {
    load_site_with(folder, names, options, None, &Cache::none())
}

/// [`load_site`] with districts from one more map of the folder, a picture of colours. Maps whose files say the same as
/// before are taken from a cache.
///
/// # Errors
/// See [`load_site`].
pub fn load_site_with(
    folder: &Path,
    names: &[&str],
    options: &BTreeMap<String, MapOptions>,
    districts: Option<&DistrictMap>,
    cache: &Cache,
) -> Result<Site, SourceError> {
    let present = map_names(folder)?;
    let mut extents: Vec<(PathBuf, Extent)> = Vec::new();
    let mut maps = BTreeMap::new();
    let mut named_areas = Arc::default();
    if let Some(wanted) = districts {
        if !present.contains(&wanted.map) {
            return Err(missing(folder, &wanted.map, &present));
        }
        let path = folder.join(format!("{}.png", wanted.map));
        let (sidecar, blamed) = sidecar_at(&path, options.get(&wanted.map))?;
        let (found, placement) = wanted.read(&path, &sidecar, &blamed)?;
        named_areas = Arc::new(found);
        extents.push((path, Extent { size: placement.size, crs: sidecar.crs, in_crs: sidecar.bounds_crs_m }));
    }
    let is_colour = |name: &str| districts.is_some_and(|districts| districts.map == name);
    for name in wanted(names).into_iter().filter(|name| !is_colour(name)) {
        if !present.iter().any(|other| other == name) {
            missing_is_fine(folder, name, &present)?;
            continue;
        }
        let path = folder.join(format!("{name}.png"));
        let (raster, extent) = load(&path, options.get(name), cache)?;
        for (other_path, other) in &extents {
            check_same_extent(other_path, other, &path, &extent)?;
        }
        maps.insert(name.to_owned(), raster);
        extents.push((path, extent));
    }
    let Some((_, first)) = extents.first() else {
        let hint = format!("known maps are {}", KNOWN_MAPS.join(", "));
        return Err(SourceError::kind(folder, "there is no map in this folder that the city uses", hint));
    };
    Ok(Site {
        bounds: rectangle(first.size),
        crs: extents.iter().find_map(|(_, extent)| extent.crs.clone()),
        origin: extents.iter().find_map(|(_, extent)| extent.in_crs).map(|bounds| bounds.min()),
        maps,
        districts: named_areas,
    })
}

/// Reads one map from a PNG file and its sidecar.
///
/// # Errors
/// [`SourceError`] when either file is missing or wrong.
pub fn load_map(path: &Path, options: Option<&MapOptions>) -> Result<Raster, SourceError> {
    load(path, options, &Cache::none()).map(|(raster, _)| Arc::unwrap_or_clone(raster))
}

/// The names of all maps of a folder, sorted: the PNG files in it without their ending.
///
/// # Errors
/// [`SourceError::Unreadable`] when the folder is missing or not a folder.
pub fn map_names(folder: &Path) -> Result<Vec<String>, SourceError> {
    let unreadable = |cause| SourceError::unreadable(folder, cause);
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        if path.extension().is_some_and(|ending| ending == "png")
            && let Some(stem) = path.file_stem().and_then(|stem| stem.to_str())
        {
            names.push(stem.to_owned());
        }
    }
    names.sort();
    Ok(names)
}

/// Width and height in metres of a map, by its sidecar; `None` when it has none, or either file is wrong (which
/// [`load_site`] says).
pub fn map_size(path: &Path) -> Option<Vec2> {
    let sidecar_path = path.with_extension("json");
    let sidecar = Sidecar::read(&sidecar_path).ok()??;
    let (width, height) = PngDecoder::new(BufReader::new(File::open(path).ok()?)).ok()?.dimensions();
    Some(sidecar.placement(&sidecar_path, width, height).ok()?.size)
}

/// Whether a picture is there and its sidecar has a legend: then it shows districts.
pub(crate) fn has_legend(path: &Path) -> bool {
    let sidecar = || Sidecar::read(&path.with_extension("json")).ok()?;
    path.is_file() && sidecar().is_some_and(|sidecar| sidecar.legend.is_some())
}

/// A site without maps: flat land of `size` metres.
///
/// # Errors
/// [`SourceError::Value`] when the size is not positive, not finite or beyond the lattice.
pub fn flat_site(size: Vec2) -> Result<Site, SourceError> {
    check_lattice(Path::new("site"), size)?;
    Ok(Site { bounds: rectangle(size), crs: None, origin: None, maps: BTreeMap::new(), districts: Arc::default() })
}

/// The rectangle a map covers.
struct Extent {
    size: Vec2,
    crs: Option<String>,
    in_crs: Option<CrsBounds>,
}

impl Extent {
    fn text(&self) -> String {
        let size = format!("{} × {} m", self.size.x, self.size.y);
        match (self.in_crs, &self.crs) {
            (Some(b), crs) => {
                let crs = crs.as_deref().unwrap_or("an unnamed crs");
                format!("{size} at ({}, {}) to ({}, {}) in {crs}", b.minx, b.miny, b.maxx, b.maxy)
            }
            (None, Some(crs)) => format!("{size} in {crs}"),
            (None, None) => size,
        }
    }
}

fn wanted<'a>(names: &[&'a str]) -> BTreeSet<&'a str> {
    names.iter().copied().chain(KNOWN_MAPS).collect()
}

fn missing_is_fine(folder: &Path, name: &str, present: &[String]) -> Result<(), SourceError> {
    if KNOWN_MAPS.contains(&name) {
        return Ok(());
    }
    Err(missing(folder, name, present))
}

fn missing(folder: &Path, name: &str, present: &[String]) -> SourceError {
    let hint = suggest::hint_for(name, present);
    SourceError::MissingMap { path: folder.to_owned(), name: name.to_owned(), hint }
}

fn rectangle(size: Vec2) -> Bounds {
    Bounds::between(Point::new(0, 0), Point::from_metres(size))
}

/// Compares on the lattice, where the site's own bounds lie: exact.
fn check_same_extent(a_path: &Path, a: &Extent, b_path: &Path, b: &Extent) -> Result<(), SourceError> {
    let same_size = Point::from_metres(a.size) == Point::from_metres(b.size);
    let same_crs = a.crs.is_none() || b.crs.is_none() || a.crs == b.crs;
    let same_place = match (a.in_crs, b.in_crs) {
        (Some(a), Some(b)) => a.min() == b.min(),
        _ => true,
    };
    if same_size && same_crs && same_place {
        return Ok(());
    }
    Err(SourceError::BoundsDiffer {
        path: a_path.to_owned(),
        first_bounds: a.text(),
        second: b_path.to_owned(),
        second_bounds: b.text(),
    })
}

fn load(path: &Path, options: Option<&MapOptions>, cache: &Cache) -> Result<(Arc<Raster>, Extent), SourceError> {
    let (sidecar, blamed) = sidecar_at(path, options)?;
    sidecar.check_value(&blamed)?;
    let bytes = read_bytes(path)?;
    let key = Digest::new("map").bytes(&bytes).value(&sidecar).finish();
    let kept = match cache.get::<(Arc<Raster>, Vec2)>(key) {
        Some(kept) => kept,
        None => {
            let picture = Picture::decode(path, bytes)?;
            let placement = sidecar.placement(&blamed, picture.width, picture.height)?;
            let read = Arc::new((Arc::new(picture.raster(path, &sidecar, &placement)?), placement.size));
            cache.keep(key, &read);
            read
        }
    };
    let (raster, size) = &*kept;
    Ok((raster.clone(), Extent { size: *size, crs: sidecar.crs, in_crs: sidecar.bounds_crs_m }))
}

/// What is said about a picture, and which file says it.
fn sidecar_at(path: &Path, options: Option<&MapOptions>) -> Result<(Sidecar, PathBuf), SourceError> {
    let sidecar_path = path.with_extension("json");
    match (Sidecar::read(&sidecar_path)?, options) {
        (Some(sidecar), _) => Ok((sidecar, sidecar_path)),
        (None, Some(options)) => Ok((sidecar_of(options), path.to_owned())),
        (None, None) => Err(no_sidecar(path, &sidecar_path)),
    }
}

fn sidecar_of(options: &MapOptions) -> Sidecar {
    let mut sidecar = Sidecar { size_m: Some(options.size_m), ..Sidecar::default() };
    sidecar.value.scale = options.scale;
    sidecar.value.offset = options.offset;
    if options.mask {
        sidecar.value.units = "mask".to_owned();
    }
    sidecar
}

pub(super) fn no_sidecar(path: &Path, sidecar: &Path) -> SourceError {
    let message = format!("has no sidecar {}, so its size is unknown", sidecar.display());
    let hint = "write one, e.g. {\"pixel_size_m\": 10, \"value\": {\"scale\": 1, \"offset\": 0, \"units\": \"m\"}}, \
                or give the size where the map is named";
    SourceError::picture(path, message, hint)
}

/// A decoded picture: 8 or 16 bits a pixel.
pub(super) struct Picture {
    pub width: u32,
    pub height: u32,
    pixels: DynamicImage,
}

/// The decoder of a PNG file of bearable size.
fn decoder(path: &Path, bytes: Vec<u8>) -> Result<PngDecoder<Cursor<Vec<u8>>>, SourceError> {
    let decoder = PngDecoder::new(Cursor::new(bytes)).map_err(|e| undecodable(path, &e))?;
    let (width, height) = decoder.dimensions();
    if width > MAX_MAP_SIDE || height > MAX_MAP_SIDE {
        let message = format!("{width} × {height} pixels are more than {MAX_MAP_SIDE} × {MAX_MAP_SIDE}");
        return Err(SourceError::picture(path, message, "scale the map down, or cut it into sites"));
    }
    Ok(decoder)
}

/// The colours of a picture.
pub(super) fn open_colours(path: &Path) -> Result<RgbaImage, SourceError> {
    let decoder = decoder(path, read_bytes(path)?)?;
    DynamicImage::from_decoder(decoder).map(|picture| picture.into_rgba8()).map_err(|e| undecodable(path, &e))
}

impl Picture {
    pub fn open(path: &Path) -> Result<Self, SourceError> {
        Self::decode(path, read_bytes(path)?)
    }

    /// The picture in a file with these bytes.
    fn decode(path: &Path, bytes: Vec<u8>) -> Result<Self, SourceError> {
        let decoder = decoder(path, bytes)?;
        let (width, height) = decoder.dimensions();
        check_grayscale(path, decoder.color_type(), decoder.original_color_type())?;
        let pixels = DynamicImage::from_decoder(decoder).map_err(|e| undecodable(path, &e))?;
        Ok(Self { width, height, pixels })
    }

    fn raster(self, path: &Path, sidecar: &Sidecar, placement: &Placement) -> Result<Raster, SourceError> {
        let (scale, offset, mask) = (sidecar.value.scale, sidecar.value.offset, sidecar.is_mask());
        let value = |pixel: u16, half: u16| match mask {
            true => f32::from(u8::from(pixel > half)),
            false => (f64::from(pixel) * scale + offset) as f32,
        };
        let values: Vec<f32> = match &self.pixels {
            DynamicImage::ImageLuma16(picture) => picture.iter().map(|&p| value(p, u16::MAX / 2)).collect(),
            DynamicImage::ImageLuma8(picture) => {
                picture.iter().map(|&p| value(u16::from(p), u16::from(u8::MAX / 2))).collect()
            }
            _ => unreachable!("checked to be grayscale when opened"),
        };
        Raster::new(self.width as usize, self.height as usize, placement.pixel_size, Vec2::ZERO, values)
            .map_err(|e| SourceError::picture(path, e.to_string(), "correct scale and offset in the sidecar"))
    }
}

impl Picture {
    /// The grey steps, row by row from the north.
    pub fn greys(&self) -> Vec<u16> {
        match &self.pixels {
            DynamicImage::ImageLuma16(picture) => picture.iter().copied().collect(),
            other => other.to_luma8().iter().map(|&grey| u16::from(grey)).collect(),
        }
    }
}

fn check_grayscale(path: &Path, decoded: ColorType, original: ExtendedColorType) -> Result<(), SourceError> {
    if matches!(decoded, ColorType::L8 | ColorType::L16) {
        return Ok(());
    }
    let what = match decoded {
        ColorType::La8 | ColorType::La16 => "grayscale with transparency".to_owned(),
        _ => format!("a colour picture ({original:?})"),
    };
    let hint = "save it as 8 or 16 bit grayscale without transparency, e.g. `magick in.png -alpha off -colorspace Gray \
                -depth 16 out.png`";
    Err(SourceError::picture(path, format!("is {what}, but maps are grayscale"), hint))
}

fn undecodable(path: &Path, error: &ImageError) -> SourceError {
    let hint = "save the picture again as an 8 or 16 bit grayscale PNG: it is cut off, damaged or of another kind";
    SourceError::picture(path, format!("is not a readable PNG: {error}"), hint)
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, ImageBuffer, Luma};
    use proptest::prelude::*;
    use std::fs;
    use tempfile::TempDir;

    const PLAIN: &str = r#"{"pixel_size_m": 10}"#;

    /// A folder with one map `m` of 8 bits, row by row from the north.
    fn folder8(width: u32, pixels: &[u8], sidecar: &str) -> TempDir {
        let folder = TempDir::new().unwrap();
        put8(&folder, "m", width, pixels, sidecar);
        folder
    }

    fn put8(folder: &TempDir, name: &str, width: u32, pixels: &[u8], sidecar: &str) {
        let height = pixels.len() as u32 / width;
        GrayImage::from_raw(width, height, pixels.to_vec())
            .unwrap()
            .save(folder.path().join(format!("{name}.png")))
            .unwrap();
        fs::write(folder.path().join(format!("{name}.json")), sidecar).unwrap();
    }

    fn put16(folder: &TempDir, name: &str, width: u32, pixels: &[u16], sidecar: &str) {
        let height = pixels.len() as u32 / width;
        let picture: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_raw(width, height, pixels.to_vec()).unwrap();
        picture.save(folder.path().join(format!("{name}.png"))).unwrap();
        fs::write(folder.path().join(format!("{name}.json")), sidecar).unwrap();
    }

    fn site(folder: &TempDir, names: &[&str]) -> Result<Site, SourceError> {
        load_site(folder.path(), names, &BTreeMap::new())
    }

    fn message(result: Result<Site, SourceError>) -> String {
        let error = result.unwrap_err();
        assert!(!error.hint().is_empty());
        format!("{error} | {}", error.hint())
    }

    #[test]
    fn values_are_pixel_times_scale_plus_offset_and_row_0_is_north() {
        let folder =
            folder8(3, &[0, 1, 255, 10, 20, 30], r#"{"pixel_size_m": 10, "value": {"scale": 0.5, "offset": -2}}"#);
        put16(&folder, "n", 1, &[0, 65535], r#"{"size_m": [30, 60], "value": {"scale": 0.01}}"#);
        let error = message(site(&folder, &["m", "n"]));
        assert!(error.contains("m.png") && error.contains("n.png"), "{error}");
        let map = load_map(&folder.path().join("m.png"), None).unwrap();
        assert_eq!(map.values(), [-2.0, -1.5, 125.5, 3.0, 8.0, 13.0]);
        assert_eq!((map.size(), map.pixel_size()), ((3, 2), 10.0));
        assert_eq!(map.nearest(Vec2::new(25.0, 15.0)), 125.5);
        assert_eq!(map.nearest(Vec2::new(5.0, 5.0)), 3.0);
        let map = load_map(&folder.path().join("n.png"), None).unwrap();
        assert_eq!(map.values(), [0.0, 655.35]);
    }

    #[test]
    fn masks_are_0_or_1_above_the_middle() {
        let sidecar = r#"{"pixel_size_m": 1, "value": {"scale": 7, "offset": 3, "units": "mask"}}"#;
        let folder = folder8(4, &[0, 127, 128, 255], sidecar);
        put16(&folder, "n", 4, &[0, 32767, 32768, 65535], sidecar);
        let site = site(&folder, &["m", "n"]).unwrap();
        for name in ["m", "n"] {
            assert_eq!(site.map(name).unwrap().values(), [0.0, 0.0, 1.0, 1.0], "{name}");
        }
    }

    #[test]
    fn one_pixel_is_a_map() {
        let folder = folder8(
            1,
            &[9],
            r#"{"size_m": [500, 500], "crs": "EPSG:32618", "bounds_crs_m": {"minx": 5, "miny": 6, "maxx": 505, "maxy": 506}}"#,
        );
        let site = site(&folder, &["m"]).unwrap();
        assert_eq!(site.bounds, Bounds::between(Point::new(0, 0), Point::new(512_000, 512_000)));
        assert_eq!((site.crs.as_deref(), site.origin), (Some("EPSG:32618"), Some(Vec2::new(5.0, 6.0))));
        assert_eq!(site.map("m").unwrap().nearest(Vec2::new(250.0, 250.0)), 9.0);
    }

    #[test]
    fn resolutions_may_differ_but_bounds_may_not() {
        let folder = folder8(4, &[0; 8], PLAIN);
        put8(&folder, "coarse", 2, &[0; 2], r#"{"pixel_size_m": 20}"#);
        put8(&folder, "wide", 4, &[0; 8], r#"{"pixel_size_m": 11}"#);
        assert_eq!(site(&folder, &["m", "coarse"]).unwrap().maps.len(), 2);
        let error = message(site(&folder, &["m", "wide"]));
        assert!(error.contains("m.png and ") && error.contains("40 × 20 m, but 44 × 22 m"), "{error}");
        let bounds = |x: i32| {
            format!(
                r#"{{"pixel_size_m": 10, "bounds_crs_m": {{"minx": {x}, "miny": 0, "maxx": {}, "maxy": 20}}}}"#,
                x + 40
            )
        };
        put8(&folder, "m", 4, &[0; 8], &bounds(100));
        put8(&folder, "east", 4, &[0; 8], &bounds(101));
        let error = message(site(&folder, &["m", "east"]));
        assert!(error.contains("(101, 0) to (141, 20)") && error.contains("(100, 0) to (140, 20)"), "{error}");
    }

    #[test]
    fn only_named_and_known_maps_are_opened() {
        let folder = folder8(2, &[0; 4], PLAIN);
        put8(&folder, "parks", 2, &[0; 4], PLAIN);
        fs::write(folder.path().join("broken.png"), "no picture").unwrap();
        fs::write(folder.path().join("broken.json"), "{").unwrap();
        let loaded = site(&folder, &["m", "density"]).unwrap();
        assert_eq!(loaded.maps.keys().collect::<Vec<_>>(), ["m", "parks"]);
        assert!(site(&folder, &["broken"]).is_err());
        assert_eq!(map_names(folder.path()).unwrap(), ["broken", "m", "parks"]);
    }

    #[test]
    fn a_missing_map_or_folder_is_named_with_its_likeness() {
        let folder = folder8(2, &[0; 4], PLAIN);
        put8(&folder, "borough", 2, &[0; 4], PLAIN);
        let error = message(site(&folder, &["burough"]));
        assert!(error.contains("no map `burough`") && error.contains("did you mean `borough`?"), "{error}");
        let error = message(site(&folder, &["zzzzzz"]));
        assert!(error.contains("there are `borough`, `m`"), "{error}");
        let gone = folder.path().join("gone");
        let error = message(load_site(&gone, &["m"], &BTreeMap::new()));
        assert!(error.contains("gone: cannot be read") && error.contains("check the spelling"), "{error}");
        let error = message(site(&TempDir::new().unwrap(), &["land"]));
        assert!(error.contains("no map in this folder") && error.contains("elevation, land"), "{error}");
    }

    #[test]
    fn sidecars_are_checked() {
        for (sidecar, wrong) in [
            ("{\n  \"pixel_size_m\": ,\n}", "m.json:2:19: expected value"),
            (r#"{"pixel_size_m": "ten"}"#, "`pixel_size_m` must be a number, not the text \"ten\""),
            (r#"{"pixel_size_m": 1e999}"#, "number out of range"),
            (r#"{"pixel_size_m": NaN}"#, "expected value"),
            (r#"{"pixel_size_m": 0}"#, "pixel_size_m is 0: it must be a finite number above 0"),
            (r#"{"pixel_size_m": -3}"#, "pixel_size_m is -3"),
            (r#"{"size_m": [20, 0]}"#, "size_m[1] is 0"),
            (r#"{"size_m": [20]}"#, "`size_m` must be two numbers"),
            (r#"{"size_m": [20, 30]}"#, "pixels must be square"),
            (r#"{"size_m": [20, 20], "pixel_size_m": 11}"#, "they make [22, 22]"),
            (r#"{"pixel_size_m": 10, "value": {"scale": 0}}"#, "value.scale is 0"),
            (r#"{"pixel_size_m": 10, "value": {"scale": -1}}"#, "value.scale is -1"),
            (r#"{"pixel_size_m": 300000}"#, "between 1 mm and 524 km"),
            (r#"{"pixel_size_m": 0.0001}"#, "between 1 mm and 524 km"),
            (r#"{"crs": "EPSG:32618"}"#, "does not say how large the map is"),
            ("[]", "is a list, not a JSON object"),
            ("", "m.json:1:0: EOF"),
            (
                r#"{"pixel_size_m": 10, "bounds_crs_m": {"minx": 0, "miny": 0, "maxx": 30, "maxy": 20}}"#,
                "bounds_crs_m is 30 × 20 m: it must span the map's 20 × 20 m",
            ),
        ] {
            let error = message(site(&folder8(2, &[0; 4], sidecar), &["m"]));
            assert!(error.contains("m.json") && error.contains(wrong), "{sidecar}: {error}");
        }
    }

    #[test]
    fn a_picture_without_a_sidecar_needs_options() {
        let folder = folder8(2, &[1, 2, 200, 4], PLAIN);
        fs::remove_file(folder.path().join("m.json")).unwrap();
        assert!(message(site(&folder, &["m"])).contains("has no sidecar"));
        let with = |size_m, scale, offset, mask| {
            let options = BTreeMap::from([("m".to_owned(), MapOptions { size_m, scale, offset, mask })]);
            load_site(folder.path(), &["m"], &options)
        };
        assert_eq!(with([8.0, 8.0], 2.0, 1.0, false).unwrap().map("m").unwrap().values(), [3.0, 5.0, 401.0, 9.0]);
        assert_eq!(with([8.0, 8.0], 1.0, 0.0, true).unwrap().map("m").unwrap().values(), [0.0, 0.0, 1.0, 0.0]);
        for (size, scale, offset) in
            [([f64::NAN, 8.0], 1.0, 0.0), ([8.0, 8.0], f64::INFINITY, 0.0), ([8.0, 8.0], 1.0, f64::NAN)]
        {
            assert!(message(with(size, scale, offset, false)).contains("finite number"));
        }
        assert!(message(with([8.0, 8.0], 1e300, 0.0, false)).contains("between 1e-9 and 1e9"));
        assert!(message(with([8.0, 8.0], 1.0, 1e300, false)).contains("not finite"));
    }

    #[test]
    fn colour_is_refused_by_name() {
        let folder = folder8(2, &[0; 4], PLAIN);
        let path = folder.path().join("m.png");
        for (picture, wrong) in [
            (DynamicImage::new_rgb8(2, 2), "a colour picture (Rgb8)"),
            (DynamicImage::new_rgba16(2, 2), "a colour picture (Rgba16)"),
            (DynamicImage::new_luma_a8(2, 2), "grayscale with transparency"),
        ] {
            picture.save(&path).unwrap();
            let error = message(site(&folder, &["m"]));
            assert!(error.contains(wrong) && error.contains("save it as 8 or 16 bit grayscale"), "{error}");
        }
    }

    #[test]
    fn a_cut_off_picture_is_an_error_wherever_it_is_cut() {
        let noise: Vec<u8> = (0..64u32).map(|i| (i * 167 % 251) as u8).collect();
        let folder = folder8(8, &noise, PLAIN);
        let path = folder.path().join("m.png");
        let whole = fs::read(&path).unwrap();
        // The last chunk, IEND, holds nothing: without it the picture is whole.
        for length in 0..whole.len() - 12 {
            fs::write(&path, &whole[..length]).unwrap();
            assert!(message(site(&folder, &["m"])).contains("m.png"), "cut at {length} of {}", whole.len());
        }
    }

    #[test]
    fn a_damaged_picture_never_panics() {
        let noise: Vec<u8> = (0..64u32).map(|i| (i * 167 % 251) as u8).collect();
        let folder = folder8(8, &noise, PLAIN);
        let path = folder.path().join("m.png");
        let whole = fs::read(&path).unwrap();
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 1 << (at % 8);
            fs::write(&path, &bytes).unwrap();
            let _ = site(&folder, &["m"]);
        }
    }

    #[test]
    fn an_absurd_size_is_refused_before_decoding() {
        let folder = folder8(MAX_MAP_SIDE + 1, &vec![0; MAX_MAP_SIDE as usize + 1], PLAIN);
        let error = message(site(&folder, &["m"]));
        assert!(error.contains("16385 × 1 pixels are more than 16384 × 16384"), "{error}");
    }

    #[test]
    fn flat_sites_have_their_size() {
        let site = flat_site(Vec2::new(3000.0, 2000.0)).unwrap();
        assert_eq!((site.bounds.size(), site.maps.len()), (Vec2::new(3000.0, 2000.0), 0));
        for size in [Vec2::new(0.0, 1.0), Vec2::new(-5.0, 1.0), Vec2::new(f64::NAN, 1.0), Vec2::new(1e9, 1.0)] {
            assert!(matches!(flat_site(size), Err(SourceError::Value { .. })), "{size}");
        }
    }

    #[test]
    fn manhattan_loads_with_its_real_numbers() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/manhattan/maps");
        let site = load_site(&folder, &["borough"], &BTreeMap::new()).unwrap();
        assert_eq!(site.maps.keys().collect::<Vec<_>>(), ["borough", "density", "land", "parks"]);
        assert_eq!(site.bounds.size(), Vec2::new(13070.0, 22900.0));
        assert_eq!((site.crs.as_deref(), site.origin), (Some("EPSG:32618"), Some(Vec2::new(579_660.0, 4_503_410.0))));
        let share = |name: &str| {
            let values = site.map(name).unwrap().values();
            values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64
        };
        // Of the sidecars: mean pixel / 255, and mean density.
        assert!((share("borough") - 50.360_332 / 255.0).abs() < 1e-6);
        assert!((share("land") - 211.748_413 / 255.0).abs() < 1e-6);
        assert!((share("density") - 9982.963).abs() < 1.0, "{}", share("density"));
        // Midtown is land in the borough, the Hudson is neither, New Jersey is land only, Central Park is a park.
        let frame = super::super::Frame::of_site(&site).unwrap().unwrap();
        for (lon, lat, borough, land, parks) in [
            (-73.9857, 40.7484, true, true, false),
            (-74.0205, 40.7450, false, false, false),
            (-74.0440, 40.7400, false, true, false),
            (-73.9654, 40.7829, true, true, true),
        ] {
            let at = frame.local(lon, lat).unwrap();
            let is = |name: &str| site.map(name).unwrap().mask(at);
            assert_eq!((is("borough"), is("land"), is("parks")), (borough, land, parks), "{lon}, {lat}");
        }
    }

    proptest! {
        #[test]
        fn any_scale_and_offset_hold(pixel: u16, scale in 1e-6..1e6f64, offset in -1e6..1e6f64) {
            let folder = TempDir::new().unwrap();
            let sidecar = serde_json::json!({"pixel_size_m": 5, "value": {"scale": scale, "offset": offset, "units": "m"}});
            put16(&folder, "m", 1, &[pixel], &sidecar.to_string());
            let map = load_map(&folder.path().join("m.png"), None).unwrap();
            prop_assert_eq!(map.values()[0], (f64::from(pixel) * scale + offset) as f32);
        }
    }
}
