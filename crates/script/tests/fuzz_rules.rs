//! Mutation fuzz of the rule language: the rules of the library, changed at random, are loaded, checked and asked. Whatever
//! is written, the answer is a rule or a fault in words, and never a panic, a hang or memory without an end.
//!
//! `PLAT_FUZZ_MUTANTS=100000 cargo test -p script --test fuzz_rules --release` runs the long version; `PLAT_FUZZ_FROM=700`
//! with `PLAT_FUZZ_MUTANTS=1` runs the mutant of that number alone.

#[path = "suite/common.rs"]
mod common;
#[path = "fuzz_rules/mutate.rs"]
mod mutate;
#[path = "fuzz_rules/world.rs"]
mod world;

use mutate::{Draws, Stock, mutant};
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;
use world::World;

/// Threads that try mutants.
const WORKERS: usize = 2;
/// Mutants of one thread: its name tells which, since an overflown stack tells nothing else.
const PER_THREAD: u64 = 50;
/// As small a stack as any thread gets.
const STACK: usize = 2 << 20;
/// A mutant that takes longer hangs.
const MOST_SECONDS: u32 = 60;
/// Most memory that the whole run may take.
const MOST_MEMORY_KIB: u64 = 1 << 20;
/// Failures that are shown in full.
const MOST_SHOWN: usize = 5;

fn number_of(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(default)
}

/// What all workers share.
struct Run {
    stock: Stock,
    world: World,
    next: AtomicU64,
    end: u64,
    /// The mutants being tried, by worker.
    trying: [AtomicU64; WORKERS],
    failures: Mutex<Vec<String>>,
    /// Milliseconds and number of the slowest.
    slowest: Mutex<(u128, u64)>,
    /// How many could be loaded, and how many faults were told.
    loaded: AtomicU64,
    told: AtomicU64,
}

impl Run {
    /// Tries mutants until none is left.
    fn work(&self, worker: usize) {
        loop {
            let from = self.next.fetch_add(PER_THREAD, Ordering::Relaxed);
            if from >= self.end {
                break;
            }
            let to = (from + PER_THREAD).min(self.end);
            let name = format!("mutants {from} to {}", to - 1);
            std::thread::scope(|scope| {
                let work = || (from..to).for_each(|number| self.attempt(worker, number));
                let thread = std::thread::Builder::new().name(name).stack_size(STACK).spawn_scoped(scope, work);
                thread.expect("a thread").join().expect("panics are caught");
            });
        }
        self.trying[worker].store(u64::MAX, Ordering::Relaxed);
    }

    #[expect(clippy::disallowed_methods, reason = "a clock tells what is slow, and decides nothing")]
    fn attempt(&self, worker: usize, number: u64) {
        self.trying[worker].store(number, Ordering::Relaxed);
        let mut draws = Draws::of(number);
        let text = mutant(&mut draws, &self.stock);
        let start = std::time::Instant::now();
        let outcome = catch_unwind(AssertUnwindSafe(|| self.world.try_rule(&text, &mut draws)));
        let milliseconds = start.elapsed().as_millis();
        {
            let mut slowest = self.slowest.lock().expect("no panic in here");
            *slowest = (*slowest).max((milliseconds, number));
        }
        let wrong = match outcome {
            Ok(Ok(tried)) => {
                self.loaded.fetch_add(u64::from(tried.is_loaded), Ordering::Relaxed);
                self.told.fetch_add(tried.faults, Ordering::Relaxed);
                return;
            }
            Ok(Err(wrong)) => wrong,
            Err(panic) => {
                let text = panic.downcast_ref::<String>().cloned();
                format!("panic: {}", text.or(panic.downcast_ref::<&str>().map(|t| (*t).to_owned())).unwrap_or_default())
            }
        };
        let failure = format!("mutant {number}: {wrong}\n--- its text\n{text}\n---\n");
        self.failures.lock().expect("no panic in here").push(failure);
    }

    /// Ends the process when a mutant hangs: nothing else can.
    fn watch(&self, is_over: &AtomicBool) {
        let mut seen = [(u64::MAX, 0); WORKERS];
        while !is_over.load(Ordering::Relaxed) {
            std::thread::sleep(Duration::from_millis(250));
            for (trying, seen) in self.trying.iter().zip(&mut seen) {
                let number = trying.load(Ordering::Relaxed);
                *seen = if seen.0 == number { (number, seen.1 + 1) } else { (number, 0) };
                if number != u64::MAX && seen.1 >= 4 * MOST_SECONDS {
                    let text = mutant(&mut Draws::of(number), &self.stock);
                    let told =
                        format!("mutant {number} takes longer than {MOST_SECONDS} s\n--- its text\n{text}\n---\n");
                    // What tests print is shown at their end, which this one does not reach.
                    let _ = std::io::stderr().write_all(told.as_bytes());
                    std::process::exit(1);
                }
            }
        }
    }
}

/// The most memory that this process ever had, in KiB, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?.trim().strip_suffix("kB")?.trim().parse().ok()
}

#[test]
fn whatever_is_written_is_a_rule_or_a_fault() {
    let from = number_of("PLAT_FUZZ_FROM", 0);
    let end = from + number_of("PLAT_FUZZ_MUTANTS", 700);
    let run = Run {
        stock: Stock::new(),
        world: World::new(),
        next: AtomicU64::new(from),
        end,
        trying: [const { AtomicU64::new(u64::MAX) }; WORKERS],
        failures: Mutex::default(),
        slowest: Mutex::default(),
        loaded: AtomicU64::default(),
        told: AtomicU64::default(),
    };
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| run.watch(&is_over));
        let workers: Vec<_> = (0..WORKERS)
            .map(|worker| {
                scope.spawn({
                    let run = &run;
                    move || run.work(worker)
                })
            })
            .collect();
        workers.into_iter().for_each(|worker| worker.join().expect("panics are caught"));
        is_over.store(true, Ordering::Relaxed);
    });
    let (milliseconds, slowest) = *run.slowest.lock().expect("no panic in here");
    let (loaded, told) = (run.loaded.into_inner(), run.told.into_inner());
    println!("mutants {from} to {}: {loaded} loaded, {told} faults told", end - 1);
    println!("the slowest was {slowest} with {milliseconds} ms");
    let memory = peak_memory();
    match memory {
        Some(kib) => println!("at most {} MiB of memory", kib >> 10),
        None => println!("this system does not tell how much memory was taken: that was not tested"),
    }
    let failures = run.failures.into_inner().expect("no panic in here");
    let heads = failures.iter().filter_map(|failure| failure.lines().next()).collect::<Vec<_>>().join("\n");
    let shown = failures.iter().take(MOST_SHOWN).cloned().collect::<String>();
    assert!(failures.is_empty(), "{} failures\n{heads}\nsuch as\n{shown}", failures.len());
    assert!(memory.is_none_or(|kib| kib < MOST_MEMORY_KIB), "{memory:?} KiB of memory");
    // Of a few mutants none may load.
    assert!(
        end - from < 200 || loaded * 10 > end - from,
        "too few mutants can be loaded to test what they do: {loaded}"
    );
}
