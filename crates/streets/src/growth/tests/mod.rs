//! Growth with ten-line rules: the literal rewriter as oracle, patterns, constraints, quarters, merges.

mod adjusting;
mod derivation;
mod given;
mod pruning;
mod quarters;
mod rewriter;
mod smoothing;
pub(in crate::growth) mod support;
