//! Presets that people save: a file in the city's folder with the rules in force and the values that differ from the rules' own.
//! Laid on the city that it was saved from, a preset changes nothing.

use script::{GoalPlan, Literal, Plan, Rule, StreetPlan};
use std::path::{Path, PathBuf};

/// Writes a preset of what a plan says of a class of streets, and with minors of parcels and buildings, into the folder of a
/// city; one of that name is not written over. Returns the file, and the parts that no preset can hold, such as mixed patterns.
///
/// # Errors
/// When the name does not do, there is one already, the plan has nothing to save, or the file cannot be written.
pub fn save(
    plan: &Plan,
    class: &str,
    folder: &Path,
    name: &str,
    city: &str,
) -> Result<(PathBuf, Vec<&'static str>), String> {
    let fits = |name: &str| {
        let mut letters = name.chars();
        letters.next().is_some_and(|first| first.is_ascii_lowercase())
            && letters.all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
    };
    if !fits(name) {
        return Err(format!("`{name}` is no name of a preset: write small letters, digits and _, a letter first"));
    }
    let path = folder.join("presets").join(format!("{name}.rhai"));
    if path.exists() {
        return Err(format!("{} is there already: choose another name", path.display()));
    }
    let nothing = "there is nothing to save: no role is played by a single rule whose values are the same everywhere";
    let (text, left_out) = text(plan, class, name, city).ok_or(nothing)?;
    let failed = |error: &dyn std::fmt::Display| format!("the preset could not be saved: {error}");
    std::fs::create_dir_all(path.parent().unwrap_or(folder)).map_err(|error| failed(&error))?;
    city::export::write_atomically(&path, |out| out.write_all(text.as_bytes())).map_err(|error| failed(&error))?;
    Ok((path, left_out))
}

/// The text of a preset; `None` where it would hold nothing.
fn text(plan: &Plan, class: &str, name: &str, city: &str) -> Option<(String, Vec<&'static str>)> {
    let title: String = name.replace('_', " ");
    let mut parts = Parts::default();
    let streets = match class {
        "highways" => &plan.highways,
        "majors" => &plan.majors,
        _ => &plan.minors,
    };
    if let Some(streets) = streets {
        parts.streets(plan, streets, class);
    }
    if class == "minors" {
        for role in ["parcels", "buildings"] {
            parts.rule(plan, role, role);
        }
    } else if !parts.lines.is_empty() {
        parts.lines.push(format!("class: \"{class}\""));
    }
    if parts.lines.is_empty() {
        return None;
    }
    let lines: String = parts.lines.iter().fold(String::new(), |lines, line| lines + "    " + &line[..] + ",\n");
    Some((format!("//! {title}: saved from {city}.\n\npreset(#{{\n{lines}}});\n"), parts.left_out))
}

/// The lines of a preset, and what no preset can hold.
#[derive(Default)]
struct Parts {
    lines: Vec<String>,
    left_out: Vec<&'static str>,
}

impl Parts {
    /// The rule of a role; whether there is one that can be written.
    fn rule(&mut self, plan: &Plan, key: &'static str, role: &str) -> bool {
        match plan.rule_of(role) {
            Some(rule) if is_plain(rule) => {
                self.lines.push(format!("{key}: {}", of_rule(rule)));
                return true;
            }
            // By place, or of several rules.
            _ if plan.roles().iter().any(|(other, _)| other.starts_with(role)) => self.left_out.push(key),
            _ => {}
        }
        false
    }

    /// All that a plan says of the streets of a class, but where they grow: that is the city's.
    fn streets(&mut self, plan: &Plan, streets: &StreetPlan, class: &str) {
        if !self.rule(plan, "pattern", &format!("{class}.pattern")) {
            return;
        }
        match &streets.constraints[..] {
            [] => {}
            [rule] if is_plain(rule) => self.lines.push(format!("constraints: {}", of_rule(rule))),
            rules if rules.iter().all(is_plain) => {
                let rules: Vec<String> = rules.iter().map(of_rule).collect();
                self.lines.push(format!("constraints: [{}]", rules.join(", ")));
            }
            _ => self.left_out.push("constraints"),
        }
        if let Some(GoalPlan::Rule(_)) = streets.goals {
            self.rule(plan, "goals", &format!("{class}.goals"));
        }
        match (streets.constant_width(), &streets.width) {
            (Some(width), _) => self.lines.push(format!("width: {width}")),
            (None, Some(_)) => self.left_out.push("width"),
            (None, None) => {}
        }
        self.lines.extend(streets.reseed.map(|metres| format!("reseed: {metres}")));
        self.lines.extend(streets.smooth.map(|smooth| format!("smooth: {smooth}")));
        if !streets.sprout {
            self.lines.push("sprout: false".into());
        }
        for (key, metres) in [("least_dead_end", streets.least_dead_end), ("least_network", streets.least_network)] {
            if metres > 0.0 {
                self.lines.push(format!("{key}: {metres}"));
            }
        }
    }
}

/// Whether all values are the same everywhere.
fn is_plain(rule: &Rule) -> bool {
    rule.params().iter().all(|(_, value)| value.constant().is_some())
}

fn of_rule(rule: &Rule) -> String {
    let values = rule.params().iter().filter_map(|(param, value)| {
        let value = value.constant().filter(|value| **value != param.default)?;
        Some(format!("{}: {}", param.name, of_value(value)))
    });
    let values: Vec<String> = values.collect();
    let name = rule.name();
    if values.is_empty() {
        format!("rule(\"{name}\")")
    } else {
        format!("rule(\"{name}\", #{{ {} }})", values.join(", "))
    }
}

/// A value as scripts write it.
fn of_value(value: &Literal) -> String {
    match value {
        Literal::Number(_) | Literal::Whole(_) | Literal::Flag(_) => value.to_string(),
        Literal::Choice(_) | Literal::Map(_) | Literal::Colour(_) => format!("\"{value}\""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use city::load;

    fn city(folder: &Path) -> city::Loaded {
        let text = r#"
            city(#{
                site: site(#{ size: [400, 400] }),
                minors: streets(#{ pattern: rule("streets/grid", #{ block_width: 66.5 }), width: 9 }),
                parcels: rule("parcels/recursive"),
                buildings: rule("buildings/extruded", #{ high: 12 }),
            });
        "#;
        std::fs::write(folder.join("city.rhai"), text).unwrap();
        load(folder, None).unwrap()
    }

    #[test]
    fn what_is_saved_can_be_laid_and_says_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let loaded = city(folder.path());
        let (path, left_out) = save(&loaded.plan, "minors", folder.path(), "my_own", "Town").unwrap();
        assert!(path.ends_with("presets/my_own.rhai") && left_out.is_empty());
        let again = load(folder.path(), None).unwrap();
        let preset = again.host.preset("my_own").unwrap();
        assert_eq!(preset.about(), "my own: saved from Town.");
        for (key, role) in [("pattern", "minors.pattern"), ("parcels", "parcels"), ("buildings", "buildings")] {
            let rules = preset.rules();
            let (_, saved) = rules.iter().find(|(name, _)| name == key).unwrap();
            let before = loaded.plan.rule_of(role).unwrap();
            let values = |rule: &Rule| rule.params().iter().map(|(_, value)| value.clone()).collect::<Vec<_>>();
            assert_eq!((saved.name(), values(saved)), (before.name(), values(before)));
        }
        assert_eq!(preset.streets().and_then(script::StreetPlan::constant_width), Some(9.0));
    }

    #[test]
    fn what_is_saved_of_each_shipped_preset_grows_the_same_city() {
        let folder = tempfile::tempdir().unwrap();
        let script = r#"
            city(#{
                site: site(#{
                    size: [600, 500],
                    density: |x, y| 30000 * exp(-hypot(x - 230, y - 250) / 200),
                    elevation: |x, y| 40 * exp(-(pow(x - 330, 2) + pow(y - 240, 2)) / 15000),
                    land: |x, y| x > 60,
                    parks: |x, y| hypot(x - 450, y - 300) < 40,
                }),
                given: [line([[100, 60], [560, 60], [560, 440], [100, 440], [100, 60]])],
                majors: streets(#{ pattern: rule("streets/grid", #{ block_width: 250, block_length: 300 }) }),
                minors: streets(#{ pattern: rule("streets/grid"), constraints: rule("constraints/standard", #{ snap: 12 }) }),
                parcels: rule("parcels/recursive"),
                buildings: rule("buildings/extruded"),
            });
        "#;
        std::fs::write(folder.path().join("city.rhai"), script).unwrap();
        let load = || city::load::load_as_written(folder.path(), None).unwrap();
        let grown = |loaded: &city::Loaded| {
            let sources = loaded.read().unwrap();
            let built = city::build(&sources, city::Settings::default(), &city::Silent, &city::Cancel::default());
            let mut bytes = Vec::new();
            city::export::geojson::write_layout(&built.unwrap().city, &mut bytes).unwrap();
            bytes
        };
        let (bare, names) = (load(), load().host.preset_names());
        let before = grown(&bare);
        let mut different = 0;
        for name in names.iter().map(|name| name.trim_start_matches("presets/")) {
            let mut laid = load();
            let class = laid.host.preset(name).unwrap().class();
            laid.lay(&format!("city={name}")).unwrap();
            let own = format!("own_{name}");
            let (_, left_out) = save(&laid.plan, class, folder.path(), &own, "Town").unwrap();
            assert_eq!(left_out, Vec::<&str>::new(), "{name}");
            let mut again = load();
            again.lay(&format!("city={own}")).unwrap();
            let expected = grown(&laid);
            assert!(grown(&again) == expected, "{name}: {}", again.host.preset(&own).unwrap().path());
            different += usize::from(expected != before);
        }
        assert!(names.len() > 10 && different > 10, "{} presets, {different} of which show", names.len());
    }

    #[test]
    fn nothing_is_written_over_and_names_are_held_to_their_form() {
        let folder = tempfile::tempdir().unwrap();
        let loaded = city(folder.path());
        let save = |name: &str| super::save(&loaded.plan, "minors", folder.path(), name, "Town");
        save("twice").unwrap();
        assert!(save("twice").unwrap_err().contains("already"));
        for name in ["", "../up", "Großstadt", "1st", "a b", "a.rhai"] {
            assert!(save(name).unwrap_err().contains("no name"), "{name}");
        }
    }
}
