//! A drawn map of a city: land, water, parks, blocks, parcels, buildings and streets, with title, legend and scale.
//!
//! One drawing, two back ends: SVG text, and pixels painted directly, because a hundred thousand buildings would take
//! an SVG reader longer than everything else together.

mod canvas;
mod colouring;
mod contour;
mod furniture;
mod landmarks;
mod layers;
mod pixels;
pub mod style;
mod svg;
mod view;

use crate::{Cache, City};
use canvas::Canvas;
use geom::{Bounds, Digest, Id, Vec2};
use layers::Backdrop;
use pixels::{Page, Pixels};
use std::io::{self, Write};
use std::sync::Arc;
use view::View;

/// What a map may be told.
#[derive(Clone, Debug, PartialEq)]
pub struct MapOptions {
    /// The longer side of the page in pixels; held between 200 and 20 000.
    pub longest_side: u32,
    /// The title; the city's name where there is none.
    pub title: Option<String>,
    /// Whom the maps and streets that came in are owed to.
    pub attribution: Option<String>,
    /// What the streets are coloured by, in place of parcels and buildings; drawn by class as on a street map when none.
    pub colour_by: Option<ColourBy>,
    /// The ground that the map must show; that of the streets when none.
    pub extent: Option<Bounds>,
    /// Places to mark above all else, such as those where rules failed.
    pub marks: Vec<Mark>,
    /// Draws the map alone, up to the rim of the page: no title, legend or scale.
    pub is_bare: bool,
}

/// A place to mark.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Where, in metres.
    pub at: Vec2,
    /// What is written beside it.
    pub words: String,
}

impl Default for MapOptions {
    fn default() -> Self {
        Self {
            longest_side: 3000,
            title: None,
            attribution: None,
            colour_by: None,
            extent: None,
            marks: Vec::new(),
            is_bare: false,
        }
    }
}

pub use canvas::Colour;
pub use colouring::{ColourBy, Colouring, Entry, Stretch};

/// Why a map could not be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MapError {
    /// The page is too large.
    #[error("no page of {width} × {height} pixels can be made")]
    Size {
        /// Pixels.
        width: u32,
        /// Pixels.
        height: u32,
    },
    /// Words could not be set.
    #[error("the words of the map could not be set: {0}")]
    Text(String),
    /// The picture could not be packed.
    #[error("the picture could not be packed: {0}")]
    Png(String),
}

/// Writes the map as SVG. Outlines of the maps of the site are kept in a cache.
///
/// # Errors
/// Those of the writer.
pub fn write_svg(city: &City, options: &MapOptions, cache: &Cache, out: impl Write) -> io::Result<()> {
    let (view, colouring) = prepared(city, options);
    let mut page = svg::Svg::new(out, view.width(), view.height(), &title(city, options));
    draw_ground(city, &backdrop(city, &view, cache), &view, colouring.as_ref(), &mut page);
    draw_rest(city, options, &view, colouring.as_ref(), &mut page);
    page.finish()
}

/// The map as a PNG file. Parts of the picture are kept in a cache, so that only those in which something changed are painted.
///
/// # Errors
/// See [`MapError`].
pub fn png(city: &City, options: &MapOptions, cache: &Cache) -> Result<Vec<u8>, MapError> {
    let (view, colouring) = prepared(city, options);
    let ground = cache.part(ground_key(city, &view, colouring.as_ref()), || {
        let mut steps = Pixels::default();
        draw_ground(city, &backdrop(city, &view, cache), &view, colouring.as_ref(), &mut steps);
        Page::new(view.width(), view.height()).map(|page| steps.painted(&page, cache))
    });
    let mut steps = Pixels::default();
    draw_rest(city, options, &view, colouring.as_ref(), &mut steps);
    let page = steps.painted((*ground).as_ref().map_err(MapError::clone)?, cache);
    steps.finish(&page)
}

/// The outlines of the maps of a city's site on the page.
fn backdrop(city: &City, view: &View, cache: &Cache) -> Arc<Backdrop> {
    let key = city.digests.site.map(|site| Digest::new("backdrop of a map").id(site).value(view).finish());
    cache.part(key, || Backdrop::of(&city.site, view))
}

/// What the ground of a map is kept by.
fn ground_key(city: &City, view: &View, colouring: Option<&Colouring>) -> Option<Id> {
    let mut digest = Digest::new("ground of a map");
    digest.id(city.digests.land?).value(&(view, colouring.is_some()));
    Some(digest.finish())
}

/// The title asked for, or the city's name, which is that of a folder, as words.
pub(super) fn title(city: &City, options: &MapOptions) -> String {
    let words = |name: &str| {
        let name = name.replace('_', " ");
        let mut letters = name.chars();
        letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
    };
    options.title.clone().unwrap_or_else(|| words(&city.name))
}

/// The page, with room for the whole legend, and the colours of the streets.
fn prepared(city: &City, options: &MapOptions) -> (View, Option<Colouring>) {
    let colouring = options.colour_by.map(|by| Colouring::of(city, by));
    let view = View::of(city, options, 1);
    let rows = colouring.as_ref().map_or(1, |colouring| furniture::legend_rows(city, colouring, &view));
    (if rows > 1 { View::of(city, options, rows) } else { view }, colouring)
}

fn draw_ground(city: &City, backdrop: &Backdrop, view: &View, colouring: Option<&Colouring>, page: &mut dyn Canvas) {
    match colouring {
        Some(_) => layers::draw_bare_ground(city, backdrop, view, page),
        None => layers::draw_ground(city, backdrop, view, page),
    }
}

/// What lies on the ground.
fn draw_rest(city: &City, options: &MapOptions, view: &View, colouring: Option<&Colouring>, page: &mut dyn Canvas) {
    match colouring {
        Some(colouring) => layers::draw_coloured(city, view, colouring, page),
        None => layers::draw(city, view, page),
    }
    if !options.is_bare {
        furniture::draw(city, options, view, colouring, page);
    }
    landmarks::draw_marks(&options.marks, view, page);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::samples::small_city;

    fn svg_of(city: &City, options: &MapOptions) -> String {
        let mut out = Vec::new();
        write_svg(city, options, &Cache::none(), &mut out).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn the_svg_is_well_formed_and_has_every_layer() {
        let options = MapOptions { title: Some("Port <Royal> & \"Sons\"".into()), ..MapOptions::default() };
        let text = svg_of(&small_city(), &options);
        let document = resvg::usvg::roxmltree::Document::parse(&text).unwrap();
        let parts: Vec<_> = document.root_element().children().filter_map(|node| node.attribute("id")).collect();
        assert_eq!(parts, ["ground", "heights", "blocks", "parcels", "buildings", "streets", "bridges", "furniture"]);
        assert!(document.descendants().any(|node| node.text() == Some("Port <Royal> & \"Sons\"")));
    }

    #[test]
    fn marks_are_drawn_last_and_none_is_lost() {
        let mark = |x: f64, words: &str| Mark { at: Vec2::new(x, 50.0), words: words.into() };
        let marks = vec![mark(50.0, "own.rhai:4"), mark(-1e6, "far.rhai:1")];
        let text = svg_of(&small_city(), &MapOptions { marks, ..MapOptions::default() });
        let document = resvg::usvg::roxmltree::Document::parse(&text).unwrap();
        let last = document.root_element().children().rfind(|node| node.attribute("id").is_some()).unwrap();
        assert_eq!(last.attribute("id"), Some("marks"));
        for words in ["own.rhai:4", "far.rhai:1"] {
            assert!(last.descendants().any(|node| node.text() == Some(words)), "{words}");
        }
    }

    #[test]
    fn a_city_without_title_is_called_by_its_name() {
        let mut city = small_city();
        city.name = "new_york".into();
        assert_eq!(title(&city, &MapOptions::default()), "New york");
        city.name.clear();
        assert_eq!(title(&city, &MapOptions::default()), "");
    }

    #[test]
    fn maps_are_the_same_every_time() {
        let options = MapOptions { longest_side: 400, ..MapOptions::default() };
        assert_eq!(svg_of(&small_city(), &options), svg_of(&small_city(), &options));
        assert_eq!(png(&small_city(), &options, &Cache::none()), png(&small_city(), &options, &Cache::none()));
    }

    #[test]
    fn kept_ground_is_that_which_would_be_drawn() {
        let (cache, none) = (Cache::in_memory(), Cache::none());
        let mut city = small_city();
        city.digests.land = Some(Id(1));
        let options = MapOptions { longest_side: 400, ..MapOptions::default() };
        let by_class = MapOptions { colour_by: Some(ColourBy::Class), ..options.clone() };
        let larger = MapOptions { longest_side: 500, ..options.clone() };
        for options in [&options, &by_class, &larger, &options] {
            assert!(png(&city, options, &cache) == png(&city, options, &none));
        }
        Arc::make_mut(&mut city.buildings).pop();
        assert!(png(&city, &options, &cache) == png(&city, &options, &none));
        city.digests.land = None;
        Arc::make_mut(&mut city.parcels).pop();
        assert!(png(&city, &options, &cache) == png(&city, &options, &none));
    }

    #[test]
    fn only_what_changed_is_painted_again() {
        let cache = Cache::in_memory();
        let empty = Page::new(1300, 700).unwrap();
        let mut steps = Pixels::default();
        let mut line = |points: [[f32; 2]; 2], colour| {
            let mut lines = canvas::Lines::default();
            lines.push(points, false);
            steps.stroke(&lines, canvas::Pen::new(colour, 4.0));
            steps.painted(&empty, &cache)
        };
        let (red, blue) = (canvas::Colour(200, 0, 0), canvas::Colour(0, 0, 200));
        let first = line([[100.0, 100.0], [200.0, 200.0]], red);
        // Its rim reaches over into the tile on the right.
        let second = line([[300.0, 600.0], [511.0, 600.0]], blue);
        assert_eq!(first.shared_tiles(&second), [true, true, true, false, false, true]);
        assert_eq!(steps.painted(&empty, &cache).shared_tiles(&second), [true; 6]);
    }

    #[test]
    fn pixels_show_what_the_svg_shows() {
        let city = small_city();
        let options = MapOptions { longest_side: 600, ..MapOptions::default() };
        let ours = resvg::tiny_skia::Pixmap::decode_png(&png(&city, &options, &Cache::none()).unwrap()).unwrap();
        let reader = resvg::usvg::Options { fontdb: pixels::fonts(), ..Default::default() };
        let tree = resvg::usvg::Tree::from_str(&svg_of(&city, &options), &reader).unwrap();
        let mut theirs = resvg::tiny_skia::Pixmap::new(ours.width(), ours.height()).unwrap();
        resvg::render(&tree, resvg::tiny_skia::Transform::identity(), &mut theirs.as_mut());
        let pairs = ours.data().iter().zip(theirs.data());
        let apart = pairs.filter(|(a, b)| a.abs_diff(**b) > 48).count();
        // The SVG is rounded to tenths of a pixel, which shows at rims only.
        assert!(apart * 100 < ours.data().len(), "{apart} of {}", ours.data().len());
    }

    #[test]
    fn an_empty_city_has_a_map_too() {
        let mut city = small_city();
        city.runs.clear();
        city.graph = streets::StreetGraph::new(streets::Classes::default()).into();
        (city.blocks, city.parcels, city.buildings) = Default::default();
        assert!(
            !png(&city, &MapOptions { longest_side: 300, ..MapOptions::default() }, &Cache::none()).unwrap().is_empty()
        );
    }
}
