//! Chains of edges of hard shadows, straightened.
//!
//! The shadow of a round thing is a chain of short segments; that of a thing of thick sheets, or turned on a lathe, has long ones and others a
//! hundred times shorter in turn. Each segment takes its triangles, and a short one a needle from wherever the next corner is, which
//! renderers with coarse numbers show in a wrong light. The mesh is no finer than its shortest edge: what lies nearer to a line than a
//! part of that is on the line. So segments that follow each other are one hint from end to end where no corner between them lies off it.
//!
//! How: from each corner that is kept, a sleeve of directions that pass all corners since near enough is narrowed corner by corner; the
//! last one that was in it is kept (Williams, *Bounded straight-line approximation of digitized planar curves and lines*, 1981). It takes a time
//! in proportion to the number of corners.
//!
//! Before: hints of degree 0 on one face. After: no more of them, with ends among the ends of before; where three meet, or a chain ends,
//! there is an end as before.

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::EdgeHint;
use crate::id::LampId;

/// A hint, and the lamp whose light jumps there.
pub(super) type LampHint = (EdgeHint, LampId);

/// Ends that lie in one cell of this share of the greatest distance are one point: they are the same corner of an occluder, seen from the
/// same lamp, with the rounding of `f64`. Two that rounding parts are no chain, and stay.
const CELL: f64 = 1e-3;

type Cell = (LampId, i64, i64);

/// The hints that are left of some; no corner that goes is farther than `within_m` from the hint in its place.
pub(super) fn straightened(hints: &[LampHint], within_m: f64) -> Vec<EdgeHint> {
    let cell_of = |point_m: DVec2, lamp: LampId| -> Cell {
        let at = (point_m / (CELL * within_m)).round();
        (lamp, at.x as i64, at.y as i64)
    };
    let mut at: FxHashMap<Cell, Vec<(usize, usize)>> = FxHashMap::default();
    for (number, (hint, lamp)) in hints.iter().enumerate() {
        for (end, &point_m) in hint.ends_m.iter().enumerate() {
            at.entry(cell_of(point_m, *lamp)).or_default().push((number, end));
        }
    }
    // The hint that goes on from an end of another, and its nearer end.
    let next = |(number, end): (usize, usize)| {
        let (hint, lamp) = &hints[number];
        match at.get(&cell_of(hint.ends_m[end], *lamp)).map(Vec::as_slice) {
            Some(&[one, other]) => {
                let next = if one == (number, end) { other } else { one };
                (next.0 != number && hints[next.0].0.needed == hint.needed).then_some(next)
            }
            _ => None,
        }
    };
    let mut is_used = vec![false; hints.len()];
    let mut left = Vec::new();
    for first in 0..hints.len() {
        if is_used[first] {
            continue;
        }
        // Back to where the chain begins, or around a closed one.
        let mut start = (first, 0);
        while let Some((before, nearer)) = next(start).filter(|&(before, _)| before != first) {
            start = (before, 1 - nearer);
        }
        let mut chain = Vec::new();
        let mut enters = Some(start);
        while let Some((number, end)) = enters.filter(|&(number, _)| !is_used[number]) {
            is_used[number] = true;
            chain.push((number, end));
            enters = next((number, 1 - end));
        }
        let mut points_m: Vec<DVec2> = chain.iter().map(|&(number, end)| hints[number].0.ends_m[end]).collect();
        points_m.extend(chain.last().map(|&(number, end)| hints[number].0.ends_m[1 - end]));
        for run in kept(&points_m, within_m).windows(2) {
            let of_run = chain[run[0]..run[1]].iter().map(|&(number, _)| &hints[number].0);
            let strength = of_run.map(|hint| hint.strength).fold(0.0, f64::max);
            let whole = EdgeHint { strength, ends_m: [points_m[run[0]], points_m[run[1]]], ..hints[chain[run[0]].0].0 };
            left.push(whole);
        }
    }
    left
}

/// The numbers of the corners of a chain that are kept, its ends among them.
fn kept(points_m: &[DVec2], within_m: f64) -> Vec<usize> {
    let mut kept = vec![0];
    let mut sleeve: Option<[DVec2; 2]> = None;
    let mut from = 0;
    let mut number = 1;
    while number < points_m.len() {
        let step = points_m[number] - points_m[from];
        let is_in = sleeve.is_none_or(|[right, left]| right.perp_dot(step) >= 0.0 && step.perp_dot(left) >= 0.0);
        // A chain that turns back is not followed by a line.
        let goes_on = number == from + 1 || step.dot(points_m[number] - points_m[number - 1]) > 0.0;
        if number > from + 1 && !(is_in && goes_on) {
            from = number - 1;
            kept.push(from);
            sleeve = None;
            continue;
        }
        let length_m = step.length();
        if length_m > within_m {
            let turn_rad = (within_m / length_m).asin();
            let [right, left] =
                [-turn_rad, turn_rad].map(|turn_rad| DVec2::from_angle(turn_rad).rotate(step / length_m));
            sleeve = Some(sleeve.map_or([right, left], |[before_right, before_left]| {
                let narrower = |is_narrower: bool, new: DVec2, old: DVec2| if is_narrower { new } else { old };
                [
                    narrower(before_right.perp_dot(right) > 0.0, right, before_right),
                    narrower(left.perp_dot(before_left) > 0.0, left, before_left),
                ]
            }));
        }
        number += 1;
    }
    kept.push(points_m.len() - 1);
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discontinuity::Degree;
    use proptest::prelude::*;

    fn chain(points: &[DVec2]) -> Vec<LampHint> {
        let hint = |(number, ends): (usize, &[DVec2])| {
            // Every other one runs the other way.
            let ends_m = if number.is_multiple_of(2) { [ends[0], ends[1]] } else { [ends[1], ends[0]] };
            let hint = EdgeHint { d_segment: number.into(), degree: Degree::D0, strength: 1.0, needed: true, ends_m };
            (hint, LampId::from(0))
        };
        points.windows(2).enumerate().map(hint).collect()
    }

    fn circle(corners: u32) -> Vec<DVec2> {
        let angle = |i: u32| std::f64::consts::TAU * f64::from(i % corners) / f64::from(corners);
        (0..=corners).map(|i| DVec2::from_angle(angle(i))).collect()
    }

    fn distance_m(point: DVec2, [from, to]: [DVec2; 2]) -> f64 {
        let t = ((point - from).dot(to - from) / from.distance_squared(to)).clamp(0.0, 1.0);
        from.lerp(to, t).distance(point)
    }

    #[test]
    fn a_circle_keeps_as_many_edges_as_its_height_over_a_chord_asks_for() {
        for within_m in [1e-5, 1e-4, 1e-3] {
            let left = straightened(&chain(&circle(10_000)), within_m);
            // A chord over the angle a is up to a^2 / 8 from the circle.
            let least = std::f64::consts::TAU / (8.0 * within_m).sqrt();
            let count = left.len() as f64;
            assert!(count > 0.7 * least && count < 1.6 * least, "{count} edges, {least} are needed");
        }
    }

    #[test]
    fn short_edges_between_long_ones_go_and_a_square_stays() {
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0)].map(DVec2::from);
        assert_eq!(straightened(&chain(&square), 1e-3).len(), 4);
        let stepped: Vec<DVec2> =
            (0..20).flat_map(|i| [0.0, 0.01].map(|more| DVec2::from_angle(0.2 * (f64::from(i) + more)))).collect();
        let left = straightened(&chain(&stepped), 1e-3).len();
        assert!((19..=20).contains(&left), "{left} of 39");
    }

    #[test]
    fn where_three_meet_or_the_lamp_is_another_there_is_an_end() {
        let line: Vec<DVec2> = (0..5).map(|i| DVec2::new(f64::from(i), 0.0)).collect();
        assert_eq!(straightened(&chain(&line), 1e-3).len(), 1);
        let mut crossed = chain(&line);
        crossed.push((EdgeHint { ends_m: [line[2], DVec2::new(2.0, 1.0)], ..crossed[0].0 }, LampId::from(0)));
        assert_eq!(straightened(&crossed, 1e-3).len(), 3);
        let mut of_two = chain(&line);
        of_two[3].1 = LampId::from(1);
        assert_eq!(straightened(&of_two, 1e-3).len(), 2);
    }

    proptest! {
        #[test]
        fn no_corner_is_farther_from_what_is_left_than_it_may(
            steps in proptest::collection::vec((0.001..0.5, -0.7..0.7), 1..60), within_m in 0.001..0.2,
        ) {
            let mut points = vec![DVec2::ZERO];
            let mut heading = 0.0;
            for (length, turn) in steps {
                heading += turn;
                points.push(points[points.len() - 1] + length * DVec2::from_angle(heading));
            }
            let left = straightened(&chain(&points), within_m);
            for point in &points {
                let nearest = left.iter().map(|hint| distance_m(*point, hint.ends_m)).fold(f64::INFINITY, f64::min);
                prop_assert!(nearest <= within_m * (1.0 + 1e-9), "{} at {}", nearest, point);
            }
            let ends: Vec<DVec2> = left.iter().flat_map(|hint| hint.ends_m).collect();
            prop_assert!(ends.contains(&points[0]) && ends.contains(&points[points.len() - 1]));
        }
    }
}
