//! T-vertices of a baked mesh: vertices inside an edge of a triangle, where a crack can show.
//!
//! Every vertex is looked up in a tree of the edges' boxes. A vertex on an edge is harmless where nothing can show through:
//! the edge has triangles on both sides that are not merely the two faces of a sheet, or triangles of one plane surround
//! the vertex, so that a surface goes on beneath the edge (a box standing on a floor).
//!
//! Holds: reads nothing but corners, so the check shares no code with the baker.

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;
use obvhs::Boundable;
use obvhs::aabb::Aabb;

use crate::boxes::{around, tree};
use crate::verify::BakedTriangle;

/// A vertex nearer to an edge than this share of the extent lies on it: 16 roundings of an `f32` coordinate.
const ON_EDGE_OF_EXTENT: f64 = 1e-6;
/// A vertex nearer to an end of the edge than this many of these distances is that end.
const AT_END: f64 = 2.0;
/// Edges are looked for within this share of the extent: boxes are `f32`.
const GROWN_OF_EXTENT: f64 = 1e-5;
/// Normals whose cosine is above are of one plane, and below its negative of the two faces of a sheet.
const SAME_PLANE: f64 = 0.9999;
/// Angles around a vertex may miss a full turn by this, in radians.
const FULL_TURN_SLACK_RAD: f64 = 1e-3;

/// A vertex inside an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TVertex {
    /// The vertex, in metres.
    pub vertex_m: DVec3,
    /// Ends of the edge, in metres.
    pub edge_m: [DVec3; 2],
}

/// A point by its bits: baked corners in one place have the same bits.
type Key = [u64; 3];

fn key(p: DVec3) -> Key {
    // Both zeros are one place.
    (p + 0.0).to_array().map(f64::to_bits)
}

fn normal(triangle: &BakedTriangle) -> DVec3 {
    let [p, q, r] = triangle.corners_m;
    (q - p).cross(r - p).normalize_or_zero()
}

struct BoxedEdge([DVec3; 2]);

impl Boundable for BoxedEdge {
    fn aabb(&self) -> Aabb {
        let [p, q] = self.0;
        Aabb::new(p.min(q).as_vec3a(), p.max(q).as_vec3a())
    }
}

/// Edges in the order of their first triangle, each with the normals of all triangles that have it.
fn edges(triangles: &[BakedTriangle], middle_m: DVec3) -> Vec<([DVec3; 2], Vec<DVec3>)> {
    let mut number_of: HashMap<[Key; 2], usize> = HashMap::new();
    let mut edges: Vec<([DVec3; 2], Vec<DVec3>)> = Vec::new();
    for triangle in triangles {
        let corners = triangle.corners_m.map(|p| p - middle_m);
        for k in 0..3 {
            let ends = [corners[k], corners[(k + 1) % 3]];
            let mut place = ends.map(key);
            place.sort_unstable();
            let number = *number_of.entry(place).or_insert(edges.len());
            if number == edges.len() {
                edges.push((ends, Vec::new()));
            }
            edges[number].1.push(normal(triangle));
        }
    }
    edges
}

/// Whether triangles of one plane that look the same way surround a vertex, given their normals and angles there.
fn is_surrounded(fan: &[(DVec3, f64)]) -> bool {
    let turn =
        |normal: DVec3| fan.iter().filter(|(n, _)| n.dot(normal) > SAME_PLANE).map(|(_, angle)| angle).sum::<f64>();
    fan.iter().any(|&(normal, _)| turn(normal) > TAU - FULL_TURN_SLACK_RAD)
}

/// Whether an edge has triangles on both sides, by their normals: the two faces of a sheet leave it open.
fn is_closed(normals: &[DVec3]) -> bool {
    normals.iter().enumerate().any(|(i, n)| normals[i + 1..].iter().any(|other| n.dot(*other) > -SAME_PLANE))
}

/// Finds the vertices that lie inside an edge, where a crack can show.
pub fn t_vertices(triangles: &[BakedTriangle]) -> Vec<TVertex> {
    let corners = || triangles.iter().flat_map(|t| t.corners_m);
    let (low, high) = (corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max));
    // Boxes are `f32`: around the middle they are exact enough, however far the scene is from the origin.
    let (extent_m, middle_m) = ((high - low).max_element(), 0.5 * (low + high));
    let on_edge_m = ON_EDGE_OF_EXTENT * extent_m;
    let edges = edges(triangles, middle_m);
    let boxes: Vec<BoxedEdge> = edges.iter().map(|(ends, _)| BoxedEdge(*ends)).collect();
    if boxes.is_empty() {
        return Vec::new();
    }
    let tree = tree(&boxes);
    let fans = fans(triangles, middle_m);
    let mut found = Vec::new();
    for (vertex, fan) in &fans {
        let mut on = Vec::new();
        tree.aabb_traverse(around(*vertex, GROWN_OF_EXTENT * extent_m), |tree, index| {
            let node = &tree.nodes[index as usize];
            let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
            let numbers = tree.primitive_indices[range].iter().map(|&number| number as usize);
            on.extend(numbers.filter(|&number| is_inside(*vertex, edges[number].0, on_edge_m)));
            true
        });
        on.sort_unstable();
        let open = on.into_iter().filter(|&number| !is_closed(&edges[number].1));
        let cracks: Vec<usize> = open.collect();
        if !cracks.is_empty() && !is_surrounded(fan) {
            let place = |ends: [DVec3; 2]| ends.map(|p| p + middle_m);
            let t_vertex = |number: usize| TVertex { vertex_m: vertex + middle_m, edge_m: place(edges[number].0) };
            found.extend(cracks.into_iter().map(t_vertex));
        }
    }
    found
}

/// Vertices in the order of their first triangle, each with normal and angle of the triangles that have it.
fn fans(triangles: &[BakedTriangle], middle_m: DVec3) -> Vec<(DVec3, Vec<(DVec3, f64)>)> {
    let mut number_of: HashMap<Key, usize> = HashMap::new();
    let mut fans: Vec<(DVec3, Vec<(DVec3, f64)>)> = Vec::new();
    for triangle in triangles {
        let corners = triangle.corners_m.map(|p| p - middle_m);
        for k in 0..3 {
            let number = *number_of.entry(key(corners[k])).or_insert(fans.len());
            if number == fans.len() {
                fans.push((corners[k], Vec::new()));
            }
            let [next, previous] = [1, 2].map(|step| corners[(k + step) % 3] - corners[k]);
            fans[number].1.push((normal(triangle), next.angle_between(previous)));
        }
    }
    fans
}

fn is_inside(vertex: DVec3, [p, q]: [DVec3; 2], on_edge_m: f64) -> bool {
    let Some(direction) = (q - p).try_normalize() else { return false };
    let (along_m, away_m) = ((vertex - p).dot(direction), (vertex - p).cross(direction).length());
    away_m < on_edge_m && along_m > AT_END * on_edge_m && p.distance(q) - along_m > AT_END * on_edge_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::scene::Rgb;

    fn triangle(corners: [[f64; 3]; 3]) -> BakedTriangle {
        BakedTriangle { corners_m: corners.map(DVec3::from), irradiance: [Rgb::ONE; 3] }
    }

    #[test]
    fn a_crack_is_found_wherever_the_scene_is() {
        for origin in [0.0, 1e6] {
            let at = |x: f64, y: f64| [origin + x, y, 0.0];
            let big = triangle([at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)]);
            let below = triangle([at(0.5, 0.0), at(0.0, 0.0), at(0.5, -1.0)]);
            let found = t_vertices(&[big, below]);
            assert_eq!(found.len(), 1, "{found:?}");
            assert_eq!(found[0].vertex_m, DVec3::from(at(0.5, 0.0)));
        }
    }

    #[test]
    fn a_box_on_a_floor_that_goes_on_beneath_it_leaves_no_crack() {
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let mut floor: Vec<_> = (0..4).map(|i| triangle([square[i], square[(i + 1) % 4], [0.5, 0.5, 0.0]])).collect();
        // A side upright over the diagonal has a corner of the floor inside its lower edge.
        floor.push(triangle([square[0], square[2], [0.5, 0.5, 1.0]]));
        assert_eq!(t_vertices(&floor), []);
        // Without a quarter of the floor it ends in the open.
        assert_eq!(t_vertices(&floor[1..]).len(), 1);
    }

    #[test]
    fn both_faces_of_a_sheet_may_have_a_crack() {
        let (a, b, c, d) = ([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.0, 0.0]);
        let beside = [triangle([d, a, [0.0, -1.0, 0.0]]), triangle([a, d, [0.0, -1.0, 0.0]])];
        let sheet = [triangle([a, b, c]), triangle([a, c, b])];
        assert_eq!(t_vertices(&[sheet, beside].concat()).len(), 1);
    }
}
