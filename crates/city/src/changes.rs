//! What people changed of a city without touching its script: presets they laid on it, values they set. Saved as text beside
//! the script, in lines that `plat build` takes as arguments, too.

use crate::{Loaded, PresetError};
use script::{Fault, ParamError, PresetTarget};
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

impl Change {
    /// Reads what it is written as; an error says why not, where there is more to say than that it is none.
    fn parse(line: &str) -> Result<Self, Option<String>> {
        let (word, rest) = line.split_once(' ').ok_or(None)?;
        match word {
            "seed" => rest.trim().parse().map(Self::Seed).map_err(|_| None),
            "preset" => {
                let (target, name) = rest.rsplit_once('=').ok_or(None)?;
                Ok(Self::Preset(target.trim().parse()?, name.trim().to_owned()))
            }
            "set" => {
                let (address, value) = rest.split_once('=').ok_or(None)?;
                Ok(Self::Value(address.trim().to_owned(), value.trim().to_owned()))
            }
            _ => Err(None),
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
    /// All that is wrong in the file, without a line when it cannot be read: at least one fault.
    pub fn saved(script: &Path) -> Result<Self, Vec<Fault>> {
        Ok(Self::read(&Self::file_of(script))?.unwrap_or_default())
    }

    /// Those in a file; `None` where there is no such file.
    ///
    /// # Errors
    /// All that is wrong in the file, without a line when it cannot be read: at least one fault.
    pub fn read(path: &Path) -> Result<Option<Self>, Vec<Fault>> {
        let file = path.display().to_string();
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(&file, &text).map(Some),
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(vec![Fault::new(file, error.to_string())]),
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

    /// Lays those over a city that was just read that suit it. Returns what is wrong with the others, each once and in their
    /// order, by lines of the file that they are saved in or in the presets and rules that they name; and the changes without
    /// them.
    pub fn lay_what_suits(&self, loaded: &mut Loaded) -> (Vec<Fault>, Self) {
        let (mut wrong, mut suiting) = (Vec::<Fault>::new(), Self::default());
        for change in self.lines() {
            let mut with_it = loaded.clone();
            match lay(&change, &mut with_it) {
                Ok(()) => {
                    *loaded = with_it;
                    suiting.add(change);
                }
                Err(faults) => {
                    faults.into_iter().for_each(|fault| {
                        if !wrong.contains(&fault) {
                            wrong.push(fault)
                        }
                    });
                }
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
    fn parse(file: &str, text: &str) -> Result<Self, Vec<Fault>> {
        let (mut changes, mut faults) = (Self::default(), Vec::new());
        let mut has_head = false;
        for (index, raw) in text.lines().enumerate() {
            let line = bare(raw);
            let wrong = |message: String, hint: &str| {
                at_line(Fault::new(file, message).with_hint(Some(hint.to_owned())), index, raw)
            };
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            if !has_head {
                if line != FORMAT {
                    let hint = format!("the first line is `{FORMAT}`; a newer program may have written this file");
                    return Err(vec![wrong(format!("`{line}` is no format of changes that is known"), &hint)]);
                }
                has_head = true;
                continue;
            }
            match Change::parse(line) {
                Ok(change) => changes.add(change),
                Err(message) => faults.push(wrong(
                    message.unwrap_or_else(|| format!("`{line}` says no change")),
                    "a line is `seed 7`, `preset city=village`, `preset minors=village` or `set minors.pattern.block_width=90`",
                )),
            }
        }
        if faults.is_empty() { Ok(changes) } else { Err(faults) }
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

/// A line without its remark.
fn bare(line: &str) -> &str {
    line.split(REMARK.trim_end()).next().unwrap_or_default().trim()
}

/// A fault of a line, counted from 0, without its remark.
fn at_line(fault: Fault, index: usize, line: &str) -> Fault {
    let count = |text: &str| u32::try_from(text.chars().count()).unwrap_or(u32::MAX);
    let indent = &line[..line.len() - line.trim_start().len()];
    let line_number = u32::try_from(index + 1).unwrap_or(u32::MAX);
    Fault { line: line_number, column: count(indent) + 1, length: count(bare(line)), ..fault }
}

/// A fault of the file of changes, at the line that says a change, where one does.
fn of_line(path: &Path, change: &Change, message: &str, hint: Option<String>) -> Fault {
    let fault = Fault::new(path.display().to_string(), format!("{change}: {message}")).with_hint(hint);
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let says = |line: &str| Change::parse(bare(line)).as_ref() == Ok(change);
    match text.lines().enumerate().find(|(_, line)| says(line)) {
        Some((index, line)) => at_line(fault, index, line),
        None => fault,
    }
}

/// Lays a change over a city.
///
/// # Errors
/// What is wrong: in the file of changes, or in the preset that it names and the rules of that.
fn lay(change: &Change, loaded: &mut Loaded) -> Result<(), Vec<Fault>> {
    let path = Changes::file_of(&loaded.script);
    let wrong = |message: &str, hint: Option<String>| vec![of_line(&path, change, message, hint)];
    let param = |error: ParamError| wrong(&error.message, error.hint);
    match change {
        Change::Seed(seed) => {
            loaded.plan.seed = *seed;
            Ok(())
        }
        Change::Preset(target, name) => loaded.lay(&format!("{target}={name}")).map_err(|error| match error {
            PresetError::Plan(error) => param(error),
            PresetError::Target(message) => wrong(&message, None),
            PresetError::Preset(faults) if faults.iter().any(|fault| fault.line > 0) => faults,
            PresetError::Preset(faults) => {
                faults.into_iter().flat_map(|fault| wrong(&fault.message, fault.hint)).collect()
            }
        }),
        Change::Value(address, value) => loaded.set(&format!("{address}={value}")).map_err(param),
    }
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
            prop_assert_eq!(Changes::parse("c", &text), Ok(changes));
        }

        #[test]
        fn no_text_is_more_than_an_error(text in "(plat-changes 1\n)?(((seed|set|preset) )?[ -~]{0,20}\n){0,4}") {
            let _ = Changes::parse("c", &text);
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
        assert_eq!(changes.lay_what_suits(&mut city), (Vec::new(), changes.clone()));
        assert_eq!(city.plan.value("minors.pattern.block_width").as_deref(), Some("62 in harbour, else 63"));
        assert_eq!(city.plan.value(&quarter).as_deref(), Some("61"));
    }

    #[test]
    fn what_does_not_suit_the_city_is_told_by_its_line() {
        let mut changes = Changes { seed: Some(9), ..Changes::default() };
        changes.set("minors.pattern.no_such_thing", "1");
        let folder = tempfile::tempdir().unwrap();
        let mut city = Loaded { script: folder.path().join("city.rhai"), ..as_written().clone() };
        let mut wrong = || {
            let (faults, suiting) = changes.lay_what_suits(&mut city);
            assert_eq!(suiting, Changes { seed: Some(9), ..Changes::default() });
            faults
        };
        assert_eq!(wrong()[0].line, 0, "nothing was saved");
        let text = "plat-changes 1\nseed 9\n  set minors.pattern.no_such_thing = 1  # was 3\n";
        std::fs::write(folder.path().join("city.changes"), text).unwrap();
        let faults = wrong();
        assert_eq!(
            faults.iter().map(|fault| (fault.line, fault.column, fault.length)).collect::<Vec<_>>(),
            [(3, 3, 36)]
        );
        assert!(faults[0].to_string().contains("city.changes:3:3: set minors"), "{}", faults[0]);
    }

    #[test]
    fn all_lines_that_say_no_change_are_told() {
        let text = "plat-changes 1\nseed 3\nreset all\nset a.b=1\n preset a=b=village\n";
        let told: Vec<(u32, String)> = Changes::parse("city.changes", text)
            .unwrap_err()
            .into_iter()
            .map(|fault| (fault.line, fault.message))
            .collect();
        assert_eq!(told[0], (3, "`reset all` says no change".into()));
        assert!(told[1].0 == 5 && told[1].1.contains("`a=b` is nothing that a preset can be laid on"), "{told:?}");
        assert_eq!(told.len(), 2);
        let newer = Changes::parse("city.changes", "plat-changes 9\nreset all\n").unwrap_err();
        assert_eq!(newer.len(), 1, "what a newer format says is not known");
    }

    #[test]
    fn what_is_wrong_behind_a_preset_is_told_in_its_own_file() {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in [
            (
                "city.rhai",
                "city(#{ site: site(#{ size: [600, 600] }), minors: streets(#{ pattern: rule(\"streets/grid\") }) });",
            ),
            (
                "city.changes",
                "plat-changes 1\nset minors.pattern.nothing=1\npreset minors=lanes\npreset district:x=lanes\n",
            ),
            (
                "presets/lanes.rhai",
                "//! Lanes.\npreset(#{ pattern: rule(\"streets/lanes\"), buildings: rule(\"huts\") });\n",
            ),
            ("streets/lanes.rhai", "//! Lanes.\nfn propose(tip, p) {\n    tip.ahaed(50);\n}\n"),
            ("huts.rhai", "//! Huts.\nfn build(shape, p) {\n    shape.extrude(9;\n}\n"),
        ] {
            std::fs::create_dir_all(folder.path().join(name).parent().unwrap()).unwrap();
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let Err(crate::LoadError::Scripts { faults, texts }) = crate::load(folder.path(), None) else {
            panic!("it loads")
        };
        let told: Vec<String> = faults
            .iter()
            .map(|fault| {
                format!("{}:{}", Path::new(&fault.file).strip_prefix(folder.path()).unwrap().display(), fault.line)
            })
            .collect();
        assert_eq!(told, ["streets/lanes.rhai:3", "huts.rhai:3", "city.changes:2"], "each once");
        assert!(faults.iter().all(|fault| texts.get(&fault.file).is_some()), "all can be shown");
    }
}
