//! What a mutant is asked about, and what its answers must keep to.

use crate::common::{Folders, shelf};
use crate::mutate::Draws;
use geom::{Angle, Bounds, Point, Polygon, Raster, Seed, Vec2};
use script::{
    AssignPattern, BareGround, BlockContext, BuildingPattern, ConstraintPattern, Fault, Faults, Ground, Host,
    ParcelPattern, Places, Plan, Rule, RuleKind, ShapeContext, Source, StreetPattern, StreetSide,
};
use std::collections::BTreeMap;
use std::fmt::Debug;
use std::sync::Arc;
use streets::growth::{Chain, Constrain, Draft, Field, Fields, GrowthRules, Step, Tip};
use streets::{Classes, Districts};

/// Width and height of the site in metres.
const SIDE: f64 = 2_000.0;
/// Cells of a map in a row.
const CELLS: usize = 40;
/// The file of a mutant.
const FILE: &str = "mine.rhai";

/// A site with maps and districts.
pub struct World {
    classes: Arc<Classes>,
    fields: Arc<Fields>,
    plain: Arc<Fields>,
}

/// What came of a mutant.
pub struct Tried {
    pub is_loaded: bool,
    pub faults: u64,
}

/// Land with the maps of the site.
#[derive(Debug)]
struct Mapped(Arc<Fields>);

impl Ground for Mapped {
    fn map(&self, name: &str, at: Vec2) -> Option<f64> {
        self.0.maps.get(name).map(|field| field.at(at))
    }

    fn zone(&self, name: &str, at: Vec2) -> Option<f64> {
        self.map(name, at).map(f64::round)
    }

    fn maps(&self) -> Vec<String> {
        self.0.maps.keys().cloned().collect()
    }

    fn distance(&self, class: &str, at: Vec2) -> Option<f64> {
        BareGround.distance(class, at).map(|far| if class == "major" { at.length() } else { far })
    }

    fn classes(&self) -> Vec<String> {
        BareGround.classes()
    }
}

fn map_of(value: impl Fn(f64, f64) -> f64) -> Arc<Raster> {
    let cell = |i: usize| value((i % CELLS) as f64 / CELLS as f64, 1.0 - (i / CELLS) as f64 / CELLS as f64) as f32;
    let values = (0..CELLS * CELLS).map(cell).collect();
    Arc::new(Raster::new(CELLS, CELLS, SIDE / CELLS as f64, Vec2::ZERO, values).expect("a map"))
}

fn corner(x: f64, y: f64) -> Point {
    Point::from_metres(Vec2::new(x, y))
}

/// The same land everywhere, with two districts.
fn districts() -> Arc<Districts> {
    let area = |a, b| Polygon::rectangle(Bounds::between(a, b));
    let areas =
        vec![(1, area(corner(0.0, 0.0), corner(900.0, SIDE))), (0, area(corner(1500.0, 0.0), corner(SIDE, 400.0)))];
    Arc::new(Districts::of_areas(vec!["harbour".into(), "old town".into()], areas))
}

impl World {
    pub fn new() -> Self {
        let bounds = Bounds::between(corner(0.0, 0.0), corner(SIDE, SIDE));
        let land = map_of(|x, _| if x < 0.9 { 1.0 } else { 0.0 });
        let parks = map_of(|x, y| if (x - 0.5).abs() < 0.1 && (y - 0.5).abs() < 0.1 { 1.0 } else { 0.0 });
        let hill = |x: f64, y: f64| 1.0 - (x - 0.3) * (x - 0.3) - (y - 0.6) * (y - 0.6);
        let (density, elevation) = (map_of(move |x, y| 20_000.0 * hill(x, y)), map_of(move |x, y| 150.0 * hill(x, y)));
        let maps =
            [("density", &density), ("elevation", &elevation), ("parks", &parks), ("land", &land), ("borough", &land)];
        let named = |(name, map): (&str, &Arc<Raster>)| (name.to_owned(), Field::Map(map.clone()));
        let maps: BTreeMap<String, Field> = maps.into_iter().map(named).collect();
        let plain = Arc::new(Fields::plain(bounds));
        let fields = Fields {
            legal: vec![land.clone()],
            land: Some(land),
            barred: vec![parks],
            density: Field::Map(density),
            elevation: Field::Map(elevation),
            maps,
            districts: districts(),
            ..Fields::plain(bounds)
        };
        Self { classes: Arc::new(Classes::default()), fields: Arc::new(fields), plain }
    }

    /// Loads a mutant, checks it, and asks it everything.
    pub fn try_rule(&self, text: &str, draws: &mut Draws) -> Result<Tried, String> {
        let mut judge = Judge { text: Some(text), faults: 0 };
        let source = Source { text: text.to_owned(), path: FILE.into() };
        let host = Host::new(vec![shelf(&[(FILE, text)])]);
        // It loads the rule once more, which takes most of the time.
        if draws.one_in(3) {
            judge.all(&host.check_rule("mine", &source))?;
        }
        let rule = match host.rule_of("mine", &source) {
            Ok(rule) => rule,
            Err(fault) => {
                judge.all(&[fault])?;
                return Ok(Tried { is_loaded: false, faults: judge.faults });
            }
        };
        let rule = with_other_value(rule, draws)?;
        let answers = self.ask(&rule, &mut judge)?;
        if draws.one_in(4) {
            self.compare_telling(&rule, &answers)?;
        }
        let is_told_once = [RuleKind::Goals, RuleKind::Constraints].iter().any(|kind| rule.kinds().contains(kind));
        if is_told_once || draws.one_in(6) {
            self.ask_in_city(&host, &rule, draws, &mut judge)?;
        }
        Ok(Tried { is_loaded: true, faults: judge.faults })
    }

    /// A rule that tells what it does decides the same, and fails in the same way.
    fn compare_telling(&self, rule: &Rule, answers: &[String]) -> Result<(), String> {
        let (telling, account) = rule.telling();
        // Columns are those of the text that tells.
        let told = self.ask(&telling, &mut Judge { text: None, faults: 0 })?;
        account.take();
        // A rule that tells may do more: it runs into the limit later.
        let is_limited = |answers: &[String]| answers.iter().any(|answer| answer.contains(" operations"));
        if told == answers || is_limited(&told) || is_limited(answers) {
            return Ok(());
        }
        Err(format!("it tells what it does, and decides otherwise:\n{told:?}\nnot\n{answers:?}"))
    }

    /// Asks a rule about street ends, streets, blocks and parcels, whatever it decides: all that it says.
    fn ask(&self, rule: &Rule, judge: &mut Judge<'_>) -> Result<Vec<String>, String> {
        let (faults, mut answers) = (Arc::new(Faults::default()), Vec::new());
        for kind in rule.kinds() {
            match kind {
                RuleKind::Streets => answers.extend(self.ask_tips(rule, &faults)?),
                RuleKind::Constrain => answers.extend(self.ask_drafts(rule, &faults)?),
                RuleKind::Parcels => answers.extend(self.ask_blocks(rule, &faults)?),
                RuleKind::Assign => {
                    let pattern = AssignPattern::new(rule.clone(), faults.clone());
                    answers.extend(self.shapes().map(|shape| format!("{:?}", pattern.assign(shape))));
                }
                RuleKind::Buildings => answers.extend(self.ask_shapes(rule, &faults)?),
                RuleKind::Goals | RuleKind::Constraints => {}
            }
        }
        let faults = faults.sorted();
        answers.extend(faults.iter().map(|fault| fault.message.clone()));
        judge.all(&faults).map(|()| answers)
    }

    fn ask_tips(&self, rule: &Rule, faults: &Arc<Faults>) -> Result<Vec<String>, String> {
        let pattern = StreetPattern::new(rule.clone(), 1, self.classes.clone(), faults.clone());
        let seed = Tip::new(Classes::MINOR, Seed(1), self.fields.clone());
        let tips = [
            Tip { at: corner(700.0, 900.0), ..seed.clone() },
            Tip {
                at: corner(950.0, 900.0),
                heading: Angle::degrees(-135.0),
                is_seed: false,
                age: 3,
                length: 240.0,
                ..seed.clone()
            },
            Tip {
                at: corner(1790.0, 20.0),
                is_seed: false,
                generation: 4,
                step: 90,
                class: Classes::HIGHWAY,
                seed: Seed(9),
                ..seed.clone()
            },
            Tip {
                at: corner(-300.0, 5e5),
                heading: Angle::degrees(1234.5),
                fields: self.plain.clone(),
                is_seed: false,
                ..seed
            },
        ];
        let ask = |mut tip: Tip| {
            pattern.propose(&mut tip);
            finite(&(tip.slots, tip.steered()))
        };
        tips.into_iter().map(ask).collect()
    }

    fn ask_drafts(&self, rule: &Rule, faults: &Arc<Faults>) -> Result<Vec<String>, String> {
        let constraint = ConstraintPattern::new(rule.clone(), self.classes.clone(), faults.clone());
        let draft = |from: Vec2, along: Vec2, fields: &Arc<Fields>| Draft {
            id: geom::Id::default(),
            from,
            to: from + along,
            heading: Angle::of(along),
            class: Classes::MINOR,
            level: 0,
            meets_street: along.x > 0.0,
            seed: Seed(3),
            fields: fields.clone(),
            refused: None,
        };
        let drafts = [
            draft(Vec2::splat(700.0), Vec2::new(300.0, 90.0), &self.fields),
            draft(Vec2::new(1700.0, 10.0), Vec2::new(-5.0, -90.0), &self.fields),
            draft(Vec2::ZERO, Vec2::Y, &self.plain),
        ];
        let ask = |mut draft: Draft| {
            constraint.constrain(&mut draft);
            let laid = finite(&(draft.from, draft.to, draft.heading))?;
            Ok(format!("{laid}, {:?}", draft.refused))
        };
        drafts.into_iter().map(ask).collect()
    }

    fn ask_blocks(&self, rule: &Rule, faults: &Arc<Faults>) -> Result<Vec<String>, String> {
        let pattern = ParcelPattern::new(rule.clone(), faults.clone());
        let bare = BlockContext::bare(9_000.0, Seed(4));
        let settled = BlockContext {
            density: 12_000.0,
            place: Vec2::splat(700.0),
            district: "old town".into(),
            streets: sides(),
            ground: Arc::new(Mapped(self.fields.clone())),
            ..bare.clone()
        };
        let blocks = [bare, BlockContext::bare(0.0, Seed(5)), settled];
        blocks.into_iter().map(|block| finite(&pattern.choose(block))).collect()
    }

    fn ask_shapes(&self, rule: &Rule, faults: &Arc<Faults>) -> Result<Vec<String>, String> {
        let pattern = BuildingPattern::new(rule.clone(), faults.clone());
        self.shapes().into_iter().map(|shape| finite(&pattern.choose(shape))).collect()
    }

    fn shapes(&self) -> [ShapeContext; 3] {
        let bare = ShapeContext::bare(600.0, Seed(6));
        let settled = ShapeContext {
            is_corner: true,
            density: 12_000.0,
            max_height: 40.0,
            place: Vec2::splat(700.0),
            landmark: "Cathedral".into(),
            streets: sides(),
            ground: Arc::new(Mapped(self.fields.clone())),
            ..bare.clone()
        };
        [bare, ShapeContext::bare(0.0, Seed(7)), settled]
    }

    /// Gives a rule all roles of a city that it can play, one of its parameters perhaps read from a map.
    fn ask_in_city(&self, host: &Host, rule: &Rule, draws: &mut Draws, judge: &mut Judge<'_>) -> Result<(), String> {
        let source = Source { text: city_of(rule, draws), path: "city.rhai".into() };
        let mut plan = match host.plan(&source, Arc::new(Folders)) {
            Ok(evaluated) => evaluated.plan,
            Err(fault) => return judge.all(&[fault]),
        };
        self.ask_plan(&plan, judge)?;
        let places = Places { maps: self.fields.maps.clone(), districts: districts() };
        if let Err(error) = plan.settle(places) {
            return if error.message.is_empty() { Err("an error without words".into()) } else { Ok(()) };
        }
        self.ask_plan(&plan, judge)?;
        plan.roles()
            .into_iter()
            .filter(|(_, rule)| rule.path() == FILE)
            .try_for_each(|(_, rule)| self.ask(rule, judge).map(drop))
    }

    fn ask_plan(&self, plan: &Plan, judge: &mut Judge<'_>) -> Result<(), String> {
        let Some(minors) = &plan.minors else { return Ok(()) };
        match minors.goal() {
            // A map that nothing holds has endless ends.
            Ok(goal) => number(&goal)?,
            Err(fault) => judge.all(&[fault])?,
        }
        let faults = Arc::new(Faults::default());
        match minors.chain(Chain::new(vec![Step::Crossing]), &self.classes, &faults) {
            Ok(chain) => {
                number(&chain.steps().iter().filter(|step| !matches!(step, Step::Own(_))).collect::<Vec<_>>())?
            }
            Err(fault) => judge.all(&[fault])?,
        }
        judge.all(&faults.sorted())
    }
}

fn sides() -> Vec<StreetSide> {
    let side = |class: &str, width, length| StreetSide { class: class.into(), width, length };
    vec![side("major", 26.0, 80.0), side("minor", 12.0, 45.5)]
}

/// The rule with one parameter set to some text, where that is taken.
fn with_other_value(rule: Rule, draws: &mut Draws) -> Result<Rule, String> {
    let names: Vec<String> = rule.params().iter().map(|(param, _)| param.name.clone()).collect();
    if names.is_empty() || !draws.one_in(3) {
        return Ok(rule);
    }
    let (name, text) = (draws.pick(&names), draws.pick(&VALUES));
    match rule.with_text(name, text) {
        Ok(rule) => Ok(rule),
        Err(error) if error.message.is_empty() => Err("an error without words".into()),
        Err(_) => Ok(rule),
    }
}

/// Texts that people may give parameters.
const VALUES: [&str; 24] = [
    "",
    " ",
    "0",
    "-1",
    "1",
    "360",
    "1e308",
    "-1e308",
    "1e-308",
    "NaN",
    "inf",
    "9223372036854775807",
    "0x10",
    "true",
    "no",
    "#fff",
    "#ffffff",
    "density",
    "nowhere",
    "best",
    "ä\u{0}\n",
    "1,5",
    "100 m",
    "65536",
];

/// A city script in which the rule plays every role that it can.
fn city_of(rule: &Rule, draws: &mut Draws) -> String {
    let has = |kind| rule.kinds().contains(&kind);
    let names: Vec<&str> = rule.params().iter().map(|(param, _)| param.name.as_str()).collect();
    let values = if names.is_empty() || draws.one_in(3) {
        String::new()
    } else {
        format!(", #{{ {}: {} }}", draws.pick(&names), draws.pick(&BY_PLACE))
    };
    let mine = format!("rule(\"mine\"{values})");
    let pattern = if has(RuleKind::Streets) { mine.clone() } else { "rule(\"streets/grid\")".to_owned() };
    let mut minors = format!("pattern: {pattern}");
    if has(RuleKind::Goals) {
        minors += &format!(", goals: {mine}");
    }
    if has(RuleKind::Constraints) || has(RuleKind::Constrain) {
        minors += &format!(", constraints: {mine}");
    }
    let mut rest = String::new();
    for (kind, role) in [(RuleKind::Parcels, "parcels"), (RuleKind::Buildings, "buildings")] {
        if has(kind) {
            rest += &format!(", {role}: {mine}");
        }
    }
    format!("let site = site(\"maps\");\ncity(#{{ site: site, minors: streets(#{{ {minors} }}){rest} }});")
}

/// Values that differ by place.
const BY_PLACE: [&str; 8] = [
    "site.map(\"density\")",
    "site.map(\"parks\").between(50, 90)",
    "site.map(\"elevation\").scale(1e308, -1e308)",
    "site.map(\"land\").clamp(0, 1)",
    "by_district(#{ \"old town\": 20, harbour: site.map(\"land\").between(10, 60) }, 80)",
    "by_district(#{ nowhere: 3 })",
    "by_district(#{ harbour: \"x\" }, true)",
    "[1, 2]",
];

/// Judges what was told of a mutant.
struct Judge<'a> {
    /// Where faults must have their places.
    text: Option<&'a str>,
    faults: u64,
}

impl Judge<'_> {
    fn all(&mut self, faults: &[Fault]) -> Result<(), String> {
        self.faults += faults.len() as u64;
        faults.iter().try_for_each(|fault| self.one(fault).map_err(|wrong| format!("{wrong}: {fault:?}")))
    }

    fn one(&self, fault: &Fault) -> Result<(), &'static str> {
        if fault.message.starts_with("the program failed inside") {
            return Err("a panic in native code");
        }
        if fault.message.trim().is_empty() || fault.hint.as_ref().is_some_and(|hint| hint.trim().is_empty()) {
            return Err("a fault without words");
        }
        let is_inside = |file: &str, line: u32, column: u32| file != FILE || self.has_place(line, column);
        let calls = fault.calls.iter().all(|call| is_inside(&call.file, call.line, call.column));
        if calls && is_inside(&fault.file, fault.line, fault.column) { Ok(()) } else { Err("a place outside the text") }
    }

    /// Whether a place lies in the text, or right behind the end of it or of a line.
    fn has_place(&self, line: u32, column: u32) -> bool {
        let Some(text) = self.text else { return true };
        let lines: Vec<&str> = text.split('\n').collect();
        let row = (line as usize).checked_sub(1).and_then(|row| lines.get(row));
        let most = row.map_or(1, |row| row.chars().count() + 1);
        line as usize <= lines.len() + 1 && column as usize <= most
    }
}

/// The value in words; every number of it must be finite.
fn finite(value: &impl Debug) -> Result<String, String> {
    number(value)?;
    let told = format!("{value:?}");
    if told.contains("inf") { Err(format!("an endless number: {told}")) } else { Ok(told) }
}

/// Every number of a value must be one.
fn number(value: &impl Debug) -> Result<(), String> {
    let told = format!("{value:?}");
    if told.contains("NaN") { Err(format!("no number: {told}")) } else { Ok(()) }
}
