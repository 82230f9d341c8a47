//! `plat validate`.

use super::{Failure, Status, ValidateArguments};
use city::validate::validate;

/// Checks a layout and prints what is wrong with it.
pub fn run(arguments: &ValidateArguments) -> Result<Status, Failure> {
    let report = validate(&arguments.layout, arguments.until)
        .map_err(|error| Failure::new(Status::Failed, error.to_string()))?;
    if arguments.json {
        println!("{}", report.to_json());
    } else {
        println!("{report}");
    }
    Ok(if report.is_valid() { Status::Done } else { Status::Faults })
}
