//! What questions are answered from, made once for a city: its layout as a file would be, the city grown again with a trace,
//! and what can be measured of it.

use crate::scene::Element;
use crate::worker::Ready;
use city::export::geojson::write_layout;
use city::export::layout_file::{LayoutFile, parse_layout};
use city::measure::{Figures, Maps, MeasureError, Ranges, Verdict, measure};
use city::why::{Answer, explain, find};
use city::{Built, Cancel, Settings, Silent, Trace, build};
use script::testing::Town;
use std::path::Path;
use std::sync::{Arc, OnceLock};

/// What is known of a city beyond what is shown. To be asked on threads that may wait.
#[derive(Debug, Default)]
pub struct Evidence {
    layout: OnceLock<Result<LayoutFile, String>>,
    traced: OnceLock<Result<Built, String>>,
    town: OnceLock<Arc<dyn Town>>,
}

/// The figures of a city, and where they should lie.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// The figures.
    pub figures: Figures,
    /// Those of the real place beside them, where the city has a file of its ranges.
    pub verdict: Option<Verdict>,
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

    /// The city as scripts ask it.
    pub fn town(&self, ready: &Ready) -> Arc<dyn Town> {
        self.town.get_or_init(|| city::testing::town(&ready.built)).clone()
    }

    /// Why something is there.
    ///
    /// # Errors
    /// When it is not in the layout, or the city does not build.
    pub fn why(&self, ready: &Ready, element: &Element) -> Result<Answer, String> {
        let (layout, traced) = (self.layout(ready)?, self.traced(ready)?);
        let found = find(layout, &element.id.to_string()).map_err(|error| error.to_string())?;
        Ok(explain(&found, layout, &ready.sources, traced))
    }

    /// The figures of the city, held against `ranges.json` where its folder has that ([`Ranges::of_folder`]).
    ///
    /// # Errors
    /// When something cannot be measured, or the file cannot be read.
    pub fn statistics(&self, ready: &Ready) -> Result<Statistics, String> {
        let layout = self.layout(ready)?;
        let folder = &ready.as_written.folder;
        let told = |error: MeasureError| error.to_string();
        let maps = match &ready.sources.plan.site.folder {
            Some(maps) => Maps::read(&folder.join(maps), None).map_err(told)?,
            None => Maps::of_site(&ready.built.city.site),
        };
        let figures = measure(layout, &maps, None).map_err(told)?;
        let ranges = Ranges::of_folder(folder).map_err(told)?;
        let verdict = ranges.map(|ranges| ranges.judge(layout, &maps, &figures)).transpose().map_err(told)?;
        Ok(Statistics { figures, verdict })
    }
}
