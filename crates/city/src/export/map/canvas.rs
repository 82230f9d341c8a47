//! What a map is drawn with: lines, areas and words on a page, for whichever back end.

/// A colour of the page, opaque.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub u8, pub u8, pub u8);

impl Colour {
    /// The colour a share of the way to another; 0 is this one.
    #[must_use]
    pub fn towards(self, other: Self, share: f32) -> Self {
        let mix = |a: u8, b: u8| (f32::from(a) + (f32::from(b) - f32::from(a)) * share).round() as u8;
        Self(mix(self.0, other.0), mix(self.1, other.1), mix(self.2, other.2))
    }
}

/// Chains of points in pixels, x right and y down.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lines {
    points: Vec<[f32; 2]>,
    /// Where each chain ends in `points`, and whether it returns to its start.
    ends: Vec<(usize, bool)>,
}

impl Lines {
    /// Adds a chain; `closed` for a ring, whose first point is not repeated. Chains of fewer than two points vanish.
    pub fn push(&mut self, points: impl IntoIterator<Item = [f32; 2]>, closed: bool) {
        let start = self.points.len();
        self.points.extend(points);
        if self.points.len() < start + 2 {
            self.points.truncate(start);
        } else {
            self.ends.push((self.points.len(), closed));
        }
    }

    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The chains with whether they are closed.
    pub fn chains(&self) -> impl Iterator<Item = (&[[f32; 2]], bool)> {
        let starts = std::iter::once(0).chain(self.ends.iter().map(|&(end, _)| end));
        starts.zip(&self.ends).map(|(start, &(end, closed))| (&self.points[start..end], closed))
    }
}

/// A rectangle as a ring.
pub fn rectangle([x, y]: [f32; 2], [width, height]: [f32; 2]) -> Lines {
    let mut lines = Lines::default();
    lines.push([[x, y], [x + width, y], [x + width, y + height], [x, y + height]], true);
    lines
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// Its colour.
    pub colour: Colour,
    /// Its width in pixels.
    pub width: f32,
    /// Whether ends are round, or cut square at the last point.
    pub round: bool,
    /// Length of dashes and gaps in pixels, for a broken line.
    pub dash: Option<f32>,
}

impl Pen {
    /// An unbroken line with round ends.
    pub fn new(colour: Colour, width: f32) -> Self {
        Self { colour, width, round: true, dash: None }
    }

    /// The same with ends cut square.
    #[must_use]
    pub fn square(self) -> Self {
        Self { round: false, ..self }
    }
}

/// Where a text stands relative to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Align {
    /// To the right of it.
    Start,
    /// Around it.
    Middle,
    /// To the left of it.
    End,
}

/// Words on the page.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    /// The words.
    pub words: String,
    /// Where the base line is, in pixels.
    pub at: [f32; 2],
    /// Height of the font in pixels.
    pub size: f32,
    /// Where the words stand.
    pub align: Align,
    /// Whether in the heavier cut.
    pub bold: bool,
    /// Their colour.
    pub colour: Colour,
}

/// A page to draw on. What is drawn later covers what was drawn before; areas are filled by the even-odd rule.
pub trait Canvas {
    /// Starts a part of the picture, named for those who edit it.
    fn part(&mut self, name: &str);
    /// Fills the rings.
    fn fill(&mut self, rings: &Lines, colour: Colour);
    /// Draws the lines.
    fn stroke(&mut self, lines: &Lines, pen: Pen);
    /// Writes words.
    fn text(&mut self, text: &Text);
}
