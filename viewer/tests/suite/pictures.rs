//! Pictures without a window, held against golden ones, with Vulkan in software where there is no other.
//!
//! `UPDATE_SNAPSHOTS=1 cargo test --workspace --test window pictures` takes new ones over, to be looked at.

use city::{Built, Cache, Cancel, Settings, Silent, build, load};
use egui_kittest::{SnapshotOptions, try_image_snapshot_options};
use geom::{Bounds, Vec2};
use image::RgbaImage;
use std::path::Path;
use viewer::render::{Camera, Gpu, GpuError, Look, MapCamera, OrbitCamera, Target};
use viewer::scene::{By, LayerKind, Scene};
use viewer::screenshot::{Picture, of_scene, picture};

/// Size of the pictures.
const SIZE: [u32; 2] = [480, 320];

/// Pixels along silhouettes that drivers may see differently.
const SILHOUETTES: usize = 300;

/// A device, or a word that there is none.
fn device() -> Option<Gpu> {
    match Gpu::headless() {
        Ok(gpu) => {
            println!("drawn by {}", gpu.about);
            Some(gpu)
        }
        Err(error) => {
            println!("SKIPPED, nothing was drawn: {error}");
            None
        }
    }
}

fn built(city: &str) -> Built {
    built_from(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts").join(city))
}

/// A small city with something of every layer.
fn with_everything() -> Built {
    let folder = tempfile::tempdir().unwrap();
    let script = r#"
        city(#{
            site: site(#{ size: [900, 600] }),
            districts: districts_from("districts.geojson"),
            landmarks: [
                landmark(#{ name: "Hall", at: [300, 300], size: [120, 80], parcel: "plaza" }),
                landmark(#{ name: "Common", at: [650, 300], size: [150, 120], parcel: "park" }),
            ],
            given: [line([[50, 50], [850, 50], [850, 550], [50, 550], [50, 50]])],
            minors: streets(#{ pattern: rule("streets/grid") }),
            parcels: rule("parcels/recursive"),
            buildings: rule("buildings/extruded"),
        });
    "#;
    let districts = r#"{ "type": "FeatureCollection", "plat": { "units": "m" }, "features": [{ "type": "Feature",
        "properties": { "name": "west" }, "geometry": { "type": "Polygon",
        "coordinates": [[[100, 100], [450, 100], [450, 500], [100, 500], [100, 100]]] } }] }"#;
    std::fs::write(folder.path().join("city.rhai"), script).unwrap();
    std::fs::write(folder.path().join("districts.geojson"), districts).unwrap();
    built_from(folder.path())
}

fn built_from(folder: &Path) -> Built {
    let loaded = load(folder, None).unwrap();
    build(&loaded.read().unwrap(), Settings::default(), &Silent, &Cancel::default()).unwrap()
}

/// What is built on, and a place where there is something to see.
fn places(built: &Built) -> (Bounds, Vec2) {
    let blocks = &built.city.blocks;
    (built.city.graph.bounds().unwrap(), blocks[blocks.len() / 2].polygon.outer[0].metres())
}

/// All of a city in space, and a part of it from nearby.
fn in_space(built: &Built) -> [Camera; 2] {
    let (bounds, place) = places(built);
    let target = place.extend(built.city.site.elevation(place));
    let near = OrbitCamera { target, distance: 350.0, heading: 40.0, pitch: 32.0 };
    [OrbitCamera::over(bounds, target.z), near].map(Camera::Orbit)
}

fn on_map(built: &Built) -> [Camera; 2] {
    let (bounds, centre) = places(built);
    [MapCamera::over(bounds, SIZE.map(|side| side as f32)), MapCamera { centre, scale: 1.2 }].map(Camera::Map)
}

fn wish(camera: Camera) -> Picture {
    Picture { size: SIZE, camera: Some(camera), ..Picture::default() }
}

/// Pixels in which two pictures differ by more than a shade.
fn apart(a: &RgbaImage, b: &RgbaImage) -> usize {
    let differ = |(p, q): (&image::Rgba<u8>, &image::Rgba<u8>)| p.0.iter().zip(q.0).any(|(a, b)| a.abs_diff(b) > 6);
    a.pixels().zip(b.pixels()).filter(|pair| differ(*pair)).count()
}

#[test]
fn cities_look_as_they_did() {
    let Some(gpu) = device() else { return };
    let mut wrong = Vec::new();
    for name in ["lattice", "krems", "patterns"] {
        let built = built(name);
        let scene = Scene::of(&gpu, &built.city, &Cache::none(), None, None);
        let cameras = [("map", on_map(&built)), ("model", in_space(&built))];
        for (kind, [whole, near]) in cameras {
            for (part, camera) in [("whole", whole), ("near", near)] {
                let drawn = of_scene(&gpu, &scene, &built.city, &wish(camera)).unwrap();
                let options = SnapshotOptions::new().max_failed_pixels(SILHOUETTES);
                let golden = format!("{name}_{kind}_{part}");
                wrong.extend(try_image_snapshot_options(&drawn, golden, &options).err().map(|error| error.to_string()));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Pictures side by side, so many in a row.
fn sheet(pictures: &[RgbaImage], columns: usize) -> RgbaImage {
    let [width, height] = SMALL;
    let rows = pictures.len().div_ceil(columns) as u32;
    let mut sheet = RgbaImage::new(width * columns as u32, height * rows);
    for (i, picture) in pictures.iter().enumerate() {
        let [x, y] = [i % columns, i / columns].map(|at| at as u32);
        image::imageops::replace(&mut sheet, picture, i64::from(x * width), i64::from(y * height));
    }
    sheet
}

/// Size of a picture on a sheet.
const SMALL: [u32; 2] = [216, 144];

/// Every rendering option and layer the other way round, every colouring and every overlay: a sheet for each city and view.
#[test]
fn options_layers_colours_and_overlays_look_as_they_did() {
    let Some(gpu) = device() else { return };
    let mut wrong = Vec::new();
    for name in ["lattice", "krems", "patterns"] {
        let built = built(name);
        let site = &built.city.site;
        let scene = Scene::of(&gpu, &built.city, &Cache::none(), None, None);
        let ([_, map], [_, near]) = (on_map(&built), in_space(&built));
        let small = |camera| Picture { size: SMALL, ..wish(camera) };
        let overlays = |camera| {
            let over = move |map: &String| Picture { overlay: Some((map.clone(), 0.6)), ..small(camera) };
            site.maps.keys().map(over).collect::<Vec<_>>()
        };
        let looks: [fn(&mut Look); 5] = [
            |_| {},
            |look| look.shadows = false,
            |look| look.silhouettes = 0.0,
            |look| look.sun = (90.0, 20.0),
            |look| look.detail = 10.0,
        ];
        let mut models: Vec<Picture> = looks
            .into_iter()
            .map(|change| {
                let mut wish = small(near);
                change(&mut wish.look);
                wish
            })
            .collect();
        models.extend((0..viewer::shown::MODEL_PARTS.len()).map(|part| {
            let mut wish = small(near);
            wish.layers.model[part] = false;
            wish
        }));
        models.extend(overlays(near));
        let mut maps: Vec<Picture> = vec![small(map)];
        maps.extend(LayerKind::ALL.map(|layer| {
            let mut wish = small(map);
            if !wish.layers.map.remove(&layer) {
                wish.layers.map.insert(layer);
            }
            wish
        }));
        let mut without_ground = small(map);
        without_ground.layers.ground = false;
        maps.push(without_ground);
        let parts: [fn(&mut viewer::shown::Layers); 2] = [|layers| layers.water = false, |layers| layers.parks = false];
        maps.extend(parts.into_iter().map(|change| {
            let mut wish = small(map);
            change(&mut wish.layers);
            wish
        }));
        maps.extend(built.city.graph.classes().iter().map(|(_, class)| {
            let mut wish = small(map);
            wish.layers.classes_off = [class.name.clone()].into();
            wish
        }));
        maps.extend(overlays(map));
        let draw = |wish: &Picture| of_scene(&gpu, &scene, &built.city, wish).unwrap();
        let mut drawn: Vec<RgbaImage> = maps.iter().map(draw).collect();
        let has_map = |by: &By| by.map().is_none_or(|map| site.map(map).is_some());
        for by in [By::Class, By::Rule, By::District, By::Density, By::Grade].into_iter().filter(has_map) {
            drawn.push(picture(&gpu, &built, &Picture { colour_by: Some(by), ..small(map) }).unwrap());
        }
        for (kind, drawn) in [("map", drawn), ("model", models.iter().map(draw).collect())] {
            let options = SnapshotOptions::new().max_failed_pixels(SILHOUETTES);
            let golden = format!("{name}_{kind}_options");
            let told = try_image_snapshot_options(&sheet(&drawn, 5), golden, &options);
            wrong.extend(told.err().map(|error| error.to_string()));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn water_parks_and_each_class_of_streets_are_switched() {
    let Some(gpu) = device() else { return };
    let folder = tempfile::tempdir().unwrap();
    let script = r#"
        city(#{
            site: site(#{ size: [900, 600], land: |x, y| x > 200, parks: |x, y| hypot(x - 325, y - 300) < 80 }),
            given: [line([[450, 50], [850, 50], [850, 550], [450, 550], [450, 50]])],
            minors: streets(#{ pattern: rule("streets/grid") }),
        });
    "#;
    std::fs::write(folder.path().join("city.rhai"), script).unwrap();
    let built = built_from(folder.path());
    let scene = Scene::of(&gpu, &built.city, &Cache::none(), None, None);
    let map = Camera::Map(MapCamera { centre: built.city.site.bounds.size() / 2.0, scale: 2.0 });
    let draw = |change: &dyn Fn(&mut viewer::shown::Layers)| {
        let mut wish = wish(map);
        // Blocks would hide the ground.
        wish.layers.map = [LayerKind::Streets].into();
        change(&mut wish.layers);
        of_scene(&gpu, &scene, &built.city, &wish).unwrap()
    };
    let all = draw(&|_| {});
    let is_there = |class: streets::Class| built.city.runs.iter().any(|run| run.class == class);
    let classes = built.city.graph.classes().iter().filter(|(class, _)| is_there(*class));
    let classes: Vec<String> = classes.map(|(_, info)| info.name.clone()).collect();
    assert_eq!(classes, ["major", "minor"]);
    let mut pictures = vec![draw(&|layers| layers.water = false), draw(&|layers| layers.parks = false)];
    pictures.extend(classes.iter().map(|class| draw(&|layers| layers.classes_off = [class.clone()].into())));
    for (i, picture) in pictures.iter().enumerate() {
        assert!(apart(picture, &all) > 300, "{i}: {}", apart(picture, &all));
    }
    let none = draw(&|layers| layers.classes_off.extend(classes.clone()));
    let no_streets = draw(&|layers| layers.map.retain(|layer| *layer != LayerKind::Streets));
    assert_eq!(apart(&none, &no_streets), 0);
}

#[test]
fn a_map_laid_over_another_hides_none_of_its_places() {
    let Some(gpu) = device() else { return };
    let built = built("patterns");
    let scene = Scene::of(&gpu, &built.city, &Cache::none(), None, None);
    let middle = built.city.site.bounds.size() / 2.0;
    let map = Camera::Map(MapCamera { centre: middle, scale: 1.2 });
    let mut names = built.city.site.maps.keys();
    let name = names.next().expect("a map of the site").clone();
    let whole = Picture { overlay: Some((name, 1.0)), ..wish(map) };
    let mut bare = whole.clone();
    bare.layers.map.clear();
    let draw = |wish: &Picture| of_scene(&gpu, &scene, &built.city, wish).unwrap();
    assert_eq!(apart(&draw(&whole), &draw(&bare)), 0, "under a map that lets nothing through there is nothing to see");
}

#[test]
fn every_option_shows() {
    let Some(gpu) = device() else { return };
    let built = with_everything();
    let ([_, near], [whole, map]) = (in_space(&built), on_map(&built));
    let scene = Scene::of(&gpu, &built.city, &Cache::none(), None, None);
    let draw = |wish: &Picture| of_scene(&gpu, &scene, &built.city, wish).unwrap();
    let (model, plan) = (wish(near), wish(map));
    let (model_drawn, plan_drawn) = (draw(&model), draw(&plan));
    let shows = |name: &str, drawn: RgbaImage, before: &RgbaImage| {
        let pixels = apart(&drawn, before);
        assert!(pixels > 60, "{name} changes {pixels} pixels");
    };
    let look = |change: fn(&mut Look)| {
        let mut wish = model.clone();
        change(&mut wish.look);
        draw(&wish)
    };
    shows("shadows", look(|look| look.shadows = false), &model_drawn);
    shows("silhouettes", look(|look| look.silhouettes = 0.0), &model_drawn);
    shows("the sun", look(|look| look.sun = (90.0, 20.0)), &model_drawn);
    for part in 0..viewer::shown::MODEL_PARTS.len() {
        let mut wish = model.clone();
        wish.layers.model[part] = false;
        shows(viewer::shown::MODEL_PARTS[part].1, draw(&wish), &model_drawn);
    }
    for layer in LayerKind::ALL {
        // From far off borders of parcels are not drawn; from nearby there are few kinds of things.
        let of = wish(if layer == LayerKind::Parcels { map } else { whole });
        let before = draw(&of);
        let mut wish = of;
        if !wish.layers.map.remove(&layer) {
            wish.layers.map.insert(layer);
        }
        shows(layer.name(), draw(&wish), &before);
    }
    for by in [By::Class, By::Rule, By::District] {
        let coloured = picture(&gpu, &built, &Picture { colour_by: Some(by), ..plan.clone() }).unwrap();
        shows(&format!("{by:?}"), coloured, &plan_drawn);
    }
    assert_eq!(draw(&model), model_drawn, "the same every time");
}

#[test]
fn every_map_of_a_site_can_be_laid_over() {
    let Some(gpu) = device() else { return };
    let built = built("patterns");
    let maps: Vec<String> = built.city.site.maps.keys().cloned().collect();
    let scene = Scene::of(&gpu, &built.city, &Cache::none(), None, None);
    let draw = |wish: &Picture| of_scene(&gpu, &scene, &built.city, wish).unwrap();
    let ([_, map], [_, near]) = (on_map(&built), in_space(&built));
    for camera in [map, near] {
        let plain = draw(&wish(camera));
        for name in &maps {
            let over = Picture { overlay: Some((name.clone(), 0.8)), ..wish(camera) };
            let pixels = apart(&draw(&over), &plain);
            assert!(pixels > 1000, "{name} changes {pixels} pixels");
            let unseen = Picture { overlay: Some((name.clone(), 0.0)), ..wish(camera) };
            assert_eq!(apart(&draw(&unseen), &plain), 0, "{name}");
        }
    }
}

#[test]
fn sizes_that_no_device_holds_are_refused() {
    let Some(gpu) = device() else { return };
    for size in [[0, 10], [10, 0], [1_000_000, 10]] {
        assert!(matches!(Target::new(&gpu, size), Err(GpuError::Size(..))), "{size:?}");
    }
    let built = built("lattice");
    let [_, near] = in_space(&built);
    for size in [[1, 1], [1, 700], [3840, 2160]] {
        let drawn = picture(&gpu, &built, &Picture { size, ..wish(near) }).unwrap();
        assert_eq!([drawn.width(), drawn.height()], size);
    }
}

#[test]
fn a_scene_over_another_shows_what_a_fresh_one_does() {
    let Some(gpu) = device() else { return };
    let cache = Cache::in_memory();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/lattice");
    let mut before: Option<Scene> = None;
    let parameters = load(&folder, None).unwrap().plan.parameters();
    // One of each stage, by the first number that its rule has; and the seed.
    let of = |role: &str| {
        let number = |p: &&script::RoleParam| matches!(p.param.domain, script::Domain::Number { .. });
        let found = parameters.iter().filter(number).find(|p| p.address.starts_with(role));
        found.map(|p| {
            let script::Domain::Number { range: (low, high), .. } = p.param.domain else { unreachable!() };
            let value = if high.is_finite() && low.is_finite() { low + (high - low) * 0.4 } else { 7.0 };
            format!("{}={value}", p.address)
        })
    };
    let edits = [None, of("buildings"), of("parcels"), of("minors"), Some("seed=9".to_owned())];
    for edit in edits {
        let mut loaded = load(&folder, None).unwrap();
        if let Some(edit) = &edit {
            loaded.set(edit).unwrap();
        }
        let sources = loaded.read_with(&cache).unwrap();
        let built = city::build_with(&sources, Settings::default(), &cache, &Silent, &Cancel::default()).unwrap();
        let over = Scene::of(&gpu, &built.city, &cache, None, before.as_ref());
        let fresh = Scene::of(&gpu, &built.city, &Cache::none(), None, None);
        let keeps_streets =
            edit.as_ref().is_some_and(|edit| edit.starts_with("buildings") || edit.starts_with("parcels"));
        if let Some(before) = before.as_ref().filter(|_| keeps_streets) {
            assert!(over.model().unwrap().shared(before.model().unwrap()) > 0, "{edit:?}: nothing was kept");
        }
        for camera in on_map(&built).into_iter().chain(in_space(&built)) {
            let draw = |scene: &Scene| of_scene(&gpu, scene, &built.city, &wish(camera)).unwrap();
            assert_eq!(apart(&draw(&over), &draw(&fresh)), 0, "{edit:?}");
        }
        before = Some(over);
    }
}
