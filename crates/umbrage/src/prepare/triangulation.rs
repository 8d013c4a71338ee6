//! Constrained Delaunay triangulation of points and edges in a plane, by the crate `spade`, as plain tables.
//!
//! Every triangle knows what lies behind each of its sides and which of the given edges the side is. An edge that
//! cannot be inserted, because it crosses another or passes through a point, is left out and counted: callers node
//! their edges first, so this happens only where rounding leaves no other way.
//!
//! Triangles are cells' raw material: [`Triangulation::cells`] gathers those with no edge between them.

use std::collections::HashMap;

use crate::id::VertexId;
use glam::DVec2;
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation as _};

/// Coordinates below this (in metres) are zero: the exact predicates have no smaller products.
const LEAST_COORDINATE_M: f64 = 1e-40;

/// A point that remembers its number.
#[derive(Clone, Copy, Debug)]
struct Site {
    position: DVec2,
    number: u32,
}

impl HasPosition for Site {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        let round = |x: f64| if x.abs() < LEAST_COORDINATE_M { 0.0 } else { x };
        Point2::new(round(self.position.x), round(self.position.y))
    }
}

/// A triangle; side `i` runs from corner `i` to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Triangle {
    /// Numbers of the corners, counter-clockwise.
    pub(super) corners: [u32; 3],
    /// The triangle behind each side, if any.
    pub(super) neighbours: [Option<u32>; 3],
    /// The given edge that each side is, if any.
    pub(super) edges: [Option<u32>; 3],
}

impl Triangle {
    /// The ends of side `i`, in order.
    pub(super) fn side(&self, i: usize) -> [u32; 2] {
        [self.corners[i], self.corners[(i + 1) % 3]]
    }
}

/// A triangulation of the convex hull of its points.
#[derive(Debug)]
pub(super) struct Triangulation {
    /// The triangles.
    pub(super) triangles: Vec<Triangle>,
    /// How many of the given edges could not be inserted.
    pub(super) missing_edges: usize,
}

impl Triangulation {
    /// Triangulates finite `points` with `edges` between them, each of two different points and given once.
    pub(super) fn new(points: &[DVec2], edges: &[[u32; 2]]) -> Self {
        let sites = points.iter().zip(0..).map(|(&position, number)| Site { position, number }).collect();
        let constraints = edges.iter().map(|e| e.map(|i| i as usize)).collect();
        let Ok(cdt) = ConstrainedDelaunayTriangulation::<Site>::try_bulk_load_cdt(sites, constraints, |_| ()) else {
            return Self { triangles: Vec::new(), missing_edges: edges.len() };
        };
        let number_of: HashMap<[u32; 2], u32> = edges.iter().map(|&[a, b]| [a.min(b), a.max(b)]).zip(0..).collect();
        let mut found = vec![false; edges.len()];
        let triangles = cdt
            .inner_faces()
            .map(|face| {
                let sides = face.adjacent_edges();
                let edges = sides.map(|side| {
                    let [a, b] = side.vertices().map(|v| v.data().number);
                    let edge = number_of.get(&[a.min(b), a.max(b)]).copied();
                    if let Some(e) = edge {
                        found[e as usize] = true;
                    }
                    edge
                });
                Triangle {
                    corners: sides.map(|side| side.from().data().number),
                    neighbours: sides.map(|side| side.rev().face().as_inner().map(|f| f.index() as u32 - 1)),
                    edges,
                }
            })
            .collect();
        Self { triangles, missing_edges: found.iter().filter(|&&f| !f).count() }
    }

    /// The number of each triangle's cell: triangles with no edge between them lie in one. Cells are numbered in the
    /// order of their first triangles.
    pub(super) fn cells(&self) -> Cells {
        let mut cell_of = vec![u32::MAX; self.triangles.len()];
        let mut count = 0;
        let mut open = Vec::new();
        for start in 0..self.triangles.len() {
            if cell_of[start] != u32::MAX {
                continue;
            }
            cell_of[start] = count;
            open.push(start);
            while let Some(t) = open.pop() {
                let triangle = &self.triangles[t];
                for i in 0..3 {
                    if let (Some(next), None) = (triangle.neighbours[i], triangle.edges[i])
                        && cell_of[next as usize] == u32::MAX
                    {
                        cell_of[next as usize] = count;
                        open.push(next as usize);
                    }
                }
            }
            count += 1;
        }
        Cells { cell_of, count: count as usize }
    }

    /// The triangles inside a closed polygon whose sides are the edges, by the rule of odd crossings.
    pub(super) fn inside(&self) -> Vec<[u32; 3]> {
        let cells = self.cells();
        let mut odd = vec![None; cells.count];
        let mut open: Vec<(usize, bool)> = Vec::new();
        for (t, triangle) in self.triangles.iter().enumerate() {
            for i in 0..3 {
                if triangle.neighbours[i].is_none() {
                    open.push((cells.cell_of[t] as usize, triangle.edges[i].is_some()));
                }
            }
        }
        let borders = self.borders(&cells);
        while let Some((cell, is_odd)) = open.pop() {
            if odd[cell].is_none() {
                odd[cell] = Some(is_odd);
                open.extend(borders[cell].iter().map(|&next| (next as usize, !is_odd)));
            }
        }
        let is_inside = |t: &usize| odd[cells.cell_of[*t] as usize] == Some(true);
        (0..self.triangles.len()).filter(is_inside).map(|t| self.triangles[t].corners).collect()
    }

    /// The cells behind each cell's edges.
    fn borders(&self, cells: &Cells) -> Vec<Vec<u32>> {
        let mut borders = vec![Vec::new(); cells.count];
        for (t, triangle) in self.triangles.iter().enumerate() {
            for i in 0..3 {
                if let (Some(next), Some(_)) = (triangle.neighbours[i], triangle.edges[i]) {
                    borders[cells.cell_of[t] as usize].push(cells.cell_of[next as usize]);
                }
            }
        }
        borders
    }
}

/// The triangles that fill a closed loop of points, counter-clockwise in the plane. A loop may pass an edge there and
/// back, as one does that joins a hole to its border.
pub(super) fn fill(corners: &[VertexId], position: impl Fn(VertexId) -> DVec2) -> Vec<[VertexId; 3]> {
    let mut vertices = corners.to_vec();
    vertices.sort_unstable();
    vertices.dedup();
    let points: Vec<DVec2> = vertices.iter().map(|&v| position(v)).collect();
    let number = |v: VertexId| vertices.partition_point(|&other| other < v) as u32;
    let mut sides: Vec<[u32; 2]> = (0..corners.len())
        .map(|i| [number(corners[i]), number(corners[(i + 1) % corners.len()])])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    sides.sort_unstable();
    let odd: Vec<[u32; 2]> = sides.chunk_by(|a, b| a == b).filter(|run| run.len() % 2 == 1).map(|run| run[0]).collect();
    Triangulation::new(&points, &odd).inside().into_iter().map(|t| t.map(|i| vertices[i as usize])).collect()
}

/// Which cell each triangle lies in.
#[derive(Debug)]
pub(super) struct Cells {
    /// The cell of each triangle.
    pub(super) cell_of: Vec<u32>,
    /// How many cells there are.
    pub(super) count: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loop_of(n: u32) -> Vec<[u32; 2]> {
        (0..n).map(|i| [i, (i + 1) % n]).collect()
    }

    fn area_of(points: &[DVec2], triangles: &[[u32; 3]]) -> f64 {
        let corner = |i: u32| points[i as usize];
        triangles.iter().map(|&[a, b, c]| 0.5 * (corner(b) - corner(a)).perp_dot(corner(c) - corner(a))).sum()
    }

    #[test]
    fn an_l_is_filled_and_its_notch_is_not() {
        let points = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 2.0), (0.0, 2.0)].map(DVec2::from);
        let t = Triangulation::new(&points, &loop_of(6));
        assert_eq!(t.missing_edges, 0);
        assert_eq!(area_of(&points, &t.inside()), 3.0);
        assert_eq!(t.cells().count, 2);
    }

    #[test]
    fn a_loop_with_a_bridge_to_its_hole_is_filled() {
        let points = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (1.0, 1.0), (1.0, 2.0), (2.0, 2.0), (2.0, 1.0)]
            .map(DVec2::from);
        let corners = [0, 1, 2, 3, 0, 4, 5, 6, 7, 4].map(VertexId::from);
        let triangles = fill(&corners, |v| points[v.index()]);
        let numbers: Vec<_> = triangles.iter().map(|t| t.map(|v| v.index() as u32)).collect();
        assert_eq!(area_of(&points, &numbers), 15.0);
    }

    #[test]
    fn neighbours_are_mutual() {
        let points = [(0.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0), (1.0, 1.0)].map(DVec2::from);
        let t = Triangulation::new(&points, &loop_of(4));
        for (number, triangle) in t.triangles.iter().enumerate() {
            for i in 0..3 {
                if let Some(next) = triangle.neighbours[i] {
                    let [a, b] = triangle.side(i);
                    let other = &t.triangles[next as usize];
                    assert!((0..3).any(|j| other.side(j) == [b, a] && other.neighbours[j] == Some(number as u32)));
                }
            }
        }
    }

    #[test]
    fn crossing_edges_are_counted_and_never_panic() {
        let points = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)].map(DVec2::from);
        assert_eq!(Triangulation::new(&points, &[[0, 1], [2, 3]]).missing_edges, 1);
        let line = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)].map(DVec2::from);
        assert!(Triangulation::new(&line, &[[0, 1]]).triangles.is_empty());
    }

    #[test]
    fn a_duplicate_point_is_survived() {
        let points = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from);
        assert_eq!(area_of(&points, &Triangulation::new(&points, &[[0, 1]]).inside()), 0.0);
    }
}
