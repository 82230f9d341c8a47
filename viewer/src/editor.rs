//! Opening a place of a script in an editor.

use crate::worker::whole;
use std::path::Path;
use std::process::{Command, Stdio};

/// What opens a place, until people say otherwise.
pub const USUAL: &str = "code --goto {file}:{line}:{column}";

/// Opens a place by a command with `{file}`, `{line}` and `{column}`; without `{file}` the file comes last.
///
/// # Errors
/// When the file is none of this computer, or the command cannot be started.
pub fn open(command: &str, file: &str, line: u32, column: u32) -> Result<(), String> {
    let path = whole(Path::new(file));
    if !path.is_file() {
        return Err(format!(
            "{file} is no file here: it is a rule that comes with the program; Change it for this city makes one of it"
        ));
    }
    let words = words(command, &path.display().to_string(), line, column);
    let (program, arguments) = words.split_first().ok_or("no editor is named")?;
    let started = Command::new(program).args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).spawn();
    match started {
        Ok(mut child) => {
            // Whoever it is ends by itself; waiting for it leaves no dead process behind.
            let waits = std::thread::Builder::new().name("editor".into()).spawn(move || drop(child.wait()));
            waits.map(drop).map_err(|error| error.to_string())
        }
        Err(error) => Err(format!("`{program}` could not be started: {error}; another editor can be named in Source")),
    }
}

/// The words of a command with a place put in.
fn words(command: &str, file: &str, line: u32, column: u32) -> Vec<String> {
    let put = |word: &str| {
        let word = word.replace("{line}", &line.to_string()).replace("{column}", &column.to_string());
        word.replace("{file}", file)
    };
    let mut words: Vec<String> = command.split_whitespace().map(put).collect();
    if !command.contains("{file}") && !words.is_empty() {
        words.push(file.to_owned());
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_put_into_commands() {
        assert_eq!(words(USUAL, "/a b/c.rhai", 3, 7), ["code", "--goto", "/a b/c.rhai:3:7"]);
        assert_eq!(words("vi +{line}", "/c.rhai", 3, 7), ["vi", "+3", "/c.rhai"]);
        assert_eq!(words(" ", "/c.rhai", 3, 7), Vec::<String>::new());
    }

    #[test]
    fn what_cannot_be_opened_is_told() {
        assert!(open(USUAL, "streets/nowhere.rhai", 1, 1).unwrap_err().contains("no file here"));
        let file = tempfile::NamedTempFile::new().unwrap();
        let path = file.path().to_string_lossy().into_owned();
        assert!(open("no-such-editor", &path, 1, 1).unwrap_err().contains("no-such-editor"));
        assert!(open("", &path, 1, 1).unwrap_err().contains("no editor"));
        open("true {line}", &path, 1, 1).unwrap();
    }
}
