//! What text formats share: lines with a number, words, numbers, and errors that name the line.
//!
//! A line ends at LF, CRLF or CR; one that ends in a backslash goes on in the next, and is named by its first. Bytes
//! that are not UTF-8 are taken as Windows-1252, which has a character for each: names in other encodings look strange, and stay
//! different. In encodings of two bytes for a character the second can be that of a backslash, which then continues nothing.

use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_8, WINDOWS_1252};

use crate::FormatError;

/// What helps against most broken lines.
pub(crate) const EXPORT_AGAIN: &str = "repair the line, or export the file again";

/// Where reading has come to in a text. A copy of it is a place to come back to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Cursor {
    at: usize,
    lines: usize,
}

/// A line with those that continue it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line<'a> {
    /// Number of its first line, from 1.
    pub(crate) number: usize,
    /// Without its end, trimmed.
    pub(crate) text: Cow<'a, str>,
}

impl Cursor {
    /// The next line that is not empty. Whether `comments` (`#`) can be continued is up to the format.
    pub(crate) fn next_line<'a>(&mut self, bytes: &'a [u8], comments_continue: bool) -> Option<Line<'a>> {
        if self.at == 0 && bytes.starts_with(b"\xEF\xBB\xBF") {
            self.at = 3;
        }
        loop {
            let first = self.physical_line(bytes)?;
            let number = self.lines;
            if first.is_empty() {
                continue;
            }
            let goes_on = |line: &[u8]| line.ends_with(b"\\") && !ends_in_two_bytes(line);
            if !goes_on(first) || (first.starts_with(b"#") && !comments_continue) {
                return Some(Line { number, text: decoded(first) });
            }
            let mut joined = Vec::new();
            let mut part = first;
            while goes_on(part) {
                joined.extend_from_slice(&part[..part.len() - 1]);
                joined.push(b' ');
                part = self.physical_line(bytes).unwrap_or_default();
            }
            joined.extend_from_slice(part);
            let text = decoded(joined.trim_ascii()).into_owned();
            if !text.is_empty() {
                return Some(Line { number, text: text.into() });
            }
        }
    }

    /// Bytes before the next line.
    pub(crate) fn offset(self) -> usize {
        self.at
    }

    /// One line, trimmed, and the cursor behind it.
    fn physical_line<'a>(&mut self, bytes: &'a [u8]) -> Option<&'a [u8]> {
        let rest = bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let end = rest.iter().position(|&b| b == b'\n' || b == b'\r');
        let line = &rest[..end.unwrap_or(rest.len())];
        let end_length = match end {
            None => 0,
            Some(end) if rest[end..].starts_with(b"\r\n") => 2,
            Some(_) => 1,
        };
        self.at += line.len() + end_length;
        self.lines += 1;
        Some(line.trim_ascii())
    }
}

/// A text in UTF-16 that says so by its first bytes, as UTF-8; any other as it is.
pub(crate) fn utf8(bytes: Vec<u8>) -> Vec<u8> {
    match Encoding::for_bom(&bytes) {
        Some((encoding, _)) if encoding != UTF_8 => encoding.decode(&bytes).0.into_owned().into_bytes(),
        _ => bytes,
    }
}

fn decoded(line: &[u8]) -> Cow<'_, str> {
    str::from_utf8(line).map_or_else(|_| WINDOWS_1252.decode_without_bom_handling(line).0, Cow::Borrowed)
}

/// Whether a line that is not UTF-8 ends in a character of two bytes, as in Shift-JIS, GBK and Big5, whose first is at least this.
fn ends_in_two_bytes(line: &[u8]) -> bool {
    const LEAST_FIRST: u8 = 0x81;
    matches!(line, [.., first, _] if *first >= LEAST_FIRST) && str::from_utf8(line).is_err()
}

/// A line of a file, for messages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<'a> {
    pub(crate) file: &'a str,
    pub(crate) line: usize,
}

impl Place<'_> {
    /// The place as messages have it.
    pub(crate) fn name(self) -> String {
        format!("line {}", self.line)
    }

    /// An error at this place.
    pub(crate) fn bad(self, what: impl Into<String>, cure: &'static str) -> FormatError {
        FormatError::BadStatement { file: self.file.to_owned(), place: self.name(), what: what.into(), cure }
    }

    /// A number; it may be infinite or NaN.
    pub(crate) fn number(self, word: &str) -> Result<f64, FormatError> {
        word.parse().map_err(|_| self.bad(format!("{:?} is not a number", shortened(word)), EXPORT_AGAIN))
    }

    /// A finite number.
    pub(crate) fn finite(self, word: &str) -> Result<f64, FormatError> {
        let number = self.number(word)?;
        if number.is_finite() {
            return Ok(number);
        }
        let (file, place) = (self.file.to_owned(), self.name());
        Err(FormatError::NotFinite { file, place, value: shortened(word) })
    }

    /// As many finite numbers as are asked for, from the words of a statement; further words are left.
    pub(crate) fn numbers<'w, const N: usize>(
        self,
        keyword: &str,
        words: &mut impl Iterator<Item = &'w str>,
    ) -> Result<[f64; N], FormatError> {
        let mut numbers = [0.0; N];
        for (i, number) in numbers.iter_mut().enumerate() {
            let missing = || self.bad(format!("{keyword} has {i} numbers, and needs {N}"), EXPORT_AGAIN);
            *number = self.finite(words.next().ok_or_else(missing)?)?;
        }
        Ok(numbers)
    }
}

/// Words of a numeric statement, up to a comment.
pub(crate) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split_ascii_whitespace().take_while(|word| !word.starts_with('#'))
}

/// The first word of a line, and the rest as it stands.
pub(crate) fn keyword(text: &str) -> (&str, &str) {
    let (word, rest) = text.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((text, ""));
    (word, rest.trim())
}

/// A piece of a file as a message can bear it.
pub fn shortened(text: &str) -> String {
    if text.chars().count() <= 80 { text.to_owned() } else { text.chars().take(80).chain("...".chars()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &[u8], comments_continue: bool) -> Vec<(usize, String)> {
        let mut cursor = Cursor::default();
        std::iter::from_fn(|| cursor.next_line(text, comments_continue))
            .map(|line| (line.number, line.text.into_owned()))
            .collect()
    }

    #[test]
    fn lines_end_in_three_ways_and_are_numbered() {
        let expected = [(1, "a".to_owned()), (3, "b c".to_owned()), (4, "d".to_owned())];
        for text in ["a\n\n b c \nd", "a\r\n\r\nb c\r\nd\r\n", "a\r\rb c\rd\r", "\u{feff}a\n\nb c\nd"] {
            assert_eq!(lines(text.as_bytes(), false), expected, "{text:?}");
        }
    }

    #[test]
    fn a_backslash_continues_a_line_and_perhaps_a_comment() {
        let text = b"f 1 2 \\\r\n 3\\\n4\n# c:\\\nv 1\n\\\n\\";
        let (f, v) = ((1, "f 1 2  3 4".to_owned()), (5, "v 1".to_owned()));
        assert_eq!(lines(text, false), [f.clone(), (4, "# c:\\".to_owned()), v]);
        assert_eq!(lines(text, true), [f, (4, "# c: v 1".to_owned())]);
    }

    #[test]
    fn names_in_other_encodings_stay_different() {
        // Latin-1 and Shift-JIS, whose second byte can be a backslash.
        let text = b"usemtl gr\xfcn\nusemtl gr\xf6n\nusemtl \x83\x5c\nusemtl \x83\x41\n";
        let names: Vec<String> = lines(text, false).into_iter().map(|(_, text)| text).collect();
        assert_eq!(names, ["usemtl gr\u{fc}n", "usemtl gr\u{f6}n", "usemtl \u{192}\\", "usemtl \u{192}A"]);
        assert_eq!(utf8(b"\xff\xfev\0 \x001\0".to_vec()), b"v 1");
        assert_eq!(utf8(b"v 1".to_vec()), b"v 1");
    }

    #[test]
    fn numbers_are_checked_and_named() {
        let place = Place { file: "a.obj", line: 7 };
        assert_eq!(place.finite("-.5e1").unwrap(), -5.0);
        let message = place.finite("1,5").unwrap_err().to_string();
        assert!(message.starts_with("a.obj: line 7: \"1,5\" is not a number"), "{message}");
        assert!(matches!(place.finite("1e999"), Err(FormatError::NotFinite { .. })));
        let message = place.numbers::<3>("v", &mut words("1 2 # 3")).unwrap_err().to_string();
        assert!(message.contains("v has 2 numbers, and needs 3"), "{message}");
    }

    #[test]
    fn statements_fall_into_keyword_and_rest() {
        assert_eq!(keyword("usemtl my \tmaterial #1"), ("usemtl", "my \tmaterial #1"));
        assert_eq!(keyword("g"), ("g", ""));
        assert_eq!(shortened(&"é".repeat(100)).chars().count(), 83);
    }
}
