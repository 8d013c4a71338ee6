//! Rays: what stands between two points.
//!
//! Leaves are tested by exact predicates on the faces' own vertices, triangle by triangle of a fan, so that neighbours
//! agree about their common edge.
//!
//! Holds: a ray through a shared edge or vertex is blocked; a face that the ray only ends on, or runs along, does not
//! block it; faces in the planes that the caller names (those of receiver and source) never do.

use std::ops::ControlFlow;

use glam::DVec3;

use super::Visibility;
use crate::geometry::predicate::orient_3d;
use crate::id::{FaceId, PlaneId};

impl Visibility {
    /// Whether a face crosses the open segment between two points; faces in the planes `passing` are passed through.
    pub fn occluded(&self, from_m: DVec3, to_m: DVec3, passing: [PlaneId; 2]) -> bool {
        let mut hit = false;
        self.walk_along(from_m, to_m, |face| {
            if passing.contains(&self.plane(face)) {
                return ControlFlow::Continue(());
            }
            hit = self.is_crossed(face, from_m, to_m);
            if hit { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        hit
    }

    /// The faces that cross the open segment between two points, but for those in the plane `passing`.
    pub fn crossed(&self, from_m: DVec3, to_m: DVec3, passing: PlaneId) -> Vec<FaceId> {
        let mut crossed = Vec::new();
        self.walk_along(from_m, to_m, |face| {
            if self.plane(face) != passing && self.is_crossed(face, from_m, to_m) {
                crossed.push(face);
            }
            ControlFlow::Continue(())
        });
        crossed
    }

    fn is_crossed(&self, face: FaceId, from_m: DVec3, to_m: DVec3) -> bool {
        let boundary = self.boundary_m(face);
        boundary[1..].windows(2).any(|pair| crosses(from_m, to_m, [boundary[0], pair[0], pair[1]]))
    }

    /// Visits the faces whose boxes the segment between two points meets.
    fn walk_along(&self, from_m: DVec3, to_m: DVec3, visit: impl FnMut(FaceId) -> ControlFlow<()>) {
        // Finite, so that a box whose border the ray starts on, along an axis that it does not follow, is not lost as NaN.
        let per_m = (to_m - from_m).recip().clamp(DVec3::MIN, DVec3::MAX);
        let meets = |min_m: DVec3, max_m: DVec3| {
            let (to_min, to_max) = ((min_m - from_m) * per_m, (max_m - from_m) * per_m);
            let near = to_min.min(to_max).max_element().max(0.0);
            let far = to_min.max(to_max).min_element().min(1.0);
            near <= far + SLAB_SLACK
        };
        self.walk(meets, visit);
    }
}

/// Rounding of the parameters at which a ray enters and leaves a box, as a share of the ray: boxes may only be missed
/// where the exact test would miss their faces.
const SLAB_SLACK: f64 = 1e-12;

/// Whether a closed triangle crosses an open segment, by exact signs.
fn crosses(from: DVec3, to: DVec3, [p, q, r]: [DVec3; 3]) -> bool {
    if orient_3d(p, q, r, from) * orient_3d(p, q, r, to) >= 0.0 {
        return false;
    }
    let turns = [orient_3d(from, to, p, q), orient_3d(from, to, q, r), orient_3d(from, to, r, p)];
    turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;

    fn two_triangles() -> (Visibility, PlaneId) {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let prepared = fixture::prepared(&[
            vec![corners[0], corners[1], corners[2]],
            vec![corners[0], corners[2], corners[3]],
            corners.map(|p| p - 5.0 * DVec3::Z).to_vec(),
        ]);
        (Visibility::new(&prepared), prepared.faces.raw[2].plane)
    }

    #[test]
    fn a_ray_on_a_shared_edge_is_blocked() {
        let (index, below) = two_triangles();
        let blocked = |x: f64, y: f64| {
            index.occluded(DVec3::new(0.875, 0.25, 3.0), DVec3::new(2.0 * x - 0.875, 2.0 * y - 0.25, -3.0), [below; 2])
        };
        assert!(blocked(0.5, 0.5) && blocked(0.25, 0.25) && blocked(0.0, 0.0) && blocked(1.0, 0.5));
        assert!(blocked(0.75, 0.25) && !blocked(1.01, 0.5) && !blocked(-0.01, -0.01));
    }

    #[test]
    fn a_face_at_the_end_of_a_ray_does_not_block_it() {
        let (index, below) = two_triangles();
        let on_face = DVec3::new(0.5, 0.25, 0.0);
        assert!(!index.occluded(on_face, on_face + DVec3::Z, [below; 2]));
        assert!(!index.occluded(on_face, on_face - DVec3::Z, [below; 2]));
        assert!(!index.occluded(on_face - DVec3::X, on_face + DVec3::X, [below; 2]));
    }

    #[test]
    fn faces_in_the_planes_of_the_ends_are_passed() {
        let (index, below) = two_triangles();
        let (above, under) = (DVec3::new(0.5, 0.25, -4.0), DVec3::new(0.5, 0.25, -6.0));
        assert!(!index.occluded(above, under, [below; 2]));
        assert!(index.occluded(above, under, [index.plane(0.into()); 2]));
    }
}
