//! `plat test`: runs the tests of rules.

use super::{Failure, Status, TestArguments, faults};
use city::testing::{Compared, Ran, Settings, Standing, Suite, accept};
use city::{FaultReport, LoadError};
use script::testing::{Branch, Coverage};
use serde_json::{Value, json};
use similar::{ChangeTag, TextDiff};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Lines told around what differs in a snapshot.
const AROUND: usize = 2;

/// Runs the tests below the paths; with `--accept` takes over the snapshots of those that pass otherwise.
pub fn run(arguments: &TestArguments) -> Result<Status, Failure> {
    let settings = Settings {
        only: arguments.only.clone(),
        trials: u64::from(arguments.trials),
        trial: arguments.trial.clone(),
        rules: arguments.rules.clone(),
        threads: usize::from(arguments.threads),
        coverage: arguments.coverage.then(Coverage::default),
    };
    let suite = Suite::find(&arguments.paths, &settings).map_err(super::build::unreadable)?;
    if suite.is_empty() && suite.faults.is_empty() {
        return Err(nothing(&arguments.paths));
    }
    let mut ran = suite.run(&settings).map_err(|error| Failure::new(Status::Failed, error.to_string()))?;
    if ran.is_empty() && suite.faults.is_empty() {
        let only = arguments.only.as_deref().unwrap_or_default();
        return Err(Failure::new(Status::Usage, format!("no test is called `{only}`, or has that in its name")));
    }
    // With some tests left out nobody knows which snapshots belong to none.
    let stale = if arguments.only.is_none() && suite.faults.is_empty() { suite.stale(&ran) } else { Vec::new() };
    let accepted = if arguments.accept { take_over(&mut ran, &stale)? } else { 0 };
    let stale = if arguments.accept { Vec::new() } else { stale };
    let reports: Vec<FaultReport> = suite.faults.iter().map(FaultReport::from).collect();
    faults::tell(&reports, &suite.texts);
    let failed = ran.iter().filter(|ran| !ran.has_passed()).count();
    if arguments.json {
        let tests: Vec<Value> = ran.iter().map(as_json).collect();
        let mut report =
            json!({ "tests": tests, "failed": failed, "faults": reports, "stale": stale, "accepted": accepted });
        if let Some(coverage) = &settings.coverage {
            report["coverage"] = suite.rules().iter().map(|(rule, path)| covered(rule, &coverage.of(path))).collect();
        }
        println!("{report}");
        ran.iter().filter(|ran| !ran.has_passed()).for_each(|ran| tell(ran, &suite));
    } else {
        tell_all(&ran, &suite);
        let told = match failed {
            0 => format!("{} passed", faults::counted(ran.len(), "test")),
            _ => format!("{failed} of {} failed", faults::counted(ran.len(), "test")),
        };
        let written =
            if accepted > 0 { format!(", {} accepted", faults::counted(accepted, "snapshot")) } else { String::new() };
        let unread: BTreeSet<&str> = reports.iter().map(|report| report.file.as_str()).collect();
        let unread = match unread.len() {
            0 => String::new(),
            count => format!("; those in {} could not be read", faults::counted(count, "file")),
        };
        println!("{told}{unread}{written}");
        if let Some(coverage) = &settings.coverage {
            let of = |(_, path): &(_, String)| (path.clone(), coverage.of(path));
            // Presets have values alone.
            let branched =
                suite.rules().iter().map(of).filter(|(_, branches)| !branches.is_empty()).collect::<Vec<_>>();
            branched.iter().for_each(|(path, branches)| print!("{}", coverage_text(path, branches)));
        }
    }
    stale
        .iter()
        .for_each(|path| eprintln!("warning: no test takes the snapshot {} (--accept removes it)", path.display()));
    Ok(if failed == 0 && reports.is_empty() { Status::Done } else { Status::Faults })
}

fn nothing(paths: &[PathBuf]) -> Failure {
    let named: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let hint = "tests are functions `fn test_…()` in grid.test.rhai beside grid.rhai, or in the rule itself";
    let error =
        LoadError::Missing { path: named.join(", ").into(), message: "there are no tests".into(), hint: hint.into() };
    Failure::new(Status::Usage, error.to_string())
}

/// Writes the snapshots of tests whose claims held, and removes those that belong to none; says how many changed.
fn take_over(ran: &mut [Ran], stale: &[PathBuf]) -> Result<usize, Failure> {
    let mut count = 0;
    let fail = |path: &Path, error: &std::io::Error| {
        Failure::new(Status::Failed, format!("{}: the snapshot could not be written: {error}", path.display()))
    };
    for compared in ran.iter_mut().filter(|ran| ran.fault.is_none()).flat_map(|ran| &mut ran.snapshots) {
        if compared.standing != Standing::Same {
            accept(compared).map_err(|error| fail(&compared.path, &error))?;
            compared.standing = Standing::Same;
            count += 1;
        }
    }
    for path in stale {
        std::fs::remove_file(path).map_err(|error| fail(path, &error))?;
        // Not every snapshot has a map.
        let _ = std::fs::remove_file(path.with_extension("svg"));
        count += 1;
    }
    Ok(count)
}

/// A line for each file, and what failed in it.
fn tell_all(ran: &[Ran], suite: &Suite) {
    for of_file in ran.chunk_by(|a, b| a.path == b.path) {
        let failed = of_file.iter().filter(|ran| !ran.has_passed()).count();
        let count = faults::counted(of_file.len(), "test");
        let outcome = if failed == 0 { "passed".to_owned() } else { format!("{failed} failed") };
        println!("{}  {count}, {outcome}", of_file[0].rule);
        for ran in of_file {
            ran.printed.iter().for_each(|line| println!("  {}: {line}", ran.test));
            if !ran.has_passed() {
                tell(ran, suite);
            }
        }
    }
}

/// What failed in a test, on standard error.
fn tell(ran: &Ran, suite: &Suite) {
    eprintln!("FAILED {}: {} ({}:{})", ran.rule, ran.test, ran.path.display(), ran.line);
    if let Some(fault) = &ran.fault {
        faults::tell(&[FaultReport::from(fault)], &suite.texts);
        if let Some(trial) = &ran.trial {
            let path = ran.path.display();
            eprintln!("the simplest trial that fails: plat test {path} --only {} --trial \"{trial}\"\n", ran.test);
        }
    }
    for compared in &ran.snapshots {
        if let Some(difference) = difference(compared) {
            eprintln!("{difference}");
        }
    }
}

/// How a snapshot differs from what was accepted, in words and lines.
fn difference(compared: &Compared) -> Option<String> {
    let file = compared.path.display();
    match &compared.standing {
        Standing::Same => None,
        Standing::New => {
            Some(format!("the snapshot {file} is new: --accept takes it over\n{}", compared.snapshot.text))
        }
        Standing::Unreadable { reason } => Some(format!("the snapshot {file} cannot be read: {reason}")),
        Standing::Differs { accepted } => {
            let lines = changed_lines(accepted, compared.snapshot.text.trim_end());
            Some(format!("the snapshot {file} differs (- accepted, + found):\n{lines}"))
        }
    }
}

fn changed_lines(accepted: &str, found: &str) -> String {
    let diff = TextDiff::from_lines(accepted, found);
    let mut text = String::new();
    for (i, group) in diff.grouped_ops(AROUND).iter().enumerate() {
        text += if i > 0 { "  …\n" } else { "" };
        for change in group.iter().flat_map(|operation| diff.iter_changes(operation)) {
            let sign = match change.tag() {
                ChangeTag::Delete => '-',
                ChangeTag::Insert => '+',
                ChangeTag::Equal => ' ',
            };
            let _ = writeln!(text, "{sign} {}", change.value().trim_end());
        }
    }
    text
}

/// How many branches of a rule were run, and a line for each that was not.
fn coverage_text(path: &str, branches: &[Branch]) -> String {
    let missed: Vec<&Branch> = branches.iter().filter(|branch| branch.count == 0).collect();
    let mut text = format!("{path}: {} of {} branches reached\n", branches.len() - missed.len(), branches.len());
    for branch in missed {
        text += &format!("  {path}:{}:{}: {} is never run\n", branch.line, branch.column, branch.what);
    }
    text
}

fn covered(rule: &str, branches: &[Branch]) -> Value {
    let branch = |branch: &Branch| json!({ "line": branch.line, "column": branch.column, "what": branch.what, "count": branch.count });
    json!({ "rule": rule, "branches": branches.iter().map(branch).collect::<Vec<_>>() })
}

fn as_json(ran: &Ran) -> Value {
    let snapshot = |compared: &Compared| {
        let (standing, accepted) = match &compared.standing {
            Standing::Same => ("same", None),
            Standing::New => ("new", None),
            Standing::Differs { accepted } => ("differs", Some(accepted)),
            Standing::Unreadable { reason } => ("unreadable", Some(reason)),
        };
        json!({ "file": compared.path, "standing": standing, "accepted": accepted, "found": compared.snapshot.text })
    };
    json!({
        "rule": ran.rule,
        "test": ran.test,
        "file": ran.path,
        "line": ran.line,
        "passed": ran.has_passed(),
        "fault": ran.fault.as_ref().map(FaultReport::from),
        "trial": ran.trial.as_ref().map(ToString::to_string),
        "snapshots": ran.snapshots.iter().map(snapshot).collect::<Vec<_>>(),
        "printed": ran.printed,
    })
}
