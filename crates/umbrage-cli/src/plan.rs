//! Which tolerance the next step of a bake in steps has: the finest that what is left allows.
//!
//! A step takes more the finer it is, by a power of its tolerance that differs from scene to scene: -0.4 to -1 as measured, and
//! more where light is gathered in another way from some tolerance on. The first step is taken to have -1; from the second on,
//! the power is the one between the last two. No step is finer than the one before by more than [`LEAST_OF_LAST`]: then a wrong
//! guess costs no more than the step before, and all steps but the last together take about a third of its time.
//!
//! Holds: tolerances fall; the last is exactly the one that was asked for.

/// Steps have these times the tolerance that was asked for, a list of short numbers, so that they are as exact as it.
const OVER_ASKED: [f64; 9] = [16.0, 12.0, 8.0, 6.0, 4.0, 3.0, 2.0, 1.5, 1.0];
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
    /// Tolerances, and what they took, in seconds.
    steps: Vec<(f64, f64)>,
}

/// The tolerance of the first step.
pub(crate) fn first(asked: f64) -> f64 {
    OVER_ASKED[0] * asked
}

impl Plan {
    /// Before the first step.
    pub(crate) fn new(asked: f64) -> Self {
        Self { asked, steps: Vec::new() }
    }

    /// Notes what a step took, in seconds.
    pub(crate) fn took(&mut self, tolerance: f64, took_s: f64) {
        self.steps.push((tolerance, took_s));
    }

    /// The tolerance of the next step, which may take `room` times what the last one took; `None` where that is not enough for
    /// any, or the last one was the one asked for. `is_alike` says of a tolerance whether light is gathered there in the same way.
    pub(crate) fn next(&self, room: f64, is_alike: impl Fn(f64) -> bool) -> Option<f64> {
        let (last, _) = *self.steps.last()?;
        let finer = || OVER_ASKED.iter().map(|times| times * self.asked).filter(|&tolerance| tolerance < last);
        if room < 1.0 {
            return None;
        }
        let power = self.power();
        let takes = |tolerance: f64| {
            (last / tolerance).powf(power) * if is_alike(tolerance) { 1.0 } else { OTHER_WAY }
        };
        let allowed = finer().filter(|&tolerance| tolerance >= LEAST_OF_LAST * last && takes(tolerance) <= FORESEEN * room);
        // Where none is, what is foreseen may be wrong: the next one is tried all the same.
        allowed.last().or_else(|| finer().next())
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
        let (mut plan, mut left, mut done) = (Plan::new(asked), limit, Vec::new());
        let mut next = Some(first(asked));
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
        let mut plan = Plan::new(0.01);
        plan.took(0.16, 1.0);
        assert_eq!(plan.next(10.0, |_| true), Some(0.04));
        assert_eq!(plan.next(10.0, |tolerance| tolerance > 0.05), Some(0.06));
        assert_eq!(plan.next(20.0, |tolerance| tolerance > 0.05), Some(0.04));
        assert_eq!(plan.next(0.99, |_| true), None);
    }

    proptest! {
        #[test]
        fn steps_get_near_what_the_limit_allows(power in 0.3..1.8, fixed in 0.0..20.0, limit in 60.0..5000.0) {
            let asked = 0.001;
            let cost = |tolerance: f64| fixed + (16.0 * asked / tolerance).powf(power);
            prop_assume!(3.0 * cost(16.0 * asked) < limit);
            let done = steps(asked, limit, cost);
            prop_assert!(done.is_sorted_by(|coarse, fine| coarse > fine));
            let finest = OVER_ASKED.iter().map(|times| times * asked).rfind(|&tolerance| cost(tolerance) <= limit);
            let last = *done.last().unwrap();
            prop_assert!(last <= 3.0 * finest.unwrap(), "{done:?} of {finest:?}");
        }
    }
}
