//! Numbers of parts of a scene on a command line: `0-5,9`.

use std::fmt;
use std::str::FromStr;

/// Numbers, sorted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Parts(Vec<usize>);

impl Parts {
    pub(crate) fn new(mut numbers: Vec<usize>) -> Self {
        numbers.sort_unstable();
        numbers.dedup();
        Self(numbers)
    }

    pub(crate) fn has(&self, number: usize) -> bool {
        self.0.binary_search(&number).is_ok()
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }
}

impl fmt::Display for Parts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let runs = self.0.chunk_by(|a, b| a + 1 == *b);
        let run = |run: &[usize]| match run {
            [one] => one.to_string(),
            more => format!("{}-{}", more[0], more[more.len() - 1]),
        };
        f.write_str(&runs.map(run).collect::<Vec<_>>().join(","))
    }
}

impl FromStr for Parts {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.parse::<usize>().map_err(|_| format!("{text:?} is not a number"));
        let mut numbers = Vec::new();
        for run in text.split(',') {
            let (first, last) = run.split_once('-').unwrap_or((run, run));
            numbers.extend(number(first)?..=number(last)?);
        }
        Ok(Self::new(numbers))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_and_read() {
        let parts = Parts::new(vec![9, 0, 1, 2, 4, 2]);
        assert_eq!(parts.to_string(), "0-2,4,9");
        assert_eq!(parts.to_string().parse(), Ok(parts.clone()));
        assert!(parts.has(4) && !parts.has(3) && parts.len() == 5);
        assert!("1-x".parse::<Parts>().is_err());
    }
}
