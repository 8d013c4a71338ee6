//! Bakes in steps, coarse ones first: for a result early (`--progressive`), and for the best one that limits of time
//! and memory allow (`--time-limit`, `--memory-limit`).
//!
//! Every step is a whole bake at a tolerance of its own: what it leaves is, byte for byte, what a bake leaves that is asked for
//! that tolerance, unless time ran short. Steps share their faces and d-segments, which are found once ([`Groundwork`]); how fine the next one can be is
//! told by what those before took ([`Plan`]).
//!
//! Where there are limits, a sketch comes first, without the edges of shadows. Once a quarter of the time is used up its refinement
//! is cut short, so that there is something to write early, whatever the scene. Of every other step refinement ends once three
//! quarters of the time are used up, so that what it found is not lost; it is kept where its error is less than that of the step before.
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
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError, SyncSender};
use std::thread;
use std::time::{Duration, Instant};

use umbrage::bake::{self, Bake, BakeError, BakeSettings};
use umbrage::groundwork::Groundwork;
use umbrage::progress::Progress;
use umbrage::scene::Scene;
use umbrage::shade::ShadeSettings;

use crate::interrupt::{self, Interrupted};
use crate::limits::{Limit, Limits};
use crate::output::Output;
use crate::plan::Plan;
use crate::progress::Bar;

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
    /// Whether it has no edges of shadows, and is there to have something early.
    pub(crate) is_sketch: bool,
    /// Whether its refinement was cut short.
    pub(crate) is_cut_short: bool,
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

/// The same, where `bake` bakes if there is one step alone.
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
        // Where there is nothing to fall back on, a stage that reports no progress is not waited for.
        if steps_done == 0 && limits.is_memory_over() {
            break ended_by(Limit::Memory, steps_done);
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
    let callback = |update| {
        if wishes.limits.is_reached() {
            return ControlFlow::Break(());
        }
        bar.update(update)
    };
    let progress = Progress::new(&callback);
    // Where nobody waits for steps any more, nothing is sent, and the thread ends.
    if !is_in_steps(asked, wishes) {
        let step = |bake| Step { bake, settings: *asked, is_asked: true, is_sketch: false, is_cut_short: false };
        let _ = sender.send(bake(scene, asked, progress).map(step));
    } else if let Err(error) = steps_on_ground(scene, asked, wishes, progress, sender) {
        let _ = sender.send(Err(error));
    }
}

/// The steps that share their faces and d-segments.
fn steps_on_ground(
    scene: &Scene,
    asked: &BakeSettings,
    wishes: &Wishes,
    progress: Progress<'_>,
    sender: &SyncSender<Result<Step, BakeError>>,
) -> Result<(), BakeError> {
    let limits = &wishes.limits;
    let mut ground = Groundwork::new(scene, asked, progress)?;
    // Of the results that were sent the best, by its error.
    let mut best_error = f64::INFINITY;
    if limits.is_any() && !wishes.early {
        let settings = BakeSettings { discontinuities: false, ..at(asked, first(asked, wishes)) };
        let (bake, is_cut_short) = baked_until(&ground, scene, &settings, progress, &|| limits.must_end_sketch())?;
        best_error = bake.report.error;
        if sender.send(Ok(Step { bake, settings, is_asked: false, is_sketch: true, is_cut_short })).is_err() {
            return Ok(());
        }
    }
    ground.find_shadows(scene, asked, progress)?;
    let mut plan = Plan::new(asked.shade.tolerance, limits.is_any());
    let mut next = Some(first(asked, wishes));
    while let Some(tolerance) = next {
        let settings = at(asked, tolerance);
        let begin = Instant::now();
        let (bake, is_cut_short) = baked_until(&ground, scene, &settings, progress, &|| limits.must_end_step())?;
        let took_s = begin.elapsed().as_secs_f64();
        let is_asked = tolerance == asked.shade.tolerance && !is_cut_short;
        plan.took(tolerance, took_s);
        let is_alike = |finer: f64| ground.gathers_alike(&settings, &at(asked, finer));
        next = if is_cut_short { None } else { plan.next(limits.room(took_s), is_alike) };
        if is_cut_short && bake.report.error >= best_error {
            break;
        }
        best_error = bake.report.error;
        if sender.send(Ok(Step { bake, settings, is_asked, is_sketch: false, is_cut_short })).is_err() {
            break;
        }
    }
    Ok(())
}

/// Bakes a step, and ends its refinement once it must; tells whether that was so.
fn baked_until(
    ground: &Groundwork,
    scene: &Scene,
    settings: &BakeSettings,
    progress: Progress<'_>,
    must_end: &(dyn Fn() -> bool + Sync),
) -> Result<(Bake, bool), BakeError> {
    let was_short = AtomicBool::new(false);
    let is_short = || {
        let is_short = must_end();
        was_short.fetch_or(is_short, Ordering::Relaxed);
        is_short
    };
    let bake = ground.bake(scene, settings, progress.hurried_by(&is_short))?;
    Ok((bake, was_short.load(Ordering::Relaxed)))
}

/// The settings that were asked for, at another tolerance.
fn at(asked: &BakeSettings, tolerance: f64) -> BakeSettings {
    BakeSettings { shade: ShadeSettings { tolerance, ..asked.shade }, ..*asked }
}

/// Whether coarse steps come before the one that was asked for.
fn is_in_steps(asked: &BakeSettings, wishes: &Wishes) -> bool {
    (wishes.early || wishes.limits.is_any()) && asked.shade.tolerance.is_finite()
}

/// The tolerance of the first step.
fn first(asked: &BakeSettings, wishes: &Wishes) -> f64 {
    let tolerance = asked.shade.tolerance;
    if is_in_steps(asked, wishes) { Plan::new(tolerance, wishes.limits.is_any()).first() } else { tolerance }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_no_coarser_step_than_no_refinement() {
        let early = Wishes { early: true, ..Wishes::default() };
        let asked = BakeSettings::default();
        assert_eq!(first(&asked, &early), 16.0 * asked.shade.tolerance);
        assert_eq!(first(&asked, &Wishes::default()), asked.shade.tolerance);
        assert_eq!(first(&at(&asked, f64::INFINITY), &early), f64::INFINITY);
    }
}
