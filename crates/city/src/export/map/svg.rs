//! The page as SVG text: whole numbers in tenths of a pixel, relative steps, one path for each colour.

use super::canvas::{Align, Canvas, Colour, Lines, Pen, Text};
use std::fmt::Write as _;
use std::io::{self, Write};

/// Units of the view box to the pixel.
const UNITS: f32 = 10.0;

/// The family name of the shipped font, then what may stand in for it.
const FAMILIES: &str = "Source Sans Pro,Source Sans 3,Helvetica,Arial,sans-serif";

/// A page being written as SVG.
pub struct Svg<W: Write> {
    out: W,
    in_part: bool,
    /// The first error; what comes after it is not written.
    result: io::Result<()>,
}

impl<W: Write> Svg<W> {
    /// Starts a page of a size in pixels.
    pub fn new(mut out: W, width: u32, height: u32, title: &str) -> Self {
        let head = format!("{}<title>{}</title>\n", head(width, height), escaped(title));
        let result = out.write_all(head.as_bytes());
        Self { out, in_part: false, result }
    }

    /// Ends the page.
    ///
    /// # Errors
    /// The first error of the writer.
    pub fn finish(mut self) -> io::Result<()> {
        if self.in_part {
            self.put("</g>\n");
        }
        self.put("</svg>\n");
        self.result?;
        self.out.flush()
    }

    fn put(&mut self, text: &str) {
        if self.result.is_ok() {
            self.result = self.out.write_all(text.as_bytes());
        }
    }
}

/// The opening tag of a page of a size in pixels.
pub fn head(width: u32, height: u32) -> String {
    let (w, h) = (width as f32 * UNITS, height as f32 * UNITS);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {w} {h}\" \
         fill-rule=\"evenodd\" stroke-linejoin=\"round\" font-family=\"{FAMILIES}\">\n"
    )
}

/// The element of a text.
pub fn text_element(text: &Text) -> String {
    let anchor = match text.align {
        Align::Start => "start",
        Align::Middle => "middle",
        Align::End => "end",
    };
    let [x, y] = text.at.map(units);
    let weight = if text.bold { " font-weight=\"600\"" } else { "" };
    let (size, fill, words) = (units(text.size), hex(text.colour), escaped(&text.words));
    format!(
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\"{weight} text-anchor=\"{anchor}\" fill=\"{fill}\">{words}</text>\n"
    )
}

impl<W: Write> Canvas for Svg<W> {
    fn part(&mut self, name: &str) {
        let close = if std::mem::replace(&mut self.in_part, true) { "</g>\n" } else { "" };
        self.put(&format!("{close}<g id=\"{}\">\n", escaped(name)));
    }

    fn fill(&mut self, rings: &Lines, colour: Colour) {
        if !rings.is_empty() {
            self.put(&format!("<path fill=\"{}\" d=\"{}\"/>\n", hex(colour), path_data(rings)));
        }
    }

    fn stroke(&mut self, lines: &Lines, pen: Pen) {
        if lines.is_empty() {
            return;
        }
        let cap = if pen.round { " stroke-linecap=\"round\"" } else { "" };
        let dash = pen.dash.map_or(String::new(), |dash| format!(" stroke-dasharray=\"{}\"", units(dash)));
        let (colour, width) = (hex(pen.colour), units(pen.width));
        let data = path_data(lines);
        self.put(&format!(
            "<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"{cap}{dash} d=\"{data}\"/>\n"
        ));
    }

    fn text(&mut self, text: &Text) {
        self.put(&text_element(text));
    }
}

fn units(pixels: f32) -> i32 {
    (pixels * UNITS).round() as i32
}

fn hex(Colour(r, g, b): Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Chains as relative moves; points that fall on the one before in whole units are left out.
fn path_data(lines: &Lines) -> String {
    let mut data = String::new();
    let mut at = [0, 0];
    for (chain, closed) in lines.chains() {
        let points = chain.iter().map(|point| point.map(units));
        let mut start = None;
        for point in points {
            let step = [point[0] - at[0], point[1] - at[1]];
            if start.is_none() {
                push_step(&mut data, "m", step);
                start = Some(point);
            } else if step != [0, 0] {
                push_step(&mut data, " ", step);
            }
            at = point;
        }
        if closed {
            data.push('z');
            at = start.unwrap_or(at);
        }
    }
    data
}

fn push_step(data: &mut String, before: &str, [x, y]: [i32; 2]) {
    // A minus sign parts numbers by itself.
    let before = if before == " " && x < 0 { "" } else { before };
    let between = if y < 0 { "" } else { " " };
    write!(data, "{before}{x}{between}{y}").expect("writing to a string");
}

/// Text as XML: with its five characters escaped, and without control characters, which XML can't hold.
fn escaped(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&apos;"),
            control if control.is_control() || matches!(control, '\u{fffe}' | '\u{ffff}') => safe.push(' '),
            other => safe.push(other),
        }
    }
    safe
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_relative_and_start_over_after_closing() {
        let mut lines = Lines::default();
        lines.push([[1.0, 1.0], [3.0, 1.0], [3.0, 1.01], [3.0, 0.5]], true);
        lines.push([[1.5, 1.0], [1.5, 2.0]], false);
        assert_eq!(path_data(&lines), "m10 10 20 0 0-5zm5 0 0 10");
    }

    #[test]
    fn words_are_escaped() {
        assert_eq!(escaped("a<b & \"c\"\u{1}"), "a&lt;b &amp; &quot;c&quot; ");
    }
}
