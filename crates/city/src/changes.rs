//! What people changed of a city without touching its script: presets they laid on it, values they set. Saved as text beside
//! the script, in lines that `plat build` takes as arguments, too.

use crate::{Loaded, PresetError};
use script::{ParamError, PresetTarget};
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// The version of the format that [`Changes::text`] writes.
const FORMAT: &str = "plat-changes 1";

/// What parts a line from the remark behind it.
const REMARK: &str = "  # ";

/// Changes of a city, in the order they are laid over its script: the seed, presets as they were laid, values.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changes {
    /// Another seed.
    pub seed: Option<u64>,
    /// Presets by what they are laid on, one each.
    presets: Vec<(PresetTarget, String)>,
    /// Values as they are written behind `--set`, by address.
    values: BTreeMap<String, String>,
}

/// Why changes could not be read or laid over a city.
#[derive(Debug, thiserror::Error)]
#[error("{}{}: {message}{}", path.display(), line.map_or(String::new(), |line| format!(":{line}")), hint.as_ref().map_or(String::new(), |hint| format!("\n  hint: {hint}")))]
pub struct ChangesError {
    /// The file.
    pub path: PathBuf,
    /// The line, from 1; none where it is not in the file.
    pub line: Option<usize>,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub hint: Option<String>,
}

/// A change, as a line says it.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Change {
    Seed(u64),
    Preset(PresetTarget, String),
    Value(String, String),
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Seed(seed) => write!(f, "seed {seed}"),
            Self::Preset(target, name) => write!(f, "preset {target}={name}"),
            Self::Value(address, value) => write!(f, "set {address}={value}"),
        }
    }
}

impl Changes {
    /// Where the changes of a city are saved: beside its script, under its name.
    pub fn file_of(script: &Path) -> PathBuf {
        script.with_extension("changes")
    }

    /// Those saved beside a script; none where there is no such file.
    ///
    /// # Errors
    /// When there is one that cannot be read.
    pub fn saved(script: &Path) -> Result<Self, ChangesError> {
        Ok(Self::read(&Self::file_of(script))?.unwrap_or_default())
    }

    /// Those in a file; `None` where there is no such file.
    ///
    /// # Errors
    /// When there is one that cannot be read.
    pub fn read(path: &Path) -> Result<Option<Self>, ChangesError> {
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&text).map(Some).map_err(|wrong| wrong.in_file(path)),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => {
                Err(ChangesError { path: path.to_path_buf(), line: None, message: error.to_string(), hint: None })
            }
        }
    }

    /// Whether nothing was changed.
    pub fn is_empty(&self) -> bool {
        self.lines().next().is_none()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.lines().count()
    }

    /// Lays a preset on something, in place of another one there.
    pub fn lay(&mut self, target: PresetTarget, preset: &str) {
        self.lift(&target);
        self.presets.push((target, preset.to_owned()));
    }

    /// Takes back the preset that was laid on something.
    pub fn lift(&mut self, target: &PresetTarget) {
        self.presets.retain(|(other, _)| other != target);
    }

    /// The presets with what they are laid on, in the order they were laid.
    pub fn presets(&self) -> impl Iterator<Item = (&PresetTarget, &str)> {
        self.presets.iter().map(|(target, name)| (target, &name[..]))
    }

    /// Sets a value as it is written behind `--set`.
    pub fn set(&mut self, address: &str, value: &str) {
        self.values.insert(address.to_owned(), value.to_owned());
    }

    /// Takes a value back.
    pub fn reset(&mut self, address: &str) {
        self.values.remove(address);
    }

    /// What a value was set to.
    pub fn value(&self, address: &str) -> Option<&str> {
        self.values.get(address).map(String::as_str)
    }

    /// All values by address.
    pub fn values(&self) -> impl Iterator<Item = (&str, &str)> {
        self.values.iter().map(|(address, value)| (&address[..], &value[..]))
    }

    /// The arguments of `plat build` that do the same.
    pub fn arguments(&self) -> Vec<String> {
        let argument = |change| match change {
            Change::Seed(seed) => ["--seed".to_owned(), seed.to_string()],
            Change::Preset(target, name) => ["--preset".to_owned(), format!("{target}={name}")],
            Change::Value(address, value) => ["--set".to_owned(), format!("{address}={value}")],
        };
        self.lines().flat_map(argument).collect()
    }

    fn lines(&self) -> impl Iterator<Item = Change> {
        let presets = self.presets.iter().map(|(target, name)| Change::Preset(target.clone(), name.clone()));
        let mut values: Vec<(&String, &String)> = self.values.iter().collect();
        // What holds everywhere would stand in place of what was said of a part before.
        values.sort_by_key(|(address, _)| (address.starts_with("quarter:"), address.starts_with("district:")));
        let values = values.into_iter().map(|(address, value)| Change::Value(address.clone(), value.clone()));
        self.seed.map(Change::Seed).into_iter().chain(presets).chain(values)
    }

    /// Lays the changes over a city that was just read.
    ///
    /// # Errors
    /// The first one that does not suit it, by its line in the file that they are saved in.
    pub fn lay_over(&self, loaded: &mut Loaded) -> Result<(), ChangesError> {
        self.lines().try_for_each(|change| lay(&change, loaded))
    }

    /// Lays those over a city that was just read that suit it. Returns what is wrong with the others, in their order, and the
    /// changes without them.
    pub fn lay_what_suits(&self, loaded: &mut Loaded) -> (Vec<ChangesError>, Self) {
        let (mut wrong, mut suiting) = (Vec::new(), Self::default());
        for change in self.lines() {
            let mut with_it = loaded.clone();
            match lay(&change, &mut with_it) {
                Ok(()) => {
                    *loaded = with_it;
                    suiting.add(change);
                }
                Err(error) => wrong.push(error),
            }
        }
        (wrong, suiting)
    }

    fn add(&mut self, change: Change) {
        match change {
            Change::Seed(seed) => self.seed = Some(seed),
            Change::Preset(target, name) => self.lay(target, &name),
            Change::Value(address, value) => self.set(&address, &value),
        }
    }

    /// The text without remarks, for whoever does not know the city.
    pub fn plain(&self) -> String {
        let head = HEAD.iter().map(|line| (*line).to_owned());
        let lines: Vec<String> = head.chain(self.lines().map(|change| change.to_string())).collect();
        lines.join("\n") + "\n"
    }

    /// The text that is saved. Remarks tell what each change stands in place of, in a city that was read without them.
    pub fn text(&self, as_written: &Loaded) -> String {
        let mut with_presets = as_written.plan.clone();
        let mut lines: Vec<String> = HEAD.iter().map(|line| (*line).to_owned()).collect();
        for change in self.lines() {
            let was = match &change {
                Change::Seed(_) => Some(as_written.plan.seed.to_string()),
                Change::Preset(target, name) => {
                    if let Ok(preset) = as_written.host.preset(name) {
                        // What cannot be laid is told when it is.
                        let _ = with_presets.apply(&preset, target);
                    }
                    None
                }
                Change::Value(address, _) => with_presets.value(address),
            };
            let remark = was.map_or(String::new(), |was| format!("{REMARK}was {was}"));
            lines.push(format!("{change}{remark}"));
        }
        lines.join("\n") + "\n"
    }

    /// Reads what [`Changes::text`] wrote, or a person.
    fn parse(text: &str) -> Result<Self, Wrong> {
        let mut changes = Self::default();
        let mut has_head = false;
        for (index, line) in text.lines().enumerate() {
            let line = line.split(REMARK.trim_end()).next().unwrap_or_default().trim();
            let wrong = |message: String, hint: &str| Wrong { line: index + 1, message, hint: Some(hint.to_owned()) };
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            if !has_head {
                if line != FORMAT {
                    let hint = format!("the first line is `{FORMAT}`; a newer program may have written this file");
                    return Err(wrong(format!("`{line}` is no format of changes that is known"), &hint));
                }
                has_head = true;
                continue;
            }
            let hint = "a line is `seed 7`, `preset minors=village` or `set minors.pattern.block_width=90`";
            let unknown = || wrong(format!("`{line}` says no change"), hint);
            let (word, rest) = line.split_once(' ').ok_or_else(unknown)?;
            let pair = || rest.rsplit_once('=').map(|(a, b)| (a.trim(), b.trim())).ok_or_else(unknown);
            match word {
                "seed" => changes.seed = Some(rest.trim().parse().map_err(|_| unknown())?),
                "preset" => {
                    let (target, name) = pair()?;
                    changes.lay(target.parse().map_err(|message| wrong(message, hint))?, name);
                }
                "set" => {
                    let (address, value) = rest.split_once('=').ok_or_else(unknown)?;
                    changes.set(address.trim(), value.trim());
                }
                _ => return Err(unknown()),
            }
        }
        Ok(changes)
    }

    /// Saves the changes beside the script of a city that was read without them, whole or not at all; without any the file is
    /// removed.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn save(&self, as_written: &Loaded) -> Result<(), crate::export::ExportError> {
        let path = Self::file_of(&as_written.script);
        if self.is_empty() {
            return match std::fs::remove_file(&path) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                    Err(crate::export::ExportError { path, problem: error.into() })
                }
                _ => Ok(()),
            };
        }
        crate::export::write_atomically(&path, |out| out.write_all(self.text(as_written).as_bytes()))
    }
}

/// The lines before the changes.
const HEAD: [&str; 2] = [
    FORMAT,
    "# Laid over the city script of this name, which stays as it was written: plat build and plat-view do so by themselves.",
];

/// What is wrong in a line.
struct Wrong {
    line: usize,
    message: String,
    hint: Option<String>,
}

impl Wrong {
    fn in_file(self, path: &Path) -> ChangesError {
        ChangesError { path: path.to_path_buf(), line: Some(self.line), message: self.message, hint: self.hint }
    }
}

/// The line of a file that says a change, where it does.
fn line_of(path: &Path, change: &Change) -> Option<usize> {
    let bare = |line: &str| -> String { line.chars().filter(|c| !c.is_whitespace()).collect() };
    let (text, wanted) = (std::fs::read_to_string(path).ok()?, bare(&change.to_string()));
    let said = |line: &str| bare(line.split(REMARK.trim_end()).next().unwrap_or_default());
    Some(text.lines().position(|line| said(line) == wanted)? + 1)
}

/// Lays a change over a city.
fn lay(change: &Change, loaded: &mut Loaded) -> Result<(), ChangesError> {
    let param = |error: ParamError| (error.message, error.hint);
    let laid = match change {
        Change::Seed(seed) => {
            loaded.plan.seed = *seed;
            Ok(())
        }
        Change::Preset(target, name) => loaded.lay(&format!("{target}={name}")).map_err(|error| match error {
            PresetError::Plan(error) => param(error),
            PresetError::Preset(fault) => (fault.message.clone(), fault.hint.clone()),
            PresetError::Target(message) => (message, None),
        }),
        Change::Value(address, value) => loaded.set(&format!("{address}={value}")).map_err(param),
    };
    laid.map_err(|(message, hint)| {
        let path = Changes::file_of(&loaded.script);
        let message = format!("{change}: {message}");
        ChangesError { line: line_of(&path, change), path, message, hint }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geom::Id;
    use proptest::prelude::*;
    use std::sync::LazyLock;

    fn as_written() -> &'static Loaded {
        static CITY: LazyLock<Loaded> = LazyLock::new(|| {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scripts/lattice");
            crate::load::load_as_written(&folder, None).unwrap()
        });
        &CITY
    }

    fn changes() -> impl Strategy<Value = Changes> {
        let target = prop_oneof![
            Just(PresetTarget::City),
            Just(PresetTarget::Class("minors")),
            "[a-z][a-z =.]{0,8}[a-z]".prop_map(PresetTarget::District),
            any::<u128>().prop_map(|id| PresetTarget::Quarter(Id(id))),
        ];
        let presets = proptest::collection::vec((target, "[a-z_]{1,9}"), 0..5);
        let values = proptest::collection::btree_map("[a-z]{1,5}\\.[a-z_]{1,5}", "[#a-z0-9.-]{1,7}", 0..5);
        (any::<Option<u64>>(), presets, values).prop_map(|(seed, presets, values)| {
            let mut changes = Changes { seed, values, ..Changes::default() };
            presets.into_iter().for_each(|(target, name)| changes.lay(target, &name));
            changes
        })
    }

    proptest! {
        #[test]
        fn what_is_saved_reads_back(changes in changes()) {
            let text = changes.text(as_written());
            prop_assert_eq!(Changes::parse(&text).map_err(|wrong| wrong.message), Ok(changes));
        }

        #[test]
        fn no_text_is_more_than_an_error(text in "(plat-changes 1\n)?(((seed|set|preset) )?[ -~]{0,20}\n){0,4}") {
            let _ = Changes::parse(&text);
        }
    }

    #[test]
    fn the_text_says_what_each_change_stands_in_place_of() {
        let city = as_written();
        let mut changes = Changes { seed: Some(9), ..Changes::default() };
        let address = city.plan.parameters()[0].address.clone();
        let was = city.plan.parameters()[0].value.to_string();
        changes.set(&address, "77");
        let text = changes.text(city);
        assert!(text.contains(&format!("seed 9  # was {}\n", city.plan.seed)), "{text}");
        assert!(text.contains(&format!("set {address}=77  # was {was}\n")), "{text}");
    }

    #[test]
    fn a_value_everywhere_leaves_those_of_parts_alone() {
        let mut changes = Changes::default();
        let quarter = format!("quarter:{}.minors.pattern.block_width", Id(7));
        for (address, value) in [
            (quarter.as_str(), "61"),
            ("district:harbour.minors.pattern.block_width", "62"),
            ("minors.pattern.block_width", "63"),
        ] {
            changes.set(address, value);
        }
        let mut city = as_written().clone();
        changes.lay_over(&mut city).unwrap();
        assert_eq!(city.plan.value("minors.pattern.block_width").as_deref(), Some("62 in harbour, else 63"));
        assert_eq!(city.plan.value(&quarter).as_deref(), Some("61"));
    }

    #[test]
    fn what_does_not_suit_the_city_is_told_by_its_line() {
        let mut changes = Changes { seed: Some(9), ..Changes::default() };
        changes.set("minors.pattern.no_such_thing", "1");
        let folder = tempfile::tempdir().unwrap();
        let mut city = Loaded { script: folder.path().join("city.rhai"), ..as_written().clone() };
        let error = changes.lay_over(&mut city).unwrap_err();
        assert_eq!(error.line, None, "nothing was saved");
        std::fs::write(folder.path().join("city.changes"), "plat-changes 1\n\nset minors.pattern.no_such_thing = 1\n")
            .unwrap();
        let error = changes.lay_over(&mut city).unwrap_err();
        assert_eq!(error.line, Some(3));
        assert!(error.to_string().contains("city.changes:3: set minors"), "{error}");
        let broken =
            Changes::parse("plat-changes 1\nseed 3\nreset all\n").err().map(|wrong| (wrong.line, wrong.message));
        assert_eq!(broken, Some((3, "`reset all` says no change".into())));
        assert!(Changes::parse("plat-changes 9\n").is_err());
    }
}
