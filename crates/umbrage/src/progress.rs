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
    /// Steps of this stage in all; 0 where nothing new is known but that it runs.
    pub total: u64,
}

/// How far on its way from 1 to `target` a residual is that falls by a factor in each step: 0 to 1.
pub(crate) fn share_of_way(residual: f64, target: f64) -> f64 {
    let share = residual.ln() / target.ln();
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
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
    /// What is told counts as a part of a stage: from one share of it to another.
    part: Option<(Stage, [f64; 2])>,
}

/// Steps of a stage that is told in parts.
const STEPS_OF_PARTS: f64 = 10_000.0;

impl<'a> Progress<'a> {
    /// Tells each update to `callback`, which cancels with [`ControlFlow::Break`].
    pub fn new(callback: &'a (dyn Fn(Update) -> ControlFlow<()> + Sync)) -> Self {
        Self { callback: Some(callback), hurries: None, part: None }
    }

    /// Tells nobody, and is never cancelled.
    pub fn silent() -> Self {
        Self { callback: None, hurries: None, part: None }
    }

    /// The same, where `hurries` says from when on the bake is to end with what it has.
    pub fn hurried_by(self, hurries: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Self { hurries: Some(hurries), ..self }
    }

    /// The same, where what is told, of whatever stage, is the work of `stage` from one share of it to another; of a part, those are
    /// shares of the part. How long parts take is guessed.
    #[must_use]
    pub fn part(self, stage: Stage, [from, to]: [f64; 2]) -> Self {
        let (stage, [begin, end]) = self.part.unwrap_or((stage, [0.0, 1.0]));
        let [from, to] = [from, to].map(|share| begin + share * (end - begin));
        Self { part: Some((stage, [from, to])), ..self }
    }

    /// Whether what can be left out is to be left out: asked between rounds.
    pub fn is_hurried(&self) -> bool {
        self.hurries.is_some_and(|hurries| hurries())
    }

    /// Tells that `done` of `total` steps of `stage` are done; a total of 0 tells no more than that it runs.
    ///
    /// # Errors
    /// [`Cancelled`] where the callback asks to stop.
    pub fn report(&self, stage: Stage, done: usize, total: usize) -> Result<(), Cancelled> {
        let update = match self.part {
            None => Update { stage, done: done as u64, total: total as u64 },
            Some((stage, _)) if total == 0 => Update { stage, done: 0, total: 0 },
            Some((stage, [from, to])) => {
                let share = from + (to - from) * (done as f64 / total as f64).min(1.0);
                Update { stage, done: (STEPS_OF_PARTS * share) as u64, total: STEPS_OF_PARTS as u64 }
            }
        };
        match self.callback.map(|callback| callback(update)) {
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
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn a_breaking_callback_cancels() {
        let stop_at_three = |u: Update| if u.done >= 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let progress = Progress::new(&stop_at_three);
        assert_eq!(progress.report(Stage::Solve, 2, 9), Ok(()));
        assert_eq!(progress.report(Stage::Solve, 3, 9), Err(Cancelled));
        assert_eq!(Progress::silent().report(Stage::Solve, 3, 9), Ok(()));
    }

    #[test]
    fn parts_of_parts_are_shares_of_the_outer_stage() {
        let told = Mutex::new(Vec::new());
        let tell = |u: Update| {
            told.lock().unwrap().push((u.stage, u.done, u.total));
            ControlFlow::Continue(())
        };
        let half = Progress::new(&tell).part(Stage::Shade, [0.5, 1.0]);
        half.report(Stage::Shade, 1, 2).unwrap();
        half.part(Stage::Discontinuity, [0.0, 0.2]).report(Stage::Discontinuity, 1, 2).unwrap();
        half.report(Stage::Discontinuity, 7, 0).unwrap();
        let expected = [(Stage::Shade, 7500, 10_000), (Stage::Shade, 5500, 10_000), (Stage::Shade, 0, 0)];
        assert_eq!(*told.lock().unwrap(), expected);
    }
}
