//! Where things come to lie on the page.

use super::MapOptions;
use crate::City;
use geom::point::units;
use geom::{Bounds, Point, Vec2};

/// Room around the city, as a share of its longer side.
const MARGIN: f64 = 0.03;

/// Least room around the city in metres.
const LEAST_MARGIN_M: f64 = 30.0;

/// A page is at least this wide for its height, so that title and legend have room.
const LEAST_ASPECT: f64 = 0.62;

/// Height of a further row of the legend, as a multiple of plain words.
pub const ROW: f64 = 1.5;

/// The ground that a page shows, and its scale.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// South-west corner of the map in metres.
    low: Vec2,
    /// North-east corner of the map in metres.
    high: Vec2,
    /// Pixels to the metre.
    scale: f64,
    /// Upper left corner of the map on the page.
    corner: [f32; 2],
    /// Size of the page in pixels.
    page: [u32; 2],
    /// The size of plain words in pixels, from which the furniture takes its measures.
    word: f32,
}

impl View {
    /// The view of a whole city with its surroundings, on a page as the options say, with so many rows of legend.
    pub fn of(city: &City, options: &MapOptions, rows: usize) -> Self {
        let longest = f64::from(options.longest_side.clamp(200, 20_000));
        let bounds = shown(city, options.extent);
        let (low, size) = (bounds.min.metres(), bounds.size().max(Vec2::ONE));
        let word = (longest / 105.0) as f32;
        let (border, footer) = match options.is_bare {
            true => (0.0, 0.0),
            false => (f64::from(word) * 1.6, f64::from(word) * (9.0 + ROW * (rows.max(1) - 1) as f64)),
        };
        let room = Vec2::new(longest - 2.0 * border, longest - border - footer);
        let scale = (room / size).min_element().max(f64::MIN_POSITIVE);
        let map = size * scale;
        let height = map.y + border + footer;
        let least = if options.is_bare { 0.0 } else { LEAST_ASPECT * height };
        let width = (map.x + 2.0 * border).max(least);
        let corner = [((width - map.x) / 2.0) as f32, border as f32];
        let page = [width.ceil() as u32, height.ceil() as u32];
        Self { low, high: low + size, scale, corner, page, word }
    }

    /// Width of the page in pixels.
    pub fn width(&self) -> u32 {
        self.page[0]
    }

    /// Height of the page in pixels.
    pub fn height(&self) -> u32 {
        self.page[1]
    }

    /// The size of plain words in pixels.
    pub fn word(&self) -> f32 {
        self.word
    }

    /// Upper left corner and size of the map on the page.
    pub fn map(&self) -> ([f32; 2], [f32; 2]) {
        let size = (self.high - self.low) * self.scale;
        (self.corner, [size.x as f32, size.y as f32])
    }

    /// Where a place in metres lies on the page.
    pub fn place(&self, at: Vec2) -> [f32; 2] {
        let x = (at.x - self.low.x) * self.scale;
        let y = (self.high.y - at.y) * self.scale;
        [self.corner[0] + x as f32, self.corner[1] + y as f32]
    }

    /// Where a lattice point lies on the page.
    pub fn point(&self, at: Point) -> [f32; 2] {
        self.place(at.metres())
    }

    /// A length in metres as pixels.
    pub fn pixels(&self, metres: f64) -> f32 {
        (metres * self.scale) as f32
    }

    /// The place in metres of a point of the map that lies so many pixels from its upper left corner.
    pub fn ground(&self, [x, y]: [f64; 2]) -> Vec2 {
        Vec2::new(self.low.x + x / self.scale, self.high.y - y / self.scale)
    }
}

/// What the map shows: the city with a margin, wide enough for the page, within the site; the whole site when there is
/// no city.
fn shown(city: &City, extent: Option<Bounds>) -> Bounds {
    let site = city.site.bounds;
    let Some(bounds) = extent.or(city.graph.bounds()) else { return site };
    let margin = (bounds.size().max_element() * MARGIN).max(LEAST_MARGIN_M);
    let grown = bounds.grown(units(margin));
    let wish = grown.size().y * LEAST_ASPECT;
    let missing = units((wish - grown.size().x).max(0.0) / 2.0);
    let wide = Bounds {
        min: Point::new(grown.min.x.saturating_sub(missing), grown.min.y),
        max: Point::new(grown.max.x.saturating_add(missing), grown.max.y),
    };
    within(wide, site, bounds)
}

/// `wish` cut to the site, but never to less than what must be shown.
fn within(wish: Bounds, site: Bounds, must: Bounds) -> Bounds {
    let (low, high) = (site.min, site.max);
    Bounds {
        min: Point::new(wish.min.x.max(low.x).min(must.min.x), wish.min.y.max(low.y).min(must.min.y)),
        max: Point::new(wish.max.x.min(high.x).max(must.max.x), wish.max.y.min(high.y).max(must.max.y)),
    }
}
