//! What `plat` takes on its command line, and the exit statuses it promises.

mod bars;
mod build;
mod validate;

use city::Until;
use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// Grows, edits and builds cities from rules.
#[derive(Parser, Debug)]
#[command(name = "plat", version, after_help = STATUSES)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

const STATUSES: &str = "Exit status: 0 done; 1 the city has faults (it is still written), or a layout breaks the contract; \
2 bad usage; 3 input or output failed, and nothing was written; 130 stopped by Ctrl-C, nothing written.";

#[derive(Subcommand, Debug)]
enum Verb {
    /// Builds a city from its script and writes streets, parcels, buildings, map and model.
    #[command(after_help = STATUSES)]
    Build(BuildArguments),
    /// Checks a layout.geojson against the validity contract.
    #[command(after_help = STATUSES)]
    Validate(ValidateArguments),
}

/// Arguments of `plat build`.
#[derive(clap::Args, Debug)]
struct BuildArguments {
    /// The city: a folder with a city.rhai, or the script itself.
    city: PathBuf,
    /// Folder for the results; made if missing.
    #[arg(short, long, default_value = "out")]
    out: PathBuf,
    /// Builds with this seed instead of the script's.
    #[arg(long)]
    seed: Option<u64>,
    /// Sets a parameter by its role, e.g. minors.pattern.block_width=90; may be given many times.
    #[arg(long = "set", value_name = "ROLE.PARAM=VALUE")]
    set: Vec<String>,
    /// Looks rules up here after the city's own folder and before the library.
    #[arg(long, value_name = "DIR")]
    rules: Option<PathBuf>,
    /// Threads to use; the result is the same for any number. All processors when 0.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024))]
    threads: u16,
    /// Stops after a stage.
    #[arg(long, value_enum, default_value_t = Until::Buildings)]
    until: Until,
    /// Prints the report as JSON on standard output.
    #[arg(long)]
    json: bool,
    /// Prints nothing but faults and errors.
    #[arg(long)]
    quiet: bool,
}

/// Arguments of `plat validate`.
#[derive(clap::Args, Debug)]
struct ValidateArguments {
    /// A layout.geojson.
    layout: PathBuf,
    /// What the layout was built until.
    #[arg(long, value_enum, default_value_t = Until::Buildings)]
    until: Until,
    /// Prints one JSON object.
    #[arg(long)]
    json: bool,
}

/// The promised exit statuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Status {
    Done = 0,
    Faults = 1,
    Usage = 2,
    Failed = 3,
    Interrupted = 130,
}

/// Runs the command line of this process.
pub fn run() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => {
            let status = if error.use_stderr() { Status::Usage } else { Status::Done };
            let _ = error.print();
            return ExitCode::from(status as u8);
        }
    };
    let status = match arguments.verb {
        Verb::Build(build) => build::run(&build),
        Verb::Validate(validate) => validate::run(&validate),
    };
    ExitCode::from(status as u8)
}
