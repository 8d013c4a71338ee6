//! How good a splitting edge is (paper, section 5, Eq. 1): the least score wins.
//!
//! Eq. (1), |A1 - A2| |e|, is zero for every chord that halves the area: in a 10 x 1 rectangle with points in the
//! middle of its long sides the diagonal ties with the short cross-cut. The default has no such tie and shuns small
//! angles.

use std::fmt;
use std::str::FromStr;

/// Weight of the chord's length where it halves the area, against the share of area by which it does not.
const LENGTH_WEIGHT: f64 = 0.5;
/// Added to the sine of the least angle, so that a right angle is about six times as good as none.
const ANGLE_FLOOR: f64 = 0.2;

/// Which score `point_split` minimises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SplitScore {
    /// Eq. (1) as printed: |A1 - A2| |e|.
    Eq1,
    /// (|A1 - A2| / A + 1/2) |e| / sqrt(A), divided by the sine of the least angle that the chord makes.
    #[default]
    WellShaped,
}

/// A chord that would split a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Chord {
    /// Areas of the two parts, in square metres.
    pub(super) areas_m2: [f64; 2],
    /// Length, in metres.
    pub(super) length_m: f64,
    /// Sine of the least angle between the chord and the boundary at its ends.
    pub(super) least_sine: f64,
}

impl SplitScore {
    /// The score of a chord: less is better.
    pub(super) fn of(self, chord: &Chord) -> f64 {
        let difference_m2 = (chord.areas_m2[0] - chord.areas_m2[1]).abs();
        match self {
            Self::Eq1 => difference_m2 * chord.length_m,
            Self::WellShaped => {
                let area_m2 = chord.areas_m2[0] + chord.areas_m2[1];
                (difference_m2 / area_m2 + LENGTH_WEIGHT) * chord.length_m
                    / area_m2.sqrt()
                    / (chord.least_sine.max(0.0) + ANGLE_FLOOR)
            }
        }
    }
}

impl fmt::Display for SplitScore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Eq1 => "eq1",
            Self::WellShaped => "well-shaped",
        })
    }
}

/// The name is that of no score.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no score {0:?}: use eq1 or well-shaped")]
pub struct ParseScoreError(String);

impl FromStr for SplitScore {
    type Err = ParseScoreError;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        [Self::Eq1, Self::WellShaped]
            .into_iter()
            .find(|score| score.to_string() == name)
            .ok_or_else(|| ParseScoreError(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chords of a 10 x 1 rectangle with points in the middle of its long sides.
    fn cross_cut_and_diagonal() -> [Chord; 2] {
        let long = 101.0_f64.sqrt();
        [
            Chord { areas_m2: [5.0, 5.0], length_m: 1.0, least_sine: 1.0 },
            Chord { areas_m2: [5.0, 5.0], length_m: long, least_sine: 1.0 / long },
        ]
    }

    #[test]
    fn equation_1_ties_every_halving_chord() {
        let [cross_cut, diagonal] = cross_cut_and_diagonal();
        assert_eq!(SplitScore::Eq1.of(&cross_cut), SplitScore::Eq1.of(&diagonal));
    }

    #[test]
    fn the_default_prefers_the_short_cross_cut() {
        let [cross_cut, diagonal] = cross_cut_and_diagonal();
        assert!(SplitScore::WellShaped.of(&cross_cut) < SplitScore::WellShaped.of(&diagonal));
    }

    #[test]
    fn equation_1_is_area_difference_times_length() {
        assert_eq!(SplitScore::Eq1.of(&Chord { areas_m2: [3.0, 5.0], length_m: 4.0, least_sine: 1.0 }), 8.0);
    }

    #[test]
    fn names_round_trip() {
        for score in [SplitScore::Eq1, SplitScore::WellShaped] {
            assert_eq!(score.to_string().parse(), Ok(score));
        }
        assert!("eq2".parse::<SplitScore>().is_err());
    }
}
