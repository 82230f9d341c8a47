//! `plat validate`.

use super::{Status, ValidateArguments};
use city::validate::validate;

/// Checks a layout and prints what is wrong with it.
pub fn run(arguments: &ValidateArguments) -> Status {
    match validate(&arguments.layout, arguments.until) {
        Err(error) => {
            eprintln!("plat: {error}");
            Status::Failed
        }
        Ok(report) => {
            if arguments.json {
                println!("{}", report.to_json());
            } else {
                println!("{report}");
            }
            if report.is_valid() { Status::Done } else { Status::Faults }
        }
    }
}
