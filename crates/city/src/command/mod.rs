//! What `plat` takes on its command line, and the exit statuses it promises.

mod bars;
mod build;
mod check;
mod failure;
mod faults;
mod new;
mod rules;
mod stats;
mod test;
mod validate;
mod why;
mod words;

use city::Until;
use city::export::ColourBy;
use city::measure::Window;
use clap::{Parser, Subcommand};
use failure::Failure;
use script::RuleKind;
use script::testing::Trial;
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
    /// Finds what is wrong in rules and city scripts without building.
    #[command(after_help = CHECK_HELP)]
    Check(CheckArguments),
    /// Lists the rules and presets of the library and what can be set in them.
    #[command(after_help = RULES_HELP)]
    Rules(RulesArguments),
    /// Prints the reference of the rule language: every word with what it does and an example.
    Words(WordsArguments),
    /// Writes the commented start of a rule or a city.
    New(NewArguments),
    /// Runs the tests of rules: claims about single calls and small towns, and snapshots.
    #[command(after_help = TEST_HELP)]
    Test(TestArguments),
    /// Checks a layout.geojson against the validity contract.
    #[command(after_help = STATUSES)]
    Validate(ValidateArguments),
    /// Measures the streets and blocks of a layout, and holds the figures against those of a real place.
    #[command(after_help = STATS_HELP)]
    Stats(StatsArguments),
    /// Says why something of a layout is there: its rule, parameters, maps, lineage, and what was refused around it.
    #[command(after_help = WHY_HELP)]
    Why(WhyArguments),
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
    #[arg(long, value_parser = seed, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Lays a preset on the city, or on part of it: village, majors=boulevards, "district:old town=medieval_core",
    /// quarter:ID=campus; may be given many times.
    #[arg(long, value_name = "[WHERE=]NAME")]
    preset: Vec<String>,
    /// Sets a parameter by its role, e.g. minors.pattern.block_width=90, or in one place alone, e.g.
    /// quarter:ID.minors.pattern.block_width=90 and "district:old town.parcels.least_area=200"; may be given many times.
    #[arg(long = "set", value_name = "ROLE.PARAM=VALUE")]
    set: Vec<String>,
    /// Looks rules up here after the city's own folder and before the library.
    #[arg(long, value_name = "DIR")]
    rules: Option<PathBuf>,
    /// Threads to use; the result is the same for any number. All processors when 0.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024), allow_negative_numbers = true)]
    threads: u16,
    /// Stops after a stage.
    #[arg(long, value_enum, default_value_t = Until::Buildings)]
    until: Until,
    /// Draws the streets after these derivation steps too, as map-step-28.svg and .png: steps count through all stages.
    #[arg(long, value_name = "STEP,…", value_delimiter = ',', value_parser = step, allow_negative_numbers = true)]
    steps: Vec<u32>,
    /// Says, once it is built, step by step how something came to be: by the first digits of its id in layout.geojson, or by the
    /// place X,Y where it lies.
    #[arg(long, value_name = "ID", conflicts_with = "json")]
    trace: Option<String>,
    /// Colours the streets of the map by what they are or by the ground they run on, with a legend.
    #[arg(long, value_enum, value_name = "WHAT", alias = "color-by")]
    colour_by: Option<ColourBy>,
    /// Builds again as soon as a rule, the script or a map is saved, until Ctrl-C; only what the change matters to is done
    /// again. While something is broken the files stay as they are. Ends with 0, or with 130 where nothing was written.
    #[arg(long, conflicts_with_all = ["steps", "trace"])]
    watch: bool,
    /// Keeps results of stages in this folder for later builds, which are the same but faster; --watch keeps them in the
    /// user's cache folder where none is named.
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Most that the cache may take on disk, in megabytes; what was not used for longest goes first.
    #[arg(long, value_name = "MB", default_value_t = 2000, value_parser = clap::value_parser!(u64).range(1..=1_000_000), allow_negative_numbers = true)]
    cache_limit: u64,
    /// Keeps nothing on disk.
    #[arg(long, conflicts_with = "cache")]
    no_cache: bool,
    /// Prints the report as JSON on standard output; with --watch one line a build.
    #[arg(long)]
    json: bool,
    /// Prints nothing but faults and errors.
    #[arg(long)]
    quiet: bool,
}

/// Arguments of `plat check`.
#[derive(clap::Args, Debug)]
struct CheckArguments {
    /// Rules, cities, or folders with .rhai files below them.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Looks rules up here after the script's own folder and before the library.
    #[arg(long, value_name = "DIR")]
    rules: Option<PathBuf>,
    /// Prints one JSON object.
    #[arg(long)]
    json: bool,
}

/// Arguments of `plat rules`.
#[derive(clap::Args, Debug)]
struct RulesArguments {
    /// Rules and presets whose names begin so, such as streets/, or are called so in their folder, such as grid or village; all
    /// when none is named.
    names: Vec<String>,
    /// Lists the rules of this folder too: a city's, or one of rules alone.
    #[arg(long, value_name = "DIR")]
    rules: Option<PathBuf>,
    /// Lists parameters, too; always so where names are given.
    #[arg(long)]
    params: bool,
    /// Prints the text of the rules and presets that are named, to be copied and changed.
    #[arg(long, requires = "names", conflicts_with_all = ["json", "params", "pictures"])]
    source: bool,
    /// Draws a picture of each preset that is listed, into this folder: NAME.png.
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
    /// Prints one JSON object.
    #[arg(long)]
    json: bool,
}

/// Arguments of `plat words`.
#[derive(clap::Args, Debug)]
struct WordsArguments {
    /// Words with this in their name; all when none is given.
    name: Option<String>,
    /// Prints all as Markdown.
    #[arg(long, conflicts_with = "name")]
    markdown: bool,
    /// Prints all as definitions for editors, the text of a .d.rhai file.
    #[arg(long, conflicts_with_all = ["name", "markdown"])]
    definitions: bool,
}

/// Arguments of `plat new`.
#[derive(clap::Args, Debug)]
struct NewArguments {
    #[command(subcommand)]
    thing: NewThing,
}

/// What can be started.
#[derive(Subcommand, Debug)]
enum NewThing {
    /// A rule, in the folder of its kind: streets/NAME.rhai.
    Rule {
        /// What it decides.
        #[arg(value_parser = new::kinds())]
        kind: RuleKind,
        /// What it is called.
        name: String,
        /// The folder of a city, or of rules alone.
        #[arg(long = "in", value_name = "DIR", default_value = ".")]
        folder: PathBuf,
    },
    /// A city: NAME/city.rhai.
    City {
        /// What it is called.
        name: String,
        /// Where its folder is made.
        #[arg(long = "in", value_name = "DIR", default_value = ".")]
        folder: PathBuf,
    },
}

const CHECK_HELP: &str = "Of a city the rules that it names are checked too, and whether its maps can be read.

Exit status: 0 nothing is wrong (there may be warnings); 1 something is; 2 bad usage, or nothing there; 3 input failed.";

const RULES_HELP: &str =
    "Exit status: 0 done; 1 a rule is broken (the others are listed); 2 bad usage, or no such rule.";

/// Arguments of `plat test`.
#[derive(clap::Args, Debug)]
struct TestArguments {
    /// Rules, files of tests, or folders with either below them.
    #[arg(required = true)]
    paths: Vec<PathBuf>,
    /// Runs only tests that have this in their name.
    #[arg(long, value_name = "NAME")]
    only: Option<String>,
    /// How many trials a random test is run for.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    trials: u32,
    /// Runs random tests for this trial alone, as a failed one told it.
    #[arg(long, value_name = "TRIAL")]
    trial: Option<Trial>,
    /// Takes over the snapshots as they are now, and removes those that no test takes.
    #[arg(long)]
    accept: bool,
    /// Says which branches of the rules no test reaches.
    #[arg(long)]
    coverage: bool,
    /// Looks rules up here after the file's own folder and before the library.
    #[arg(long, value_name = "DIR")]
    rules: Option<PathBuf>,
    /// Threads to use. All processors when 0.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u16).range(0..=1024), allow_negative_numbers = true)]
    threads: u16,
    /// Prints one JSON object.
    #[arg(long)]
    json: bool,
}

const TEST_HELP: &str = "Tests are functions `fn test_…()` in grid.test.rhai beside grid.rhai, or in the rule itself. What a snapshot holds
lies in snapshots/ beside them, with a map as SVG.

Exit status: 0 all passed; 1 some failed, or a file has faults; 2 bad usage, or there are no tests; 3 input or output failed.";

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

/// Arguments of `plat stats`.
#[derive(clap::Args, Debug)]
struct StatsArguments {
    /// A layout.geojson.
    layout: PathBuf,
    /// Folder of maps in the layout's frame: masks borough, city or land; parks, density, elevation.
    maps: Option<PathBuf>,
    /// The place of the file of ranges to hold the figures against.
    #[arg(long, value_name = "NAME", requires = "ranges")]
    place: Option<String>,
    /// A JSON file of ranges by place.
    #[arg(long, value_name = "FILE", requires = "place")]
    ranges: Option<PathBuf>,
    /// The mask of MAPS to measure in, instead of the first of borough, city, land.
    #[arg(long, value_name = "NAME", requires = "maps")]
    mask: Option<String>,
    /// Measures inside a rectangle only: west,south,east,north in metres.
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = stats::parse_window, allow_hyphen_values = true)]
    window: Option<Window>,
    /// Prints one JSON object: measures by name, and the verdict as `place`.
    #[arg(long)]
    json: bool,
}

/// Arguments of `plat why`.
#[derive(clap::Args, Debug)]
struct WhyArguments {
    /// A layout.geojson that `plat build` wrote.
    layout: PathBuf,
    /// The id of a street, crossing, quarter, block, parcel or building in it, whose first digits do; or a place X,Y in metres.
    id: String,
    /// The city that the layout was built from, where report.json does not say.
    #[arg(long, value_name = "CITY")]
    city: Option<PathBuf>,
    /// The seed it was built with, instead of the layout's.
    #[arg(long, value_parser = seed, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// The presets it was built with, instead of those in report.json.
    #[arg(long, value_name = "[WHERE=]NAME")]
    preset: Vec<String>,
    /// The parameters it was built with, instead of those in report.json.
    #[arg(long = "set", value_name = "ROLE.PARAM=VALUE")]
    set: Vec<String>,
    /// The folder of rules it was built with, instead of that in report.json.
    #[arg(long, value_name = "DIR")]
    rules: Option<PathBuf>,
    /// Prints one JSON object.
    #[arg(long)]
    json: bool,
}

const WHY_HELP: &str =
    "The city is derived once more, which takes as long as its streets take to grow. report.json beside the layout says
which city it was built from, and with which parameters.

Exit status: 0 done; 1 the layout is not what the city gives now (the answer says how); 2 bad usage, or no such id;
3 input failed.";

const STATS_HELP: &str = "A street or block counts where its middle lies in the mask and the window. A file of ranges:
  {\"my_town\": {\"whole\": {\"order\": [0.6, 0.9], \"headings\": [151.5, 61.5]},
               \"windows\": {\"centre\": {\"window\": [0, 0, 1000, 1000], \"x_share\": [0.4, 0.9]}}}}

Exit status: 0 done; 1 a measure is outside its range or nothing could be measured; 2 bad usage; 3 input failed.";

/// The promised exit statuses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Status {
    Done = 0,
    Faults = 1,
    Usage = 2,
    Failed = 3,
    Interrupted = 130,
}

fn seed(text: &str) -> Result<u64, String> {
    text.trim().parse().map_err(|_| format!("a seed is a whole number from 0 to {}", u64::MAX))
}

fn step(text: &str) -> Result<u32, String> {
    text.trim().parse().map_err(|_| "a derivation step is a whole number from 0, e.g. --steps 28,142".to_owned())
}

/// Runs the command line of this process.
pub fn run() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return ExitCode::from(tell_usage(&error) as u8),
    };
    let (outcome, json) = match &arguments.verb {
        Verb::Build(build) => (build::run(build), build.json),
        Verb::Check(check) => (check::run(check), check.json),
        Verb::Rules(rules) => (rules::run(rules), rules.json),
        Verb::Words(asked) => (words::run(asked), false),
        Verb::New(new) => (new::run(new), false),
        Verb::Test(test) => (test::run(test), test.json),
        Verb::Validate(validate) => (validate::run(validate), validate.json),
        Verb::Stats(stats) => (stats::run(stats), stats.json),
        Verb::Why(why) => (why::run(why), why.json),
    };
    ExitCode::from(outcome.unwrap_or_else(|failure| failure.tell(json)) as u8)
}

/// Tells what is wrong with the command line, or the help that was asked for.
fn tell_usage(error: &clap::Error) -> Status {
    let _ = error.print();
    if !error.use_stderr() {
        return Status::Done;
    }
    if std::env::args_os().any(|argument| argument == "--json") {
        println!("{}", failure::as_json(Status::Usage, error.to_string().trim_start_matches("error: ")));
    }
    Status::Usage
}
