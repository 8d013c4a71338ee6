//! Transforms and arrays: `xf -t 1 0 0 -a 3 -t 0 0 2` and their like.
//!
//! Arguments act one after the other on what is enclosed. `-i n` repeats those after it, up to the next `-i` or `-a`, n
//! times; `-a n` does so 0, 1, ... n - 1 times, once for every element of an array. Several `-a` make an array of
//! arrays, the last one counting fastest. Mirroring and negative scales turn the sense of polygons.

use glam::{DAffine3, DQuat, DVec3};

use crate::FormatError;
use crate::text::{EXPORT_AGAIN, Place, shortened};

/// Arguments of a transform, and which element of its arrays is at hand.
#[derive(Clone, Debug)]
pub(super) struct Transform {
    /// The arguments before, between and after `-i` and `-a`, each as one transform.
    parts: Vec<Part>,
}

/// Arguments that are repeated together.
#[derive(Clone, Copy, Debug)]
struct Part {
    transform: DAffine3,
    /// How many times it acts: for an array, which element is at hand.
    times: u32,
    /// Elements of the array, if it is one.
    elements: Option<u32>,
}

impl Transform {
    /// Reads arguments; the first element of each array is at hand.
    pub(super) fn parse(place: Place<'_>, words: &[&str]) -> Result<Self, FormatError> {
        let mut parts = vec![Part { transform: DAffine3::IDENTITY, times: 1, elements: None }];
        let mut words = words.iter().copied();
        while let Some(word) = words.next() {
            let mut number = |what: &str| {
                let word = words.next().ok_or_else(|| place.bad(format!("{what} lacks a number"), EXPORT_AGAIN))?;
                place.finite(word)
            };
            let step = match word {
                "-t" => DAffine3::from_translation(DVec3::new(number(word)?, number(word)?, number(word)?)),
                "-rx" => DAffine3::from_quat(DQuat::from_rotation_x(number(word)?.to_radians())),
                "-ry" => DAffine3::from_quat(DQuat::from_rotation_y(number(word)?.to_radians())),
                "-rz" => DAffine3::from_quat(DQuat::from_rotation_z(number(word)?.to_radians())),
                "-s" => match number(word)? {
                    0.0 => return Err(place.bad("a scale of 0 leaves nothing", "give another scale")),
                    scale => DAffine3::from_scale(DVec3::splat(scale)),
                },
                "-mx" => DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
                "-my" => DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0)),
                "-mz" => DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)),
                "-i" | "-a" => {
                    let count = number(word)?;
                    let least = if word == "-a" { 1.0 } else { 0.0 };
                    if count.fract() != 0.0 || !(least..=1e6).contains(&count) {
                        return Err(place.bad(format!("{word} {count} is no sound number of times"), EXPORT_AGAIN));
                    }
                    // A whole number up to a million.
                    let count = count as u32;
                    let (times, elements) = if word == "-a" { (0, Some(count)) } else { (count, None) };
                    parts.push(Part { transform: DAffine3::IDENTITY, times, elements });
                    continue;
                }
                _ => {
                    let what = format!("{:?} is not an argument of a transform", shortened(word));
                    return Err(place.bad(what, "use -t, -rx, -ry, -rz, -s, -mx, -my, -mz, -i or -a"));
                }
            };
            if let Some(part) = parts.last_mut() {
                part.transform = step * part.transform;
            }
        }
        Ok(Self { parts })
    }

    /// Parts that are multiplied for each element.
    pub(super) fn part_count(&self) -> usize {
        self.parts.len()
    }

    /// The transform for the element at hand.
    pub(super) fn current(&self) -> DAffine3 {
        self.parts.iter().fold(DAffine3::IDENTITY, |all, part| power(part.transform, part.times) * all)
    }

    /// Takes the next element of the arrays; false if there is none.
    pub(super) fn advance(&mut self) -> bool {
        for part in self.parts.iter_mut().rev() {
            let Some(elements) = part.elements else { continue };
            part.times += 1;
            if part.times < elements {
                return true;
            }
            part.times = 0;
        }
        false
    }
}

/// A transform applied so many times, by squaring.
fn power(transform: DAffine3, mut times: u32) -> DAffine3 {
    let (mut result, mut square) = (DAffine3::IDENTITY, transform);
    while times > 0 {
        if times & 1 == 1 {
            result = square * result;
        }
        square = square * square;
        times >>= 1;
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Transform, FormatError> {
        Transform::parse(Place { file: "a.mgf", line: 1 }, &text.split_whitespace().collect::<Vec<_>>())
    }

    fn points(text: &str, p: [f64; 3]) -> Vec<[i64; 3]> {
        let mut transform = parse(text).unwrap();
        let mut points = Vec::new();
        loop {
            let point = transform.current().transform_point3(p.into()).to_array();
            points.push(point.map(|x| (x * 1000.0).round() as i64));
            if !transform.advance() {
                return points;
            }
        }
    }

    #[test]
    fn arguments_act_one_after_the_other() {
        assert_eq!(points("-t 1 0 0 -rz 90", [0.0; 3]), [[0, 1000, 0]]);
        assert_eq!(points("-rz 90 -t 1 0 0", [0.0; 3]), [[1000, 0, 0]]);
        assert_eq!(points("-s 2 -mx", [1.0, 2.0, 3.0]), [[-2000, 4000, 6000]]);
        assert_eq!(points("-rx 90", [0.0, 1.0, 0.0]), [[0, 0, 1000]]);
        assert_eq!(points("-ry 90", [0.0, 0.0, 1.0]), [[1000, 0, 0]]);
        assert_eq!(points("", [1.0, 2.0, 3.0]), [[1000, 2000, 3000]]);
    }

    #[test]
    fn repetitions_and_arrays() {
        assert_eq!(points("-t 1 0 0 -i 3 -t 0 1 0 -i 1 -t 0 0 1", [0.0; 3]), [[1000, 3000, 1000]]);
        assert_eq!(points("-t 1 0 0 -a 3 -t 0 2 0", [0.0; 3]), [[1000, 0, 0], [1000, 2000, 0], [1000, 4000, 0]]);
        let grid = points("-a 2 -t 1 0 0 -a 2 -t 0 1 0 -i 1 -t 0 0 5", [0.0; 3]);
        assert_eq!(grid, [[0, 0, 5000], [0, 1000, 5000], [1000, 0, 5000], [1000, 1000, 5000]]);
        assert_eq!(points("-a 4 -rz 90", [1.0, 0.0, 0.0])[3], [0, -1000, 0]);
    }

    #[test]
    fn bad_arguments_are_named() {
        for (text, words) in [
            ("-t 1 2", "-t lacks a number"),
            ("-q 1", "\"-q\" is not an argument"),
            ("5", "\"5\" is not an argument"),
            ("-a 0 -t 1 0 0", "-a 0 is no sound"),
            ("-a 2.5", "-a 2.5"),
            ("-a 99999999", "sound number"),
            ("-s 0", "leaves nothing"),
            ("-rx nan", "not finite"),
        ] {
            let message = parse(text).unwrap_err().to_string();
            assert!(message.starts_with("a.mgf: line 1: ") && message.contains(words), "{message}");
        }
    }
}
