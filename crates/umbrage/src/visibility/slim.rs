//! Slim faces in pieces: a tree of boxes for rays alone.
//!
//! The box of a sliver that lies aslant is mostly empty, and thousands of them cover each other: the spikes of a polygon of 20,000
//! corners, or the slivers that one of many corners is partitioned into. Then a ray meets the boxes of a thousand faces, and one face.
//! So such faces are halved across their longest extent, as long as the boxes of the halves are much smaller, and the tree is built over
//! the boxes of the pieces (*early split clipping*: Ernst and Greiner, *Early Split Clipping for Bounding Volume Hierarchies*, 2007).
//!
//! Only rays that ask for any or for the nearest face walk it: they do not mind meeting a face twice. A scene without such faces has no second
//! tree, and the same answers.
//!
//! Holds: the boxes of a face's pieces cover it.

use glam::DVec3;
use obvhs::Boundable;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::index::rounded;
use crate::geometry::clip;
use crate::id::FaceId;

/// A piece is halved where the boxes of its halves have less than this share of its box's area together: 0.75 for a right
/// triangle along the axes, which is not slim, and 0.5 for an aslant line.
const HALVES_SAVE: f64 = 0.7;
/// A face is halved so many times at most: into 32 pieces.
const MOST_HALVINGS: u32 = 5;
/// The tree of pieces is built where they leave less than this share of the area of all boxes: else it saves less than it costs.
const WORTH_IT: f64 = 0.5;
/// And where there are as many faces: a ray looks at fewer in no time.
const LEAST_FACES: usize = 256;

/// A tree of boxes, and the faces in them.
#[derive(Clone)]
pub(super) struct SlimTree {
    tree: Bvh2,
    /// The face of each piece.
    faces: Vec<FaceId>,
}

impl SlimTree {
    /// The tree over the pieces of faces, each with its boundary; `None` where they are not slim.
    pub(super) fn new<'a>(
        boundaries_m: impl IndexedParallelIterator<Item = &'a [DVec3]>,
        faces: usize,
    ) -> Option<Self> {
        if faces < LEAST_FACES {
            return None;
        }
        let of_face = |boundary_m: &[DVec3]| {
            let mut pieces = SmallVec::<[Piece; 1]>::new();
            halve(boundary_m.iter().copied().collect(), MOST_HALVINGS, &mut pieces);
            (Piece::around(boundary_m).area_m2(), pieces)
        };
        let of_faces: Vec<_> = boundaries_m.map(of_face).collect();
        let whole_m2: f64 = of_faces.iter().map(|(area_m2, _)| area_m2).sum();
        let in_pieces_m2: f64 = of_faces.iter().flat_map(|(_, pieces)| pieces).map(Piece::area_m2).sum();
        if in_pieces_m2 > WORTH_IT * whole_m2 {
            return None;
        }
        let numbered = of_faces.iter().enumerate();
        let faces = numbered.flat_map(|(face, (_, pieces))| std::iter::repeat_n(FaceId::from(face), pieces.len()));
        let faces = faces.collect();
        let pieces: Vec<Piece> = of_faces.into_iter().flat_map(|(_, pieces)| pieces).collect();
        let tree = build_bvh2(&pieces, obvhs::BvhBuildParams::medium_build(), &mut Default::default());
        Some(Self { tree, faces })
    }

    /// The tree of boxes.
    pub(super) fn tree(&self) -> &Bvh2 {
        &self.tree
    }

    /// The face of one of its primitives.
    pub(super) fn face(&self, primitive: u32) -> FaceId {
        self.faces[primitive as usize]
    }
}

/// The box of a piece, in metres.
#[derive(Clone, Copy, Debug)]
struct Piece {
    min_m: DVec3,
    max_m: DVec3,
}

impl Piece {
    fn around(corners_m: &[DVec3]) -> Self {
        let min_m = corners_m.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        Self { min_m, max_m: corners_m.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max) }
    }

    fn area_m2(&self) -> f64 {
        let size_m = self.max_m - self.min_m;
        2.0 * (size_m.x * size_m.y + size_m.y * size_m.z + size_m.z * size_m.x)
    }
}

impl Boundable for Piece {
    fn aabb(&self) -> Aabb {
        Aabb::new(rounded(self.min_m, f32::next_down), rounded(self.max_m, f32::next_up))
    }
}

fn halve(corners_m: SmallVec<[DVec3; 8]>, halvings: u32, pieces: &mut SmallVec<[Piece; 1]>) {
    let whole = Piece::around(&corners_m);
    let size_m = whole.max_m - whole.min_m;
    let axis = if size_m.max_element() == size_m.x {
        DVec3::X
    } else if size_m.max_element() == size_m.y {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let middle_m = axis.dot(0.5 * (whole.min_m + whole.max_m));
    if halvings > 0 {
        let halves = [-1.0, 1.0].map(|side| {
            clip::where_not_negative(&corners_m, |p: DVec3| side * (axis.dot(p) - middle_m))
                .into_iter()
                .collect::<SmallVec<[DVec3; 8]>>()
        });
        let area_m2: f64 = halves.iter().map(|half| Piece::around(half).area_m2()).sum();
        if halves.iter().all(|half| !half.is_empty()) && area_m2 < HALVES_SAVE * whole.area_m2() {
            return halves.into_iter().for_each(|half| halve(half, halvings - 1, pieces));
        }
    }
    pieces.push(whole);
}

#[cfg(test)]
mod tests {
    use super::super::{Visibility, fixture};
    use super::*;

    #[test]
    fn a_ray_through_a_thousand_spikes_meets_the_boxes_of_few_and_the_same_face() {
        let spike = |i: u32| {
            let along = |angle: f64| DVec3::new(angle.cos(), angle.sin(), 0.0);
            let angle = |i: u32| std::f64::consts::TAU * f64::from(i) / 1000.0;
            [0.5 * along(angle(i)), along(0.5 * (angle(i) + angle(i + 1))), 0.5 * along(angle(i + 1))]
                .map(fixture::f32_point)
                .to_vec()
        };
        let prepared = fixture::prepared(&(0..1000).map(spike).collect::<Vec<_>>());
        let [slim, whole] = [Visibility::new(&prepared), Visibility::without_tree(&prepared)];
        assert!(slim.ray_tree().nodes.len() > slim.tree().nodes.len(), "there are pieces");
        let mut looked_at = 0;
        for i in 0..1000 {
            let (radius, angle) = (0.5 + 5e-4 * f64::from(i), 2.4 * f64::from(i));
            let foot = radius * DVec3::new(angle.cos(), angle.sin(), 0.0);
            let [from, to] = [foot + DVec3::new(0.1, 0.2, 1.0), foot - DVec3::new(0.1, 0.2, 1.0)];
            let no_plane = [prepared.planes.len().into(); 2];
            assert_eq!(slim.blocker(None, from, to, no_plane), whole.blocker(None, from, to, no_plane), "at {foot}");
            assert_eq!(slim.first_met(from, to, None), whole.first_met(from, to, None), "at {foot}");
            let at = |min_m: DVec3, max_m: DVec3| min_m.cmple(foot).all() && max_m.cmpge(foot).all();
            let meets = |aabb: &Aabb| at(aabb.min.as_dvec3(), aabb.max.as_dvec3());
            slim.walk_ray(None, meets, at, |_| {
                looked_at += 1;
                std::ops::ControlFlow::Continue(())
            });
        }
        assert!(looked_at < 10_000, "{looked_at} boxes over 1,000 points");
    }

    #[test]
    fn a_box_needs_no_pieces() {
        let boxes = (0..100)
            .map(f64::from)
            .flat_map(|x| fixture::outward_box(2.0 * DVec3::splat(x), 2.0 * DVec3::splat(x) + 1.0));
        let index = Visibility::new(&fixture::prepared(&boxes.collect::<Vec<_>>()));
        assert_eq!(index.ray_tree().nodes.len(), index.tree().nodes.len());
    }
}
