//! Progress of a bake on a terminal: a bar for the stage that runs, with what is done and what there is to do.
//!
//! Where standard error is no terminal, a line comes every ten seconds. Nothing is told with `--quiet`, or while a log runs there.

use std::fmt;
use std::io::{self, IsTerminal};
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use umbrage::progress::{Stage, Update};

use crate::interrupt;
use crate::output::{self, Output};
use crate::pace::Pace;

const COUNTED: &str = "{msg:>14} [{bar:32}] {percent:>3} %  {elapsed}, {eta} left";
const UNCOUNTED: &str = "{msg:>14} {spinner}  {elapsed}";

/// A progress bar, and the stage that it shows.
pub(crate) struct Bar {
    bar: ProgressBar,
    shown: Mutex<Option<(Running, u64)>>,
    /// Where lines are told instead.
    pace: Option<Mutex<Pace>>,
    begin: Instant,
}

/// What runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Running {
    /// A stage of a bake.
    Stage(Stage),
    /// Something else, by name.
    Other(&'static str),
}

impl fmt::Display for Running {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stage(stage) => stage.fmt(f),
            Self::Other(name) => f.write_str(name),
        }
    }
}

impl Bar {
    /// A bar on standard error, where it may be drawn.
    pub(crate) fn new(output: Output) -> Self {
        let target =
            if output.quiet || output.logging { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(None, target);
        let tells = !output.quiet && !output.logging && !io::stderr().is_terminal();
        let pace = tells.then(|| Mutex::new(Pace::default()));
        Self { bar, shown: Mutex::new(None), pace, begin: Instant::now() }
    }

    /// Shows an update, and asks to stop after Ctrl-C. Called from many threads, often.
    pub(crate) fn update(&self, update: Update) -> ControlFlow<()> {
        self.show(Running::Stage(update.stage), update.done, update.total)
    }

    /// The same for what is no stage of a bake.
    pub(crate) fn step(&self, name: &'static str, done: usize, total: usize) -> ControlFlow<()> {
        self.show(Running::Other(name), done as u64, total as u64)
    }

    fn show(&self, running: Running, done: u64, total: u64) -> ControlFlow<()> {
        if interrupt::was_interrupted() {
            return ControlFlow::Break(());
        }
        if let Some(Ok(mut pace)) = self.pace.as_ref().map(Mutex::try_lock)
            && let Some(line) = pace.line(self.begin.elapsed(), &running.to_string(), done, total)
        {
            output::note(&line);
        }
        // Where another thread is drawing, this update may be lost: the next one comes soon.
        if !self.bar.is_hidden()
            && let Ok(mut shown) = self.shown.try_lock()
        {
            let is_new = shown.is_none_or(|(before, _)| before != running);
            if is_new || (total > 0 && *shown != Some((running, total))) {
                self.start(running, done, total, is_new);
                *shown = Some((running, total));
            }
            if total > 0 {
                self.bar.set_position(done.max(self.bar.position()));
            }
        }
        ControlFlow::Continue(())
    }

    fn start(&self, running: Running, done: u64, total: u64, is_new: bool) {
        let template = if total > 0 { COUNTED } else { UNCOUNTED };
        // Without its style a bar is less pretty, but tells the same.
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.bar.set_style(style.progress_chars("=> "));
        }
        if is_new {
            self.bar.reset();
        }
        self.bar.set_position(done);
        self.bar.set_length(total);
        self.bar.set_message(running.to_string());
    }

    /// Does what may write to the terminal.
    pub(crate) fn aside<R>(&self, work: impl FnOnce() -> R) -> R {
        self.bar.suspend(work)
    }

    /// Removes the bar.
    pub(crate) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_templates_are_sound() {
        assert!(ProgressStyle::with_template(COUNTED).is_ok() && ProgressStyle::with_template(UNCOUNTED).is_ok());
    }
}
