//! What a check found, and how the errors of bake and check are told apart.
//!
//! At each point the mean of `K` batches differs from the truth by chance, with a variance that the batches' spread
//! tells. The mean squared difference between bake and check, less that variance, is the mean squared error of the
//! bake, without bias.

use glam::DVec3;
use umbrage::scene::Rgb;

use crate::path::BATCHES;

/// A number and the standard error of its estimate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// A point that was checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckedPoint {
    /// Where it is, in metres.
    pub position_m: DVec3,
    /// The side that it is on.
    pub normal: DVec3,
    /// Irradiance by the bake, in W/m2.
    pub baked: Rgb,
    /// Irradiance by paths, in W/m2.
    pub traced: Rgb,
    /// Standard error of it, in W/m2.
    pub traced_error: Rgb,
}

impl CheckedPoint {
    pub(crate) fn new(position_m: DVec3, normal: DVec3, baked: Rgb, batches: &[Rgb; BATCHES]) -> Self {
        let count = BATCHES as f64;
        let traced = batches.iter().sum::<Rgb>() / count;
        let spread = batches.iter().map(|batch| (batch - traced) * (batch - traced)).sum::<Rgb>();
        let variance = spread / (count - 1.0) / count;
        Self { position_m, normal, baked, traced, traced_error: variance.map(f64::sqrt) }
    }

    /// The greatest error over the colours, less one standard error of the check, in W/m2.
    fn sure_error(&self) -> f64 {
        ((self.baked - self.traced).abs() - self.traced_error).max_element()
    }
}

/// What a check found. Errors and biases are shares of the mean irradiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Points that were compared.
    pub compared: usize,
    /// Points that no light reaches and that the bake does not show, or that see nothing but backs: they are left out.
    pub buried: usize,
    /// Points where the bake has no triangle that looks the same way.
    pub uncovered: usize,
    /// Compared points that no light reaches.
    pub dark: usize,
    /// Dark and buried points that the bake lights by more than a thousandth of the mean, the brightest first.
    pub leaks: Vec<CheckedPoint>,
    /// Mean irradiance by paths over the compared points and the colours, in W/m2.
    pub mean_irradiance: f64,
    /// Root mean square error of the bake; the check's own is taken off.
    pub error: Estimate,
    /// Root mean square error of the check itself, which was taken off.
    pub noise: f64,
    /// Mean error of the bake, with its sign.
    pub bias: Estimate,
    /// The points with the greatest error, the worst first.
    pub worst: Vec<CheckedPoint>,
    /// Paths that were followed.
    pub paths: u64,
    /// Rays that were sent.
    pub rays: u64,
}

/// What is lit by more than this share of the mean, and should be dark, is a leak.
const LEAK_OF_MEAN: f64 = 1e-3;
/// How many of the worst points are told.
const WORST: usize = 8;

/// Mean of numbers, and its standard error.
fn mean(values: &[f64]) -> Estimate {
    let count = values.len() as f64;
    let value = values.iter().sum::<f64>() / count.max(1.0);
    let spread: f64 = values.iter().map(|x| (x - value).powi(2)).sum();
    let standard_error = if values.len() > 1 { (spread / (count - 1.0) / count).sqrt() } else { 0.0 };
    Estimate { value, standard_error }
}

impl Report {
    /// Compares points; `buried` ones only for leaks.
    pub(crate) fn new(
        points: &[CheckedPoint],
        buried: &[CheckedPoint],
        uncovered: usize,
        paths: u64,
        rays: u64,
    ) -> Self {
        let over_colours = |of: &dyn Fn(&CheckedPoint) -> Rgb| -> Vec<f64> {
            points.iter().map(|point| of(point).element_sum() / 3.0).collect()
        };
        let mean_irradiance = mean(&over_colours(&|p| p.traced)).value;
        // A dark scene has no shares: all is then told in W/m2.
        let unit = if mean_irradiance > 0.0 { mean_irradiance } else { 1.0 };
        let variance = |p: &CheckedPoint| p.traced_error * p.traced_error;
        let difference = |p: &CheckedPoint| p.baked - p.traced;
        let squared = mean(&over_colours(&|p| difference(p) * difference(p) - variance(p)));
        let noise = mean(&over_colours(&variance)).value.sqrt() / unit;
        let root = squared.value.max(0.0).sqrt();
        // The derivative of the root, and where that has none, the root of the error.
        let doubtful = squared.standard_error / (2.0 * root).max(squared.standard_error.sqrt()).max(f64::MIN_POSITIVE);
        let bias = mean(&over_colours(&difference));

        let is_dark = |p: &&CheckedPoint| p.traced == Rgb::ZERO;
        let shows = |p: &CheckedPoint| p.baked.max_element();
        let dark = points.iter().filter(is_dark);
        let mut leaks: Vec<CheckedPoint> =
            dark.clone().chain(buried).filter(|p| shows(p) > LEAK_OF_MEAN * unit).copied().collect();
        leaks.sort_by(|p, q| shows(q).total_cmp(&shows(p)));
        let mut worst: Vec<CheckedPoint> = points.to_vec();
        worst.sort_by(|p, q| q.sure_error().total_cmp(&p.sure_error()));
        worst.truncate(WORST);
        Self {
            compared: points.len(),
            buried: buried.len(),
            uncovered,
            dark: dark.count(),
            leaks,
            mean_irradiance,
            error: Estimate { value: root / unit, standard_error: doubtful / unit },
            noise,
            bias: Estimate { value: bias.value / unit, standard_error: bias.standard_error / unit },
            worst,
            paths,
            rays,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fastrand::Rng;

    /// Nearly normal numbers: the sum of twelve even ones.
    fn normal(rng: &mut Rng) -> f64 {
        (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0
    }

    /// A check with noise of `noise` of a bake with errors of `error` and a bias.
    fn report(error: f64, bias: f64, noise: f64) -> Report {
        let mut rng = Rng::with_seed(3);
        let points: Vec<CheckedPoint> = (0..4000)
            .map(|_| {
                let truth = Rgb::ONE;
                let baked = truth + bias + error * normal(&mut rng);
                let per_batch = noise * (BATCHES as f64).sqrt();
                let batches = [(); BATCHES].map(|()| truth + per_batch * normal(&mut rng));
                CheckedPoint::new(DVec3::ZERO, DVec3::Z, baked, &batches)
            })
            .collect();
        Report::new(&points, &[], 0, 0, 0)
    }

    #[test]
    fn the_checks_own_noise_is_taken_off() {
        for (error, bias, noise) in [(0.01, 0.0, 0.02), (0.01, 0.003, 0.002), (0.0, 0.0, 0.02)] {
            let report = report(error, bias, noise);
            let truth = error.hypot(bias);
            let slack = 4.0 * report.error.standard_error;
            assert!((report.error.value - truth).abs() < slack && slack < 0.01, "{report:?}");
            assert!((report.noise / noise - 1.0).abs() < 0.05, "{report:?}");
            assert!((report.bias.value - bias).abs() < 4.0 * report.bias.standard_error, "{report:?}");
        }
    }

    #[test]
    fn what_should_be_dark_and_is_not_leaks() {
        let point = |baked: f64, traced: f64| {
            CheckedPoint::new(DVec3::ZERO, DVec3::Z, Rgb::splat(baked), &[Rgb::splat(traced); BATCHES])
        };
        let points = [point(1.0, 1.0), point(0.0, 0.0), point(0.5, 0.0), point(1e-5, 0.0)];
        let report = Report::new(&points, &[point(0.7, 0.0), point(0.0, 0.0)], 3, 10, 20);
        assert_eq!((report.compared, report.dark, report.buried, report.uncovered), (4, 3, 2, 3));
        assert_eq!(report.leaks.iter().map(|leak| leak.baked.x).collect::<Vec<_>>(), [0.7, 0.5]);
        assert_eq!(report.worst[0].baked.x, 0.5);
    }
}
