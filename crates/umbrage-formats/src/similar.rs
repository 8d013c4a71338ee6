//! Names that somebody may have meant, for messages.

use std::collections::BTreeSet;

use crate::text::shortened;

/// Names that a message lists.
const LISTED_NAMES: usize = 40;

/// Names that differ by more than this are not suggested: 0 is nothing in common, 1 is equal.
const LEAST_SIMILARITY: f64 = 0.4;

/// Names that are compared, and of each so many characters: files have hundreds of thousands of names, and names of megabytes.
const COMPARED_NAMES: usize = 10_000;
const COMPARED_CHARACTERS: usize = 64;

/// What a message says where `name` is none of `names`: the most similar of these, as part of a sentence, and the first of them.
pub(crate) fn alike<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> (String, String) {
    let mut seen = BTreeSet::new();
    let names: Vec<&str> = names.filter(|name| seen.insert(*name)).collect();
    let like = most_similar(name, names.iter().copied());
    let like = like.map_or(String::new(), |like| format!(", perhaps {:?} is meant", shortened(like)));
    (like, listed(&names))
}

/// The first names of a list, and how many more there are.
fn listed(names: &[&str]) -> String {
    let more = names.len().saturating_sub(LISTED_NAMES);
    let listed: Vec<String> = names.iter().take(LISTED_NAMES).map(|name| format!("{:?}", shortened(name))).collect();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    if listed.is_empty() { "none".into() } else { format!("{}{more}", listed.join(", ")) }
}

/// The most similar of some names, if one is similar at all; capitals do not count.
pub(crate) fn most_similar<'a>(name: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let plain = |name: &str| name.chars().take(COMPARED_CHARACTERS).collect::<String>().to_lowercase();
    let name = plain(name);
    let likeness = |other: &str| strsim::normalized_damerau_levenshtein(&name, &plain(other));
    let scored = names.take(COMPARED_NAMES).map(|other| (likeness(other), other));
    scored.filter(|(score, _)| *score >= LEAST_SIMILARITY).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, other)| other)
}
