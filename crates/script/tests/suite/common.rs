//! What several tests share: libraries of texts, sites of names, tips.

#![allow(dead_code)]

use geom::{Angle, Bounds, Point, Raster, Seed, Vec2};
use script::{Evaluated, Fault, Host, Library, Rule, SiteInfo, SiteRequest, Sites, Source};
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::Classes;
use streets::growth::{Draft, Field, Fields, Tip};

/// A library of texts.
#[derive(Debug)]
pub struct Shelf(pub BTreeMap<String, String>);

/// A library of file names and texts.
pub fn shelf(files: &[(&str, &str)]) -> Arc<dyn Library> {
    Arc::new(Shelf(files.iter().map(|(name, text)| ((*name).into(), (*text).into())).collect()))
}

impl Library for Shelf {
    fn read(&self, name: &str) -> Option<Result<Source, String>> {
        assert!(!name.contains("..") && !name.starts_with('/'), "asked for `{name}`");
        self.0.get(name).map(|text| Ok(Source { text: text.clone(), path: name.to_owned() }))
    }

    fn place(&self) -> String {
        "the shelf".into()
    }

    fn names(&self) -> Vec<String> {
        self.0.keys().cloned().collect()
    }
}

/// Every folder holds the same maps, but `empty`, which is not there.
#[derive(Debug)]
pub struct Folders;

impl Sites for Folders {
    fn site(&self, request: &SiteRequest) -> Result<SiteInfo, String> {
        if request.folder == "empty" {
            return Err("there is no folder `empty`".into());
        }
        let maps = ["borough", "density", "districts", "elevation", "land", "parks"].map(str::to_owned).to_vec();
        Ok(SiteInfo { maps, size: Some(geom::Vec2::new(13_000.0, 22_000.0)) })
    }
}

pub fn source(text: &str) -> Source {
    Source { text: text.to_owned(), path: "mine.rhai".into() }
}

/// A rule of a text, among other files.
pub fn rule_among(text: &str, files: &[(&str, &str)]) -> Result<Rule, Fault> {
    Host::new(vec![shelf(files)]).rule_of("mine", &source(text))
}

pub fn rule(text: &str) -> Result<Rule, Fault> {
    rule_among(text, &[])
}

/// What a city script asks for.
pub fn city(text: &str) -> Result<Evaluated, Fault> {
    Host::new(vec![]).plan(&Source { text: text.to_owned(), path: "city.rhai".into() }, Arc::new(Folders))
}

/// A tip in the middle of flat land, heading so many degrees.
pub fn tip(heading: f64) -> Tip {
    let bounds = Bounds::between(Point::new(0, 0), Point::new(1 << 22, 1 << 22));
    let mut tip = Tip::new(Classes::MINOR, Seed(7), Arc::new(Fields::plain(bounds)));
    (tip.at, tip.heading) = (Point::new(1 << 20, 1 << 20), Angle::degrees(heading));
    (tip.is_seed, tip.age) = (false, 3);
    tip
}

/// A proposed street of so many metres to the east through (1000, 1000); its last map cell of 10 m is a park from x = 1100.
pub fn draft(length: f64) -> Draft {
    let parks = (0..200 * 200).map(|cell| if cell % 200 >= 110 { 1.0 } else { 0.0 }).collect();
    let parks = Raster::new(200, 200, 10.0, Vec2::ZERO, parks).expect("a raster");
    let bounds = Bounds::between(Point::new(0, 0), Point::from_metres(Vec2::splat(2000.0)));
    let maps = [("parks".to_owned(), Field::Map(Arc::new(parks)))].into();
    let density = Field::Constant(900.0);
    let from = Vec2::splat(1000.0);
    Draft {
        id: geom::Id::default(),
        from,
        to: from + Vec2::X * length,
        heading: Angle::ZERO,
        class: Classes::MINOR,
        level: 0,
        meets_street: false,
        seed: Seed(7),
        fields: Arc::new(Fields { maps, density, ..Fields::plain(bounds) }),
        refused: None,
    }
}

/// `file:line:column: message`.
pub fn headline(fault: &Fault) -> String {
    fault.to_string().lines().next().unwrap_or_default().to_owned()
}
