//! The places of a script that are worth telling, and the script with calls in them.

use super::{LONGEST, StepKind, TELL, TELL_BEHIND, cut};
use crate::host::{Places, code_until, until};
use rhai::{AST, ASTFlags, ASTNode, Expr, FnCallExpr, Position, Stmt};
use std::collections::{BTreeMap, BTreeSet};
use std::ptr;

/// A place of a script that tells a value.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Site {
    /// From 1.
    pub line: u32,
    pub kind: StepKind,
    /// As it is written, on one line.
    pub text: String,
    /// Whether its value is told as well.
    pub shows: bool,
    /// Whether it only reads a property: the same value again says nothing new.
    pub is_read: bool,
}

/// Something to be put into a text.
struct Insert {
    at: usize,
    /// What closes a call stands before what follows a statement, and that before what opens one.
    order: Order,
    text: String,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Order {
    Closes,
    Follows,
    /// The longer one first: it stands around the others.
    Opens(std::cmp::Reverse<usize>),
}

/// The text of a script in which the places worth telling hand on their values, numbered from `first`, and those places.
pub(super) fn with_calls(text: &str, ast: &AST, first: usize) -> (String, Vec<Site>) {
    let mut finder = Finder {
        places: Places::of(text),
        own: ast.iter_functions().map(|function| function.name.to_owned()).collect(),
        bodies: bodies(ast),
        prefixes: BTreeMap::new(),
        first,
        sites: Vec::new(),
        inserts: Vec::new(),
        known: BTreeSet::new(),
    };
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        finder.look(path);
        true
    });
    let Finder { mut inserts, sites, .. } = finder;
    inserts.sort_by_key(|insert| (insert.at, insert.order));
    let mut telling = text.to_owned();
    inserts.iter().rev().for_each(|insert| telling.insert_str(insert.at, &insert.text));
    (telling, sites)
}

/// Line and column.
type Place = (Option<usize>, Option<usize>);

fn place(at: Position) -> Place {
    (at.line(), at.position())
}

/// Where the bodies of functions begin and end.
fn bodies(ast: &AST) -> Vec<(Place, Place)> {
    let body = |name: &str, arguments: usize| {
        let body = &ast.shared_lib().get_script_fn(name, arguments)?.body;
        Some((place(body.start_position()), place(body.end_position())))
    };
    ast.iter_functions().filter_map(|function| body(function.name, function.params.len())).collect()
}

struct Finder<'a> {
    places: Places<'a>,
    /// The functions of the script.
    own: BTreeSet<String>,
    bodies: Vec<(Place, Place)>,
    /// What is told before an expression, by where it lies in memory: `x = ` of the variable that it becomes.
    prefixes: BTreeMap<*const Expr, String>,
    first: usize,
    sites: Vec<Site>,
    inserts: Vec<Insert>,
    /// Where something is told already.
    known: BTreeSet<(usize, usize)>,
}

impl Finder<'_> {
    fn look(&mut self, path: &[ASTNode<'_>]) {
        let around = path.len().checked_sub(2).map(|i| &path[i]);
        match path.last() {
            Some(ASTNode::Stmt(statement)) if self.is_inside(statement.position()) => self.statement(statement),
            Some(ASTNode::Expr(expression)) if self.is_inside(expression.start_position()) => {
                self.expression(expression, around);
            }
            _ => {}
        }
    }

    /// Whether a place lies in a function: the top of a script is run when it is loaded.
    fn is_inside(&self, at: Position) -> bool {
        let at = place(at);
        self.bodies.iter().any(|(from, to)| *from <= at && at <= *to)
    }

    fn byte(&self, at: Position) -> Option<usize> {
        self.places.at(at).map(|(byte, ..)| byte)
    }

    fn statement(&mut self, statement: &Stmt) {
        let Some(from) = self.byte(statement.position()) else { return };
        match statement {
            Stmt::Var(parts, ..) if !parts.1.is_constant() => self.variable(from, parts.0.as_str(), &parts.1),
            Stmt::Assignment(parts) => {
                if let Expr::Variable(variable, ..) = &parts.1.lhs
                    && let Some(from) = self.byte(parts.1.lhs.start_position())
                {
                    self.after_statement(from, variable.1.as_str());
                }
            }
            Stmt::If(parts, _) => self.condition(from, "if", &parts.expr, self.byte(parts.body.position())),
            Stmt::While(parts, _) => self.condition(from, "while", &parts.expr, self.byte(parts.body.position())),
            Stmt::Switch(parts, _) if !parts.0.is_constant() => {
                let end = from + until(&self.places.text[from..], &['{']);
                self.behind_word(from, "switch", end, StepKind::Value, true);
            }
            Stmt::For(parts, _) => {
                if let Some(body) = self.byte(parts.2.body.position()) {
                    self.follow(from, body + 1, &format!("for {}", parts.0.as_str()), parts.0.as_str());
                }
            }
            Stmt::Return(Some(value), flags, _) if !flags.contains(ASTFlags::BREAK) => {
                if self.is_told(value) {
                    self.prefixes.insert(ptr::from_ref(value), "return ".into());
                } else {
                    let end = from + until(&self.places.text[from..], &[';', '}']);
                    self.behind_word(from, "return", end, StepKind::Value, !value.is_constant());
                }
            }
            Stmt::FnCall(call, at) => self.call(call, *at, ""),
            _ => {}
        }
    }

    /// A variable: with what is told anyway in one step, else after its statement.
    fn variable(&mut self, from: usize, name: &str, value: &Expr) {
        if self.is_told(value) {
            self.prefixes.insert(ptr::from_ref(value), format!("{name} = "));
        } else {
            self.after_statement(from, name);
        }
    }

    /// A variable once the statement that begins at a byte is over.
    fn after_statement(&mut self, from: usize, name: &str) {
        let end = from + until(&self.places.text[from..], &[';', '}', ',', ')', ']']);
        match self.places.text[end..].chars().next() {
            Some(';') => self.follow(from, end + 1, name, name),
            // The last of its block.
            Some('}') => {
                let call = format!("; {TELL_BEHIND}({}, {name});", self.first + self.sites.len());
                self.inserts.push(Insert { at: end, order: Order::Follows, text: call });
                self.site(from, StepKind::Value, name, true, false);
            }
            _ => {}
        }
    }

    /// Tells a variable at a byte that lies between statements.
    fn follow(&mut self, from: usize, at: usize, text: &str, name: &str) {
        let call = format!(" {TELL_BEHIND}({}, {name});", self.first + self.sites.len());
        self.inserts.push(Insert { at, order: Order::Follows, text: call });
        self.site(from, StepKind::Value, text, true, false);
    }

    fn condition(&mut self, from: usize, word: &str, condition: &Expr, end: Option<usize>) {
        if let Some(end) = end.filter(|_| !condition.is_constant()) {
            self.behind_word(from, word, end, StepKind::Test, true);
        }
    }

    /// What stands between a word and a byte.
    fn behind_word(&mut self, from: usize, word: &str, end: usize, kind: StepKind, shows: bool) {
        let text = self.places.text;
        // A comment would take in what closes the call.
        let end = from + code_until(&text[from..end], &[]);
        let Some(behind) = text[from..end].strip_prefix(word) else { return };
        let start = end - behind.trim_start().len();
        if start < end && self.wrap(start, end) {
            self.site(from, kind, &text[from..end], shows, false);
        }
    }

    fn expression(&mut self, expression: &Expr, around: Option<&ASTNode<'_>>) {
        let prefix = self.prefixes.remove(&ptr::from_ref(expression)).unwrap_or_default();
        match expression {
            Expr::Dot(..) | Expr::Index(..) if is_root_plain(expression) && is_whole(expression, around) => {
                let Some(from) = self.byte(expression.start_position()) else { return };
                let end = end_of_chain(self.places.text, from);
                let told = &self.places.text[from..end];
                if self.wrap(from, end) {
                    let is_read = prefix.is_empty() && !told.contains('(');
                    self.site(from, StepKind::Value, &format!("{prefix}{told}"), true, is_read);
                }
            }
            Expr::FnCall(call, at) => self.call(call, *at, &prefix),
            _ => {}
        }
    }

    /// A call of a function of the script or of one that it imports, and of what is there for looking at a rule.
    fn call(&mut self, call: &FnCallExpr, at: Position, prefix: &str) {
        let Some(name) = self.byte(at) else { return };
        let text = self.places.text;
        let Some(open) = text[name..].find('(').map(|length| name + length + 1) else { return };
        let end = open + until(&text[open..], &[')']);
        if !text[end..].starts_with(')') {
            return;
        }
        if matches!(call.name.as_str(), "print" | "debug") && call.args.len() == 1 {
            if self.wrap(open, end) {
                self.site(name, StepKind::Print, call.name.as_str(), true, false);
            }
        } else if self.is_told_call(call) {
            let from = start_of_path(text, name);
            if self.wrap(from, end + 1) {
                self.site(from, StepKind::Value, &format!("{prefix}{}", &text[from..=end]), true, false);
            }
        }
    }

    /// Whether an expression tells its value by itself.
    fn is_told(&self, expression: &Expr) -> bool {
        match expression {
            Expr::Dot(..) | Expr::Index(..) => is_root_plain(expression),
            Expr::FnCall(call, _) => self.is_told_call(call),
            _ => false,
        }
    }

    fn is_told_call(&self, call: &FnCallExpr) -> bool {
        !call.namespace.is_empty() || call.name == "mark" || self.own.contains(call.name.as_str())
    }

    /// Puts a call around a stretch of the text, unless there is one.
    fn wrap(&mut self, from: usize, to: usize) -> bool {
        if !self.known.insert((from, to)) {
            return false;
        }
        let call = format!("{TELL}({}, ", self.first + self.sites.len());
        // What stands right before may be a word.
        let call =
            if self.places.text[..from].ends_with(|c: char| c.is_alphanumeric()) { format!(" {call}") } else { call };
        let opens = Order::Opens(std::cmp::Reverse(to - from));
        self.inserts.push(Insert { at: from, order: opens, text: call });
        self.inserts.push(Insert { at: to, order: Order::Closes, text: ")".into() });
        true
    }

    fn site(&mut self, from: usize, kind: StepKind, told: &str, shows: bool, is_read: bool) {
        let line = 1 + self.places.text[..from].matches('\n').count() as u32;
        let text = told.split_whitespace().collect::<Vec<_>>().join(" ");
        self.sites.push(Site { line, kind, text: cut(&text, LONGEST), shows, is_read });
    }
}

/// Whether a chain starts at a variable.
fn is_root_plain(chain: &Expr) -> bool {
    match chain {
        Expr::Dot(parts, ..) | Expr::Index(parts, ..) => is_root_plain(&parts.lhs),
        Expr::Variable(variable, ..) => variable.2.is_empty(),
        _ => false,
    }
}

/// Whether a chain is no part of a longer one, and is read rather than assigned to.
fn is_whole(chain: &Expr, around: Option<&ASTNode<'_>>) -> bool {
    match around {
        Some(ASTNode::Expr(Expr::Dot(parts, ..))) => !ptr::eq(&parts.rhs, chain),
        Some(ASTNode::Expr(Expr::Index(parts, flags, _))) => {
            flags.contains(ASTFlags::BREAK) || !ptr::eq(&parts.rhs, chain)
        }
        Some(ASTNode::Stmt(Stmt::Assignment(parts))) => !ptr::eq(&parts.1.lhs, chain),
        _ => true,
    }
}

fn is_of_word(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

/// Where a word ends that begins at a byte.
fn end_of_word(text: &str, from: usize) -> usize {
    text[from..].find(|c| !is_of_word(c)).map_or(text.len(), |length| from + length)
}

/// Where the bracket closes that opens at a byte.
fn end_of_brackets(text: &str, open: usize) -> usize {
    (open + 1 + until(&text[open + 1..], &[')', ']', '}']) + 1).min(text.len())
}

/// Where a chain of properties, calls and indices ends that begins with a variable at a byte.
fn end_of_chain(text: &str, from: usize) -> usize {
    let mut end = end_of_word(text, from);
    loop {
        let blanks = text[end..].find(|c: char| !c.is_whitespace()).unwrap_or(0);
        let next = end + blanks;
        let rest = text[next..].strip_prefix('?').unwrap_or(&text[next..]);
        let at = text.len() - rest.len();
        if rest.starts_with('.') && !rest.starts_with("..") {
            let word = at + 1 + rest[1..].find(|c: char| !c.is_whitespace()).unwrap_or(0);
            end = end_of_word(text, word);
            if text[end..].starts_with('(') {
                end = end_of_brackets(text, end);
            }
        } else if rest.starts_with('[') {
            end = end_of_brackets(text, at);
        } else {
            return end;
        }
    }
}

/// Where a function's name begins with the modules before it: `a::b::name`.
fn start_of_path(text: &str, name: usize) -> usize {
    let mut from = name;
    while let Some(before) = text[..from].strip_suffix("::") {
        let word =
            before.rfind(|c| !is_of_word(c)).map_or(0, |at| at + before[at..].chars().next().map_or(1, char::len_utf8));
        from = word;
    }
    from
}
