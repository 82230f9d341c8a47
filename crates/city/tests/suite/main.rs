//! Tests of cities and of the command, in one program: one to link, and whose tests run side by side.

mod areas;
mod bad_input;
mod by_place;
mod common;
mod crossings;
mod each_map;
mod landmarks;
mod maps;
mod mistakes;
mod presets;
mod prints;
mod rule_tests;
mod seat;
mod stats;
mod traced;
mod watch;
mod why;
mod why_steps;
