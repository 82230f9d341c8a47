//! Values as people and snapshots read them.

use crate::param::{Domain, Param};
use crate::rule::Rule;
use rhai::{Array, Dynamic, Map};

/// A number to at most six decimals: the same text wherever the last digits differ by rounding alone.
pub(super) fn number(value: f64) -> String {
    if !value.is_finite() || value.abs() >= 1e15 {
        return value.to_string();
    }
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}

/// A value on one line.
pub(super) fn line(value: &Dynamic) -> String {
    if let Ok(number_) = value.as_float() {
        return number(number_);
    }
    if let Ok(whole) = value.as_int() {
        return number(whole as f64);
    }
    if let Some(list) = value.read_lock::<Array>() {
        return format!("[{}]", list.iter().map(line).collect::<Vec<_>>().join(", "));
    }
    if let Some(map) = value.read_lock::<Map>() {
        let each: Vec<String> = map.iter().map(|(key, value)| format!("{key}: {}", line(value))).collect();
        return format!("#{{ {} }}", each.join(", "));
    }
    if value.is_string() {
        return format!("\"{}\"", value.clone().into_string().unwrap_or_default());
    }
    if value.is_unit() { "()".into() } else { value.to_string() }
}

/// A value of several lines: one for each element of a list, each key of a map.
pub(super) fn text(value: &Dynamic) -> String {
    if let Some(list) = value.read_lock::<Array>() {
        return list.iter().map(|value| line(value) + "\n").collect();
    }
    if let Some(map) = value.read_lock::<Map>() {
        return map.iter().map(|(key, value)| format!("{key}: {}\n", line(value))).collect();
    }
    if value.is_string() {
        return value.clone().into_string().unwrap_or_default() + "\n";
    }
    line(value) + "\n"
}

/// The parameters of a rule: a line each, with default, unit, range and help.
pub(super) fn parameters(rule: &Rule) -> String {
    rule.params().iter().map(|(param, value)| format!("{} = {value}{}\n", param.name, described(param))).collect()
}

fn described(param: &Param) -> String {
    let domain = match &param.domain {
        Domain::Number { unit, range: (low, high) } => format!("{}, {low} to {high}", unit.suffix()),
        Domain::Whole { range: (low, high) } => format!(" whole, {low} to {high}"),
        Domain::Choice(words) => format!(" of {}", words.join(", ")),
        Domain::Flag => " flag".into(),
        Domain::Map => " map".into(),
        Domain::Colour => " colour".into(),
    };
    format!("{domain}: {}", param.about)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_decimals_at_most() {
        let cases = [(1.0, "1"), (0.1 + 0.2, "0.3"), (-1e-9, "0"), (123.456_789_1, "123.456789"), (1e300, "1e300")];
        for (value, text) in cases {
            let told = number(value);
            assert!(told == text || (value == 1e300 && told.starts_with('1')), "{told}");
        }
        assert_eq!(number(f64::INFINITY), "inf");
    }

    #[test]
    fn a_list_has_a_line_for_each_element() {
        let map = Dynamic::from(Map::from([("b".into(), Dynamic::from(2_i64)), ("a".into(), Dynamic::from(0.5))]));
        assert_eq!(text(&Dynamic::from(vec![map.clone(), Dynamic::UNIT])), "#{ a: 0.5, b: 2 }\n()\n");
        assert_eq!(text(&map), "a: 0.5\nb: 2\n");
    }
}
