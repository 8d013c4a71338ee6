//! The first face along a ray.
//!
//! Boxes are visited the nearer first, and no more once a face is nearer than they are. Whether a face is crossed is told by the exact
//! signs of [`super::ray`], so no ray slips through an edge that faces share.
//!
//! Holds: where the two sides of a sheet are two faces of one plane, the one that looks at the start is met.

use glam::DVec3;
use smallvec::SmallVec;

use super::ray::{Origin, Slabs};
use super::{ReceiverPoint, Visibility};
use crate::id::{FaceId, PlaneId};

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Met {
    /// 0 at the start of the ray, 1 at its end.
    at: f64,
    plane: PlaneId,
    face: FaceId,
    /// The face whose front it is; `None` where it is a back.
    front: Option<FaceId>,
}

/// The side of a face that a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FirstMet {
    /// No face.
    Nothing,
    /// The back of this face.
    Back(FaceId),
    /// The front of this face, at this point, in metres.
    Front(FaceId, DVec3),
}

impl Visibility {
    /// The face whose front a receiver point sees first in the direction of a point far away, and where; `None` where it sees none, or
    /// a back before.
    pub fn first_front_of(&self, receiver: &ReceiverPoint, to_m: DVec3) -> Option<(FaceId, DVec3)> {
        let from_m = receiver.position_m;
        let Some(near) = receiver.near else {
            let mut first = None;
            let own = (from_m, receiver.face);
            let covering = receiver.face.map_or(&[][..], |own| self.covering(own));
            covering.iter().for_each(|&face| self.meet(face, own, to_m, &mut first));
            let met = self.nearest(own, to_m, |face| self.plane(face) == receiver.plane, first)?;
            return Some((met.front?, from_m.lerp(to_m, met.at)));
        };
        let mut first = None;
        let (near_m, near_to_m) = (near.from_m, to_m + (near.from_m - from_m));
        self.near(receiver).iter().for_each(|&face| self.meet(face, (near_m, None), near_to_m, &mut first));
        let passes = |face: FaceId| self.plane(face) == receiver.plane || self.is_near(receiver, face);
        let met = self.nearest((from_m, receiver.face), to_m, passes, first)?;
        Some((met.front?, from_m.lerp(to_m, met.at)))
    }

    /// The face whose front the open segment between two points meets first, and where; `None` where it meets none, or a back before.
    /// Faces in the plane `passing` are passed through.
    pub fn first_front(&self, from_m: DVec3, to_m: DVec3, passing: PlaneId) -> Option<(FaceId, DVec3)> {
        let met = self.nearest((from_m, None), to_m, |face| self.plane(face) == passing, None)?;
        Some((met.front?, from_m.lerp(to_m, met.at)))
    }

    /// Finds what the open segment between two points meets first. Faces in the plane `passing`, where one is given, are passed through.
    pub fn first_met(&self, from_m: DVec3, to_m: DVec3, passing: Option<PlaneId>) -> FirstMet {
        match self.nearest((from_m, None), to_m, |face| Some(self.plane(face)) == passing, None) {
            None => FirstMet::Nothing,
            Some(Met { front: None, face, .. }) => FirstMet::Back(face),
            Some(Met { front: Some(face), at, .. }) => FirstMet::Front(face, from_m.lerp(to_m, at)),
        }
    }

    /// What a segment meets first, if that is not `first` already.
    fn nearest(
        &self,
        from: Origin,
        to_m: DVec3,
        passes: impl Fn(FaceId) -> bool,
        mut first: Option<Met>,
    ) -> Option<Met> {
        let tree = self.ray_tree();
        let slabs = Slabs::new(from.0, to_m);
        let enters = |node: u32| {
            let aabb = tree.nodes[node as usize].aabb();
            slabs.may_enter(aabb.min, aabb.max)
        };
        let mut stack: SmallVec<[(u32, f32); 64]> = SmallVec::new();
        if !tree.nodes.is_empty() {
            stack.extend(enters(0).map(|near| (0, near)));
        }
        while let Some((index, near)) = stack.pop() {
            if first.is_some_and(|met| f64::from(near) > met.at) {
                continue;
            }
            let node = &tree.nodes[index as usize];
            if node.is_leaf() {
                let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                for &primitive in &tree.primitive_indices[range] {
                    let face = self.face_met(primitive);
                    let [min_m, max_m] = self.bounds_m(face);
                    if !passes(face) && slabs.meet(min_m, max_m) {
                        self.meet(face, from, to_m, &mut first);
                    }
                }
                continue;
            }
            let [one, other] =
                [node.first_index, node.first_index + 1].map(|part| enters(part).map(|near| (part, near)));
            let one_is_nearer = matches!((one, other), (Some(one), Some(other)) if one.1 <= other.1);
            let [far, near] = if one_is_nearer { [other, one] } else { [one, other] };
            if let Some(far) = far {
                stack.push(far);
            }
            if let Some(near) = near {
                stack.push(near);
            }
        }
        first
    }

    /// Notes a face that a segment crosses, where it is the first so far.
    fn meet(&self, face: FaceId, from: Origin, to_m: DVec3, first: &mut Option<Met>) {
        let Some([over_start, over_end]) = self.crossing(face, from, to_m) else { return };
        let at = over_start / (over_start - over_end);
        let plane = self.plane(face);
        let front = (over_start > 0.0).then_some(face);
        match first {
            Some(met) if met.plane == plane => met.front = met.front.or(front),
            Some(met) if met.at <= at => {}
            _ => *first = Some(Met { at, plane, face, front }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn it_is_the_nearest_of_all_that_are_crossed(
            centres in prop::collection::vec((-2.0..2.0, -2.0..2.0, -2.0..2.0), 1..40),
            from in (-3.0..3.0, -3.0..3.0, -3.0..3.0), to in (-3.0..3.0, -3.0..3.0, -3.0..3.0),
        ) {
            let prepared = fixture::prepared(&fixture::boxes(&centres));
            let index = Visibility::new(&prepared);
            let (from_m, to_m) = (DVec3::from(from), DVec3::from(to));
            let passing = PlaneId::from(prepared.faces.len());
            let distance_m = |face: FaceId| {
                let plane = prepared.oriented_plane(face);
                let over = [from_m, to_m].map(|p| plane.signed_distance_m(p));
                (over[0] / (over[0] - over[1]), over[0] > 0.0)
            };
            let crossed = index.crossed(from_m, to_m, passing);
            let nearest = crossed.iter().map(|&face| distance_m(face)).min_by(|p, q| p.0.total_cmp(&q.0));
            let found = index.first_front(from_m, to_m, passing);
            prop_assert_eq!(found.is_some(), nearest.is_some_and(|(_, is_front)| is_front));
            if let (Some((face, at_m)), Some((at, _))) = (found, nearest) {
                prop_assert!((distance_m(face).0 - at).abs() < 1e-9);
                // Corners lie in the plane of their face within its tolerance.
                prop_assert!(prepared.oriented_plane(face).signed_distance_m(at_m).abs() < 1e-9 + 4.0 * prepared.tolerance.coplanar_m());
            }
        }
    }

    #[test]
    fn a_sheet_is_met_on_the_side_that_looks_at_the_start() {
        let (up, down) = (fixture::square(DVec3::Z, 1.0, true), fixture::square(DVec3::Z, 1.0, false));
        for sheet in [[up.clone(), down.clone()], [down, up.clone()]] {
            let prepared = fixture::prepared(&sheet);
            let index = Visibility::new(&prepared);
            for height_m in [0.0, 2.0] {
                let from_m = DVec3::new(0.3, 0.2, height_m);
                let (face, at_m) = index
                    .first_front(from_m, from_m + 3.0 * (DVec3::Z - from_m.with_x(0.0).with_y(0.0)), PlaneId::from(9))
                    .unwrap();
                assert!(prepared.normal(face).z * (height_m - 1.0) > 0.0 && (at_m.z - 1.0).abs() < 1e-12);
            }
        }
        let alone = fixture::prepared(&[up]);
        let from_m = DVec3::new(0.3, 0.2, 0.0);
        assert_eq!(Visibility::new(&alone).first_front(from_m, from_m + 2.0 * DVec3::Z, PlaneId::from(9)), None);
    }
}
