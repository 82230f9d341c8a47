//! Growth with ten-line rules: the literal rewriter as oracle, patterns, constraints, quarters, merges.

mod adjusting;
mod derivation;
mod given;
mod quarters;
mod rewriter;
mod support;
