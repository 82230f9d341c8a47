//! Growth with ten-line rules: the literal rewriter as oracle, patterns, constraints, quarters, merges.

mod adjusting;
mod chains;
mod derivation;
mod given;
mod kept;
mod pruning;
mod quarters;
mod rewriter;
mod rims;
mod shore;
mod smoothing;
pub(in crate::growth) mod support;
