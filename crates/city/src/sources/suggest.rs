//! "Did you mean …": the names nearest to one that is not there.

/// The names of `present` that look like `wanted`, the most alike first, at most three. Names are alike that differ by
/// few letters or where one starts with the other, without regard to case.
pub fn nearest_names(wanted: &str, present: &[String]) -> Vec<String> {
    let wanted = wanted.to_lowercase();
    let allowed = wanted.chars().count() / 3 + 1;
    let mut found: Vec<(usize, &String)> = present
        .iter()
        .map(|name| (likeness(&wanted, &name.to_lowercase()), name))
        .filter(|&(distance, _)| distance <= allowed)
        .collect();
    found.sort();
    found.into_iter().take(3).map(|(_, name)| name.clone()).collect()
}

/// Letters to change, add or drop; 1 where one name starts with the other.
fn likeness(a: &str, b: &str) -> usize {
    let distance = edit_distance(a, b);
    let prefix = !a.is_empty() && !b.is_empty() && (a.starts_with(b) || b.starts_with(a));
    if prefix { distance.min(1) } else { distance }
}

/// Levenshtein distance.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &to) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(from != to);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// A list for a hint: "did you mean `a` or `b`?", else what there is.
pub(super) fn hint_for(wanted: &str, present: &[String]) -> String {
    let near = nearest_names(wanted, present);
    if !near.is_empty() {
        format!("did you mean {}?", listed(&near, " or "))
    } else if present.is_empty() {
        "there are none".to_owned()
    } else {
        format!("there are {}", listed(present, ", "))
    }
}

fn listed(names: &[String], between: &str) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(between)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(list: &[&str]) -> Vec<String> {
        list.iter().map(|&name| name.to_owned()).collect()
    }

    #[test]
    fn edit_distance_of_known_pairs() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("abc", ""), 3);
        assert_eq!(edit_distance("land", "land"), 0);
    }

    #[test]
    fn nearest_come_first_and_strangers_not_at_all() {
        let present = names(&["density", "elevation", "land", "lend", "parks"]);
        assert_eq!(nearest_names("lnd", &present), ["land", "lend"]);
        assert_eq!(nearest_names("Elevaton", &present), ["elevation"]);
        assert_eq!(nearest_names("park", &present), ["parks"]);
        assert!(nearest_names("zebra", &present).is_empty());
    }

    #[test]
    fn hints_read_well() {
        assert_eq!(hint_for("lnd", &names(&["land", "lend"])), "did you mean `land` or `lend`?");
        assert_eq!(hint_for("zebra", &names(&["land", "parks"])), "there are `land`, `parks`");
        assert_eq!(hint_for("zebra", &[]), "there are none");
    }
}
