//! Where polygons of different planes meet: the segments along which both are cut.
//!
//! Polygons are taken as convex pieces, and pairs of pieces whose boxes touch are tried. A corner within the coplanar
//! tolerance of the other's plane lies in it (sign 0), the others are in front or behind (+, -). A side with both ends
//! in the other's plane meets it along that side, as a box does that stands on a floor. Where there is no such side,
//! two pieces that both pass through the other's plane cross, and meet along the common part of the line of the two
//! planes.
//!
//! Holds after: a segment's ends are points that lie in both planes within the weld distance. Segments are not yet cut
//! where they meet vertices or each other; `node` does so.

use glam::{DVec2, DVec3};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree, RTreeObject};

use super::PrepareError;
use super::coplanar::Planes;
use super::entangled::Meetings;
use super::soup::Polygon;
use super::triangulation;
use super::weld::Points;
use crate::geometry::{PlaneFrame, Tolerance};
use crate::id::{PlaneId, VertexId};
use crate::progress::Cancelled;

/// Convex polygons with more corners than this are cut into triangles too, so that a pair of pieces costs a constant.
const MOST_CORNERS: usize = 8;
/// Pairs between two chances to cancel.
const PAIRS_PER_PULSE: usize = 1 << 14;

/// A segment along which two planes' polygons meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Contact {
    /// Its ends.
    pub(super) ends: [VertexId; 2],
    /// The planes whose polygons it cuts.
    pub(super) planes: [PlaneId; 2],
}

/// A convex part of a polygon, counter-clockwise in its plane's frame.
struct Piece {
    plane: PlaneId,
    corners: Vec<VertexId>,
}

/// All contacts of all pairs of polygons; `dropped` counts those that rounding left no place for.
pub(super) fn contacts(
    soup: &[Polygon],
    planes: &Planes,
    points: &mut Points,
    tolerance: &Tolerance,
    dropped: &mut usize,
    meetings: &Meetings,
    mut pulse: impl FnMut() -> Result<(), Cancelled>,
) -> Result<Vec<Contact>, PrepareError> {
    let pieces = pieces(soup, planes, points, tolerance);
    let slack = DVec3::splat(tolerance.weld_m());
    let boxes = pieces.iter().enumerate().map(|(i, piece)| {
        let (low, high) = bounds(piece.corners.iter().map(|&v| points[v]));
        GeomWithData::new(Rectangle::from_corners((low - slack).to_array(), (high + slack).to_array()), i)
    });
    let boxes: Vec<GeomWithData<Rectangle<[f64; 3]>, usize>> = boxes.collect();
    let tree = RTree::bulk_load(boxes.clone());
    let mut contacts = Vec::new();
    let mut tried = 0;
    let mut others: Vec<usize> = Vec::new();
    for (i, bounding_box) in boxes.iter().enumerate() {
        let range: AABB<[f64; 3]> = bounding_box.envelope();
        let before = contacts.len();
        others.clear();
        others.extend(tree.locate_in_envelope_intersecting(range).map(|o| o.data).filter(|&j| j > i));
        others.sort_unstable();
        for &j in &others {
            if pieces[i].plane != pieces[j].plane {
                meet(&pieces[i], &pieces[j], planes, points, tolerance, dropped, &mut contacts);
            }
        }
        meetings.add(contacts.len() - before);
        meetings.check()?;
        if (tried + others.len()) / PAIRS_PER_PULSE > tried / PAIRS_PER_PULSE {
            pulse()?;
        }
        tried += others.len();
    }
    contacts.sort_unstable_by_key(|c| (c.ends, c.planes));
    contacts.dedup();
    Ok(contacts)
}

fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    points.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)))
}

fn pieces(soup: &[Polygon], planes: &Planes, points: &Points, tolerance: &Tolerance) -> Vec<Piece> {
    let mut pieces = Vec::with_capacity(soup.len());
    for (polygon, &(plane, _)) in soup.iter().zip(&planes.of_polygon) {
        let frame = &planes.frames[plane];
        let flat: Vec<DVec2> = polygon.corners.iter().map(|&v| frame.to_2d(points[v])).collect();
        let turned = crate::geometry::polygon::signed_area_2d_m2(&flat) < 0.0;
        let n = flat.len();
        let is_convex = (0..n).all(|i| {
            let [a, b, c] = [flat[i], flat[(i + 1) % n], flat[(i + 2) % n]];
            let turn = (b - a).perp_dot(c - b) * if turned { -1.0 } else { 1.0 };
            turn >= -tolerance.coplanar_m() * a.distance(c) && (b - a).dot(c - b) > -(b - a).length() * (c - b).length()
        });
        if (is_convex && n <= MOST_CORNERS) || n == 3 {
            let mut corners = polygon.corners.clone();
            if turned {
                corners.reverse();
            }
            pieces.push(Piece { plane, corners });
        } else {
            let triangles = triangulation::fill(&polygon.corners, |v| frame.to_2d(points[v]));
            pieces.extend(triangles.into_iter().map(|t| Piece { plane, corners: t.to_vec() }));
        }
    }
    pieces
}

/// Heights of a piece's corners over a plane; those within the coplanar tolerance are 0.
fn heights_m(piece: &Piece, frame: &PlaneFrame, points: &Points, tolerance: &Tolerance) -> Vec<f64> {
    let snap = |h: f64| if h.abs() <= tolerance.coplanar_m() { 0.0 } else { h };
    piece.corners.iter().map(|&v| snap(frame.plane.signed_distance_m(points[v]))).collect()
}

fn meet(
    first: &Piece,
    second: &Piece,
    planes: &Planes,
    points: &mut Points,
    tolerance: &Tolerance,
    dropped: &mut usize,
    contacts: &mut Vec<Contact>,
) {
    let both = [first.plane, second.plane];
    let first_heights = heights_m(first, &planes.frames[second.plane], points, tolerance);
    if is_on_one_side(&first_heights) {
        return;
    }
    let second_heights = heights_m(second, &planes.frames[first.plane], points, tolerance);
    if is_on_one_side(&second_heights) {
        return;
    }
    let mut segments: Vec<[DVec3; 2]> = Vec::new();
    for (standing, heights, ground) in [(first, &first_heights, second), (second, &second_heights, first)] {
        let n = heights.len();
        for i in (0..n).filter(|&i| heights[i] == 0.0 && heights[(i + 1) % n] == 0.0) {
            let side = [standing.corners[i], standing.corners[(i + 1) % n]].map(|v| points[v]);
            segments.extend(inside(side, ground, &planes.frames[ground.plane], points, tolerance));
        }
    }
    if segments.is_empty() {
        segments.extend(crossing(first, &first_heights, second, &second_heights, planes, points));
    }
    for segment in segments {
        let lies_in_both = segment
            .iter()
            .all(|&p| both.iter().all(|&id| planes.frames[id].plane.signed_distance_m(p).abs() <= tolerance.weld_m()));
        if !lies_in_both {
            *dropped += 1;
            continue;
        }
        let mut ends = segment.map(|p| points.weld(p));
        ends.sort_unstable();
        if ends[0] != ends[1] {
            contacts.push(Contact { ends, planes: [both[0].min(both[1]), both[0].max(both[1])] });
        }
    }
}

fn is_on_one_side(heights: &[f64]) -> bool {
    heights.iter().all(|&h| h > 0.0) || heights.iter().all(|&h| h < 0.0)
}

/// The part of a side that lies on a piece in whose plane the side lies. An end within half the weld distance of a side
/// of the piece is taken to lie on it.
fn inside(
    side: [DVec3; 2],
    ground: &Piece,
    frame: &PlaneFrame,
    points: &Points,
    tolerance: &Tolerance,
) -> Option<[DVec3; 2]> {
    let [from, to] = side.map(|p| frame.to_2d(p));
    let (mut t_min, mut t_max) = (0.0_f64, 1.0_f64);
    let n = ground.corners.len();
    for i in 0..n {
        let [p, q] = [ground.corners[i], ground.corners[(i + 1) % n]].map(|v| frame.to_2d(points[v]));
        let inward = (q - p).perp().normalize_or_zero();
        let snap = |h: f64| if h.abs() <= 0.5 * tolerance.weld_m() { 0.0 } else { h };
        let (at_from, at_to) = (snap(inward.dot(from - p)), snap(inward.dot(to - p)));
        if at_from < 0.0 && at_to < 0.0 {
            return None;
        }
        if at_from < 0.0 {
            t_min = t_min.max(at_from / (at_from - at_to));
        } else if at_to < 0.0 {
            t_max = t_max.min(at_from / (at_from - at_to));
        }
    }
    (t_min < t_max).then(|| [side[0].lerp(side[1], t_min), side[0].lerp(side[1], t_max)])
}

/// The common segment of two pieces that pass through each other's plane.
fn crossing(
    first: &Piece,
    first_heights: &[f64],
    second: &Piece,
    second_heights: &[f64],
    planes: &Planes,
    points: &Points,
) -> Option<[DVec3; 2]> {
    let along = planes.frames[first.plane].plane.normal.cross(planes.frames[second.plane].plane.normal);
    let one = chord(first, first_heights, along, points)?;
    let other = chord(second, second_heights, along, points)?;
    let start = if one[0].0 >= other[0].0 { one[0] } else { other[0] };
    let end = if one[1].0 <= other[1].0 { one[1] } else { other[1] };
    (start.0 < end.0).then_some([start.1, end.1])
}

/// Where a piece passes through a plane: its two extreme points along a direction, with their places along it.
fn chord(piece: &Piece, heights: &[f64], along: DVec3, points: &Points) -> Option<[(f64, DVec3); 2]> {
    let n = heights.len();
    let mut ends: Option<[(f64, DVec3); 2]> = None;
    for i in 0..n {
        let j = (i + 1) % n;
        let (p, q, at_p, at_q) = (points[piece.corners[i]], points[piece.corners[j]], heights[i], heights[j]);
        let met = if at_p == 0.0 {
            p
        } else if (at_p < 0.0 && at_q > 0.0) || (at_p > 0.0 && at_q < 0.0) {
            // In an order of the ends that both neighbours of a side agree on.
            if piece.corners[i] < piece.corners[j] {
                p.lerp(q, at_p / (at_p - at_q))
            } else {
                q.lerp(p, at_q / (at_q - at_p))
            }
        } else {
            continue;
        };
        let found = (along.dot(met), met);
        let [low, high] = ends.unwrap_or([found; 2]);
        ends = Some([if found.0 < low.0 { found } else { low }, if found.0 > high.0 { found } else { high }]);
    }
    ends
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Small, TOLERANCE};
    use super::*;

    const FLOOR: &[[f64; 3]] = &[[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 4.0], [4.0, 0.0, 0.0]];

    /// Contacts of polygons, in micrometres.
    fn contacts_of(polygons: &[&[[f64; 3]]]) -> Vec<[[i64; 3]; 2]> {
        let mut small = Small::new(polygons);
        let mut dropped = 0;
        let found = contacts(
            &small.soup,
            &small.planes,
            &mut small.points,
            &TOLERANCE,
            &mut dropped,
            &Meetings::of(99),
            || Ok(()),
        );
        assert_eq!(dropped, 0);
        found.unwrap().iter().map(|c| small.micrometres(c.ends)).collect()
    }

    fn micro(ends: [[f64; 3]; 2]) -> Vec<[[i64; 3]; 2]> {
        vec![ends.map(|p| p.map(|x| (x * 1e6).round() as i64))]
    }

    #[test]
    fn a_wall_standing_on_a_floor() {
        let wall = &[[1.0, 0.0, 1.0], [3.0, 0.0, 1.0], [3.0, 2.0, 1.0], [1.0, 2.0, 1.0]];
        assert_eq!(contacts_of(&[FLOOR, wall]), micro([[1.0, 0.0, 1.0], [3.0, 0.0, 1.0]]));
    }

    #[test]
    fn a_wall_reaching_beyond_the_floor() {
        let wall = &[[-1.0, 0.0, 1.0], [3.0, 0.0, 1.0], [3.0, 2.0, 1.0], [-1.0, 2.0, 1.0]];
        assert_eq!(contacts_of(&[FLOOR, wall]), micro([[0.0, 0.0, 1.0], [3.0, 0.0, 1.0]]));
    }

    #[test]
    fn a_wall_through_a_floor() {
        let wall = &[[1.0, -1.0, 1.0], [5.0, -1.0, 1.0], [5.0, 2.0, 1.0], [1.0, 2.0, 1.0]];
        assert_eq!(contacts_of(&[FLOOR, wall]), micro([[1.0, 0.0, 1.0], [4.0, 0.0, 1.0]]));
    }

    #[test]
    fn a_wall_over_or_beside_a_floor_does_not_meet_it() {
        let over = &[[1.0, 0.1, 1.0], [3.0, 0.1, 1.0], [3.0, 2.0, 1.0], [1.0, 2.0, 1.0]];
        let beside = &[[5.0, 0.0, 1.0], [6.0, 0.0, 1.0], [6.0, 2.0, 1.0], [5.0, 2.0, 1.0]];
        let tip = &[[1.0, 0.0, 1.0], [3.0, 2.0, 1.0], [1.0, 2.0, 1.0]];
        assert!(contacts_of(&[FLOOR, over]).is_empty());
        assert!(contacts_of(&[FLOOR, beside]).is_empty());
        assert!(contacts_of(&[FLOOR, tip]).is_empty());
    }

    #[test]
    fn a_floor_with_a_notch_is_met_outside_the_notch_only() {
        let notched =
            &[[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [1.0, 0.0, 4.0], [1.0, 0.0, 1.0], [4.0, 0.0, 1.0], [4.0, 0.0, 0.0]];
        let wall = &[[0.5, 0.0, 2.0], [3.0, 0.0, 2.0], [3.0, 2.0, 2.0], [0.5, 2.0, 2.0]];
        let found = contacts_of(&[notched, wall]);
        let length = |[a, b]: &[[i64; 3]; 2]| b[0] - a[0];
        assert_eq!(found.iter().map(length).sum::<i64>(), 500_000);
    }
}
