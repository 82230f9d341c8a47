//! Copies of a city's folder: for cities that cannot be written where they lie, and for trying something beside them.

use std::fs;
use std::path::{Path, PathBuf};

/// How deep folders may lie in each other: links can go in circles.
const DEEPEST: usize = 32;

/// Copies the folder of a script to where nothing is yet, whole or not at all, with a text as the script's saved changes.
/// What links point to is copied, not the links. Returns the copy: the folder, or the script where that is no `city.rhai`.
///
/// # Errors
/// When something is there already, the copy would lie in the city itself, or something cannot be read or written.
pub fn copy(script: &Path, to: &Path, changes: Option<&str>) -> Result<PathBuf, String> {
    let failed = |path: &Path, error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    let name = script.file_name().ok_or("the city has no script")?;
    let folder = script.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let is_free = !to.exists() || fs::read_dir(to).is_ok_and(|mut entries| entries.next().is_none());
    if !is_free {
        return Err(format!("{} is there already: name a new folder", to.display()));
    }
    let above = to.parent().filter(|above| !above.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(above).map_err(|error| failed(above, &error))?;
    let real = |path: &Path| path.canonicalize().map_err(|error| failed(path, &error));
    if real(above)?.starts_with(real(folder)?) {
        return Err(format!("{} lies in the city itself: name a folder beside it", to.display()));
    }
    // Beside its place, then into it: a copy that is cut off is none.
    let unfinished = tempfile::Builder::new().prefix(".plat-").tempdir_in(above);
    let unfinished = unfinished.map_err(|error| failed(above, &error))?;
    let inside = unfinished.path().join("city");
    copy_folder(folder, &inside, 0)?;
    let file = city::Changes::file_of(&inside.join(name));
    match changes {
        Some(text) => fs::write(&file, text).map_err(|error| failed(to, &error))?,
        None if file.exists() => fs::remove_file(&file).map_err(|error| failed(to, &error))?,
        None => {}
    }
    if to.exists() {
        fs::remove_dir(to).map_err(|error| failed(to, &error))?;
    }
    fs::rename(&inside, to).map_err(|error| failed(to, &error))?;
    Ok(if name == "city.rhai" { to.to_path_buf() } else { to.join(name) })
}

fn copy_folder(from: &Path, to: &Path, depth: usize) -> Result<(), String> {
    let failed = |path: &Path, error: &dyn std::fmt::Display| format!("{}: {error}", path.display());
    if depth > DEEPEST {
        return Err(format!("{}: folders lie too deep in each other", from.display()));
    }
    fs::create_dir(to).map_err(|error| failed(to, &error))?;
    for entry in fs::read_dir(from).map_err(|error| failed(from, &error))? {
        let entry = entry.map_err(|error| failed(from, &error))?;
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy_folder(&path, &target, depth + 1)?;
            continue;
        }
        // What was not written to be changed may be changed in the copy.
        let bytes = fs::read(&path).map_err(|error| failed(&path, &error))?;
        fs::write(&target, bytes).map_err(|error| failed(&path, &error))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn city(folder: &Path) -> PathBuf {
        let city = folder.join("town");
        fs::create_dir_all(city.join("maps/deep")).unwrap();
        fs::write(city.join("city.rhai"), "city(#{ })").unwrap();
        fs::write(city.join("city.changes"), "old").unwrap();
        fs::write(city.join("maps/deep/land.png"), [1, 2, 3]).unwrap();
        city
    }

    #[test]
    fn all_of_a_city_is_copied_with_other_changes() {
        let folder = tempfile::tempdir().unwrap();
        let city = city(folder.path());
        let to = folder.path().join("new/place");
        assert_eq!(copy(&city.join("city.rhai"), &to, Some("new")), Ok(to.clone()));
        assert_eq!(fs::read(to.join("maps/deep/land.png")).unwrap(), [1, 2, 3]);
        assert_eq!(fs::read_to_string(to.join("city.changes")).unwrap(), "new");
        assert_eq!(fs::read_to_string(city.join("city.changes")).unwrap(), "old");
        let bare = folder.path().join("bare");
        fs::create_dir(&bare).unwrap();
        copy(&city.join("city.rhai"), &bare, None).unwrap();
        assert!(bare.join("city.rhai").exists() && !bare.join("city.changes").exists());
        fs::write(city.join("other.rhai"), "city(#{ })").unwrap();
        let other = folder.path().join("other");
        assert_eq!(copy(&city.join("other.rhai"), &other, None), Ok(other.join("other.rhai")));
    }

    #[test]
    fn nothing_is_written_over_and_nothing_is_left_half() {
        let folder = tempfile::tempdir().unwrap();
        let city = city(folder.path());
        let script = city.join("city.rhai");
        let listing = || {
            let entries = fs::read_dir(folder.path()).unwrap();
            let mut names: Vec<String> =
                entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
            names.sort();
            names
        };
        assert!(copy(&script, &city, None).unwrap_err().contains("already"));
        assert!(copy(&script, &city.join("inner"), None).unwrap_err().contains("in the city itself"));
        assert!(copy(&script, &city.join("city.rhai/below"), None).is_err());
        assert_eq!(listing(), ["town"]);
        #[cfg(unix)]
        {
            // A link that goes round.
            std::os::unix::fs::symlink(&city, city.join("again")).unwrap();
            assert!(copy(&script, &folder.path().join("copy"), None).unwrap_err().contains("too deep"));
            assert_eq!(listing(), ["town"]);
        }
    }
}
