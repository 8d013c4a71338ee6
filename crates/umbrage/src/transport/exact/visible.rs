//! The form factor between two polygons past occluders, by adaptive integration over the receiver.
//!
//! At each point of the receiver the visible part of the source is exact, so only the integral over the receiver has an
//! error. The receiver is cut into cells; of those in clear sight of the source the factor is exact too
//! ([`super::clear`]), and the rest take two rules of different degree, whose difference bounds the error of the better one
//! for smooth functions. Again and again the cell with the greatest error is cut, along a kink of the visible factor
//! ([`super::kink`]) if one crosses it, and in halves if not, until the sum of all errors is within the tolerance.
//!
//! Two rules may agree by chance. So the first difference is not believed: a cell's error is at least half of what cutting
//! its parent changed, and all of its integral where it has no parent.
//!
//! Points may miss a narrow shadow. So the penumbra of each occluder is known ([`super::penumbra`]), and where a cell has no
//! point in its part of one, one more point is taken there, and what it differs by from its neighbour counts as error.
//!
//! Holds after: the error bound is the sum over the cells, and is honest where the tolerance was not reached. It cannot
//! know of a sliver of light between occluders that no point met: so every cell that is not in clear sight is cut some
//! times whatever its error.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};

use super::cell::{Cell, Hints};
use super::clear;
use super::edge_pair::Part;
use super::kink::kinks;
use super::penumbra::{contains, penumbrae};
use super::quadrature::TriangleRule;
use super::{Exchange, polygon_to_polygon};
use crate::geometry::{PlaneFrame, clip, polygon};
use crate::transport::form_factor::factor_of_seen;
use crate::visibility::{FlatSource, ReceiverPoint, SourcePolygon, Visibility};

/// How long to go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// The error bound to reach.
    pub tolerance: f64,
    /// Points of the receiver at which the visible part is taken, at most about.
    pub max_points: usize,
}

impl Default for Effort {
    fn default() -> Self {
        Self { tolerance: 1e-5, max_points: 2_000_000 }
    }
}

/// Points each way in a triangle of the rule that bounds the error, and of the one that is taken.
const POINTS: [usize; 2] = [3, 4];
/// Cells that are not in clear sight are cut at least so often.
const LEAST_CUTS: u32 = 3;
/// What is lit or dark in a strip of 4e-9 of the source does not count: a factor is good to this share.
const STRIP_ROUNDING: f64 = 1e-8;

/// The form factor from `receiver` to what it sees of `source`, past the faces of the scene that `visibility` indexes.
pub fn visible_polygon_to_polygon(
    visibility: &Visibility,
    receiver: &SourcePolygon,
    source: &SourcePolygon,
    effort: &Effort,
) -> Exchange {
    let area_m2 = polygon::area_m2(&receiver.corners_m);
    if receiver.plane == source.plane || area_m2 <= 0.0 {
        return Exchange::default();
    }
    let before = |of: &SourcePolygon, plane| SourcePolygon {
        corners_m: clip::in_front_of(&of.corners_m, plane, 0.0),
        ..of.clone()
    };
    let front = before(receiver, &source.oriented_plane);
    let source = before(source, &receiver.oriented_plane);
    if front.corners_m.is_empty() || source.corners_m.is_empty() {
        return Exchange::default();
    }
    if !visibility.may_be_blocked(&front, &source) {
        return polygon_to_polygon(&receiver.corners_m, &source.corners_m);
    }
    let frame = PlaneFrame::new(front.oriented_plane, front.corners_m[0]);
    let hints = Hints {
        frame,
        kinks: kinks(visibility, &front, &source, &frame),
        penumbrae: penumbrae(visibility, &front, &source, &frame),
    };
    let mut integration = Integration {
        visibility,
        receiver: &front,
        source: &source,
        flat_source: FlatSource::new(&source, PlaneFrame::new(source.oriented_plane, source.corners_m[0])),
        rules: POINTS.map(TriangleRule::new),
        hints: &hints,
        open: BinaryHeap::new(),
        closed: Part::default(),
        points: 0,
    };
    integration.run(effort, area_m2);
    let sum = integration.sum();
    let factor = (sum.value / area_m2).max(0.0);
    Exchange { factor, error_bound: sum.error / area_m2 + STRIP_ROUNDING * factor }
}

/// A cell with its integral.
#[derive(Debug)]
struct Measured {
    cell: Cell,
    part: Part,
    /// Orders cells of the same error, so that the order of cuts is one.
    number: usize,
}

impl PartialEq for Measured {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Measured {}

impl PartialOrd for Measured {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Measured {
    fn cmp(&self, other: &Self) -> Ordering {
        self.part.error.total_cmp(&other.part.error).then(other.number.cmp(&self.number))
    }
}

struct Integration<'a> {
    visibility: &'a Visibility,
    receiver: &'a SourcePolygon,
    source: &'a SourcePolygon,
    flat_source: FlatSource,
    rules: [TriangleRule; 2],
    hints: &'a Hints,
    /// Cells that may be cut further.
    open: BinaryHeap<Measured>,
    /// Sum over the cells in clear sight.
    closed: Part,
    points: usize,
}

impl Integration<'_> {
    fn run(&mut self, effort: &Effort, area_m2: f64) {
        self.begin(Cell::whole(self.receiver.corners_m.clone(), self.hints));
        let mut error = self.sum().error;
        let mut number = self.open.len();
        while error > effort.tolerance * area_m2 && self.points < effort.max_points {
            let Some(worst) = self.open.pop() else { break };
            let before = self.closed;
            error -= worst.part.error;
            let parts: Vec<Measured> = worst
                .cell
                .cut(self.hints)
                .into_iter()
                .filter_map(|cell| {
                    number += 1;
                    self.measure(cell, number)
                })
                .collect();
            let closed = self.closed.value - before.value;
            let change =
                (parts.iter().map(|measured| measured.part.value).sum::<f64>() + closed - worst.part.value).abs();
            error += self.closed.error - before.error;
            for mut measured in parts {
                measured.part.error = measured.part.error.max(0.5 * change);
                error += measured.part.error;
                self.open.push(measured);
            }
        }
    }

    /// Cuts a cell until its parts are in clear sight or have been cut often enough.
    fn begin(&mut self, cell: Cell) {
        if cell.cuts < LEAST_CUTS && self.visibility.may_be_blocked(&self.polygon(&cell), self.source) {
            for part in cell.cut(self.hints) {
                self.begin(part);
            }
        } else if let Some(mut measured) = self.measure(cell, self.open.len()) {
            measured.part.error = measured.part.error.max(measured.part.value);
            self.open.push(measured);
        }
    }

    fn polygon(&self, cell: &Cell) -> SourcePolygon {
        SourcePolygon { corners_m: cell.corners_m.clone(), ..self.receiver.clone() }
    }

    /// Integrates over a cell; one in clear sight is done with.
    fn measure(&mut self, cell: Cell, number: usize) -> Option<Measured> {
        let polygon = self.polygon(&cell);
        if !self.visibility.may_be_blocked(&polygon, self.source) {
            let part = clear::exchange_area_m2(&polygon.corners_m, &self.source.corners_m);
            self.closed.value += part.value;
            self.closed.error += part.error;
            return None;
        }
        let [coarse, fine] = [&self.rules[0], &self.rules[1]].map(|rule| {
            let points = rule.over(&cell.corners_m);
            points.into_iter().map(|(point, weight)| (point, weight, self.factor(point))).collect::<Vec<_>>()
        });
        self.points += coarse.len() + fine.len();
        let [rough, value] = [&coarse, &fine].map(|points| points.iter().map(|(_, weight, f)| weight * f).sum::<f64>());
        let missed = self.missed_m2(&cell, &fine);
        let part = Part { value, error: (value - rough).abs() + missed };
        Some(Measured { cell, part, number })
    }

    /// The visible factor at a point of the receiver.
    fn factor(&self, near_m: DVec3) -> f64 {
        let plane = &self.receiver.oriented_plane;
        let position_m = plane.project(near_m);
        let point = ReceiverPoint::on_plane(position_m, plane.normal, self.receiver.plane);
        factor_of_seen(self.visibility, &point, &self.flat_source, None)
    }

    /// What the points of a rule may have missed in penumbrae that none of them lies in: area times factor.
    fn missed_m2(&mut self, cell: &Cell, points: &[(DVec3, f64, f64)]) -> f64 {
        let flat: Vec<_> = points.iter().map(|(point, ..)| self.hints.frame.to_2d(*point)).collect();
        let mut missed = 0.0;
        for part in cell.in_penumbrae(self.hints) {
            if flat.iter().any(|&point| contains(&part, point)) {
                continue;
            }
            let middle = part.iter().sum::<DVec2>() / part.len() as f64;
            let nearest = flat
                .iter()
                .zip(points)
                .min_by(|(p, _), (q, _)| p.distance_squared(middle).total_cmp(&q.distance_squared(middle)));
            if let Some((_, (.., factor))) = nearest {
                self.points += 1;
                let here = self.factor(self.hints.frame.to_3d(middle));
                missed += polygon::signed_area_2d_m2(&part) * (here - factor).abs();
            }
        }
        missed
    }

    /// The sum over all cells, in the order in which they were made.
    fn sum(&self) -> Part {
        let mut cells: Vec<&Measured> = self.open.iter().collect();
        cells.sort_by_key(|measured| measured.number);
        cells.iter().fold(self.closed, |sum, measured| Part {
            value: sum.value + measured.part.value,
            error: sum.error + measured.part.error,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::FaceId;
    use crate::visibility::fixture;

    /// The factor between unit squares at distance 1, with a polygon between.
    fn past(blocker: Vec<DVec3>, effort: &Effort) -> Exchange {
        let floor = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0)).to_vec();
        let ceiling = floor.iter().rev().map(|p| *p + DVec3::Z).collect();
        let prepared = fixture::prepared(&[floor, blocker, ceiling]);
        let [receiver, source] = [0, 2].map(|face| SourcePolygon::of_face(&prepared, FaceId::from(face)));
        visible_polygon_to_polygon(&Visibility::new(&prepared), &receiver, &source, effort)
    }

    fn level(x: [f64; 2], y: [f64; 2], z: f64) -> Vec<DVec3> {
        [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])].map(|(x, y)| DVec3::new(x, y, z)).to_vec()
    }

    #[test]
    fn shapiros_blocker_and_three_blockers_half_way() {
        let effort = Effort { tolerance: 2e-7, ..Effort::default() };
        for (blocker, truth) in [
            (level([0.25, 0.75], [0.25, 0.75], 0.75), 0.1156206021),
            (level([0.25, 0.75], [0.25, 0.75], 0.25), 0.1156206021),
            (level([0.25, 0.75], [0.25, 0.75], 0.5), 0.0995062946),
            (level([0.0, 0.5], [0.0, 0.5], 0.5), 0.1498686718),
            (level([0.0, 0.5], [0.0, 1.0], 0.5), 0.0999124478),
        ] {
            let exchange = past(blocker, &effort);
            assert!((exchange.factor - truth).abs() <= 1e-6, "{exchange:?} is not {truth}");
            assert!((exchange.factor - truth).abs() <= exchange.error_bound, "{exchange:?} bounds no {truth}");
            assert!(exchange.error_bound <= 2.1e-7, "{exchange:?}");
        }
    }

    #[test]
    fn a_blocker_that_is_turned_in_all_axes_is_the_same_from_both_sides() {
        let corner = |s: f64, t: f64| {
            let (u, v) = (DVec3::new(0.8, 0.3, 0.25), DVec3::new(-0.25, 0.7, 0.15));
            fixture::f32_point(DVec3::new(0.45, 0.5, 0.5) + 0.3 * (s * u + t * v))
        };
        let blocker = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let effort = Effort { tolerance: 1e-6, ..Effort::default() };
        let there = past(blocker.clone(), &effort);
        // The same seen from the ceiling: the scene mirrored at half its height.
        let mirrored = blocker.iter().rev().map(|p| DVec3::new(p.x, p.y, 1.0 - p.z)).collect();
        let back = past(mirrored, &effort);
        assert!((there.factor - back.factor).abs() < there.error_bound + back.error_bound, "{there:?} {back:?}");
        assert!(there.error_bound < 1.1e-6 && there.factor < 0.16, "{there:?}");
    }

    #[test]
    fn what_is_wholly_hidden_exchanges_exactly_nothing_and_few_points_are_told() {
        assert_eq!(past(level([-3.0, 4.0], [-3.0, 4.0], 0.5), &Effort::default()).factor, 0.0);
        let hasty = past(level([0.25, 0.75], [0.3, 0.7], 0.6), &Effort { tolerance: 1e-9, max_points: 3000 });
        let patient = past(level([0.25, 0.75], [0.3, 0.7], 0.6), &Effort { tolerance: 1e-7, ..Effort::default() });
        assert!(hasty.error_bound > 1e-9, "{hasty:?}");
        assert!(
            (hasty.factor - patient.factor).abs() < hasty.error_bound + patient.error_bound,
            "{hasty:?} {patient:?}"
        );
    }
}
