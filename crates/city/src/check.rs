//! What can be found wrong in rules and city scripts without building.

use crate::load::{LoadError, RuleFolder, load, read_script, script_hint};
use crate::testing::is_tests;
use script::{Fault, Host, Library, RuleKind, Source, Texts};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a check found.
#[derive(Clone, Debug, Default)]
pub struct Checked {
    /// How many files were looked at.
    pub files: usize,
    /// All that is wrong in them, and what is doubtful, by file and place; of a city what stopped it comes first.
    pub faults: Vec<Fault>,
    /// The texts of the files.
    pub texts: Texts,
}

/// Checks a rule, a city script with the rules it names and the maps it reads, or all scripts below a folder.
///
/// # Errors
/// [`LoadError::Missing`] when there is nothing to check there, [`LoadError::Unreadable`] for a file alone that is no text; below
/// a folder it is a fault like others.
pub fn check(path: &Path, rules: Option<&Path>) -> Result<Checked, LoadError> {
    let mut checked = Checked::default();
    let mut scripts = Vec::new();
    for file in files_below(path)? {
        match read_script(&file) {
            Ok(text) => scripts.push((file, text)),
            Err(cause) if file == path => return Err(LoadError::Unreadable { path: file, cause }),
            Err(cause) => {
                let fault = Fault::new(file.display().to_string(), cause.to_string());
                checked.faults.push(fault.with_hint(Some(script_hint(&cause).to_owned())));
                checked.files += 1;
            }
        }
    }
    // Rules of a city are told with it.
    let mut seen = BTreeSet::new();
    let (cities, others): (Vec<_>, Vec<_>) = scripts.into_iter().partition(|(path, text)| is_city(path, text));
    for (script, text) in &cities {
        checked.texts.keep_all(&check_city(script, text, rules, &mut checked.faults, &mut seen)?);
    }
    for (script, text) in &others {
        let host = rule_host_at(&root_of(script), rules)?;
        let source = Source { text: text.clone(), path: script.display().to_string() };
        let faults = host.check_rule(&name_of(script), &source);
        checked.faults.extend(faults.into_iter().filter(|fault| seen.insert(key(fault))));
        checked.texts.keep_all(host.texts());
    }
    checked.files += cities.len() + others.len();
    Ok(checked)
}

type Key = (String, u32, u32, String);

fn key(fault: &Fault) -> Key {
    (fault.file.clone(), fault.line, fault.column, fault.message.clone())
}

fn check_city(
    script: &Path,
    text: &str,
    rules: Option<&Path>,
    faults: &mut Vec<Fault>,
    seen: &mut BTreeSet<Key>,
) -> Result<Texts, LoadError> {
    let (found, texts) = match load(script, rules) {
        Ok(loaded) => {
            let mut found = loaded.doubts.clone();
            // Maps and street files: what they lack is found without building, too.
            match loaded.read() {
                Ok(sources) => found.extend(sources.plan.missing_maps()),
                Err(LoadError::Scripts { faults, .. }) => found.extend(faults),
                Err(LoadError::Value { error, .. }) => found.push(loaded.value_fault(&error)),
                Err(error) => found.push(in_city(script, &error)),
            }
            (found, loaded.texts)
        }
        Err(LoadError::Scripts { faults, texts }) => (faults, texts),
        Err(error) => return Err(error),
    };
    texts.keep_text(&script.display().to_string(), text);
    faults.extend(found.into_iter().filter(|fault| seen.insert(key(fault))));
    Ok(texts)
}

/// What is wrong with the files of a city, as a fault of its script.
fn in_city(script: &Path, error: &LoadError) -> Fault {
    let text = error.to_string();
    let (message, hint) = match text.split_once("\n  hint: ") {
        Some((message, hint)) => (message.to_owned(), Some(hint.to_owned())),
        None => (text, None),
    };
    Fault::new(script.display().to_string(), message).with_hint(hint)
}

/// The scripts to check with their texts, in the order of their paths.
pub(crate) fn scripts_below(path: &Path) -> Result<Vec<(PathBuf, String)>, LoadError> {
    files_below(path)?.into_iter().map(|file| read(&file).map(|text| (file, text))).collect()
}

fn files_below(path: &Path) -> Result<Vec<PathBuf>, LoadError> {
    let missing = |message: String| LoadError::Missing {
        path: path.to_path_buf(),
        message,
        hint: "name a rule, a city, or a folder with .rhai files below it".into(),
    };
    let mut files = Vec::new();
    if path.is_dir() {
        collect(path, &mut files, 0);
        if files.is_empty() {
            return Err(missing("there are no .rhai files below this folder".into()));
        }
    } else if path.exists() {
        files.push(path.to_path_buf());
    } else {
        return Err(missing("there is no such file or folder".into()));
    }
    files.sort();
    Ok(files)
}

/// Folders nested deeper than this are not looked into.
const DEEPEST: usize = 16;

fn collect(folder: &Path, files: &mut Vec<PathBuf>, depth: usize) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        let is_hidden = name.to_string_lossy().starts_with('.') || name == "target";
        match entry.file_type() {
            Ok(kind) if kind.is_dir() && !is_hidden && depth < DEEPEST => collect(&path, files, depth + 1),
            // Definitions for editors are no scripts.
            Ok(kind) if !kind.is_dir() && is_script(&name.to_string_lossy()) => files.push(path),
            _ => {}
        }
    }
}

fn is_script(name: &str) -> bool {
    name.ends_with(".rhai") && !name.ends_with(".d.rhai")
}

fn read(path: &Path) -> Result<String, LoadError> {
    read_script(path).map_err(|cause| LoadError::Unreadable { path: path.to_path_buf(), cause })
}

/// Whether a script is a city's rather than a rule.
pub(crate) fn is_city(path: &Path, text: &str) -> bool {
    let is_named = path.file_name().is_some_and(|name| name == "city.rhai");
    let tells = || text.lines().any(|line| line.starts_with("city("));
    !is_tests(path) && (is_named || tells())
}

/// The folder that a rule's imports are looked up in: above `streets/` and its like, else the rule's own.
pub(crate) fn root_of(rule: &Path) -> PathBuf {
    let folder = rule.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let is_kind = folder.file_name().is_some_and(|name| RuleKind::folders().iter().any(|kind| name == *kind));
    match folder.parent().filter(|_| is_kind) {
        Some(root) if !root.as_os_str().is_empty() => root.to_path_buf(),
        Some(_) => PathBuf::from("."),
        None => folder.to_path_buf(),
    }
}

/// What a city script would call it.
pub(crate) fn name_of(rule: &Path) -> String {
    let below = rule.strip_prefix(root_of(rule)).unwrap_or(rule);
    below.with_extension("").to_string_lossy().replace('\\', "/")
}

/// A host for the built-in library and, before it, a folder of rules.
///
/// # Errors
/// [`LoadError::Missing`] when the folder is not there.
pub fn rule_host(rules: Option<&Path>) -> Result<Host, LoadError> {
    Ok(Host::new(rules.map(rule_folder).transpose()?.into_iter().collect()))
}

fn rule_host_at(root: &Path, rules: Option<&Path>) -> Result<Host, LoadError> {
    let own: Arc<dyn Library> = Arc::new(RuleFolder(root.to_path_buf()));
    let given = rules.map(rule_folder).transpose()?;
    Ok(Host::new(std::iter::once(own).chain(given).collect()))
}

/// A folder of rules that a person named.
pub(crate) fn rule_folder(rules: &Path) -> Result<Arc<dyn Library>, LoadError> {
    if rules.is_dir() {
        return Ok(Arc::new(RuleFolder(rules.to_path_buf())));
    }
    let hint = "--rules takes a folder such as rules/ with streets/, parcels/, …".to_owned();
    Err(LoadError::Missing { path: rules.into(), message: "there is no such folder".into(), hint })
}
