//! `plat build --watch`.

use super::{
    Bars, BuildArguments, Failure, Status, Written, built, cache_of, loaded, sources, tell, tell_loaded, tell_problems,
    unbuilt, write,
};
use city::watch::WatchError;
use city::{Cache, Cancel, Loaded, Watch, export};
use geom::Id;
use script::Texts;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Builds a city, and again after each change to what it is made from.
pub fn run(arguments: &BuildArguments) -> Result<Status, Failure> {
    let kept_in = arguments.cache.clone().or_else(usual_folder);
    let results: Vec<PathBuf> = std::iter::once(arguments.out.clone()).chain(kept_in).collect();
    let mut watch = Watch::new(&results).map_err(unwatched)?;
    let mut session = Session {
        arguments,
        folders: always_watched(arguments).collect(),
        cache: cache_for(arguments)?,
        bars: Bars::new(arguments.quiet || arguments.json),
        interrupt: Interrupt::of(&watch),
        last: None,
        is_good: shows_good_city(&arguments.out),
    };
    let is_new = !arguments.out.exists();
    let outcome = session.follow(&mut watch);
    if session.last.is_none() && is_new {
        // The folder was made to find out whether it can be; it is empty, or it stays.
        let _ = std::fs::remove_dir(&arguments.out);
    }
    session.cache.flush();
    outcome.map(|()| if session.last.is_some() { Status::Done } else { Status::Interrupted })
}

/// Whether a folder holds a city that was written without faults.
fn shows_good_city(folder: &Path) -> bool {
    let report = std::fs::read(folder.join(export::REPORT)).ok();
    let report: Option<serde_json::Value> = report.and_then(|text| serde_json::from_slice(&text).ok());
    let faults = report.as_ref().and_then(|report| report["faults"].as_array());
    are_there(folder) && faults.is_some_and(|faults| faults.iter().all(|fault| fault["severity"] != "error"))
}

/// Whether all files of a city are there.
fn are_there(folder: &Path) -> bool {
    export::Format::ALL
        .map(export::Format::file_name)
        .into_iter()
        .chain([export::REPORT])
        .all(|name| folder.join(name).is_file())
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
        Cache::on_disk(&folder, arguments.cache_limit << 20)
            .map_err(|error| eprintln!("   warning  nothing is kept in {}: {error}", folder.display()))
            .ok()
    };
    usual_folder().and_then(open).unwrap_or_else(Cache::in_memory)
}

/// Where the user keeps what can be made again.
fn usual_folder() -> Option<PathBuf> {
    Some(dirs::cache_dir()?.join("plat"))
}

/// Ctrl-C: ends the build under way and the watch; a second one ends the process at once.
struct Interrupt {
    building: Arc<Mutex<Option<Cancel>>>,
    asked: Cancel,
}

impl Interrupt {
    fn of(watch: &Watch) -> Self {
        let building: Arc<Mutex<Option<Cancel>>> = Arc::default();
        let (own, stop, asked) = (building.clone(), watch.stopper(), Cancel::default());
        let told = asked.clone();
        let handler = move || {
            if told.is_cancelled() {
                std::process::exit(Status::Interrupted as i32);
            }
            told.cancel();
            if let Some(building) = &*own.lock().unwrap_or_else(PoisonError::into_inner) {
                building.cancel();
            }
            stop();
        };
        // Only fails when a handler is there already, and there is one command a process.
        let _ = ctrlc::set_handler(handler);
        Self { building, asked }
    }

    fn ends(&self, building: &Cancel) {
        *self.building.lock().unwrap_or_else(PoisonError::into_inner) = Some(building.clone());
        // It may have come before there was anything to end.
        if self.asked.is_cancelled() {
            building.cancel();
        }
    }
}

/// The names of files that changed, without those that editors keep beside them.
fn names_of(changed: &BTreeSet<PathBuf>) -> String {
    let names = changed.iter().filter_map(|path| Some((path, path.file_name()?.to_string_lossy().into_owned())));
    let (aside, own): (Vec<_>, Vec<_>) = names.partition(|(path, name)| is_aside(path, name));
    // Where there is nothing else, these are what is told.
    let told = if own.is_empty() { aside } else { own };
    let more = if told.len() > 3 { ", …" } else { "" };
    let first: Vec<String> = told.into_iter().take(3).map(|(_, name)| name).collect();
    format!("{}{more}", first.join(", "))
}

/// Whether a file is an editor's: hidden, a copy from before, or gone again.
fn is_aside(path: &Path, name: &str) -> bool {
    name.starts_with('.') || name.ends_with('~') || !path.exists()
}

/// The folders that the command line tells of.
fn always_watched(arguments: &BuildArguments) -> impl Iterator<Item = PathBuf> {
    let city = arguments.city.as_path();
    // The city may be away for a moment: what it is, is told by its name.
    let is_script = city.is_file() || city.extension().is_some_and(|ending| ending == "rhai");
    let folder = if is_script { city.parent().unwrap_or(Path::new(".")) } else { city };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    std::iter::once(folder.to_owned()).chain(arguments.rules.clone())
}

/// What is kept from one build to the next.
struct Session<'a> {
    arguments: &'a BuildArguments,
    /// What is watched: what the command line and the script told last.
    folders: Vec<PathBuf>,
    cache: Cache,
    bars: Bars,
    interrupt: Interrupt,
    /// What the files were written from last, and what was told of it.
    last: Option<(Id, Written, Texts)>,
    /// Whether they show a city without faults.
    is_good: bool,
}

impl Session<'_> {
    /// Builds, and again after each change, until it is stopped.
    fn follow(&mut self, watch: &mut Watch) -> Result<(), Failure> {
        let mut is_first = true;
        loop {
            let round = self.round(watch);
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
            // Folders that came and went meanwhile are heard of by their new selves.
            watch.follow(&self.folders).map_err(unwatched)?;
            let Some(changed) = watch.wait() else { return Ok(()) };
            self.say(&format!("   changed  {}", names_of(&changed)));
        }
    }

    /// Tells people how far it is.
    fn say(&self, line: &str) {
        if !self.arguments.quiet && !self.arguments.json {
            eprintln!("{line}");
        }
    }

    /// Reads, builds and writes once, unless nothing is new.
    fn round(&mut self, watch: &mut Watch) -> Result<(), Failure> {
        #[expect(clippy::disallowed_methods, reason = "told to people, no part of the city")]
        let begin = Instant::now();
        loop {
            // Heard of before anything is read, so that no change is lost.
            watch.follow(&self.folders).map_err(unwatched)?;
            let loaded = loaded(self.arguments)?;
            let folders: Vec<PathBuf> = always_watched(self.arguments).chain(loaded.folders()).collect();
            if folders == self.folders {
                return self.build(&loaded, watch, begin);
            }
            self.folders = folders;
        }
    }

    fn build(&mut self, loaded: &Loaded, watch: &Watch, begin: Instant) -> Result<(), Failure> {
        let arguments = self.arguments;
        tell_loaded(arguments, loaded);
        let sources = sources(arguments, loaded, &self.cache)?;
        let digest = sources.digest(&self.cache);
        if let Some((last, written, texts)) = &self.last
            && *last == digest
            && are_there(&arguments.out)
        {
            self.say("      same  as what is written");
            if arguments.json {
                // A program that reads on hears that all is well again.
                tell(arguments, written, texts);
            }
            return Ok(());
        }
        let prepared = export::prepare(&arguments.out);
        prepared.map_err(|error| Failure::new(Status::Failed, error.to_string()))?;
        let cancel = Cancel::default();
        self.interrupt.ends(&cancel);
        let (cache, bars) = (&self.cache, &self.bars);
        let written = watch.during(&cancel, || {
            let built = built(arguments, &sources, cache, bars, &cancel).map_err(|error| unbuilt(error, loaded))?;
            if built.report.has_faults() && self.is_good {
                let faults = built.report.faults;
                return Err(Failure::of_scripts(Status::Faults, faults, loaded.texts.clone()));
            }
            write(arguments, &built, cache, bars, &cancel)
        })?;
        self.is_good = !written.report.has_faults();
        tell(arguments, &written, &loaded.texts);
        self.last = Some((digest, written, loaded.texts.clone()));
        let seconds = begin.elapsed().as_secs_f64();
        self.say(&format!("     built  in {seconds:.1} s; watching for changes, Ctrl-C ends"));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn files_of_editors_are_not_told_beside_others() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str| folder.path().join(name);
        for name in ["a.rhai", "a.rhai~", ".a.rhai.swp", "b.rhai", "c.rhai", "d.rhai"] {
            fs::write(file(name), "").unwrap();
        }
        let told = |names: &[&str]| names_of(&names.iter().map(|name| file(name)).collect());
        assert_eq!(told(&["4913", ".a.rhai.swp", "a.rhai", "a.rhai~"]), "a.rhai");
        assert_eq!(told(&["a.rhai", "b.rhai", "c.rhai", "d.rhai"]), "a.rhai, b.rhai, c.rhai, …");
        assert_eq!(told(&[".a.rhai.swp"]), ".a.rhai.swp");
    }
}
