//! Partition of a plane's cells into convex, well-shaped pieces (Hertel and Mehlhorn, 1983).
//!
//! A constrained Delaunay triangulation fills the cells; then diagonals are taken away as long as what they separated
//! is convex together. Hertel and Mehlhorn take any order and have at most four times the fewest pieces; here two
//! orders are tried, by how much better shaped (`4 pi A / P^2`) a union is than its parts and by length, and each cell
//! keeps the one with the fewest pieces, then with the best shaped worst piece. Needed edges are never taken away. Both
//! facings of a cell share its pieces, so that diagonals never cross.
//!
//! Holds after: pieces are convex but for vertices that lie straight within the tolerance; they cover the cells.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::arrangement::Label;
use super::merge::{Order, Pieces};
use super::sides;
use super::triangulation::{Cells, Triangulation};
use crate::geometry::{PlaneFrame, Tolerance};

/// A convex piece of a cell.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Numbers of all its boundary vertices, counter-clockwise in the frame.
    pub(super) boundary: Vec<u32>,
    /// Which of these are corners, ascending; the others lie straight between them.
    pub(super) corners: Vec<usize>,
    /// What its cell shows.
    pub(super) label: Label,
}

/// A partition is better shaped only by more than this: less is rounding.
const LEAST_GAIN: f64 = 1e-6;
/// All orders that are tried; of equal results the first counts.
const ORDERS: [Order; 2] = [Order::MostGain, Order::Longest];

/// The convex pieces of all cells that show something. `beside` says what each edge has to its left and its right.
pub(super) fn pieces(
    frame: &PlaneFrame,
    points: &[DVec3],
    triangulation: &Triangulation,
    beside: &[[Label; 2]],
    tolerance: &Tolerance,
) -> Vec<Piece> {
    let flat: Vec<DVec2> = points.iter().map(|&p| frame.to_2d(p)).collect();
    let cells = triangulation.cells();
    let labels = labels(triangulation, &cells, beside);
    let mut best: Vec<Option<Partition>> = vec![None; cells.count];
    let merged = |&order: &Order| {
        // A triangle that cuts have bent out of the plane stays one: it is plane by itself.
        let is_in_plane = |&v: &u32| frame.plane.signed_distance_m(points[v as usize]).abs() <= tolerance.weld_m();
        let may_merge = |t: usize| {
            labels[cells.cell_of[t] as usize] != [None; 2] && triangulation.triangles[t].corners.iter().all(is_in_plane)
        };
        let mut pieces = Pieces::new(&flat, points, triangulation, sides::straight_m(tolerance), may_merge);
        pieces.merge(order);
        by_cell(&mut pieces, &cells, &labels)
    };
    let all: Vec<Vec<Partition>> = ORDERS.par_iter().map(merged).collect();
    for (cell, found) in all.into_iter().flat_map(|partitions| partitions.into_iter().enumerate()) {
        if best[cell].as_ref().is_none_or(|known| found.is_better_than(known)) {
            best[cell] = Some(found);
        }
    }
    best.into_iter().flatten().flat_map(|partition| partition.pieces).collect()
}

/// The pieces of one cell.
#[derive(Clone, Debug, Default)]
struct Partition {
    pieces: Vec<Piece>,
    /// Compactness of the worst shaped piece.
    worst: f64,
}

impl Partition {
    fn is_better_than(&self, other: &Self) -> bool {
        let (n, m) = (self.pieces.len(), other.pieces.len());
        n < m || (n == m && self.worst > other.worst + LEAST_GAIN)
    }
}

/// What each cell shows: what some edge of it has on that side.
fn labels(triangulation: &Triangulation, cells: &Cells, beside: &[[Label; 2]]) -> Vec<Label> {
    let mut label_of: Vec<Option<Label>> = vec![None; cells.count];
    for (t, triangle) in triangulation.triangles.iter().enumerate() {
        for i in 0..3 {
            if let Some(edge) = triangle.edges[i] {
                let [from, to] = triangle.side(i);
                label_of[cells.cell_of[t] as usize].get_or_insert(beside[edge as usize][usize::from(from > to)]);
            }
        }
    }
    label_of.into_iter().map(Option::unwrap_or_default).collect()
}

/// The merged pieces of each cell that shows something.
fn by_cell(pieces: &mut Pieces<'_>, cells: &Cells, labels: &[Label]) -> Vec<Partition> {
    let mut partitions: Vec<Partition> = vec![Partition { pieces: Vec::new(), worst: 1.0 }; cells.count];
    let mut done = vec![false; pieces.start.len()];
    for half in 0..pieces.start.len() {
        let cell = cells.cell_of[half / 3] as usize;
        if done[half] || pieces.gone[half] || labels[cell] == [None; 2] {
            continue;
        }
        let round = pieces.round(half);
        round.iter().for_each(|&h| done[h] = true);
        let boundary: Vec<u32> = round.iter().map(|&h| pieces.start[h]).collect();
        let corners = pieces.corners(&boundary).unwrap_or_else(|| (0..boundary.len()).collect());
        let piece = pieces.piece_of(half);
        partitions[cell].worst = partitions[cell].worst.min(pieces.compactness(piece));
        partitions[cell].pieces.push(Piece { boundary, corners, label: labels[cell] });
    }
    partitions
}

#[cfg(test)]
mod tests {
    use super::super::arrangement::Shown;
    use super::super::testing::TOLERANCE;
    use super::*;
    use crate::geometry::{Plane, polygon};
    use crate::id::SurfaceId;

    /// Pieces of a polygon with holes, each a loop; the first runs counter-clockwise, the holes clockwise.
    fn pieces_of(loops: &[&[[f64; 2]]]) -> Vec<f64> {
        let flat: Vec<DVec2> = loops.iter().copied().flatten().map(|&p| DVec2::from(p)).collect();
        let (mut edges, mut beside, mut first) = (Vec::new(), Vec::new(), 0);
        let white: Label = [Some(Shown { surface: SurfaceId::from(0), skin: None }), None];
        for corners in loops {
            let n = corners.len() as u32;
            for i in 0..n {
                let (a, b) = (first + i, first + (i + 1) % n);
                edges.push([a, b]);
                beside.push(if a < b { [white, [None; 2]] } else { [[None; 2], white] });
            }
            first += n;
        }
        let plane = Plane { normal: DVec3::Z, offset_m: 0.0 };
        let frame = PlaneFrame { plane, origin: DVec3::ZERO, u: DVec3::X, v: DVec3::Y };
        let points: Vec<DVec3> = flat.iter().map(|p| p.extend(0.0)).collect();
        let triangulation = Triangulation::new(&flat, &edges);
        let pieces = pieces(&frame, &points, &triangulation, &beside, &TOLERANCE);
        for piece in &pieces {
            let corners: Vec<DVec2> = piece.boundary.iter().map(|&i| flat[i as usize]).collect();
            assert!(sides::is_convex(&corners, &piece.corners) && piece.corners.len() <= 16);
        }
        let polygon = |piece: &Piece| piece.boundary.iter().map(|&i| flat[i as usize]).collect::<Vec<_>>();
        pieces.iter().map(|piece| polygon::signed_area_2d_m2(&polygon(piece))).collect()
    }

    #[test]
    fn a_convex_polygon_is_one_piece() {
        let octagon: Vec<[f64; 2]> =
            (0..8).map(|i| DVec2::from_angle(f64::from(i) * std::f64::consts::FRAC_PI_4).to_array()).collect();
        assert_eq!(pieces_of(&[&octagon]).len(), 1);
    }

    /// A circle of a thousand corners, a star with as many, and an ellipse whose corners lie at random.
    fn of_many_corners() -> [Vec<[f64; 2]>; 3] {
        let at = |turn: f64| DVec2::from_angle(std::f64::consts::TAU * turn);
        let circle = (0..1000).map(|i| at(f64::from(i) / 1000.0));
        let star = (0..1000).map(|i| (0.7 + 0.3 * f64::from(i % 2)) * at(f64::from(i) / 1000.0));
        // Steps that never repeat, of one to three hundredths of a degree or so.
        let mut turns: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.618_033_988_749_895).fract()).collect();
        turns.sort_by(f64::total_cmp);
        let ellipse = turns.into_iter().map(|turn| at(turn + 1e-4 * (7e3 * turn).sin()) * DVec2::new(1.0, 0.6));
        [circle.collect::<Vec<_>>(), star.collect(), ellipse.collect()]
            .map(|corners| corners.iter().map(DVec2::to_array).collect())
    }

    #[test]
    fn polygons_of_many_corners_fall_into_few_pieces_that_are_well_shaped_but_for_a_thin_rim() {
        for corners in of_many_corners() {
            let whole = polygon::signed_area_2d_m2(&corners.iter().copied().map(DVec2::from).collect::<Vec<_>>());
            let mut areas = pieces_of(&[&corners]);
            areas.sort_by(|p, q| q.total_cmp(p));
            assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-9 * whole);
            assert!(areas.len() <= corners.len() / 2 + 150, "{} pieces", areas.len());
            let large: f64 = areas.iter().take(100).sum();
            assert!(large > 0.5 * whole, "the largest hundred of {} hold {}", areas.len(), large / whole);
        }
    }

    #[test]
    fn vertices_on_a_side_make_no_pieces() {
        let square = [[0.0, 0.0], [1.0, 1e-8], [2.0, -1e-8], [4.0, 0.0], [4.0, 4.0], [3.0, 4.0 - 1e-8], [0.0, 4.0]];
        assert_eq!(pieces_of(&[&square]).len(), 1);
    }

    #[test]
    fn a_square_with_a_square_hole_is_four_pieces() {
        let outer = [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]];
        let hole = [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]];
        let areas = pieces_of(&[&outer, &hole]);
        assert_eq!(areas.len(), 4);
        assert!((areas.iter().sum::<f64>() - 8.0).abs() < 1e-12);
    }

    #[test]
    fn a_comb_has_one_piece_for_each_tooth_and_its_back() {
        let mut comb = vec![[9.0, 0.0], [9.0, 1.0]];
        for i in (0..4).rev() {
            let x = 2.0 * f64::from(i) + 1.0;
            comb.extend([[x + 1.0, 1.0], [x + 1.0, 3.0], [x, 3.0], [x, 1.0]]);
        }
        comb.extend([[0.0, 1.0], [0.0, 0.0]]);
        let areas = pieces_of(&[&comb]);
        assert_eq!(areas.len(), 5);
        assert!((areas.iter().sum::<f64>() - 17.0).abs() < 1e-12);
    }
}
