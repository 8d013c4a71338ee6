//! Evidence: what the residuals of the samples of a leaf say of noise and of what the fit misses.
//!
//! Residuals are added up in cells. If the fit is right their sums are chance, and the mean of `sum^2 / count` over cells is the variance of
//! a residual; what is more is misfit. One leaf has few samples, so two things are asked of all leaves together: which share of the
//! variance even samples leave to chance ([`Pool::chance`]), and how far geometry that is near (a ray that is short beside the leaf)
//! is to be believed to hide light from the samples of other places ([`Pool::trust`]).

use glam::{DVec2, Vec3};

use super::element::{Element, element_at};
use super::sample::Sample;
use crate::scene::Rgb;

/// Cells across, from so many samples on: the finest, and those whose sums are the estimate.
const FINEST_CELLS: [(f64, usize); 3] = [(1536.0, 16), (384.0, 8), (96.0, 4)];
const FEWEST_CELLS: usize = 2;
const CELLS: [(f64, usize); 1] = [(256.0, 4)];
/// Samples for each class of directions, and the most classes along each side.
const SAMPLES_A_CLASS: f64 = 6.0;
const MAX_CLASSES: usize = 16;
/// The same of next events.
const SAMPLES_AN_EVENT_CLASS: usize = 12;
const MAX_EVENT_CLASSES: usize = 64;
/// A class of few samples is drawn to nothing by half a sample.
const OF_NO_CLASS: f32 = 0.5;
/// Light that near geometry reflects may vary over the leaf by this share of itself.
const NEAR_VARIES: f64 = 0.3;
/// A residual counts as no more than so many standard deviations: else splits chase single rays that meet something bright.
const MAX_DEVIATIONS: f64 = 4.0;
/// At least this share of the samples counts as free of what was fitted.
const MIN_FREE: f64 = 0.3;
/// Where cells are fewer than so many samples hold, the estimate leans on the prior alone.
const MIN_SAMPLES: f64 = 128.0;
/// What is beyond so many standard deviations of chance is believed.
const SURE: f64 = 3.0;
/// Weight of what is supposed before leaves tell, in leaves or samples.
const OF_SUPPOSED: f64 = 30.0;
const OF_SUPPOSED_SPREAD: f64 = 12.0;

/// Light by class of direction, and of next event, less its mean: classes are equally probable.
#[derive(Clone, Debug, Default)]
pub(super) struct Classes {
    /// Classes of directions are `side` times `side`.
    side: usize,
    of_directions: Vec<Vec3>,
    of_events: Vec<Vec3>,
}

impl Classes {
    /// What is known of a sample's light from its direction and its event, in W/m2.
    pub(super) fn light(&self, sample: &Sample) -> Rgb {
        let of_event = match self.of_events.len() {
            0 => Vec3::ZERO,
            classes => self.of_events[sample.class_of_event(classes)],
        };
        (self.of_direction(sample) + of_event).as_dvec3()
    }

    fn of_direction(&self, sample: &Sample) -> Vec3 {
        if self.side == 0 { Vec3::ZERO } else { self.of_directions[sample.class(self.side)] }
    }

    /// Values that are fitted for the classes.
    fn values(&self) -> usize {
        self.of_directions.len() + self.of_events.len()
    }

    /// Means of residuals by class; of events, where samples have any.
    fn of(samples: &[Sample], residuals: &[Vec3], has_events: bool) -> Self {
        let mut classes = Self::default();
        let side = ((samples.len() as f64 / SAMPLES_A_CLASS).sqrt() as usize).min(MAX_CLASSES);
        if side >= 2 {
            let by_class = samples.iter().zip(residuals).map(|(sample, &residual)| (sample.class(side), residual));
            classes.of_directions = means(side * side, by_class);
            classes.side = side;
        }
        let count = (samples.len() / SAMPLES_AN_EVENT_CLASS).min(MAX_EVENT_CLASSES);
        if has_events && count >= 2 {
            let rest = |(sample, residual): (&Sample, &Vec3)| {
                (sample.class_of_event(count), residual - classes.of_direction(sample))
            };
            classes.of_events = means(count, samples.iter().zip(residuals).map(rest));
        }
        classes
    }
}

/// Means by class, less the mean of all.
fn means(classes: usize, residuals: impl Iterator<Item = (usize, Vec3)>) -> Vec<Vec3> {
    let mut light = vec![Vec3::ZERO; classes];
    let mut counts = vec![OF_NO_CLASS; classes];
    for (class, residual) in residuals {
        light[class] += residual;
        counts[class] += 1.0;
    }
    light.iter_mut().zip(&counts).for_each(|(light, count)| *light /= *count);
    let mean = light.iter().sum::<Vec3>() / classes as f32;
    light.iter_mut().for_each(|light| *light -= mean);
    light
}

/// Sums of squared sums over cells of one size.
#[derive(Clone, Copy, Debug, Default)]
struct CellSums {
    /// Cells across.
    side: usize,
    /// Cells that hold samples.
    filled: f64,
    /// Sum of `sum^2 / count` over them, over the number of samples, in W2/m4.
    squared: f64,
}

/// What the samples of a leaf say.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Evidence {
    samples: f64,
    /// Mean of their light, in W/m2.
    mean: f64,
    /// Variance of a residual, in W2/m4.
    variance: f64,
    /// The square of what near geometry may hide, in W2/m4.
    near_squared: f64,
    cells: CellSums,
    finer: [CellSums; 3],
}

/// What becomes of it with the others.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Judged {
    /// Mean square of what the fit misses, in W2/m4.
    pub(super) misfit: f64,
    /// Standard deviation of a sample's residual, in W/m2.
    pub(super) spread: f64,
}

impl Evidence {
    /// Looks at the residuals of a leaf's samples against the fit, and finds the classes of their directions.
    pub(super) fn of(
        polygon_m: &[DVec2],
        (samples, has_events): (&[Sample], bool),
        elements: &[Element],
        values: &[Rgb],
    ) -> (Self, Classes) {
        let low = polygon_m.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = polygon_m.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        let count = samples.len() as f64;
        let across = |steps: &[(f64, usize)]| {
            steps.iter().find(|(least, _)| count >= *least).map_or(FEWEST_CELLS, |(_, side)| *side)
        };
        let (finest, side) = (across(&FINEST_CELLS), across(&CELLS));
        let residual = |sample: &Sample| {
            let fitted = element_at(elements, sample.at()).map(|(i, at)| elements[i].value(at, values));
            fitted.map_or(Vec3::ZERO, |fitted| sample.light - fitted.as_vec3())
        };
        let residuals: Vec<Vec3> = samples.iter().map(residual).collect();
        let classes = Classes::of(samples, &residuals, has_events);
        // Count, sum, sum of what near geometry brings, and of its squares.
        let mut cells = vec![[0.0_f64; 4]; finest * finest];
        let radius_m = 0.5 * (high - low).length();
        let (mut squared, mut near) = (0.0, 0.0);
        let rest =
            |(sample, residual): (&Sample, &Vec3)| (residual.as_dvec3() - classes.light(sample)).element_sum() / 3.0;
        let rests: Vec<f64> = samples.iter().zip(&residuals).map(rest).collect();
        let most = MAX_DEVIATIONS * (rests.iter().map(|rest| rest * rest).sum::<f64>() / count).sqrt();
        for (sample, rest) in samples.iter().zip(rests) {
            let rest = rest.clamp(-most, most);
            let place = ((sample.at() - low) / (high - low) * finest as f64)
                .clamp(DVec2::ZERO, DVec2::splat(finest as f64 - 0.01));
            let hidden = rest.abs() * (radius_m * f64::from(sample.nearness)).min(1.0).powi(3);
            let cell = &mut cells[place.x as usize + finest * place.y as usize];
            [1.0, rest, hidden, hidden * hidden].iter().zip(cell).for_each(|(add, sum)| *sum += add);
            squared += rest * rest;
            near += hidden;
        }
        // Freed of their own noise.
        let in_cells =
            cells.iter().filter(|cell| cell[0] >= 2.0).map(|cell| (cell[2] * cell[2] - cell[3]) / (cell[0] - 1.0));
        let near_squared = (in_cells.sum::<f64>() / count).max((near / count).powi(2));
        let mut sums: Vec<[f64; 2]> = cells.iter().map(|cell| [cell[0], cell[1]]).collect();
        let (mut finer, mut number, mut now) = ([CellSums::default(); 3], 0, finest);
        let cells = loop {
            let sums_now = CellSums::of(now, &sums, count);
            if now == side {
                break sums_now;
            }
            finer[number] = sums_now;
            number += 1;
            sums = coarser(&sums, now);
            now /= 2;
        };
        let free = (count - cells.filled - classes.values() as f64).max(MIN_FREE * count).max(1.0);
        let variance = ((squared - count * cells.squared) / free).max(0.0);
        let mean = samples.iter().map(|sample| f64::from(sample.light.element_sum())).sum::<f64>() / (3.0 * count);
        let evidence =
            Self { samples: count, mean, variance, near_squared: NEAR_VARIES.powi(2) * near_squared, cells, finer };
        (evidence, classes)
    }
}

impl CellSums {
    fn of(side: usize, sums: &[[f64; 2]], count: f64) -> Self {
        let filled = || sums.iter().filter(|sum| sum[0] > 0.0);
        let squared = filled().map(|[count, sum]| sum * sum / count).sum::<f64>() / count;
        Self { side, filled: filled().count() as f64, squared }
    }

    /// What is more than chance, and the standard deviation of chance.
    fn excess(&self, by_chance: f64) -> [f64; 2] {
        [self.squared - self.filled * by_chance, (2.0 * self.filled).sqrt() * by_chance]
    }
}

/// Four cells to one.
fn coarser(sums: &[[f64; 2]], side: usize) -> Vec<[f64; 2]> {
    let half = side / 2;
    let mut coarse = vec![[0.0; 2]; half * half];
    for (number, sum) in sums.iter().enumerate() {
        let cell = &mut coarse[(number % side) / 2 + half * (number / side / 2)];
        cell.iter_mut().zip(sum).for_each(|(cell, sum)| *cell += sum);
    }
    coarse
}

/// Sizes of cells that have a chance of their own: 2, 4, 8, 16 across.
const SIZES: usize = 4;
/// What is supposed of them: samples that are stratified leave less to chance the larger a cell is.
const SUPPOSED_CHANCE: [f64; SIZES] = [0.5, 0.7, 0.75, 0.8];
/// Classes of how much near geometry may hide, as a share of the variance.
const NEAR_CLASSES: [f64; 4] = [2e-3, 1e-2, 4e-2, 0.16];

/// What all leaves say together.
#[derive(Clone, Debug)]
pub(super) struct Pool {
    /// The share of the variance that sums over cells have by chance, by size of cells.
    chance: [f64; SIZES],
    /// How far near geometry is to be believed, by its classes.
    trust: [f64; NEAR_CLASSES.len() + 1],
    /// Variance of light over the square of its mean.
    relative_variance: f64,
    /// No spread is taken to be less, in W/m2.
    least_spread: f64,
}

fn size(side: usize) -> usize {
    (side.max(2).ilog2() as usize - 1).min(SIZES - 1)
}

fn near_class(evidence: &Evidence) -> usize {
    let share = evidence.near_squared / evidence.variance.max(f64::MIN_POSITIVE);
    NEAR_CLASSES.iter().filter(|&&least| share >= least).count()
}

impl Pool {
    /// Puts together what leaves of these areas say; no spread is less than `least_spread`.
    pub(super) fn new<'a>(leaves: impl Iterator<Item = (f64, &'a Evidence)> + Clone, least_spread: f64) -> Self {
        let mut sums = [[0.0_f64; 3]; SIZES];
        let (mut relative_variance, mut many) = (OF_SUPPOSED, OF_SUPPOSED);
        for (area_m2, evidence) in leaves.clone() {
            if evidence.mean > 0.0 {
                relative_variance += (evidence.variance / evidence.mean.powi(2)).min(10.0);
                many += 1.0;
            }
            if near_class(evidence) > 0 {
                continue;
            }
            for cells in [&evidence.cells].into_iter().chain(&evidence.finer).filter(|cells| cells.side > 0) {
                let by_chance = area_m2 * cells.filled * evidence.variance / evidence.samples;
                let of_size = &mut sums[size(cells.side)];
                [area_m2 * cells.squared, by_chance, by_chance * by_chance]
                    .iter()
                    .zip(of_size)
                    .for_each(|(add, sum)| *sum += add);
            }
        }
        let chance = std::array::from_fn(|i| {
            let [found, by_chance, squared] = sums[i];
            if squared <= 0.0 {
                return SUPPOSED_CHANCE[i];
            }
            let leaves = by_chance * by_chance / squared;
            ((OF_SUPPOSED * SUPPOSED_CHANCE[i] + leaves * found / by_chance) / (OF_SUPPOSED + leaves)).clamp(0.4, 0.9)
        });
        let mut pool = Self {
            chance,
            trust: [1.0; NEAR_CLASSES.len() + 1],
            relative_variance: relative_variance / many,
            least_spread,
        };
        let mut sums = [[0.0_f64; 3]; NEAR_CLASSES.len() + 1];
        for (area_m2, evidence) in leaves {
            let by_chance = pool.by_chance(&evidence.cells, evidence.variance, evidence.samples);
            let [excess, _] = evidence.cells.excess(by_chance);
            let of_class = &mut sums[near_class(evidence)];
            let variance = 2.0 * evidence.cells.filled * (area_m2 * by_chance).powi(2);
            [area_m2 * excess, variance, area_m2 * evidence.near_squared]
                .iter()
                .zip(of_class)
                .for_each(|(add, sum)| *sum += add);
        }
        for (trust, [excess, variance, near]) in pool.trust.iter_mut().zip(sums) {
            if near > 0.0 {
                let doubt = 4.0 * (variance / (near * near)).max(1e-12);
                *trust = ((excess / near / doubt + 1.0) / (1.0 / doubt + 1.0)).clamp(0.03, 3.0);
            }
        }
        pool
    }

    fn by_chance(&self, cells: &CellSums, variance: f64, samples: f64) -> f64 {
        self.chance[size(cells.side)] * variance / samples
    }

    /// What the evidence of a leaf comes to beside that of all.
    pub(super) fn judge(&self, evidence: &Evidence) -> Judged {
        let samples = evidence.samples;
        let supposed = self.relative_variance * evidence.mean * evidence.mean;
        let variance = (samples * evidence.variance + OF_SUPPOSED_SPREAD * supposed) / (samples + OF_SUPPOSED_SPREAD);
        let [excess, deviation] = evidence.cells.excess(self.by_chance(&evidence.cells, variance, samples));
        let prior = (self.trust[near_class(evidence)] * evidence.near_squared).max(f64::MIN_POSITIVE);
        // The mean of both, weighted by how sure they are.
        let (of_prior, of_chance) = (prior * prior, deviation * deviation);
        let both = (excess.max(0.0) * of_prior + prior * of_chance) / (of_prior + of_chance);
        let mut misfit = if both.is_finite() { both } else { 0.0 };
        if samples >= MIN_SAMPLES {
            misfit = misfit.max(excess - SURE * deviation);
        }
        for cells in evidence.finer.iter().filter(|cells| cells.side > 0) {
            let [excess, deviation] = cells.excess(self.by_chance(cells, variance, samples));
            misfit = misfit.max(excess - SURE * deviation);
        }
        Judged { misfit, spread: variance.sqrt().max(self.least_spread) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texels::{Draws, Sequence, key_of};

    #[test]
    fn misfit_is_told_from_noise() {
        let square = [DVec2::ZERO, DVec2::new(1.0, 0.0), DVec2::ONE, DVec2::new(0.0, 1.0)];
        let elements =
            [Element::new([square[0], square[1], square[2]]), Element::new([square[0], square[2], square[3]])];
        let values = vec![Rgb::ONE; 1];
        let judged = |wave: f32| {
            let samples: Vec<Sample> = (0..2048)
                .map(|i| {
                    let sequence = Sequence::new(5);
                    let [s, t, u, v] = sequence.at(i);
                    // Light of half of all directions, and a wave over the leaf that the fit does not know.
                    let noise = if Draws::new(key_of(i, 1)).next() < 0.5 { 2.0 } else { 0.0 };
                    let light = Vec3::splat(noise + wave * (9.0 * s).sin());
                    let direction = [u, v].map(|share| (share * 65_536.0) as u16);
                    Sample { at_m: [s, t], light, direction, ..Sample::default() }
                })
                .collect();
            let (evidence, _) = Evidence::of(&square, (&samples, false), &elements, &values);
            Pool::new([(1.0, &evidence)].into_iter(), 0.0).judge(&evidence)
        };
        let [right, wrong] = [0.0, 0.5].map(judged);
        assert!((0.8..1.1).contains(&right.spread) && right.misfit < 2e-4, "{right:?}");
        // The mean square of the wave is an eighth of the square of its height.
        assert!((0.05..0.14).contains(&wrong.misfit), "{wrong:?}");
    }
}
