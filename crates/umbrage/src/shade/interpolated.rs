//! A field that is quadratic over the triangles of the leaves of a mesh: indirect light, which is smooth, is gathered at few
//! points and interpolated at the many that direct light needs.
//!
//! Patches that share a leaf edge share its values, so that the field is continuous wherever its values are.

use glam::DVec2;

use super::plain::PlainFace;
use super::refine::Refined;
use crate::id::{FaceId, PatchId, Table};
use crate::mesh::Mesh;
use crate::scene::Rgb;
use crate::visibility::ReceiverPoint;

/// A triangle in the frame of its face, with the values at its corners.
#[derive(Clone, Copy, Debug)]
struct Element {
    corners_m: [DVec2; 3],
    /// At the corners.
    values: [Rgb; 3],
    /// In the middles of the sides, from each corner to the next.
    middles: [Rgb; 3],
}

impl Element {
    /// Barycentric coordinates of a point.
    fn weights(&self, at: DVec2) -> [f64; 3] {
        let [a, b, c] = self.corners_m;
        let doubled = (b - a).perp_dot(c - a);
        [(b, c), (c, a), (a, b)].map(|(p, q)| (p - at).perp_dot(q - at) / doubled)
    }

    /// The value where the barycentric coordinates are these.
    fn value(&self, weights: [f64; 3]) -> Rgb {
        (0..3)
            .map(|i| {
                let (here, next) = (weights[i], weights[(i + 1) % 3]);
                here * (2.0 * here - 1.0) * self.values[i] + 4.0 * here * next * self.middles[i]
            })
            .sum()
    }

    /// The least light at its points, of each colour.
    fn least(&self) -> Rgb {
        let points = self.values.into_iter().chain(self.middles);
        points.reduce(Rgb::min).unwrap_or_default().max(Rgb::ZERO)
    }
}

/// The triangles around the middle of a face.
fn fan(mesh: &Mesh, face: FaceId, plain: &PlainFace) -> Vec<Element> {
    let frame = mesh.frame(face);
    let middle_m = frame.to_2d(mesh.patch(mesh.root(face)).centroid_m);
    let corners: Vec<(DVec2, Rgb)> =
        plain.corners.iter().map(|&(vertex, value)| (frame.to_2d(mesh.vertex_m(vertex)), value)).collect();
    let triangle = |i: usize| {
        let [(here_m, here), (next_m, next)] = [corners[i], corners[(i + 1) % corners.len()]];
        let values = [plain.in_middle, here, next];
        let middles = [0, 1, 2].map(|k| 0.5 * (values[k] + values[(k + 1) % 3]));
        Element { corners_m: [middle_m, here_m, next_m], values, middles }
    };
    (0..corners.len()).map(triangle).collect()
}

/// A field that is quadratic over the triangles of the leaves of a mesh of its own.
#[derive(Clone, Debug)]
pub(super) struct Interpolated<'a> {
    mesh: &'a Mesh,
    elements: Table<PatchId, Vec<Element>>,
}

impl<'a> Interpolated<'a> {
    /// The field that was refined on `mesh` and is linear over the fans of the faces that are `plain`.
    pub(super) fn new(mesh: &'a Mesh, refined: &Refined, plain: &Table<FaceId, Option<PlainFace>>) -> Self {
        let mut elements: Table<PatchId, Vec<Element>> = vec![Vec::new(); mesh.patch_count()].into();
        for leaf in mesh.leaves() {
            let frame = mesh.frame(mesh.patch(leaf).face);
            let of_leaf = refined.elements.get(leaf.index()).into_iter().flatten();
            elements[leaf] = of_leaf
                .map(|element| {
                    let (vertices, values, middles) = element.parabola(&refined.values);
                    let corners_m = vertices.map(|vertex| frame.to_2d(mesh.vertex_m(vertex)));
                    Element { corners_m, values, middles }
                })
                .collect();
        }
        for (face, plain) in plain.iter_enumerated() {
            if let Some(plain) = plain {
                elements[mesh.root(face)] = fan(mesh, face, plain);
            }
        }
        Self { mesh, elements }
    }

    /// The value at a point of a face.
    pub(super) fn at(&self, point: &ReceiverPoint, face: FaceId) -> Rgb {
        let at = self.mesh.frame(face).to_2d(point.position_m);
        let least = |weights: &[f64; 3]| weights.iter().copied().fold(f64::INFINITY, f64::min);
        let nearest = self.elements[self.mesh.leaf_at(face, point.position_m)]
            .iter()
            .map(|element| (element.weights(at), element))
            .reduce(|best, next| if least(&next.0) > least(&best.0) { next } else { best });
        // Beside a dark corner a parabola may fall below the light at all of its points, even below zero: that would be a black dot.
        nearest.map_or(Rgb::ZERO, |(weights, element)| element.value(weights).max(element.least()))
    }
}
