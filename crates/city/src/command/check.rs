//! `plat check`: what can be found wrong in rules and city scripts without building.

use super::{CheckArguments, Failure, Status, faults};
use city::{FaultReport, check};

/// Checks files and folders, and tells all that is wrong.
pub fn run(arguments: &CheckArguments) -> Result<Status, Failure> {
    let (mut files, mut found) = (0, Vec::new());
    for path in &arguments.paths {
        let checked = check(path, arguments.rules.as_deref()).map_err(super::build::unreadable)?;
        let reports: Vec<FaultReport> = checked.faults.iter().map(FaultReport::from).collect();
        faults::tell(&reports, &checked.texts);
        files += checked.files;
        found.extend(reports);
    }
    if arguments.json {
        println!("{}", serde_json::json!({ "files": files, "faults": found }));
    } else {
        println!("{}, {}", faults::counted(files, "file"), faults::summary(&found));
    }
    Ok(faults::status(&found))
}
