//! Which tolerance the next step of a bake in steps has: the finest that what is left allows.
//!
//! A step takes more the finer it is, by a power of its tolerance that differs from scene to scene: -0.4 to -1 as measured, and
//! more where light is gathered in another way from some tolerance on. The first step is taken to have -1; from the second on,
//! the power is the one between the last two. No step is finer than the one before by more than [`LEAST_OF_LAST`]: then a wrong
//! guess costs no more than the step before, and all steps but the last together take about a third of its time.
//!
//! Holds: tolerances fall; the last is exactly the one that was asked for.

/// The first step is asked for two to the power of so many times the tolerance: powers of two, and three halves of them, are as
/// exact as the tolerance itself.
const FIRST_POWER: i32 = 4;
/// Where time or memory is limited, the first step has this tolerance at least: it ends soon on any scene.
const COARSE: f64 = 0.16;
/// The next step has at least this share of the tolerance of the last.
const LEAST_OF_LAST: f64 = 0.25;
/// What the next step takes is foreseen no better than to this share of what is left.
const FORESEEN: f64 = 0.85;
/// Powers of the tolerance that are believed.
const POWERS: [f64; 2] = [0.4, 2.0];
/// A step that gathers light in another way may take so many times what is foreseen.
const OTHER_WAY: f64 = 4.0;

/// What steps took so far.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    asked: f64,
    /// The first tolerance over the one asked for, as a power of two.
    first_power: i32,
    /// Tolerances, and what they took, in seconds.
    steps: Vec<(f64, f64)>,
}

impl Plan {
    /// Before the first step on the way to a tolerance, a finite one.
    pub(crate) fn new(asked: f64, is_limited: bool) -> Self {
        let to_coarse = (COARSE / asked).log2().ceil() as i32;
        let first_power = if is_limited { FIRST_POWER.max(to_coarse) } else { FIRST_POWER };
        Self { asked, first_power, steps: Vec::new() }
    }

    /// The tolerance of the first step.
    pub(crate) fn first(&self) -> f64 {
        2.0_f64.powi(self.first_power) * self.asked
    }

    /// All tolerances of steps finer than one, falling.
    fn finer_than(&self, last: f64) -> impl DoubleEndedIterator<Item = f64> {
        let asked = self.asked;
        let times =
            (0..=self.first_power).rev().map(|power| 2.0_f64.powi(power)).flat_map(|times| [1.5 * times, times]);
        times.map(move |times| times * asked).filter(move |&tolerance| tolerance < last)
    }

    /// Notes what a step took, in seconds.
    pub(crate) fn took(&mut self, tolerance: f64, took_s: f64) {
        self.steps.push((tolerance, took_s));
    }

    /// The tolerance of the next step, which may take `room` times what the last one took; `None` where that is not enough for
    /// any, or the last one was the one asked for. `is_alike` says of a tolerance whether light is gathered there in the same way.
    pub(crate) fn next(&self, room: f64, is_alike: impl Fn(f64) -> bool) -> Option<f64> {
        let (last, _) = *self.steps.last()?;
        if room < 1.0 {
            return None;
        }
        let power = self.power();
        let takes = |tolerance: f64| (last / tolerance).powf(power) * if is_alike(tolerance) { 1.0 } else { OTHER_WAY };
        let mut finer = self.finer_than(last);
        let allowed = |&tolerance: &f64| tolerance >= LEAST_OF_LAST * last && takes(tolerance) <= FORESEEN * room;
        // Where none is, what is foreseen may be wrong: the next one is tried all the same.
        self.finer_than(last).rfind(allowed).or_else(|| finer.next())
    }

    /// By which power of the inverse of the tolerance time grows.
    fn power(&self) -> f64 {
        match self.steps[..] {
            [.., (before, before_s), (last, last_s)] if before_s > 0.0 && last_s > 0.0 => {
                ((last_s / before_s).ln() / (before / last).ln()).clamp(POWERS[0], POWERS[1])
            }
            _ => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The tolerances of steps that take `cost` units of work each, of `limit` in all; the last of them may not end.
    fn steps(asked: f64, limit: f64, cost: impl Fn(f64) -> f64) -> Vec<f64> {
        let (mut plan, mut left, mut done) = (Plan::new(asked, limit.is_finite()), limit, Vec::new());
        let mut next = Some(plan.first());
        while let Some(tolerance) = next.filter(|&tolerance| cost(tolerance) <= left) {
            left -= cost(tolerance);
            done.push(tolerance);
            plan.took(tolerance, cost(tolerance));
            next = plan.next(left / cost(tolerance), |_| true);
        }
        done
    }

    #[test]
    fn without_limits_three_steps_lead_to_the_one_asked_for() {
        for asked in [0.01, 0.003, 1e-9, 0.7, 1.0 / 3.0] {
            assert_eq!(steps(asked, f64::INFINITY, |tolerance| 1.0 / tolerance), [16.0 * asked, 4.0 * asked, asked]);
        }
    }

    #[test]
    fn a_step_that_gathers_in_another_way_is_taken_to_be_dear() {
        let mut plan = Plan::new(0.01, true);
        plan.took(0.16, 1.0);
        assert_eq!(plan.next(10.0, |_| true), Some(0.04));
        assert_eq!(plan.next(10.0, |tolerance| tolerance > 0.05), Some(0.06));
        assert_eq!(plan.next(20.0, |tolerance| tolerance > 0.05), Some(0.04));
        assert_eq!(plan.next(0.99, |_| true), None);
    }

    proptest! {
        #[test]
        fn steps_get_near_what_the_limit_allows(power in 0.3..1.8, fixed in 0.0..20.0, over in 12.0..2000.0) {
            let asked = 0.001;
            let cost = |tolerance: f64| fixed + (0.256 / tolerance).powf(power);
            let limit = over * cost(Plan::new(asked, true).first());
            let done = steps(asked, limit, cost);
            prop_assert!(done.is_sorted_by(|coarse, fine| coarse > fine));
            let finest = Plan::new(asked, true).finer_than(1.0).rfind(|&tolerance| cost(tolerance) <= limit);
            let last = *done.last().unwrap();
            prop_assert!(last <= 4.0 * finest.unwrap(), "{done:?} of {finest:?}");
        }
    }
}
