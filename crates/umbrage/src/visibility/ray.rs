//! Rays: what stands between two points.
//!
//! Leaves are tested by exact predicates on the faces' own vertices, triangle by triangle of a fan, so that neighbours
//! agree about their common edge.
//!
//! Holds: a ray through a shared edge or vertex is blocked; a face that the ray only ends on, or runs along, does not
//! block it; faces in the planes that the caller names (those of receiver and source) never do.

use std::ops::ControlFlow;

use glam::{DVec3, Vec3A};
use obvhs::aabb::Aabb;

use super::Visibility;
use super::pair::Placed;
use crate::geometry::predicate::orient_3d;
use crate::id::{FaceId, PlaneId};

/// Where a ray starts, in metres, and the face that this is a point of, if it is one.
pub(super) type Origin = (DVec3, Option<FaceId>);

impl Visibility {
    /// Whether a face crosses the open segment between two points; faces in the planes `passing` are passed through.
    pub fn occluded(&self, from_m: DVec3, to_m: DVec3, passing: [PlaneId; 2]) -> bool {
        self.blocker(None, from_m, to_m, passing).is_some()
    }

    /// A face that does, of some faces, or of all where none are given.
    pub(crate) fn blocker(
        &self,
        among: Option<&[FaceId]>,
        from_m: DVec3,
        to_m: DVec3,
        passing: [PlaneId; 2],
    ) -> Option<FaceId> {
        self.blocker_but(among, (from_m, None), to_m, passing, |_| false)
    }

    /// The same from a point that may be of a face, but for faces that `passes` lets pass.
    pub(super) fn blocker_but(
        &self,
        among: Option<&[FaceId]>,
        from: Origin,
        to_m: DVec3,
        passing: [PlaneId; 2],
        passes: impl Fn(FaceId) -> bool,
    ) -> Option<FaceId> {
        let mut hit = None;
        let visit = |face| {
            if passes(face) || passing.contains(&self.plane(face)) || !self.is_crossed(face, from, to_m) {
                return ControlFlow::Continue(());
            }
            hit = Some(face);
            ControlFlow::Break(())
        };
        let slabs = Slabs::new(from.0, to_m);
        let may_meet = |aabb: &Aabb| slabs.may_meet(aabb.min, aabb.max);
        self.walk_ray(among, may_meet, |min_m, max_m| slabs.meet(min_m, max_m), visit);
        hit
    }

    /// The faces that cross the open segment between two points, but for those in the plane `passing`.
    pub fn crossed(&self, from_m: DVec3, to_m: DVec3, passing: PlaneId) -> Vec<FaceId> {
        let mut crossed = Vec::new();
        self.walk_along(&Slabs::new(from_m, to_m), |face| {
            if self.plane(face) != passing && self.is_crossed(face, (from_m, None), to_m) {
                crossed.push(face);
            }
            ControlFlow::Continue(())
        });
        crossed
    }

    pub(super) fn is_crossed(&self, face: FaceId, from: Origin, to_m: DVec3) -> bool {
        self.crossing(face, from, to_m).is_some()
    }

    /// How far the ends of an open segment that a face crosses, by exact signs, are over the face, in one measure: one of them is
    /// below zero. Of a start on a face that is very near, the side that its face is on counts ([`super::pair`]).
    pub(super) fn crossing(&self, face: FaceId, (from_m, own): Origin, to_m: DVec3) -> Option<[f64; 2]> {
        let placed = own.and_then(|own| self.placed_at(face, own, from_m));
        if placed == Some(Placed::Behind) || (placed.is_none() && self.is_beside(face, from_m, to_m)) {
            return None;
        }
        let side_of_start = match placed {
            Some(Placed::BeforeWithFront) => 1.0,
            Some(Placed::BeforeWithBack) => -1.0,
            _ => 0.0,
        };
        if side_of_start != 0.0 && self.is_over(face, from_m) {
            let over_end = self.near_plane(face).signed_distance_m(to_m);
            return (side_of_start * over_end < 0.0).then_some([side_of_start * f64::MIN_POSITIVE, over_end]);
        }
        let (&apex, others) = self.boundary_m(face).split_first()?;
        // A triangle of the fan is crossed where the line turns the same way around all of its sides.
        let mut turn = orient_3d(from_m, to_m, apex, *others.first()?);
        for pair in others.windows(2) {
            let next = orient_3d(from_m, to_m, apex, pair[1]);
            let (first, last) = (std::mem::replace(&mut turn, next), -next);
            if (first > 0.0 && last < 0.0) || (first < 0.0 && last > 0.0) {
                continue;
            }
            let turns = [first, orient_3d(from_m, to_m, pair[0], pair[1]), last];
            if turns.iter().all(|&t| t >= 0.0) || turns.iter().all(|&t| t <= 0.0) {
                let mut over = [from_m, to_m].map(|end| orient_3d(apex, pair[0], pair[1], end));
                if side_of_start != 0.0 {
                    over[0] = side_of_start * over[0].abs().max(f64::MIN_POSITIVE);
                }
                if (over[0] > 0.0 && over[1] < 0.0) || (over[0] < 0.0 && over[1] > 0.0) {
                    return Some(over);
                }
            }
        }
        None
    }

    /// Visits the faces whose boxes a segment meets.
    fn walk_along(&self, slabs: &Slabs, visit: impl FnMut(FaceId) -> ControlFlow<()>) {
        self.walk_among(
            None,
            |aabb| slabs.may_meet(aabb.min, aabb.max),
            |min_m, max_m| slabs.meet(min_m, max_m),
            visit,
        );
    }
}

/// A segment, made for the question which boxes it meets: those whose slabs along the axes it is in at one time.
pub(super) struct Slabs {
    from_m: DVec3,
    per_m: DVec3,
    /// The start in `f32`, moved by its rounding either way.
    around_m: [Vec3A; 2],
    per_m_rounded: Vec3A,
}

impl Slabs {
    pub(super) fn new(from_m: DVec3, to_m: DVec3) -> Self {
        // Finite, so that a box whose border the ray starts on, along an axis that it does not follow, is not lost as
        // NaN.
        let per_m = (to_m - from_m).recip().clamp(DVec3::splat(-MOST_PER_M), DVec3::splat(MOST_PER_M));
        let (start, grown) = (from_m.as_vec3a(), Vec3A::splat((ROUNDED_START * from_m.abs().max_element()) as f32));
        Self { from_m, per_m, around_m: [start - grown, start + grown], per_m_rounded: per_m.as_vec3a() }
    }

    pub(super) fn meet(&self, min_m: DVec3, max_m: DVec3) -> bool {
        let (to_min, to_max) = ((min_m - self.from_m) * self.per_m, (max_m - self.from_m) * self.per_m);
        let near = to_min.min(to_max).max_element().max(0.0);
        let far = to_min.max(to_max).min_element().min(1.0);
        near <= far + SLAB_SLACK
    }

    /// The same in `f32`, where rounding never loses a box: but it may pass one more (Ize, *Robust BVH ray traversal*,
    /// 2013).
    fn may_meet(&self, min_m: Vec3A, max_m: Vec3A) -> bool {
        self.may_enter(min_m, max_m).is_some()
    }

    /// The time at which it may enter a box, if it may meet it at all: no later than it does.
    pub(super) fn may_enter(&self, min_m: Vec3A, max_m: Vec3A) -> Option<f32> {
        let to_min = (min_m - self.around_m[1]) * self.per_m_rounded;
        let to_max = (max_m - self.around_m[0]) * self.per_m_rounded;
        let near = to_min.min(to_max).max_element().max(0.0);
        let far = to_min.max(to_max).min_element().min(1.0);
        (near <= far + ROUNDED_SLACK).then_some(near - ROUNDED_SLACK)
    }
}

/// Rounding of the parameters at which a ray enters and leaves a box, as a share of the ray: boxes may only be missed
/// where the exact test would miss their faces.
const SLAB_SLACK: f64 = 1e-12;
/// The same in `f32`: parameters between 0 and 1 are good to some 3e-7.
const ROUNDED_SLACK: f32 = 1e-6;
/// The start of a ray is rounded by less than this share of its greatest coordinate.
const ROUNDED_START: f64 = 1.2e-7;
/// In place of infinity where a ray does not follow an axis: finite in `f32`, whatever a scene's extent is in metres.
const MOST_PER_M: f64 = 1e25;

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
