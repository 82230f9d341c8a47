//! The worker: the newest order wins, and nothing is built twice.

use city::{Cache, Changes};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};
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
    let worker = Worker::start(None, Cache::in_memory(), Arc::new(|| {})).unwrap();
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
