//! The page in pixels, by tiny-skia; words by resvg with the shipped font alone, so that no machine's fonts show.

use super::MapError;
use super::canvas::{Canvas, Colour, Lines, Pen, Text};
use super::svg::{head, text_element};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageResult};
use resvg::tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Shader, Stroke, StrokeDash, Transform,
};
use resvg::usvg::{Options, Tree, fontdb};
use std::sync::{Arc, OnceLock};

/// Chains drawn at once: enough to be fast, few enough for the rasteriser's list of edges.
const BATCH: usize = 2_000;

/// A page being painted.
#[derive(Clone, Debug)]
pub struct Pixels {
    page: Pixmap,
    /// Words, written in the end, over everything.
    words: String,
}

impl Pixels {
    /// An empty page of a size in pixels.
    ///
    /// # Errors
    /// When there is no memory for it.
    pub fn new(width: u32, height: u32) -> Result<Self, MapError> {
        let page = Pixmap::new(width, height).ok_or(MapError::Size { width, height })?;
        Ok(Self { page, words: head(width, height) })
    }

    /// The page as a PNG file.
    ///
    /// # Errors
    /// When the words or the file can't be made.
    pub fn finish(mut self) -> Result<Vec<u8>, MapError> {
        self.words.push_str("</svg>");
        let options = Options { fontdb: fonts(), font_family: "Source Sans Pro".into(), ..Options::default() };
        let tree = Tree::from_str(&self.words, &options).map_err(|error| MapError::Text(error.to_string()))?;
        resvg::render(&tree, Transform::identity(), &mut self.page.as_mut());
        encoded(self.page).map_err(|error| MapError::Png(error.to_string()))
    }
}

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
        let paint = paint(colour);
        // Rings of one shape may lie apart in the list, so that a shape with holes must not be parted.
        for path in paths(rings, usize::MAX) {
            self.page.fill_path(&path, &paint, FillRule::EvenOdd, Transform::identity(), None);
        }
    }

    fn stroke(&mut self, lines: &Lines, pen: Pen) {
        let stroke = Stroke {
            width: pen.width,
            line_cap: if pen.round { LineCap::Round } else { LineCap::Butt },
            line_join: LineJoin::Round,
            dash: pen.dash.and_then(|dash| StrokeDash::new(vec![dash, dash], 0.0)),
            ..Stroke::default()
        };
        let paint = paint(pen.colour);
        for path in paths(lines, BATCH) {
            self.page.stroke_path(&path, &paint, &stroke, Transform::identity(), None);
        }
    }

    fn text(&mut self, text: &Text) {
        self.words.push_str(&text_element(text));
    }
}

fn paint(Colour(r, g, b): Colour) -> Paint<'static> {
    Paint { shader: Shader::SolidColor(Color::from_rgba8(r, g, b, 255)), ..Paint::default() }
}

/// The chains as paths of at most `batch` chains each.
fn paths(lines: &Lines, batch: usize) -> Vec<Path> {
    let chains: Vec<_> = lines.chains().collect();
    let path = |chains: &[(&[[f32; 2]], bool)]| {
        let mut builder = PathBuilder::new();
        for (chain, closed) in chains {
            builder.move_to(chain[0][0], chain[0][1]);
            chain[1..].iter().for_each(|&[x, y]| builder.line_to(x, y));
            if *closed {
                builder.close();
            }
        }
        builder.finish()
    };
    chains.chunks(batch.min(chains.len().max(1))).filter_map(path).collect()
}
