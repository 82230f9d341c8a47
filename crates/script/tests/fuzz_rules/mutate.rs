//! Mutants: a rule of the library with one to four changes, drawn from the mutant's number alone.

use geom::Seed;
use script::{Embedded, Library};

/// Draws for one mutant, one after the other.
pub struct Draws {
    seed: Seed,
    next: u64,
}

impl Draws {
    pub fn of(number: u64) -> Self {
        Self { seed: Seed(number).purpose("fuzz rules"), next: 0 }
    }

    /// A number from 0 to below `end`; 0 where that is 0.
    pub fn below(&mut self, end: usize) -> usize {
        self.next += 1;
        (self.seed.child(self.next).0 % end.max(1) as u64) as usize
    }

    /// Whether one of so many cases happens.
    pub fn one_in(&mut self, cases: usize) -> bool {
        self.below(cases) == 0
    }

    pub fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }
}

/// What mutants are made of.
pub struct Stock {
    rules: Vec<String>,
    /// Identifiers of all rules, and words of the language.
    words: Vec<String>,
}

impl Stock {
    pub fn new() -> Self {
        let read = |name: String| Embedded.read(&name).expect("listed").expect("readable").text;
        let rules: Vec<String> = Embedded.names().into_iter().map(read).collect();
        let words = rules.iter().flat_map(|text| tokens(text)).filter(|token| token.kind == Kind::Word);
        let mut words: Vec<String> = words.map(|token| token.text).collect();
        words.extend(WORDS.split_whitespace().map(str::to_owned));
        words.sort_unstable();
        words.dedup();
        Self { rules, words }
    }
}

/// What a piece of text is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Space,
    Word,
    Number,
    Text,
    Comment,
    Sign,
}

/// A piece of text.
#[derive(Clone, Debug)]
pub struct Token {
    pub kind: Kind,
    pub text: String,
}

/// Signs of several characters, longer ones first.
const SIGNS: [&str; 33] = [
    "...", "..=", "<<=", ">>=", "**=", "===", "..", "::", "#{", "=>", "->", "==", "!=", "<=", ">=", "&&", "||", "??",
    "?.", "?[", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<", ">>", "**", "!in", "//",
];

/// The pieces of a text; together they are the text again.
pub fn tokens(text: &str) -> Vec<Token> {
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let (kind, length) = piece(rest, first);
        let (token, behind) = rest.split_at(length);
        found.push(Token { kind, text: token.to_owned() });
        rest = behind;
    }
    found
}

fn piece(rest: &str, first: char) -> (Kind, usize) {
    let until = |ends: &dyn Fn(char) -> bool| rest.find(ends).unwrap_or(rest.len());
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    match first {
        c if c.is_whitespace() => (Kind::Space, until(&|c| !c.is_whitespace())),
        c if c.is_alphabetic() || c == '_' => (Kind::Word, until(&|c| !is_word(c))),
        c if c.is_ascii_digit() => (Kind::Number, number_length(rest)),
        '"' | '`' | '\'' => (Kind::Text, quoted_length(rest, first)),
        '/' if rest.starts_with("//") => (Kind::Comment, until(&|c| c == '\n')),
        '/' if rest.starts_with("/*") => (Kind::Comment, rest.find("*/").map_or(rest.len(), |end| end + 2)),
        _ => {
            let sign = SIGNS.iter().find(|sign| rest.starts_with(**sign));
            (Kind::Sign, sign.map_or(first.len_utf8(), |sign| sign.len()))
        }
    }
}

/// Digits, then a point with digits: `1..5` and `12.pct` have no point of their own.
fn number_length(rest: &str) -> usize {
    let digits =
        |from: usize| rest[from..].find(|c: char| !c.is_ascii_alphanumeric()).map_or(rest.len(), |end| from + end);
    let whole = digits(0);
    let has_part = rest[whole..].starts_with('.') && rest[whole + 1..].starts_with(|c: char| c.is_ascii_digit());
    if has_part { digits(whole + 1) } else { whole }
}

fn quoted_length(rest: &str, quote: char) -> usize {
    let mut is_escaped = false;
    for (at, letter) in rest.char_indices().skip(1) {
        match letter {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            c if c == quote => return at + c.len_utf8(),
            _ => {}
        }
    }
    rest.len()
}

/// What ends the parameters of a rule.
const HEAD_END: &str = "});\n";

/// The mutant that is drawn.
pub fn mutant(draws: &mut Draws, stock: &Stock) -> String {
    let text = draws.pick(&stock.rules);
    // Mostly the parameters stay as they are: what cannot be loaded is not asked.
    let kept = text.find(HEAD_END).filter(|_| !draws.one_in(4)).map_or(0, |end| end + HEAD_END.len());
    let mut changed = text[kept..].to_owned();
    for _ in 0..1 + draws.below(4) {
        changed = match draws.below(12) {
            0..4 => of_tokens(&changed, draws, stock),
            4..9 => with_snippet(&changed, draws),
            9 => of_lines(&changed, draws),
            10 => spliced(&changed, draws, stock),
            _ => with_noise(&changed, draws),
        };
    }
    format!("{}{changed}", &text[..kept])
}

/// Deletes, doubles, swaps or replaces tokens.
fn of_tokens(text: &str, draws: &mut Draws, stock: &Stock) -> String {
    let mut all = tokens(text);
    let of = |kinds: &[Kind]| -> Vec<usize> { (0..all.len()).filter(|&i| kinds.contains(&all[i].kind)).collect() };
    let (solid, numbers, words) =
        (of(&[Kind::Word, Kind::Number, Kind::Text, Kind::Sign]), of(&[Kind::Number]), of(&[Kind::Word]));
    if solid.is_empty() || numbers.is_empty() || words.is_empty() {
        return (*draws.pick(SNIPPETS)).to_owned();
    }
    match draws.below(12) {
        0 => drop(all.remove(*draws.pick(&solid))),
        1 => {
            let at = *draws.pick(&solid);
            all.insert(at, all[at].clone());
        }
        2 => all.swap(*draws.pick(&solid), *draws.pick(&solid)),
        3..8 => all[*draws.pick(&numbers)].text = (*draws.pick(NUMBERS)).to_owned(),
        8 => all[*draws.pick(&words)].text = draws.pick(&stock.words).clone(),
        // A word of the same text, or a word of the language behind a point: that can mostly be read.
        _ => {
            let at = *draws.pick(&words);
            let is_property = at > 0 && all[at - 1].text == ".";
            let other =
                if is_property { draws.pick(&stock.words).clone() } else { all[*draws.pick(&words)].text.clone() };
            all[at].text = other;
        }
    }
    joined(&all)
}

fn joined(tokens: &[Token]) -> String {
    tokens.iter().map(|token| token.text.as_str()).collect()
}

/// A snippet stands where a statement may in a function that is asked; sometimes anywhere.
fn with_snippet(text: &str, draws: &mut Draws) -> String {
    let all = tokens(text);
    let argument = ["block", "shape", "segment"].into_iter().find(|name| text.contains(&format!("({name}, p)")));
    let argument = argument.unwrap_or("tip");
    let is_asked = |tokens: &[Token]| tokens[0].text == "(" && (tokens[1].text == argument || tokens[1].text == "p");
    let from = all.windows(5).rposition(is_asked).unwrap_or(0);
    let ends: Vec<usize> = (from..all.len()).filter(|&i| matches!(all[i].text.as_str(), "{" | ";")).collect();
    let at = if draws.one_in(20) || ends.is_empty() { draws.below(all.len()) } else { *draws.pick(&ends) };
    let (function, statement) = if draws.one_in(8) { *draws.pick(FUNCTIONS) } else { ("", *draws.pick(SNIPPETS)) };
    // Snippets speak of `tip`; what a rule of another kind is asked about has another name, or is not there.
    let has_argument = text.contains(&format!("({argument}, p)"));
    let statement = if has_argument { statement.replace("tip", argument) } else { statement.replace("tip", "p") };
    let (before, after) = all.split_at((at + 1).min(all.len()));
    format!("{} {statement} {}\n{function}", joined(before), joined(after))
}

/// Deletes, doubles or moves a line.
fn of_lines(text: &str, draws: &mut Draws) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    let (from, to) = (draws.below(lines.len()), draws.below(lines.len()));
    if lines.is_empty() {
        return text.to_owned();
    }
    match draws.below(3) {
        0 => drop(lines.remove(from)),
        1 => lines.insert(to, lines[from]),
        _ => lines.swap(from, to),
    }
    lines.join("\n")
}

/// A range of lines comes from another rule.
fn spliced(text: &str, draws: &mut Draws, stock: &Stock) -> String {
    let (mut lines, other): (Vec<&str>, Vec<&str>) =
        (text.lines().collect(), draws.pick(&stock.rules).lines().collect());
    let mut range = |length: usize| {
        let from = draws.below(length);
        from..from + draws.below(length - from.min(length) + 1)
    };
    let (into, from) = (range(lines.len()), range(other.len()));
    lines.splice(into, other[from].iter().copied());
    lines.join("\n")
}

/// Odd characters somewhere.
fn with_noise(text: &str, draws: &mut Draws) -> String {
    let at = draws.below(text.len() + 1);
    let at = (at..=text.len()).find(|&at| text.is_char_boundary(at)).unwrap_or(text.len());
    let (before, after) = text.split_at(at);
    format!("{before}{}{after}", draws.pick(NOISE))
}

/// Numbers at which things end.
const NUMBERS: &[&str] = &[
    "0",
    "-1",
    "1",
    "0.0",
    "-0.0",
    "1e308",
    "-1e308",
    "1e-308",
    "5e-324",
    "9223372036854775807",
    "-9223372036854775808",
    "(-9223372036854775807 - 1)",
    "(1.0/0.0)",
    "(0.0/0.0)",
    "(-1.0/0.0)",
    "65535",
    "65536",
    "1000000000",
    "4294967296",
    "2147483648",
    "-2147483648",
    "9007199254740993",
    "0x7fffffffffffffff",
    "0b11",
    "1_000_000",
    "99999999999999999999",
    "1e999",
    "360",
    "180.0",
    "0.1",
    "500000",
    "1e-9",
];

/// Words of the language that rules may not use, but could.
const WORDS: &str =
    "x y heading width class district is_seed age street_length generation step home_x home_y home_heading
    runs_along turn_to towards distance_to map density elevation slope uphill contour shore peak nearest_peak
    seek_density steer ahead branch_left branch_right fork cross raster rings chance turn delay inner spacing rays arc
    chord area perimeter length longest_side rectangularity zone has_map frontage fronts classes street_width distance
    recursive whole open least_area most_area spread least_frontage irregularity forced_access least_convexity squared
    join depth is_corner is_inner max_height landmark extrude none setback front side rear coverage from_x from_y to_x
    to_y level meets_street shorten cut_to end_at refuse legal mask crossing snap extend duplicate angle arms own prune
    turn_step turn_most turn_first bridge bridge_spacing bridge_over bridge_first hairpin tunnel least full pace consume
    sin cos tan asin acos atan exp ln log sqrt pow hypot floor ceiling round min max clamp mix PI pct to_int to_float
    params metres degrees number ratio choice flag colour range about propose goals constraints constrain subdivide
    build tip block shape segment p this global print debug type_of is_shared call curry Fn let const fn if else
    while loop do until for in break continue return throw try catch switch import export as private true false push
    pop pad len insert remove splice extract drain retain sort reverse filter reduce zip dedup split chars to_string
    parse_int parse_float sub_string crop replace index_of to_upper trim keys values fill_with mixin set get";

/// What goes wrong in programs, as statements.
const SNIPPETS: &[&str] = &[
    "loop { }",
    "while true { }",
    "do { } until false;",
    "for i in 0..9223372036854775807 { }",
    "for i in -9223372036854775807..=9223372036854775807 { }",
    "for i in range(0, 10, 0) { }",
    "for i in range(0, -9223372036854775807, -3) { }",
    "for i in range(0.0, 1e308, 1e-308) { }",
    "for c in \"äöü\\U0001F600\" { print(c); }",
    "for (x, i) in [[1], #{ a: 2 }, \"x\", ()] { print(x); }",
    "propose(tip, p);",
    "subdivide(tip, p); build(tip, p); constrain(tip, p);",
    "constraints(p); goals(p);",
    "Fn(\"propose\").call(tip, p);",
    "let f = Fn(\"propose\").curry(tip); f.call(p);",
    "let f = |x| x; loop { f = f.curry(1); }",
    "let f = |f| f.call(f); f.call(f);",
    "let l = []; let f = || l; l.push(f); l.push(l);",
    "let l = [1, 2]; l.map(|x| l.len());",
    "let l = [3, 1, 2]; try { l.for_each(|x| l.push(x)); } catch { }",
    "let n = 0; [1, 2, 3].for_each(|x| n += x); print(n);",
    "let l = []; for i in 0..600 { l.push((i * 7919) % 97); } l.sort(|a, b| if (a + b) % 3 == 0 { 1 } else { -1 });",
    "let l = []; for i in 0..60 { l.push(i); } l.sort(|a, b| throw a);",
    "[1, \"a\", (), #{}].sort();",
    "[0.0/0.0, 1.0, 0.0/0.0, -1.0].sort();",
    "let l = [1, 2, 3]; l.splice(-9223372036854775807, 9223372036854775807, [4]);",
    "let l = [1, 2, 3]; l.extract(-1, 9223372036854775807); l.drain(1, -1); l.retain(5..2);",
    "let l = [1, 2, 3]; l.insert(-9223372036854775807, 0); l.remove(9223372036854775807); l.chop(-1);",
    "let l = [1, 2, 3]; l[-4] = 1;",
    "let l = [[[]]]; l[0][0][0] = l;",
    "let l = [1]; loop { l += l; }",
    "let l = [1]; loop { l = [l, l]; }",
    "let l = []; l.pad(1000, [1, 2, 3]);",
    "let l = []; l.pad(9223372036854775807, 1);",
    "let l = []; l.pad(999, \"x\"); loop { let m = l; m[0] = 1; }",
    "let s = \"a\"; loop { s += s; }",
    "let s = \"\"; s.pad(10000, 'x'); loop { s.index_of(\"y\"); }",
    "let s = \"\"; s.pad(9999, 'x'); for i in 0..99 { s.replace(\"x\", \"y\"); }",
    "let s = \"\"; s.pad(9999, 'x'); s.replace(\"x\", s);",
    "let s = \"\"; s.pad(9223372036854775807, 'x');",
    "let s = \"\"; s.pad(9000, 'ä'); loop { s.to_upper(); s.len(); s.sub_string(4000, 5000); }",
    "let s = \"\"; s.pad(9000, ' '); loop { s.split(); }",
    "let s = \"äöü\"; s.sub_string(-9223372036854775807, 9223372036854775807); s.crop(-1, -1); s[-9] = 'x';",
    "let s = \"äöü\"; s[1..9223372036854775807]; s[-2]; s.chars(1, -5); s.truncate(-1); s.remove(\"ö\");",
    "let s = `${tip}${p}${[tip]}${|x| x}${#{ a: () }}`; print(s);",
    "let s = \"x\"; for i in 0..30 { s = `${s}${s}`; }",
    "print(\"\\x00\\u202e\\x1b[2J\"); debug(tip);",
    "let m = #{}; loop { m[m.len().to_string()] = m; }",
    "let m = #{}; for i in 0..999 { m[`${i}`] = i; } loop { let n = m; n.x = 1; }",
    "let m = #{ a: #{ b: [1] } }; m.a.b[0] += m.c; m.a.b.c = 1;",
    "let m = #{ propose: 1, p: tip }; m.p.ahead(3); m.mixin(m); m.fill_with(m); m -= m;",
    "this = 1; this.x;",
    "tip.call(|| { this = 3; });",
    "p = #{}; tip = 3; tip.ahead(3);",
    "let p = p; let tip = tip; tip.ahead(1);",
    "let p = tip; p.ahead(p.x);",
    "tip.x = 3; p.block_length = 4; p.x.y.z = 1;",
    "tip[0]; tip[\"x\"]; p[0] = p; tip.x.y();",
    "tip == p; tip + 1; tip && p; !tip; -tip; tip in [tip]; tip?.x ?? 1;",
    "let t = tip; let k = [t, t]; k[0].chance(1); k.map(|t| t.chance(2));",
    "for t in tip { } for q in p { }",
    "return tip;",
    "return |x| x;",
    "return [tip, p];",
    "return #{ snap: 1.0/0.0 };",
    "return [snap(1), snap(2), own(), crossing(), 3];",
    "return [legal(#{ turn_step: 0.1, turn_most: 180, bridge: 10000 }), slope(0, #{ hairpin: true })];",
    "return density(p.map, #{ least: 1e308, full: -1e308, pace: 1e6, consume: 1e9 });",
    "throw tip;",
    "throw ();",
    "throw #{ message: [1, 2], line: -1 };",
    "throw 0.0/0.0;",
    "try { throw p; } catch (e) { e.x; }",
    "try { loop { } } catch { }",
    "loop { try { tip.ahead(-1); } catch { } }",
    "try { propose(tip, p); } catch { propose(tip, p); }",
    "switch tip { 1 => 2, _ if p => 3, _ => throw 4 }",
    "switch 5 { 0..9223372036854775807 => tip.ahead(1), -1..=1 => (), \"x\" | () => 1, _ => 2 }",
    "import \"mine\" as mine; mine::propose(tip, p);",
    "import \"streets/grid\" as grid; grid::propose(tip, p); grid::goals(p);",
    "import \"streets/\" + \"organic\" as o; import \"../x\" as x;",
    "for i in 0..99 { import \"parcels/zoned\" as z; z::subdivide(tip, p); }",
    "global::X = 1; const X = [tip]; global::X.push(1);",
    "const tip = 3; let y = tip; tip.x = y;",
    "params(#{ a: metres(1), a: metres(2), tip: flag(3) });",
    "params(#{ b: metres(1e308).range(-1e308, 1e308).about(\"x\"), c: choice(\"\", []), d: whole(9223372036854775807) });",
    "((((((((((1))))))))));",
    "[[[[[[[[[[1]]]]]]]]]];",
    "if true { if true { if true { if true { if true { if true { if true { tip.ahead(5); } } } } } } }",
    "let x = -9223372036854775807 - 1; x / -1; x % -1; -x; abs(x); x - 1; x * x;",
    "1 << 64; 1 << -1; 1 >> 999; -1 >> 63; 5 % 0; 5.0 % 0.0; 1 / 0;",
    "to_int(1e300); to_int(0.0/0.0);",
    "loop { tip.shore(2000); }",
    "loop { tip.seek_density(100000, 180, 90); }",
    "loop { tip.distance_to(\"parks\"); }",
    "tip.ahead(1e-300, #{ turn: 180, delay: -1000000, width: 200 }); tip.fork(10000, 5e-324);",
    "tip.steer(raster(1e308, 1, 10000, 1e308, -1e308)); tip.ahead(5); tip.runs_along(1e300);",
    "tip.steer(rings(1e308, -1e308, #{ spacing: 5, rays: 64 })); tip.contour(0); tip.turn_to(1e308); tip.towards(1e308, 0);",
    "tip.end_at(400000, -400000); tip.turn(180); tip.cut_to(1e-300); tip.shorten(1e-300);",
];

/// Functions, and statements that call them.
const FUNCTIONS: &[(&str, &str)] = &[
    ("fn own(x) { own(x + 1) }", "own(1);"),
    ("fn odd(n) { even(n + 1) }\nfn even(n) { odd(n) }", "odd(0);"),
    ("fn bump() { this += 1; }", "let n = 1; n.bump(); tip.bump();"),
    ("fn twice(f) { f.call(); f.call(); }", "let l = [1]; twice(|| l.push(l.len()));"),
    ("fn deep(n) { if n > 0 { [[[[[[[[[[deep(n - 1)]]]]]]]]]] } else { 1 } }", "deep(39);"),
    ("fn deep(n) { if n > 0 { import \"mine\" as m; m::deep(n - 1); } }", "deep(30);"),
    ("fn ahead(x) { this.branch_left(x); }\nfn clamp(a, b, c) { throw b; }", "tip.ahead(3); clamp(1, 2, 3);"),
    ("fn max(a, b) { min(a, b) }\nfn min(a, b) { max(a, b) }", "max(1, 2);"),
    ("fn propose(tip) { }\nfn build() { }", "propose(tip);"),
    ("private fn own(x) { x }\nfn own(x, y) { x }", "own(tip); own(tip, p);"),
    ("fn many(a, b, c, d, e, f, g, h) { [a, b, c, d, e, f, g, h] }", "many(tip, p, 3, 4, 5, 6, 7, 8).map(|x| x);"),
    ("const KEPT = [];\nfn keep(x) { global::KEPT.push(x); }", "keep(tip); keep([global::KEPT]);"),
];

/// Characters that no rule has.
const NOISE: &[&str] = &[
    "\u{0}",
    "\u{feff}",
    "\u{1b}[31m",
    "\r",
    "\r\n",
    "\u{2028}",
    "ä",
    "日本",
    "\u{1F600}",
    "e\u{301}",
    "\"",
    "`",
    "'",
    "`${",
    "/*",
    "*/",
    "\\",
    "\\u{110000}",
    "#!",
    "#{",
    "@",
    "~",
    "\u{202e}",
    "\t\u{7f}",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_the_text() {
        let text = "//! Nah.\nfn f(x) { let s = \"a\\\"b\"; x.y += 12.pct ..= 1.5e3 `ä ${x}` /* x */ }";
        let all = tokens(text);
        assert_eq!(all.iter().map(|token| token.text.as_str()).collect::<String>(), text);
        let of = |kind: Kind| all.iter().filter(|t| t.kind == kind).map(|t| t.text.as_str()).collect::<Vec<_>>();
        assert_eq!(of(Kind::Number), ["12", "1.5e3"]);
        assert_eq!(of(Kind::Text), ["\"a\\\"b\"", "`ä ${x}`"]);
        assert_eq!(of(Kind::Comment), ["//! Nah.", "/* x */"]);
        assert!(of(Kind::Sign).contains(&"+=") && of(Kind::Sign).contains(&"..="));
    }

    #[test]
    fn a_number_is_a_mutant() {
        let stock = Stock::new();
        let text = |number| mutant(&mut Draws::of(number), &stock);
        assert_eq!(text(7), text(7));
        assert_ne!(text(7), text(8));
    }
}
