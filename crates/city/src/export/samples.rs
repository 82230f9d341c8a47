//! Cities made by hand, for tests: a warped grid with majors, a highway, and a river with bridges.

use crate::{Area, City, Site};
use buildings::Building;
use geom::point::units;
use geom::{Bounds, Id, Point, Polygon, Raster, Vec2};
use layout::{Block, Parcel, Use};
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::graph::{Crowding, NewSegment};
use streets::runs::Run;
use streets::{Claim, Classes, NodeId, NodeKey, SegmentId, StreetGraph, StreetId};

/// Five streets each way, no maps but a river.
pub fn small_city() -> City {
    city(5, false)
}

/// Nine streets each way on hills.
pub fn hilly_city() -> City {
    city(9, true)
}

/// `n` streets each way.
pub fn city(n: usize, hills: bool) -> City {
    let mut maker = Maker::new(n, hills);
    maker.streets();
    maker.blocks();
    maker.city
}

struct Maker {
    n: usize,
    city: City,
    keys: BTreeMap<(usize, usize), NodeKey>,
}

/// The column after which the river flows.
fn river(n: usize) -> usize {
    n / 2
}

impl Maker {
    fn new(n: usize, hills: bool) -> Self {
        let site = site(n, hills);
        let graph = StreetGraph::new(Classes::default());
        let city = City {
            credits: Vec::new(),
            name: "Sampleton".into(),
            seed: 1625,
            site: Arc::new(site),
            graph: graph.into(),
            origins: vec!["streets/grid".into(), "buildings/extruded".into()],
            street_names: BTreeMap::new(),
            runs: Vec::new(),
            quarters: Vec::new(),
            districts: Vec::new(),
            landmarks: Vec::new(),
            blocks: Arc::default(),
            parcels: Arc::default(),
            buildings: Arc::default(),
            digests: crate::Digests::default(),
        };
        Self { n, city, keys: BTreeMap::new() }
    }

    fn streets(&mut self) {
        for i in 0..self.n {
            for j in 0..self.n {
                if i + 1 < self.n && (i != river(self.n) || j % 2 == 0) {
                    self.segment((i, j), (i + 1, j), j, i == river(self.n));
                }
                if j + 1 < self.n {
                    self.segment((i, j), (i, j + 1), 100_000 + i, false);
                }
            }
        }
        self.city.runs.sort_by_key(|run| run.id);
        self.city.street_names.insert(street(0), "First \"Street\"".into());
    }

    fn segment(&mut self, a: (usize, usize), b: (usize, usize), name: usize, is_bridge: bool) {
        let rank = name % 100_000;
        let (class, half_width) = match rank {
            2 => (Classes::HIGHWAY, units(14.0)),
            _ if rank.is_multiple_of(4) => (Classes::MAJOR, units(10.0)),
            _ => (Classes::MINOR, units(7.0)),
        };
        let (from_id, to_id) = (node(a), node(b));
        let claim = Claim { street: street(name), class, half_width, origin: 0, forward: true };
        let level = i8::from(is_bridge);
        let new = NewSegment { from: at(self.n, a), to: at(self.n, b), from_id, to_id, claim, level };
        let path =
            Arc::make_mut(&mut self.city.graph).insert(&new, Crowding::Refuse).expect("the sample is planar").path;
        self.keys.insert(a, path[0]);
        self.keys.insert(b, path[path.len() - 1]);
        let id = SegmentId::between(street(name), from_id, to_id, level).0;
        let nodes = path.to_vec();
        self.city.runs.push(Run { id, street: street(name), class, half_width, level, origin: 0, nodes });
    }

    fn blocks(&mut self) {
        let n = self.n;
        for i in (0..n - 1).filter(|&i| i != river(n)) {
            for j in 0..n - 1 {
                self.block(i, j);
            }
        }
        let quarter = |b: &Block| Area { id: b.id.child(7), name: None, polygon: b.polygon.clone() };
        Arc::make_mut(&mut self.city.blocks).sort_by_key(|block| block.id);
        Arc::make_mut(&mut self.city.parcels).sort_by_key(|parcel| parcel.id);
        Arc::make_mut(&mut self.city.buildings).sort_by_key(|building| building.id);
        self.city.quarters = self.city.blocks.iter().take(1).map(quarter).collect();
        let all = Polygon::rectangle(self.city.site.bounds);
        self.city.districts = vec![Area { id: Id::of_text("district", "all"), name: Some("All".into()), polygon: all }];
    }

    fn block(&mut self, i: usize, j: usize) {
        let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|cell| at(self.n, cell));
        let id = Id::root("block", &[i as u128, j as u128]);
        let streets = [street(j), street(100_000 + i + 1), street(j + 1), street(100_000 + i)];
        let usage = if (i + j).is_multiple_of(5) { Use::Park } else { Use::Built };
        let mut sorted = streets.to_vec();
        sorted.sort_unstable();
        let polygon = Polygon::new(corners.to_vec(), Vec::new());
        Arc::make_mut(&mut self.city.blocks).push(Block {
            id,
            quarter: None,
            polygon,
            streets: sorted,
            bodies: Vec::new(),
        });
        // A corner `inset` from the sides keeps clear of the widest street.
        let inner = |u: f64, v: f64| {
            let [a, b, c, d] = corners.map(Point::metres);
            let (u, v) = (0.2 + 0.6 * u, 0.25 + 0.5 * v);
            Point::from_metres(a.lerp(b, u).lerp(d.lerp(c, u), v))
        };
        for p in 0..3u32 {
            for q in 0..2u32 {
                let (u, v) = (f64::from(p) / 3.0, f64::from(q) / 2.0);
                let ring = vec![inner(u, v), inner(u + 1.0 / 3.0, v), inner(u + 1.0 / 3.0, v + 0.5), inner(u, v + 0.5)];
                let access = vec![(streets[if q == 0 { 0 } else { 2 }], 20.0)];
                self.parcel(id, id.child(u64::from(p * 2 + q)), ring, access, usage);
            }
        }
    }

    fn parcel(&mut self, block: Id, id: Id, ring: Vec<Point>, access: Vec<(StreetId, f64)>, usage: Use) {
        let polygon = Polygon::new(ring, Vec::new());
        if usage == Use::Built {
            let centre = polygon.centroid();
            let shrunk = polygon.outer.iter().map(|p| Point::from_metres(p.metres().lerp(centre, 0.25)));
            let footprint = Polygon::new(shrunk.collect(), Vec::new());
            let heights = footprint.outer.iter().map(|p| self.city.site.elevation(p.metres()));
            let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(z), high.max(z)));
            let height = 6.0 + (id.0 % 97) as f64 * if id.0.is_multiple_of(7) { 2.0 } else { 0.3 };
            let building = id.child(99);
            let building = Building { id: building, parcel: id, footprint, height, ground: (low, high), origin: 1 };
            Arc::make_mut(&mut self.city.buildings).push(building);
        }
        Arc::make_mut(&mut self.city.parcels).push(Parcel {
            id,
            block,
            sides: vec![None; polygon.outer.len()],
            polygon,
            access,
            usage,
            tags: Vec::new(),
        });
    }
}

fn street(name: usize) -> StreetId {
    StreetId(Id::root("sample street", &[name as u128]))
}

fn node((i, j): (usize, usize)) -> NodeId {
    NodeId(Id::root("sample node", &[i as u128, j as u128]))
}

/// Where the crossing of two streets lies: a grid, warped a little, with a gap for the river.
fn at(n: usize, (i, j): (usize, usize)) -> Point {
    let gap = if i > river(n) { 120.0 } else { 0.0 };
    let (x, y) = (i as f64 * 130.0 + gap, j as f64 * 95.0);
    let warp = Vec2::new(libm::sin(y / 210.0) * 14.0, libm::sin(x / 260.0) * 18.0);
    Point::from_metres(Vec2::new(60.0 + x, 60.0 + y) + warp)
}

/// A site around the grid.
fn site(n: usize, hills: bool) -> Site {
    let size = Vec2::new((n - 1) as f64 * 130.0 + 240.0, (n - 1) as f64 * 95.0 + 120.0);
    let pixel = 10.0;
    let (columns, rows) = ((size.x / pixel).ceil() as usize, (size.y / pixel).ceil() as usize);
    let raster = |value: &dyn Fn(Vec2) -> f64| {
        let cells = (0..rows).rev().flat_map(|row| (0..columns).map(move |column| (column, row)));
        let centre = |(column, row): (usize, usize)| Vec2::new(column as f64 + 0.5, row as f64 + 0.5) * pixel;
        let values = cells.map(|cell| value(centre(cell)) as f32).collect();
        Arc::new(Raster::new(columns, rows, pixel, Vec2::ZERO, values).expect("a sound raster"))
    };
    let middle = 60.0 + river(n) as f64 * 130.0 + 125.0;
    let is_water = |at: Vec2| (at.x - middle - libm::sin(at.y / 210.0) * 14.0).abs() < 55.0;
    let mut maps = BTreeMap::new();
    maps.insert("land".to_owned(), raster(&|at| f64::from(u8::from(!is_water(at)))));
    maps.insert("parks".to_owned(), raster(&|at| f64::from(u8::from(at.distance(Vec2::new(size.x, 0.0)) < 90.0))));
    if hills {
        let height = |at: Vec2| 25.0 * libm::sin(at.x / 190.0) * libm::cos(at.y / 150.0) + 30.0;
        maps.insert("elevation".to_owned(), raster(&|at| if is_water(at) { 3.0 } else { height(at) }));
    }
    let bounds = Bounds::between(Point::default(), Point::from_metres(size));
    Site {
        bounds,
        crs: Some("EPSG:32618".into()),
        origin: Some(Vec2::new(579_660.0, 4_503_410.0)),
        maps,
        districts: Default::default(),
    }
}
