//! The page in pixels, by tiny-skia, tile by tile; words by resvg with the shipped font alone, so that no machine's fonts show.

use super::MapError;
use super::canvas::{Canvas, Colour, Lines, Pen, Text};
use super::svg::{head, text_element};
use crate::Cache;
use geom::{Digest, Id};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageResult};
use rayon::prelude::*;
use resvg::tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Shader, Stroke, StrokeDash, Transform,
};
use resvg::usvg::{Options, Tree, fontdb};
use std::sync::{Arc, OnceLock};

/// Side of a tile in pixels.
const TILE: u32 = 512;

/// Pixels around a tile that are painted and not shown: the rasteriser draws thin lines wrongly at the upper and left rim.
const RIM: u32 = 6;

/// Pens up to this width are drawn by the rasteriser as hairlines, which lead astray where they come in from outside.
const HAIRLINE: f32 = 1.0;

/// Chains drawn at once: enough to be fast, few enough for the rasteriser's list of edges.
const BATCH: usize = 2_000;

/// What is to be painted, step by step; painted in tiles, all at the same time.
#[derive(Debug, Default)]
pub struct Pixels {
    steps: Vec<Step>,
    /// Words, written in the end, over everything.
    words: String,
}

/// Chains drawn in one way.
#[derive(Debug)]
struct Step {
    lines: Lines,
    colour: Colour,
    /// The pen; areas are filled where there is none.
    pen: Option<Pen>,
}

/// A painted page: its tiles row by row. Those of one page and the next may be the same ones.
#[derive(Clone, Debug)]
pub struct Page {
    width: u32,
    height: u32,
    /// Side of a tile.
    side: u32,
    tiles: Vec<Arc<Tile>>,
}

#[derive(Clone, Debug)]
struct Tile {
    /// With [`RIM`] more on each side.
    pixels: Pixmap,
    /// The digest of all that was painted on it.
    digest: Id,
}

impl Page {
    /// An empty page of a size in pixels.
    ///
    /// # Errors
    /// When there is no memory for it.
    pub fn new(width: u32, height: u32) -> Result<Self, MapError> {
        Self::in_tiles(width, height, TILE)
    }

    fn in_tiles(width: u32, height: u32, side: u32) -> Result<Self, MapError> {
        let corners = (0..height).step_by(side as usize);
        let corners = corners.flat_map(|y| (0..width).step_by(side as usize).map(move |x| [x, y]));
        let tile = |[x, y]: [u32; 2]| {
            let pixels = Pixmap::new(side.min(width - x) + 2 * RIM, side.min(height - y) + 2 * RIM)?;
            let digest = Digest::new("tile of a page").value(&(x, y, pixels.width(), pixels.height())).finish();
            Some(Arc::new(Tile { pixels, digest }))
        };
        let tiles = corners.map(tile).collect::<Option<_>>().ok_or(MapError::Size { width, height })?;
        Ok(Self { width, height, side, tiles })
    }

    fn columns(&self) -> usize {
        self.width.div_ceil(self.side) as usize
    }

    /// Upper left corner of a tile.
    fn corner(&self, tile: usize) -> [u32; 2] {
        [(tile % self.columns()) as u32 * self.side, (tile / self.columns()) as u32 * self.side]
    }

    /// The tiles that a box of pixels may touch.
    fn touched(&self, low: [f32; 2], high: [f32; 2]) -> impl Iterator<Item = usize> + use<> {
        let columns = self.columns();
        let of = |axis: usize, count: usize| {
            let cell = |at: f32| (at / self.side as f32).floor();
            let (first, last) = (cell(low[axis]).max(0.0), cell(high[axis]).min(count as f32 - 1.0));
            // What is not a number touches nothing.
            if first <= last { first as usize..last as usize + 1 } else { 0..0 }
        };
        let (across, down) = (of(0, columns), of(1, self.tiles.len() / columns.max(1)));
        down.flat_map(move |row| across.clone().map(move |column| row * columns + column))
    }

    /// For each tile, whether another page has the very same.
    #[cfg(test)]
    pub fn shared_tiles(&self, other: &Self) -> Vec<bool> {
        self.tiles.iter().zip(&other.tiles).map(|(a, b)| Arc::ptr_eq(a, b)).collect()
    }

    /// The whole page in one piece.
    fn joined(&self) -> Result<Pixmap, MapError> {
        let (width, height) = (self.width, self.height);
        let mut whole = Pixmap::new(width, height).ok_or(MapError::Size { width, height })?;
        let row_of = width as usize * 4;
        for (index, tile) in self.tiles.iter().enumerate() {
            let [x, y] = self.corner(index).map(|at| at as usize);
            let row_of_tile = tile.pixels.width() as usize * 4;
            let shown = RIM as usize * 4..row_of_tile - RIM as usize * 4;
            let rows = tile.pixels.height().saturating_sub(2 * RIM) as usize;
            for (i, row) in tile.pixels.data().chunks_exact(row_of_tile).skip(RIM as usize).take(rows).enumerate() {
                let start = (y + i) * row_of + x * 4;
                whole.data_mut()[start..start + shown.len()].copy_from_slice(&row[shown.clone()]);
            }
        }
        Ok(whole)
    }
}

impl Pixels {
    /// Paints on a page, but for the words. Where the cache keeps anything, tiles on which the same was painted before are
    /// not painted again.
    pub fn painted(&self, page: &Page, cache: &Cache) -> Page {
        let shares = self.shares(page);
        let tile = |(index, (below, share)): (usize, (&Arc<Tile>, &Share))| {
            if share.is_empty() {
                return below.clone();
            }
            let digest = self.digest(below.digest, share);
            cache.part(Some(digest), || self.painted_tile(below, digest, page.corner(index), share))
        };
        let tiles = page.tiles.par_iter().zip(&shares).enumerate().map(tile).collect();
        Page { tiles, ..*page }
    }

    /// The page with the words as a PNG file.
    ///
    /// # Errors
    /// When the words or the file can't be made.
    pub fn finish(self, page: &Page) -> Result<Vec<u8>, MapError> {
        let mut whole = page.joined()?;
        let words = format!("{}{}</svg>", head(page.width, page.height), self.words);
        let options = Options { fontdb: fonts(), font_family: "Source Sans Pro".into(), ..Options::default() };
        let tree = Tree::from_str(&words, &options).map_err(|error| MapError::Text(error.to_string()))?;
        resvg::render(&tree, Transform::identity(), &mut whole.as_mut());
        encoded(whole).map_err(|error| MapError::Png(error.to_string()))
    }

    /// What each tile has a share in: of each step that touches it, the chains that do.
    fn shares(&self, page: &Page) -> Vec<Share<'_>> {
        let mut shares: Vec<Share> = page.tiles.iter().map(|_| Share::new()).collect();
        for (index, step) in self.steps.iter().enumerate() {
            // A pixel more for what rounding and soft rims add.
            let room = step.pen.map_or(0.0, |pen| pen.width / 2.0) + 1.0;
            for chain in step.lines.chains() {
                let (mut low, mut high) = (chain.0[0], chain.0[0]);
                for point in chain.0 {
                    for axis in 0..2 {
                        (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
                    }
                }
                for tile in page.touched(low.map(|at| at - room), high.map(|at| at + room)) {
                    match shares[tile].last_mut() {
                        Some((last, chains)) if *last == index => chains.push(chain),
                        _ => shares[tile].push((index, vec![chain])),
                    }
                }
            }
        }
        shares
    }

    fn digest(&self, below: Id, share: &Share) -> Id {
        let mut digest = Digest::new("painted");
        digest.id(below);
        let mut bytes = Vec::new();
        for (index, chains) in share {
            let Step { lines: _, colour, pen } = &self.steps[*index];
            digest.value(&(colour, pen, chains.len()));
            bytes.clear();
            for (chain, closed) in chains {
                bytes.push(u8::from(*closed));
                bytes.extend(chain.len().to_le_bytes());
                bytes.extend(chain.iter().flatten().flat_map(|at| at.to_le_bytes()));
            }
            digest.bytes(&bytes);
        }
        digest.finish()
    }

    fn painted_tile(&self, below: &Tile, digest: Id, corner: [u32; 2], share: &Share) -> Tile {
        let mut pixels = below.pixels.clone();
        let [x, y] = corner.map(|at| at as f32 - RIM as f32);
        let size = [pixels.width(), pixels.height()].map(f64::from);
        for (index, chains) in share {
            let step = &self.steps[*index];
            let paint = paint(step.colour);
            match step.pen {
                // Rings of one shape may lie apart in the list, so that a shape with holes must not be parted.
                None => paths(chains, usize::MAX, [x, y]).iter().for_each(|path| {
                    pixels.fill_path(path, &paint, FillRule::EvenOdd, Transform::identity(), None);
                }),
                Some(pen) if pen.width <= HAIRLINE && pen.dash.is_none() => {
                    let (rings, lines): (Vec<_>, Vec<_>) = chains.iter().partition(|(_, closed)| *closed);
                    // A ring has no ends, and the rasteriser would put one where it begins.
                    for (chains, round) in [(rings, false), (lines, pen.round)] {
                        let stroke = stroke(Pen { round, ..pen });
                        let cut = cut(&chains, [x, y], size);
                        cut.chunks(BATCH).filter_map(|pieces| path_of(pieces.iter().cloned())).for_each(|path| {
                            pixels.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
                        });
                    }
                }
                Some(pen) => {
                    let stroke = stroke(pen);
                    paths(chains, BATCH, [x, y]).iter().for_each(|path| {
                        pixels.stroke_path(path, &paint, &stroke, Transform::identity(), None);
                    });
                }
            }
        }
        Tile { pixels, digest }
    }
}

/// The steps that touch a tile, each with the chains that do and whether they are closed.
type Share<'a> = Vec<(usize, Vec<(&'a [[f32; 2]], bool)>)>;

/// A page as a PNG file, packed the fast way: it comes out about a third larger, in a fraction of the time.
fn encoded(page: Pixmap) -> ImageResult<Vec<u8>> {
    let (width, height) = (page.width(), page.height());
    let mut file = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Adaptive);
    encoder.write_image(&page.take_demultiplied(), width, height, ExtendedColorType::Rgba8)?;
    Ok(file)
}

/// The shipped fonts and no others.
pub fn fonts() -> Arc<fontdb::Database> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let load = || {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(include_bytes!("../../../assets/SourceSansPro-Regular.ttf").to_vec());
        fonts.load_font_data(include_bytes!("../../../assets/SourceSansPro-Semibold.ttf").to_vec());
        Arc::new(fonts)
    };
    FONTS.get_or_init(load).clone()
}

impl Canvas for Pixels {
    fn part(&mut self, _name: &str) {}

    fn fill(&mut self, rings: &Lines, colour: Colour) {
        self.steps.push(Step { lines: rings.clone(), colour, pen: None });
    }

    fn stroke(&mut self, lines: &Lines, pen: Pen) {
        self.steps.push(Step { lines: lines.clone(), colour: pen.colour, pen: Some(pen) });
    }

    fn text(&mut self, text: &Text) {
        self.words.push_str(&text_element(text));
    }
}

fn stroke(pen: Pen) -> Stroke {
    Stroke {
        width: pen.width,
        line_cap: if pen.round { LineCap::Round } else { LineCap::Butt },
        line_join: LineJoin::Round,
        dash: pen.dash.and_then(|dash| StrokeDash::new(vec![dash, dash], 0.0)),
        ..Stroke::default()
    }
}

fn paint(Colour(r, g, b): Colour) -> Paint<'static> {
    Paint { shader: Shader::SolidColor(Color::from_rgba8(r, g, b, 255)), ..Paint::default() }
}

/// The chains as paths of at most `batch` chains each, seen from a corner.
fn paths(chains: &[(&[[f32; 2]], bool)], batch: usize, [left, top]: [f32; 2]) -> Vec<Path> {
    let seen = |(chain, closed): &(&'_ [[f32; 2]], bool)| {
        (chain.iter().map(|[x, y]| [x - left, y - top]).collect::<Vec<_>>(), *closed)
    };
    let batches = chains.chunks(batch.min(chains.len().max(1)));
    batches.filter_map(|chains| path_of(chains.iter().map(seen))).collect()
}

/// Lines as one path.
fn path_of(pieces: impl Iterator<Item = Piece>) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for (piece, closed) in pieces {
        builder.move_to(piece[0][0], piece[0][1]);
        piece[1..].iter().for_each(|&[x, y]| builder.line_to(x, y));
        if closed {
            builder.close();
        }
    }
    builder.finish()
}

/// A line that is drawn at once, and whether it returns to its start.
type Piece = (Vec<[f32; 2]>, bool);

/// The parts of chains that lie in a picture of a size, seen from its corner. They end within its rim, where nobody sees how.
fn cut(chains: &[(&[[f32; 2]], bool)], [left, top]: [f32; 2], size: [f64; 2]) -> Vec<Piece> {
    let room = size.map(|side| (2.0, side - 2.0));
    let mut pieces: Vec<Piece> = Vec::new();
    for (chain, closed) in chains {
        let seen = |&[x, y]: &[f32; 2]| [f64::from(x) - f64::from(left), f64::from(y) - f64::from(top)];
        let is_inside = |at: &[f64; 2]| (0..2).all(|axis| (room[axis].0..=room[axis].1).contains(&at[axis]));
        let mut corners: Vec<[f64; 2]> = chain.iter().map(seen).collect();
        if *closed {
            let Some(outside) = corners.iter().position(|at| !is_inside(at)) else {
                pieces.push((corners.iter().map(|at| at.map(|x| x as f32)).collect(), true));
                continue;
            };
            // A ring that begins where nobody sees it has no ends where somebody does.
            corners.rotate_left(outside);
            corners.push(corners[0]);
        }
        let mut goes_on = false;
        for pair in corners.windows(2) {
            let Some((from, to)) = within(pair[0], pair[1], room) else {
                goes_on = false;
                continue;
            };
            let at = |share: f64| [0, 1].map(|axis| (pair[0][axis] + (pair[1][axis] - pair[0][axis]) * share) as f32);
            match pieces.last_mut().filter(|_| goes_on && from == 0.0) {
                Some((piece, _)) => piece.push(at(to)),
                None => pieces.push((vec![at(from), at(to)], false)),
            }
            goes_on = to == 1.0;
        }
    }
    pieces
}

/// The shares of a line between which it lies in a box (Liang and Barsky 1984).
fn within(from: [f64; 2], to: [f64; 2], room: [(f64, f64); 2]) -> Option<(f64, f64)> {
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for axis in 0..2 {
        let (step, (low, high)) = (to[axis] - from[axis], room[axis]);
        if step == 0.0 {
            if !(low..=high).contains(&from[axis]) {
                return None;
            }
            continue;
        }
        let (a, b) = ((low - from[axis]) / step, (high - from[axis]) / step);
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    (enter < leave).then_some((enter, leave))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A page as it is painted in tiles of a side.
    fn painted(pixels: &Pixels, side: u32) -> Pixmap {
        let page = Page::in_tiles(300, 260, side).unwrap();
        pixels.painted(&page, &Cache::none()).joined().unwrap()
    }

    fn chain() -> impl Strategy<Value = (Vec<[f32; 2]>, bool)> {
        // Corners on borders of tiles and just beside them are where it goes wrong.
        let on_border = (0..6u32, -2..=2i32).prop_map(|(cell, quarters)| cell as f32 * 64.0 + quarters as f32 / 4.0);
        let along = prop_oneof![3 => -150.0..450.0f32, 1 => on_border];
        let corner = [along.clone(), along];
        // A ring has three corners at least.
        let chain = (proptest::collection::vec(corner, 2..6), any::<bool>());
        chain.prop_map(|(chain, closed)| (chain.clone(), closed && chain.len() > 2))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]

        #[test]
        fn tiles_show_what_the_page_in_one_piece_shows(
            chains in proptest::collection::vec(chain(), 1..6),
            width in prop_oneof![Just(0.3f32), Just(0.7), Just(1.0), Just(1.6), Just(7.0)],
        ) {
            let mut lines = Lines::default();
            chains.iter().for_each(|(chain, closed)| lines.push(chain.iter().copied(), *closed));
            let mut pixels = Pixels::default();
            pixels.fill(&square(), Colour(255, 255, 255));
            pixels.stroke(&lines, Pen { colour: Colour(0, 0, 0), width, round: true, dash: None });
            let (tiled, whole) = (painted(&pixels, 64), painted(&pixels, 1024));
            // The rasteriser places the ends of thin lines to a 64th of a pixel, the rims of areas to a quarter; where lines
            // cross that adds up. Thin lines that lead astray are 60 to 98 apart.
            let most = if width <= HAIRLINE { 56 } else { 80 };
            let apart = tiled.data().iter().zip(whole.data()).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            prop_assert!(apart <= most, "{apart} of 255 apart");
        }
    }

    fn square() -> Lines {
        let mut lines = Lines::default();
        lines.push([[0.0, 0.0], [300.0, 0.0], [300.0, 260.0], [0.0, 260.0]], true);
        lines
    }

    #[test]
    fn a_line_is_cut_to_what_is_seen_of_it() {
        let line = [[-100.0f32, 50.0], [50.0, 50.0], [50.0, 400.0], [500.0, 400.0]];
        let pieces = cut(&[(&line, false)], [0.0, 0.0], [100.0, 100.0]);
        assert_eq!(pieces, [(vec![[2.0, 50.0], [50.0, 50.0], [50.0, 98.0]], false)]);
        // A ring that is seen whole stays one; of another the part outside is left out.
        let ring = [[10.0f32, 10.0], [90.0, 10.0], [90.0, 90.0]];
        assert_eq!(cut(&[(&ring, true)], [0.0, 0.0], [100.0, 100.0]), [(ring.to_vec(), true)]);
        let pieces = cut(&[(&[[10.0f32, 10.0], [90.0, 10.0], [50.0, 900.0]], true)], [0.0, 0.0], [100.0, 100.0]);
        assert_eq!(pieces.len(), 1, "{pieces:?}");
        assert_eq!(pieces[0].0[1..3], [[10.0, 10.0], [90.0, 10.0]]);
    }
}
