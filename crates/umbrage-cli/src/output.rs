//! The two streams: what was asked for on standard output, everything else on standard error.
//!
//! Colours are kept on a terminal only (and `NO_COLOR` is heeded).

use std::error::Error;
use std::io::{self, Write};

use anstream::{stderr, stdout};
use clap::builder::styling::{AnsiColor, Style};

const ERROR: Style = AnsiColor::Red.on_default().bold();
const WARNING: Style = AnsiColor::Yellow.on_default().bold();

/// How much a command says.
#[derive(Clone, Copy, Debug)]
pub struct Output {
    /// Nothing but warnings and errors.
    pub quiet: bool,
    /// A log runs on standard error, where a progress bar would disturb it.
    pub logging: bool,
    /// Files that are there already may be replaced, whatever they are.
    pub force: bool,
}

impl Output {
    /// Says what was not asked for by name: a summary, what to do next.
    ///
    /// # Errors
    /// Where standard output cannot be written.
    pub fn say(self, text: &str) -> anyhow::Result<()> {
        if self.quiet { Ok(()) } else { answer(text) }
    }
}

/// Writes what was asked for, as a block of whole lines.
///
/// # Errors
/// Where standard output cannot be written.
pub fn answer(text: &str) -> anyhow::Result<()> {
    let mut stream = stdout().lock();
    stream.write_all(text.as_bytes())?;
    if !text.ends_with('\n') {
        stream.write_all(b"\n")?;
    }
    Ok(stream.flush()?)
}

/// Writes a warning.
pub fn warning(text: &str) {
    report(WARNING, "warning", text);
}

/// Writes how something is going.
pub fn note(text: &str) {
    // Where standard error is closed, there is nobody to tell.
    let _ = writeln!(stderr().lock(), "{}", harmless(text));
}

/// Writes an error.
pub fn error(text: &str) {
    report(ERROR, "error", text);
}

/// Writes an error and its causes, one below the other.
pub fn error_chain(error: &anyhow::Error) {
    self::error(&chain(error.as_ref()));
}

/// A message is cut after so many bytes: names in files can be of any length.
const MAX_MESSAGE_BYTES: usize = 4000;

/// A message as it may be shown: cut, and without characters that do something to a terminal.
fn harmless(text: &str) -> String {
    // What turns the direction of writing is no control character, and can make one name look like another.
    let turns = |c: char| matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let shown = |c: char| if (c.is_control() && c != '\n') || turns(c) { char::REPLACEMENT_CHARACTER } else { c };
    let text: String = text.chars().map(shown).collect();
    match text.char_indices().find(|(at, _)| *at >= MAX_MESSAGE_BYTES) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

fn report(style: Style, kind: &str, text: &str) {
    let text = harmless(text);
    // Where standard error is closed, there is nobody to tell.
    let _ = writeln!(stderr().lock(), "{style}{kind}:{style:#} {text}");
}

/// An error and its causes, each on a line of its own, but for causes that the line above already quotes.
fn chain(error: &(dyn Error + 'static)) -> String {
    let mut text = error.to_string();
    let mut last = text.clone();
    let mut next = error.source();
    while let Some(cause) = next {
        let message = cause.to_string();
        if !last.contains(&message) {
            text += "\n  because: ";
            text += &message;
            last = message;
        }
        next = cause.source();
    }
    text
}

/// Whether writing failed because nobody reads any more.
pub fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .any(|cause| cause.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe))
}

#[cfg(test)]
mod tests {
    use anyhow::Context;

    use super::*;

    #[test]
    fn messages_are_cut_and_do_nothing_to_a_terminal() {
        assert_eq!(harmless("a\u{1b}[31mb\u{7}\nc\u{202e}d"), "a\u{fffd}[31mb\u{fffd}\nc\u{fffd}d");
        let long = harmless(&"\u{e9}".repeat(100_000));
        assert!(long.len() <= MAX_MESSAGE_BYTES + 5 && long.ends_with("..."));
    }

    #[test]
    fn a_chain_tells_each_cause_once() {
        let error = Err::<(), _>(io::Error::other("disk on fire"))
            .context("room.glb: cannot be read: disk on fire")
            .context("cannot bake")
            .unwrap_err();
        assert_eq!(chain(error.as_ref()), "cannot bake\n  because: room.glb: cannot be read: disk on fire");
    }
}
