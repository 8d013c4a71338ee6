//! Bakes in steps, coarse ones first: for a result early (`--progressive`), and for the best one that limits of time
//! and memory allow (`--time-limit`, `--memory-limit`).
//!
//! Every step is a whole bake at a tolerance of its own, and shares nothing with the one before: what it leaves is,
//! byte for byte, what a bake leaves that is asked for that tolerance. Tolerances are the one that is asked for times a
//! power of two, and what a coarse step took tells which finer one can still end within the limits.
//!
//! A thread bakes while this one waits, so that the end of the time and Ctrl-C are heeded at once, whatever the bake is
//! doing. It is then left alone: the progress callback ends it, or the process does. Where memory is short, its end is
//! waited for, as what comes next needs the memory that it gives back.
//!
//! Holds: steps come in order, each finer than the one before; the last is the one asked for, unless a limit is
//! reached.

use std::ops::ControlFlow;
use std::panic;
use std::sync::Arc;
use std::sync::mpsc::{self, RecvTimeoutError, SyncSender};
use std::thread;
use std::time::{Duration, Instant};

use umbrage::bake::{self, Bake, BakeError, BakeSettings};
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::shade::ShadeSettings;

use crate::interrupt::{self, Interrupted};
use crate::limits::{Limit, Limits};
use crate::output::Output;
use crate::progress::Bar;

/// The first step is asked for so many times the tolerance. A power of two, as all quotients of steps, so that they are
/// as exact as the tolerance that was asked for.
const FIRST_OVER_ASKED: f64 = 16.0;
/// Where results are shown early, the next one comes with at least this share of the tolerance. Time grows by no more
/// than the inverse of it, so that all steps but the last together take about a third of its time.
const LEAST_OF_LAST: f64 = 0.25;
/// How often time and interrupts are looked at.
const PULSE: Duration = Duration::from_millis(20);

/// What is wished besides the bake itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct Wishes {
    /// Coarse results are wanted, too.
    pub(crate) early: bool,
    /// What the bake may take.
    pub(crate) limits: Arc<Limits>,
}

/// A whole bake.
#[derive(Debug)]
pub(crate) struct Step {
    pub(crate) bake: Bake,
    /// With the tolerance of this step.
    pub(crate) settings: BakeSettings,
    /// Whether this is the bake that was asked for, and no coarser one.
    pub(crate) is_asked: bool,
}

/// Bakes with progress on the terminal, and hands each step to `found`, with the bar out of its way. Tells which limit
/// was reached before the step that was asked for, if one was.
///
/// # Errors
/// What `found` says; [`Interrupted`], [`TooLittle`](crate::limits::TooLittle) and [`BakeError`].
pub(crate) fn bake_in_steps(
    scene: &Arc<Scene>,
    asked: &BakeSettings,
    wishes: &Wishes,
    output: Output,
    found: impl FnMut(Step) -> anyhow::Result<()>,
) -> anyhow::Result<Option<Limit>> {
    bake_in_steps_by(bake::bake, scene, asked, wishes, output, found)
}

/// The same, where `bake` bakes a step.
pub(crate) fn bake_in_steps_by(
    bake: impl Fn(&Scene, &BakeSettings, Progress<'_>) -> Result<Bake, BakeError> + Send + 'static,
    scene: &Arc<Scene>,
    asked: &BakeSettings,
    wishes: &Wishes,
    output: Output,
    mut found: impl FnMut(Step) -> anyhow::Result<()>,
) -> anyhow::Result<Option<Limit>> {
    let limits = &wishes.limits;
    let bar = Arc::new(Bar::new(output));
    // A step waits until the one before was taken.
    let (sender, steps) = mpsc::sync_channel(0);
    let worker = {
        let (scene, asked, wishes, bar) = (Arc::clone(scene), *asked, wishes.clone(), Arc::clone(&bar));
        thread::spawn(move || all_steps(bake, &scene, &asked, &wishes, &bar, &sender))
    };
    let mut steps_done = 0;
    let ended_by = |limit, steps_done| match steps_done {
        0 => Err(limits.too_little(limit, first(asked, wishes)).into()),
        _ => Ok(Some(limit)),
    };
    let result = loop {
        if interrupt::was_interrupted() {
            break Err(Interrupted.into());
        }
        if limits.is_time_over() {
            break ended_by(Limit::Time, steps_done);
        }
        match steps.recv_timeout(PULSE) {
            Ok(Ok(step)) => {
                steps_done += 1;
                let is_asked = step.is_asked;
                let taken = bar.aside(|| found(step));
                if is_asked || taken.is_err() {
                    break taken.map(|()| None);
                }
            }
            Ok(Err(BakeError::Cancelled(_))) if limits.reached() == Limit::Memory && !interrupt::was_interrupted() => {
                break ended_by(Limit::Memory, steps_done);
            }
            // What else cancels is the end of the time or Ctrl-C: both are looked at next.
            Ok(Err(BakeError::Cancelled(_))) | Err(RecvTimeoutError::Timeout) => {}
            Ok(Err(error)) => break Err(error.into()),
            // No finer step keeps within the limits; or a defect, which is to be seen.
            Err(RecvTimeoutError::Disconnected) => match worker.join() {
                Ok(()) => break ended_by(limits.reached(), steps_done),
                Err(defect) => panic::resume_unwind(defect),
            },
        }
    };
    bar.clear();
    result
}

/// The thread that bakes.
fn all_steps(
    bake: impl Fn(&Scene, &BakeSettings, Progress<'_>) -> Result<Bake, BakeError>,
    scene: &Scene,
    asked: &BakeSettings,
    wishes: &Wishes,
    bar: &Bar,
    sender: &SyncSender<Result<Step, BakeError>>,
) {
    let asked_tolerance = asked.shade.tolerance;
    let callback = |update| {
        if wishes.limits.is_reached() {
            return ControlFlow::Break(());
        }
        bar.update(update)
    };
    let mut next = Some(first(asked, wishes));
    while let Some(tolerance) = next {
        let settings = BakeSettings { shade: ShadeSettings { tolerance, ..asked.shade }, ..*asked };
        let begin = Instant::now();
        let baked = bake(scene, &settings, Progress::new(&callback));
        let room = wishes.limits.room(begin.elapsed().as_secs_f64());
        let is_asked = tolerance == asked_tolerance;
        next = (baked.is_ok() && !is_asked).then(|| finer(asked_tolerance, tolerance, room, wishes.early)).flatten();
        // Where nobody waits for steps any more, the loop ends.
        if sender.send(baked.map(|bake| Step { bake, settings, is_asked })).is_err() {
            break;
        }
    }
}

/// The tolerance of the first step.
fn first(asked: &BakeSettings, wishes: &Wishes) -> f64 {
    let in_steps = (wishes.early || wishes.limits.is_any()) && asked.shade.tolerance.is_finite();
    if in_steps { FIRST_OVER_ASKED * asked.shade.tolerance } else { asked.shade.tolerance }
}

/// The tolerance of the step after one at `last`: the finest that will keep within `room` times what that one took, if
/// time and memory grow as the inverse of the tolerance (measured: with its power of -0.4 to -1). Where none will, the
/// next finer one is tried all the same, but not in less than the last one took.
fn finer(asked: f64, last: f64, room: f64, early: bool) -> Option<f64> {
    let keeps_within = |tolerance: &f64| last / tolerance <= room;
    let is_early = |tolerance: &f64| !early || *tolerance >= LEAST_OF_LAST * last;
    let mut next = 0.5 * last;
    if room < 1.0 {
        return None;
    }
    while next > asked && Some(0.5 * next).filter(keeps_within).filter(is_early).is_some() {
        next *= 0.5;
    }
    Some(next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_finest_step_that_can_end_is_next() {
        // At 0.01 it takes at most 16 times what it took at tolerance 0.16.
        let next = |room| finer(0.01, 0.16, room, false);
        assert_eq!([16.0, 15.9, 4.0, 2.5].map(next), [0.01, 0.02, 0.04, 0.08].map(Some));
        // It may take less than that, but hardly less than the last one.
        assert_eq!([1.5, 0.9].map(next), [Some(0.08), None]);
    }

    #[test]
    fn early_results_come_one_after_the_other_down_to_the_one_asked_for() {
        let next = |last, room| finer(0.01, last, room, true);
        assert_eq!([0.16, 0.04, 0.02].map(|last| next(last, f64::INFINITY)), [0.04, 0.01, 0.01].map(Some));
        assert_eq!([next(0.16, 100.0), next(0.16, 3.0)], [0.04, 0.08].map(Some));
    }

    #[test]
    fn steps_end_exactly_at_the_tolerance_asked_for() {
        for asked in [0.01, 0.003, 1e-9, 0.7, 1.0 / 3.0] {
            let settings = |tolerance| BakeSettings {
                shade: ShadeSettings { tolerance, ..ShadeSettings::default() },
                ..BakeSettings::default()
            };
            let early = Wishes { early: true, ..Wishes::default() };
            let mut last = first(&settings(asked), &early);
            assert_eq!(last, 16.0 * asked);
            while last != asked {
                let next = finer(asked, last, f64::INFINITY, true).unwrap();
                assert!(next < last && next >= asked);
                last = next;
            }
            assert_eq!(first(&settings(asked), &Wishes::default()), asked);
            assert_eq!(first(&settings(f64::INFINITY), &early), f64::INFINITY, "there is no coarser one than none");
        }
    }
}
