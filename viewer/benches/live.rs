//! How long from saving a rule of Manhattan to the city being ready to be painted, beside a build from scratch; and what a frame
//! costs. `cargo bench -p viewer`.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot go on ends")]

use city::{Cache, Cancel, Changes, Digests, Settings, Silent, build, build_with, load, load_as_written};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use viewer::render::{Camera, Gpu, Look, OrbitCamera, Renderer, Target};
use viewer::scene::{MapScene, ModelScene, Scene};
use viewer::shown::{Layers, shown};
use viewer::sight::Sight;
use viewer::worker::{News, Order, Ready, Worker};

/// Saves of each rule.
const SAVES: usize = 5;

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() { copy(&entry.path(), &target) } else { drop(fs::copy(entry.path(), target)) }
    }
}

/// Waits for the next city; how long after a moment what is in sight of it was there.
fn next_since(worker: &Worker, begin: Instant) -> (Arc<Ready>, Duration) {
    let mut glimpsed = None;
    loop {
        for news in worker.news() {
            match news {
                News::Glimpse(_) => glimpsed = Some(begin.elapsed()),
                News::Ready(ready) => return (ready, glimpsed.unwrap_or_else(|| begin.elapsed())),
                News::Failed(failure) => panic!("{failure:?}"),
                _ => {}
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

fn next(worker: &Worker) -> Arc<Ready> {
    next_since(worker, Instant::now()).0
}

fn seconds(times: &[Duration]) -> String {
    times.iter().map(|time| format!("{:.2}", time.as_secs_f64())).collect::<Vec<_>>().join(" ")
}

fn main() {
    let Ok(gpu) = Gpu::headless() else { return println!("SKIPPED: no graphics adapter") };
    println!("drawn by {}", gpu.about);
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let folder = tempfile::tempdir().unwrap();
    let city = folder.path().join("manhattan");
    copy(&root.join("scripts/manhattan"), &city);
    for kind in ["buildings", "parcels", "streets", "presets"] {
        copy(&root.join("rules").join(kind), &city.join(kind));
    }
    let from_scratch = || {
        let begin = Instant::now();
        let sources = load(&city, None).unwrap().read().unwrap();
        build(&sources, Settings::default(), &Silent, &Cancel::default()).unwrap();
        begin.elapsed()
    };
    println!("{:32} {}", "from scratch, nothing drawn", seconds(&[from_scratch(), from_scratch()]));
    steps(&gpu, &city);
    cached(&gpu, &city);
    let worker = Worker::start(Some(gpu.clone()), Cache::in_memory, Arc::new(|| {})).unwrap();
    let order = |changes| Order { city: city.clone(), rules: None, changes, colour_by: None };
    let begin = Instant::now();
    worker.order(order(Changes::default()));
    let ready = next(&worker);
    println!("{:32} {}", "first picture, nothing kept", seconds(&[begin.elapsed()]));
    frames(&gpu, ready.scene.as_ref().unwrap(), ready.built.city.buildings.len());
    large(&gpu, &root);
    let mut changes = Changes::default();
    let quarters = &ready.built.city.quarters;
    let largest = quarters.iter().max_by(|a, b| a.polygon.area().total_cmp(&b.polygon.area())).unwrap().id;
    let text = fs::read_to_string(city.join("streets/organic.rhai")).unwrap();
    fs::write(city.join("streets/mine.rhai"), &text).unwrap();
    fs::write(city.join("presets/mine.rhai"), "//! Mine.\npreset(#{ pattern: rule(\"streets/mine\") });\n").unwrap();
    changes.lay(format!("quarter:{largest}").parse().unwrap(), "mine");
    worker.order(order(changes));
    next(&worker);
    // As somebody does who works on a rule: most of a district in sight.
    let middle = quarters.iter().find(|quarter| quarter.id == largest).map(|quarter| quarter.polygon.centroid());
    let middle = middle.unwrap();
    let reach = geom::Vec2::new(700.0, 500.0);
    let near = Sight::of(middle - reach, middle + reach, ready.scene.as_ref().unwrap().extent);
    assert!(near.is_some());
    let edit = |name: &str, file: PathBuf, change: &dyn Fn(&str, usize) -> String| {
        let text = fs::read_to_string(&file).unwrap();
        let times: Vec<(Duration, Duration, Duration)> = (0..SAVES)
            .map(|i| {
                let save = |sight: Option<Sight>, i: usize| {
                    worker.look(sight);
                    std::thread::sleep(Duration::from_millis(500));
                    worker.news().for_each(drop);
                    let begin = Instant::now();
                    let changed = change(&text, i);
                    assert_ne!(changed, text, "{name}: nothing is another");
                    fs::write(&file, changed).unwrap();
                    let (_, glimpsed) = next_since(&worker, begin);
                    (glimpsed, begin.elapsed())
                };
                let (_, whole) = save(None, 2 * i);
                let (glimpsed, after) = save(near, 2 * i + 1);
                (whole, glimpsed, after)
            })
            .collect();
        let pick =
            |of: fn(&(Duration, Duration, Duration)) -> Duration| seconds(&times.iter().map(of).collect::<Vec<_>>());
        println!("{name:32} {}", pick(|times| times.0));
        println!("{:32} {}, then all {}", "  a part in sight", pick(|times| times.1), pick(|times| times.2));
    };
    let remark = |text: &str, i: usize| format!("{text}\n// {i}\n");
    // What is built changes with these.
    let higher = |text: &str, i: usize| text.replacen("max(round(", &format!("max({i} + round("), 1);
    let wider =
        |text: &str, i: usize| text.replacen("setback: p.setback", &format!("setback: p.setback + 0.{:02}", i + 1), 1);
    let building = city.join("buildings/extruded.rhai");
    edit("building rule, a remark", building.clone(), &remark);
    edit("building rule, heights", building.clone(), &higher);
    edit("building rule, setbacks", building, &wider);
    edit("parcel rule, a remark", city.join("parcels/island.rhai"), &remark);
    edit("parcel rule, sizes", city.join("parcels/island.rhai"), &|text, i| {
        text.replacen("most_area: p.most_area", &format!("most_area: p.most_area * 1.0{:02}", i + 1), 1)
    });
    edit("street rule of one quarter", city.join("streets/mine.rhai"), &|text, i| {
        text.replacen("tip.ahead(", &format!("tip.ahead({i} + "), 1)
    });
    edit("street rule of all", city.join("streets/grid.rhai"), &remark);
}

/// What the worker does after a building rule was saved, step by step.
fn steps(gpu: &Gpu, city: &Path) {
    let cache = Cache::in_memory();
    let file = city.join("buildings/extruded.rhai");
    let text = fs::read_to_string(&file).unwrap();
    let mut before: Option<(ModelScene, MapScene, Digests)> = None;
    for save in 0..4 {
        fs::write(&file, format!("{text}\n// step {save}\n")).unwrap();
        let mut laps = Laps::begin();
        let mut done = |name| laps.done(name);
        let loaded = load_as_written(city, None).unwrap();
        done("load");
        let sources = loaded.read_with(&cache).unwrap();
        done("read");
        let built = build_with(&sources, Settings::default(), &cache, &Silent, &Cancel::default()).unwrap();
        done("build");
        let model = city::export::glb::model(&built.city, &cache);
        done("meshes");
        let model = ModelScene::of(gpu, &model, before.as_ref().map(|(model, ..)| model));
        done("chunks of the model");
        let known = before.as_ref().map(|(_, map, digests)| (map, *digests));
        let map = MapScene::of(gpu, &built.city, None, known);
        done("chunks of the map");
        before = Some((model, map, built.city.digests));
        if save == 0 {
            continue;
        }
        println!("{:32} {}", "step by step", laps.told());
    }
    fs::write(&file, text).unwrap();
}

/// What comes before the first picture of a city whose stages lie on disk, step by step.
fn cached(gpu: &Gpu, city: &Path) {
    let folder = tempfile::tempdir().unwrap();
    for start in 0..3 {
        let mut laps = Laps::begin();
        let cache = Cache::on_disk(folder.path(), 1 << 30).unwrap();
        laps.done("cache");
        let loaded = load_as_written(city, None).unwrap();
        laps.done("load");
        let sources = loaded.read_with(&cache).unwrap();
        laps.done("read");
        let built = build_with(&sources, Settings::default(), &cache, &Silent, &Cancel::default()).unwrap();
        laps.done("build");
        let scene = Scene::of_map(gpu, &built.city, None);
        laps.done("chunks of the map");
        let first = laps.told();
        scene.add_model(gpu, &built.city, &cache);
        laps.done("the model");
        cache.flush();
        if start > 0 {
            println!("{:32} {first}", "first picture, stages on disk");
            println!("{:32} {}", "  with the model", laps.told());
        }
    }
}

/// Times of steps, one after the other.
struct Laps {
    begin: Instant,
    steps: Vec<(&'static str, Duration)>,
}

impl Laps {
    fn begin() -> Self {
        Self { begin: Instant::now(), steps: Vec::new() }
    }

    fn done(&mut self, name: &'static str) {
        let now = Instant::now();
        self.steps.push((name, now - std::mem::replace(&mut self.begin, now)));
    }

    fn told(&self) -> String {
        let all: Duration = self.steps.iter().map(|(_, time)| *time).sum();
        let steps: Vec<String> =
            self.steps.iter().map(|(name, time)| format!("{name} {:.2}", time.as_secs_f64())).collect();
        format!("{:.2}: {}", all.as_secs_f64(), steps.join(", "))
    }
}

/// Frames of a city with far more than 100,000 buildings, all in sight, and of one with about as many.
fn large(gpu: &Gpu, root: &Path) {
    for name in ["san_francisco", "two_rivers"] {
        let sources = load(&root.join("scripts").join(name), None).unwrap().read().unwrap();
        let built = build(&sources, Settings::default(), &Silent, &Cancel::default()).unwrap();
        let scene = Scene::of(gpu, &built.city, &Cache::none(), None, None);
        frames(gpu, &scene, built.city.buildings.len());
    }
}

/// What frames cost on the processor, while the camera turns.
fn frames(gpu: &Gpu, scene: &Scene, buildings: usize) {
    let target = Target::new(gpu, [1280, 800]).unwrap();
    let mut renderer = Renderer::new(gpu.clone());
    let mut camera = OrbitCamera::over(scene.extent, 0.0);
    let mut costs = Vec::new();
    for _ in 0..20 {
        camera.turn([15.0, 0.0]);
        let camera = Camera::Orbit(camera);
        costs.push(renderer.draw(
            &target,
            &camera,
            &shown(scene, None, &camera, &Layers::default(), None, Look::default()),
        ));
        target.read(gpu).unwrap();
    }
    costs.sort_by_key(|cost| cost.cpu);
    let (middle, last) = (costs[costs.len() / 2], costs[costs.len() - 1]);
    println!(
        "{:32} {:.2} ms, at most {:.2}; {} draws, {} triangles, {} kB uploaded, {} buildings",
        "a frame, on the processor",
        middle.cpu.as_secs_f64() * 1000.0,
        last.cpu.as_secs_f64() * 1000.0,
        middle.draws,
        middle.primitives,
        middle.bytes.div_ceil(1024),
        buildings
    );
}
