//! Landmarks on the map, and what else it was told to mark: a diamond on each, with its name.

use super::canvas::{Align, Canvas, Colour, Lines, Pen, Text};
use super::view::View;
use super::{Mark, style};
use crate::City;
use geom::Polygon;

/// Size of the names, as a share of plain words.
const NAME: f32 = 0.85;
/// Half of the mark's width, as a share of plain words.
const MARK: f32 = 0.36;
/// Width of a letter on average, as a share of the size of its word.
const LETTER: f32 = 0.5;

/// Draws the marks, then the names. Nothing where the city has no landmark.
pub fn draw(city: &City, view: &View, page: &mut dyn Canvas) {
    if city.landmarks.is_empty() {
        return;
    }
    page.part("landmarks");
    for landmark in &city.landmarks {
        let rim = outline(&landmark.ground, view);
        page.stroke(&rim, Pen::new(style::LANDMARK, view.word() * 0.06));
    }
    let (corner, size) = view.map();
    for landmark in &city.landmarks {
        let [x, y] = view.place(landmark.at);
        // The frame covers what lies outside; a name beside a mark there would not be covered.
        if x >= corner[0] && x <= corner[0] + size[0] && y >= corner[1] && y <= corner[1] + size[1] {
            mark(&landmark.name, style::LANDMARK, [x, y], view, page);
        }
    }
}

/// Draws marks that the map was told of, above all else.
pub fn draw_marks(marks: &[Mark], view: &View, page: &mut dyn Canvas) {
    if marks.is_empty() {
        return;
    }
    page.part("marks");
    let (corner, size) = view.map();
    for told in marks {
        let [x, y] = view.place(told.at);
        // What happened outside is shown at the rim.
        let inside = |at: f32, low: f32, extent: f32| at.clamp(low, low + extent);
        let at = [inside(x, corner[0], size[0]), inside(y, corner[1], size[1])];
        mark(&told.words, style::MARK, at, view, page);
    }
}

fn outline(ground: &Polygon, view: &View) -> Lines {
    let mut lines = Lines::default();
    lines.push(ground.outer.iter().map(|&corner| view.point(corner)), true);
    lines
}

/// A diamond, and the name on the side where there is room, on a pale ground of its own.
fn mark(words: &str, colour: Colour, [x, y]: [f32; 2], view: &View, page: &mut dyn Canvas) {
    let (word, half) = (view.word(), view.word() * MARK);
    let mut diamond = Lines::default();
    diamond.push([[x - half, y], [x, y - half], [x + half, y], [x, y + half]], true);
    page.fill(&diamond, colour);
    page.stroke(&diamond, Pen::new(style::PAPER, word * 0.08));
    let size = word * NAME;
    let length = size * LETTER * words.chars().count() as f32;
    let (corner, extent) = view.map();
    let is_left = x + half * 2.0 + length > corner[0] + extent[0];
    let beside = half * 1.8;
    let (at, align) = if is_left { (x - beside, Align::End) } else { (x + beside, Align::Start) };
    let text = |at: [f32; 2], colour| Text { words: words.to_owned(), at, size, align, bold: true, colour };
    let base = y + size * 0.34;
    // A halo, so that the name is read over streets and houses.
    let off = word * 0.07;
    for (dx, dy) in
        [(-1.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0), (-0.7, -0.7), (0.7, -0.7), (-0.7, 0.7), (0.7, 0.7)]
    {
        page.text(&text([at + dx * off, base + dy * off], style::PAPER));
    }
    page.text(&text([at, base], colour));
}
