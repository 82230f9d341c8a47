//! `plat build`.

mod watch;

use super::bars::Bars;
use super::{BuildArguments, Failure, Status, faults};
use city::export::{ColourBy, MapOptions, Mark};
use city::progress::{Progress, Stage};
use city::why::{Answer, WhyError, explain, find, on_site};
use city::{
    BuildError, Built, BuiltFrom, Cache, Cancel, Changes, City, FaultReport, LoadError, Loaded, MarkReport,
    PresetError, Report, Settings, Sources, Trace, build_with, export, load, with_threads,
};
use geom::Vec2;
use script::{Fault, Texts};
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// Builds a city and writes it.
pub fn run(arguments: &BuildArguments) -> Result<Status, Failure> {
    if arguments.watch {
        return watch::run(arguments);
    }
    let cache = cache_of(arguments)?;
    let bars = Bars::new(arguments.quiet || arguments.json);
    let is_new = !arguments.out.exists();
    let outcome = build_and_write(arguments, &cache, &bars);
    if outcome.is_err() && is_new {
        // The folder was made to find out whether it can be; it is empty, or it stays.
        let _ = std::fs::remove_dir(&arguments.out);
    }
    bars.clear();
    cache.flush();
    tell_problems(&cache);
    outcome.map(|(written, texts)| tell(arguments, &written, &texts))
}

/// The cache that a command line asks for.
fn cache_of(arguments: &BuildArguments) -> Result<Cache, Failure> {
    let open = |folder: &Path| {
        Cache::on_disk(folder, arguments.cache_limit << 20).map_err(|error| {
            let hint = "hint: name another folder with --cache";
            Failure::new(Status::Failed, format!("{}: {error}\n  {hint}", folder.display()))
        })
    };
    arguments.cache.as_deref().map_or_else(|| Ok(Cache::none()), open)
}

/// Tells what went wrong in a cache; the build did without.
fn tell_problems(cache: &Cache) {
    cache.problems().iter().take(1).for_each(|problem| eprintln!("   warning  {problem}"));
}

/// Why a city could not be read, as a failure.
pub fn unreadable(error: LoadError) -> Failure {
    match error {
        LoadError::Missing { .. } => Failure::new(Status::Usage, error.to_string()),
        LoadError::Scripts { faults, texts } => {
            Failure::of_scripts(Status::Failed, faults.iter().map(FaultReport::from).collect(), texts)
        }
        other => Failure::new(Status::Failed, other.to_string()),
    }
}

/// What was written, and what there is to say about it.
struct Written {
    report: Report,
    files: Vec<PathBuf>,
}

fn build_and_write(arguments: &BuildArguments, cache: &Cache, bars: &Bars) -> Result<(Written, Texts), Failure> {
    let cancel = stop_on_interrupt();
    let loaded = loaded(arguments)?;
    tell_loaded(arguments, &loaded);
    export::prepare(&arguments.out).map_err(|error| failed(&error))?;
    let sources = sources(arguments, &loaded, cache)?;
    let built = built(arguments, &sources, cache, bars, &cancel).map_err(|error| unbuilt(error, &loaded))?;
    let written = write(arguments, &built, cache, bars, &cancel)?;
    if let Some(id) = &arguments.trace {
        print!("{}", traced(id, &arguments.out, &sources, &built)?);
    }
    Ok((written, loaded.texts))
}

/// What the city's script printed, and whether changes were laid over it.
fn tell_loaded(arguments: &BuildArguments, loaded: &Loaded) {
    loaded.printed.iter().for_each(|line| eprintln!("{line}"));
    if !loaded.changes.is_empty() && !arguments.quiet && !arguments.json {
        let file = Changes::file_of(&loaded.script);
        let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        eprintln!("     script  {} changes of {name} laid over it", loaded.changes.len());
    }
}

fn failed(error: &dyn std::fmt::Display) -> Failure {
    Failure::new(Status::Failed, error.to_string())
}

/// The city's script, with what the command line changes.
fn loaded(arguments: &BuildArguments) -> Result<Loaded, Failure> {
    let mut loaded = load(&arguments.city, arguments.rules.as_deref()).map_err(unreadable)?;
    lay_presets(&mut loaded, &arguments.preset)?;
    set_all(&mut loaded, &arguments.set)?;
    if let Some(seed) = arguments.seed {
        loaded.plan.seed = seed;
    }
    Ok(loaded)
}

/// Why maps and streets cannot be read, as a failure: the command line is to blame where it is well without what that changes.
fn unread(arguments: &BuildArguments, loaded: &Loaded, error: LoadError) -> Failure {
    let preset = arguments.preset.iter().map(|preset| format!("--preset {preset}"));
    let changes: Vec<String> = preset.chain(arguments.set.iter().map(|set| format!("--set {set}"))).collect();
    let LoadError::Value { error: value, .. } = &error else { return unreadable(error) };
    let plain = || load(&loaded.script, arguments.rules.as_deref()).and_then(|loaded| loaded.read()).is_ok();
    if changes.is_empty() || !plain() {
        let fault = FaultReport::from(&loaded.value_fault(value));
        return Failure::of_scripts(Status::Failed, vec![fault], loaded.texts.clone());
    }
    Failure::new(Status::Usage, format!("{}: {}", changes.join(" "), param(value)))
}

/// The maps and streets that it names.
fn sources(arguments: &BuildArguments, loaded: &Loaded, cache: &Cache) -> Result<Sources, Failure> {
    let sources = loaded.read_with(cache).map_err(|error| unread(arguments, loaded, error))?;
    check_colours(arguments, &sources)?;
    warn_of_size(arguments, &sources);
    Ok(sources)
}

fn built(
    arguments: &BuildArguments,
    sources: &Sources,
    cache: &Cache,
    bars: &Bars,
    cancel: &Cancel,
) -> Result<Built, BuildError> {
    let settings = Settings {
        threads: usize::from(arguments.threads),
        until: arguments.until,
        traces: !arguments.steps.is_empty() || arguments.trace.is_some(),
        within: None,
    };
    build_with(sources, settings, cache, bars, cancel)
}

/// Why there is no city, as a failure: what went wrong in rules with its place, and then what that led to.
fn unbuilt(error: BuildError, loaded: &Loaded) -> Failure {
    let faults = match &error {
        BuildError::Cancelled => return Failure::new(Status::Interrupted, error.to_string()),
        BuildError::Fault(fault) => vec![FaultReport::from(&**fault)],
        BuildError::Nothing { faults, reason, hint } if !faults.is_empty() => {
            let message = format!("there is nothing to build: {reason}");
            let led_to = Fault::new(loaded.script.display().to_string(), message).with_hint(Some(hint.clone()));
            faults.iter().map(FaultReport::from).chain([FaultReport::from(&led_to)]).collect()
        }
        BuildError::Nothing { .. } | BuildError::Threads(_) => return failed(&error),
    };
    Failure::of_scripts(Status::Failed, faults, loaded.texts.clone())
}

/// Writes a city, its report and what else the command line asks for.
fn write(
    arguments: &BuildArguments,
    built: &Built,
    cache: &Cache,
    bars: &Bars,
    cancel: &Cancel,
) -> Result<Written, Failure> {
    let city = &built.city;
    bars.begin(Stage::Export, 0);
    let report = Report { built_from: Some(built_from(arguments)), ..built.report.clone() };
    let mut json = serde_json::to_vec_pretty(&report).map_err(|error| failed(&error))?;
    json.push(b'\n');
    if arguments.colour_by == Some(ColourBy::District) && city.districts.is_empty() && !arguments.quiet {
        eprintln!("   warning  the city has no districts to colour by: all streets are grey");
    }
    let of_rules = spread(&report.marks, MOST_RULE_MARKS).map(mark_of_rule);
    let marks = report.faults.iter().filter_map(mark_of).take(MOST_MARKS).chain(of_rules).collect();
    let map = MapOptions { colour_by: arguments.colour_by, marks, ..MapOptions::default() };
    let trace = built.trace.as_ref().filter(|_| !arguments.steps.is_empty());
    let steps =
        trace.map_or(Ok(Vec::new()), |trace| steps(arguments, city, trace, &map)).map_err(|error| failed(&error))?;
    let others: Vec<(&str, &[u8])> = std::iter::once((export::REPORT, &json[..]))
        .chain(steps.iter().map(|(name, content)| (&name[..], &content[..])))
        .collect();
    // The watch soon writes them again, and its user waits to see them.
    let is_durable = !arguments.watch;
    let wanted = export::Wanted { map: &map, formats: &export::Format::ALL, others: &others, cache, is_durable };
    let files =
        with_threads(usize::from(arguments.threads), || export::write_wanted(city, &wanted, &arguments.out, cancel));
    let files = files.map_err(|error| failed(&error))?.map_err(|error| match error.problem {
        export::Problem::Cancelled => Failure::new(Status::Interrupted, BuildError::Cancelled.to_string()),
        _ => failed(&error),
    })?;
    let names: Vec<_> =
        files.iter().filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned())).collect();
    bars.end(Stage::Export, &format!("{} in {}", names.join(", "), arguments.out.display()));
    Ok(Written { report, files })
}

/// Says step by step how something of the city just written came to be, by the first digits of its id.
fn traced(id: &str, folder: &Path, sources: &Sources, built: &Built) -> Result<Answer, Failure> {
    let layout =
        export::read_layout(&folder.join(export::Format::Layout.file_name())).map_err(|error| failed(&error))?;
    let unknown = |error: WhyError| Failure::new(Status::Usage, error.to_string());
    let found = find(&layout, id).map_err(unknown)?;
    on_site(&found, sources).map_err(unknown)?;
    Ok(explain(&found, &layout, sources, built))
}

/// Most places of faults that a map shows.
const MOST_MARKS: usize = 50;

/// Where on the map a fault happened, with its line.
fn mark_of(fault: &FaultReport) -> Option<Mark> {
    let [x, y] = fault.place?;
    let file = fault.file.rsplit(['/', '\\']).next().unwrap_or(&fault.file);
    Some(Mark { at: Vec2::new(x, y), words: format!("{file}:{}", fault.line) })
}

/// Some of a list, as many from each part of it.
fn spread<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    let count = all.len().min(most);
    (0..count).map(move |i| &all[i * all.len() / count])
}

/// Most places marked by rules that a map shows.
const MOST_RULE_MARKS: usize = 200;

/// A place that a rule marked, with the rule's name.
fn mark_of_rule(mark: &MarkReport) -> Mark {
    let file = mark.rule.rsplit(['/', '\\']).next().unwrap_or(&mark.rule);
    Mark { at: Vec2::from_array(mark.place), words: file.trim_end_matches(".rhai").to_owned() }
}

/// A city as others can find it: one that is named by where the command was run, such as `.`, by its folder's name.
fn named(city: &Path) -> PathBuf {
    let is_told = city.components().any(|part| matches!(part, Component::Normal(_)));
    let whole = || city.canonicalize().ok()?.file_name().map(PathBuf::from);
    if is_told { city.to_path_buf() } else { whole().unwrap_or_else(|| city.to_path_buf()) }
}

/// What is remembered of the command line, to build the same city again.
fn built_from(arguments: &BuildArguments) -> BuiltFrom {
    BuiltFrom {
        city: named(&arguments.city).display().to_string(),
        rules: arguments.rules.as_deref().map(|rules| rules.display().to_string()),
        presets: arguments.preset.clone(),
        set: arguments.set.clone(),
    }
}

/// Lays presets that a command line names on a city, one after the other.
pub fn lay_presets(loaded: &mut Loaded, presets: &[String]) -> Result<(), Failure> {
    let mut faults: Vec<FaultReport> = Vec::new();
    for assignment in presets {
        match loaded.lay(assignment) {
            Ok(()) => {}
            // A preset that is there, but wrong, is shown in its file.
            Err(PresetError::Preset(wrong)) if wrong.iter().any(|fault| fault.line > 0) => {
                faults.extend(wrong.iter().map(FaultReport::from));
            }
            Err(other) => return Err(Failure::new(Status::Usage, format!("--preset {assignment}: {other}"))),
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(Failure::of_scripts(Status::Failed, faults, loaded.texts.clone())) }
}

/// Sets values that a command line names; all that are wrong are told.
pub fn set_all(loaded: &mut Loaded, set: &[String]) -> Result<(), Failure> {
    let wrong: Vec<String> = set
        .iter()
        .filter_map(|assignment| Some(format!("--set {assignment}: {}", param(&loaded.set(assignment).err()?))))
        .collect();
    if wrong.is_empty() { Ok(()) } else { Err(Failure::new(Status::Usage, wrong.join("\n"))) }
}

/// A parameter's error with its hint.
pub fn param(error: &script::ParamError) -> String {
    let hint = error.hint.as_ref().map_or(String::new(), |hint| format!("\n  hint: {hint}"));
    format!("{}{hint}", error.message)
}

/// Land in km² from which a build takes hours and tens of gigabytes.
const LARGE_KM2: f64 = 1000.0;

/// Says so before a build takes very long.
fn warn_of_size(arguments: &BuildArguments, sources: &Sources) {
    let km2 = sources.growing_km2();
    if km2 > LARGE_KM2 && !arguments.quiet {
        eprintln!("   warning  streets grow on {km2:.0} km²: this may take hours and tens of gigabytes of memory");
        eprintln!(
            "  hint: sizes of sites are in metres; `within` names a mask of what to build, --until streets stops early"
        );
    }
}

/// Refuses colours by a map that the site does not have, before anything is built.
fn check_colours(arguments: &BuildArguments, sources: &Sources) -> Result<(), Failure> {
    let Some(name) = arguments.colour_by.and_then(ColourBy::map) else { return Ok(()) };
    if sources.site.map(name).is_some() {
        return Ok(());
    }
    let message = format!(
        "--colour-by: the site has no map `{name}` to colour by\n  hint: add {name}.png with {name}.json to its maps, or \
         colour by rule, class or district"
    );
    Err(Failure::new(Status::Usage, message))
}

/// The maps after the steps asked for.
fn steps(
    arguments: &BuildArguments,
    city: &City,
    trace: &Trace,
    map: &MapOptions,
) -> Result<Vec<(String, Vec<u8>)>, export::map::MapError> {
    let wanted: BTreeSet<u32> = arguments.steps.iter().copied().collect();
    let last = trace.last_step();
    if !arguments.quiet {
        let stages: Vec<String> = trace
            .stages()
            .filter(|(_, stage)| stage.last_step() > 0)
            .map(|(start, stage)| format!("{} in steps {} to {}", stage.name, start + 1, start + stage.last_step()))
            .collect();
        eprintln!("     steps  {}", if stages.is_empty() { "nothing grew".into() } else { stages.join(", ") });
        for step in wanted.iter().filter(|step| **step > last) {
            eprintln!("   warning  growth ended with step {last}: step {step} shows all that grew");
        }
    }
    let maps = wanted.into_iter().map(|step| export::steps::step_maps(city, trace, step, map));
    Ok(maps.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
}

/// Ctrl-C asks the build to stop; a second one ends the process at once.
fn stop_on_interrupt() -> Cancel {
    let cancel = Cancel::default();
    let asked = cancel.clone();
    let handler = move || {
        if asked.is_cancelled() {
            std::process::exit(Status::Interrupted as i32);
        }
        asked.cancel();
    };
    // Only fails when a handler is there already, and there is one command a process.
    let _ = ctrlc::set_handler(handler);
    cancel
}

/// Says what was written and what is odd about it.
fn tell(arguments: &BuildArguments, Written { report, files }: &Written, texts: &Texts) -> Status {
    if arguments.json {
        let files: Vec<_> = files.iter().map(|path| path.display().to_string()).collect();
        let value = serde_json::json!({ "report": report, "files": files });
        println!("{value}");
    }
    for warning in report.warnings.iter().take(20).filter(|_| !arguments.quiet) {
        eprintln!("   warning  {warning}");
    }
    for print in report.prints.iter().take(20).filter(|_| !arguments.quiet) {
        eprintln!("   print    {print}");
    }
    let more = report.prints.len().saturating_sub(20);
    if more > 0 && !arguments.quiet {
        eprintln!("   print    and {more} more texts: they stand in report.json");
    }
    if !report.marks.is_empty() && !arguments.quiet {
        let shown = report.marks.len().min(MOST_RULE_MARKS);
        let most = if shown < report.marks.len() { format!("; the map shows {shown} of them") } else { String::new() };
        eprintln!("   mark     {} places, in report.json and on the map{most}", report.marks.len());
    }
    faults::tell(&report.faults, texts);
    if report.has_faults() { Status::Faults } else { Status::Done }
}
