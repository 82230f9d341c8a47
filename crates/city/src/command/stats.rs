//! `plat stats`.

use super::{Failure, StatsArguments, Status};
use city::export::read_layout;
use city::measure::{Figure, Figures, Judged, MEASURES, Maps, Measure, MeasureError, Ranges, Verdict, Window, measure};
use std::fmt::Write;

/// Measures a layout, and holds the figures against a place where one is named.
pub fn run(arguments: &StatsArguments) -> Result<Status, Failure> {
    let ranges = arguments.ranges.as_deref().zip(arguments.place.as_deref());
    let ranges = ranges.map(|(path, place)| Ranges::read(path, place)).transpose()?;
    let file = read_layout(&arguments.layout).map_err(|error| Failure::new(Status::Failed, error.to_string()))?;
    let maps = arguments.maps.as_deref().map(|folder| Maps::read(folder, arguments.mask.as_deref())).transpose()?;
    let maps = maps.unwrap_or_default();
    let figures = measure(&file, &maps, arguments.window)?;
    let verdict = ranges.map(|ranges| ranges.judge(&file, &maps, &figures)).transpose()?;
    if arguments.json {
        println!("{}", as_json(&figures, verdict.as_ref()));
    } else {
        print!("{}", as_table(&figures, verdict.as_ref()));
    }
    if figures.is_empty() {
        eprintln!("plat: nothing was measured: the middle of no street lies inside the mask and the window");
        return Ok(Status::Faults);
    }
    let is_good = verdict.is_none_or(|verdict| verdict.is_good());
    Ok(if is_good { Status::Done } else { Status::Faults })
}

impl From<MeasureError> for Failure {
    fn from(error: MeasureError) -> Self {
        Self::new(Status::Failed, error.to_string())
    }
}

/// Reads `--window`.
pub fn parse_window(text: &str) -> Result<Window, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse::<f64>()).collect();
    match numbers.as_deref() {
        Ok(&[west, south, east, north]) if west < east && south < north => Ok(Window([west, south, east, north])),
        Ok([_, _, _, _]) => Err("the second corner must lie north-east of the first".into()),
        _ => Err("give four numbers in metres: west,south,east,north".into()),
    }
}

fn as_json(figures: &Figures, verdict: Option<&Verdict>) -> serde_json::Value {
    let mut object = figures.to_json();
    if let Some(verdict) = verdict {
        object.insert("place".into(), verdict.to_json());
    }
    object.into()
}

fn as_table(figures: &Figures, verdict: Option<&Verdict>) -> String {
    let mut text = String::new();
    let judged: &[Judged] = verdict.map_or(&[], |verdict| &verdict.judged);
    let of_whole = |name: &str| judged.iter().find(|judged| judged.window.is_none() && judged.measure == name);
    for measure in &MEASURES {
        let (figure, judged) = (figures.get(measure.name), of_whole(measure.name));
        if figure.is_some() || judged.is_some() {
            row(&mut text, measure, figure, judged, verdict.is_some());
        }
    }
    let in_windows: Vec<&Judged> = judged.iter().filter(|judged| judged.window.is_some()).collect();
    for window in in_windows.chunk_by(|a, b| a.window == b.window) {
        let _ = writeln!(text, "{}", window[0].window.as_deref().unwrap_or_default());
        for judged in window {
            if let Some(measure) = MEASURES.iter().find(|measure| measure.name == judged.measure) {
                row(&mut text, measure, judged.figure, Some(judged), true);
            }
        }
    }
    if let Some(verdict) = verdict {
        let (good, asked) = (verdict.good(), verdict.judged.len());
        let _ = writeln!(text, "{}: {good} of {asked} measures in the real range", verdict.place);
    }
    text
}

/// One line of the table, with a column for marks where anything is judged.
fn row(text: &mut String, measure: &Measure, figure: Option<Figure>, judged: Option<&Judged>, is_judging: bool) {
    let mark = judged.map_or("", |judged| if judged.is_good() { "ok" } else { "OFF" });
    let shown = figure.map_or("not measured".to_owned(), |figure| shown(figure, measure.unit));
    let range = judged.map_or_else(|| measure.about.to_owned(), |judged| judged.range.to_string());
    let mark = if is_judging { format!("{mark:<4}") } else { String::new() };
    let _ = writeln!(text, "{mark}{:<18} {shown:<16} {range}", measure.name);
}

fn shown(figure: Figure, unit: &str) -> String {
    let space = if unit.is_empty() || unit == "°" { "" } else { " " };
    let number = match figure {
        Figure::Number(number) => digits(number),
        Figure::Headings([first, second]) => return format!("{first}{unit}, {second}{unit}"),
    };
    format!("{number}{space}{unit}")
}

/// Four digits that count, no more.
fn digits(number: f64) -> String {
    let whole = number.abs().max(1e-9);
    let decimals = [1000.0, 100.0, 10.0, 1.0, 0.1].iter().position(|&least| whole >= least).unwrap_or(5);
    format!("{number:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_four_numbers_from_south_west_to_north_east() {
        assert_eq!(parse_window("1, 2,3.5,4"), Ok(Window([1.0, 2.0, 3.5, 4.0])));
        assert!(parse_window("1,2,3").unwrap_err().contains("four numbers"));
        assert!(parse_window("1,2,x,4").unwrap_err().contains("four numbers"));
        assert!(parse_window("3,2,1,4").unwrap_err().contains("north-east"));
    }

    #[test]
    fn figures_show_four_digits() {
        assert_eq!(
            [1625.34, 89.412, 0.53128, 0.0, 12345.6].map(digits),
            ["1625", "89.41", "0.5313", "0.00000", "12346"]
        );
    }
}
