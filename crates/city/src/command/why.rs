//! `plat why`.

use super::{Failure, Status, WhyArguments};
use city::export::{LayoutFile, REPORT, read_layout};
use city::why::{Kind, explain, find, on_site};
use city::{BuiltFrom, Cancel, LoadError, Settings, Silent, Sources, build, load};
use std::path::{Path, PathBuf};

/// Derives the city of a layout once more, and says why something of it is there.
pub fn run(arguments: &WhyArguments) -> Result<Status, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::new(Status::Failed, error.to_string());
    let layout = read_layout(&arguments.layout).map_err(|error| failed(&error))?;
    let found = find(&layout, &arguments.id).map_err(|error| Failure::new(Status::Usage, error.to_string()))?;
    let sources = sources(arguments, &layout)?;
    on_site(&found, &sources).map_err(|error| Failure::new(Status::Usage, error.to_string()))?;
    let traces = found.is_place || is_of_growth(found.kind);
    let settings = Settings { until: found.kind.until(), traces, ..Settings::default() };
    let built = build(&sources, settings, &Silent, &Cancel::default()).map_err(|error| failed(&error))?;
    let answer = explain(&found, &layout, &sources, &built);
    if arguments.json {
        println!("{}", serde_json::to_string(&answer).map_err(|error| failed(&error))?);
    } else {
        print!("{answer}");
    }
    Ok(if answer.differs.is_empty() { Status::Done } else { Status::Faults })
}

fn is_of_growth(kind: Kind) -> bool {
    matches!(kind, Kind::Street | Kind::Crossing | Kind::Quarter | Kind::Place)
}

/// What the layout was built from, as the command line and the report beside it say.
fn sources(arguments: &WhyArguments, layout: &LayoutFile) -> Result<Sources, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::new(Status::Failed, error.to_string());
    let beside = arguments.layout.with_file_name(REPORT);
    let told = built_from(&beside);
    let from_report = |path: &String| found_from(&beside, path);
    let city = arguments.city.clone().or_else(|| told.as_ref().map(|told| from_report(&told.city)));
    let Some(city) = city else {
        let message = format!(
            "{} does not say which city the layout was built from\n  hint: name it: --city scripts/manhattan",
            beside.display()
        );
        return Err(Failure::new(Status::Usage, message));
    };
    let told = told.unwrap_or_default();
    let rules: Option<PathBuf> = arguments.rules.clone().or_else(|| told.rules.as_ref().map(from_report));
    let mut loaded = load(&city, rules.as_deref()).map_err(|error| match error {
        // That a report names a city that is gone is no fault of the command line.
        LoadError::Missing { .. } if arguments.city.is_none() => {
            let message = format!("{error}\n  hint: the report names it: tell where it is now with --city");
            Failure::new(Status::Failed, message)
        }
        LoadError::Missing { .. } => failed(&error),
        other => super::build::unreadable(other),
    })?;
    let presets = if arguments.preset.is_empty() { &told.presets } else { &arguments.preset };
    super::build::lay_presets(&mut loaded, presets)?;
    let set = if arguments.set.is_empty() { &told.set } else { &arguments.set };
    super::build::set_all(&mut loaded, set)?;
    let seed = layout.about.as_ref().and_then(|about| about.seed.as_ref()).and_then(|seed| seed.parse().ok());
    loaded.plan.seed = arguments.seed.or(seed).unwrap_or(loaded.plan.seed);
    loaded.read().map_err(super::build::unreadable)
}

/// What a report says; nothing where there is none, or it is not one.
fn built_from(report: &Path) -> Option<BuiltFrom> {
    let text = std::fs::read_to_string(report).ok()?;
    let value: serde_json::Value = serde_json::from_str(&text).ok()?;
    serde_json::from_value(value.get("built_from")?.clone()).ok()
}

/// A path without detours, from the present folder where it lies below it.
fn plain(path: &Path) -> PathBuf {
    let Ok(whole) = path.canonicalize() else { return path.to_path_buf() };
    let here = std::env::current_dir().and_then(|here| here.canonicalize());
    let below = here.ok().and_then(|here| whole.strip_prefix(here).ok().map(Path::to_path_buf));
    below.filter(|below| !below.as_os_str().is_empty()).unwrap_or(whole)
}

/// A path as it was named on a command line: from the present folder, else from the folder of the report or one of those
/// around it.
fn found_from(report: &Path, path: &str) -> PathBuf {
    let whole = report.canonicalize().unwrap_or_else(|_| report.to_path_buf());
    let around = whole.ancestors().skip(1).map(|folder| folder.join(path));
    let found = std::iter::once(PathBuf::from(path)).chain(around).find(|path| path.exists());
    found.map_or_else(|| path.into(), |found| plain(&found))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_city_is_found_from_around_the_report() {
        let folder = tempfile::tempdir().unwrap();
        let (out, city) = (folder.path().join("out/a"), folder.path().join("towns/b"));
        std::fs::create_dir_all(&out).unwrap();
        std::fs::create_dir_all(&city).unwrap();
        let report = out.join("report.json");
        std::fs::write(&report, "{}").unwrap();
        assert_eq!(found_from(&report, "towns/b"), city.canonicalize().unwrap());
        assert_eq!(found_from(&report, &city.display().to_string()), city.canonicalize().unwrap());
        assert_eq!(found_from(&report, "towns/none"), Path::new("towns/none"));
    }
}
