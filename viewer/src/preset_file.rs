//! Presets that people save: a file in the city's folder with the rules in force and the values that differ from the rules' own.

use script::{Literal, Plan, Rule};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The roles of a preset, with what they are called in a plan.
const ROLES: [(&str, &str); 3] = [("pattern", "minors.pattern"), ("parcels", "parcels"), ("buildings", "buildings")];

/// Writes a preset of what a plan says of minors, parcels and buildings into the folder of a city; one of that name is not
/// written over. Returns the file, and the roles that no preset can hold, such as mixed patterns.
///
/// # Errors
/// When the name does not do, there is one already, the plan has nothing to save, or the file cannot be written.
pub fn save(plan: &Plan, folder: &Path, name: &str, city: &str) -> Result<(PathBuf, Vec<&'static str>), String> {
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
    let (text, left_out) =
        text(plan, name, city).ok_or("there is nothing to save: no role is played by a single rule")?;
    let failed = |error: &dyn std::fmt::Display| format!("the preset could not be saved: {error}");
    std::fs::create_dir_all(path.parent().unwrap_or(folder)).map_err(|error| failed(&error))?;
    city::export::write_atomically(&path, |out| out.write_all(text.as_bytes())).map_err(|error| failed(&error))?;
    Ok((path, left_out))
}

/// The text of a preset; `None` where it would hold nothing.
fn text(plan: &Plan, name: &str, city: &str) -> Option<(String, Vec<&'static str>)> {
    let mut left_out = Vec::new();
    let title: String = name.replace('_', " ");
    let mut text = format!("//! {title}: saved from {city}.\n\npreset(#{{\n");
    let start = text.len();
    for (key, role) in ROLES {
        match plan.rule_of(role) {
            Some(rule) if is_plain(rule) => {
                let _ = writeln!(text, "    {key}: {},", of_rule(rule));
            }
            // By place, or of several rules.
            _ if plan.roles().iter().any(|(other, _)| other.starts_with(role)) => left_out.push(key),
            _ => {}
        }
    }
    let width = plan.minors.as_ref().and_then(script::StreetPlan::constant_width);
    if let Some(width) = width.filter(|_| text.contains("    pattern:")) {
        let _ = writeln!(text, "    width: {width},");
    }
    (text.len() > start).then(|| (text + "});\n", left_out))
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
        let (path, left_out) = save(&loaded.plan, folder.path(), "my_own", "Town").unwrap();
        assert!(path.ends_with("presets/my_own.rhai") && left_out.is_empty());
        let again = load(folder.path(), None).unwrap();
        let preset = again.host.preset("my_own").unwrap();
        assert_eq!(preset.about(), "my own: saved from Town.");
        for (key, role) in ROLES {
            let rules = preset.rules();
            let (_, saved) = rules.iter().find(|(name, _)| name == key).unwrap();
            let before = loaded.plan.rule_of(role).unwrap();
            let values = |rule: &Rule| rule.params().iter().map(|(_, value)| value.clone()).collect::<Vec<_>>();
            assert_eq!((saved.name(), values(saved)), (before.name(), values(before)));
        }
        assert_eq!(preset.streets().and_then(script::StreetPlan::constant_width), Some(9.0));
    }

    #[test]
    fn nothing_is_written_over_and_names_are_held_to_their_form() {
        let folder = tempfile::tempdir().unwrap();
        let loaded = city(folder.path());
        let save = |name: &str| super::save(&loaded.plan, folder.path(), name, "Town");
        save("twice").unwrap();
        assert!(save("twice").unwrap_err().contains("already"));
        for name in ["", "../up", "Großstadt", "1st", "a b", "a.rhai"] {
            assert!(save(name).unwrap_err().contains("no name"), "{name}");
        }
    }
}
