//! Form factors of all pairs of faces, and their sums over groups of faces.
//!
//! A pair that nothing can stand between is exact. Any other is integrated twice, once over each of its ends; the better
//! one counts for both directions (`A1 F12 = A2 F21`), and the difference of the two tells how good they are without
//! trusting either's bound.

use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::visible::{Effort, visible_polygon_to_polygon};
use crate::geometry::polygon;
use crate::id::{FaceId, Table};
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::visibility::{SourcePolygon, Visibility};

/// What two faces exchange.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacePair {
    /// The faces, the smaller id first.
    pub faces: [FaceId; 2],
    /// Form factor times area, the same both ways, in square metres.
    pub exchange_m2: f64,
    /// The bound of its error, in square metres.
    pub error_m2: f64,
    /// The same from the one face minus from the other, each integrated for itself, in square metres.
    pub residual_m2: f64,
}

/// The form factors of all pairs of faces that exchange anything.
#[derive(Clone, Debug, PartialEq)]
pub struct FactorTable {
    /// Area of each face, in square metres.
    pub areas_m2: Table<FaceId, f64>,
    /// The pairs, in the order of their faces.
    pub pairs: Vec<FacePair>,
}

/// The form factor from one group of faces to another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FactorTotals {
    /// Share of the light that leaves the receiver, uniformly, and arrives at the source.
    pub factor: f64,
    /// The bound of its error.
    pub error_bound: f64,
    /// How far both directions differ, as a share of what leaves the receiver.
    pub reciprocity_residual: f64,
}

impl FactorTable {
    /// All pairs between a face that `first` names and one that `second` names, in either role.
    ///
    /// # Errors
    /// [`Cancelled`] where the progress callback asks to stop.
    pub fn new(
        prepared: &Prepared,
        visibility: &Visibility,
        first: impl Fn(FaceId) -> bool,
        second: impl Fn(FaceId) -> bool,
        effort: &Effort,
        progress: Progress<'_>,
    ) -> Result<Self, Cancelled> {
        let polygons: Table<FaceId, SourcePolygon> =
            prepared.faces.keys().map(|face| SourcePolygon::of_face(prepared, face)).collect();
        let areas_m2 = polygons.iter().map(|polygon| polygon::area_m2(&polygon.corners_m)).collect();
        let asked = |p: FaceId, q: FaceId| (first(p) && second(q)) || (first(q) && second(p));
        let pairs: Vec<[FaceId; 2]> = prepared
            .faces
            .keys()
            .flat_map(|p| prepared.faces.keys().filter(move |&q| p < q).map(move |q| [p, q]))
            .filter(|&[p, q]| asked(p, q))
            .collect();
        let done = AtomicUsize::new(0);
        let exchange = |&[p, q]: &[FaceId; 2]| {
            progress.report(Stage::Transport, done.fetch_add(1, Ordering::Relaxed), pairs.len())?;
            Ok(exchange(visibility, &polygons, &areas_m2, [p, q], effort))
        };
        let found = pairs.par_iter().map(exchange).collect::<Result<Vec<_>, Cancelled>>()?;
        Ok(Self { pairs: found.into_iter().flatten().collect(), areas_m2 })
    }

    /// The factors from each group of faces to each, by `group_of`, which leaves out what it has no group for.
    pub fn totals(&self, groups: usize, group_of: impl Fn(FaceId) -> Option<usize>) -> Vec<Vec<FactorTotals>> {
        let mut area_m2 = vec![0.0; groups];
        for (face, area) in self.areas_m2.iter_enumerated() {
            if let Some(group) = group_of(face) {
                area_m2[group] += area;
            }
        }
        let mut totals = vec![vec![FactorTotals::default(); groups]; groups];
        for pair in &self.pairs {
            let [Some(p), Some(q)] = pair.faces.map(&group_of) else { continue };
            for (receiver, source, sign) in [(p, q, 1.0), (q, p, -1.0)] {
                let total = &mut totals[receiver][source];
                total.factor += pair.exchange_m2 / area_m2[receiver];
                total.error_bound += pair.error_m2 / area_m2[receiver];
                total.reciprocity_residual += sign * pair.residual_m2 / area_m2[receiver];
            }
        }
        totals
    }
}

/// What a pair exchanges; `None` where it is nothing.
fn exchange(
    visibility: &Visibility,
    polygons: &Table<FaceId, SourcePolygon>,
    areas_m2: &Table<FaceId, f64>,
    faces: [FaceId; 2],
    effort: &Effort,
) -> Option<FacePair> {
    let [first, second] = faces.map(|face| &polygons[face]);
    // A tolerance of the factor of either end is met where it is met for the smaller one.
    let ways = [(first, second, faces[0], faces[1]), (second, first, faces[1], faces[0])].map(
        |(receiver, source, receiver_face, source_face)| {
            let smaller = (areas_m2[source_face] / areas_m2[receiver_face]).min(1.0);
            let effort = Effort { tolerance: effort.tolerance * smaller, ..*effort };
            let exchange = visible_polygon_to_polygon(visibility, receiver, source, &effort);
            (areas_m2[receiver_face] * exchange.factor, areas_m2[receiver_face] * exchange.error_bound)
        },
    );
    let [there, back] = ways;
    let (exchange_m2, error_m2) = if there.1 <= back.1 { there } else { back };
    let pair = FacePair { faces, exchange_m2, error_m2, residual_m2: there.0 - back.0 };
    (pair.exchange_m2 > 0.0 || pair.error_m2 > 0.0).then_some(pair)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::fixture;
    use glam::DVec3;

    fn table(polygons: &[Vec<DVec3>], effort: &Effort) -> FactorTable {
        let prepared = fixture::prepared(polygons);
        let visibility = Visibility::new(&prepared);
        FactorTable::new(&prepared, &visibility, |_| true, |_| true, effort, Progress::silent()).unwrap()
    }

    #[test]
    fn the_rows_of_a_cube_sum_to_one() {
        let table = table(&fixture::inward_box(DVec3::ZERO, DVec3::new(1.0, 2.0, 0.5)), &Effort::default());
        for row in table.totals(6, |face| Some(face.index())) {
            let sum: f64 = row.iter().map(|total| total.factor).sum();
            assert!((sum - 1.0).abs() < 1e-11, "{row:?}");
            assert!(row.iter().all(|total| total.reciprocity_residual.abs() < 1e-11), "{row:?}");
        }
    }

    #[test]
    fn groups_sum_their_faces_and_what_is_not_asked_for_is_left_out() {
        let prepared = fixture::prepared(&fixture::inward_box(DVec3::ZERO, DVec3::ONE));
        let visibility = Visibility::new(&prepared);
        let of = |first: fn(FaceId) -> bool, second: fn(FaceId) -> bool| {
            FactorTable::new(&prepared, &visibility, first, second, &Effort::default(), Progress::silent()).unwrap()
        };
        let all = of(|_| true, |_| true);
        let walls = |face: FaceId| Some(usize::from(face.index() >= 2));
        let totals = all.totals(2, walls);
        let opposed = 0.1998248957;
        assert!((totals[0][0].factor - opposed).abs() < 1e-10, "{totals:?}");
        assert!((totals[0][1].factor - (1.0 - opposed)).abs() < 1e-10, "{totals:?}");
        let one = of(|face| face.index() == 0, |face| face.index() == 1);
        assert_eq!(one.pairs, all.pairs[..1]);
    }
}
