//! Tables as Markdown, which is readable as it stands: columns as wide as they must be, numbers to the right.

/// A table under its heads.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    pub(crate) fn new(heads: &[&str]) -> Self {
        Self { rows: vec![heads.iter().map(|&head| head.to_owned()).collect()] }
    }

    /// Adds a row; what it has too little of stays empty.
    pub(crate) fn row(&mut self, cells: Vec<String>) {
        self.rows.push(cells);
    }

    /// The text. The first column is aligned to the left, all others to the right.
    pub(crate) fn text(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let cell = |row: &[String], column: usize| row.get(column).cloned().unwrap_or_default();
        let width = |column| self.rows.iter().map(|row| cell(row, column).chars().count()).max().unwrap_or(0).max(3);
        let widths: Vec<usize> = (0..columns).map(width).collect();
        let line = |row: &[String]| {
            let cells = widths.iter().enumerate().map(|(column, &width)| match column {
                0 => format!(" {:<width$} |", cell(row, 0)),
                _ => format!(" {:>width$} |", cell(row, column)),
            });
            format!("|{}\n", cells.collect::<String>())
        };
        let rule = widths.iter().enumerate().map(|(column, width)| match column {
            0 => format!("{}|", "-".repeat(width + 2)),
            _ => format!("{}:|", "-".repeat(width + 1)),
        });
        let rule = format!("|{}\n", rule.collect::<String>());
        let mut lines = self.rows.iter().map(|row| line(row));
        lines.next().into_iter().chain([rule]).chain(lines).collect()
    }
}

/// A share in percent with `decimals` digits.
pub(crate) fn percent(share: f64, decimals: usize) -> String {
    format!("{:.decimals$} %", 100.0 * share)
}

/// Seconds with three digits that count, and at most as many as are sure.
pub(crate) fn seconds(s: f64) -> String {
    let decimals = if s < 9.995 { 2 } else { usize::from(s < 99.95) };
    format!("{s:.decimals$}")
}

/// A number with its thousands apart: `1,234,567`.
pub(crate) fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let comma = |i: usize| i > 0 && (digits.len() - i).is_multiple_of(3);
    digits.chars().enumerate().flat_map(|(i, digit)| [comma(i).then_some(','), Some(digit)]).flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_as_wide_as_their_widest_cell() {
        let mut table = Table::new(&["scene", "s"]);
        table.row(vec!["a".into(), "1.25".into()]);
        table.row(vec!["bcdefgh".into()]);
        assert_eq!(table.text(), "| scene   |    s |\n|---------|-----:|\n| a       | 1.25 |\n| bcdefgh |      |\n");
    }

    #[test]
    fn numbers_are_told_readably() {
        assert_eq!([0, 999, 1000, 1_234_567].map(grouped), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([0.123, 9.996, 12.34, 123.4].map(seconds), ["0.12", "10.0", "12.3", "123"]);
        assert_eq!(percent(0.00625, 2), "0.62 %");
    }
}
