//! Finding things in the text of a script.

/// Where `key:` stands in the first `#{ … }` that opens at or after a position: its line and column. Nested brackets,
/// strings and comments are skipped.
pub(super) fn key_position(text: &str, line: u32, column: u32, key: &str) -> Option<(u32, u32)> {
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

/// The identifiers of a text, in order.
pub(super) fn identifiers(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !is_word(c)).filter(|word| word.starts_with(|c: char| c.is_alphabetic() || c == '_'))
}

#[cfg(test)]
mod tests {
    use super::*;

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
