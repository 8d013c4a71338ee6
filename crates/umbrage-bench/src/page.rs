//! Figures in a page of the docs: what stands between two marks is made by a command.

use std::fs;
use std::path::Path;

use anyhow::Context;

/// The mark before the figures.
const BEGIN: &str = "<!-- figures: made by the command below -->\n";
/// The mark after them.
const END: &str = "<!-- end of figures -->\n";

/// Replaces what stands between the marks of a page.
pub(crate) fn put_figures(page: &Path, figures: &str) -> anyhow::Result<()> {
    let text = fs::read_to_string(page).with_context(|| format!("cannot read {}", page.display()))?;
    let text = with_figures(&text, figures)
        .with_context(|| format!("{} has no marks {:?} and {:?}", page.display(), BEGIN.trim(), END.trim()))?;
    fs::write(page, text).with_context(|| format!("cannot write {}", page.display()))
}

fn with_figures(text: &str, figures: &str) -> Option<String> {
    let (before, rest) = text.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{}\n\n{END}{after}", figures.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_between_the_marks_changes() {
        let page = format!("# Title\n\n{BEGIN}old\n{END}\nText\n");
        let new = with_figures(&page, "| new |\n").unwrap();
        assert_eq!(new, format!("# Title\n\n{BEGIN}\n| new |\n\n{END}\nText\n"));
        assert_eq!(with_figures(&new, "| new |\n").unwrap(), new);
        assert_eq!(with_figures("# Title\n", "| new |\n"), None);
    }
}
