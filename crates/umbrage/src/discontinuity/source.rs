//! Features of the sources: the edges across which emitted light can step, and their corners.
//!
//! Events come from where the light of an emitter ends or changes, as the eye sees it: an edge between convex pieces of
//! one emitter never steps, one between two touching emitters steps by their difference, one between two faces of a
//! glowing box steps where only one of them is seen.

use glam::DVec3;
use smallvec::{SmallVec, smallvec};

use super::Emitter;
use crate::geometry::{Plane, polygon};
use crate::id::{EdgeId, EmitterId, FaceId, Table, VertexId};
use crate::prepare::Prepared;
use crate::scene::Rgb;

/// Directions whose sine is below this are one: rounding of f32 vertices on an edge of a hundredth of the extent.
const STRAIGHT_SINE: f64 = 1e-5;

/// A step of radiance within an emitter that is less than this share of it casts no lines: they would be as many times weaker than those
/// of its outline, and pictures on tiles of a sky or of lava give each a mean of its own.
const FAINT_STEP: f64 = 0.05;

/// Two fronts are one around an edge where cosines between normals and between inward directions cancel out within this: else they sum to
/// up to 2.
const FRONT_GOES_ON: f64 = 0.1;
/// Inward directions with a greater cosine are upon one another, as the sides of a sheet.
const LEAST_OPEN: f64 = 0.99;

/// A face beside an edge.
#[derive(Clone, Copy, Debug)]
struct Beside {
    /// Away from the edge into the face, a unit vector across the edge.
    inward: DVec3,
    normal: DVec3,
    radiance: Rgb,
}

/// An edge across which emitted light can step.
#[derive(Clone, Debug)]
pub(super) struct SourceEdge {
    pub(super) edge: EdgeId,
    /// The first emitter along it.
    pub(super) emitter: EmitterId,
    /// All emitters along it, ascending.
    pub(super) emitters: SmallVec<[EmitterId; 2]>,
    pub(super) ends: [VertexId; 2],
    pub(super) ends_m: [DVec3; 2],
    beside: SmallVec<[Beside; 2]>,
}

impl SourceEdge {
    /// The normals of the faces along the edge.
    pub(super) fn normals(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.beside.iter().map(|face| face.normal)
    }

    /// By how much radiance steps across the edge, as it is seen from `eye_m` before a background that emits `behind`.
    /// Faces whose plane is within `slack_m` of the eye are seen edge-on.
    pub(super) fn step(&self, eye_m: DVec3, slack_m: f64, behind: Rgb) -> Rgb {
        let [left, right] = self.sides(self.across(eye_m), eye_m, slack_m, behind);
        right - left
    }

    /// The normal of the plane through the edge and an eye.
    fn across(&self, eye_m: DVec3) -> DVec3 {
        (self.ends_m[1] - self.ends_m[0]).cross(eye_m - self.ends_m[0]).normalize_or_zero()
    }

    /// The radiance on both sides of the edge, as [`Self::step`] sees it: behind a plane through edge and eye with the
    /// normal `across`, and in front of it.
    pub(super) fn sides(&self, across: DVec3, eye_m: DVec3, slack_m: f64, behind: Rgb) -> [Rgb; 2] {
        let [from, to] = self.ends_m;
        let to_eye = eye_m - from;
        let towards = self.across(eye_m).cross(to - from).normalize_or_zero();
        let lean = |face: &Beside| face.inward.dot(towards);
        [-1.0, 1.0].map(|side| {
            let on_side =
                |face: &&Beside| face.normal.dot(to_eye).abs() > slack_m && face.inward.dot(across) * side > 0.0;
            let seen = || self.beside.iter().filter(on_side);
            let Some(most) = seen().map(lean).reduce(f64::max) else { return behind };
            // The two sides of a sheet are at one place: the one that is turned to the eye is seen.
            let mut nearest = seen().filter(|face| lean(face) >= most - STRAIGHT_SINE);
            nearest.find(|face| face.normal.dot(to_eye) > 0.0).map_or(Rgb::ZERO, |face| face.radiance)
        })
    }

    /// The parts of a line in a plane with this edge, divided where it crosses the line of the edge. What lies within
    /// `slack_m` of that is left out.
    pub(super) fn parts_beside(&self, plane: &Plane, line: [DVec3; 2], slack_m: f64) -> SmallVec<[[DVec3; 2]; 2]> {
        let [from, to] = self.ends_m;
        let Some(across) = plane.normal.cross(to - from).try_normalize() else { return SmallVec::new() };
        let heights_m = line.map(|end| across.dot(end - from));
        let part = |side: f64| {
            let over = heights_m.map(|height_m| side * height_m - slack_m);
            let crossing = || line[0].lerp(line[1], over[0] / (over[0] - over[1]));
            match over.map(|height_m| height_m > 0.0) {
                [true, true] => Some(line),
                [true, false] => Some([line[0], crossing()]),
                [false, true] => Some([crossing(), line[1]]),
                [false, false] => None,
            }
        };
        [1.0, -1.0].into_iter().filter_map(part).collect()
    }
}

/// A corner of a source.
#[derive(Clone, Debug)]
pub(super) struct SourceVertex {
    pub(super) vertex: VertexId,
    /// The first emitter at it.
    pub(super) emitter: EmitterId,
    pub(super) at_m: DVec3,
    /// Numbers of the source edges at it.
    pub(super) edges: SmallVec<[usize; 3]>,
}

/// Edges and corners of all sources.
#[derive(Clone, Debug)]
pub(super) struct Sources {
    pub(super) edges: Vec<SourceEdge>,
    pub(super) vertices: Vec<SourceVertex>,
    /// Numbers of the edges along each emitter, ascending.
    pub(super) of_emitter: Table<EmitterId, Vec<usize>>,
}

impl Sources {
    /// The edges and corners of emitters among faces that have these radiances, and of those that are parts of faces.
    pub(super) fn new(
        prepared: &Prepared,
        radiance: &Table<FaceId, Rgb>,
        emitters: &Table<EmitterId, Emitter>,
    ) -> Self {
        let (parts, whole): (Vec<_>, Vec<_>) =
            emitters.iter_enumerated().partition(|(_, emitter)| emitter.part_m.is_some());
        let mut of_face: Table<FaceId, Option<EmitterId>> = prepared.faces.iter().map(|_| None).collect();
        for (id, emitter) in whole {
            emitter.faces.iter().for_each(|&face| of_face[face] = Some(id));
        }
        let mut edges = Vec::new();
        for (id, edge) in prepared.edges.iter_enumerated() {
            let mut along: SmallVec<[EmitterId; 2]> = edge.faces.iter().filter_map(|&face| of_face[face]).collect();
            along.sort_unstable();
            along.dedup();
            let Some(&emitter) = along.first() else { continue };
            // Faces of one emitter look the same way: two at an edge lie on both sides of it.
            let goes_on =
                |emitter: &EmitterId| edge.faces.iter().filter(|&&face| of_face[face] == Some(*emitter)).count() == 2;
            let plane = prepared.faces[edge.faces[0]].plane;
            if edge.faces.iter().all(|&face| prepared.faces[face].plane == plane) && along.iter().all(goes_on) {
                continue;
            }
            let ends_m = edge.ends.map(|vertex| prepared.vertices_m[vertex]);
            let beside = |&face: &FaceId| {
                let inside = polygon::centroid(&prepared.polygon_m(face));
                Beside { inward: inward(ends_m, inside), normal: prepared.normal(face), radiance: radiance[face] }
            };
            let beside: SmallVec<[Beside; 2]> = edge.faces.iter().map(beside).collect();
            if never_steps(&beside) {
                continue;
            }
            edges.push(SourceEdge { edge: id, emitter, emitters: along, ends: edge.ends, ends_m, beside });
        }
        for (id, part) in parts {
            edges.extend(part.outline.iter().map(|&edge| {
                let ends = prepared.edges[edge].ends;
                let ends_m = ends.map(|vertex| prepared.vertices_m[vertex]);
                let (inward, normal) = (inward(ends_m, part.centroid_m), part.plane.normal);
                let beside = smallvec![Beside { inward, normal, radiance: part.radiance }];
                SourceEdge { edge, emitter: id, emitters: smallvec![id], ends, ends_m, beside }
            }));
        }
        let vertices = vertices(prepared, &edges);
        let mut of_emitter: Table<EmitterId, Vec<usize>> = emitters.iter().map(|_| Vec::new()).collect();
        for (number, edge) in edges.iter().enumerate() {
            edge.emitters.iter().for_each(|&emitter| of_emitter[emitter].push(number));
        }
        Self { edges, vertices, of_emitter }
    }
}

/// Whether light steps across an edge by next to nothing, from wherever it is seen: two faces that emit about alike, in one plane or as the
/// sides of a hollow. From behind one side of a hollow that side's back hides the edge of the other.
fn never_steps(beside: &[Beside]) -> bool {
    let [one, other] = beside else { return false };
    let (darker, brighter) = (one.radiance.min(other.radiance), one.radiance.max(other.radiance));
    let is_hollow = one.normal.dot(other.inward) > -STRAIGHT_SINE && other.normal.dot(one.inward) > -STRAIGHT_SINE;
    // One front goes on in the other: by any angle between them the two cosines are opposite.
    let between = one.inward.dot(other.inward);
    let goes_on = (one.normal.dot(other.normal) + between).abs() < FRONT_GOES_ON && between < LEAST_OPEN;
    is_hollow && goes_on && (brighter - darker).max_element() <= FAINT_STEP * brighter.max_element()
}

/// The unit vector across an edge towards a point.
fn inward([from, to]: [DVec3; 2], inside: DVec3) -> DVec3 {
    let (along, into) = ((to - from).normalize_or_zero(), inside - from);
    (into - into.dot(along) * along).normalize_or_zero()
}

/// The vertices at which source edges do not simply go straight on.
fn vertices(prepared: &Prepared, edges: &[SourceEdge]) -> Vec<SourceVertex> {
    let mut ends: Vec<(VertexId, usize)> =
        edges.iter().enumerate().flat_map(|(i, edge)| edge.ends.map(|vertex| (vertex, i))).collect();
    ends.sort_unstable();
    ends.chunk_by(|p, q| p.0 == q.0)
        .filter(|at| {
            let along = |i: usize| (edges[at[i].1].ends_m[1] - edges[at[i].1].ends_m[0]).normalize_or_zero();
            !(at.len() == 2 && along(0).cross(along(1)).length() < STRAIGHT_SINE)
        })
        .map(|at| SourceVertex {
            vertex: at[0].0,
            emitter: at.iter().map(|end| edges[end.1].emitter).min().unwrap_or(edges[at[0].1].emitter),
            at_m: prepared.vertices_m[at[0].0],
            edges: at.iter().map(|end| end.1).collect(),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::emitter;
    use super::*;
    use crate::visibility::fixture;

    /// The sources among polygons that give this light.
    fn sources(polygons: &[(Vec<DVec3>, f64)]) -> Sources {
        let prepared = fixture::prepared(&polygons.iter().map(|polygon| polygon.0.clone()).collect::<Vec<_>>());
        let radiance: Table<FaceId, Rgb> = polygons.iter().map(|polygon| Rgb::splat(polygon.1)).collect();
        Sources::new(&prepared, &radiance, &emitter::emitters(&prepared, &radiance))
    }

    fn turned(polygon: &[DVec3]) -> Vec<DVec3> {
        polygon.iter().rev().copied().collect()
    }

    fn level(corners: &[[f64; 2]], height_m: f64) -> Vec<DVec3> {
        corners.iter().map(|&[x, y]| fixture::f32_point(DVec3::new(x, y, height_m))).collect()
    }

    #[test]
    fn each_side_of_a_sheet_of_light_is_seen_from_its_own_front() {
        // The middle of this quadrilateral is rounded in another way when it is passed the other way.
        let up = level(&[[0.1, 0.1], [0.83, 0.17], [0.71, 0.93], [0.23, 0.67]], 0.1);
        for order in [[1.0, 3.0], [3.0, 1.0]] {
            let both = sources(&[(up.clone(), order[0]), (turned(&up), order[1])]);
            assert_eq!(both.edges.len(), 4);
            for edge in &both.edges {
                for (eye, expected) in [(DVec3::new(2.0, 1.0, 5.0), order[0]), (DVec3::new(-2.0, 1.0, -5.0), order[1])]
                {
                    let step = edge.step(eye, 1e-6, Rgb::ZERO).abs().max_element();
                    assert_eq!(step, expected, "{eye} {edge:?}");
                }
            }
        }
    }

    #[test]
    fn between_faces_that_emit_alike_only_ridges_cast_lines() {
        // Two squares that share the edge from (1, 0, 0) to (1, 1, 0), the second one turned by it, both looking up.
        let squares = |rise: f64, other: f64| {
            let first = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
            let far = [DVec3::new(2.0, 0.0, rise), DVec3::new(2.0, 1.0, rise)];
            let second = vec![DVec3::X, far[0], far[1], DVec3::new(1.0, 1.0, 0.0)];
            [(first.into_iter().map(fixture::f32_point).collect(), 1.0), (second, other)]
        };
        for (rise, other, edges) in [
            (0.0, 1.0, 6),
            (0.0, 0.96, 6),
            (0.0, 0.9, 7),
            (0.5, 1.0, 6),
            (0.5, 0.9, 7),
            (-0.5, 1.0, 7),
            (-0.5, 0.97, 7),
        ] {
            assert_eq!(sources(&squares(rise, other)).edges.len(), edges, "rises by {rise}, {other} as bright");
        }
        // One that looks up beside one that looks down.
        let [first, (second, light)] = squares(0.0, 1.0);
        assert_eq!(sources(&[first, (turned(&second), light)]).edges.len(), 7);
    }

    #[test]
    fn an_edge_inside_a_sheet_of_light_is_none() {
        let [a, b, c] = <[DVec3; 3]>::try_from(level(&[[0.1, 0.2], [0.7, 0.3], [0.3, 0.9]], 0.0)).unwrap();
        let d = fixture::f32_point(b + c - a);
        let (one, other) = (vec![a, b, c], vec![c, b, d]);
        let sheet = [one.clone(), other.clone(), turned(&one), turned(&other)].map(|polygon| (polygon, 1.0));
        assert_eq!(sources(&sheet).edges.len(), 4);
        assert_eq!(sources(&sheet[..2]).edges.len(), 4);
        // Where only one of its sides goes on, the other side ends.
        assert_eq!(sources(&sheet[..3]).edges.len(), 5);
    }
}
