//! Tests of the rule language, in one program. `fuzz_rules` is another: it measures the memory of the whole process.

mod by_place;
mod city_scripts;
mod common;
mod constraints;
mod digests;
mod districts;
mod growing;
mod hostile;
mod landmarks;
mod params;
mod patterns;
mod policy;
mod tour;
