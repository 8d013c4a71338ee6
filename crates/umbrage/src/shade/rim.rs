//! Rims: narrow strips that carry what a face shows on into area that is hidden (see [`crate::prepare::Rim`]).
//!
//! ```text
//!    p0 ----- p1 -- p2 -------- p3     the edge, with the vertices that the visible side has on it
//!      \      |               /
//!       q0 -- q1 ----------- q3        the far side of the strip
//! ```
//!
//! A vertex of the far side shows the light of the vertex that it stands for. There is one wherever the light along the edge turns.
//!
//! Holds after: strips meet what is visible in all of its vertices along the edge, and have the same values there.

use std::collections::BTreeMap;

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
    let mut strips = Strips { triangles: Vec::new(), vertices_m: Vec::new() };
    let mut of_face: BTreeMap<FaceId, Vec<usize>> = BTreeMap::new();
    prepared.rims.iter().enumerate().for_each(|(number, rim)| of_face.entry(rim.face).or_default().push(number));
    let mut along: Vec<Vec<Segment>> = vec![Vec::new(); prepared.rims.len()];
    for triangle in triangles {
        for &number in of_face.get(&triangle.face).map_or(&[][..], Vec::as_slice) {
            along[number].extend(side_along(prepared, mesh, &prepared.rims[number], triangle));
        }
    }
    for (rim, mut segments) in prepared.rims.iter().zip(along) {
        segments.sort_by(|one, other| one.at_m[0].total_cmp(&other.at_m[0]));
        add_strip(prepared, mesh, rim, &segments, values, &mut strips);
    }
    strips
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

fn add_strip(prepared: &Prepared, mesh: &Mesh, rim: &Rim, segments: &[Segment], values: &[Rgb], strips: &mut Strips) {
    let (start_m, along) = axis(prepared, rim);
    let outward = along.cross(prepared.normal(rim.face));
    let [from, to] = prepared.edges[rim.edge].ends.map(|v| prepared.vertices_m[v]);
    let length_m = from.distance(to);
    let taper_m = rim.taper_m();
    let mut far = |at_m: f64| {
        let squeezed_m = taper_m + at_m * (1.0 - 2.0 * taper_m / length_m);
        strips.vertices_m.push(start_m + squeezed_m * along + rim.width_m * outward);
        VertexId::from(mesh.vertex_count() + strips.vertices_m.len() - 1)
    };
    let mut first = 0;
    // The far vertex of the run before, and what it shows.
    let mut before: Option<(VertexId, VertexId, usize)> = None;
    while first < segments.len() {
        let last = (first..segments.len())
            .take_while(|&last| is_straight(&segments[first..=last], values))
            .last()
            .unwrap_or(first);
        let (begin, end) = (&segments[first], &segments[last]);
        let near = match before {
            Some((of, near, value)) if of == begin.vertices[0] && value == begin.values[0] => near,
            _ => far(begin.at_m[0]),
        };
        let next = far(end.at_m[1]);
        let mut push = |vertices: [VertexId; 3], values: [usize; 3]| {
            strips.triangles.push(LitTriangle { face: rim.face, vertices, values });
        };
        for segment in &segments[first..=last] {
            let ([a, b], [at_a, at_b]) = (segment.vertices, segment.values);
            push([near, b, a], [begin.values[0], at_b, at_a]);
        }
        push([near, next, end.vertices[1]], [begin.values[0], end.values[1], end.values[1]]);
        before = Some((end.vertices[1], next, end.values[1]));
        first = last + 1;
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
