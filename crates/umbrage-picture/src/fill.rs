//! Which samples a triangle covers.
//!
//! Idea: the sign of an edge function, in integers, tells the side of an edge; a sample exactly on an edge counts as if
//! it were moved by an infinitely small step in one fixed direction. Each row of samples then is one span, whose ends
//! follow by exact division.
//!
//! ```text
//!   E(p) = (b - a) x (p - a)      inside:  E > 0, or E = 0 and the step leads inside
//! ```
//!
//! Holds: samples inside a mesh whose triangles share their edges are covered exactly once, whatever the snapping
//! did: no crack, no sample twice.
//!
//! Source: J. Pineda, A Parallel Algorithm for Polygon Rasterization, SIGGRAPH 1988; simulation of simplicity for the
//! step.

use crate::project::{SNAP, ScreenTriangle};

/// A triangle that is ready to be filled.
#[derive(Clone, Debug)]
pub(crate) struct Fill {
    /// Edge functions, each opposite to a corner: value at sample (0, 0), change per sample right and down.
    edges: [[i64; 3]; 3],
    /// 0 where a sample on the edge counts as inside, else 1.
    closed: [i64; 3],
    /// Twice the area, in squared steps.
    doubled_area: i64,
    /// First row and row after the last, of those that can have samples.
    rows: [i64; 2],
}

impl Fill {
    /// The fill of a triangle that shows its front, or nothing where it shows its back or no area.
    pub(crate) fn new(triangle: &ScreenTriangle) -> Option<Self> {
        let [a, b, c] = triangle.map(|corner| [corner.x, corner.y]);
        // Samples are at the middle of their cells.
        let half = SNAP / 2;
        let edge = |from: [i64; 2], to: [i64; 2]| {
            let (dx, dy) = (from[0] - to[0], from[1] - to[1]);
            let at_first = dx * (half - from[1]) - dy * (half - from[0]);
            // Samples on an edge count as moved right, and infinitely less far down.
            let leads_inside = dy < 0 || (dy == 0 && dx > 0);
            ([at_first, -dy * SNAP, dx * SNAP], i64::from(!leads_inside))
        };
        // The front runs counter-clockwise as one sees it; y runs down: hence c before b, and the edges backwards.
        let doubled_area = (c[0] - a[0]) * (b[1] - a[1]) - (c[1] - a[1]) * (b[0] - a[0]);
        if doubled_area <= 0 {
            return None;
        }
        let ((e0, c0), (e1, c1), (e2, c2)) = (edge(b, c), edge(c, a), edge(a, b));
        let low = a[1].min(b[1]).min(c[1]);
        let high = a[1].max(b[1]).max(c[1]);
        let rows = [(low - half).div_euclid(SNAP), (high - half).div_euclid(SNAP) + 1];
        Some(Self { edges: [e0, e1, e2], closed: [c0, c1, c2], doubled_area, rows })
    }

    /// First row and row after the last that can have samples.
    pub(crate) fn rows(&self) -> [i64; 2] {
        self.rows
    }

    /// The covered samples of a row, among the first `width`: first column and column after the last.
    pub(crate) fn span(&self, row: i64, width: i64) -> Option<[i64; 2]> {
        let (mut first, mut end) = (0, width);
        for ([at_first, right, down], closed) in self.edges.iter().zip(self.closed) {
            // Inside: value + right * column >= 0.
            let value = at_first + down * row - closed;
            match right.signum() {
                1 => first = first.max(-value.div_euclid(*right)),
                -1 => end = end.min(value.div_euclid(-right) + 1),
                _ if value < 0 => return None,
                _ => {}
            }
        }
        (first < end).then_some([first, end])
    }

    /// How the barycentric weights change from a sample to the next one on the right, and to the next one below.
    pub(crate) fn weight_steps(&self) -> [[f64; 3]; 2] {
        let scale = 1.0 / self.doubled_area as f64;
        [1, 2].map(|axis| self.edges.map(|edge| edge[axis] as f64 * scale))
    }

    /// Barycentric weights of a sample, by corner.
    pub(crate) fn weights(&self, column: i64, row: i64) -> [f64; 3] {
        let scale = 1.0 / self.doubled_area as f64;
        self.edges.map(|[at_first, right, down]| (at_first + right * column + down * row) as f64 * scale)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::project::Corner;

    const SIZE: i64 = 12;

    fn triangle(corners: [[i64; 2]; 3]) -> ScreenTriangle {
        corners.map(|[x, y]| Corner { x, y, inverse_depth: 1.0, color_over_depth: [0.0; 3], uv_over_depth: [0.0; 2] })
    }

    /// How often each sample of a small square picture is covered.
    fn covered(triangles: &[[[i64; 2]; 3]]) -> Vec<u32> {
        let mut count = vec![0; (SIZE * SIZE) as usize];
        for fill in triangles.iter().filter_map(|t| Fill::new(&triangle(*t))) {
            for row in fill.rows()[0].max(0)..fill.rows()[1].min(SIZE) {
                let Some([first, end]) = fill.span(row, SIZE) else { continue };
                (first..end).for_each(|column| count[(row * SIZE + column) as usize] += 1);
            }
        }
        count
    }

    #[test]
    fn two_halves_of_a_square_cover_it_exactly_once() {
        let side = SIZE * SNAP;
        // The diagonal passes exactly through samples.
        let count = covered(&[[[0, 0], [0, side], [side, side]], [[0, 0], [side, side], [side, 0]]]);
        assert!(count.iter().all(|&n| n == 1), "{count:?}");
    }

    #[test]
    fn a_triangle_seen_from_behind_covers_nothing() {
        let side = SIZE * SNAP;
        assert!(Fill::new(&triangle([[0, 0], [side, side], [0, side]])).is_none());
        assert!(Fill::new(&triangle([[0, 0], [side, side], [2 * side, 2 * side]])).is_none());
    }

    #[test]
    fn weights_are_barycentric() {
        let fill = Fill::new(&triangle([[128, 128], [128, 1152], [1152, 128]])).unwrap();
        assert_eq!(fill.weights(0, 0), [1.0, 0.0, 0.0]);
        assert_eq!(fill.weights(0, 4), [0.0, 1.0, 0.0]);
        assert_eq!(fill.weights(1, 1), [0.5, 0.25, 0.25]);
        assert_eq!(fill.weight_steps(), [[-0.25, 0.0, 0.25], [-0.25, 0.25, 0.0]]);
    }

    proptest! {
        /// A fan of triangles around a point, out to the corners of the picture and beyond: samples on edges and on the
        /// common corner included (coordinates are multiples of half a sample), each is covered once.
        #[test]
        fn a_fan_has_no_crack_and_no_overlap(
            x in 1..2 * SIZE, y in 1..2 * SIZE, jitter in 0..2i64,
            cuts in prop::collection::btree_set(0..8 * SIZE, 0..6),
        ) {
            let side = 2 * SIZE;
            let on_border = |at: i64| match at / side {
                0 => [0, at],
                1 => [at - side, side],
                2 => [side, 3 * side - at],
                _ => [4 * side - at, 0],
            };
            let mut rim: Vec<i64> = cuts.into_iter().chain([0, side, 2 * side, 3 * side]).collect();
            rim.sort_unstable();
            rim.dedup();
            let half = SNAP / 2;
            let middle = [x * half + jitter * 37, y * half + jitter * 11];
            let fan: Vec<_> = (0..rim.len())
                .map(|i| [rim[i], rim[(i + 1) % rim.len()]].map(|at| on_border(at).map(|v| v * half)))
                .map(|[from, to]| [middle, from, to])
                .collect();
            let count = covered(&fan);
            prop_assert!(count.iter().all(|&n| n == 1), "{count:?}");
        }
    }
}
