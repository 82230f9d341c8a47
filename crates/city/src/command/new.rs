//! `plat new`: commented starts that work.

use super::{Failure, NewArguments, NewThing, Status};
use clap::ValueEnum;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What a new rule decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum NewRule {
    /// How streets grow: propose(tip, p).
    Streets,
    /// Where streets want to be: goals(p).
    Goals,
    /// What every street keeps to: constraints(p).
    Constraints,
    /// Whether one street may be laid: constrain(segment, p).
    Constrain,
    /// How a block becomes parcels: subdivide(block, p).
    Parcels,
    /// What stands on a parcel: build(shape, p).
    Buildings,
}

impl NewRule {
    /// The folder that such rules stand in.
    fn folder(self) -> &'static str {
        match self {
            Self::Streets => "streets",
            Self::Goals => "goals",
            Self::Constraints | Self::Constrain => "constraints",
            Self::Parcels => "parcels",
            Self::Buildings => "buildings",
        }
    }

    fn start(self) -> &'static str {
        match self {
            Self::Streets => include_str!("new/streets.rhai"),
            Self::Goals => include_str!("new/goals.rhai"),
            Self::Constraints => include_str!("new/constraints.rhai"),
            Self::Constrain => include_str!("new/constrain.rhai"),
            Self::Parcels => include_str!("new/parcels.rhai"),
            Self::Buildings => include_str!("new/buildings.rhai"),
        }
    }

    /// How a city script uses it.
    fn usage(self, rule: &str) -> String {
        let rule = format!("rule(\"{rule}\")");
        match self {
            Self::Streets => format!("minors: streets(#{{ pattern: {rule} }})"),
            Self::Goals => format!("minors: streets(#{{ pattern: …, goals: {rule} }})"),
            Self::Constraints => format!("minors: streets(#{{ pattern: …, constraints: {rule} }})"),
            Self::Constrain => {
                format!("minors: streets(#{{ pattern: …, constraints: [rule(\"constraints/standard\"), {rule}] }})")
            }
            Self::Parcels => format!("parcels: {rule}"),
            Self::Buildings => format!("buildings: {rule}"),
        }
    }
}

/// Writes the start of a rule or a city, never over something that is there.
pub fn run(arguments: &NewArguments) -> Result<Status, Failure> {
    match &arguments.thing {
        NewThing::Rule { kind, name, folder } => {
            let name = checked(name)?;
            let rule = format!("{}/{name}", kind.folder());
            let path = below(folder, &format!("{rule}.rhai"));
            write(&path, &kind.start().replace("NAME", name))?;
            println!("wrote {}", path.display());
            println!("  in a city script: {}", kind.usage(&rule));
            println!("  what is wrong with it: plat check {}", path.display());
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

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    let failed = |what: PathBuf, error: std::io::Error| {
        Failure::new(Status::Failed, format!("{}: {error}\n  hint: --in names a folder to write to", what.display()))
    };
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(|error| failed(folder.to_path_buf(), error))?;
    match fs::OpenOptions::new().write(true).create_new(true).open(path) {
        Ok(mut file) => file.write_all(text.as_bytes()).map_err(|error| failed(path.to_path_buf(), error)),
        Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {
            let message = format!("{} is there already\n  hint: choose another name", path.display());
            Err(Failure::new(Status::Usage, message))
        }
        Err(error) => Err(failed(path.to_path_buf(), error)),
    }
}
