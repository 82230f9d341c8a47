//! What can be found wrong in a script before it runs.

use super::Vocabulary;
use crate::fault::Fault;
use crate::names::nearest;
use rhai::{AST, ASTNode, Expr, FnCallExpr, Position, Stmt};

/// Calls of functions that do not exist, by position. Rhai itself finds them only when they are reached.
pub(crate) fn unknown_words(ast: &AST, file: &str, words: &Vocabulary) -> Vec<Fault> {
    let mut faults = Vec::new();
    ast.walk(&mut |path: &[ASTNode<'_>]| {
        if let Some((call, at)) = path.last().and_then(call_of)
            && is_unknown(call, words)
        {
            faults.push(fault(call, at, file, words));
        }
        true
    });
    faults.sort_by_key(|fault| (fault.line, fault.column));
    faults.dedup();
    faults
}

fn call_of<'a>(node: &ASTNode<'a>) -> Option<(&'a FnCallExpr, Position)> {
    match node {
        ASTNode::Expr(Expr::FnCall(call, at) | Expr::MethodCall(call, at)) | ASTNode::Stmt(Stmt::FnCall(call, at)) => {
            Some((call, *at))
        }
        _ => None,
    }
}

fn is_unknown(call: &FnCallExpr, words: &Vocabulary) -> bool {
    let plain = call.namespace.is_empty() && call.op_token.is_none();
    plain && call.name.starts_with(|c: char| c.is_alphabetic() || c == '_') && !words.has_function(&call.name)
}

fn fault(call: &FnCallExpr, at: Position, file: &str, words: &Vocabulary) -> Fault {
    let near = nearest(&call.name, words.functions()).map(|name| format!("did you mean `{name}`?"));
    Fault {
        line: at.line().unwrap_or(0) as u32,
        column: at.position().unwrap_or(0) as u32,
        hint: near,
        ..Fault::new(file, format!("there is no function `{}`", call.name))
    }
}
