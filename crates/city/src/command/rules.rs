//! `plat rules`: what rules and presets there are, and what can be set in them.

use super::{Failure, RulesArguments, Status};
use city::testing::picture;
use city::{FaultReport, rule_host};
use script::{Domain, Host, Param, Preset, Rule};
use serde::Serialize;
use std::path::Path;

/// A rule as it is listed.
#[derive(Serialize)]
struct Listed {
    name: String,
    file: String,
    about: String,
    /// The functions that make it a rule.
    decides: Vec<&'static str>,
    params: Vec<ListedParam>,
}

/// A preset as it is listed.
#[derive(Serialize)]
struct ListedPreset {
    name: String,
    file: String,
    about: String,
    /// The class of streets that it is made for.
    class: &'static str,
    /// The rules in it, with the values that it chooses.
    rules: Vec<ChosenRule>,
}

/// A rule of a preset.
#[derive(Serialize)]
struct ChosenRule {
    role: String,
    rule: String,
    values: serde_json::Map<String, serde_json::Value>,
}

/// A parameter as it is listed.
#[derive(Serialize)]
struct ListedParam {
    name: String,
    /// `number`, `whole`, `choice`, `flag`, `map` or `colour`.
    kind: &'static str,
    /// `m`, `°` or nothing.
    unit: String,
    default: String,
    /// Least and greatest value of a number; open where there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    range: Option<[Option<f64>; 2]>,
    /// The words of a choice.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    words: Vec<String>,
    about: String,
}

/// Lists the rules of the library and of `--rules`, or those that are called so.
pub fn run(arguments: &RulesArguments) -> Result<Status, Failure> {
    let host = rule_host(arguments.rules.as_deref()).map_err(super::build::unreadable)?;
    // By the beginning of its name, or by what follows its folder: `streets`, `streets/grid`, `grid`.
    let is_called = |name: &str, asked: &str| name.starts_with(asked) || name.rsplit('/').next() == Some(asked);
    let wanted =
        |name: &String| arguments.names.is_empty() || arguments.names.iter().any(|asked| is_called(name, asked));
    let names: Vec<String> = host.names().into_iter().filter(wanted).collect();
    let presets: Vec<String> = host.preset_names().into_iter().filter(wanted).collect();
    let is_there = |asked: &&String| names.iter().chain(&presets).any(|name| is_called(name, asked));
    if let Some(asked) = arguments.names.iter().find(|asked| !is_there(asked)) {
        let fault = host.rule(asked).err();
        let hint = fault.and_then(|fault| fault.hint).map_or(String::new(), |hint| format!("\n  hint: {hint}"));
        return Err(Failure::new(Status::Usage, format!("there is no rule `{asked}`{hint}")));
    }
    if arguments.source {
        return Ok(print_sources(&host, names.iter().chain(&presets)));
    }
    let (mut rules, mut faults) = (Vec::new(), Vec::new());
    for name in &names {
        match host.rule(name) {
            Ok(rule) => rules.push(listed(&rule)),
            // Listing goes on without it.
            Err(fault) => faults.push(FaultReport::from(&fault)),
        }
    }
    let mut found = Vec::new();
    for name in &presets {
        match host.preset(name) {
            Ok(preset) => found.push(preset),
            Err(found) => faults.extend(found.iter().map(FaultReport::from)),
        }
    }
    let listed: Vec<ListedPreset> = found.iter().map(listed_preset).collect();
    super::faults::tell(&faults, host.texts());
    if arguments.json {
        println!("{}", serde_json::json!({ "rules": rules, "presets": listed, "faults": faults }));
    } else {
        let with_params = !arguments.names.is_empty() || arguments.params;
        print!("{}{}", text(&rules, with_params), presets_text(&listed, with_params));
    }
    if let Some(folder) = &arguments.pictures {
        draw(&found, folder)?;
    }
    Ok(if faults.is_empty() { Status::Done } else { Status::Faults })
}

/// Prints the texts of scripts.
fn print_sources<'a>(host: &Host, names: impl Iterator<Item = &'a String>) -> Status {
    let mut status = Status::Done;
    for name in names {
        match host.source(name) {
            Ok(source) => print!("{}", source.text),
            Err(fault) => {
                super::faults::tell(&[FaultReport::from(&fault)], host.texts());
                status = Status::Faults;
            }
        }
    }
    status
}

/// Draws a picture of each preset.
fn draw(presets: &[Preset], folder: &Path) -> Result<(), Failure> {
    let failed = |path: &Path, error: &dyn std::fmt::Display| {
        Failure::new(Status::Failed, format!("{}: {error}", path.display()))
    };
    std::fs::create_dir_all(folder).map_err(|error| failed(folder, &error))?;
    for preset in presets {
        let name = preset.name().rsplit('/').next().unwrap_or_default();
        let path = folder.join(format!("{name}.png"));
        let png = picture(preset).map_err(|error| failed(Path::new(preset.path()), &error))?;
        std::fs::write(&path, png).map_err(|error| failed(&path, &error))?;
    }
    Ok(())
}

fn listed_preset(preset: &Preset) -> ListedPreset {
    let chosen = |(role, rule): (String, &Rule)| {
        let values = rule.params().iter().filter(|(param, value)| value.constant() != Some(&param.default));
        let values = values.map(|(param, value)| (param.name.clone(), value.to_string().into())).collect();
        ChosenRule { role, rule: rule.name().to_owned(), values }
    };
    ListedPreset {
        name: preset.name().to_owned(),
        file: preset.path().to_owned(),
        about: preset.about().to_owned(),
        class: preset.class(),
        rules: preset.rules().into_iter().map(chosen).collect(),
    }
}

/// As people read them: a line a preset, with its rules and values below where they are asked for.
fn presets_text(presets: &[ListedPreset], with_values: bool) -> String {
    let mut lines = String::new();
    let widest = presets.iter().map(|preset| preset.name.chars().count()).max().unwrap_or(0);
    for preset in presets {
        if !with_values {
            lines += &format!("{:widest$}  {}\n", preset.name, preset.about);
            continue;
        }
        lines += &format!("\n{}  {}\n  {}, for {}\n", preset.name, preset.about, preset.file, preset.class);
        for rule in &preset.rules {
            let values =
                rule.values.iter().map(|(name, value)| format!("{name} {}", value.as_str().unwrap_or_default()));
            lines += &format!("  {:11}  {}: {}\n", rule.role, rule.rule, values.collect::<Vec<_>>().join(", "));
        }
    }
    if !with_values && !presets.is_empty() {
        lines += "\nWhat is in one: plat rules presets/NAME; laid on a city: plat build CITY --preset NAME\n";
    }
    lines
}

fn listed(rule: &Rule) -> Listed {
    Listed {
        name: rule.name().to_owned(),
        file: rule.path().to_owned(),
        about: rule.about().to_owned(),
        decides: rule.kinds().iter().map(|kind| kind.function()).collect(),
        params: rule.params().iter().map(|(param, _)| param_of(param)).collect(),
    }
}

fn param_of(param: &Param) -> ListedParam {
    let (mut unit, mut range, mut words) = (String::new(), None, Vec::new());
    let kind = match &param.domain {
        Domain::Number { unit: of, range: (low, high) } => {
            unit = of.suffix().trim().to_owned();
            range = Some([low, high].map(|end| end.is_finite().then_some(*end)));
            "number"
        }
        Domain::Whole { range: (low, high) } => {
            let end = |end: i64| (end != i64::MIN && end != i64::MAX).then_some(end as f64);
            range = Some([end(*low), end(*high)]);
            "whole"
        }
        Domain::Choice(all) => {
            words.clone_from(all);
            "choice"
        }
        Domain::Flag => "flag",
        Domain::Map => "map",
        Domain::Colour => "colour",
    };
    let (name, default, about) = (param.name.clone(), param.default.to_string(), param.about.clone());
    ListedParam { name, kind, unit, default, range, words, about }
}

/// As people read it: a line a rule, with its parameters below where they are asked for.
fn text(rules: &[Listed], with_params: bool) -> String {
    let widest = rules.iter().map(|rule| rule.name.chars().count()).max().unwrap_or(0);
    let mut lines = String::new();
    for (i, rule) in rules.iter().enumerate() {
        if !with_params {
            lines += &format!("{:widest$}  {}\n", rule.name, rule.about);
            continue;
        }
        let gap = if i > 0 { "\n" } else { "" };
        lines += &format!("{gap}{}  {}\n  {}\n", rule.name, rule.about, rule.file);
        let rows: Vec<[String; 4]> = rule.params.iter().map(row).collect();
        let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let (name, default, range) = (width(0), width(1), width(2));
        for row in &rows {
            let line = format!("  {:name$}  {:>default$}  {:range$}  {}", row[0], row[1], row[2], row[3]);
            lines += &format!("{}\n", line.trim_end());
        }
    }
    if !with_params && !rules.is_empty() {
        lines += "\nWhat can be set in one: plat rules NAME\n";
    }
    lines
}

/// Name, default with unit, range or words, help.
fn row(param: &ListedParam) -> [String; 4] {
    let unit = match param.unit.as_str() {
        "" | "°" => param.unit.clone(),
        unit => format!(" {unit}"),
    };
    let end = |end: Option<f64>| end.map_or("…".to_owned(), |end| end.to_string());
    let bounds = match (param.range, param.kind) {
        (Some([None, None]), _) => String::new(),
        (Some([low, high]), _) => format!("{} to {}", end(low), end(high)),
        (None, "flag") => "true or false".into(),
        (None, "map") => "a map".into(),
        (None, "colour") => "#rrggbb".into(),
        (None, _) => param.words.join(", "),
    };
    [param.name.clone(), format!("{}{unit}", param.default), bounds, param.about.clone()]
}
