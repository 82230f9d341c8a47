//! What questions are answered from, made once for a city: its layout as a file would be, and the city grown again with a trace.

use crate::worker::Ready;
use city::export::geojson::write_layout;
use city::export::layout_file::{LayoutFile, parse_layout};
use city::{Built, Cancel, Settings, Silent, Trace, build};
use std::path::Path;
use std::sync::OnceLock;

/// What is known of a city beyond what is shown. To be asked on threads that may wait.
#[derive(Debug, Default)]
pub struct Evidence {
    layout: OnceLock<Result<LayoutFile, String>>,
    traced: OnceLock<Result<Built, String>>,
}

impl Evidence {
    /// The layout of the city.
    ///
    /// # Errors
    /// When it cannot be read back.
    pub fn layout(&self, ready: &Ready) -> Result<&LayoutFile, String> {
        let made = self.layout.get_or_init(|| {
            let mut bytes = Vec::new();
            write_layout(&ready.built.city, &mut bytes).map_err(|error| error.to_string())?;
            parse_layout(&bytes, Path::new("layout.geojson")).map_err(|error| error.to_string())
        });
        made.as_ref().map_err(String::clone)
    }

    /// The city grown again, with what growth did.
    ///
    /// # Errors
    /// When it does not build.
    pub fn traced(&self, ready: &Ready) -> Result<&Built, String> {
        let made = self.traced.get_or_init(|| {
            let settings = Settings { traces: true, ..Settings::default() };
            build(&ready.sources, settings, &Silent, &Cancel::default()).map_err(|error| error.to_string())
        });
        made.as_ref().map_err(String::clone)
    }

    /// What growth did.
    ///
    /// # Errors
    /// When the city does not build.
    pub fn trace(&self, ready: &Ready) -> Result<&Trace, String> {
        self.traced(ready)?.trace.as_ref().ok_or_else(|| "nothing grew".to_owned())
    }
}
