//! Copies of a city's folder: for cities that cannot be written where they lie, and for trying something beside them.

use crate::Changes;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// How deep folders may lie in each other: links can go in circles.
const DEEPEST: usize = 32;

/// Why a city was not copied: nothing of the copy is there.
#[derive(Debug, thiserror::Error)]
pub enum CopyError {
    /// Something lies where the copy is to be.
    #[error("{} is there already: name a new folder", .0.display())]
    Taken(PathBuf),
    /// The copy would be copied, too.
    #[error("{} lies in the city itself: name a folder beside it", .0.display())]
    Inside(PathBuf),
    /// Folders lie in each other without an end.
    #[error("{}: folders lie too deep in each other", .0.display())]
    Deep(PathBuf),
    /// Something cannot be read or written.
    #[error("{}: {cause}", path.display())]
    Files {
        /// What.
        path: PathBuf,
        /// What the system says.
        cause: io::Error,
    },
}

fn at(path: &Path) -> impl FnOnce(io::Error) -> CopyError {
    let path = path.to_path_buf();
    |cause| CopyError::Files { path, cause }
}

/// Copies the folder of a script to where nothing is yet, whole or not at all, with a text as the script's saved changes.
/// What links point to is copied, not the links. Returns the copy: the folder, or the script where that is no `city.rhai`.
///
/// # Errors
/// When something is there already, the copy would lie in the city itself, or something cannot be read or written.
pub fn copy_city(script: &Path, to: &Path, changes: Option<&str>) -> Result<PathBuf, CopyError> {
    let folder_or_here = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        folder.map_or_else(|| PathBuf::from("."), Path::to_path_buf)
    };
    let (folder, above) = (folder_or_here(script), folder_or_here(to));
    let is_free = !to.exists() || fs::read_dir(to).is_ok_and(|mut entries| entries.next().is_none());
    if !is_free {
        return Err(CopyError::Taken(to.to_path_buf()));
    }
    // As far as there is something: nothing is made in the city to find that out.
    let there = above.ancestors().find(|path| path.exists()).unwrap_or(Path::new("."));
    let real = |path: &Path| path.canonicalize().map_err(at(path));
    if real(there)?.starts_with(real(&folder)?) {
        return Err(CopyError::Inside(to.to_path_buf()));
    }
    fs::create_dir_all(&above).map_err(at(&above))?;
    // Beside its place, then into it: a copy that is cut off is none.
    let unfinished =
        tempfile::Builder::new().prefix(crate::export::UNFINISHED).tempdir_in(&above).map_err(at(&above))?;
    let inside = unfinished.path().join("city");
    copy_folder(&folder, &inside, 0)?;
    let name = script.file_name().unwrap_or_default();
    let file = Changes::file_of(&inside.join(name));
    match changes {
        Some(text) => fs::write(&file, text).map_err(at(to))?,
        None if file.exists() => fs::remove_file(&file).map_err(at(to))?,
        None => {}
    }
    if to.exists() {
        fs::remove_dir(to).map_err(at(to))?;
    }
    fs::rename(&inside, to).map_err(at(to))?;
    Ok(if name == "city.rhai" { to.to_path_buf() } else { to.join(name) })
}

fn copy_folder(from: &Path, to: &Path, depth: usize) -> Result<(), CopyError> {
    if depth > DEEPEST {
        return Err(CopyError::Deep(from.to_path_buf()));
    }
    fs::create_dir(to).map_err(at(to))?;
    for entry in fs::read_dir(from).map_err(at(from))? {
        let entry = entry.map_err(at(from))?;
        let (path, target) = (entry.path(), to.join(entry.file_name()));
        if path.is_dir() {
            copy_folder(&path, &target, depth + 1)?;
            continue;
        }
        // Read and written, for a copy of what nobody may change may be changed.
        let bytes = fs::read(&path).map_err(at(&path))?;
        fs::write(&target, bytes).map_err(at(&target))?;
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
        assert_eq!(copy_city(&city.join("city.rhai"), &to, Some("new")).unwrap(), to);
        assert_eq!(fs::read(to.join("maps/deep/land.png")).unwrap(), [1, 2, 3]);
        assert_eq!(fs::read_to_string(to.join("city.changes")).unwrap(), "new");
        assert_eq!(fs::read_to_string(city.join("city.changes")).unwrap(), "old");
        let bare = folder.path().join("bare");
        fs::create_dir(&bare).unwrap();
        copy_city(&city.join("city.rhai"), &bare, None).unwrap();
        assert!(bare.join("city.rhai").exists() && !bare.join("city.changes").exists());
        fs::write(city.join("other.rhai"), "city(#{ })").unwrap();
        let other = folder.path().join("other");
        assert_eq!(copy_city(&city.join("other.rhai"), &other, None).unwrap(), other.join("other.rhai"));
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
        let wrong = |to: &Path| copy_city(&script, to, None).unwrap_err();
        assert!(matches!(wrong(&city), CopyError::Taken(_)));
        assert!(matches!(wrong(&city.join("inner")), CopyError::Inside(_)));
        assert!(matches!(wrong(&city.join("inner/deeper")), CopyError::Inside(_)) && !city.join("inner").exists());
        fs::write(folder.path().join("file"), "").unwrap();
        assert!(matches!(wrong(&folder.path().join("file/below")), CopyError::Files { .. }));
        fs::remove_file(folder.path().join("file")).unwrap();
        assert_eq!(listing(), ["town"]);
        #[cfg(unix)]
        {
            // A link that goes round.
            std::os::unix::fs::symlink(&city, city.join("again")).unwrap();
            assert!(matches!(wrong(&folder.path().join("copy")), CopyError::Deep(_)));
            assert_eq!(listing(), ["town"]);
        }
    }
}
