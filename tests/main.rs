//! Tests over the whole, in one program: one to link, and whose tests run side by side.

mod arrows;
mod bars;
#[path = "fuzz/graph.rs"]
mod fuzz_graph;
mod kept;
mod kernel_words;
mod land;
mod params;
mod places;
mod promises;
mod rules;
