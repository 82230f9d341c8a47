//! Where a rule is asked: a site as one call sees it.

use crate::city::SiteHandle;
use crate::fault::Complaint;
use crate::host::{kind_of, numeric};
use crate::names::{hint, listed};
use crate::param::Places;
use crate::rule::Rule;
use crate::words::Ground;
use geom::{Bounds, Point, Raster, Vec2};
use rhai::{Dynamic, Map};
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::growth::{Field, Fields};
use streets::{Classes, Districts};

/// Side of the bare land that is asked about where no site is told, metres.
const SIDE: f64 = 1000.0;

/// A site whose maps are known.
pub(super) struct Place {
    size: Vec2,
    maps: BTreeMap<String, Arc<Raster>>,
    districts: Arc<Districts>,
}

impl Place {
    /// The site behind `on: …`; bare land where there is none.
    pub fn of(site: Option<Dynamic>) -> Result<Self, Complaint> {
        let Some(site) = site else {
            return Ok(Self { size: Vec2::splat(SIDE), maps: BTreeMap::new(), districts: Arc::default() });
        };
        let given = kind_of(&site);
        let wrong =
            || Complaint::new(format!("`on` must be a site, not {given}")).hint("on: standard(\"hill\")").key("on");
        let plan = site.try_cast::<SiteHandle>().ok_or_else(wrong)?.plan();
        if plan.folder.is_some() {
            let help = "draw the site: on: standard(\"hill\"), or site(#{ size: [600, 600], density: |x, y| … })";
            return Err(Complaint::new("one call cannot be asked on maps of a folder").hint(help).key("on"));
        }
        let districts = plan.drawn_districts.map(|drawn| Districts::of_cells(drawn.names, drawn.cells));
        Ok(Self {
            size: plan.size.unwrap_or(Vec2::splat(SIDE)),
            maps: plan.drawn,
            districts: Arc::new(districts.unwrap_or_default()),
        })
    }

    pub fn middle(&self) -> Vec2 {
        self.size / 2.0
    }

    fn map(&self, name: &str, at: Vec2) -> Option<f64> {
        self.maps.get(name).map(|map| map.bilinear(at))
    }

    pub fn density(&self, at: Vec2) -> f64 {
        self.map("density", at).unwrap_or(0.0)
    }

    pub fn max_height(&self, at: Vec2) -> f64 {
        self.maps.get("max_height").map_or(f64::INFINITY, |map| map.nearest(at))
    }

    pub fn district(&self, at: Vec2) -> String {
        self.districts.name_at(at).to_owned()
    }

    /// A rule with its values by place read here.
    pub fn settled(&self, rule: &Rule) -> Result<Rule, Complaint> {
        let maps = self.maps.iter().map(|(name, map)| (name.clone(), Field::Map(map.clone()))).collect();
        let places = Arc::new(Places { maps, districts: self.districts.clone() });
        let params = rule.params();
        params.check(&places).map_err(|error| Complaint::new(error.message).maybe_hint(error.hint))?;
        Ok(rule.with(params.on(&places)))
    }

    /// The site as growth knows it.
    pub fn fields(&self) -> Arc<Fields> {
        let field = |name: &str, other: f64| self.maps.get(name).cloned().map_or(Field::Constant(other), Field::Map);
        let bounds = Bounds::between(Point::new(0, 0), Point::from_metres(self.size));
        let land = self.maps.get("land").cloned();
        Arc::new(Fields {
            legal: land.clone().into_iter().collect(),
            barred: self.maps.get("parks").cloned().into_iter().collect(),
            land,
            density: field("density", 1.0),
            elevation: field("elevation", 0.0),
            maps: self.maps.iter().map(|(name, map)| (name.clone(), Field::Map(map.clone()))).collect(),
            districts: self.districts.clone(),
            ..Fields::plain(bounds)
        })
    }

    /// The land around a block or a parcel, with the distances of streets by class.
    pub fn ground(&self, distances: Map) -> Result<Arc<dyn Ground>, Complaint> {
        let classes = Classes::default();
        let names: Vec<&str> = classes.iter().map(|(_, info)| info.name.as_str()).collect();
        let distance = |(class, metres): (_, Dynamic)| {
            let class = String::from(class);
            if !names.contains(&class.as_str()) {
                let help = hint(&class, names.iter().copied()).unwrap_or_else(|| format!("one of {}", listed(&names)));
                return Err(Complaint::new(format!("there is no street class `{class}`")).hint(help).key("distances"));
            }
            Ok((class, numeric("a distance", &metres)?))
        };
        let distances = distances.into_iter().map(distance).collect::<Result<_, Complaint>>()?;
        Ok(Arc::new(AskedGround { maps: self.maps.clone(), distances }))
    }
}

/// The land around, as one question tells it.
#[derive(Debug)]
struct AskedGround {
    maps: BTreeMap<String, Arc<Raster>>,
    distances: BTreeMap<String, f64>,
}

impl Ground for AskedGround {
    fn map(&self, name: &str, at: Vec2) -> Option<f64> {
        self.maps.get(name).map(|map| map.bilinear(at))
    }

    fn zone(&self, name: &str, at: Vec2) -> Option<f64> {
        self.maps.get(name).map(|map| map.nearest(at))
    }

    fn maps(&self) -> Vec<String> {
        self.maps.keys().cloned().collect()
    }

    fn distance(&self, class: &str, _: Vec2) -> Option<f64> {
        let is_known = Classes::default().named(class).is_some();
        is_known.then(|| self.distances.get(class).copied().unwrap_or(f64::INFINITY))
    }

    fn classes(&self) -> Vec<String> {
        Classes::default().iter().map(|(_, info)| info.name.clone()).collect()
    }
}
