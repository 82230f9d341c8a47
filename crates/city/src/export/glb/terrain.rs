//! The terrain as right-angled triangles, as few as keep it within [`ERROR_M`] of the elevation map (a right-triangulated
//! irregular network, Evans, Kirkpatrick & Townsend 2001), without a crack between triangles or tiles.
//!
//! Shores and park rims are lines through the triangles, where the mask interpolated between grid points passes one half.

use super::tiles::{Meshes, Tiles};
use super::{Corner, Group, Surface, TILE_M, TileKey, push_corners};
use crate::City;
use geom::{Bounds, Raster, Vec2, Vec3};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// What the terrain may be off the elevation map, in metres.
pub const ERROR_M: f64 = 0.5;

/// Most halvings of a tile's side: cells of about 8 m.
const MOST_HALVINGS: u32 = 7;

/// A grid point: columns and rows from the south-west corner of the south-west tile.
type Cell = (usize, usize);

/// A right-angled triangle of the grid: both ends of its long side, then its right angle.
type Triangle = [Cell; 3];

/// The terrain of a city.
pub struct Terrain {
    /// The ground that is shown.
    low: Vec2,
    high: Vec2,
    /// South-west tile.
    first: TileKey,
    /// Tiles from west to east and from south to north.
    tiles: (usize, usize),
    /// Halvings of a tile's side.
    halvings: u32,
    /// Metres between grid points.
    step: f64,
    heights: Vec<f32>,
    /// Above 0 on land; empty where all is land.
    land: Vec<f32>,
    /// Above 0 in parks; empty where there is none.
    park: Vec<f32>,
    /// For the middle of a long side: what is lost where its triangles are not split. At least that of any triangle
    /// within, so that a split never leaves a neighbour with a crack.
    errors: Vec<f32>,
}

impl Terrain {
    /// The terrain under a city's site and streets.
    pub fn of(city: &City) -> Self {
        let site = city.site.bounds;
        let bounds = city.graph.bounds().map_or(site, |b| site.with(b.min).with(b.max));
        let finest = ["elevation", "land", "parks"].into_iter().filter_map(|name| city.site.map(name));
        let pixel = finest.map(|map| map.pixel_size()).fold(f64::INFINITY, f64::min);
        let mut terrain = Self::flat(bounds, halvings_for(pixel));
        terrain.sample(city);
        terrain.measure();
        terrain
    }

    fn flat(bounds: Bounds, halvings: u32) -> Self {
        let (low, high) = (bounds.min.metres(), bounds.max.metres());
        let (first, last) = (TileKey::of(low), TileKey::of(high));
        let count = |from: i32, to: i32| usize::try_from(to - from).unwrap_or(0) + 1;
        let tiles = (count(first.column, last.column), count(first.row, last.row));
        let step = TILE_M / f64::from(1u32 << halvings);
        let (heights, land, park, errors) = Default::default();
        Self { low, high, first, tiles, halvings, step, heights, land, park, errors }
    }

    /// Grid points from west to east and from south to north.
    fn size(&self) -> (usize, usize) {
        ((self.tiles.0 << self.halvings) + 1, (self.tiles.1 << self.halvings) + 1)
    }

    fn index(&self, (column, row): Cell) -> usize {
        row * self.size().0 + column
    }

    fn place(&self, (column, row): Cell) -> Vec2 {
        self.first.origin() + Vec2::new(column as f64, row as f64) * self.step
    }

    fn sample(&mut self, city: &City) {
        let (columns, rows) = self.size();
        let sampled = |value: &(dyn Fn(Vec2) -> f64 + Sync)| -> Vec<f32> {
            let cells = (0..columns * rows).into_par_iter();
            cells.map(|cell| value(self.place((cell % columns, cell / columns))) as f32).collect()
        };
        let mask = |map: Option<&std::sync::Arc<Raster>>| {
            map.map_or(Vec::new(), |map| sampled(&|at| off_zero(map.bilinear(at) - 0.5)))
        };
        let heights = sampled(&|at| city.site.elevation(at));
        let (land, park) = (mask(city.site.map("land")), mask(city.site.map("parks")));
        (self.heights, self.land, self.park) = (heights, land, park);
    }

    /// Fills `errors`, from the smallest triangles up.
    fn measure(&mut self) {
        // Errors are not negative, so that their bits are in the same order as they.
        let errors: Vec<AtomicU32> = self.heights.iter().map(|_| AtomicU32::new(0)).collect();
        let known = |at: usize| f32::from_bits(errors[at].load(Ordering::Relaxed));
        let is_level = self.heights.iter().all(|&height| height == self.heights[0]);
        let ground = self.kinds_of_ground();
        let tiles: Vec<Cell> = self.tile_cells().collect();
        let last = 2 * self.halvings;
        for depth in (0..last).rev() {
            tiles.par_iter().flat_map_iter(|&tile| self.roots(tile)).for_each(|root| {
                self.at_depth(root, depth, &mut |triangle| {
                    let [a, b, c] = triangle;
                    let at = self.index(middle(a, b));
                    let mut error = self.rim_error(&ground, triangle, at);
                    if depth + 1 < last {
                        // The long sides of the halves are the short ones of the whole.
                        error = error.max(known(self.index(middle(c, a)))).max(known(self.index(middle(b, c))));
                    }
                    // Only whether the promise holds matters, so that what is split anyway is not measured.
                    if !is_level && f64::from(error) <= ERROR_M {
                        let is_last = depth + 1 == last;
                        let of_heights =
                            if is_last { self.middle_error(triangle, at) } else { self.height_error(triangle) };
                        error = error.max(of_heights);
                    }
                    errors[at].fetch_max(error.to_bits(), Ordering::Relaxed);
                });
            });
        }
        self.errors = errors.into_iter().map(|error| f32::from_bits(error.into_inner())).collect();
    }

    /// On which side of shores and of park rims each grid point lies; empty where there are none.
    fn kinds_of_ground(&self) -> Vec<u8> {
        let bit = |mask: &[f32], at: usize| u8::from(mask.get(at).is_some_and(|&value| value > 0.0));
        let masks = self.land.len().max(self.park.len());
        (0..masks).into_par_iter().map(|at| bit(&self.land, at) | bit(&self.park, at) << 1).collect()
    }

    /// Endless where a shore or park rim passes between the corners and the middle of the long side.
    fn rim_error(&self, ground: &[u8], [a, b, c]: Triangle, middle: usize) -> f32 {
        let differs = |cell: Cell| ground[self.index(cell)] != ground[middle];
        if !ground.is_empty() && (differs(a) || differs(b) || differs(c)) { f32::INFINITY } else { 0.0 }
    }

    /// The same as [`Self::height_error`] for a triangle with no other grid point than the middle of its long side.
    fn middle_error(&self, [a, b, _]: Triangle, middle: usize) -> f32 {
        let height = |at: usize| f64::from(self.heights[at]);
        (0.5 * height(self.index(a)) + 0.5 * height(self.index(b)) - height(middle)).abs() as f32
    }

    /// How far the grid points in a triangle lie off its plane at most, in metres; not beyond the first that lies too
    /// far off.
    fn height_error(&self, triangle: Triangle) -> f32 {
        let wide = |(x, y): Cell| (x as i64, y as i64);
        let (a, b, c) = (wide(triangle[0]), wide(triangle[1]), wide(triangle[2]));
        let whole = cross(a, b, c) as f64;
        let height = |cell: Cell| f64::from(self.heights[self.index(cell)]);
        let (p, q, r) = (height(triangle[0]), height(triangle[1]), height(triangle[2]));
        let span = |a: i64, b: i64, c: i64| a.min(b).min(c)..=a.max(b).max(c);
        let mut error = 0f64;
        for y in span(a.1, b.1, c.1) {
            for x in span(a.0, b.0, c.0) {
                let (second, third) = (cross(a, (x, y), c) as f64 / whole, cross(a, b, (x, y)) as f64 / whole);
                let first = 1.0 - second - third;
                if first < 0.0 || second < 0.0 || third < 0.0 {
                    continue;
                }
                let there = f64::from(self.heights[self.index((x as usize, y as usize))]);
                error = error.max((first * p + second * q + third * r - there).abs());
                if error > ERROR_M {
                    return error as f32;
                }
            }
        }
        error as f32
    }

    fn tile_cells(&self) -> impl Iterator<Item = Cell> + use<> {
        let tiles = self.tiles;
        (0..tiles.1).flat_map(move |row| (0..tiles.0).map(move |column| (column, row)))
    }

    /// The two halves of a tile.
    fn roots(&self, (column, row): Cell) -> [Triangle; 2] {
        let n = 1 << self.halvings;
        let (x, y) = (column * n, row * n);
        [[(x, y), (x + n, y + n), (x + n, y)], [(x + n, y + n), (x, y), (x, y + n)]]
    }

    fn at_depth(&self, triangle: Triangle, depth: u32, f: &mut impl FnMut(Triangle)) {
        if depth == 0 {
            return f(triangle);
        }
        let [one, other] = halves(triangle);
        self.at_depth(one, depth - 1, f);
        self.at_depth(other, depth - 1, f);
    }

    /// Whether a triangle of a depth is split.
    fn is_split(&self, triangle: Triangle, depth: u32) -> bool {
        depth < 2 * self.halvings && f64::from(self.errors[self.index(middle(triangle[0], triangle[1]))]) > ERROR_M
    }

    /// Calls `f` with the triangles of the terrain that a box may touch; all of `within` where it is `None`.
    fn for_leaves(&self, within: Triangle, depth: u32, near: Option<(Vec2, Vec2)>, f: &mut impl FnMut(Triangle)) {
        if near.is_some_and(|near| !self.may_touch(within, near)) {
            return;
        }
        if self.is_split(within, depth) {
            let [one, other] = halves(within);
            self.for_leaves(one, depth + 1, near, f);
            self.for_leaves(other, depth + 1, near, f);
        } else {
            f(within);
        }
    }

    fn may_touch(&self, triangle: Triangle, (low, high): (Vec2, Vec2)) -> bool {
        let (a, b, c) = (self.place(triangle[0]), self.place(triangle[1]), self.place(triangle[2]));
        let (least, most) = (a.min(b).min(c), a.max(b).max(c));
        least.cmple(high).all() && most.cmpge(low).all()
    }

    /// A grid point as a corner, with the normal of the terrain around it.
    fn corner(&self, cell: Cell) -> Corner {
        let at = self.place(cell);
        let height = f64::from(self.heights[self.index(cell)]);
        let (columns, rows) = self.size();
        let slope = |low: Cell, high: Cell, steps: usize| {
            let rise = self.heights[self.index(high)] - self.heights[self.index(low)];
            f64::from(rise) / (steps.max(1) as f64 * self.step)
        };
        let (west, east) = (cell.0.saturating_sub(1), (cell.0 + 1).min(columns - 1));
        let (south, north) = (cell.1.saturating_sub(1), (cell.1 + 1).min(rows - 1));
        let x = slope((west, cell.1), (east, cell.1), east - west);
        let y = slope((cell.0, south), (cell.0, north), north - south);
        Corner { at, height, normal: Vec3::new(-x, -y, 1.0) }
    }

    /// A triangle with its corners counter-clockwise.
    fn turned(&self, [a, b, c]: Triangle) -> Triangle {
        let (p, q, r) = (self.place(a), self.place(b), self.place(c));
        if (q - p).perp_dot(r - p) > 0.0 { [a, b, c] } else { [b, a, c] }
    }

    /// The corners of a triangle, counter-clockwise.
    fn corners(&self, triangle: Triangle) -> [Corner; 3] {
        self.turned(triangle).map(|cell| self.corner(cell))
    }

    /// Height of the terrain in metres; at the rim for places outside.
    pub fn height(&self, place: Vec2) -> f64 {
        let place = place.clamp(self.place((0, 0)), self.place((self.size().0 - 1, self.size().1 - 1)));
        let mut found = None;
        self.for_leaves_near((place, place), &mut |triangle| {
            let corners = self.corners(triangle);
            if found.is_none() && shares(&corners, place).iter().all(|&share| share >= -1e-9) {
                found = Some(interpolated(&corners, place).height);
            }
        });
        found.unwrap_or(0.0)
    }

    fn for_leaves_near(&self, near: (Vec2, Vec2), f: &mut impl FnMut(Triangle)) {
        let cells = |low: f64, high: f64, first: i32, count: usize| {
            let last = count as i64 - 1;
            let cell = |x: f64| ((x / TILE_M).floor() as i64 - i64::from(first)).clamp(0, last) as usize;
            // Both tiles of a shared rim are looked at.
            cell(low - self.step)..=cell(high + self.step)
        };
        for row in cells(near.0.y, near.1.y, self.first.row, self.tiles.1) {
            for column in cells(near.0.x, near.1.x, self.first.column, self.tiles.0) {
                self.roots((column, row)).into_iter().for_each(|root| self.for_leaves(root, 0, Some(near), f));
            }
        }
    }

    /// Lays a convex polygon (counter-clockwise, metres) onto the terrain, `lift` metres above it: calls `f` with the
    /// pieces that lie on one triangle each.
    pub fn drape(&self, polygon: &[Vec2], lift: f64, f: &mut impl FnMut(&[Corner])) {
        let Some((&first, rest)) = polygon.split_first() else { return };
        let near = rest.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
        // Most triangles near a street are missed by it, so that nothing is found of them, nor room for it, until need be.
        let (mut piece, mut cut, mut on_ground) = (Vec::new(), Vec::new(), Vec::new());
        self.for_leaves_near(near, &mut |triangle| {
            let cells = self.turned(triangle);
            let [a, b, c] = cells.map(|cell| self.place(cell));
            piece.clear();
            piece.extend_from_slice(polygon);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                clip(&piece, |&p| (to - from).perp_dot(p - from), |p, q, t| p.lerp(*q, t), &mut cut);
                std::mem::swap(&mut piece, &mut cut);
            }
            if area(&piece) > LEAST_PIECE_M2 {
                let corners = cells.map(|cell| self.corner(cell));
                on_ground.clear();
                on_ground.extend(piece.iter().map(|&at| {
                    let corner = interpolated(&corners, at);
                    Corner { height: corner.height + lift, ..corner }
                }));
                f(&on_ground);
            }
        });
    }

    /// The terrain as meshes, cut to what is shown.
    pub fn tiles(&self) -> Tiles {
        let tile = |(column, row): Cell| {
            let key = TileKey { column: self.first.column + column as i32, row: self.first.row + row as i32 };
            let (mut meshes, mut shared) = (Meshes::of(key), Shared::default());
            for root in self.roots((column, row)) {
                self.for_leaves(root, 0, None, &mut |triangle| self.add_triangle(&mut meshes, triangle, &mut shared));
            }
            (key, Arc::new(meshes.finish()))
        };
        self.tile_cells().collect::<Vec<_>>().into_par_iter().map(tile).collect()
    }

    fn add_triangle(&self, meshes: &mut Meshes, triangle: Triangle, shared: &mut Shared) {
        let origin = meshes.origin;
        let values =
            |mask: &[f32], other: f32| triangle.map(|cell| mask.get(self.index(cell)).copied().unwrap_or(other));
        let (land, park) = (values(&self.land, 1.0), values(&self.park, -1.0));
        let whole = |mask: [f32; 3]| mask.iter().all(|&v| v > 0.0) || mask.iter().all(|&v| v <= 0.0);
        let inside = triangle.iter().all(|&cell| {
            let at = self.place(cell);
            at.cmpge(self.low).all() && at.cmple(self.high).all()
        });
        if inside && whole(land) && whole(park) {
            let surface = surface_of(land[0] > 0.0, park[0] > 0.0);
            let mesh = meshes.mesh(Group::Terrain, surface);
            self.push_shared(mesh, origin, triangle, shared.entry(surface).or_default());
            return;
        }
        let point = |i: usize| Mixed { corner: self.corner(triangle[i]), land: land[i].into(), park: park[i].into() };
        let mut corners = [0, 1, 2].map(point);
        if (corners[1].corner.at - corners[0].corner.at).perp_dot(corners[2].corner.at - corners[0].corner.at) < 0.0 {
            corners.swap(0, 1);
        }
        for (surface, piece) in self.pieces(corners.to_vec()) {
            push_corners(meshes.mesh(Group::Terrain, surface), &piece, origin);
        }
    }

    /// A triangle cut to what is shown and parted into surfaces.
    fn pieces(&self, corners: Vec<Mixed>) -> Vec<(Surface, Vec<Corner>)> {
        let (low, high) = (self.low, self.high);
        let mut shown = clipped(&corners, |p| p.corner.at.x - low.x, Mixed::between);
        shown = clipped(&shown, |p| high.x - p.corner.at.x, Mixed::between);
        shown = clipped(&shown, |p| p.corner.at.y - low.y, Mixed::between);
        shown = clipped(&shown, |p| high.y - p.corner.at.y, Mixed::between);
        let land = clipped(&shown, |p| p.land, Mixed::between);
        let parts = [
            (Surface::Water, clipped(&shown, |p| -p.land, Mixed::between)),
            (Surface::Park, clipped(&land, |p| p.park, Mixed::between)),
            (Surface::Ground, clipped(&land, |p| -p.park, Mixed::between)),
        ];
        let plain = |(surface, piece): (Surface, Vec<Mixed>)| {
            (surface, piece.into_iter().map(|point| point.corner).collect::<Vec<_>>())
        };
        let seen = |(_, piece): &(Surface, Vec<Corner>)| {
            area(&piece.iter().map(|corner| corner.at).collect::<Vec<_>>()) > LEAST_PIECE_M2
        };
        parts.into_iter().map(plain).filter(seen).collect()
    }

    /// Adds a triangle whose corners are shared with its neighbours.
    fn push_shared(&self, mesh: &mut geom::Mesh, origin: Vec2, triangle: Triangle, known: &mut FxHashMap<Cell, u32>) {
        for cell in self.turned(triangle) {
            let index = *known.entry(cell).or_insert_with(|| {
                let next = mesh.positions.len() as u32;
                push_corners(mesh, &[self.corner(cell)], origin);
                next
            });
            mesh.indices.push(index);
        }
    }
}

/// Corners of a tile that a surface has already.
type Shared = std::collections::BTreeMap<Surface, FxHashMap<Cell, u32>>;

/// Smaller pieces (m²) are left out: they are what rounding leaves along a cut.
const LEAST_PIECE_M2: f64 = 1e-5;

/// A corner with the masks there.
#[derive(Clone, Copy)]
struct Mixed {
    corner: Corner,
    land: f64,
    park: f64,
}

impl Mixed {
    fn between(&self, other: &Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * t;
        let corner = Corner {
            at: self.corner.at.lerp(other.corner.at, t),
            height: mix(self.corner.height, other.corner.height),
            normal: self.corner.normal.lerp(other.corner.normal, t),
        };
        Self { corner, land: mix(self.land, other.land), park: mix(self.park, other.park) }
    }
}

fn surface_of(land: bool, park: bool) -> Surface {
    match (land, park) {
        (false, _) => Surface::Water,
        (true, true) => Surface::Park,
        (true, false) => Surface::Ground,
    }
}

/// A mask's value, never 0: what passes through a grid point would otherwise leave pieces without an area.
fn off_zero(value: f64) -> f64 {
    if value.abs() < 1e-3 { 1e-3 } else { value }
}

/// Halvings of a tile that make cells no larger than a pixel; none where there is no map.
fn halvings_for(pixel: f64) -> u32 {
    if !pixel.is_finite() {
        return 0;
    }
    (1..MOST_HALVINGS).find(|&n| TILE_M / f64::from(1u32 << n) <= pixel).unwrap_or(MOST_HALVINGS)
}

fn middle(a: Cell, b: Cell) -> Cell {
    ((a.0 + b.0) / 2, (a.1 + b.1) / 2)
}

/// Twice the signed area of a triangle of grid points.
fn cross(a: (i64, i64), b: (i64, i64), c: (i64, i64)) -> i64 {
    (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
}

/// The two triangles that a split makes.
fn halves([a, b, c]: Triangle) -> [Triangle; 2] {
    let middle = middle(a, b);
    [[c, a, middle], [b, c, middle]]
}

/// The shares of the corners at a place (barycentric coordinates).
fn shares(corners: &[Corner; 3], place: Vec2) -> [f64; 3] {
    let [a, b, c] = corners.map(|corner| corner.at);
    let whole = (b - a).perp_dot(c - a);
    let second = (place - a).perp_dot(c - a) / whole;
    let third = (b - a).perp_dot(place - a) / whole;
    [1.0 - second - third, second, third]
}

fn interpolated(corners: &[Corner; 3], at: Vec2) -> Corner {
    let shares = shares(corners, at);
    let height = (0..3).map(|i| shares[i] * corners[i].height).sum();
    let normal = (0..3).map(|i| shares[i] * corners[i].normal).sum();
    Corner { at, height, normal }
}

/// The part of a convex polygon where `side` is not negative (Sutherland and Hodgman 1974).
fn clipped<P: Copy>(polygon: &[P], side: impl Fn(&P) -> f64, between: impl Fn(&P, &P, f64) -> P) -> Vec<P> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    clip(polygon, side, between, &mut kept);
    kept
}

/// The same, into a list that is emptied first.
fn clip<P: Copy>(polygon: &[P], side: impl Fn(&P) -> f64, between: impl Fn(&P, &P, f64) -> P, kept: &mut Vec<P>) {
    kept.clear();
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        let (here, there) = (side(p), side(q));
        if here >= 0.0 {
            kept.push(*p);
        }
        if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
            kept.push(between(p, q, here / (here - there)));
        }
    }
}

/// Area of a polygon in m².
fn area(polygon: &[Vec2]) -> f64 {
    let Some(&base) = polygon.first() else { return 0.0 };
    polygon.windows(2).map(|pair| (pair[0] - base).perp_dot(pair[1] - base)).sum::<f64>() / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::samples::{hilly_city, small_city};
    use proptest::prelude::*;

    #[test]
    fn a_flat_site_is_two_triangles_a_tile() {
        let mut city = small_city();
        std::sync::Arc::make_mut(&mut city.site).maps.clear();
        let tiles = Terrain::of(&city).tiles();
        let meshes = tiles.values().flat_map(|tile| tile.values());
        let triangles: usize = meshes.map(|mesh| mesh.triangles().count()).sum();
        let shown = city.site.bounds.size();
        assert!(shown.x < TILE_M && shown.y < TILE_M, "{shown}");
        // Both halves are cut to the site: a quadrilateral or two each.
        assert!((2..=6).contains(&triangles), "{triangles}");
    }

    #[test]
    fn the_terrain_covers_the_site_once() {
        let city = hilly_city();
        let tiles = Terrain::of(&city).tiles();
        let plan = |[a, b, c]: [[f32; 3]; 3]| {
            let flat = |p: [f32; 3]| Vec2::new(f64::from(p[0]), -f64::from(p[2]));
            (flat(b) - flat(a)).perp_dot(flat(c) - flat(a)) / 2.0
        };
        let meshes = tiles.values().flat_map(|tile| tile.values());
        let areas: Vec<f64> = meshes.flat_map(|mesh| mesh.triangles().map(plan)).collect();
        assert!(areas.iter().all(|&area| area > -1e-3));
        let size = city.site.bounds.size();
        assert!((areas.iter().sum::<f64>() / (size.x * size.y) - 1.0).abs() < 1e-4);
        assert!(areas.len() > 100);
    }

    #[test]
    fn no_triangle_ends_within_the_side_of_another() {
        let terrain = Terrain::of(&hilly_city());
        let mut sides: std::collections::BTreeMap<[Cell; 2], u32> = std::collections::BTreeMap::new();
        for tile in terrain.tile_cells() {
            for root in terrain.roots(tile) {
                terrain.for_leaves(root, 0, None, &mut |[a, b, c]| {
                    for (p, q) in [(a, b), (b, c), (c, a)] {
                        *sides.entry([p.min(q), p.max(q)]).or_default() += 1;
                    }
                });
            }
        }
        let (columns, rows) = terrain.size();
        let on_rim = |p: Cell, q: Cell| {
            (p.0 == q.0 && (p.0 == 0 || p.0 == columns - 1)) || (p.1 == q.1 && (p.1 == 0 || p.1 == rows - 1))
        };
        assert!(sides.len() > 1000 && terrain.tiles.0 > 1);
        for ([p, q], count) in sides {
            assert_eq!(count, if on_rim(p, q) { 1 } else { 2 }, "{p:?} {q:?}");
        }
    }

    #[test]
    fn the_smallest_triangles_miss_the_height_of_one_grid_point() {
        let terrain = Terrain::of(&hilly_city());
        let mut uneven = 0;
        for root in terrain.tile_cells().flat_map(|tile| terrain.roots(tile)) {
            terrain.at_depth(root, 2 * terrain.halvings - 1, &mut |triangle| {
                let [a, b, _] = triangle;
                let whole = terrain.height_error(triangle);
                assert_eq!(terrain.middle_error(triangle, terrain.index(middle(a, b))).to_bits(), whole.to_bits());
                uneven += usize::from(whole > 0.0);
            });
        }
        assert!(uneven > 100);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn heights_keep_the_promised_error(x in 0.0..1500.0f64, y in 0.0..1500.0f64) {
            let city = hilly_city();
            let terrain = Terrain::of(&city);
            // At grid points the map is sampled exactly.
            let cell = ((x / terrain.step).round() as usize, (y / terrain.step).round() as usize);
            let at = terrain.place(cell);
            prop_assert!((terrain.height(at) - city.site.elevation(at)).abs() <= ERROR_M + 1e-3);
        }
    }
}
