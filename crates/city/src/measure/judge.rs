//! Figures held against the ranges that real places lie in.

use super::{Figure, Figures, LayoutFile, MEASURES, Maps, MeasureError, Window, measure};
use crate::sources::nearest_names;
use serde_json::{Map, Value};
use std::fmt;
use std::fs;
use std::path::Path;

/// Degrees that a heading may miss the one it should have.
const HEADING_SLACK: f64 = 3.0;

/// Where a figure should lie.
#[derive(Clone, Debug, PartialEq)]
pub enum Range {
    /// From one number to another, both within.
    Within(f64, f64),
    /// Each of these headings is one of the two strongest, to 3°.
    Headings(Vec<f64>),
}

impl Range {
    /// Whether a figure lies in it.
    pub fn holds(&self, figure: Figure) -> bool {
        match (self, figure) {
            (Self::Within(low, high), Figure::Number(number)) => (*low..=*high).contains(&number),
            (Self::Headings(wanted), Figure::Headings(found)) => {
                wanted.iter().all(|wish| found.iter().any(|other| apart(*wish, *other) <= HEADING_SLACK))
            }
            _ => false,
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Within(low, high) => write!(f, "{low} to {high}"),
            Self::Headings(headings) => {
                let each: Vec<String> = headings.iter().map(ToString::to_string).collect();
                write!(f, "within {HEADING_SLACK}° of {}", each.join(" and "))
            }
        }
    }
}

/// Degrees between two headings, modulo 180.
fn apart(a: f64, b: f64) -> f64 {
    let turn = (a - b).rem_euclid(180.0);
    turn.min(180.0 - turn)
}

/// Measures with their ranges, in the order of the file.
type Wishes = Vec<(String, Range)>;

/// The ranges of one place: for the whole, and for windows of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranges {
    /// The place's name.
    pub place: String,
    whole: Wishes,
    windows: Vec<(String, Window, Wishes)>,
}

/// A figure with its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// The window it was measured in; the whole layout when none.
    pub window: Option<String>,
    /// The measure's name.
    pub measure: String,
    /// What it came to, where it could be measured.
    pub figure: Option<Figure>,
    /// Where it should lie.
    pub range: Range,
}

impl Judged {
    /// Whether it lies where it should.
    pub fn is_good(&self) -> bool {
        self.figure.is_some_and(|figure| self.range.holds(figure))
    }
}

/// A layout held against a place.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The place's name.
    pub place: String,
    /// Every range asked for, the whole first.
    pub judged: Vec<Judged>,
}

impl Verdict {
    /// How many figures lie in their range.
    pub fn good(&self) -> usize {
        self.judged.iter().filter(|judged| judged.is_good()).count()
    }

    /// Whether all do.
    pub fn is_good(&self) -> bool {
        self.good() == self.judged.len()
    }

    /// The verdict as JSON: `name`, `good`, `asked`, and `judged` with `window`, `measure`, `figure`, `range`, `ok`.
    pub fn to_json(&self) -> Value {
        let range = |range: &Range| match range {
            Range::Within(low, high) => vec![*low, *high],
            Range::Headings(headings) => headings.clone(),
        };
        let row = |judged: &Judged| {
            serde_json::json!({
                "window": judged.window,
                "measure": judged.measure,
                "figure": judged.figure.map(Figure::to_json),
                "range": range(&judged.range),
                "ok": judged.is_good(),
            })
        };
        let rows: Vec<Value> = self.judged.iter().map(row).collect();
        serde_json::json!({ "name": self.place, "good": self.good(), "asked": self.judged.len(), "judged": rows })
    }
}

impl Ranges {
    /// Reads the ranges of a place: a JSON object of places, each with `whole` (measures to `[low, high]`, `headings` to
    /// a list of degrees) and `windows` (names to the same with a `window` of west, south, east, north in metres).
    ///
    /// # Errors
    /// [`MeasureError::Ranges`] when the file can't be read, lacks the place, or names a measure that there is not.
    pub fn read(path: &Path, place: &str) -> Result<Self, MeasureError> {
        Self::parse(&fs::read_to_string(path).map_err(|error| bad(path)(error.to_string(), CHECK))?, path, place)
    }

    /// The ranges in a city's folder, `ranges.json`: those of the place that is called like the folder, or of the only one;
    /// `None` where there is no such file.
    ///
    /// # Errors
    /// As [`Ranges::read`].
    pub fn of_folder(folder: &Path) -> Result<Option<Self>, MeasureError> {
        let path = folder.join("ranges.json");
        if !path.is_file() {
            return Ok(None);
        }
        let text = fs::read_to_string(&path).map_err(|error| bad(&path)(error.to_string(), CHECK))?;
        let known: Map<String, Value> = serde_json::from_str(&text).unwrap_or_default();
        let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        let own = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let only = known.keys().next().filter(|_| known.len() == 1 && !known.contains_key(&own));
        Self::parse(&text, &path, only.unwrap_or(&own)).map(Some)
    }

    fn parse(text: &str, path: &Path, place: &str) -> Result<Self, MeasureError> {
        let bad = bad(path);
        let file: Map<String, Value> = serde_json::from_str(text).map_err(|error| bad(error.to_string(), FORM))?;
        let says = file.get(place).ok_or_else(|| {
            let names: Vec<String> = file.keys().cloned().collect();
            bad(format!("there is no place `{place}`"), &suggestion(place, &names))
        })?;
        let part = |value: Option<&Value>, name: &str| match value {
            None => Ok(Map::new()),
            Some(Value::Object(map)) => Ok(map.clone()),
            Some(_) => Err(bad(format!("{place}.{name} must be an object"), FORM)),
        };
        let whole = wishes(&part(says.get("whole"), "whole")?).map_err(|(message, hint)| bad(message, &hint))?;
        let mut windows = Vec::new();
        for (name, value) in part(says.get("windows"), "windows")? {
            let mut map = part(Some(&value), &format!("windows.{name}"))?;
            let window = map.shift_remove("window").and_then(|value| serde_json::from_value(value).ok()).map(Window);
            let lacks = || bad(format!("{place}.windows.{name} needs \"window\": [west, south, east, north]"), FORM);
            let wishes = wishes(&map).map_err(|(message, hint)| bad(message, &hint))?;
            let window = window.ok_or_else(lacks)?;
            windows.push((name, window, wishes));
        }
        if whole.is_empty() && windows.is_empty() {
            return Err(bad(format!("`{place}` asks for nothing"), FORM));
        }
        Ok(Self { place: place.to_owned(), whole, windows })
    }

    /// Holds a layout against the ranges; `figures` are those of the whole.
    ///
    /// # Errors
    /// As [`measure`].
    pub fn judge(&self, file: &LayoutFile, maps: &Maps, figures: &Figures) -> Result<Verdict, MeasureError> {
        let mut judged = judge(None, &self.whole, figures);
        for (name, window, wishes) in &self.windows {
            judged.extend(judge(Some(name), wishes, &measure(file, maps, Some(*window))?));
        }
        Ok(Verdict { place: self.place.clone(), judged })
    }
}

const CHECK: &str = "name a file of ranges, such as {\"my_town\": {\"whole\": {\"order\": [0.6, 0.9]}}}";
const FORM: &str = "ranges are written {\"my_town\": {\"whole\": {\"order\": [0.6, 0.9]}, \"windows\": {\"centre\": \
                    {\"window\": [0, 0, 1000, 1000], \"x_share\": [0.4, 0.9]}}}}";

fn bad(path: &Path) -> impl Fn(String, &str) -> MeasureError {
    move |message, hint| MeasureError::Ranges { path: path.to_owned(), message, hint: hint.to_owned() }
}

fn judge(window: Option<&String>, wishes: &Wishes, figures: &Figures) -> Vec<Judged> {
    let of = |(name, range): &(String, Range)| Judged {
        window: window.cloned(),
        measure: name.clone(),
        figure: figures.get(name),
        range: range.clone(),
    };
    wishes.iter().map(of).collect()
}

/// The ranges of a part, or what is wrong with one and a hint.
fn wishes(map: &Map<String, Value>) -> Result<Wishes, (String, String)> {
    map.iter().map(|(name, value)| Ok((name.clone(), wish(name, value)?))).collect()
}

fn wish(name: &str, value: &Value) -> Result<Range, (String, String)> {
    let names = MEASURES.map(|measure| measure.name.to_owned());
    if !names.iter().any(|known| known == name) {
        return Err((format!("there is no measure `{name}`"), suggestion(name, &names)));
    }
    let numbers: Option<Vec<f64>> = serde_json::from_value(value.clone()).ok();
    match (name, numbers.as_deref()) {
        ("headings", Some(headings)) if !headings.is_empty() => Ok(Range::Headings(headings.to_vec())),
        ("headings", _) => Err((format!("`headings` must be a list of degrees, not {value}"), FORM.into())),
        (_, Some(&[low, high])) if low <= high => Ok(Range::Within(low, high)),
        _ => Err((format!("`{name}` must be [low, high], not {value}"), FORM.into())),
    }
}

fn suggestion(wanted: &str, names: &[String]) -> String {
    let near = nearest_names(wanted, names);
    let listed = |names: &[String], between: &str| {
        names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(between)
    };
    if near.is_empty() {
        format!("there are {}", listed(names, ", "))
    } else {
        format!("did you mean {}?", listed(&near, " or "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Ranges, String> {
        Ranges::parse(text, Path::new("r.json"), "town").map_err(|error| error.to_string())
    }

    #[test]
    fn headings_are_alike_modulo_180() {
        let range = Range::Headings(vec![179.0, 90.0]);
        assert!(range.holds(Figure::Headings([88.5, 1.5])));
        assert!(!range.holds(Figure::Headings([88.5, 4.5])));
        assert!(!range.holds(Figure::Number(90.0)));
    }

    #[test]
    fn what_is_wrong_with_ranges_is_said() {
        for (text, wanted) in [
            ("[]", "invalid type"),
            (r#"{"tow": {}}"#, "did you mean `tow`?"),
            (r#"{"town": {}}"#, "asks for nothing"),
            (r#"{"town": {"whole": {"ordre": [0, 1]}}}"#, "did you mean `order`?"),
            (r#"{"town": {"whole": {"order": [1, 0]}}}"#, "must be [low, high], not [1,0]"),
            (r#"{"town": {"whole": {"headings": 7}}}"#, "list of degrees"),
            (r#"{"town": {"windows": {"a": {"order": [0, 1]}}}}"#, "town.windows.a needs \"window\""),
            (r#"{"town": {"windows": 7}}"#, "town.windows must be an object"),
        ] {
            let message = parse(text).unwrap_err();
            assert!(message.starts_with("r.json: ") && message.contains(wanted), "{message}");
        }
    }
}
