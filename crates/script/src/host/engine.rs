//! The one place where a Rhai engine is made.

use super::check::captured;
use super::maths;
use super::resolver::Resolver;
use super::spending;
use super::texts;
use crate::fault::{Complaint, Refusal, open_comment};
use rhai::packages::{
    ArithmeticPackage, BasicArrayPackage, BasicFnPackage, BasicIteratorPackage, BasicMapPackage, BasicStringPackage,
    LogicPackage, MoreStringPackage, Package,
};
use rhai::{AST, Engine, LexError, Position, Scope, Token};

/// How much a script may do in one go.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    /// Operations per evaluation of a file or call of a function.
    pub operations: u64,
    /// Elements of a list, all nested ones counted.
    pub elements: usize,
    /// Entries of a map, all nested ones counted.
    pub entries: usize,
    /// Characters of a text.
    pub characters: usize,
}

impl Limits {
    /// For a rule: it is called a million times.
    pub const RULE: Self = Self { operations: 100_000, elements: 1_000, entries: 200, characters: 10_000 };
    /// For a rule that tells what it does: with the calls that tell, a loop around nothing takes five times the operations.
    pub const TELLING: Self = Self { operations: 6 * Self::RULE.operations, ..Self::RULE };
    /// For a city script: it runs once, and may list streets point by point.
    pub const CITY: Self = Self { operations: 1_000_000, elements: 20_000, entries: 2_000, characters: 100_000 };
    /// For a test: it looks through all streets and parcels of a town.
    pub const TEST: Self =
        Self { operations: 20_000_000, elements: 1_000_000, entries: 1_000_000, characters: 1_000_000 };
    /// For a console: it lists all parcels of a city.
    pub const CONSOLE: Self =
        Self { operations: 50_000_000, elements: 20_000_000, entries: 20_000_000, characters: 200_000_000 };
}

/// Calls inside calls.
const CALL_LEVELS: usize = 40;
/// Brackets inside brackets.
const EXPRESSION_DEPTH: usize = 48;

/// An engine with the whole policy of the rule language and none of its words:
///
/// - **No file, clock, chance or thread.** A raw engine with chosen packages: arithmetic, logic, lists, maps, texts,
///   ranges, function pointers. Left out are `eval`, `timestamp`, `sleep`, `exit`, `rand`, reflection, blobs.
/// - **The same digits everywhere.** `sin`, `exp`, `pow` … come from `libm` ([`maths`]); the operator `**`, which Rhai
///   computes with the platform's library, is switched off (overriding it would cost a third of all speed).
/// - **Limits decide faults**, the same on every computer: operations, call levels, expression depth, sizes of texts,
///   lists and maps, variables, functions, imports.
/// - **Strict.** Unknown variables are errors when a file is read; so are unknown keys of maps when asked for. A variable
///   may be declared again (shadowed), as in Rust.
/// - **Closures see their arguments only**, as functions do ([`compile`]), in rules; elsewhere more where they are not kept.
///   There is no `curry`, which would let them.
/// - **Imports** go through [`Resolver`]: inside the libraries only, cycles refused, each file read once.
/// - `print` and `debug` say nothing until the owner of the engine listens.
pub(crate) fn engine(limits: Limits, resolver: Resolver) -> Engine {
    let mut engine = Engine::new_raw();
    packages(&mut engine);
    maths::register(&mut engine);
    texts::register(&mut engine, limits.characters);
    spending::limit(&mut engine, limits.operations);
    for symbol in ["eval", "curry", "**", "**="] {
        engine.disable_symbol(symbol);
    }
    engine
        .set_strict_variables(true)
        .set_fail_on_invalid_map_property(true)
        .set_max_array_size(limits.elements)
        .set_max_map_size(limits.entries)
        .set_max_string_size(limits.characters)
        .set_max_call_levels(CALL_LEVELS)
        .set_max_expr_depths(EXPRESSION_DEPTH, EXPRESSION_DEPTH)
        .set_max_variables(500)
        .set_max_functions(500)
        .set_max_modules(50)
        .set_module_resolver(resolver);
    engine
}

/// Lines of a script, and letters of a line: Rhai counts both with 16 bits, and takes what stands behind for nowhere.
const LONGEST: usize = 60_000;

/// What closures of a script see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Closures {
    /// Their arguments alone: in rules.
    Closed,
    /// Variables around them too, where they are handed at once to a word that does not keep them: in city scripts and
    /// tests.
    InPlace,
    /// Whatever they take: the caller asks [`refuse_captures`].
    Any,
}

/// Reads a script, and refuses what the engine itself would let pass.
pub(crate) fn compile(engine: &Engine, text: &str, closures: Closures) -> Result<AST, Refusal> {
    compile_within(engine, &Scope::new(), text, closures)
}

/// The same of a script that knows the variables of a scope.
pub(crate) fn compile_within(engine: &Engine, scope: &Scope, text: &str, closures: Closures) -> Result<AST, Refusal> {
    measure(text)?;
    let ast = engine.compile_with_scope(scope, text)?;
    refuse_open_comment(engine, text)?;
    refuse_captures(&ast, closures)?;
    Ok(ast)
}

/// Refuses closures that see more than they may.
pub(crate) fn refuse_captures(ast: &AST, closures: Closures) -> Result<(), Refusal> {
    let found = if closures == Closures::Any { None } else { captured(ast, closures) };
    let Some((name, at)) = found else { return Ok(()) };
    let help = match closures {
        Closures::Closed => {
            "it sees its own arguments and, as `global::NAME`, the constants of its file: use a loop instead"
        }
        Closures::InPlace | Closures::Any => {
            "only a closure that is handed on at once does: site(#{ … }), list.filter(|x| …) and its kin"
        }
    };
    let mut refusal: Refusal =
        Complaint::new(format!("a closure does not see the variable `{name}`")).hint(help).into();
    refusal.set_position(at);
    Err(refusal)
}

/// Refuses a comment without an end: what stands behind it would be gone without a word.
fn refuse_open_comment(engine: &Engine, text: &str) -> Result<(), Refusal> {
    let Some((line, column)) = open_comment(text).filter(|_| ends_in_comment(engine, text)) else { return Ok(()) };
    let mut refusal: Refusal = Complaint::new("this comment has no end").hint("close it with `*/`").into();
    refusal.set_position(Position::new(line as u16, column as u16));
    Err(refusal)
}

/// Whether what stood behind a text would be a comment: a text that opens there is then no token.
fn ends_in_comment(engine: &Engine, text: &str) -> bool {
    let probe = format!("{text}\n\"");
    let inputs = [probe.as_str()];
    let (tokens, _) = engine.lex(&inputs);
    let is_open_text = |token| matches!(token, Token::LexError(error) if *error == LexError::UnterminatedString);
    // At its end it goes on to tell that this is the end.
    let mut tokens = tokens.take_while(|(token, _)| *token != Token::EOF);
    !tokens.any(|(token, _)| is_open_text(token))
}

/// Refuses a script whose places cannot be told: one that is too long or too wide, or has a carriage return within a line.
/// That ends a comment and a line to Rhai, but not to whoever reads the script.
fn measure(text: &str) -> Result<(), Refusal> {
    let told = |message: String, help: &str, line: usize, column: usize| {
        let mut refusal: Refusal = Complaint::new(message).hint(help).into();
        refusal.set_position(Position::new(line as u16, column as u16));
        refusal
    };
    for (number, line) in text.split('\n').enumerate() {
        if number >= LONGEST {
            let message = format!("the lines of a script are at most {LONGEST}");
            return Err(told(message, "share it out between files that import each other", LONGEST, 1));
        }
        // Letters have at least one byte.
        if line.len() > LONGEST && line.chars().count() > LONGEST {
            let message = format!("the letters of a line are at most {LONGEST}");
            return Err(told(message, "break it into several", number + 1, 1));
        }
        if let Some(at) = line.strip_suffix('\r').unwrap_or(line).find('\r') {
            let (message, help) = ("a carriage return stands within this line", "save the script with other line ends");
            return Err(told(message.to_owned(), help, number + 1, line[..at].chars().count() + 1));
        }
    }
    Ok(())
}

fn packages(engine: &mut Engine) {
    ArithmeticPackage::new().register_into_engine(engine);
    LogicPackage::new().register_into_engine(engine);
    BasicArrayPackage::new().register_into_engine(engine);
    BasicMapPackage::new().register_into_engine(engine);
    BasicStringPackage::new().register_into_engine(engine);
    MoreStringPackage::new().register_into_engine(engine);
    BasicIteratorPackage::new().register_into_engine(engine);
    BasicFnPackage::new().register_into_engine(engine);
}
