//! "Did you mean …": the name nearest to one that is not there.

/// Longer names, in bytes, are near to none: to compare two of a million letters takes more memory than there is.
const LONGEST: usize = 100;

/// The name of `present` most like `wanted`, if any is near: few letters changed, or one starts with the other. Of equally
/// near names the first in alphabetical order.
pub fn nearest<'a>(wanted: &str, present: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if wanted.len() > LONGEST {
        return None;
    }
    let folded = wanted.to_lowercase();
    let allowed = (folded.chars().count() + 1) / 3;
    present
        .into_iter()
        .filter(|name| name.len() <= LONGEST)
        .map(|name| (likeness(&folded, &name.to_lowercase()), name))
        .filter(|&(distance, name)| distance <= allowed && name != wanted)
        .min()
        .map(|(_, name)| name)
}

/// A hint: "did you mean `x`?", else the names there are, else none.
pub(crate) fn hint<'a>(wanted: &str, present: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let mut all: Vec<&str> = present.into_iter().collect();
    if let Some(name) = nearest(wanted, all.iter().copied()) {
        return Some(format!("did you mean `{name}`?"));
    }
    all.sort_unstable();
    all.dedup();
    (!all.is_empty()).then(|| format!("there are {}", listed(&all)))
}

/// Names as `a`, `b`, `c`.
pub(crate) fn listed(names: &[&str]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

/// Letters to change, add, drop or swap; 1 where one name starts with the other.
fn likeness(a: &str, b: &str) -> usize {
    let distance = edit_distance(a, b);
    let prefix = a.len() > 2 && b.len() > 2 && (a.starts_with(b) || b.starts_with(a));
    if prefix { distance.min(1) } else { distance }
}

/// Damerau–Levenshtein distance with adjacent swaps (optimal string alignment).
fn edit_distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let width = b.len() + 1;
    let mut table = vec![0; (a.len() + 1) * width];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            table[i * width + j] = cell(&table, &a, &b, i, j);
        }
    }
    table[a.len() * width + b.len()]
}

fn cell(table: &[usize], a: &[char], b: &[char], i: usize, j: usize) -> usize {
    let at = |i: usize, j: usize| table[i * (b.len() + 1) + j];
    if i == 0 || j == 0 {
        return i + j;
    }
    let replaced = at(i - 1, j - 1) + usize::from(a[i - 1] != b[j - 1]);
    let least = replaced.min(at(i - 1, j) + 1).min(at(i, j - 1) + 1);
    let swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
    if swapped { least.min(at(i - 2, j - 2) + 1) } else { least }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_of_known_pairs() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("widht", "width"), 1);
        assert_eq!(edit_distance("", "abc"), 3);
    }

    #[test]
    fn the_nearest_is_found_and_strangers_are_not() {
        let present = ["steer", "ahead", "branch_left", "branch_right"];
        assert_eq!(nearest("aheda", present), Some("ahead"));
        assert_eq!(nearest("branch_lft", present), Some("branch_left"));
        assert_eq!(nearest("branch", present), Some("branch_left"));
        assert_eq!(nearest("zzzzzz", present), None);
        assert_eq!(hint("zz", ["b", "a"]).as_deref(), Some("there are `a`, `b`"));
        assert_eq!(hint("zz", []), None);
        let long = "x".repeat(1_000_000);
        assert_eq!((nearest(&long, [long.as_str(), "x"]), nearest("x", [long.as_str()])), (None, None));
    }
}
