//! The image around a vertex: what an eye sees of the faces that meet there, as steps of brightness between rays.
//!
//! Seen from a point, the faces at a vertex are sectors around its image, bounded by the images of their edges. Where a
//! sector begins or ends, what is seen jumps: from lit to unlit for a source, from open to blocked for an occluder.
//! These steps are all that an edge-vertex or vertex-edge event needs to know of a vertex, however many faces meet
//! there, convex or not, closed or open, touching one another or not.
//!
//! ```text
//!          edge                 A line at the distance w from the vertex, with the normal m, cuts a ray with the slope
//!     ____/ sector              q / p (along / across the line) at w q / p. The length of the sector on the line is
//!    |   /                      therefore linear in w on both sides of the vertex, and its slope jumps by the sum of
//!  --+--/------- line           step * q / p over all rays.
//!    | v\
//! ```

use glam::DVec3;
use smallvec::SmallVec;

use super::Emitter;
use crate::id::{EmitterId, FaceId, Table, VertexId};
use crate::prepare::Prepared;
use crate::scene::Rgb;

/// A face whose plane passes nearer than this sine to the eye is seen edge-on, and covers nothing.
const EDGE_ON_SINE: f64 = 1e-8;
/// Steps that cancel to less than this share are none: a vertex inside a straight outline.
const CANCELLED: f64 = 1e-6;

/// A face at one of its boundary vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct FaceCorner {
    /// To the next boundary vertex, in metres.
    pub(super) next: DVec3,
    /// To the boundary vertex before, in metres.
    pub(super) previous: DVec3,
    /// Unit normal of the front.
    pub(super) normal: DVec3,
    /// What the front emits, in W/(m2 sr).
    pub(super) radiance: Rgb,
}

/// The corners of all faces, by vertex.
#[derive(Clone, Debug)]
pub(super) struct Corners {
    first: Table<VertexId, u32>,
    corners: Vec<FaceCorner>,
}

impl Corners {
    /// The corners of all faces, which have these radiances, and of the emitters that are parts of faces.
    pub(super) fn new(
        prepared: &Prepared,
        radiance: &Table<FaceId, Rgb>,
        emitters: &Table<EmitterId, Emitter>,
    ) -> Self {
        let mut at: Vec<(VertexId, FaceCorner)> = Vec::new();
        let mut add = |boundary: &[VertexId], normal: DVec3, radiance: Rgb| {
            let n = boundary.len();
            at.extend((0..n).map(|i| {
                let to = |j: usize| prepared.vertices_m[boundary[j % n]] - prepared.vertices_m[boundary[i]];
                (boundary[i], FaceCorner { next: to(i + 1), previous: to(i + n - 1), normal, radiance })
            }));
        };
        for id in prepared.faces.keys() {
            let boundary: SmallVec<[VertexId; 8]> = prepared.boundary(id).collect();
            add(&boundary, prepared.normal(id), radiance[id]);
        }
        for part in emitters.iter().filter(|emitter| emitter.part_m.is_some()) {
            add(&part.corners, part.plane.normal, part.radiance);
        }
        at.sort_by_key(|corner| corner.0);
        let mut first: Table<VertexId, u32> = Table::with_capacity(prepared.vertices_m.len() + 1);
        let mut next = 0;
        for vertex in prepared.vertices_m.keys() {
            first.push(next as u32);
            next += at[next..].iter().take_while(|corner| corner.0 == vertex).count();
        }
        first.push(next as u32);
        Self { first, corners: at.into_iter().map(|corner| corner.1).collect() }
    }

    /// The faces at a vertex.
    pub(super) fn at(&self, vertex: VertexId) -> &[FaceCorner] {
        let next = VertexId::from(vertex.index() + 1);
        &self.corners[self.first[vertex] as usize..self.first[next] as usize]
    }
}

/// A ray from a vertex, the image of an edge, across which what is seen jumps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Along the edge, in metres.
    pub(super) edge: DVec3,
    /// By how much it jumps, counter-clockwise as the eye sees it.
    pub(super) step: Rgb,
}

/// The steps around a vertex.
pub(super) type Steps = SmallVec<[Step; 4]>;

/// What is emitted by the face that is seen, or by the background where there is none.
pub(super) fn emitted(background: Rgb) -> impl Fn(Option<(&FaceCorner, bool)>) -> Rgb {
    move |seen| match seen {
        Some((corner, true)) => corner.radiance,
        Some((_, false)) => Rgb::ZERO,
        None => background,
    }
}

/// One where nothing is in the way.
pub(super) fn open(seen: Option<(&FaceCorner, bool)>) -> Rgb {
    if seen.is_some() { Rgb::ZERO } else { Rgb::ONE }
}

/// A sector of the image.
#[derive(Clone, Copy, Debug)]
struct Sector<'a> {
    corner: &'a FaceCorner,
    front: bool,
    /// The rays where it begins and ends, counter-clockwise.
    rays: [DVec3; 2],
    from: f64,
    span: f64,
}

/// The steps of the image around a vertex with these faces, seen along the unit vector `to_eye`. `value` tells what is
/// seen of the nearest face, and whether that is its front.
pub(super) fn steps(
    corners: &[FaceCorner],
    to_eye: DVec3,
    value: impl Fn(Option<(&FaceCorner, bool)>) -> Rgb,
) -> Steps {
    use std::f64::consts::TAU;
    let (right, up) = to_eye.any_orthonormal_pair();
    let angle = |edge: DVec3| edge.dot(up).atan2(edge.dot(right));
    let sectors: SmallVec<[Sector<'_>; 8]> = corners
        .iter()
        .filter(|corner| corner.normal.dot(to_eye).abs() > EDGE_ON_SINE)
        .map(|corner| {
            let front = corner.normal.dot(to_eye) > 0.0;
            let rays = if front { [corner.next, corner.previous] } else { [corner.previous, corner.next] };
            let from = angle(rays[0]);
            Sector { corner, front, rays, from, span: (angle(rays[1]) - from).rem_euclid(TAU) }
        })
        .collect();
    if let [only] = sectors.as_slice() {
        let inside = value(Some((only.corner, only.front))) - value(None);
        let steps = [Step { edge: only.rays[0], step: inside }, Step { edge: only.rays[1], step: -inside }];
        return steps.into_iter().filter(|step| step.step != Rgb::ZERO).collect();
    }
    let mut rays: SmallVec<[(f64, DVec3); 16]> = SmallVec::new();
    for sector in &sectors {
        rays.push((sector.from, sector.rays[0]));
        rays.push((angle(sector.rays[1]), sector.rays[1]));
    }
    rays.sort_by(|p, q| p.0.total_cmp(&q.0));
    rays.dedup_by(|next, kept| next.0 == kept.0);
    // What is seen in the middle between a ray and the next: the face that leans farthest towards the eye.
    let seen = |i: usize| {
        let (from, to) = (rays[i].0, if i + 1 < rays.len() { rays[i + 1].0 } else { rays[0].0 + TAU });
        let middle = 0.5 * (from + to);
        let direction = right * middle.cos() + up * middle.sin();
        let lean = |sector: &Sector<'_>| -sector.corner.normal.dot(direction) / sector.corner.normal.dot(to_eye);
        let nearest = sectors
            .iter()
            .filter(|sector| (middle - sector.from).rem_euclid(TAU) < sector.span)
            .map(|sector| (lean(sector), sector))
            .reduce(|best, next| if (next.0, next.1.front) > (best.0, best.1.front) { next } else { best });
        value(nearest.map(|(_, sector)| (sector.corner, sector.front)))
    };
    let values: SmallVec<[Rgb; 16]> = (0..rays.len()).map(seen).collect();
    (0..rays.len())
        .map(|i| Step { edge: rays[i].1, step: values[i] - values[(i + rays.len() - 1) % rays.len()] })
        .filter(|step| step.step != Rgb::ZERO)
        .collect()
}

/// By how much the slope of the length jumps that a line with the unit normal `across` has in the image, when it passes
/// over the vertex: the sum of step times slope of each ray.
pub(super) fn slope_jump(steps: &[Step], to_eye: DVec3, across: DVec3) -> Rgb {
    let along = to_eye.cross(across);
    let part = |step: &Step| step.step * (step.edge.dot(along) / step.edge.dot(across));
    let sum: Rgb = steps.iter().map(part).sum();
    let most = steps.iter().map(|step| part(step).abs().max_element()).fold(0.0, f64::max);
    if sum.abs().max_element() > CANCELLED * most { sum } else { Rgb::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(next: DVec3, previous: DVec3) -> FaceCorner {
        FaceCorner { next, previous, normal: next.cross(previous).normalize(), radiance: Rgb::ONE }
    }

    /// The three faces at the upper corner of a box in the octant x, y, z < 0.
    fn box_corner() -> [FaceCorner; 3] {
        let [x, y, z] = [-DVec3::X, -DVec3::Y, -DVec3::Z];
        [corner(x, y), corner(y, z), corner(z, x)]
    }

    #[test]
    fn a_plates_corner_steps_at_its_two_edges() {
        let plate = [corner(DVec3::X, DVec3::Y)];
        for eye in [DVec3::Z, -DVec3::Z] {
            let steps = steps(&plate, eye, open);
            assert_eq!(steps.len(), 2);
            // A line across the diagonal: both rays have slope 1 in opposite directions.
            let across = (DVec3::X + DVec3::Y).normalize();
            assert!((slope_jump(&steps, eye, across).abs() - 2.0 * Rgb::ONE).length() < 1e-12);
        }
        assert!(steps(&plate, -DVec3::Z, emitted(Rgb::ZERO)).is_empty(), "a back gives no light");
    }

    #[test]
    fn only_the_outline_of_a_box_steps() {
        assert_eq!(steps(&box_corner(), DVec3::ONE.normalize(), open).len(), 0, "the corner is seen inside the box");
        // From high above and in front of one wall: the silhouette has two edges at the corner.
        let silhouette = steps(&box_corner(), DVec3::new(1.0, -1.0, 1.0).normalize(), open);
        assert_eq!(silhouette.len(), 2);
    }

    #[test]
    fn a_vertex_in_a_straight_outline_is_no_corner() {
        let straight = [corner(DVec3::X, DVec3::Y), corner(DVec3::Y, -DVec3::X)];
        let steps = steps(&straight, DVec3::Z, emitted(Rgb::ZERO));
        assert_eq!(steps.len(), 2);
        assert_eq!(slope_jump(&steps, DVec3::Z, DVec3::new(0.6, 0.8, 0.0)), Rgb::ZERO);
    }

    #[test]
    fn touching_lights_step_by_their_difference() {
        let dim = FaceCorner { radiance: Rgb::splat(0.25), ..corner(DVec3::Y, -DVec3::X) };
        let steps = steps(&[corner(DVec3::X, DVec3::Y), dim], DVec3::Z, emitted(Rgb::ZERO));
        let mut sizes: Vec<f64> = steps.iter().map(|step| step.step.x.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        assert_eq!(sizes, [0.25, 0.75, 1.0]);
    }

    #[test]
    fn the_face_that_leans_to_the_eye_hides_the_one_behind() {
        // A lit plate, and a dark fin that stands on its edge and leans over it.
        let lit = corner(DVec3::X, DVec3::Y);
        let fin = FaceCorner { radiance: Rgb::ZERO, ..corner(DVec3::new(1.0, 1.0, 1.0), DVec3::X) };
        let steps = steps(&[lit, fin], DVec3::Z, emitted(Rgb::ZERO));
        let rays: Vec<DVec3> = steps.iter().map(|step| step.edge).collect();
        assert!(rays.contains(&DVec3::Y) && rays.contains(&DVec3::ONE) && !rays.contains(&DVec3::X), "{rays:?}");
    }
}
