//! Progress of a bake, told by a callback that can also cancel it.
//!
//! A bake that runs out of time can be hurried: then refinement ends after the round that runs, and what there is is shown.
//!
//! Stages call [`Progress::report`] often and cheaply; the callback decides what to show. Where it answers
//! [`ControlFlow::Break`], the stage stops with [`Cancelled`] and the bake leaves nothing behind.

use std::fmt;
use std::ops::ControlFlow;

/// A stage of the pipeline, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Faces from polygons: weld, merge, cut along contacts, partition.
    Prepare,
    /// Discontinuity segments: events, wedges, tracing.
    Discontinuity,
    /// Patches and links: `subdivide` over pairs of patches.
    Transport,
    /// Radiosity of each patch.
    Solve,
    /// Triangles and the light of their vertices.
    Shade,
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Prepare => "prepare",
            Self::Discontinuity => "discontinuity",
            Self::Transport => "transport",
            Self::Solve => "solve",
            Self::Shade => "shade",
        })
    }
}

/// How far a stage is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Update {
    /// The running stage.
    pub stage: Stage,
    /// Steps done in this stage.
    pub done: u64,
    /// Steps of this stage in all, 0 where that is not known.
    pub total: u64,
}

/// The bake was cancelled by the progress callback.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cancelled")]
pub struct Cancelled;

/// A progress callback, borrowed for the length of a bake.
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    callback: Option<&'a (dyn Fn(Update) -> ControlFlow<()> + Sync)>,
    hurries: Option<&'a (dyn Fn() -> bool + Sync)>,
}

impl<'a> Progress<'a> {
    /// Tells each update to `callback`, which cancels with [`ControlFlow::Break`].
    pub fn new(callback: &'a (dyn Fn(Update) -> ControlFlow<()> + Sync)) -> Self {
        Self { callback: Some(callback), hurries: None }
    }

    /// Tells nobody, and is never cancelled.
    pub fn silent() -> Self {
        Self { callback: None, hurries: None }
    }

    /// The same, where `hurries` says from when on the bake is to end with what it has.
    pub fn hurried_by(self, hurries: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self { hurries: Some(hurries), ..self }
    }

    /// Whether what can be left out is to be left out: asked between rounds.
    pub fn is_hurried(&self) -> bool {
        self.hurries.is_some_and(|hurries| hurries())
    }

    /// Tells that `done` of `total` steps of `stage` are done.
    ///
    /// # Errors
    /// [`Cancelled`] where the callback asks to stop.
    pub fn report(&self, stage: Stage, done: usize, total: usize) -> Result<(), Cancelled> {
        match self.callback.map(|callback| callback(Update { stage, done: done as u64, total: total as u64 })) {
            Some(ControlFlow::Break(())) => Err(Cancelled),
            _ => Ok(()),
        }
    }
}

impl fmt::Debug for Progress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.callback.is_some() { "Progress(callback)" } else { "Progress(silent)" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_breaking_callback_cancels() {
        let stop_at_three = |u: Update| if u.done >= 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let progress = Progress::new(&stop_at_three);
        assert_eq!(progress.report(Stage::Solve, 2, 9), Ok(()));
        assert_eq!(progress.report(Stage::Solve, 3, 9), Err(Cancelled));
        assert_eq!(Progress::silent().report(Stage::Solve, 3, 9), Ok(()));
    }
}
