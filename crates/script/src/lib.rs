//! The Rhai rule host: the only crate that names rhai.
//!
//! A [`Host`] finds scripts in its libraries. A rule file becomes a [`Rule`]: its parameters ([`ParamSet`]) and the
//! function that makes it decide something ([`RuleKind`]). A city script becomes a [`Plan`]: plain data and rules. At
//! build time [`StreetPattern`], [`ParcelPattern`] and [`BuildingPattern`] let kernels ask rules from any thread; what
//! goes wrong is collected in [`Faults`], and the city goes on without it.
//!
//! What rule writers read is `rules/README.md`.

mod account;
mod city;
mod digest;
mod effects;
mod fault;
mod host;
mod names;
mod param;
mod pattern;
mod plan;
mod preset;
pub mod reference;
mod rule;
pub mod testing;
mod words;

pub use account::{Account, Step, StepKind, Telling};
pub use city::{Checked, Evaluated, SiteInfo, SiteRequest, Sites};
pub use digest::PlanDigests;
pub use effects::heard;
pub use fault::{Call, Fault, Faults, Severity, place_in_script};
pub use host::{Embedded, LIBRARY, Library, Source, Texts};
pub use names::nearest;
pub use param::{DistrictValues, Domain, Literal, MapValue, Param, ParamError, ParamSet, Places, Unit, Value};
pub use pattern::{PatternPart, PatternPlan, WeightPlan};
pub use plan::{
    DensityGoal, DistrictPlan, DrawnDistricts, GivenLine, GoalPlan, Landmark, MINOR_WIDTH, MapOptions, MapRef,
    NO_DISTRICT, Plan, QuarterPlan, Rim, RoleParam, SitePlan, StreetImport, StreetPlan, StreetUnits, Within,
};
pub use preset::{Preset, PresetTarget};
pub use rule::{MOST_NOTES, Note, Rule, RuleKind};
pub use words::{
    AssignPattern, Assigned, BareGround, BlockContext, BuildingChoice, BuildingPattern, ConstraintPattern, Ground,
    Marked, PROPOSES_NOTHING, ParcelChoice, ParcelPattern, REFUSES_EVERYTHING, ShapeContext, StreetPattern, StreetSide,
};

use host::{Modules, Shelves};
use rule::Surroundings;
use std::sync::Arc;
use testing::{Bench, Coverage, TestFile};

/// Finds and loads scripts. Each file is read at most once per use; make a new host to read changed files.
#[derive(Clone, Debug)]
pub struct Host {
    around: Surroundings,
}

impl Host {
    /// A host that looks into the given libraries in order, then into the built-in one.
    pub fn new(libraries: Vec<Arc<dyn Library>>) -> Self {
        Self {
            around: Surroundings {
                shelves: Shelves::new(libraries),
                texts: Texts::default(),
                modules: Modules::default(),
                coverage: None,
                account: None,
                rules: None,
            },
        }
    }

    /// The same, counting the branches of rules that are run.
    #[must_use]
    pub fn counting(mut self, coverage: &Coverage) -> Self {
        self.around.coverage = Some(coverage.clone());
        self
    }

    /// A rule by name, e.g. `streets/grid`, with its parameters at their defaults.
    pub fn rule(&self, name: &str) -> Result<Rule, Fault> {
        let source = self.around.shelves.read(name)?;
        Rule::load(name, &source, &self.around)
    }

    /// A rule from its text.
    pub fn rule_of(&self, name: &str, source: &Source) -> Result<Rule, Fault> {
        Rule::load(name, source, &self.around)
    }

    /// The text of a rule or a preset by its full name.
    pub fn source(&self, name: &str) -> Result<Source, Fault> {
        self.around.shelves.read(name)
    }

    /// The texts of the scripts read so far.
    pub fn texts(&self) -> &Texts {
        &self.around.texts
    }

    /// The names of all rules and other scripts in the libraries but presets, in alphabetical order.
    pub fn names(&self) -> Vec<String> {
        self.around.shelves.names().into_iter().filter(|name| !preset::is_preset(name)).collect()
    }

    /// The names of all presets in the libraries, in alphabetical order.
    pub fn preset_names(&self) -> Vec<String> {
        self.around.shelves.names().into_iter().filter(|name| preset::is_preset(name)).collect()
    }

    /// A preset by name, e.g. `presets/village` or `village`.
    ///
    /// # Errors
    /// Without a line when there is none of that name; else all that is wrong in it and in the rules it names, what stopped it
    /// first: at least one fault.
    pub fn preset(&self, name: &str) -> Result<Preset, Vec<Fault>> {
        let name = preset::full_name(name);
        let missing = |fault: Fault| vec![Fault { message: fault.message.replace("rule", "preset"), ..fault }];
        let source = self.around.shelves.read(&name).map_err(missing)?;
        Preset::load(&name, &source, &self.around)
    }

    /// What is wrong with a rule, found without calling it: all of it, in the order of the text, with what is doubtful as
    /// warnings. A file without any function of a rule is one that others import.
    pub fn check_rule(&self, name: &str, source: &Source) -> Vec<Fault> {
        if preset::is_preset(name) && !testing::is_beside(name) {
            return Preset::load(name, source, &self.around).err().unwrap_or_default();
        }
        let mut faults = Vec::new();
        if !testing::is_beside(name) {
            faults = Rule::examine(name, source, &self.around).map_or_else(|faults| faults, |rule| rule.doubts());
        }
        // What the whole text is no script for is told once.
        if faults.iter().all(|fault| fault.severity == Severity::Warning) {
            let tests = self.tests_of(name, source, Bench::bare());
            faults.extend(tests.map_or_else(|faults| faults, |tests| tests.misnamed_rules()));
        } else {
            faults.sort_by_key(|fault| (fault.line, fault.column));
        }
        faults
    }

    /// The tests of a file: a rule's own, or one beside it called `grid.test`. A rule may have none.
    ///
    /// # Errors
    /// What is wrong in the file, found without running a test: at least one fault.
    pub fn tests_of(&self, name: &str, source: &Source, bench: Bench) -> Result<TestFile, Vec<Fault>> {
        TestFile::load(name, source, &self.around, bench)
    }

    /// Runs a city script, and finds what is wrong in it and in all rules that it names.
    pub fn check_city(&self, source: &Source, sites: Arc<dyn Sites>) -> Checked {
        city::check(source, &self.around, sites, true)
    }

    /// Runs a city script; `sites` tells what folders of maps hold.
    pub fn plan(&self, source: &Source, sites: Arc<dyn Sites>) -> Result<Evaluated, Fault> {
        city::evaluate(source, &self.around, sites)
    }
}
