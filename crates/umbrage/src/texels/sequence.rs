//! Random numbers that are spread evenly: scrambled Sobol' points, one sequence for each key.
//!
//! Points of a sequence are stratified in four dimensions at once, so that the mean over many of them errs far less than chance; those
//! of two keys have nothing to do with each other (Burley, *Practical hash-based Owen scrambling*, 2020; crate `sobol_burley`).
//!
//! Holds: number and key tell the point, whatever was asked before and by whatever thread.

/// The crate knows so many points of a sequence; later ones are those of another.
const POINTS_OF_SEED: usize = 1 << 16;

/// A sequence of points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sequence {
    key: u64,
}

impl Sequence {
    /// The sequence of a key.
    pub(crate) fn new(key: u64) -> Self {
        Self { key }
    }

    /// A point of the unit cube in four dimensions.
    pub(crate) fn at(&self, number: usize) -> [f32; 4] {
        self.dimensions(number, 0)
    }

    /// Four numbers more that belong to the same point.
    pub(crate) fn more_at(&self, number: usize) -> [f32; 4] {
        self.dimensions(number, 1)
    }

    /// One set of four dimensions of a point.
    fn dimensions(&self, number: usize, set: u32) -> [f32; 4] {
        let seed = mix(self.key ^ ((number / POINTS_OF_SEED) as u64) << 40) as u32;
        sobol_burley::sample_4d((number % POINTS_OF_SEED) as u32, set, seed)
    }
}

/// Random numbers one after the other, without strata: for choices that are averaged over many points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draws(u64);

impl Draws {
    /// The numbers of a key.
    pub(crate) fn new(key: u64) -> Self {
        Self(key)
    }

    /// The next number, from 0 on and below 1.
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = mix(self.0);
        (self.0 >> 40) as f32 / (1_u32 << 24) as f32
    }
}

/// The key of a thing with this number, for one of several uses.
pub(crate) fn key_of(number: usize, of_use: u64) -> u64 {
    mix(number as u64 ^ (of_use << 48))
}

/// A bijection after which every bit depends on all bits (Steele, Lea and Flood, *Fast splittable pseudorandom number generators*,
/// 2014).
fn mix(bits: u64) -> u64 {
    let next = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let once = (next ^ (next >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let twice = (once ^ (once >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    twice ^ (twice >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_errs_less_than_chance_and_sequences_differ() {
        // The integral of a product of two coordinates that come from different pairs.
        let mean = |key: u64, count: usize| {
            let sequence = Sequence::new(key_of(7, key));
            let product = |i: usize| {
                let [a, _, c, _] = sequence.at(i);
                f64::from(a) * f64::from(c)
            };
            (0..count).map(product).sum::<f64>() / count as f64
        };
        let errors: Vec<f64> = (0..50).map(|key| mean(key, 1024) - 0.25).collect();
        let rms = (errors.iter().map(|error| error * error).sum::<f64>() / 50.0).sqrt();
        // By chance it would be 0.22 / 32.
        assert!(rms < 0.001, "{rms}");
        let distinct = errors.windows(2).all(|pair| pair[0] != pair[1]);
        assert!(distinct);
        // Past the numbers that the crate knows it goes on with others.
        let sequence = Sequence::new(3);
        assert_ne!(sequence.at(1), sequence.at(1 + POINTS_OF_SEED));
    }
}
