//! Needles at two vertices of one straight line that lie very near to each other: one of the two goes.
//!
//! Where a thing of facets ends a hair beyond a surface, its outline there has a vertex at each edge between facets and, next to it, one
//! at the diagonal of each facet. Both lie on one line, and need a triangle each from wherever the next corner is: a needle of two metres
//! and a third of a millimetre, whose light a renderer with coarse numbers extrapolates to black.
//!
//! ```text
//!     a --------------- v w ----------- b        a ----------------- w ----------- b
//!        `-..       . / |                 ->        `-..           / |
//!              `-.. x                                    `-.. x
//! ```
//!
//! A vertex `v` goes to `w` where an edge much shorter than what can be seen joins them, a needle stands on that edge, and what is covered
//! stays covered: of all triangles around `v` in one plane, the areas are the same as before, and none is turned over. So `v` was inside a plane,
//! or on a straight line in each.
//!
//! Holds after: edges are shared as they were; no outline moved by more than the weld distance.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::flat::LitTriangle;
use crate::id::{FaceId, VertexId};

/// Edges shorter than so many weld distances join vertices that are one to the eye: half a millimetre in a hall of ten metres.
const SHORT_OF_WELD: f64 = 16.0;
/// A triangle of more than this length over its height is a needle.
const NEEDLE: f64 = 1_000.0;
/// Rounds after which needles stay: neighbours of one that went wait for the next.
const MOST_ROUNDS: usize = 8;
/// What is covered may change by so many times the weld distance times the length of the edge: by some roundings of `f32` along edges of
/// a few centimetres.
const ROUNDED: f64 = 4.0;

/// Joins what is described above, where `side` tells the planes of faces apart, and their sides; returns how many triangles that took out.
pub(super) fn join<S: PartialEq>(
    triangles: &mut Vec<LitTriangle>,
    at_m: impl Fn(VertexId) -> DVec3,
    side: impl Fn(FaceId) -> S,
    weld_m: f64,
) -> usize {
    (0..MOST_ROUNDS).map(|_| join_once(triangles, &at_m, &side, weld_m)).take_while(|&count| count > 0).sum()
}

/// The same, each time with nothing else around it having changed.
fn join_once<S: PartialEq>(
    triangles: &mut Vec<LitTriangle>,
    at_m: &impl Fn(VertexId) -> DVec3,
    side: &impl Fn(FaceId) -> S,
    weld_m: f64,
) -> usize {
    let before = triangles.len();
    let mut ends = BTreeSet::new();
    let short: BTreeSet<[VertexId; 2]> =
        triangles.iter().filter_map(|triangle| base_of_needle(triangle, at_m, weld_m)).collect();
    ends.extend(short.iter().flatten().copied());
    let mut around: BTreeMap<VertexId, Vec<usize>> = BTreeMap::new();
    for (number, triangle) in triangles.iter().enumerate() {
        triangle.vertices.iter().filter(|v| ends.contains(v)).for_each(|&v| around.entry(v).or_default().push(number));
    }
    let mut done: BTreeSet<VertexId> = BTreeSet::new();
    for [earlier, later] in short {
        let ways = [[later, earlier], [earlier, later]];
        let free = [earlier, later].iter().all(|end| !done.contains(end));
        let way = ways.into_iter().find(|way| free && may_go(triangles, &around[&way[0]], *way, (at_m, side), weld_m));
        let Some([goes, stays]) = way else { continue };
        // What is around them is not what it was: another round would have to look again.
        done.extend(around[&goes].iter().chain(&around[&stays]).flat_map(|&number| triangles[number].vertices));
        let of_side = |triangle: &LitTriangle| Some((triangle.value_at(goes)?, triangle.value_at(stays)?));
        let values: BTreeMap<usize, usize> = around[&goes].iter().filter_map(|&n| of_side(&triangles[n])).collect();
        for &number in &around[&goes] {
            let triangle = &mut triangles[number];
            for (vertex, value) in triangle.vertices.iter_mut().zip(&mut triangle.values) {
                if *vertex == goes {
                    (*vertex, *value) = (stays, values.get(value).copied().unwrap_or(*value));
                }
            }
        }
    }
    triangles.retain(|t| (0..3).all(|i| t.vertices[i] != t.vertices[(i + 1) % 3]));
    before - triangles.len()
}

/// The short side of a triangle that is a needle.
fn base_of_needle(triangle: &LitTriangle, at_m: &impl Fn(VertexId) -> DVec3, weld_m: f64) -> Option<[VertexId; 2]> {
    let [a, b, c] = triangle.vertices.map(at_m);
    let lengths_m = [a.distance(b), b.distance(c), c.distance(a)];
    let (shortest, &short_m) = lengths_m.iter().enumerate().min_by(|p, q| p.1.total_cmp(q.1))?;
    let longest_m = lengths_m.iter().copied().fold(0.0, f64::max);
    let height_m = (b - a).cross(c - a).length() / longest_m;
    (short_m < SHORT_OF_WELD * weld_m && longest_m > NEEDLE * height_m).then(|| triangle.side(shortest))
}

/// Whether a vertex may go to another: in no plane what is covered changes, and no triangle is turned over.
fn may_go<S: PartialEq>(
    triangles: &[LitTriangle],
    around: &[usize],
    [goes, stays]: [VertexId; 2],
    (at_m, side): (&impl Fn(VertexId) -> DVec3, &impl Fn(FaceId) -> S),
    weld_m: f64,
) -> bool {
    let doubled_m2 = |corners: [DVec3; 3]| (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    // By how much the doubled area in each plane grows.
    let mut planes: Vec<(S, DVec3)> = Vec::new();
    for &number in around {
        let vertices = triangles[number].vertices;
        let old_m = vertices.map(at_m);
        let new_m = vertices.map(|v| at_m(if v == goes { stays } else { v }));
        let (old, new) = (doubled_m2(old_m), doubled_m2(new_m));
        let vanishes = vertices.contains(&stays);
        if !vanishes && new.dot(old) <= 0.0 {
            return false;
        }
        let side = side(triangles[number].face);
        match planes.iter_mut().find(|(other, _)| *other == side) {
            Some((_, grown)) => *grown += new - old,
            None => planes.push((side, new - old)),
        }
    }
    let most_m2 = ROUNDED * weld_m * weld_m.max(at_m(goes).distance(at_m(stays)));
    planes.iter().all(|(_, grown)| grown.length() < most_m2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::FaceId;

    const WELD_M: f64 = 1e-4;

    fn triangles(of: &[[usize; 3]]) -> Vec<LitTriangle> {
        let triangle = |&values: &[usize; 3]| LitTriangle {
            // The floor, and the wall.
            face: FaceId::from(usize::from(!values.contains(&4))),
            vertices: values.map(VertexId::from),
            values,
        };
        of.iter().map(triangle).collect()
    }

    /// A floor that ends at the line 0, 1, 2, 3 before a wall of the facets 4 and 5; 1 and 2 are very near.
    fn joined(bend_m: f64) -> (usize, Vec<LitTriangle>, Vec<DVec3>) {
        let at: Vec<DVec3> = [
            [-1.0, 0.0, 0.0],
            [0.0, 0.0, 0.0],
            [1e-3, bend_m, 0.0],
            [1.0, bend_m, 0.0],
            [0.0, -3.0, 0.0],
            [-1.0, 0.0, 1.0],
            [1.0, bend_m, 1.0],
        ]
        .map(DVec3::from)
        .to_vec();
        let mut all = triangles(&[[4, 1, 0], [4, 2, 1], [4, 3, 2], [0, 1, 5], [1, 6, 5], [1, 2, 6], [2, 3, 6]]);
        let count = join(&mut all, |v| at[v.index()], |face| face, WELD_M);
        (count, all, at)
    }

    #[test]
    fn a_needle_at_two_points_of_a_straight_line_goes() {
        let (count, left, at) = joined(0.0);
        assert_eq!(count, 2, "the needle, and what stands on its base behind it");
        let area_m2 = |t: &LitTriangle| {
            let [a, b, c] = t.vertices.map(|v| at[v.index()]);
            0.5 * (b - a).cross(c - a).length()
        };
        let [floor, wall]: [f64; 2] =
            [true, false].map(|floor| left.iter().filter(|t| t.values.contains(&4) == floor).map(area_m2).sum());
        assert!((floor - 3.0).abs() < 1e-9 && (wall - 2.0).abs() < 1e-9, "{floor} {wall}");
        // The light of the side is that of the point that stays.
        assert!(left.iter().all(|t| (0..3).all(|i| t.vertices[i].index() == t.values[i])));
    }

    #[test]
    fn where_the_line_bends_it_stays() {
        let (count, left, _) = joined(5e-3);
        assert_eq!((count, left.len()), (0, 7));
    }
}
