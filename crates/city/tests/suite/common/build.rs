//! Cities in a folder, built in the process.

use city::{Built, Cancel, LoadError, Settings, Silent, Until, build, load};
use std::path::Path;

/// Builds the city of a folder.
pub fn try_build(folder: &Path, until: Until) -> Result<Built, LoadError> {
    let settings = Settings { until, ..Settings::default() };
    Ok(build(&load(folder, None)?.read()?, settings, &Silent, &Cancel::default()).expect("a city"))
}

/// What was built, without a fault of any rule.
pub fn faultless(built: Result<Built, LoadError>) -> Built {
    let built = built.unwrap_or_else(|error| panic!("{error}"));
    assert!(!built.report.has_faults(), "{:?}", built.report.faults);
    built
}
