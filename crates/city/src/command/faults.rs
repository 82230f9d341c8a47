//! Faults of scripts as people read them: with the line they are in.

use super::Status;
use city::FaultReport;
use codespan_reporting::diagnostic::{Diagnostic, Label, Severity};
use codespan_reporting::files::SimpleFiles;
use codespan_reporting::term::termcolor::{ColorChoice, StandardStream};
use codespan_reporting::term::{Config, Styles, StylesWriter, emit_into_string, emit_to_write_style};
use script::Texts;
use std::collections::BTreeMap;
use std::io::IsTerminal;

/// The files of a report, each once: what lies in one file is shown in one piece.
struct Files {
    files: SimpleFiles<String, String>,
    known: BTreeMap<String, usize>,
}

impl Files {
    fn id(&mut self, name: &str, text: &str) -> usize {
        let add = || self.files.add(name.to_owned(), visible(text));
        *self.known.entry(name.to_owned()).or_insert_with(add)
    }
}

/// Tells faults on standard error, in colour on a terminal.
pub fn tell(faults: &[FaultReport], texts: &Texts) {
    let is_plain = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let has_colours = std::io::stderr().is_terminal() && !is_plain;
    let mut files = Files { files: SimpleFiles::new(), known: BTreeMap::new() };
    for fault in faults {
        let diagnostic = diagnostic(fault, texts, &mut files);
        if !has_colours {
            eprint!("{}", emit_into_string(&Config::default(), &files.files, &diagnostic).unwrap_or_default());
            continue;
        }
        let stream = StandardStream::stderr(ColorChoice::Auto);
        let styles = Styles::default();
        // Where standard error is gone there is nobody to tell.
        let _ = emit_to_write_style(
            &mut StylesWriter::new(stream.lock(), &styles),
            &Config::default(),
            &files.files,
            &diagnostic,
        );
    }
}

/// What a fault looks like: its line, then the calls that led there, each in its file.
fn diagnostic(fault: &FaultReport, texts: &Texts, files: &mut Files) -> Diagnostic<usize> {
    let severity = if fault.is_error() { Severity::Error } else { Severity::Warning };
    let mut labels = Vec::new();
    if let Some((file, range)) = place(&fault.file, (fault.line, fault.column, fault.length), texts, files) {
        labels.push(Label::primary(file, range));
    }
    let message = if labels.is_empty() { format!("{}: {}", fault.file, fault.message) } else { fault.message.clone() };
    for call in &fault.calls {
        let label = place(&call.file, (call.line, call.column, 0), texts, files);
        labels.extend(label.map(|(file, range)| {
            let text = format!("`{}` is called here", call.function);
            Label::secondary(file, range).with_message(text)
        }));
    }
    let times = (fault.count > 1).then(|| format!("{} times", fault.count));
    let at = fault.place.map(|[x, y]| {
        let first = if fault.count > 1 { "first " } else { "" };
        format!("{first}at ({x:.1}, {y:.1}) m")
    });
    let happened: Vec<String> = times.into_iter().chain(at).collect();
    let hint = fault.hint.as_ref().map(|hint| format!("hint: {hint}"));
    let notes = hint.into_iter().chain((!happened.is_empty()).then(|| happened.join(", "))).collect();
    Diagnostic::new(severity).with_message(message).with_labels(labels).with_notes(notes)
}

/// A file and the bytes of so many characters at a line and column in it.
fn place(
    file: &str,
    (line, column, length): (u32, u32, u32),
    texts: &Texts,
    files: &mut Files,
) -> Option<(usize, std::ops::Range<usize>)> {
    let text = texts.get(file).filter(|_| line > 0)?;
    let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1));
    let start = starts.into_iter().nth(line as usize - 1)?;
    let row = text[start..].lines().next().unwrap_or_default();
    let bytes = |characters: u32| row.char_indices().nth(characters as usize).map_or(row.len(), |(at, _)| at);
    let from = column.saturating_sub(1);
    let range = start + bytes(from)..start + bytes(from + length.max(1));
    Some((files.id(file, &text), range))
}

/// A text without characters that a terminal would obey; as many bytes, so that places stay where they are.
fn visible(text: &str) -> String {
    let is_hidden = |letter: char| letter.is_control() && letter != '\n' && letter != '\t';
    // Line ends of Windows are no part of a line.
    let text = text.replace("\r\n", " \n");
    let shown = |letter: char| match (is_hidden(letter), letter.len_utf8()) {
        (false, _) => letter,
        (true, 1) => '?',
        (true, _) => '¿',
    };
    text.chars().map(shown).collect()
}

/// One line that says how many there were.
pub fn summary(faults: &[FaultReport]) -> String {
    let errors = faults.iter().filter(|fault| fault.is_error()).count();
    match faults.len() - errors {
        0 => counted(errors, "error"),
        warnings => format!("{}, {}", counted(errors, "error"), counted(warnings, "warning")),
    }
}

/// `1 error`, `2 errors`.
pub fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}

/// Whether any of them is an error, as a status.
pub fn status(faults: &[FaultReport]) -> Status {
    if faults.iter().any(FaultReport::is_error) { Status::Faults } else { Status::Done }
}
