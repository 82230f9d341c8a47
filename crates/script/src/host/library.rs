//! Where rules come from: libraries asked one after another, the last one embedded in the program.

use crate::fault::{Complaint, Fault};
use crate::names::hint;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;
use std::sync::{Arc, Mutex, PoisonError};

/// The text of a script and the name that messages call it by.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The script.
    pub text: String,
    /// What a person knows it as: a path, or `streets/grid.rhai (built in)`.
    pub path: String,
}

/// A place that holds rule files. This crate reads no files: `city` implements it on folders.
pub trait Library: Send + Sync + Debug {
    /// The file of that name (`streets/grid.rhai`, `/` between the parts, never `..`): `None` when it is not there, an
    /// error when it is there but cannot be read.
    fn read(&self, name: &str) -> Option<Result<Source, String>>;

    /// What the place is called in messages.
    fn place(&self) -> String;

    /// The names it holds, with `.rhai`: for suggestions and listings.
    fn names(&self) -> Vec<String>;
}

/// The files of the `rules` folder, embedded: name with `.rhai`, text.
const EMBEDDED: [(&str, &str); 30] = [
    ("buildings/extruded.rhai", include_str!("../../../../rules/buildings/extruded.rhai")),
    ("buildings/zoned.rhai", include_str!("../../../../rules/buildings/zoned.rhai")),
    ("constraints/clear_of_parks.rhai", include_str!("../../../../rules/constraints/clear_of_parks.rhai")),
    ("constraints/mountain.rhai", include_str!("../../../../rules/constraints/mountain.rhai")),
    ("constraints/standard.rhai", include_str!("../../../../rules/constraints/standard.rhai")),
    ("goals/settled.rhai", include_str!("../../../../rules/goals/settled.rhai")),
    ("parcels/recursive.rhai", include_str!("../../../../rules/parcels/recursive.rhai")),
    ("parcels/zoned.rhai", include_str!("../../../../rules/parcels/zoned.rhai")),
    ("presets/avenues.rhai", include_str!("../../../../rules/presets/avenues.rhai")),
    ("presets/boulevard_radial.rhai", include_str!("../../../../rules/presets/boulevard_radial.rhai")),
    ("presets/campus.rhai", include_str!("../../../../rules/presets/campus.rhai")),
    ("presets/curved_suburb.rhai", include_str!("../../../../rules/presets/curved_suburb.rhai")),
    ("presets/garden_city.rhai", include_str!("../../../../rules/presets/garden_city.rhai")),
    ("presets/highways.rhai", include_str!("../../../../rules/presets/highways.rhai")),
    ("presets/hillside_contour.rhai", include_str!("../../../../rules/presets/hillside_contour.rhai")),
    ("presets/industrial_grid.rhai", include_str!("../../../../rules/presets/industrial_grid.rhai")),
    ("presets/medieval_core.rhai", include_str!("../../../../rules/presets/medieval_core.rhai")),
    ("presets/mountain_road.rhai", include_str!("../../../../rules/presets/mountain_road.rhai")),
    ("presets/perimeter_blocks.rhai", include_str!("../../../../rules/presets/perimeter_blocks.rhai")),
    ("presets/raster_downtown.rhai", include_str!("../../../../rules/presets/raster_downtown.rhai")),
    ("presets/village.rhai", include_str!("../../../../rules/presets/village.rhai")),
    ("presets/waterfront.rhai", include_str!("../../../../rules/presets/waterfront.rhai")),
    ("streets/contour.rhai", include_str!("../../../../rules/streets/contour.rhai")),
    ("streets/corniche.rhai", include_str!("../../../../rules/streets/corniche.rhai")),
    ("streets/grid.rhai", include_str!("../../../../rules/streets/grid.rhai")),
    ("streets/highway.rhai", include_str!("../../../../rules/streets/highway.rhai")),
    ("streets/loose_grid.rhai", include_str!("../../../../rules/streets/loose_grid.rhai")),
    ("streets/organic.rhai", include_str!("../../../../rules/streets/organic.rhai")),
    ("streets/quarter_grid.rhai", include_str!("../../../../rules/streets/quarter_grid.rhai")),
    ("streets/radial.rhai", include_str!("../../../../rules/streets/radial.rhai")),
];

/// The version of the library that the program carries. It grows when the rules of it give another city than before; what
/// they replace then goes to [`FORMER`], so that cities that keep to an earlier version stay as they are.
pub const LIBRARY: u32 = 1;

/// Texts of rules that later versions replaced: the last version that had them, name, text. None so far.
const FORMER: [Former; 0] = [];

/// The last version that had a text, its name, the text.
type Former = (u32, &'static str, &'static str);

/// The text of a rule in a version of a library.
fn text_at(
    version: u32,
    name: &str,
    former: &[Former],
    current: &[(&'static str, &'static str)],
) -> Option<&'static str> {
    let replaced = former.iter().filter(|(until, known, _)| *until >= version && *known == name);
    let replaced = replaced.min_by_key(|(until, ..)| *until).map(|(.., text)| *text);
    replaced.or_else(|| current.iter().find(|(known, _)| *known == name).map(|(_, text)| *text))
}

/// The rules that are others now than in a version, each once.
fn changed_since(version: u32, former: &[Former]) -> BTreeSet<&'static str> {
    former.iter().filter(|(until, ..)| *until >= version).map(|(_, name, _)| name.trim_end_matches(".rhai")).collect()
}

/// Which version of the library a run keeps to. Shared by all that read from it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pin(Arc<Mutex<Pinned>>);

#[derive(Debug, Default)]
struct Pinned {
    version: Option<u32>,
    /// Whether something was read: then it is too late to choose.
    is_read: bool,
}

impl Pin {
    /// Keeps to a version from now on.
    pub fn choose(&self, version: i64) -> Result<(), Complaint> {
        let mut pinned = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if pinned.is_read {
            let help = "put it at the top of the script";
            return Err(Complaint::new("library(…) stands before the first rule(…) and preset(…)").hint(help));
        }
        if let Some(before) = pinned.version {
            return Err(Complaint::new("library(…) is called twice").hint(format!("it is version {before} already")));
        }
        let known = u32::try_from(version).ok().filter(|version| (1..=LIBRARY).contains(version));
        let unknown = || {
            let message = format!("this program has no version {version} of the library");
            let help = if LIBRARY == 1 {
                "it carries version 1".into()
            } else {
                format!("it carries versions 1 to {LIBRARY}")
            };
            Complaint::new(message).hint(help)
        };
        pinned.version = Some(known.ok_or_else(unknown)?);
        Ok(())
    }

    /// The version to read from.
    fn reading(&self) -> u32 {
        let mut pinned = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        pinned.is_read = true;
        pinned.version.unwrap_or(LIBRARY)
    }

    /// What there is to say about keeping to an earlier version: which rules a later one changes.
    pub fn changes(&self) -> Option<String> {
        let version = self.0.lock().unwrap_or_else(PoisonError::into_inner).version?;
        told_changes(version, &changed_since(version, &FORMER))
    }
}

fn told_changes(version: u32, changed: &BTreeSet<&str>) -> Option<String> {
    let names: Vec<&str> = changed.iter().copied().collect();
    let told =
        || format!("this city keeps to version {version} of the library; later ones change {}", names.join(", "));
    (!names.is_empty()).then(told)
}

/// The library that the program carries.
#[derive(Clone, Copy, Debug, Default)]
pub struct Embedded;

impl Library for Embedded {
    fn read(&self, name: &str) -> Option<Result<Source, String>> {
        let (_, text) = EMBEDDED.iter().find(|(file, _)| *file == name)?;
        Some(Ok(Source { text: (*text).to_owned(), path: format!("rules/{name}") }))
    }

    fn place(&self) -> String {
        "the built-in library".into()
    }

    fn names(&self) -> Vec<String> {
        EMBEDDED.iter().map(|(name, _)| (*name).to_owned()).collect()
    }
}

/// The libraries of one run in the order they are asked.
#[derive(Clone, Debug)]
pub(crate) struct Shelves {
    libraries: Arc<[Arc<dyn Library>]>,
    pin: Pin,
}

impl Shelves {
    /// The given libraries, then the embedded one.
    pub fn new(libraries: Vec<Arc<dyn Library>>) -> Self {
        let libraries = libraries.into_iter().chain([Arc::new(Embedded) as Arc<dyn Library>]).collect();
        Self { libraries, pin: Pin::default() }
    }

    /// Reads a script by its name without `.rhai`, e.g. `streets/grid`.
    pub fn read(&self, name: &str) -> Result<Source, Fault> {
        let name = name.strip_suffix(".rhai").unwrap_or(name);
        if !is_inside(name) {
            let help = "a rule is named by folder and file, such as \"streets/grid\"";
            return Err(Fault::new(name, "names nothing inside a rule library").with_hint(Some(help.into())));
        }
        let file = format!("{name}.rhai");
        match self.find(&file) {
            Some(found) => found.map_err(|reason| Fault::new(file, reason)),
            None => Err(self.missing(name)),
        }
    }

    /// Which version of the library is read from.
    pub fn pin(&self) -> &Pin {
        &self.pin
    }

    /// The file of that name in the first library that has it; of the built-in one in the version that is kept to.
    fn find(&self, file: &str) -> Option<Result<Source, String>> {
        let others = &self.libraries[..self.libraries.len() - 1];
        let found = others.iter().find_map(|library| library.read(file));
        let built_in = || {
            let text = text_at(self.pin.reading(), file, &FORMER, &EMBEDDED)?;
            Some(Ok(Source { text: text.to_owned(), path: format!("rules/{file}") }))
        };
        found.or_else(built_in)
    }

    /// All names without `.rhai`.
    pub fn names(&self) -> BTreeSet<String> {
        let all = self.libraries.iter().flat_map(|library| library.names());
        all.map(|name| name.strip_suffix(".rhai").unwrap_or(&name).to_owned()).collect()
    }

    fn missing(&self, name: &str) -> Fault {
        let places: Vec<String> = self.libraries.iter().map(|library| library.place()).collect();
        let names = self.names();
        let message = format!("there is no rule of that name in {}", places.join(", "));
        Fault::new(name, message).with_hint(hint(name, names.iter().map(String::as_str)))
    }
}

/// Whether a name stays inside a library: plain parts between slashes.
pub(crate) fn is_inside(name: &str) -> bool {
    let plain = |part: &str| {
        !part.is_empty() && !part.starts_with('.') && part.chars().all(|c| c.is_alphanumeric() || "_-. ".contains(c))
    };
    name.split('/').all(plain)
}

/// The texts of all scripts read so far, by the path that messages use: for showing the line of a fault. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Texts(Arc<Mutex<BTreeMap<String, Arc<str>>>>);

impl Texts {
    /// Keeps a text.
    pub(crate) fn keep(&self, source: &Source) {
        self.keep_text(&source.path, &source.text);
    }

    /// Keeps the text of a script.
    pub fn keep_text(&self, path: &str, text: &str) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(path.to_owned(), text.into());
    }

    /// Keeps all texts of another reading.
    pub fn keep_all(&self, other: &Self) {
        if Arc::ptr_eq(&self.0, &other.0) {
            return;
        }
        let others = other.0.lock().unwrap_or_else(PoisonError::into_inner).clone();
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend(others);
    }

    /// The text of an imported script, by the name it was imported by.
    pub(crate) fn imported(&self, name: &str) -> Option<Arc<str>> {
        let end = format!("/{name}.rhai");
        let texts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        texts.iter().find(|(path, _)| path.replace('\\', "/").ends_with(&end)).map(|(_, text)| text.clone())
    }

    /// The text of a script.
    pub fn get(&self, path: &str) -> Option<Arc<str>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(path).cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::{Path, PathBuf};

    fn files_below(folder: &Path, root: &Path, found: &mut Vec<String>) {
        let mut entries: Vec<PathBuf> =
            std::fs::read_dir(folder).expect("the rules folder").map(|e| e.expect("an entry").path()).collect();
        entries.sort();
        for path in entries {
            if path.is_dir() {
                files_below(&path, root, found);
            } else if path.extension().is_some_and(|e| e == "rhai")
                && !path.to_string_lossy().ends_with(".test.rhai")
                && !path.to_string_lossy().ends_with(".d.rhai")
            {
                found.push(path.strip_prefix(root).expect("below").to_string_lossy().replace('\\', "/"));
            }
        }
    }

    #[test]
    fn the_embedded_library_is_the_rules_folder() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../rules");
        let mut found = Vec::new();
        files_below(&root, &root, &mut found);
        assert_eq!(Embedded.names(), found);
    }

    #[test]
    fn earlier_versions_stay_as_they_were() {
        let former: [Former; 3] = [(1, "a.rhai", "a1"), (3, "a.rhai", "a3"), (2, "b.rhai", "b2")];
        let current = [("a.rhai", "a5"), ("b.rhai", "b5"), ("c.rhai", "c")];
        let at = |version, name| text_at(version, name, &former, &current);
        assert_eq!((1..=5).map(|v| at(v, "a.rhai")).collect::<Vec<_>>(), ["a1", "a3", "a3", "a5", "a5"].map(Some));
        assert_eq!((1..=3).map(|v| at(v, "b.rhai")).collect::<Vec<_>>(), ["b2", "b2", "b5"].map(Some));
        assert_eq!((at(1, "c.rhai"), at(1, "d.rhai")), (Some("c"), None));
        assert_eq!(changed_since(3, &former).into_iter().collect::<Vec<_>>(), ["a"]);
        let told = told_changes(2, &changed_since(2, &former));
        assert_eq!(told.as_deref(), Some("this city keeps to version 2 of the library; later ones change a, b"));
        assert_eq!(told_changes(4, &changed_since(4, &former)), None);
    }

    #[test]
    fn a_version_is_chosen_once_and_before_anything_is_read() {
        let shelves = Shelves::new(vec![]);
        assert!(shelves.pin().choose(0).is_err() && shelves.pin().choose(i64::from(LIBRARY) + 1).is_err());
        assert!(shelves.pin().choose(i64::from(LIBRARY)).is_ok() && shelves.pin().changes().is_none());
        shelves.read("streets/grid").expect("is there");
        assert!(shelves.pin().choose(1).expect_err("too late").message.contains("before the first rule"));
    }

    #[test]
    fn names_stay_inside() {
        for good in ["streets/grid", "mine", "a/b/c-d_e"] {
            assert!(is_inside(good), "{good}");
        }
        for bad in ["", "/etc/passwd", "../x", "a/../b", "a//b", "./a", "a\\b", "C:/x", "a/", "a/.."] {
            assert!(!is_inside(bad), "{bad}");
        }
    }

    #[test]
    fn a_missing_rule_says_where_and_what_is_near() {
        let fault = Shelves::new(vec![]).read("streets/gird").expect_err("there is none");
        assert_eq!(fault.message, "there is no rule of that name in the built-in library");
        assert_eq!(fault.hint.as_deref(), Some("did you mean `streets/grid`?"));
    }
}
