//! Rims: narrow strips that carry what a face shows on into area that is hidden (see [`crate::prepare::Rim`]).
//!
//! ```text
//!    p0 ----- p1 -- p2 -------- p3     the edge, with the vertices that the visible side has on it
//!      \      |               /
//!       q0 -- q1 ----------- q3        the far side of the strip
//! ```
//!
//! A vertex of the far side shows the light of the vertex that it stands for. There is one wherever the light along the edge turns,
//! on either side of a double-sided face: the strips of both have the same vertices.
//!
//! Holds after: strips meet what is visible in all of its vertices along the edge, and have the same values there; no vertex of a
//! strip lies inside a side of another.

use std::collections::{BTreeMap, BTreeSet};

use glam::DVec3;

use super::flat::LitTriangle;
use crate::geometry::polygon;
use crate::id::{FaceId, VertexId};
use crate::mesh::Mesh;
use crate::prepare::{Prepared, Rim};
use crate::scene::Rgb;

/// Light along an edge is straight where it departs from that by less than this share of itself: a step of a screen's colours.
const STRAIGHT_OF_LIGHT: f64 = 0.01;

/// Strips, and the vertices of their far sides, numbered behind those of the mesh.
pub(super) struct Strips {
    pub(super) triangles: Vec<LitTriangle>,
    pub(super) vertices_m: Vec<DVec3>,
}

/// A part of an edge between two vertices of a triangle that lies along it.
#[derive(Clone, Copy)]
struct Segment {
    /// How far along the edge it begins and ends, in metres.
    at_m: [f64; 2],
    vertices: [VertexId; 2],
    values: [usize; 2],
}

/// The strips along all rims.
pub(super) fn strips(prepared: &Prepared, mesh: &Mesh, triangles: &[LitTriangle], values: &[Rgb]) -> Strips {
    let mut of_face: BTreeMap<FaceId, Vec<usize>> = BTreeMap::new();
    prepared.rims.iter().enumerate().for_each(|(number, rim)| of_face.entry(rim.face).or_default().push(number));
    let mut along: Vec<Vec<Segment>> = vec![Vec::new(); prepared.rims.len()];
    for triangle in triangles {
        for &number in of_face.get(&triangle.face).map_or(&[][..], Vec::as_slice) {
            along[number].extend(side_along(prepared, mesh, &prepared.rims[number], triangle));
        }
    }
    along.iter_mut().for_each(|segments| segments.sort_by(|one, other| one.at_m[0].total_cmp(&other.at_m[0])));
    let mut strips = Strips { triangles: Vec::new(), vertices_m: Vec::new() };
    let numbers: Vec<usize> = (0..prepared.rims.len()).collect();
    for beside_edge in numbers.chunk_by(|&one, &other| prepared.rims[one].edge == prepared.rims[other].edge) {
        let mut left = beside_edge.to_vec();
        while let Some(&first) = left.first() {
            let is_twin = |number: &usize| are_twins(prepared, [first, *number].map(|number| &prepared.rims[number]));
            let (twins, others) = left.into_iter().partition(is_twin);
            let twins: Vec<(&Rim, &[Segment])> =
                Vec::into_iter(twins).map(|number| (&prepared.rims[number], &along[number][..])).collect();
            add_strips(prepared, mesh, &twins, values, &mut strips);
            left = others;
        }
    }
    strips
}

/// Whether two rims along one edge are the two sides of one strip.
fn are_twins(prepared: &Prepared, rims: [&Rim; 2]) -> bool {
    let [one, other] = rims.map(|rim| (prepared.faces[rim.face].plane, rim.width_m));
    let [outward, of_other] = rims.map(|rim| outward(prepared, rim));
    one == other && outward.dot(of_other) > 0.0
}

/// The direction in which a rim goes on beyond its edge.
fn outward(prepared: &Prepared, rim: &Rim) -> DVec3 {
    axis(prepared, rim).1.cross(prepared.normal(rim.face))
}

/// The side of a triangle that lies along the edge of a rim.
fn side_along(prepared: &Prepared, mesh: &Mesh, rim: &Rim, triangle: &LitTriangle) -> Option<Segment> {
    let lies_on = |v: VertexId| prepared.edges[rim.edge].ends.contains(&v) || mesh.split_root(v) == Some(rim.edge);
    let i = (0..3).find(|&i| lies_on(triangle.vertices[i]) && lies_on(triangle.vertices[(i + 1) % 3]))?;
    let corners = [i, (i + 1) % 3];
    let (start_m, along) = axis(prepared, rim);
    let vertices = corners.map(|k| triangle.vertices[k]);
    let at_m = vertices.map(|v| (mesh.vertex_m(v) - start_m).dot(along));
    Some(Segment { at_m, vertices, values: corners.map(|k| triangle.values[k]) }).filter(|s| s.at_m[0] < s.at_m[1])
}

/// Where the boundary of a rim's face begins to pass the edge, and the direction that it passes it in.
fn axis(prepared: &Prepared, rim: &Rim) -> (DVec3, DVec3) {
    let [from, to] = prepared.edges[rim.edge].ends.map(|v| prepared.vertices_m[v]);
    let inside = polygon::centroid(&prepared.polygon_m(rim.face)) - from;
    let is_forward = prepared.normal(rim.face).cross(to - from).dot(inside) > 0.0;
    let (from, to) = if is_forward { (from, to) } else { (to, from) };
    (from, (to - from).normalize_or_zero())
}

/// Adds the strips of rims that are twins: all have the same vertices on their far sides, so that those of one lie on no side of another.
fn add_strips(prepared: &Prepared, mesh: &Mesh, twins: &[(&Rim, &[Segment])], values: &[Rgb], strips: &mut Strips) {
    let ends = twins.iter().flat_map(|(_, segments)| turns(segments, values)).collect();
    let mut far = BTreeMap::new();
    for (rim, segments) in twins {
        add_strip(prepared, mesh, rim, segments, &ends, &mut far, strips);
    }
}

/// The vertices in which light along an edge turns or jumps, and the first and last.
fn turns(segments: &[Segment], values: &[Rgb]) -> Vec<VertexId> {
    let mut turns = Vec::new();
    let mut left = segments;
    while let [first, ..] = left {
        let straight = (1..=left.len()).take_while(|&count| is_straight(&left[..count], values)).last();
        let (run, others) = left.split_at(straight.unwrap_or(1));
        turns.extend([first.vertices[0], run[run.len() - 1].vertices[1]]);
        left = others;
    }
    turns
}

/// Adds a strip with a vertex on its far side for each of the vertices `ends` of the edge; those in `far` are there already.
fn add_strip(
    prepared: &Prepared,
    mesh: &Mesh,
    rim: &Rim,
    segments: &[Segment],
    ends: &BTreeSet<VertexId>,
    far: &mut BTreeMap<VertexId, VertexId>,
    strips: &mut Strips,
) {
    let (start_m, along) = axis(prepared, rim);
    let outward = outward(prepared, rim);
    let [from, to] = prepared.edges[rim.edge].ends.map(|v| prepared.vertices_m[v]);
    let length_m = from.distance(to);
    let taper_m = rim.taper_m();
    let Strips { triangles, vertices_m } = strips;
    let mut far_of = |vertex: VertexId, at_m: f64| {
        *far.entry(vertex).or_insert_with(|| {
            let squeezed_m = taper_m + at_m * (1.0 - 2.0 * taper_m / length_m);
            vertices_m.push(start_m + squeezed_m * along + rim.width_m * outward);
            VertexId::from(mesh.vertex_count() + vertices_m.len() - 1)
        })
    };
    for run in segments.chunk_by(|before, _| !ends.contains(&before.vertices[1])) {
        let (begin, end) = (&run[0], &run[run.len() - 1]);
        let near = far_of(begin.vertices[0], begin.at_m[0]);
        let next = far_of(end.vertices[1], end.at_m[1]);
        let mut push = |vertices: [VertexId; 3], values: [usize; 3]| {
            triangles.push(LitTriangle { face: rim.face, vertices, values });
        };
        for segment in run {
            let ([a, b], [at_a, at_b]) = (segment.vertices, segment.values);
            push([near, b, a], [begin.values[0], at_b, at_a]);
        }
        push([near, next, end.vertices[1]], [begin.values[0], end.values[1], end.values[1]]);
    }
}

/// Whether segments follow on each other, and light is straight along them.
fn is_straight(run: &[Segment], values: &[Rgb]) -> bool {
    let [Some(first), Some(last)] = [run.first(), run.last()] else { return true };
    let follow =
        |pair: &[Segment]| pair[0].vertices[1] == pair[1].vertices[0] && pair[0].values[1] == pair[1].values[0];
    let ([from_m, _], [_, to_m]) = (first.at_m, last.at_m);
    let ends = [values[first.values[0]], values[last.values[1]]];
    let departs = |segment: &Segment| {
        let value = values[segment.values[1]];
        let straight = ends[0].lerp(ends[1], (segment.at_m[1] - from_m) / (to_m - from_m));
        (value - straight).abs().max_element() > STRAIGHT_OF_LIGHT * value.max_element()
    };
    run.windows(2).all(follow) && !run.iter().any(departs)
}
