//! Noding: edges are cut until they meet in end points only.
//!
//! An edge is cut at every point within the weld distance of it, and two edges are cut where they cross: in the frame
//! of a plane that they share, or in space. Cutting bends an edge by less than the weld distance, so pieces are looked
//! at again until nothing changes. Edges are known by their ends in all planes together: what one plane cuts, all do,
//! and the pieces of two edges that lie on each other are the same pieces.
//!
//! Holds after: no point of an edge lies within the weld distance of another edge, but for its own ends; edges of one
//! plane do not cross. Where rounding leaves no other way, an exception is counted.
//!
//! It ends because an edge is cut only into strictly shorter ones.

use std::collections::HashMap;

use glam::DVec3;
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};
use smallvec::SmallVec;

use super::PrepareError;
use super::coplanar::Planes;
use super::crossing::{Span, crossing};
use super::entangled::Meetings;
use super::near::{NearSegment, PlacedPoint, points_within};
use super::weld::Points;
use crate::geometry::Tolerance;
use crate::id::{PlaneId, VertexId};
use crate::progress::Cancelled;

/// Rounds of cutting after which what is left is given up: crossings make points, whose cuts may make crossings, but
/// each time by less than the weld distance; two or three rounds are usual.
const MOST_ROUNDS: usize = 16;
/// An edge and what it was cut into.
#[derive(Clone, Debug)]
struct Segment {
    /// Ascending.
    ends: [VertexId; 2],
    planes: SmallVec<[PlaneId; 2]>,
    /// Points between the ends, in order; none for an edge that is whole.
    nodes: SmallVec<[VertexId; 2]>,
}

impl Segment {
    fn is_whole(&self) -> bool {
        self.nodes.is_empty()
    }

    fn has_end_of(&self, other: &Self) -> bool {
        self.ends.iter().any(|v| other.ends.contains(v))
    }
}

/// Edges, each once, with the pieces that they were cut into.
#[derive(Debug, Default)]
pub(super) struct Segments {
    all: Vec<Segment>,
    number_of: HashMap<[VertexId; 2], usize>,
    /// Edges that came since the last look at points, and at crossings.
    fresh: Vec<usize>,
    uncrossed: Vec<usize>,
    /// Which points were the end of an edge at the last look at points.
    used: Vec<bool>,
}

impl Segments {
    /// Adds an edge of a plane; its ends differ.
    pub(super) fn add(&mut self, ends: [VertexId; 2], planes: &[PlaneId]) {
        let ends = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let number = *self.number_of.entry(ends).or_insert_with(|| {
            self.all.push(Segment { ends, planes: SmallVec::new(), nodes: SmallVec::new() });
            self.fresh.push(self.all.len() - 1);
            self.uncrossed.push(self.all.len() - 1);
            self.all.len() - 1
        });
        let segment = &mut self.all[number];
        let before = segment.planes.len();
        for &plane in planes {
            if !segment.planes.contains(&plane) {
                segment.planes.push(plane);
            }
        }
        if segment.planes.len() > before && !segment.is_whole() {
            let pieces = children(segment);
            pieces.into_iter().for_each(|piece| self.add(piece, planes));
        }
    }

    /// The whole pieces of an edge, in the direction from its first end to its second.
    pub(super) fn pieces(&self, ends: [VertexId; 2], out: &mut Vec<[VertexId; 2]>) {
        let sorted = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let Some(&number) = self.number_of.get(&sorted) else { return };
        let segment = &self.all[number];
        if segment.is_whole() {
            out.push(ends);
            return;
        }
        let mut pieces = children(segment);
        if sorted != ends {
            pieces.reverse();
            pieces.iter_mut().for_each(|piece| piece.reverse());
        }
        pieces.into_iter().for_each(|piece| self.pieces(piece, out));
    }

    /// Cuts all edges until nothing changes. Returns how many cuts were given up.
    pub(super) fn cut(
        &mut self,
        planes: &Planes,
        points: &mut Points,
        tolerance: &Tolerance,
        meetings: &Meetings,
        mut pulse: impl FnMut() -> Result<(), Cancelled>,
    ) -> Result<usize, PrepareError> {
        for _ in 0..MOST_ROUNDS {
            while !self.fresh.is_empty() {
                self.cut_at_points(planes, points, tolerance);
                pulse()?;
            }
            let crossings = self.cut_at_crossings(planes, points, tolerance, meetings)?;
            pulse()?;
            if crossings == 0 {
                return Ok(0);
            }
        }
        Ok(self.fresh.len())
    }

    /// Cuts fresh edges at the points that lie on them, and all others at points that are newly in use.
    fn cut_at_points(&mut self, planes: &Planes, points: &Points, tolerance: &Tolerance) {
        let mut is_fresh = vec![false; self.all.len()];
        std::mem::take(&mut self.fresh).into_iter().for_each(|i| is_fresh[i] = true);
        let mut used: Vec<VertexId> = self.all.iter().filter(|s| s.is_whole()).flat_map(|s| s.ends).collect();
        used.sort_unstable();
        used.dedup();
        self.used.resize(points.len(), false);
        let new: Vec<VertexId> = used.iter().copied().filter(|v| !self.used[v.index()]).collect();
        new.iter().for_each(|v| self.used[v.index()] = true);
        let tree_of = |vertices: &[VertexId]| -> RTree<PlacedPoint> {
            RTree::bulk_load(vertices.iter().map(|&v| PlacedPoint::new(points[v].to_array(), v)).collect())
        };
        let (all_points, new_points) = (tree_of(&used), tree_of(&new));
        let look_at: Vec<usize> =
            (0..self.all.len()).filter(|&i| self.all[i].is_whole() && (is_fresh[i] || !new.is_empty())).collect();
        let on = |&i: &usize| {
            let tree = if is_fresh[i] { &all_points } else { &new_points };
            self.points_on(i, tree, planes, points, tolerance)
        };
        let cuts: Vec<Vec<VertexId>> = look_at.par_iter().map(on).collect();
        for (i, nodes) in look_at.into_iter().zip(cuts) {
            self.cut_one(i, &nodes, points);
        }
    }

    /// The points within the weld distance of an edge and of all its planes, but for its ends.
    fn points_on(
        &self,
        number: usize,
        tree: &RTree<PlacedPoint>,
        planes: &Planes,
        points: &Points,
        tolerance: &Tolerance,
    ) -> Vec<VertexId> {
        let segment = &self.all[number];
        let in_plane = |v: VertexId, plane: PlaneId| {
            planes.frames[plane].plane.signed_distance_m(points[v]).abs() <= tolerance.weld_m()
        };
        let mut found = points_within(tree, segment.ends.map(|v| points[v]), tolerance.weld_m());
        found.retain(|&v| !segment.ends.contains(&v) && segment.planes.iter().all(|&plane| in_plane(v, plane)));
        found
    }

    /// Cuts edges where they cross; returns how many cuts there were.
    fn cut_at_crossings(
        &mut self,
        planes: &Planes,
        points: &mut Points,
        tolerance: &Tolerance,
        meetings: &Meetings,
    ) -> Result<usize, PrepareError> {
        let new: Vec<usize> =
            std::mem::take(&mut self.uncrossed).into_iter().filter(|&i| self.all[i].is_whole()).collect();
        let boxes = self.all.iter().enumerate().filter(|(_, s)| s.is_whole()).map(|(i, s)| {
            let [a, b] = s.ends.map(|v| points[v]);
            GeomWithData::new(Rectangle::from_corners(a.min(b).to_array(), a.max(b).to_array()), i)
        });
        let tree = RTree::bulk_load(boxes.collect());
        let mut is_new = vec![false; self.all.len()];
        new.iter().for_each(|&i| is_new[i] = true);
        let span = |i: usize| Span { ends: self.all[i].ends.map(|v| points[v]), planes: &self.all[i].planes };
        let found: Vec<Vec<(usize, DVec3)>> = new
            .par_iter()
            .map(|&i| {
                if !meetings.add(0) {
                    return Vec::new();
                }
                let near = NearSegment::new(self.all[i].ends.map(|v| points[v]), 2.0 * tolerance.weld_m());
                let mut met: Vec<(usize, DVec3)> = tree
                    .locate_with_selection_function(near)
                    .map(|other| other.data)
                    .filter(|&j| j != i && (j > i || !is_new[j]) && !self.all[i].has_end_of(&self.all[j]))
                    .filter_map(|j| Some((j, crossing(&span(i), &span(j), planes, tolerance)?)))
                    .collect();
                met.sort_unstable_by_key(|&(j, _)| j);
                meetings.add(met.len());
                met
            })
            .collect();
        meetings.check()?;
        let mut nodes: Vec<Vec<VertexId>> = vec![Vec::new(); self.all.len()];
        for (&i, met) in new.iter().zip(found) {
            for (j, place) in met {
                let point = points.weld(place);
                [i, j].into_iter().filter(|&k| !self.all[k].ends.contains(&point)).for_each(|k| nodes[k].push(point));
            }
        }
        let mut cuts = 0;
        for (i, mut points_on_it) in nodes.into_iter().enumerate() {
            points_on_it.sort_unstable();
            points_on_it.dedup();
            cuts += usize::from(self.cut_one(i, &points_on_it, points));
        }
        Ok(cuts)
    }

    /// Cuts an edge at points on it, or at one of them where not all pieces would be shorter. Returns whether it did.
    fn cut_one(&mut self, number: usize, nodes: &[VertexId], points: &Points) -> bool {
        let [a, b] = self.all[number].ends;
        let (start, along) = (points[a], points[b] - points[a]);
        let mut nodes: SmallVec<[VertexId; 2]> = nodes.iter().copied().collect();
        nodes.sort_by(|&p, &q| along.dot(points[p] - start).total_cmp(&along.dot(points[q] - start)).then(p.cmp(&q)));
        let shortens = |nodes: &[VertexId]| {
            let stops: SmallVec<[VertexId; 4]> = [a].into_iter().chain(nodes.iter().copied()).chain([b]).collect();
            stops.windows(2).all(|w| points[w[0]].distance_squared(points[w[1]]) < along.length_squared())
        };
        if !shortens(&nodes) {
            let Some(&one) = nodes.iter().find(|&&node| shortens(&[node])) else { return false };
            nodes = [one].into_iter().collect();
        }
        if nodes.is_empty() {
            return false;
        }
        self.all[number].nodes = nodes;
        let planes = self.all[number].planes.clone();
        children(&self.all[number]).into_iter().for_each(|piece| self.add(piece, &planes));
        true
    }
}

fn children(segment: &Segment) -> SmallVec<[[VertexId; 2]; 4]> {
    let [a, b] = segment.ends;
    let stops: SmallVec<[VertexId; 4]> = [a].into_iter().chain(segment.nodes.iter().copied()).chain([b]).collect();
    stops.windows(2).map(|w| [w[0], w[1]]).collect()
}

#[cfg(test)]
mod tests {
    use super::super::soup::Polygon;
    use super::super::testing::{Small, TOLERANCE};
    use super::*;

    /// Cuts the sides of polygons; returns the pieces of each side in micrometres.
    fn pieces_of(polygons: &[&[[f64; 3]]]) -> Vec<Vec<[[i64; 3]; 2]>> {
        let mut small = Small::new(polygons);
        let mut segments = Segments::default();
        for (polygon, &(plane, _)) in small.soup.iter().zip(&small.planes.of_polygon) {
            polygon.sides().for_each(|ends| segments.add(ends, &[plane]));
        }
        assert_eq!(segments.cut(&small.planes, &mut small.points, &TOLERANCE, &Meetings::of(9), || Ok(())), Ok(0));
        let mut all = Vec::new();
        for side in small.soup.iter().flat_map(Polygon::sides) {
            let mut pieces = Vec::new();
            segments.pieces(side, &mut pieces);
            assert_eq!((pieces[0][0], pieces[pieces.len() - 1][1]), (side[0], side[1]));
            assert!(pieces.windows(2).all(|w| w[0][1] == w[1][0]));
            all.push(pieces.into_iter().map(|piece| small.micrometres(piece)).collect());
        }
        all
    }

    #[test]
    fn sides_that_overlap_have_common_pieces() {
        let long = &[[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 5.0, 0.0]];
        let short = &[[4.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.0, 3.0]];
        let pieces = pieces_of(&[long, short]);
        assert_eq!(pieces[0].len(), 3);
        assert_eq!(pieces[3], [pieces[0][1]]);
    }

    #[test]
    fn crossing_sides_of_one_plane_are_cut_at_one_point() {
        let one = &[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let other = &[[1.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 3.0, 0.0], [1.0, 3.0, 0.0]];
        let pieces = pieces_of(&[one, other]);
        assert_eq!(pieces.iter().map(Vec::len).collect::<Vec<_>>(), [3, 1, 3, 1, 1, 3, 1, 3]);
        assert_eq!(pieces[0][1], [[1_000_000, 0, 0], [2_000_000, 0, 0]]);
    }

    #[test]
    fn a_crossing_at_a_known_point_cuts_what_passes_through_it() {
        // Six sides through one point, which no polygon has as a corner.
        let fan: Vec<[[f64; 3]; 3]> = (0..6)
            .map(|i| f64::from(i) * 0.5)
            .map(|a| [[-3.0 * a.cos(), -3.0 * a.sin(), 0.0], [3.0 * a.cos(), 3.0 * a.sin(), 0.0], [0.0, 0.0, 4.0 + a]])
            .collect();
        let polygons: Vec<&[[f64; 3]]> = fan.iter().map(|t| &t[..]).collect();
        let pieces = pieces_of(&polygons);
        assert!((0..6).all(|i| pieces[3 * i].len() == 2));
    }
}
