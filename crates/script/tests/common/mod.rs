//! What several tests share: libraries of texts, sites of names, tips.

#![allow(dead_code)]

use geom::{Angle, Bounds, Point, Seed};
use script::{Evaluated, Fault, Host, Library, Rule, SiteInfo, SiteRequest, Sites, Source};
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::Classes;
use streets::growth::{Fields, Tip};

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

/// `file:line:column: message`.
pub fn headline(fault: &Fault) -> String {
    fault.to_string().lines().next().unwrap_or_default().to_owned()
}
