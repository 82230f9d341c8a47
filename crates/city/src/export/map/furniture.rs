//! What stands around the map: frame, title, numbers, legend, scale bar, north arrow, attribution.

use super::canvas::{Align, Canvas, Colour, Lines, Pen, Text, rectangle};
use super::colouring::Colouring;
use super::view::{ROW, View};
use super::{MapOptions, style, title};
use crate::City;
use streets::Class;

/// Width of a letter on average, as a share of the size of the words.
const LETTER: f32 = 0.47;

/// Draws it all, covering what of the map lies outside the frame.
pub fn draw(city: &City, options: &MapOptions, view: &View, colouring: Option<&Colouring>, page: &mut dyn Canvas) {
    page.part("furniture");
    let (corner, size) = view.map();
    let mut outside = Lines::default();
    for rim in [rectangle([0.0, 0.0], [view.width() as f32, view.height() as f32]), rectangle(corner, size)] {
        rim.chains().for_each(|(ring, closed)| outside.push(ring.iter().copied(), closed));
    }
    page.fill(&outside, style::PAPER);
    page.stroke(&rectangle(corner, size), Pen::new(style::INK, view.word() * 0.07));
    let footer = Footer { view, page };
    footer.draw(city, options, colouring);
}

/// The strip below the map.
struct Footer<'a> {
    view: &'a View,
    page: &'a mut dyn Canvas,
}

impl Footer<'_> {
    fn draw(mut self, city: &City, options: &MapOptions, colouring: Option<&Colouring>) {
        let word = self.view.word();
        let (corner, size) = self.view.map();
        let border = word * 1.6;
        let (left, right) = (border, self.view.width() as f32 - border);
        let top = corner[1] + size[1];
        self.words(&title(city, options), [left, top + word * 3.1], 2.5, Align::Start, style::INK, true);
        self.words(&numbers(city), [left, top + word * 4.9], 1.0, Align::Start, style::FAINT_INK, false);
        match colouring {
            Some(colouring) => self.colours(city, colouring, [left, top + word * 7.1]),
            None => self.legend(city, left, top + word * 7.1),
        }
        self.north([right - word * 0.7, top + word * 1.0]);
        self.scale_bar(right - word * 4.2, top + word * 2.4);
        let made = format!("Grown with Plat, seed {}", city.seed);
        let credit = options.attribution.iter().cloned().chain([made]).collect::<Vec<_>>().join(" · ");
        self.words(&credit, [right, top + word * 4.9], 0.85, Align::End, style::FAINT_INK, false);
    }

    /// Words whose size is a multiple of that of plain words.
    fn words(&mut self, words: &str, at: [f32; 2], size: f32, align: Align, colour: Colour, bold: bool) {
        let size = size * self.view.word();
        self.page.text(&Text { words: words.to_owned(), at, size, align, bold, colour });
    }

    fn legend(&mut self, city: &City, left: f32, base: f32) {
        let word = self.view.word();
        let mut x = left;
        for (class, info) in city.graph.classes().iter() {
            if city.runs.iter().any(|run| run.class == class) {
                self.street_sample(city, class, [x, base - word * 0.33]);
                x = self.label(&info.name, x, base);
            }
        }
        for (name, colour) in areas(city) {
            self.swatch(x, base, word * 1.8, colour);
            x = self.label(name, x, base);
        }
        if !city.buildings.is_empty() {
            self.building_tones(x, base);
        }
    }

    /// The colours of streets, row by row, under their heading.
    fn colours(&mut self, city: &City, colouring: &Colouring, [left, base]: [f32; 2]) {
        let word = self.view.word();
        self.words(colouring.heading, [left, base], 0.95, Align::Start, style::INK, true);
        let samples = samples(city, colouring);
        for ((x, row), (name, colour, is_street)) in places(colouring, &samples, self.view).into_iter().zip(samples) {
            let (x, base) = (left + x, base + row as f32 * ROW as f32 * word);
            if is_street {
                let mut line = Lines::default();
                line.push([[x, base - word * 0.33], [x + word * 1.8, base - word * 0.33]], false);
                self.page.stroke(&line, Pen::new(style::rim(colour), word * 0.6).square());
                self.page.stroke(&line, Pen::new(colour, word * 0.46).square());
            } else {
                self.swatch(x, base, word * 1.8, colour);
            }
            self.label(&name, x, base);
        }
    }

    /// The word beside a sample, and where the next sample goes.
    fn label(&mut self, name: &str, x: f32, base: f32) -> f32 {
        let word = self.view.word();
        self.words(name, [x + word * 2.3, base], 0.95, Align::Start, style::INK, false);
        x + label_width(name, word)
    }

    fn street_sample(&mut self, city: &City, class: Class, [x, y]: [f32; 2]) {
        let word = self.view.word();
        let style = style::street_style(city.graph.classes(), class);
        let width = word * 0.09 * (style.least + 2.2);
        let mut line = Lines::default();
        line.push([[x, y], [x + word * 1.8, y]], false);
        self.page.stroke(&line, Pen::new(style.casing, width).square());
        self.page.stroke(&line, Pen::new(style.fill, width * 0.7).square());
    }

    fn swatch(&mut self, x: f32, base: f32, width: f32, colour: Colour) {
        let word = self.view.word();
        let box_ = rectangle([x, base - word * 0.75], [width, word * 0.85]);
        self.page.fill(&box_, colour);
        self.page.stroke(&box_, Pen::new(style::FAINT_INK, word * 0.025));
    }

    /// The tones of buildings side by side, with the heights that part them.
    fn building_tones(&mut self, x: f32, base: f32) {
        let word = self.view.word();
        let step = word * 1.7;
        for tone in 0..=style::TONES.len() {
            self.swatch(x + step * tone as f32, base, step, style::tone_colour(tone));
        }
        for (i, least) in style::TONES.iter().enumerate() {
            let at = [x + step * (i + 1) as f32, base + word * 0.95];
            self.words(&format!("{least}"), at, 0.7, Align::Middle, style::FAINT_INK, false);
        }
        let after = x + step * (style::TONES.len() + 1) as f32 + word * 0.5;
        self.words("building, height in m", [after, base], 0.95, Align::Start, style::INK, false);
    }

    fn north(&mut self, [x, y]: [f32; 2]) {
        let word = self.view.word();
        let mut west = Lines::default();
        west.push([[x, y], [x - word * 0.6, y + word * 1.7], [x, y + word * 1.3]], true);
        let mut east = Lines::default();
        east.push([[x, y], [x + word * 0.6, y + word * 1.7], [x, y + word * 1.3]], true);
        self.page.fill(&west, style::INK);
        self.page.fill(&east, style::PAPER);
        for half in [west, east] {
            self.page.stroke(&half, Pen::new(style::INK, word * 0.06));
        }
        self.words("N", [x, y + word * 2.75], 0.95, Align::Middle, style::INK, true);
    }

    /// A bar of four parts of a round length, ending at `right`.
    fn scale_bar(&mut self, right: f32, top: f32) {
        let word = self.view.word();
        let metres = round_length(f64::from(word) * 14.0 / f64::from(self.view.pixels(1.0)));
        let length = self.view.pixels(metres);
        let (left, height) = (right - length, word * 0.34);
        for part in 0..4u8 {
            let colour = if part % 2 == 0 { style::INK } else { style::PAPER };
            self.page.fill(&rectangle([left + length * f32::from(part) / 4.0, top], [length / 4.0, height]), colour);
        }
        self.page.stroke(&rectangle([left, top], [length, height]), Pen::new(style::INK, word * 0.05));
        for (at, label) in [(left, "0".into()), (left + length / 2.0, measure(metres / 2.0)), (right, measure(metres))]
        {
            self.words(&label, [at, top - word * 0.4], 0.8, Align::Middle, style::INK, false);
        }
    }
}

/// Room that a sample takes with its word and a gap.
fn label_width(name: &str, word: f32) -> f32 {
    word * (2.3 + name.chars().count() as f32 * LETTER + 1.2)
}

/// What of the ground the legend explains.
fn areas(city: &City) -> impl Iterator<Item = (&'static str, Colour)> {
    let has = |name: &str| city.site.map(name).is_some();
    let areas = [
        ("park", style::PARK, has("parks") || city.parcels.iter().any(|parcel| parcel.usage == layout::Use::Park)),
        ("water", style::WATER, has("land")),
        ("block", style::BLOCK, !city.blocks.is_empty()),
    ];
    areas.into_iter().filter(|(.., shown)| *shown).map(|(name, colour, _)| (name, colour))
}

/// What the legend of coloured streets shows: words, colour, and whether it is a street.
fn samples(city: &City, colouring: &Colouring) -> Vec<(String, Colour, bool)> {
    let streets = colouring.entries.iter().map(|entry| (entry.name.clone(), entry.colour, true));
    streets.chain(areas(city).map(|(name, colour)| (name.to_owned(), colour, false))).collect()
}

/// Where the samples go: pixels from the left, and the row.
fn places(colouring: &Colouring, samples: &[(String, Colour, bool)], view: &View) -> Vec<(f32, usize)> {
    let word = view.word();
    let room = view.width() as f32 - word * 3.2;
    let start = word * (colouring.heading.chars().count() as f32 * LETTER + 1.6);
    let (mut x, mut row) = (start, 0);
    let place = |(name, ..): &(String, Colour, bool)| {
        let width = label_width(name, word);
        if x > start && x + width - word * 1.2 > room {
            (x, row) = (start, row + 1);
        }
        x += width;
        (x - width, row)
    };
    samples.iter().map(place).collect()
}

/// Rows that the legend of coloured streets needs.
pub fn legend_rows(city: &City, colouring: &Colouring, view: &View) -> usize {
    let places = places(colouring, &samples(city, colouring), view);
    places.last().map_or(1, |(_, row)| row + 1)
}

/// The largest of 1, 2, 5 times a power of ten that is not above a length in metres.
fn round_length(most: f64) -> f64 {
    let steps = std::iter::successors(Some(1.0), |power| Some(power * 10.0)).take(8);
    let lengths = steps.flat_map(|power| [power, 2.0 * power, 5.0 * power]);
    lengths.take_while(|&length| length <= most).last().unwrap_or(1.0)
}

fn measure(metres: f64) -> String {
    if metres < 1000.0 { format!("{metres} m") } else { format!("{} km", metres / 1000.0) }
}

/// What the city has, in one line.
fn numbers(city: &City) -> String {
    let length: f64 = city
        .runs
        .iter()
        .flat_map(|run| run.nodes.windows(2))
        .map(|pair| city.graph.at(pair[0]).distance(city.graph.at(pair[1])))
        .sum();
    let counts = [(city.blocks.len(), "blocks"), (city.parcels.len(), "parcels"), (city.buildings.len(), "buildings")];
    let counted = counts.into_iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{} {what}", grouped(n)));
    let streets =
        if length < 10_000.0 { format!("{:.1}", length / 1000.0) } else { grouped((length / 1000.0) as usize) };
    std::iter::once(format!("{streets} km of streets")).chain(counted).collect::<Vec<_>>().join(" · ")
}

/// A number with its digits in groups of three.
pub fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{a0}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_round() {
        assert_eq!([0.3, 1.0, 4.9, 730.0, 999_999.0].map(round_length), [1.0, 1.0, 2.0, 500.0, 500_000.0]);
        assert_eq!((measure(250.0), measure(2500.0)), ("250 m".into(), "2.5 km".into()));
    }

    #[test]
    fn digits_are_grouped() {
        assert_eq!([7, 1000, 1_234_567].map(grouped), ["7", "1\u{a0}000", "1\u{a0}234\u{a0}567"]);
    }
}
