//! `plat-view`: opens a city in a window, or draws a picture of it.

use clap::Parser;
use std::process::ExitCode;
use viewer::command::{Arguments, run};

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("plat-view: {failure}");
            ExitCode::from(failure.status)
        }
    }
}
