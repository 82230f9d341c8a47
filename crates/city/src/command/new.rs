//! `plat new`: commented starts that work.

use super::{Failure, NewArguments, NewThing, Status};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use script::RuleKind;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Reads what a new rule decides.
pub fn kinds() -> impl TypedValueParser<Value = RuleKind> {
    let value = |kind: RuleKind| PossibleValue::new(kind.name()).help(kind.form());
    let named = |name: String| RuleKind::ALL.into_iter().find(|kind| kind.name() == name);
    PossibleValuesParser::new(RuleKind::ALL.map(value)).try_map(move |name| named(name).ok_or("no kind of rule"))
}

/// The start of a rule, and of its tests.
fn start(kind: RuleKind) -> (&'static str, &'static str) {
    match kind {
        RuleKind::Streets => (include_str!("new/streets.rhai"), include_str!("new/streets.test.rhai")),
        RuleKind::Goals => (include_str!("new/goals.rhai"), include_str!("new/goals.test.rhai")),
        RuleKind::Constraints => (include_str!("new/constraints.rhai"), include_str!("new/constraints.test.rhai")),
        RuleKind::Constrain => (include_str!("new/constrain.rhai"), include_str!("new/constrain.test.rhai")),
        RuleKind::Parcels => (include_str!("new/parcels.rhai"), include_str!("new/parcels.test.rhai")),
        RuleKind::Assign => (include_str!("new/assign.rhai"), include_str!("new/assign.test.rhai")),
        RuleKind::Buildings => (include_str!("new/buildings.rhai"), include_str!("new/buildings.test.rhai")),
    }
}

/// How a city script uses a rule.
fn usage(kind: RuleKind, rule: &str) -> String {
    let rule = format!("rule(\"{rule}\")");
    match kind {
        RuleKind::Streets => format!("minors: streets(#{{ pattern: {rule} }})"),
        RuleKind::Goals => format!("minors: streets(#{{ pattern: …, goals: {rule} }})"),
        RuleKind::Constraints => format!("minors: streets(#{{ pattern: …, constraints: {rule} }})"),
        RuleKind::Constrain => {
            format!("minors: streets(#{{ pattern: …, constraints: [rule(\"constraints/standard\"), {rule}] }})")
        }
        RuleKind::Parcels | RuleKind::Assign => format!("parcels: {rule}"),
        RuleKind::Buildings => format!("buildings: {rule}"),
    }
}

/// Writes the start of a rule or a city, never over something that is there.
pub fn run(arguments: &NewArguments) -> Result<Status, Failure> {
    match &arguments.thing {
        NewThing::Rule { kind, name, folder } => {
            let name = checked(name)?;
            let rule = format!("{}/{name}", kind.folder());
            let path = below(folder, &format!("{rule}.rhai"));
            let tests = below(folder, &format!("{rule}.test.rhai"));
            let (start, start_of_tests) = start(*kind);
            if tests.exists() {
                return Err(taken(&tests));
            }
            write(&path, &start.replace("NAME", name))?;
            write(&tests, &start_of_tests.replace("NAME", name))?;
            println!("wrote {} and {}", path.display(), tests.display());
            println!("  in a city script: {}", usage(*kind, &rule));
            println!("  what is wrong with it: plat check {}", path.display());
            println!("  its tests: plat test {}", path.display());
        }
        NewThing::City { name, folder } => {
            let name = checked(name)?;
            let city = below(folder, name);
            let path = city.join("city.rhai");
            write(&path, &include_str!("new/city.rhai").replace("NAME", name))?;
            println!("wrote {}", path.display());
            println!("  build it: plat build {} -o out", city.display());
            println!("  a rule of its own: plat new rule streets mine --in {}", city.display());
        }
    }
    Ok(Status::Done)
}

/// A path in a folder, without a needless `./`.
fn below(folder: &Path, name: &str) -> PathBuf {
    if folder == Path::new(".") { PathBuf::from(name) } else { folder.join(name) }
}

/// A name that is one plain word: it becomes a file name and stands between quotes in scripts.
fn checked(name: &str) -> Result<&str, Failure> {
    let is_plain =
        name.starts_with(char::is_alphanumeric) && name.chars().all(|c| c.is_alphanumeric() || "_-".contains(c));
    if is_plain {
        return Ok(name);
    }
    let message = format!("`{name}` is no name\n  hint: letters, digits, `_` and `-`, such as my_pattern");
    Err(Failure::new(Status::Usage, message))
}

fn taken(path: &Path) -> Failure {
    Failure::new(Status::Usage, format!("{} is there already\n  hint: choose another name", path.display()))
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let failed = |what: PathBuf, error: std::io::Error| {
        Failure::new(Status::Failed, format!("{}: {error}\n  hint: --in names a folder to write to", what.display()))
    };
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(|error| failed(folder.to_path_buf(), error))?;
    match fs::OpenOptions::new().write(true).create_new(true).open(path) {
        Ok(mut file) => file.write_all(text.as_bytes()).map_err(|error| failed(path.to_path_buf(), error)),
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => Err(taken(path)),
        Err(error) => Err(failed(path.to_path_buf(), error)),
    }
}
