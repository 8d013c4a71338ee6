//! Names that somebody may have meant, for messages.

/// Names that a message lists.
const LISTED_NAMES: usize = 40;

/// Names that differ by more than this are not suggested: 0 is nothing in common, 1 is equal.
const LEAST_SIMILARITY: f64 = 0.4;

/// The first names of a list, and how many more there are.
pub(crate) fn listed(names: &[&str]) -> String {
    let more = names.len().saturating_sub(LISTED_NAMES);
    let listed: Vec<String> = names.iter().take(LISTED_NAMES).map(|name| format!("{name:?}")).collect();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    if listed.is_empty() { "none".into() } else { format!("{}{more}", listed.join(", ")) }
}

/// The most similar of some names, if one is similar at all; capitals do not count.
pub(crate) fn most_similar<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let name = name.to_lowercase();
    let likeness = |other: &str| strsim::normalized_damerau_levenshtein(&name, &other.to_lowercase());
    let scored = names.map(|other| (likeness(other), other));
    scored.filter(|(score, _)| *score >= LEAST_SIMILARITY).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, other)| other)
}
