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
    tiles: Vec<Arc<Tile>>,
}

#[derive(Clone, Debug)]
struct Tile {
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
        let corners = (0..height).step_by(TILE as usize);
        let corners = corners.flat_map(|y| (0..width).step_by(TILE as usize).map(move |x| [x, y]));
        let tile = |[x, y]: [u32; 2]| {
            let pixels = Pixmap::new(TILE.min(width - x), TILE.min(height - y))?;
            let digest = Digest::new("tile of a page").value(&(x, y, pixels.width(), pixels.height())).finish();
            Some(Arc::new(Tile { pixels, digest }))
        };
        let tiles = corners.map(tile).collect::<Option<_>>().ok_or(MapError::Size { width, height })?;
        Ok(Self { width, height, tiles })
    }

    fn columns(&self) -> usize {
        self.width.div_ceil(TILE) as usize
    }

    /// Upper left corner of a tile.
    fn corner(&self, tile: usize) -> [u32; 2] {
        [(tile % self.columns()) as u32 * TILE, (tile / self.columns()) as u32 * TILE]
    }

    /// The tiles that a box of pixels may touch.
    fn touched(&self, low: [f32; 2], high: [f32; 2]) -> impl Iterator<Item = usize> + use<> {
        let columns = self.columns();
        let of = |axis: usize, count: usize| {
            let cell = |at: f32| (at / TILE as f32).floor();
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
            for (i, row) in tile.pixels.data().chunks_exact(row_of_tile).enumerate() {
                let start = (y + i) * row_of + x * 4;
                whole.data_mut()[start..start + row_of_tile].copy_from_slice(row);
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
        let [x, y] = corner.map(|at| at as f32);
        for (index, chains) in share {
            let step = &self.steps[*index];
            let paint = paint(step.colour);
            match step.pen {
                // Rings of one shape may lie apart in the list, so that a shape with holes must not be parted.
                None => paths(chains, usize::MAX, [x, y]).iter().for_each(|path| {
                    pixels.fill_path(path, &paint, FillRule::EvenOdd, Transform::identity(), None);
                }),
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
    let path = |chains: &[(&[[f32; 2]], bool)]| {
        let mut builder = PathBuilder::new();
        for (chain, closed) in chains {
            builder.move_to(chain[0][0] - left, chain[0][1] - top);
            chain[1..].iter().for_each(|&[x, y]| builder.line_to(x - left, y - top));
            if *closed {
                builder.close();
            }
        }
        builder.finish()
    };
    chains.chunks(batch.min(chains.len().max(1))).filter_map(path).collect()
}
