//! Finding things in the text of a script.

/// Where `key:` stands in the first `#{ … }` that opens at or after a position: its line and column. Nested brackets,
/// strings and comments are skipped.
pub(crate) fn key_position(text: &str, line: u32, column: u32, key: &str) -> Option<(u32, u32)> {
    let mut scan = Scan::new(text, line, column)?;
    while scan.chars.get(scan.at)? != &'#' || scan.chars.get(scan.at + 1) != Some(&'{') {
        scan.step();
    }
    scan.step();
    scan.step();
    let mut depth = 1;
    while depth > 0 {
        match scan.chars.get(scan.at)? {
            '{' | '(' | '[' => depth += 1,
            '}' | ')' | ']' => depth -= 1,
            _ if depth == 1 && scan.is_key(key) => return Some((scan.line, scan.column)),
            _ => {}
        }
        scan.step();
    }
    None
}

/// The bracket of a kind that is most likely the one without its partner: one whose partner stands at the head of a line
/// that is indented otherwise, else the last that is open at the end.
pub(super) fn unclosed(text: &str, opens: char) -> Option<(u32, u32)> {
    let indents: Vec<usize> = text.lines().map(|line| line.chars().take_while(|c| c.is_whitespace()).count()).collect();
    let indent = |line: u32| indents.get(line as usize - 1).copied().unwrap_or(0);
    let mut scan = Scan::new(text, 1, 1)?;
    let mut open: Vec<(char, u32, u32)> = Vec::new();
    while let Some(&c) = scan.chars.get(scan.at) {
        match c {
            '{' | '(' | '[' => open.push((c, scan.line, scan.column)),
            '}' | ')' | ']' => {
                let heads_line = scan.column as usize == indent(scan.line) + 1;
                match open.pop() {
                    Some((c, line, column)) if c == opens && heads_line && indent(line) != indent(scan.line) => {
                        return Some((line, column));
                    }
                    _ => {}
                }
            }
            _ => {}
        }
        scan.step();
    }
    open.iter().rev().find(|(c, ..)| *c == opens).map(|&(_, line, column)| (line, column))
}

/// Where a script says what a message is about: the district that it names, else the only key that it names. Line, column
/// and length, from 1.
pub fn place_in_script(text: &str, message: &str) -> Option<(u32, u32, u32)> {
    let quoted = |head: &str| Some(message.split_once(head)?.1.split_once('`')?.0);
    let keys: Vec<(u32, u32, u32)> = match quoted("differs in `") {
        Some(district) => keys(text, district).take(1).collect(),
        None => keys(text, message.split('`').nth(1)?).collect(),
    };
    if let [only] = keys[..] { Some(only) } else { None }
}

/// Where `name:` or `"name":` stands outside of remarks.
fn keys(text: &str, name: &str) -> impl Iterator<Item = (u32, u32, u32)> {
    let is_key = |line: &str, at: usize, length: usize| {
        let ends = |c: char| !is_word(c) && c != '"';
        line[..at].chars().next_back().is_none_or(ends) && line[at + length..].trim_start().starts_with(':')
    };
    text.lines().zip(1..).flat_map(move |(line, number)| {
        let code = line.split("//").next().unwrap_or_default();
        let forms = [name.to_owned(), format!("\"{name}\"")];
        forms.into_iter().find_map(|form| {
            let at = code.match_indices(&form).map(|(at, _)| at).find(|&at| is_key(code, at, form.len()))?;
            Some((number, code[..at].chars().count() as u32 + 1, form.chars().count() as u32))
        })
    })
}

/// Where the comment begins that has no end; comments may stand within comments.
pub(crate) fn open_comment(text: &str) -> Option<(u32, u32)> {
    let mut scan = Scan::new(text, 1, 1).filter(|_| text.contains("/*"))?;
    let pair = |scan: &Scan| (scan.chars.get(scan.at).copied(), scan.chars.get(scan.at + 1).copied());
    loop {
        match pair(&scan) {
            (None, _) => return None,
            (Some('/'), Some('*')) => {}
            _ => {
                scan.step();
                continue;
            }
        }
        let (start, mut depth) = ((scan.line, scan.column), 0u32);
        loop {
            let by = match pair(&scan) {
                (None, _) => return Some(start),
                (Some('/'), Some('*')) => 1,
                (Some('*'), Some('/')) => -1,
                _ => 0,
            };
            depth = depth.saturating_add_signed(by);
            (0..if by == 0 { 1 } else { 2 }).for_each(|_| scan.advance());
            if depth == 0 {
                break;
            }
        }
    }
}

/// Where a word stands in a line, from 1; 0 where it does not.
pub(crate) fn column_of(text: &str, line: u32, word: &str) -> u32 {
    let row = text.lines().nth((line as usize).wrapping_sub(1)).unwrap_or_default();
    row.find(word).map_or(0, |at| row[..at].chars().count() as u32 + 1)
}

/// How many characters the word, number, text or sign at a place has; 0 past the end of its line.
pub(super) fn word_length(text: &str, line: u32, column: u32) -> u32 {
    let Some(row) = text.lines().nth((line as usize).wrapping_sub(1)) else { return 0 };
    let rest: Vec<char> = row.chars().skip((column as usize).saturating_sub(1)).collect();
    let Some(&first) = rest.first() else { return 0 };
    let length = match first {
        c if is_word(c) => rest.iter().take_while(|c| is_word(**c)).count(),
        '"' | '`' => quoted_length(&rest),
        '#' if rest.get(1) == Some(&'{') => 2,
        '(' | ')' | '[' | ']' | '{' | '}' | ',' | ';' => 1,
        c if c.is_whitespace() => 1,
        _ => rest.iter().take_while(|c| is_sign(**c)).count().max(1),
    };
    length as u32
}

/// The length of a text with its quotes, to the end of the line where it is not closed there.
fn quoted_length(rest: &[char]) -> usize {
    let mut at = 1;
    while at < rest.len() && rest[at] != rest[0] {
        at += if rest[at] == '\\' { 2 } else { 1 };
    }
    (at + 1).min(rest.len())
}

fn is_sign(c: char) -> bool {
    "+-*/%=<>!&|^?:.".contains(c)
}

/// A walk over a text that jumps over comments and the inside of strings.
struct Scan {
    chars: Vec<char>,
    at: usize,
    line: u32,
    column: u32,
}

impl Scan {
    fn new(text: &str, line: u32, column: u32) -> Option<Self> {
        let mut scan = Self { chars: text.chars().collect(), at: 0, line: 1, column: 1 };
        while (scan.line, scan.column) < (line, column) {
            scan.chars.get(scan.at)?;
            scan.advance();
        }
        Some(scan)
    }

    /// Goes on by one character.
    fn advance(&mut self) {
        let newline = self.chars.get(self.at) == Some(&'\n');
        (self.line, self.column) = if newline { (self.line + 1, 1) } else { (self.line, self.column + 1) };
        self.at += 1;
    }

    /// Goes on by one character, one identifier, one string or one comment.
    fn step(&mut self) {
        let next = self.chars.get(self.at + 1);
        match self.chars.get(self.at) {
            Some('"' | '`') => self.skip_string(),
            Some('/') if next == Some(&'/') => self.skip_while(|rest| rest[0] != '\n'),
            Some('/') if next == Some(&'*') => self.skip_while(|rest| !rest.starts_with(&['*', '/'])),
            Some(c) if is_word(*c) => self.skip_while(|rest| is_word(rest[0])),
            _ => self.advance(),
        }
    }

    fn skip_while(&mut self, goes_on: impl Fn(&[char]) -> bool) {
        while self.at < self.chars.len() && goes_on(&self.chars[self.at..]) {
            self.advance();
        }
    }

    fn skip_string(&mut self) {
        let quote = self.chars[self.at];
        self.advance();
        while self.chars.get(self.at).is_some_and(|c| *c != quote) {
            if self.chars[self.at] == '\\' {
                self.advance();
            }
            self.advance();
        }
        self.advance();
    }

    /// Whether the key, bare or quoted, stands here with a colon behind it.
    fn is_key(&self, key: &str) -> bool {
        let rest = &self.chars[self.at..];
        let quoted = rest[0] == '"';
        let rest = &rest[usize::from(quoted)..];
        let length = key.chars().count();
        let same = rest.len() > length && rest.iter().copied().zip(key.chars()).all(|(a, b)| a == b);
        if !same || (!quoted && is_word(rest[length])) {
            return false;
        }
        let after = rest[length + usize::from(quoted)..].iter();
        after.copied().find(|c| !c.is_whitespace()) == Some(':')
    }
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// What stands from a line and a column on, both from 1, to the end of the line; nothing where there is no such place.
pub(super) fn from_place(text: &str, line: usize, column: usize) -> &str {
    let row = text.lines().nth(line.wrapping_sub(1)).unwrap_or_default();
    row.char_indices().nth(column.saturating_sub(1)).map_or("", |(start, _)| &row[start..])
}

/// The identifiers of a text, in order.
pub(super) fn identifiers(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !is_word(c)).filter(|word| word.starts_with(|c: char| c.is_alphabetic() || c == '_'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_measured_as_they_are_written() {
        let text = "let größe = tip.ahead(1.5) ** \"a\\\"b\";\n#{ a: 'x }";
        let found = [1, 5, 11, 13, 17, 23, 28, 31].map(|column| word_length(text, 1, column));
        assert_eq!(found, [3, 5, 1, 3, 5, 1, 2, 6]);
        assert_eq!((word_length(text, 2, 1), word_length(text, 2, 99), word_length(text, 3, 1)), (2, 0, 0));
        assert_eq!(word_length(text, 0, 0), 0);
    }

    #[test]
    fn the_bracket_that_was_forgotten_is_told_by_indents() {
        let forgotten = "fn a() {\n    if b {\n        c();\n    d();\n}\n";
        assert_eq!(unclosed(forgotten, '{'), Some((2, 10)));
        assert_eq!(unclosed("fn a() {\n    b(c(1);\n}", '('), Some((2, 6)));
        assert_eq!(unclosed("fn a() { \"}\"", '{'), Some((1, 8)));
        assert_eq!(unclosed("fn a() { }", '{'), None);
        assert_eq!((column_of("fn größe(a)", 1, "(a"), column_of("x", 4, "x")), (9, 0));
    }

    #[test]
    fn keys_are_found_at_their_own_depth() {
        let text = "city(#{\n  a: rule(#{ b: 1 }), // b: no\n  \"b\": \"b:\",\n  bb: 2,\n  c : 3 })";
        assert_eq!(key_position(text, 1, 1, "a"), Some((2, 3)));
        assert_eq!(key_position(text, 1, 1, "b"), Some((3, 3)));
        assert_eq!(key_position(text, 1, 1, "bb"), Some((4, 3)));
        assert_eq!(key_position(text, 1, 1, "c"), Some((5, 3)));
        assert_eq!(key_position(text, 2, 6, "b"), Some((2, 14)));
        assert_eq!(key_position(text, 1, 1, "d"), None);
        assert_eq!(key_position(text, 9, 9, "d"), None);
        assert_eq!(key_position("x", 1, 1, "d"), None);
    }
}
