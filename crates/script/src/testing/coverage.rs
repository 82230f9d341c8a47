//! Which branches of rules tests reach.
//!
//! Rhai does not say which statements it runs, so each branch of a rule's text is given a call that counts; lines stay
//! where they are.

use crate::host::{Places, Source, until};
use rhai::{AST, ASTNode, Engine, Position, Stmt};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// The word that counts. No identifier that a person writes.
const COUNT: &str = "covered__";

/// A branch of a rule.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Branch {
    /// Where it begins, from 1.
    pub line: u32,
    /// Where it begins, from 1, in characters.
    pub column: u32,
    /// `function`, `if`, `else`, `loop`, `case`.
    pub what: &'static str,
    /// How often it was run.
    pub count: u64,
}

/// A branch before it is counted.
#[derive(Clone, Debug)]
struct Found {
    /// Bytes from the start of the text.
    at: usize,
    line: u32,
    column: u32,
    what: &'static str,
    /// What is put before and behind the number, and where what is behind goes.
    form: Form,
}

/// How a branch is given its call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// `{` becomes `{ covered__(n);`.
    Block,
    /// ` else { covered__(n); }` is added.
    MissingElse,
    /// An expression, up to a byte, is put into a block.
    Expression(usize),
}

/// Counts of branches by rule file. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub struct Coverage(Arc<Mutex<BTreeMap<String, Counted>>>);

/// The branches of a file with their counts.
type Counted = (Vec<Branch>, Arc<[AtomicU64]>);

impl Coverage {
    /// The branches of a rule file, in the order of the text; nothing where no test asked for the rule.
    pub fn of(&self, path: &str) -> Vec<Branch> {
        let known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let Some((branches, counts)) = known.get(path) else { return Vec::new() };
        let count =
            |(branch, count): (&Branch, &AtomicU64)| Branch { count: count.load(Ordering::Relaxed), ..branch.clone() };
        branches.iter().zip(counts.iter()).map(count).collect()
    }

    /// The text of a rule with a call in each branch, and what counts the calls.
    pub(crate) fn counted(&self, source: &Source, ast: &AST, engine: &mut Engine) -> String {
        let found = branches(&source.text, ast);
        let branch = |found: &Found| Branch { line: found.line, column: found.column, what: found.what, count: 0 };
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let fresh = || (found.iter().map(branch).collect(), found.iter().map(|_| AtomicU64::new(0)).collect());
        let counts = known.entry(source.path.clone()).or_insert_with(fresh).1.clone();
        engine.register_fn(COUNT, move |n: i64| {
            if let Some(count) = usize::try_from(n).ok().and_then(|n| counts.get(n)) {
                count.fetch_add(1, Ordering::Relaxed);
            }
        });
        with_calls(&source.text, &found)
    }
}

/// Puts the calls in, from the end of the text to its start.
fn with_calls(text: &str, found: &[Found]) -> String {
    let mut inserts: Vec<(usize, String)> = Vec::new();
    for (n, branch) in found.iter().enumerate() {
        match branch.form {
            Form::Block => inserts.push((branch.at + 1, format!(" {COUNT}({n});"))),
            Form::MissingElse => inserts.push((branch.at + 1, format!(" else {{ {COUNT}({n}); }}"))),
            Form::Expression(end) => {
                inserts.push((branch.at, format!("{{ {COUNT}({n}); ")));
                inserts.push((end, " }".into()));
            }
        }
    }
    inserts.sort_by_key(|(at, _)| std::cmp::Reverse(*at));
    let mut text = text.to_owned();
    inserts.into_iter().for_each(|(at, call)| text.insert_str(at, &call));
    text
}

/// The branches of a script, in the order of its text.
fn branches(text: &str, ast: &AST) -> Vec<Found> {
    let places = Places::of(text);
    let mut found = Vec::new();
    for function in ast.iter_functions() {
        let body =
            ast.shared_lib().get_script_fn(function.name, function.params.len()).map(|f| f.body.start_position());
        found.extend(body.and_then(|at| places.block(at, "function")));
    }
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        if let Some(ASTNode::Stmt(statement)) = path.last() {
            of_statement(statement, &places, &mut found);
        }
        true
    });
    found.sort_by_key(|branch| branch.at);
    found.dedup_by_key(|branch| branch.at);
    found
}

fn of_statement(statement: &Stmt, places: &Places<'_>, found: &mut Vec<Found>) {
    match statement {
        Stmt::If(parts, ..) => {
            found.extend(places.block(parts.body.position(), "if"));
            if parts.branch.is_empty() && parts.branch.position().is_none() {
                found.extend(places.missing_else(parts.body.end_position()));
            } else {
                // Of `else if` the inner one is found by itself.
                found.extend(places.block(parts.branch.position(), "else"));
            }
        }
        Stmt::While(parts, ..) | Stmt::Do(parts, ..) => found.extend(places.block(parts.body.position(), "loop")),
        Stmt::For(parts, ..) => found.extend(places.block(parts.2.body.position(), "loop")),
        Stmt::Switch(parts, ..) => {
            for case in &parts.1.expressions {
                found.extend(places.expression(case.rhs.start_position()));
            }
        }
        _ => {}
    }
}

impl Places<'_> {
    fn block(&self, position: Position, what: &'static str) -> Option<Found> {
        let (at, line, column) = self.at(position)?;
        self.text[at..].starts_with('{').then_some(Found { at, line, column, what, form: Form::Block })
    }

    fn missing_else(&self, end: Position) -> Option<Found> {
        let (at, line, column) = self.at(end)?;
        let is_end = self.text[at..].starts_with('}');
        is_end.then_some(Found { at, line, column, what: "else", form: Form::MissingElse })
    }

    fn expression(&self, position: Position) -> Option<Found> {
        if let Some(block) = self.block(position, "case") {
            return Some(block);
        }
        let (at, line, column) = self.at(position)?;
        let end = at + until(&self.text[at..], &[',', '}', ')', ']']);
        Some(Found { at, line, column, what: "case", form: Form::Expression(end) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "fn f(x) {\n    if x > 1 { 1 } else if x < 0 { 2 } else { 3 }\n}\n\
                        fn g(x) {\n    if x == 1 { return 9; }\n    for i in 0..2 { x += i; }\n    \
                        switch x {\n        1 => f(1, \"},\"), // one, two }\n        2 => { 5 }\n        _ => [1, 2],\n    }\n}\n\
                        fn h() { let c = |y| { y + 1 }; c.call(1) }\n";

    #[test]
    fn every_branch_is_found_once_and_the_text_stays_a_script() {
        let mut engine = Engine::new_raw();
        let ast = engine.compile(TEXT).expect("a script");
        let coverage = Coverage::default();
        let source = Source { text: TEXT.into(), path: "f.rhai".into() };
        let counted = coverage.counted(&source, &ast, &mut engine);
        engine.compile(&counted).unwrap_or_else(|error| panic!("{error}\n{counted}"));
        assert_eq!(counted.lines().count(), TEXT.lines().count());
        let told: Vec<(u32, &str)> = coverage.of("f.rhai").iter().map(|b| (b.line, b.what)).collect();
        let wanted = [
            (1, "function"),
            (2, "if"),
            (2, "if"),
            (2, "else"),
            (4, "function"),
            (5, "if"),
            (5, "else"),
            (6, "loop"),
            (8, "case"),
            (9, "case"),
            (10, "case"),
            (13, "function"),
            (13, "function"),
        ];
        assert_eq!(told, wanted);
    }
}
