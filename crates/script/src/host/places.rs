//! Where things stand in the text of a script, for putting calls into it: Rhai tells where they begin, not where they end.

use rhai::Position;

/// From lines and columns to bytes.
pub(crate) struct Places<'a> {
    pub text: &'a str,
    /// Where each line starts.
    lines: Vec<usize>,
}

impl<'a> Places<'a> {
    /// Those of a text.
    pub fn of(text: &'a str) -> Self {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1));
        Self { text, lines: starts.collect() }
    }

    /// The byte at a position, with its line and column.
    pub fn at(&self, position: Position) -> Option<(usize, u32, u32)> {
        let (line, column) = (position.line()?, position.position()?);
        let start = *self.lines.get(line - 1)?;
        let (offset, _) = self.text[start..].char_indices().nth(column - 1)?;
        Some((start + offset, line as u32, column as u32))
    }
}

/// How far a text goes until a letter that ends it stands outside of brackets, texts and comments; all of it where there is
/// none. A `{` after `#` begins a map and ends nothing.
pub(crate) fn until(text: &str, ends: &[char]) -> usize {
    scan(text, ends).0
}

/// The same without the blanks and comments before that.
pub(crate) fn code_until(text: &str, ends: &[char]) -> usize {
    scan(text, ends).1
}

/// Where a text ends, and where the last letter of it that is no comment does.
fn scan(text: &str, ends: &[char]) -> (usize, usize) {
    let (mut depth, mut quote, mut before, mut letters) = (0, None, ' ', text.char_indices().peekable());
    let mut code = 0;
    while let Some((at, letter)) = letters.next() {
        let next = letters.peek().map(|(_, next)| *next);
        match (quote, letter) {
            (Some(_), '\\') => {
                letters.next();
                continue;
            }
            (Some(mark), _) if mark == letter => quote = None,
            (Some(_), _) => {}
            (None, '"' | '`' | '\'') => quote = Some(letter),
            (None, '/') if next == Some('/') => {
                letters.by_ref().find(|(_, letter)| *letter == '\n');
                continue;
            }
            (None, '/') if next == Some('*') => {
                let end = text[at..].find("*/").map_or(text.len(), |length| at + length + 1);
                letters.by_ref().find(|(at, _)| *at >= end);
                continue;
            }
            (None, _) if depth == 0 && ends.contains(&letter) && (letter, before) != ('{', '#') => return (at, code),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') if depth > 0 => depth -= 1,
            _ => {}
        }
        before = letter;
        if !letter.is_whitespace() {
            code = at + letter.len_utf8();
        }
    }
    (text.len(), code)
}

#[cfg(test)]
mod tests {
    use super::{code_until, until};

    #[test]
    fn what_stands_in_brackets_texts_and_comments_ends_nothing() {
        for (text, ends, wanted) in [
            ("f(1, \"},\"), // one, two }", &[',', '}'][..], "f(1, \"},\")"),
            ("a /* ; */ + `;` + ';' ; b", &[';'], "a /* ; */ + `;` + ';' "),
            ("#{ a: 1 }.a { 1 }", &['{'], "#{ a: 1 }.a "),
            ("(a, [b; c]) }", &[';', '}'], "(a, [b; c]) "),
            ("a // ;", &[';'], "a // ;"),
        ] {
            assert_eq!(&text[..until(text, ends)], wanted, "{text}");
        }
        for (text, wanted) in
            [("a // ;\n ;", "a"), ("f(b /* c */) /* d */ // e\n;", "f(b /* c */)"), ("`a;` ;", "`a;`")]
        {
            assert_eq!(&text[..code_until(text, &[';'])], wanted, "{text}");
        }
    }
}
