//! The `plat` command.

mod command;

use std::panic;
use std::process::{self, ExitCode};

fn main() -> ExitCode {
    end_with_the_reader();
    command::run()
}

/// Ends quietly where nobody reads on, as behind `| head`: to print to a closed pipe is no failure of the program.
fn end_with_the_reader() {
    let usual = panic::take_hook();
    panic::set_hook(Box::new(move |info| {
        let message = info.payload_as_str().unwrap_or_default();
        if message.starts_with("failed printing to std") {
            process::exit(0);
        }
        usual(info);
    }));
}
