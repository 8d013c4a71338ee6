//! Elements: the triangles that are shown of a leaf, and what interpolation errs on them.
//!
//! The field over a triangle is taken to be quadratic: its values at the corners, and how far it departs from a straight
//! line in the middles of the sides, say all. So the mean square of an error is a closed form.
//!
//! The value that a vertex shows need not be the field's own there. Where the field bulges, straight lines between true
//! values all run below it. A vertex that is shifted by the mean bulge of the triangles around it leaves less than half of
//! the error, and no bias; true darkness stays dark.

use glam::DVec3;

use super::field::{Field, MeshPoint, Places, Request, Values};
use crate::id::{PatchId, VertexId};
use crate::mesh::{BoundaryPoint, Mesh};
use crate::scene::Rgb;
use crate::transport::BrightPlace;

/// The triangles of a leaf.
pub(super) struct Outlined {
    pub(super) patch: PatchId,
    boundary: Vec<BoundaryPoint>,
    triangles: Vec<[usize; 3]>,
}

/// A triangle of a leaf.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub(super) area_m2: f64,
    vertices: [VertexId; 3],
    /// Numbers of the values at its corners.
    corners: [u32; 3],
    /// How far the field departs from the mean of its ends in the middle of each side, from each corner to the next.
    bulges: [Rgb; 3],
    /// How far the field at [`PROBE`] departs from a plane through its corners.
    inside: Rgb,
    /// Mean square of how far the field departs from the parabola through corners and middles at [`MORE_PROBES`], where it was
    /// looked at there; or of how much more light than that falls on its bright places.
    between: Rgb,
    /// Whether it ends in a corner of a contact, where the field has no one value.
    at_contact_corner: bool,
}

/// Where an element is looked at inside: barycentric coordinates. On a face that is lit evenly all around, the points of the
/// parabola alone, and the centroid, may be right by symmetry; this point is on no axis of it.
const PROBE: [f64; 3] = [0.45, 0.33, 0.22];
/// Where else a large element is looked at.
const MORE_PROBES: [[f64; 3]; 2] = [[0.1, 0.7, 0.2], [0.2, 0.1, 0.7]];

impl Outlined {
    /// The triangles that `point_split` would make of a leaf.
    pub(super) fn of(mesh: &Mesh, patch: PatchId) -> Self {
        let boundary = mesh.boundary(patch);
        let triangles = mesh.triangles_of(patch, &boundary);
        Self { patch, boundary, triangles }
    }

    /// Number of boundary points: with more of them the triangles are others.
    pub(super) fn point_count(&self) -> usize {
        self.boundary.len()
    }

    /// The corners of each triangle, and the points of its corners and of the middles of its sides.
    pub(super) fn nodes<'a>(
        &'a self,
        mesh: &'a Mesh,
        places: &'a Places<'_>,
    ) -> impl Iterator<Item = ([VertexId; 3], [MeshPoint; 6])> + 'a {
        self.triangles.iter().map(|&triangle| {
            let corners = triangle.map(|k| self.boundary[k].vertex);
            let [a, b, c] = corners.map(|corner| places.vertex_key(mesh, self.patch, corner));
            let [d, e, f] = [0, 1, 2].map(|i| self.middle_key(mesh, places, triangle, i));
            (corners, [a, b, c, d, e, f])
        })
    }

    /// The points whose values the elements need.
    pub(super) fn requests(&self, mesh: &Mesh, places: &Places<'_>) -> Vec<Request> {
        let vertices = self.boundary.iter().map(|point| places.vertex(mesh, self.patch, point.vertex));
        let middles =
            self.triangles.iter().flat_map(|&triangle| (0..3).map(move |i| self.middle(mesh, places, triangle, i)));
        vertices.chain(middles).collect()
    }

    /// The middle of the side of a triangle after its corner `i`.
    fn middle(&self, mesh: &Mesh, places: &Places<'_>, triangle: [usize; 3], i: usize) -> Request {
        places.middle(mesh, self.patch, [triangle[i], triangle[(i + 1) % 3]].map(|k| &self.boundary[k]))
    }

    /// Its name.
    fn middle_key(&self, mesh: &Mesh, places: &Places<'_>, triangle: [usize; 3], i: usize) -> MeshPoint {
        places.middle_key(mesh, self.patch, [triangle[i], triangle[(i + 1) % 3]].map(|k| &self.boundary[k]))
    }

    /// The elements, once the values that they need are known: those that were there `before`, and others.
    pub(super) fn elements(
        &self,
        mesh: &Mesh,
        places: &Places<'_>,
        values: &Values,
        field: &impl Field,
        closer: &Closer<'_>,
        before: &[Element],
    ) -> Vec<Element> {
        let element = |&triangle: &[usize; 3]| {
            let vertices = triangle.map(|k| self.boundary[k].vertex);
            if let Some(known) = before.iter().find(|element| element.vertices == vertices) {
                return Some(*known);
            }
            let [a, b, c] = triangle.map(|k| mesh.vertex_m(self.boundary[k].vertex));
            let number = |k: usize| values.number(&places.vertex_key(mesh, self.patch, self.boundary[k].vertex));
            let corners = [number(triangle[0])?, number(triangle[1])?, number(triangle[2])?];
            let at = corners.map(|corner| values.as_slice()[corner as usize]);
            let bulge = |i: usize| {
                let middle = values.get(&self.middle_key(mesh, places, triangle, i))?;
                Some(middle - 0.5 * (at[i] + at[(i + 1) % 3]))
            };
            let bulges = [bulge(0)?, bulge(1)?, bulge(2)?];
            let departure = |[p, q, r]: [f64; 3]| {
                let point = places.inside(mesh, self.patch, p * a + q * b + r * c);
                field.at(mesh, &point, self.patch) - (p * at[0] + q * at[1] + r * at[2])
            };
            let beyond = |[p, q, r]: [f64; 3]| {
                let error = departure([p, q, r]) - parabola([p, q, r], &bulges);
                error * error
            };
            let at_contact_corner = triangle.iter().any(|&k| places.is_contact_corner(mesh, self.boundary[k].vertex));
            let area_m2 = 0.5 * (b - a).cross(c - a).length();
            let between = match area_m2 > closer.large_m2 {
                true => MORE_PROBES.map(beyond).into_iter().sum::<Rgb>() / 2.0,
                false => Rgb::ZERO,
            };
            let shown = |[p, q, r]: [f64; 3]| p * at[0] + q * at[1] + r * at[2] + parabola([p, q, r], &bulges);
            let between = between.max(closer.missed_squared([a, b, c], shown));
            let inside = departure(PROBE);
            Some(Element { area_m2, vertices, corners, bulges, inside, between, at_contact_corner })
        };
        self.triangles.iter().filter_map(element).collect()
    }
}

/// Where elements are looked at more closely.
pub(super) struct Closer<'a> {
    /// Those larger than this are looked at in more points, in square metres.
    pub(super) large_m2: f64,
    /// Places that sources are known to light.
    pub(super) bright: Vec<&'a BrightPlace>,
}

impl Closer<'_> {
    /// Mean square over a triangle of how much less light is shown on bright places than sources bring there.
    fn missed_squared(&self, corners_m: [DVec3; 3], shown: impl Fn([f64; 3]) -> Rgb) -> Rgb {
        let [a, b, c] = corners_m;
        let doubled = (b - a).cross(c - a);
        let (mut sum, mut covered_m2) = (Rgb::ZERO, 0.0);
        for place in &self.bright {
            let share = |p: DVec3, q: DVec3| (p - place.point_m).cross(q - place.point_m).dot(doubled);
            let at = [share(b, c), share(c, a), share(a, b)].map(|share| share / doubled.length_squared());
            if at.iter().all(|&share| share >= 0.0) {
                let missed = (place.irradiance - shown(at)).max(Rgb::ZERO);
                sum += place.area_m2 * missed * missed;
                covered_m2 += place.area_m2;
            }
        }
        // What stands for more than the triangle reaches beyond it.
        if covered_m2 > 0.0 { sum / covered_m2.max(0.5 * doubled.length()) } else { Rgb::ZERO }
    }
}

/// How far the parabola with these bulges departs from a plane through its corners, at barycentric coordinates.
fn parabola([p, q, r]: [f64; 3], bulges: &[Rgb; 3]) -> Rgb {
    4.0 * (p * q * bulges[0] + q * r * bulges[1] + r * p * bulges[2])
}

impl Element {
    /// Numbers of the values at its corners.
    pub(super) fn corners(&self) -> [u32; 3] {
        self.corners
    }

    /// Mean of how far the field departs from straight lines in the middles of its sides.
    pub(super) fn bulge(&self) -> Rgb {
        self.bulges.into_iter().sum::<Rgb>() / 3.0
    }

    /// The vertices at its corners, and the values there and in the middle of each side, from each corner to the next.
    pub(super) fn parabola(&self, values: &Values) -> ([VertexId; 3], [Rgb; 3], [Rgb; 3]) {
        let at = self.corners.map(|corner| values.as_slice()[corner as usize]);
        let middle = |i: usize| self.bulges[i] + 0.5 * (at[i] + at[(i + 1) % 3]);
        (self.vertices, at, [middle(0), middle(1), middle(2)])
    }

    /// Mean square of what linear interpolation errs between corners that show `shifts` more than the field, per colour.
    pub(super) fn linear_error_squared(&self, shifts: &[Rgb]) -> Rgb {
        let ([d, e, f], s) = (self.bulges, self.corners.map(|corner| shifts[corner as usize]));
        // Means over a triangle of products of barycentric coordinates, of degree 4, 3 and 2.
        let of_bulges = 8.0 / 45.0 * (d * d + e * e + f * f + d * e + e * f + f * d);
        let at_ends = d * (s[0] + s[1]) + e * (s[1] + s[2]) + f * (s[2] + s[0]);
        let opposite = d * s[2] + e * s[0] + f * s[1];
        let of_shifts = (s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + s[0] * s[1] + s[1] * s[2] + s[2] * s[0]) / 6.0;
        let quadratic = of_bulges - 2.0 * (2.0 / 15.0 * at_ends + 1.0 / 15.0 * opposite) + of_shifts;
        // A bump of height h inside alone has a mean square of about h^2 / 6.
        let inside = self.inside - (PROBE[0] * s[0] + PROBE[1] * s[1] + PROBE[2] * s[2]);
        quadratic.max(inside * inside / 6.0).max(self.between)
    }

    /// Whether the mean square of what interpolation errs, per colour, is of more than a share of the light here and `least`, in
    /// W/m2; never at a corner of a contact, where it always is.
    pub(super) fn errs_locally(&self, squared: Rgb, values: &Values, of_own: f64, least: f64) -> bool {
        let own: Rgb = self.corners.iter().map(|&corner| values.as_slice()[corner as usize]).sum();
        let most = of_own * own.element_sum() / 9.0 + least;
        !self.at_contact_corner && squared.element_sum() / 3.0 > most * most
    }

    /// Whether it is exactly dark inside, and at a corner, and more than `least` is shown there, in W/m2.
    pub(super) fn leaks(&self, values: &Values, least: f64) -> bool {
        let at = self.corners.map(|corner| values.as_slice()[corner as usize]);
        let shown: Rgb = PROBE.into_iter().zip(at).map(|(weight, light)| weight * light).sum();
        at.contains(&Rgb::ZERO) && shown.max_element() > least && shown + self.inside == Rgb::ZERO
    }

    /// Square of what quadratic interpolation errs where it was looked at, beyond what may be by chance, per colour.
    pub(super) fn quadratic_error_squared(&self) -> Rgb {
        let inside = self.inside - parabola(PROBE, &self.bulges);
        (inside * inside).max(self.between)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean square of the error by many points.
    fn sampled(element: &Element, shifts: &[Rgb]) -> f64 {
        let n = 400;
        let (mut sum, mut count) = (0.0, 0.0);
        for (i, j) in (0..n).flat_map(|i| (0..n - i).map(move |j| (i, j))) {
            let (p, q) = ((f64::from(i) + 1.0 / 3.0) / f64::from(n), (f64::from(j) + 1.0 / 3.0) / f64::from(n));
            let weights = [p, q, 1.0 - p - q];
            let error: f64 = (0..3)
                .map(|k| {
                    4.0 * weights[k] * weights[(k + 1) % 3] * element.bulges[k].x
                        - weights[k] * shifts[element.corners[k] as usize].x
                })
                .sum();
            sum += error * error;
            count += 1.0;
        }
        sum / count
    }

    #[test]
    fn the_closed_form_is_the_mean_square_over_the_triangle() {
        let bulges = [0.3, -0.1, 0.7].map(Rgb::splat);
        let element = Element {
            area_m2: 1.0,
            vertices: [0, 1, 2].map(VertexId::from),
            corners: [0, 1, 2],
            bulges,
            inside: Rgb::ZERO,
            between: Rgb::ZERO,
            at_contact_corner: false,
        };
        let shifts = [0.2, -0.4, 0.1].map(Rgb::splat);
        let squared = element.linear_error_squared(&shifts).x;
        assert!((squared / sampled(&element, &shifts) - 1.0).abs() < 0.02, "{squared}");
    }
}
