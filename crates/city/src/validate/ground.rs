//! A layout brought onto the lattice, by kind.

use super::ValidationReport;
use crate::export::LayoutFile;
use crate::export::layout_file::{Feature, Geometry, Properties};
use geom::{Bounds, Point, Polygon, Vec2};
use std::collections::{BTreeMap, BTreeSet};

/// A street between two crossings.
pub struct Street<'a> {
    /// Its id, or a word for its absence.
    pub id: &'a str,
    /// What it says of itself.
    pub says: &'a Properties,
    /// Its centre line without repeated points.
    pub line: Vec<Point>,
}

/// A feature with a ground polygon.
pub struct Area<'a> {
    /// Its id, or a word for its absence.
    pub id: &'a str,
    /// What it says of itself.
    pub says: &'a Properties,
    /// Its ground, turned counter-clockwise, without repeated points.
    pub polygon: Polygon,
    /// Its extent.
    pub bounds: Bounds,
    /// Whether the polygon is valid and has an area: only such take part in overlaps.
    pub sound: bool,
}

/// Everything in the file that has a place on the lattice.
#[derive(Default)]
pub struct Ground<'a> {
    /// Streets with a centre line of two or more points.
    pub streets: Vec<Street<'a>>,
    /// Crossings by id.
    pub crossings: BTreeMap<&'a str, Point>,
    /// Quarters.
    pub quarters: Vec<Area<'a>>,
    /// Blocks.
    pub blocks: Vec<Area<'a>>,
    /// Parcels.
    pub parcels: Vec<Area<'a>>,
    /// Buildings.
    pub buildings: Vec<Area<'a>>,
    /// Names and run ids of streets: what an access list may name.
    pub street_names: BTreeSet<&'a str>,
}

impl Street<'_> {
    /// Its level.
    pub fn level(&self) -> f64 {
        self.says.level
    }

    /// The crossings that it names as its ends.
    pub fn ends(&self) -> [Option<&str>; 2] {
        [self.says.from.as_deref(), self.says.to.as_deref()]
    }

    /// Its straight pieces.
    pub fn pieces(&self) -> impl Iterator<Item = (Point, Point)> {
        self.line.windows(2).map(|pair| (pair[0], pair[1]))
    }
}

/// What reading a decimal may put a position off the lattice: a few units in the last place of the largest coordinate.
const READING_ERROR_M: f64 = 1e-9;

/// Positions on their way to the lattice.
#[derive(Default)]
struct Rounding {
    moved: usize,
    outside: bool,
}

impl Rounding {
    fn point(&mut self, [x, y]: [f64; 2]) -> Point {
        let at = Vec2::new(x, y);
        match Point::try_from_metres(at) {
            Some(point) => {
                self.moved += usize::from((point.metres() - at).abs().max_element() > READING_ERROR_M);
                point
            }
            None => {
                self.outside = true;
                Point::default()
            }
        }
    }

    /// The chain without points equal to the one before.
    fn chain(&mut self, positions: &[[f64; 2]]) -> Vec<Point> {
        let mut chain: Vec<Point> = positions.iter().map(|&at| self.point(at)).collect();
        chain.dedup();
        chain
    }

    /// The same for a ring, whose last point repeats the first in the file.
    fn ring(&mut self, positions: &[[f64; 2]]) -> Vec<Point> {
        let mut ring = self.chain(positions);
        while ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        ring
    }
}

impl<'a> Ground<'a> {
    /// Sorts the features of a file by kind and rounds them to the lattice; features whose geometry is not what their
    /// kind asks for are reported and left out.
    pub fn of(file: &'a LayoutFile, report: &mut ValidationReport) -> Self {
        let mut ground = Self::default();
        let mut rounding = Rounding::default();
        for feature in &file.features {
            rounding.outside = false;
            ground.take(feature, &mut rounding, report);
        }
        if rounding.moved > 0 {
            report.notes.push(format!("{} positions lie off the lattice of 1/1024 m and were rounded", rounding.moved));
        }
        report.street_km =
            ground.streets.iter().flat_map(Street::pieces).map(|(a, b)| a.distance(b)).sum::<f64>() / 1e3;
        ground
    }

    fn take(&mut self, feature: &'a Feature, rounding: &mut Rounding, report: &mut ValidationReport) {
        let says = &feature.properties;
        let id = says.id.as_deref().unwrap_or("without id");
        let (kind, rule) = match says.kind.as_deref() {
            Some(kind @ ("street" | "crossing")) => (kind, "V1"),
            Some(kind @ ("quarter" | "block")) => (kind, "V4"),
            Some(kind @ "parcel") => (kind, "V5"),
            Some(kind @ "building") => (kind, "V22"),
            _ => return,
        };
        match (kind, &feature.geometry) {
            ("street", Geometry::LineString(line)) => self.take_street(id, says, rounding.chain(line), report),
            ("crossing", Geometry::Point(at)) => {
                self.crossings.insert(id, rounding.point(*at));
            }
            ("street" | "crossing", other) | (_, other @ (Geometry::Nothing | Geometry::Other(_))) => {
                report.add(rule, &[(kind, id)], None, format!("{kind} {id} is {}", other.name()));
            }
            (_, Geometry::Polygon(rings)) => self.take_area(kind, id, says, rings, rounding),
            (_, other) => report.add(rule, &[(kind, id)], None, format!("{kind} {id} is {}", other.name())),
        }
        if rounding.outside {
            report.add(rule, &[(kind, id)], None, format!("{kind} {id} lies outside the lattice (±524 km)"));
        }
    }

    fn take_street(&mut self, id: &'a str, says: &'a Properties, line: Vec<Point>, report: &mut ValidationReport) {
        if line.len() < 2 {
            report.add("V1", &[("street", id)], line.first().copied(), format!("street {id} has no length"));
            return;
        }
        self.street_names.extend(says.street.as_deref().into_iter().chain([id]));
        self.streets.push(Street { id, says, line });
    }

    fn take_area(
        &mut self,
        kind: &str,
        id: &'a str,
        says: &'a Properties,
        rings: &[Vec<[f64; 2]>],
        rounding: &mut Rounding,
    ) {
        let mut rings = rings.iter().map(|ring| rounding.ring(ring));
        let outer = rings.next().unwrap_or_default();
        let polygon = Polygon::new(outer, rings.collect());
        let bounds = polygon.bounds().unwrap_or(Bounds::between(Point::default(), Point::default()));
        let sound = !rounding.outside && polygon.is_valid() && polygon.area() > super::SLIVER_M;
        let area = Area { id, says, polygon, bounds, sound };
        match kind {
            "quarter" => self.quarters.push(area),
            "block" => self.blocks.push(area),
            "parcel" => self.parcels.push(area),
            _ => self.buildings.push(area),
        }
    }
}
