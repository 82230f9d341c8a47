//! Runs the tests of rules: finds them, builds their towns, holds their snapshots against files.

mod laboratory;
mod picture;
mod snapshots;
mod town;

pub use picture::picture;
pub use snapshots::{Compared, Standing, accept};

use crate::Built;
use crate::check::{is_city, name_of, root_of, rule_folder, scripts_below};
use crate::load::{LoadError, MapFolders, RuleFolder};
use laboratory::CityLaboratory;
use script::testing::{Bench, Coverage, Outcome, Test, TestFile, Town, Trial, is_beside};
use script::{Fault, Host, Library, Source, Texts};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use town::GrownTown;

/// Which tests to run, and how.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Tests whose name holds this; all when none.
    pub only: Option<String>,
    /// Trials of each random test.
    pub trials: u64,
    /// The trial to run instead.
    pub trial: Option<Trial>,
    /// A folder of rules that is asked after the file's own and before the library.
    pub rules: Option<PathBuf>,
    /// Threads; all processors when 0.
    pub threads: usize,
    /// Counts the branches of rules that tests reach.
    pub coverage: Option<Coverage>,
}

impl Default for Settings {
    fn default() -> Self {
        Self { only: None, trials: 20, trial: None, rules: None, threads: 0, coverage: None }
    }
}

/// Scripts with tests, ready to run.
#[derive(Debug, Default)]
pub struct Suite {
    files: Vec<(PathBuf, TestFile)>,
    /// What is wrong in scripts whose tests cannot be run.
    pub faults: Vec<Fault>,
    /// The texts of the scripts.
    pub texts: Texts,
}

/// A test that was run.
#[derive(Clone, Debug)]
pub struct Ran {
    /// The rule it is about.
    pub rule: String,
    /// Its name, without `test_`.
    pub test: String,
    /// The file it stands in.
    pub path: PathBuf,
    /// The line it begins in.
    pub line: u32,
    /// What was wrong; none where every claim held.
    pub fault: Option<Fault>,
    /// The simplest trial found that fails, or the one that was asked for.
    pub trial: Option<Trial>,
    /// Its snapshots, held against files.
    pub snapshots: Vec<Compared>,
    /// What it printed.
    pub printed: Vec<String>,
}

impl Ran {
    /// Whether every claim held and every snapshot is as it was accepted.
    pub fn has_passed(&self) -> bool {
        self.fault.is_none() && self.snapshots.iter().all(|snapshot| snapshot.standing == Standing::Same)
    }
}

impl Suite {
    /// Finds the tests in a rule, in the file beside it, or in all scripts below a folder.
    ///
    /// # Errors
    /// [`LoadError`] when there is no such file or folder, or it cannot be read.
    pub fn find(paths: &[PathBuf], settings: &Settings) -> Result<Self, LoadError> {
        let mut suite = Self::default();
        let mut scripts = Vec::new();
        for path in paths {
            scripts.extend(scripts_below(path)?);
            let beside = path.with_extension("test.rhai");
            if path.is_file() && beside.is_file() {
                scripts.extend(scripts_below(&beside)?);
            }
        }
        scripts.sort();
        scripts.dedup();
        for (path, text) in scripts {
            if !is_city(&path, &text) {
                suite.add(path, text, settings)?;
            }
        }
        Ok(suite)
    }

    fn add(&mut self, path: PathBuf, text: String, settings: &Settings) -> Result<(), LoadError> {
        let root = root_of(&path);
        let own: Arc<dyn Library> = Arc::new(RuleFolder(root));
        let given = settings.rules.as_deref().map(rule_folder).transpose()?;
        let host = Host::new(std::iter::once(own).chain(given).collect());
        let host = settings.coverage.as_ref().map_or(host.clone(), |coverage| host.counting(coverage));
        self.add_script(&host, path, text);
        Ok(())
    }

    /// Adds the tests of one script, whose rules a host finds.
    pub fn add_script(&mut self, host: &Host, path: PathBuf, text: String) {
        let folder = path.parent().map_or_else(|| PathBuf::from("."), Path::to_path_buf);
        let bench = bench_in(folder);
        let source = Source { text, path: path.display().to_string() };
        let name = name_of(&path);
        match host.tests_of(&name, &source, bench) {
            Ok(file) if !file.tests().is_empty() => self.files.push((path, file)),
            Ok(_) => {}
            Err(faults) => self.faults.extend(faults),
        }
        self.texts.keep_all(host.texts());
    }

    /// The rule files that tests are about, each once, with what messages call them.
    pub fn rules(&self) -> Vec<(String, String)> {
        let mut found: Vec<(String, String)> = self
            .files
            .iter()
            .map(|(path, file)| {
                let beside = path.file_name().unwrap_or_default().to_string_lossy().replace(".test.rhai", ".rhai");
                (file.rule().to_owned(), path.with_file_name(beside).display().to_string())
            })
            .collect();
        found.sort();
        found.dedup();
        found
    }

    /// How many tests there are.
    pub fn len(&self) -> usize {
        self.files.iter().map(|(_, file)| file.tests().len()).sum()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.files.is_empty()
    }

    /// Runs them, many at once; what comes out is in the order of files and tests.
    ///
    /// # Errors
    /// When no threads can be started.
    pub fn run(&self, settings: &Settings) -> io::Result<Vec<Ran>> {
        let is_wanted = |test: &&Test| settings.only.as_ref().is_none_or(|only| test.name.contains(only.as_str()));
        let wanted: Vec<(&PathBuf, &TestFile, &Test)> = self
            .files
            .iter()
            .flat_map(|(path, file)| file.tests().iter().filter(is_wanted).map(move |test| (path, file, test)))
            .collect();
        let ran = side_by_side(settings.threads, &wanted, |(path, file, test)| run(path, file, test, settings))?;
        // Rules are read when tests ask for them, under the names that faults give.
        self.files.iter().for_each(|(_, file)| self.texts.keep_all(file.texts()));
        Ok(ran)
    }

    /// Snapshots beside these files that belong to no test of theirs any more. Where a test failed, nobody knows which it
    /// would have taken: then none of its file's.
    pub fn stale(&self, ran: &[Ran]) -> Vec<PathBuf> {
        let has_failed = |path: &PathBuf| ran.iter().any(|ran| ran.path == *path && ran.fault.is_some());
        let whole = self.files.iter().map(|(path, _)| path).filter(|path| !has_failed(path));
        whole.flat_map(|path| snapshots::stale(path, ran)).collect()
    }
}

/// What scripts in a folder work with.
pub fn bench_in(folder: PathBuf) -> Bench {
    Bench { laboratory: Arc::new(CityLaboratory { folder: folder.clone() }), sites: Arc::new(MapFolders(folder)) }
}

/// A built city, as tests and consoles ask it.
pub fn town(built: &Built) -> Arc<dyn Town> {
    Arc::new(GrownTown::new(built))
}

/// Stack of a thread that runs tests: what is left of it by a script's limits on depth holds a build.
pub const STACK: usize = 16 << 20;

/// Does a piece of work for each of some things on so many threads (all processors when 0), and gives the results in order.
///
/// These are plain threads: a worker of a pool that waits for a build would take up further work meanwhile, one inside the
/// other, until its stack ends.
///
/// # Errors
/// When no threads can be started.
pub fn side_by_side<T: Sync, R: Send>(
    threads: usize,
    things: &[T],
    work: impl Fn(&T) -> R + Sync,
) -> io::Result<Vec<R>> {
    let all = || thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let threads = if threads == 0 { all() } else { threads };
    let (next, done) = (AtomicUsize::new(0), Mutex::new(Vec::with_capacity(things.len())));
    let toil = || {
        loop {
            let at = next.fetch_add(1, Ordering::Relaxed);
            let Some(thing) = things.get(at) else { break };
            let result = work(thing);
            done.lock().unwrap_or_else(PoisonError::into_inner).push((at, result));
        }
    };
    thread::scope(|scope| {
        for _ in 0..threads.min(things.len()) {
            thread::Builder::new().stack_size(STACK).spawn_scoped(scope, toil)?;
        }
        Ok::<_, io::Error>(())
    })?;
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(at, _)| *at);
    Ok(done.into_iter().map(|(_, result)| result).collect())
}

fn run(path: &Path, file: &TestFile, test: &Test, settings: &Settings) -> Ran {
    let (outcome, trial) = match (test.is_random, &settings.trial) {
        (false, _) => (file.run(test, None), None),
        (true, Some(trial)) => (file.run(test, Some(trial)), Some(trial.clone())),
        (true, None) => run_trials(file, test, settings.trials),
    };
    let compare = |snapshot| snapshots::compare(path, snapshot);
    Ran {
        rule: file.rule().to_owned(),
        test: test.name.clone(),
        path: path.to_path_buf(),
        line: test.line,
        fault: outcome.fault,
        trial,
        snapshots: outcome.snapshots.into_iter().map(compare).collect(),
        printed: outcome.printed,
    }
}

/// Runs of a test in search of a simpler trial that fails.
const MOST_SIMPLER: usize = 200;

/// Runs a random test for some trials; of the first that fails the simplest one found.
fn run_trials(file: &TestFile, test: &Test, trials: u64) -> (Outcome, Option<Trial>) {
    let mut last = Outcome::default();
    for ordinal in 0..trials {
        let trial = Trial::random(&test.name, ordinal);
        last = file.run(test, Some(&trial));
        if last.fault.is_some() {
            return simplest(file, test, trial, last);
        }
    }
    (last, None)
}

fn simplest(file: &TestFile, test: &Test, mut trial: Trial, mut outcome: Outcome) -> (Outcome, Option<Trial>) {
    let mut left = MOST_SIMPLER;
    'search: loop {
        for simpler in trial.simpler(&outcome.drawn) {
            if left == 0 {
                break 'search;
            }
            left -= 1;
            let other = file.run(test, Some(&simpler));
            if other.fault.is_some() {
                (trial, outcome) = (simpler, other);
                continue 'search;
            }
        }
        break;
    }
    (outcome, Some(trial))
}

/// Whether a file holds nothing but tests of the rule beside it.
pub(crate) fn is_tests(path: &Path) -> bool {
    path.file_stem().is_some_and(|stem| is_beside(&stem.to_string_lossy()))
}
