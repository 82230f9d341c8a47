//! A city as a map: areas and lines in layers, tile by tile.

use super::are_same;
use crate::render::{Chunk, ChunkRef, Drawing, Flat, Gpu, Ground, Kind, linear};
use crate::sight::Sight;
use city::export::glb::TileKey;
use city::export::map::style;
use city::export::map::{Colour, Colouring};
use city::{City, Digests};
use geom::predicates::orient;
use geom::triangulate::triangulate;
use geom::{Digest, Id, Point, Polygon, Vec2};
use layout::Use;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Arc;
use streets::Class;
use streets::runs::Run;

pub use city::export::map::ColourBy as By;

/// What streets are coloured by; as on a street map when none.
pub type ColourBy = Option<By>;

/// The layers of a map, from below.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub enum LayerKind {
    /// Blocks.
    Blocks,
    /// Parks, plazas and open land.
    Green,
    /// Borders of parcels.
    Parcels,
    /// Buildings.
    Buildings,
    /// Streets, with bridges.
    Streets,
    /// Rims of quarters.
    Quarters,
    /// Rims of districts.
    Districts,
    /// Grounds of landmarks.
    Landmarks,
}

impl LayerKind {
    /// All, from below.
    pub const ALL: [Self; 8] = [
        Self::Blocks,
        Self::Green,
        Self::Parcels,
        Self::Buildings,
        Self::Streets,
        Self::Quarters,
        Self::Districts,
        Self::Landmarks,
    ];

    /// What people call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Blocks => "Blocks",
            Self::Green => "Parks and open land",
            Self::Parcels => "Parcels",
            Self::Buildings => "Buildings",
            Self::Streets => "Streets",
            Self::Quarters => "Quarters",
            Self::Districts => "Districts",
            Self::Landmarks => "Landmarks",
        }
    }
}

/// Where a drawing stands in the order of painting: layers, and within streets level, casings before fills, then classes.
type Order = (LayerKind, i8, u8, std::cmp::Reverse<u8>);

/// A map of a city.
#[derive(Debug, Default)]
pub struct MapScene {
    parts: BTreeMap<(Order, TileKey), Part>,
    /// Names and colours of what streets are coloured by.
    pub legend: Vec<(String, [u8; 3])>,
    colour_by: ColourBy,
    /// Names of the classes that streets have.
    classes: BTreeMap<Class, String>,
}

#[derive(Clone, Debug)]
struct Part {
    kind: Kind,
    /// The digest of what the chunk was made of.
    digest: Id,
    chunk: ChunkRef,
}

/// Drawings of an order, by tile.
type Drawings = BTreeMap<TileKey, Drawing<Flat>>;

impl MapScene {
    /// The map of a city. Of a map before, with what its city was made from, layers are taken over that are made from the
    /// same, and chunks in which nothing changed.
    pub fn of(gpu: &Gpu, city: &City, colour_by: ColourBy, before: Option<(&Self, Digests)>) -> Self {
        Self::of_part(gpu, city, colour_by, before, None)
    }

    /// The same of what is in sight; elsewhere all stays as it was before.
    pub(super) fn of_part(
        gpu: &Gpu,
        city: &City,
        colour_by: ColourBy,
        before: Option<(&Self, Digests)>,
        sight: Option<Sight>,
    ) -> Self {
        let is_wanted = |tile: TileKey| sight.is_none_or(|sight| sight.contains(tile));
        let colouring = colour_by.map(|by| Colouring::of(city, by));
        let colours = colouring.as_ref();
        let is_kept = |layer: LayerKind| {
            before.is_some_and(|(map, digests)| match layer {
                LayerKind::Buildings => false,
                LayerKind::Streets => map.colour_by == colour_by && are_same(digests.streets, city.digests.streets),
                _ => are_same(digests.land, city.digests.land),
            })
        };
        let drawn: Vec<(Order, Kind, Drawings)> = LayerKind::ALL
            .into_par_iter()
            .filter(|layer| !is_kept(*layer))
            .flat_map_iter(|layer| drawings(city, layer, colours))
            .collect();
        let known = before.map(|(map, _)| &map.parts);
        let wanted = drawn.into_iter().map(|(order, kind, mut drawings)| {
            drawings.retain(|tile, _| is_wanted(*tile));
            (order, kind, drawings)
        });
        let mut made = Self::made(gpu, wanted.collect(), known, colours);
        let stays = |layer: LayerKind, tile: TileKey| is_kept(layer) || !is_wanted(tile);
        let kept = known.into_iter().flatten().filter(|(((layer, ..), tile), _)| stays(*layer, *tile));
        made.parts.extend(kept.map(|(place, part)| (*place, part.clone())));
        Self { colour_by, classes: classes(city), ..made }
    }

    /// Drawings as chunks; those that are the same among known ones are taken over.
    fn made(
        gpu: &Gpu,
        drawn: Vec<(Order, Kind, Drawings)>,
        known: Option<&BTreeMap<(Order, TileKey), Part>>,
        colours: Option<&Colouring>,
    ) -> Self {
        let tiles: Vec<((Order, TileKey), Kind, Drawing<Flat>)> = drawn
            .into_iter()
            .flat_map(|(order, kind, tiles)| tiles.into_iter().map(move |(tile, made)| ((order, tile), kind, made)))
            .collect();
        let made = tiles.into_par_iter().filter_map(|(place, kind, drawing)| {
            let digest = digest(&drawing);
            let kept = known.and_then(|parts| parts.get(&place)).filter(|part| part.digest == digest);
            let chunk = match kept {
                Some(part) => part.chunk.clone(),
                None => Arc::new(Chunk::of(gpu, &drawing)?),
            };
            Some((place, Part { kind, digest, chunk }))
        });
        let parts = made.collect();
        let legend = colours.map(|of| of.entries.iter().map(|entry| (entry.name.clone(), rgb(entry.colour))).collect());
        Self { parts, legend: legend.unwrap_or_default(), ..Self::default() }
    }

    /// The map of a city with colours of its streets that are known already.
    pub fn coloured(gpu: &Gpu, city: &City, colours: Option<&Colouring>) -> Self {
        let drawn = LayerKind::ALL.into_par_iter().flat_map_iter(|layer| drawings(city, layer, colours));
        Self { classes: classes(city), ..Self::made(gpu, drawn.collect(), None, colours) }
    }

    /// The chunks of the layers that are shown, from below; of streets by the name of their class.
    pub fn chunks(
        &self,
        is_shown: impl Fn(LayerKind, Option<&str>) -> bool,
    ) -> impl Iterator<Item = (&ChunkRef, Kind)> {
        let is_shown = move |&(layer, _, _, std::cmp::Reverse(class)): &Order| {
            let class = (layer == LayerKind::Streets).then(|| self.classes.get(&Class(class))).flatten();
            is_shown(layer, class.map(String::as_str))
        };
        let shown = self.parts.iter().filter(move |((order, _), _)| is_shown(order));
        shown.map(|(_, part)| (&part.chunk, part.kind))
    }
}

/// Names of the classes of a city's streets.
fn classes(city: &City) -> BTreeMap<Class, String> {
    city.runs.iter().map(|run| (run.class, city.graph.classes().info(run.class).name.clone())).collect()
}

/// What there is to draw of a layer.
fn drawings(city: &City, layer: LayerKind, colours: Option<&Colouring>) -> Vec<(Order, Kind, Drawings)> {
    let areas = |areas: &[city::Area], width, colour| bands(areas.iter().map(|area| &area.polygon), width, colour);
    let (kind, drawings) = match layer {
        LayerKind::Blocks => (Kind::Area, blocks(city)),
        LayerKind::Green => (Kind::Area, green(city)),
        LayerKind::Parcels => (Kind::Line, parcels(city)),
        LayerKind::Buildings => (Kind::Area, buildings(city)),
        LayerKind::Streets => return streets(city, colours),
        LayerKind::Quarters => (Kind::Area, areas(&city.quarters, 5.0, style::MARK)),
        LayerKind::Districts => (Kind::Area, areas(&city.districts, 8.0, Colour(0x33, 0x22, 0x88))),
        LayerKind::Landmarks => {
            let rims = city.landmarks.iter().map(|landmark| &landmark.ground);
            (Kind::Area, bands(rims, 3.0, style::LANDMARK))
        }
    };
    vec![((layer, 0, 0, std::cmp::Reverse(0)), kind, drawings)]
}

fn digest(drawing: &Drawing<Flat>) -> Id {
    let mut digest = Digest::new("map chunk");
    digest.bytes(bytemuck::cast_slice(&drawing.vertices)).bytes(bytemuck::cast_slice(&drawing.indices));
    digest.finish()
}

fn rgb(Colour(r, g, b): Colour) -> [u8; 3] {
    [r, g, b]
}

fn opaque(colour: Colour) -> [u8; 4] {
    let [r, g, b] = linear(rgb(colour));
    [r, g, b, 255]
}

/// The drawing of the tile that a place lies in.
fn tile_of(drawings: &mut Drawings, place: Vec2) -> &mut Drawing<Flat> {
    let key = TileKey::of(place);
    drawings.entry(key).or_insert_with(|| Drawing::at(key.origin()))
}

/// Fills a polygon; one without triangles is left out.
fn fill(drawings: &mut Drawings, polygon: &Polygon, colour: Colour) {
    let Some(first) = polygon.outer.first() else { return };
    let colour = opaque(colour);
    if is_convex(polygon) {
        // Most buildings are boxes: a fan needs no search for edges.
        let drawing = tile_of(drawings, first.metres());
        for pair in polygon.outer[1..].windows(2) {
            for corner in [*first, pair[0], pair[1]] {
                push(drawing, corner.metres(), colour);
            }
        }
        return;
    }
    let Ok(triangles) = triangulate(polygon) else { return };
    let drawing = tile_of(drawings, first.metres());
    for &triangle in &triangles.triangles {
        for corner in triangles.corners(triangle) {
            push(drawing, corner.metres(), colour);
        }
    }
}

/// Whether a polygon is one ring that turns left at every corner, and goes round once.
fn is_convex(polygon: &Polygon) -> bool {
    let ring = &polygon.outer;
    let at = |i: usize| ring[i % ring.len()];
    let turns_left = |i: usize| orient(at(i), at(i + 1), at(i + 2)) >= 0;
    // A star turns left at every corner, too, but goes round twice: seen from the first corner it turns back.
    let goes_on = |i: usize| orient(at(0), at(i), at(i + 1)) >= 0;
    polygon.holes.is_empty() && ring.len() >= 3 && (0..ring.len()).all(turns_left) && (1..ring.len() - 1).all(goes_on)
}

/// Adds a corner, and its index.
fn push(drawing: &mut Drawing<Flat>, place: Vec2, colour: [u8; 4]) {
    push_rim(drawing, place, (Vec2::ZERO, 0.0), colour);
}

/// Adds a corner of a line with a width: where its middle is, the way from there to the rim, and the least of it in pixels.
fn push_rim(drawing: &mut Drawing<Flat>, place: Vec2, (reach, least): (Vec2, f64), colour: [u8; 4]) {
    let position = (place - drawing.corner).as_vec2().to_array();
    drawing.indices.push(drawing.vertices.len() as u32);
    let reach = [reach.x as f32, reach.y as f32, least as f32];
    drawing.vertices.push(Flat { position, reach, colour });
}

fn blocks(city: &City) -> Drawings {
    let mut drawings = Drawings::new();
    city.blocks.iter().for_each(|block| fill(&mut drawings, &block.polygon, style::BLOCK));
    drawings
}

fn green(city: &City) -> Drawings {
    let mut drawings = Drawings::new();
    for parcel in city.parcels.iter() {
        let colour = match parcel.usage {
            Use::Open => style::OPEN,
            Use::Park => style::PARK,
            Use::Plaza => style::PLAZA,
            Use::Built => continue,
        };
        fill(&mut drawings, &parcel.polygon, colour);
    }
    drawings
}

fn parcels(city: &City) -> Drawings {
    let mut drawings = Drawings::new();
    let colour = opaque(style::PARCEL_LINE.towards(style::INK, 0.2));
    for ring in city.parcels.iter().flat_map(|parcel| parcel.polygon.rings()) {
        let Some(first) = ring.first() else { continue };
        let drawing = tile_of(&mut drawings, first.metres());
        for (i, &p) in ring.iter().enumerate() {
            push(drawing, p.metres(), colour);
            push(drawing, ring[(i + 1) % ring.len()].metres(), colour);
        }
    }
    drawings
}

fn buildings(city: &City) -> Drawings {
    let mut drawings = Drawings::new();
    for building in city.buildings.iter() {
        fill(&mut drawings, &building.footprint, style::tone_colour(style::tone(building.height)));
    }
    drawings
}

/// Bands of a width in metres along the rims of areas.
fn bands<'a>(areas: impl Iterator<Item = &'a Polygon>, width: f64, colour: Colour) -> Drawings {
    let mut drawings = Drawings::new();
    for ring in areas.flat_map(Polygon::rings) {
        let mut line: Vec<Vec2> = ring.iter().map(|p| p.metres()).collect();
        line.extend(line.first().copied());
        ribbon(&mut drawings, &line, (width / 2.0, 0.7), opaque(colour));
    }
    drawings
}

/// Streets by level, first all casings, then all fills, lesser classes first.
fn streets(city: &City, colouring: Option<&Colouring>) -> Vec<(Order, Kind, Drawings)> {
    let mut orders: BTreeMap<Order, Drawings> = BTreeMap::new();
    let order = |run: &Run, fill: u8| {
        let Class(class) = run.class;
        (LayerKind::Streets, run.level, fill, std::cmp::Reverse(class))
    };
    for (index, run) in city.runs.iter().enumerate() {
        let look = style::street_style(city.graph.classes(), run.class);
        let half = f64::from(run.half_width) / Point::UNITS_PER_METRE;
        let rim = (half * 0.28).clamp(0.6, 2.5);
        let least = f64::from(look.least) * LEAST;
        let whole: Vec<Vec2> = run.nodes.iter().map(|&key| city.graph.at(key).metres()).collect();
        let stretches: Vec<(Colour, Colour, &[Vec2])> = match colouring {
            None => vec![(look.casing, look.fill, &whole)],
            Some(colouring) => {
                let of = |stretch: &'_ city::export::map::Stretch| colouring.entries[stretch.entry].colour;
                let stretches = colouring.stretches[index].iter();
                stretches.map(|stretch| (style::rim(of(stretch)), of(stretch), &stretch.line[..])).collect()
            }
        };
        for (casing, fill, line) in stretches {
            // A bridge's rims are darker than what it crosses.
            let casing = if run.level > 0 { casing.towards(style::INK, 0.35) } else { casing };
            ribbon(orders.entry(order(run, 0)).or_default(), line, (half + rim * 0.5, least), opaque(casing));
            ribbon(orders.entry(order(run, 1)).or_default(), line, (half - rim * 0.5, least), opaque(fill));
        }
    }
    orders.into_iter().map(|(order, drawings)| (order, Kind::Area, drawings)).collect()
}

/// Half of the least width of a street in pixels, as a share of that on a drawn map.
const LEAST: f64 = 0.25;

/// Corners of a round end.
const ROUND: usize = 10;

/// A line of half a width in metres and in pixels at least, round at bends and ends.
fn ribbon(drawings: &mut Drawings, line: &[Vec2], (half, least): (f64, f64), colour: [u8; 4]) {
    let Some(&first) = line.first() else { return };
    let drawing = tile_of(drawings, first);
    for pair in line.windows(2) {
        let Some(along) = (pair[1] - pair[0]).try_normalize() else { continue };
        let left = along.perp() * half;
        let [a, b] = [pair[0], pair[1]];
        for (at, reach) in [(a, -left), (b, -left), (b, left), (a, -left), (b, left), (a, left)] {
            push_rim(drawing, at, (reach, least), colour);
        }
    }
    for (i, &at) in line.iter().enumerate() {
        // Straight on there is no gap to fill.
        let is_bend = i == 0 || i + 1 == line.len() || {
            let (before, after) = ((at - line[i - 1]).normalize_or_zero(), (line[i + 1] - at).normalize_or_zero());
            before.dot(after) < 0.999
        };
        if is_bend {
            let rim = |k: usize| {
                let turn = std::f64::consts::TAU * k as f64 / ROUND as f64;
                Vec2::new(turn.cos(), turn.sin()) * half
            };
            for k in 0..ROUND {
                for reach in [Vec2::ZERO, rim(k), rim(k + 1)] {
                    push_rim(drawing, at, (reach, least), colour);
                }
            }
        }
    }
}

/// Most pixels of the ground along a side.
const MOST_GROUND: f64 = 2048.0;

/// Land, parks and the light on hills.
pub(super) fn ground(gpu: &Gpu, city: &City) -> Ground {
    let site = &city.site;
    let size = site.bounds.size();
    let pixel =
        ["land", "parks", "elevation"].into_iter().filter_map(|name| site.map(name)).map(|map| map.pixel_size());
    let finest = pixel.fold(f64::INFINITY, f64::min).min(size.max_element());
    let step = finest.max(size.max_element() / MOST_GROUND);
    let [width, height] = [size.x, size.y].map(|side| ((side / step).ceil() as u32).max(1));
    let low = site.bounds.min.metres();
    let mask = |name: &str, place: Vec2, other: f64| site.map(name).map_or(other, |map| map.bilinear(place));
    let pixel = |index: u32| {
        let (x, y) = (index % width, index / width);
        let share = Vec2::new((f64::from(x) + 0.5) / f64::from(width), 1.0 - (f64::from(y) + 0.5) / f64::from(height));
        let place = low + share * size;
        let slope = site.map("elevation").map_or(Vec2::ZERO, |map| map.gradient(place));
        let light = (0.5 + (slope.y - slope.x) * 0.7).clamp(0.0, 1.0);
        [mask("land", place, 1.0), mask("parks", place, 0.0), light, 1.0].map(|share| (share * 255.0).round() as u8)
    };
    let pixels: Vec<[u8; 4]> = (0..width * height).into_par_iter().map(pixel).collect();
    Ground::of(gpu, [width, height], &pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(corners: &[(i32, i32)]) -> Polygon {
        Polygon { outer: corners.iter().map(|&(x, y)| Point::new(x, y)).collect(), holes: Vec::new() }
    }

    #[test]
    fn boxes_are_convex_and_bays_stars_and_courts_are_not() {
        let square = [(0, 0), (10, 0), (10, 10), (0, 10)];
        assert!(is_convex(&ring(&square)));
        assert!(is_convex(&ring(&[(0, 0), (5, 0), (10, 0), (10, 10)])));
        assert!(!is_convex(&ring(&[(0, 0), (10, 0), (10, 10), (5, 2)])));
        // Five points of a star: always to the left, twice around.
        assert!(!is_convex(&ring(&[(0, 100), (-59, -81), (95, 31), (-95, 31), (59, -81)])));
        let court = Polygon { holes: vec![ring(&[(2, 2), (2, 4), (4, 4), (4, 2)]).outer], ..ring(&square) };
        assert!(!is_convex(&court));
    }

    #[test]
    fn a_fan_covers_what_the_triangles_cover() {
        let area = |polygon: &Polygon| {
            let mut drawings = Drawings::new();
            fill(&mut drawings, polygon, Colour(0, 0, 0));
            let all = drawings.values().flat_map(|drawing| drawing.vertices.chunks(3));
            let at = |corner: &Flat| Vec2::new(f64::from(corner.position[0]), f64::from(corner.position[1]));
            let doubled = |c: &[Flat]| (at(&c[1]) - at(&c[0])).perp_dot(at(&c[2]) - at(&c[0]));
            all.map(doubled).sum::<f64>() / 2.0
        };
        for corners in
            [&[(0, 0), (9000, 100), (9100, 5000), (200, 5100)][..], &[(0, 0), (9000, 0), (9000, 9000), (4000, 900)]]
        {
            let polygon = ring(corners);
            assert!((area(&polygon) - polygon.area()).abs() < 1e-3 * polygon.area(), "{corners:?}");
        }
    }
}
