//! The viewer, as people use it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod bugs;
mod desk;
mod edits;
mod panels;
mod pictures;
mod widgets;
mod worker;
