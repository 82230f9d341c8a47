//! The worker: the newest order wins, and nothing is built twice.

use city::{Cache, Changes};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
use viewer::render::{Camera, Gpu, MapCamera};
use viewer::scene::Scene;
use viewer::screenshot::{Picture, of_scene};
use viewer::sight::Sight;
use viewer::worker::{News, Order, Ready, Worker};

/// Longest that anything may take.
const PATIENCE: Duration = Duration::from_secs(120);

fn order(seed: u64) -> Order {
    let city = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/lattice");
    let mut changes = Changes::default();
    changes.seed = Some(seed);
    Order { city, rules: None, changes, colour_by: None }
}

/// The cities that were told of until nothing is left to do.
fn cities(worker: &Worker) -> Vec<Arc<Ready>> {
    let begin = Instant::now();
    let mut found = Vec::new();
    loop {
        let is_idle = worker.is_idle();
        for news in worker.news() {
            match news {
                News::Ready(ready) => found.push(ready),
                News::Failed(failure) => panic!("{failure:?}"),
                _ => {}
            }
        }
        if is_idle {
            return found;
        }
        assert!(begin.elapsed() < PATIENCE, "nothing came of it");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn the_newest_order_wins_and_is_built_once() {
    let worker = Worker::start(None, Cache::in_memory, Arc::new(|| {})).unwrap();
    worker.order(order(1));
    assert_eq!(cities(&worker).len(), 1);
    for seed in 2..=6 {
        worker.order(order(seed));
        std::thread::sleep(Duration::from_millis(15));
    }
    let found = cities(&worker);
    assert_eq!(found.last().map(|ready| (&ready.order, ready.built.city.seed)), Some((&order(6), 6)));
    assert_eq!(found.iter().filter(|ready| ready.order == order(6)).count(), 1, "built twice");
    // Nor does anything come of what woke it meanwhile.
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(cities(&worker).len(), 0);
}

#[test]
fn what_is_in_sight_comes_first_and_is_what_the_whole_shows_there() {
    let Ok(gpu) = Gpu::headless() else { return println!("SKIPPED: no graphics adapter") };
    let worker = Worker::start(Some(gpu.clone()), Cache::in_memory, Arc::new(|| {})).unwrap();
    worker.order(order(1));
    let first = cities(&worker).pop().expect("a city");
    let middle = first.built.city.blocks[first.built.city.blocks.len() / 2].polygon.outer[0].metres();
    let reach = geom::Vec2::new(240.0, 160.0);
    let extent = first.scene.as_ref().unwrap().extent;
    let sight = Sight::of(middle - reach, middle + reach, extent).expect("a part");
    worker.look(Some(sight));
    worker.order(order(2));
    let begin = Instant::now();
    let (mut glimpse, mut ready) = (None, None);
    while ready.is_none() {
        for news in worker.news() {
            match news {
                News::Glimpse(scene) => glimpse = Some(scene),
                News::Ready(city) => ready = Some(city),
                News::Failed(failure) => panic!("{failure:?}"),
                _ => {}
            }
        }
        assert!(begin.elapsed() < PATIENCE, "nothing came of it");
        std::thread::sleep(Duration::from_millis(2));
    }
    let (glimpse, ready) = (glimpse.expect("what is in sight"), ready.unwrap());
    let camera = Camera::Map(MapCamera { centre: middle, scale: 1.0 });
    let wish = Picture { size: [480, 320], camera: Some(camera), ..Picture::default() };
    let draw = |scene: &Scene| of_scene(&gpu, scene, &ready.built.city, &wish).unwrap();
    assert!(draw(&glimpse) == draw(ready.scene.as_ref().unwrap()), "it shows what the whole does");
    assert!(draw(&glimpse) != draw(first.scene.as_ref().unwrap()), "something is another");
}

#[test]
fn a_build_for_saved_files_is_told_of_and_can_be_given_up() {
    let folder = tempfile::tempdir().unwrap();
    let city = crate::desk::copy_of("lattice", folder.path());
    let worker = Worker::start(None, Cache::none, Arc::new(|| {})).unwrap();
    worker.order(Order { city: city.clone(), rules: None, changes: Changes::default(), colour_by: None });
    assert_eq!(cities(&worker).len(), 1);
    let script = city.join("city.rhai");
    let text = std::fs::read_to_string(&script).unwrap();
    std::fs::write(&script, format!("{text}\n// Saved.\n")).unwrap();
    let begin = Instant::now();
    let mut stages = Vec::new();
    while stages.is_empty() {
        stages.extend(worker.news().filter(|news| matches!(news, News::Under(..))));
        assert!(begin.elapsed() < PATIENCE, "nothing was told");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(!worker.is_idle(), "it is at work");
    while !worker.is_idle() {
        worker.cancel();
    }
    assert!(!worker.news().any(|news| matches!(news, News::Ready(_))), "it was given up");
    std::fs::write(&script, &text).unwrap();
    while worker.is_idle() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(!cities(&worker).is_empty(), "the next save is built");
}

#[test]
fn the_model_follows_the_map_of_the_first_city_and_is_there_at_once_for_the_next() {
    let Ok(gpu) = Gpu::headless() else { return println!("SKIPPED: no graphics adapter") };
    let worker = Worker::start(Some(gpu), Cache::in_memory, Arc::new(|| {})).unwrap();
    let begin = Instant::now();
    let mut told = Vec::new();
    worker.order(order(1));
    while !told.contains(&"model") {
        for news in worker.news() {
            match news {
                News::Ready(_) => told.push("city"),
                News::Model => told.push("model"),
                _ => {}
            }
        }
        assert!(begin.elapsed() < PATIENCE, "nothing came of it");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(told, ["city", "model"]);
    worker.order(order(2));
    let next = cities(&worker).pop().expect("a city");
    assert!(next.scene.as_ref().unwrap().model().is_some_and(|model| !model.is_empty()));
}
