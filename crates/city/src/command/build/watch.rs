//! `plat build --watch`.

use super::{Bars, BuildArguments, Failure, Status, built, cache_of, loaded, sources, tell, tell_problems, write};
use city::watch::WatchError;
use city::{Cache, Cancel, Loaded, Watch, export};
use geom::Id;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Builds a city, and again after each change to what it is made from.
pub fn run(arguments: &BuildArguments) -> Result<Status, Failure> {
    let ignored: Vec<PathBuf> = std::iter::once(arguments.out.clone()).chain(arguments.cache.clone()).collect();
    let mut watch = Watch::new(&ignored).map_err(unwatched)?;
    let mut session = Session {
        arguments,
        cache: cache_for(arguments)?,
        bars: Bars::new(arguments.quiet || arguments.json),
        interrupt: Interrupt::of(&watch),
        last: None,
        is_good: false,
    };
    let is_new = !arguments.out.exists();
    let outcome = session.follow(&mut watch);
    if session.last.is_none() && is_new {
        // The folder was made to find out whether it can be; it is empty, or it stays.
        let _ = std::fs::remove_dir(&arguments.out);
    }
    session.cache.flush();
    outcome.map(|()| Status::Done)
}

fn unwatched(error: WatchError) -> Failure {
    Failure::new(Status::Failed, error.to_string())
}

/// The cache asked for; where none is, that of the user.
fn cache_for(arguments: &BuildArguments) -> Result<Cache, Failure> {
    if arguments.cache.is_some() {
        return cache_of(arguments);
    }
    Ok(if arguments.no_cache { Cache::in_memory() } else { usual_cache(arguments) })
}

/// In the user's cache folder, where there is one that can be written to; else in memory.
fn usual_cache(arguments: &BuildArguments) -> Cache {
    let open = |folder: PathBuf| {
        Cache::on_disk(&folder.join("plat"), arguments.cache_limit << 20)
            .map_err(|error| eprintln!("   warning  nothing is kept in {}: {error}", folder.display()))
            .ok()
    };
    dirs::cache_dir().and_then(open).unwrap_or_else(Cache::in_memory)
}

/// Ctrl-C: ends the build under way and the watch; a second one ends the process at once.
struct Interrupt {
    building: Arc<Mutex<Option<Cancel>>>,
}

impl Interrupt {
    fn of(watch: &Watch) -> Self {
        let building: Arc<Mutex<Option<Cancel>>> = Arc::default();
        let (own, stop, asked) = (building.clone(), watch.stopper(), Cancel::default());
        let handler = move || {
            if asked.is_cancelled() {
                std::process::exit(Status::Interrupted as i32);
            }
            asked.cancel();
            if let Some(building) = &*own.lock().unwrap_or_else(PoisonError::into_inner) {
                building.cancel();
            }
            stop();
        };
        // Only fails when a handler is there already, and there is one command a process.
        let _ = ctrlc::set_handler(handler);
        Self { building }
    }

    fn ends(&self, building: &Cancel) {
        *self.building.lock().unwrap_or_else(PoisonError::into_inner) = Some(building.clone());
    }
}

/// What is kept from one build to the next.
struct Session<'a> {
    arguments: &'a BuildArguments,
    cache: Cache,
    bars: Bars,
    interrupt: Interrupt,
    /// What the files were written from last.
    last: Option<Id>,
    /// Whether they show a city without faults.
    is_good: bool,
}

impl Session<'_> {
    /// Builds, and again after each change, until it is stopped.
    fn follow(&mut self, watch: &mut Watch) -> Result<(), Failure> {
        // Heard of before anything is read, so that no change is lost.
        watch.follow(&self.folders(&[])).map_err(unwatched)?;
        let mut is_first = true;
        loop {
            let (round, folders) = self.round(watch);
            self.bars.clear();
            match round {
                // What is wrong with the command line no change of a file mends.
                Err(failure) if is_first && failure.status() == Status::Usage => return Err(failure),
                // Given up for a change, which comes next, or for good.
                Err(failure) if failure.status() == Status::Interrupted => {}
                Err(failure) => drop(failure.tell(self.arguments.json)),
                Ok(()) => {}
            }
            is_first = false;
            tell_problems(&self.cache);
            watch.follow(&self.folders(&folders)).map_err(unwatched)?;
            let Some(changed) = watch.wait() else { return Ok(()) };
            let names: Vec<_> = changed.iter().filter_map(|path| Some(path.file_name()?.to_string_lossy())).collect();
            let more = if names.len() > 3 { ", …" } else { "" };
            self.say(&format!("   changed  {}{more}", names[..names.len().min(3)].join(", ")));
        }
    }

    /// The folders to watch: those that the city told last, or that it stands in.
    fn folders(&self, told: &[PathBuf]) -> Vec<PathBuf> {
        let city = &self.arguments.city;
        let own = if city.is_dir() { city.as_path() } else { city.parent().unwrap_or(Path::new(".")) };
        let own = if own.as_os_str().is_empty() { Path::new(".") } else { own };
        told.iter().cloned().chain([own.to_owned()]).chain(self.arguments.rules.clone()).collect()
    }

    /// Tells people how far it is.
    fn say(&self, line: &str) {
        if !self.arguments.quiet && !self.arguments.json {
            eprintln!("{line}");
        }
    }

    /// Reads, builds and writes once, unless nothing is new; and tells which folders the city is made from.
    fn round(&mut self, watch: &Watch) -> (Result<(), Failure>, Vec<PathBuf>) {
        #[expect(clippy::disallowed_methods, reason = "told to people, no part of the city")]
        let begin = Instant::now();
        match loaded(self.arguments) {
            Ok(loaded) => (self.build(&loaded, watch, begin), loaded.folders()),
            Err(failure) => (Err(failure), Vec::new()),
        }
    }

    fn build(&mut self, loaded: &Loaded, watch: &Watch, begin: Instant) -> Result<(), Failure> {
        let arguments = self.arguments;
        let prepared = export::prepare(&arguments.out);
        prepared.map_err(|error| Failure::new(Status::Failed, error.to_string()))?;
        let sources = sources(arguments, loaded, &self.cache)?;
        let digest = sources.digest(&self.cache);
        if self.last == Some(digest) {
            self.say("      same  as what is written");
            return Ok(());
        }
        let cancel = Cancel::default();
        self.interrupt.ends(&cancel);
        let (cache, bars) = (&self.cache, &self.bars);
        let written = watch.during(&cancel, || {
            let built = built(arguments, &sources, cache, bars, &cancel)?;
            if built.report.has_faults() && self.is_good {
                let faults = built.report.faults;
                return Err(Failure::of_scripts(Status::Faults, faults, loaded.texts.clone()));
            }
            write(arguments, &built, cache, bars, &cancel)
        })?;
        self.last = Some(digest);
        self.is_good = !written.report.has_faults();
        tell(arguments, &written, &loaded.texts);
        let seconds = begin.elapsed().as_secs_f64();
        self.say(&format!("     built  in {seconds:.1} s; watching for changes, Ctrl-C ends"));
        Ok(())
    }
}
