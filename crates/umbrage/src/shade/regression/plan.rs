//! The plan of a round: splits and samples are bought at one price, the squared error that one sample must take off.
//!
//! A leaf with noise `b / n` of `n` samples wants `sqrt(b / price)` of them; it is split as deep as each doubling of its parts takes
//! more misfit off than its work and its samples cost. The price is the greatest at which noise and misfit of all leaves are
//! what is allowed; never less than what makes samples worth their time.

use crate::id::PatchId;

/// A split leaves this share of the misfit.
const LEFT_BY_SPLIT: f64 = 0.4;
/// It costs as much as so many samples, for each part.
const SAMPLES_OF_SPLIT: f64 = 150.0;
/// Twice the parts with as little noise take so many times the samples more.
const MORE_FOR_PARTS: f64 = 0.8;
/// No leaf is to be split deeper in one plan.
const MAX_DEPTH: i32 = 12;
/// A million samples must take at least this share off the squared error that is allowed.
const WORTH_OF_MILLION: f64 = 0.03;
/// A plan aims at this share of the squared error that is allowed.
const AIM: f64 = 0.95;
/// What is known at first is poor: a round takes at most so many times the samples that there are, and some more.
const MAX_GROWTH: f64 = 1.6;
const SAMPLES_MORE: f64 = 2e4;
/// Fewer than so many times the samples that there are, are not drawn.
pub(super) const WORTHWHILE: f64 = 1.25;

/// What a leaf needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Need {
    pub(super) leaf: PatchId,
    /// Integral of the squared misfit, in W2/m2.
    pub(super) misfit: f64,
    /// Integral of the squared noise of one sample.
    pub(super) noise: f64,
    /// Samples that there are.
    pub(super) samples: f64,
    /// The fewest samples that a part may have.
    pub(super) fewest: f64,
    /// Whether it may be split.
    pub(super) splits: bool,
}

/// What to do next.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Plan {
    /// The squared error, integrated, that a sample must take off.
    pub(super) price: f64,
    /// The leaves to split, ascending.
    pub(super) splits: Vec<PatchId>,
}

/// Plans a round where so much squared error is `allowed`, integrated over all leaves, and at most so many samples in all.
pub(super) fn plan(needs: &[Need], allowed: f64, max_samples: f64) -> Plan {
    let least = WORTH_OF_MILLION * allowed / 1e6;
    // The greatest price that is low enough, by bisection of its logarithm.
    let greatest = |is_enough: &dyn Fn(f64) -> bool, from: f64, to: f64, steps: usize| {
        let (mut low, mut high) = (from.ln(), to.ln());
        for _ in 0..steps {
            let middle = 0.5 * (low + high);
            if is_enough(middle.exp()) { low = middle } else { high = middle }
        }
        [low.exp(), high.exp()]
    };
    let is_enough = |price: f64| {
        let [error, samples] = outcome(needs, price);
        // Where no price is, the one that all samples pay.
        error <= AIM * allowed || samples > max_samples
    };
    let mut price = greatest(&is_enough, 1e-3 * least, allowed, 40)[0].max(least);
    let there: f64 = needs.iter().map(|need| need.samples).sum();
    let most = MAX_GROWTH * there + SAMPLES_MORE;
    let is_too_much = |price: f64| needs.iter().map(|need| need.wanted(price)).sum::<f64>() > most;
    if is_too_much(price) {
        // At this one none is worthwhile.
        let none = needs.iter().map(|need| need.noise / (need.samples * need.samples)).fold(price, f64::max);
        price = greatest(&is_too_much, price, none, 30)[1];
    }
    let mut splits: Vec<PatchId> = needs.iter().filter(|need| need.depth(price) > 0).map(|need| need.leaf).collect();
    splits.sort_unstable();
    Plan { price, splits }
}

/// Squared error and samples that leaves come to at a price.
fn outcome(needs: &[Need], price: f64) -> [f64; 2] {
    needs.iter().fold([0.0; 2], |[error, all], need| {
        let depth = need.depth(price);
        let parts = f64::from(1 << depth);
        let samples = (parts * need.noise / price).sqrt().max(need.samples).max(parts * need.fewest);
        [error + need.misfit * LEFT_BY_SPLIT.powi(depth) + parts * need.noise / samples, all + samples]
    })
}

impl Need {
    /// How many samples it is to have.
    pub(super) fn wanted(&self, price: f64) -> f64 {
        let wanted = (self.noise / price).sqrt();
        if wanted > WORTHWHILE * self.samples { wanted } else { self.samples }
    }

    /// How often it is to be split.
    fn depth(&self, price: f64) -> i32 {
        let (mut depth, mut misfit, mut parts) = (0, self.misfit, 1.0);
        let costs = |parts: f64| SAMPLES_OF_SPLIT * parts + MORE_FOR_PARTS * (parts * self.noise / price).sqrt();
        while self.splits && depth < MAX_DEPTH && (1.0 - LEFT_BY_SPLIT) * misfit > price * costs(parts) {
            misfit *= LEFT_BY_SPLIT;
            parts *= 2.0;
            depth += 1;
        }
        depth
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn need(leaf: usize, misfit: f64, noise: f64) -> Need {
        Need { leaf: leaf.into(), misfit, noise, samples: 256.0, fewest: 32.0, splits: true }
    }

    #[test]
    fn what_errs_most_is_split_and_what_is_right_is_left_alone() {
        let needs = [need(0, 1.0, 1.0), need(1, 1e-9, 1.0), need(2, 1e-9, 1e-6)];
        let Plan { price, splits } = plan(&needs, 0.02, 1e7);
        assert_eq!(splits, vec![PatchId::from(0)]);
        assert!(needs[1].wanted(price) >= 256.0 && needs[2].wanted(price) == 256.0);
        let nothing = plan(&needs[1..], 1.0, 1e7);
        assert!(nothing.splits.is_empty() && needs[1].wanted(nothing.price) == 256.0);
    }

    #[test]
    fn a_plan_ends_where_samples_are_too_many() {
        let needs: Vec<Need> = (0..1000).map(|leaf| need(leaf, 1.0, 1e3)).collect();
        let Plan { price, .. } = plan(&needs, 1e-6, 1e6);
        let wanted: f64 = needs.iter().map(|need| need.wanted(price)).sum();
        assert!(wanted <= MAX_GROWTH * 256e3 + 2.0 * SAMPLES_MORE, "{wanted}");
    }
}
