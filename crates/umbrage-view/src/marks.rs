//! Lines over the surfaces: d-segments, patches, and what was picked.
//!
//! Holds: lines lie on the front of their faces, relative to the file's origin; the patches of level 0 are the faces,
//! and each level shows all cuts of the levels before.

use glam::DVec3;
use umbrage::bake::Meshed;
use umbrage::id::{DSegmentId, FaceId, PatchId};
use umbrage::mesh::{Cut, Patch};
use umbrage_picture::color::{DEGREES, linear_from_srgb8};
use umbrage_picture::{LinearRgb, SEGMENT_WIDTH_PX};

/// Begin (3), end (3), normal of the surface (3), linear colour (3), half the width in pixels: see `line.wgsl`.
pub(crate) type Mark = [f32; 13];

/// Colours of cuts that no d-segment made: `point_split` and `triangle_split`, as sRGB codes.
pub(crate) const POINTS: [u8; 3] = [176, 74, 214];
pub(crate) const TRIANGLE: [u8; 3] = [0, 160, 140];
/// Colour of the outlines of faces.
const FACE: [u8; 3] = [150, 150, 150];
/// Colours of the patch that was picked, and of the d-segment that cut it.
const PICKED: [u8; 3] = [255, 235, 60];
const PICKED_HINT: [u8; 3] = [255, 255, 255];
/// Width of the lines of patches, and of what was picked, in pixels.
const PATCH_WIDTH_PX: f64 = 1.2;
const PICKED_WIDTH_PX: f64 = 3.0;
/// Length of an arm of the cross on a point, as a share of the scene's size.
const CROSS: f64 = 0.006;

/// Makes lines of what a bake kept.
#[derive(Clone, Copy)]
pub(crate) struct Marker<'a> {
    pub(crate) meshed: &'a Meshed,
    /// Origin of the file that is shown, in metres.
    pub(crate) origin_m: DVec3,
}

impl Marker<'_> {
    fn mark(&self, face: FaceId, ends_m: [DVec3; 2], color: LinearRgb, width_px: f64) -> Mark {
        let moved = self.meshed.prepared.origin_m - self.origin_m;
        mark(ends_m.map(|end| moved + end), self.meshed.prepared.normal(face), color, width_px)
    }

    /// The d-segments of the degrees that are asked for, those that jump most last, so that they are drawn over the
    /// others.
    pub(crate) fn d_segments(&self, shown: [bool; 3]) -> Vec<Mark> {
        let mut marks = Vec::new();
        for degree in (0..3).rev().filter(|&degree| shown[degree]) {
            let color = linear_from_srgb8(DEGREES[degree]);
            let segments = self.meshed.discontinuities.segments.iter();
            marks.extend(
                segments
                    .filter(|segment| segment.degree.number() == degree)
                    .map(|segment| self.mark(segment.face, segment.ends_m, color, SEGMENT_WIDTH_PX)),
            );
        }
        marks
    }

    /// The faces, and the cuts of the patches above `level`.
    pub(crate) fn patches(&self, level: usize) -> Vec<Mark> {
        let mut marks = Vec::new();
        for face in self.meshed.prepared.faces.keys() {
            marks.extend(self.outline(face, self.meshed.prepared.polygon_m(face), FACE, PATCH_WIDTH_PX));
        }
        for (id, patch) in self.meshed.mesh.patches() {
            if let (Some(ends_m), Some(cut)) = (self.meshed.mesh.cut_m(id), patch.cut)
                && level_of(self.meshed, patch) < level
            {
                let color = linear_from_srgb8(self.color_of(cut));
                marks.push(self.mark(patch.face, ends_m, color, PATCH_WIDTH_PX));
            }
        }
        marks
    }

    fn color_of(&self, cut: Cut) -> [u8; 3] {
        match cut {
            Cut::EdgeHint(d_segment) => DEGREES[self.meshed.discontinuities.segments[d_segment].degree.number()],
            Cut::Points => POINTS,
            Cut::Triangle => TRIANGLE,
        }
    }

    /// A patch that was picked, and the d-segment that cut it.
    pub(crate) fn picked(&self, patch: PatchId, hint: Option<DSegmentId>) -> Vec<Mark> {
        let face = self.meshed.mesh.patch(patch).face;
        let mut marks: Vec<Mark> =
            self.outline(face, self.meshed.mesh.polygon_m(patch), PICKED, PICKED_WIDTH_PX).collect();
        if let Some(hint) = hint {
            let segment = &self.meshed.discontinuities.segments[hint];
            marks.push(self.mark(segment.face, segment.ends_m, linear_from_srgb8(PICKED_HINT), PICKED_WIDTH_PX));
        }
        marks
    }

    fn outline(
        &self,
        face: FaceId,
        corners_m: Vec<DVec3>,
        code: [u8; 3],
        width_px: f64,
    ) -> impl Iterator<Item = Mark> + '_ {
        let color = linear_from_srgb8(code);
        (0..corners_m.len()).map(move |i| {
            let ends_m = [corners_m[i], corners_m[(i + 1) % corners_m.len()]];
            self.mark(face, ends_m, color, width_px)
        })
    }
}

/// A line between two points relative to the file's origin.
fn mark(ends_m: [DVec3; 2], normal: DVec3, color: LinearRgb, width_px: f64) -> Mark {
    let [begin, end, normal] = [ends_m[0], ends_m[1], normal].map(|vector| vector.as_vec3().to_array());
    let mut mark = [0.0; 13];
    for (words, vector) in mark.chunks_exact_mut(3).zip([begin, end, normal, color]) {
        words.copy_from_slice(&vector);
    }
    mark[12] = 0.5 * width_px as f32;
    mark
}

/// A cross on a point of a surface, relative to the file's origin, in a scene of `size_m`.
pub(crate) fn cross(point_m: DVec3, normal: DVec3, size_m: f64) -> [Mark; 2] {
    let first = normal.any_orthonormal_vector();
    [first, normal.cross(first)].map(|along| {
        let arm_m = CROSS * size_m * along;
        mark([point_m - arm_m, point_m + arm_m], normal, linear_from_srgb8(PICKED), PICKED_WIDTH_PX)
    })
}

/// How often the face was split to make a patch.
pub(crate) fn level_of(meshed: &Meshed, patch: &Patch) -> usize {
    std::iter::successors(patch.parent, |&parent| meshed.mesh.patch(parent).parent).count()
}

/// The deepest level of all patches.
pub(crate) fn deepest(meshed: &Meshed) -> usize {
    // Subpatches come after their patch.
    let mut levels = vec![0; meshed.mesh.patch_count()];
    for (id, patch) in meshed.mesh.patches() {
        levels[id.index()] = patch.parent.map_or(0, |parent| levels[parent.index()] + 1);
    }
    levels.into_iter().max().unwrap_or(0)
}

#[cfg(test)]
pub(crate) mod tests {
    use umbrage::bake::{BakeSettings, subdivided};
    use umbrage::progress::Progress;
    use umbrage::scene::cornell::cornell_box;

    use super::*;

    pub(crate) fn cornell() -> Meshed {
        let settings = BakeSettings { max_form_factor: Some(0.5), ..BakeSettings::default() };
        subdivided(&cornell_box(), &settings, Progress::silent()).unwrap()
    }

    #[test]
    fn all_d_segments_of_a_degree_are_marked() {
        let meshed = cornell();
        let marker = Marker { meshed: &meshed, origin_m: DVec3::ZERO };
        let counts = meshed.discontinuities.count_by_degree();
        for degree in 0..3 {
            let mut shown = [false; 3];
            shown[degree] = true;
            let marks = marker.d_segments(shown);
            assert_eq!(marks.len(), counts[degree]);
            let color = linear_from_srgb8(DEGREES[degree]);
            assert!(marks.iter().all(|mark| mark[9..12] == color));
        }
        assert_eq!(marker.d_segments([true; 3]).len(), counts.iter().sum::<usize>());
        assert!(counts.iter().sum::<usize>() > 0);
    }

    #[test]
    fn each_level_adds_the_cuts_of_its_patches_and_the_last_shows_all() {
        let meshed = cornell();
        let marker = Marker { meshed: &meshed, origin_m: DVec3::ZERO };
        let sides: usize = meshed.prepared.faces.iter().map(|face| face.sides.len()).sum();
        let cuts = meshed.mesh.patches().filter(|(_, patch)| patch.cut.is_some()).count();
        let deepest = deepest(&meshed);
        let counts: Vec<usize> = (0..=deepest).map(|level| marker.patches(level).len()).collect();
        assert!(deepest > 0 && counts.windows(2).all(|pair| pair[0] < pair[1]), "{counts:?}");
        assert_eq!((counts[0], counts[deepest]), (sides, sides + cuts));
    }

    #[test]
    fn a_cross_lies_in_the_surface_around_its_point() {
        let (point, normal) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.6, 0.0, 0.8));
        for mark in cross(point, normal, 10.0) {
            let [begin, end] = [0, 3].map(|at| DVec3::new(mark[at].into(), mark[at + 1].into(), mark[at + 2].into()));
            assert!(((begin + end) / 2.0).distance(point) < 1e-6);
            assert!((begin - point).dot(normal).abs() < 1e-6 && ((end - begin).length() - 0.12).abs() < 1e-6);
        }
    }

    #[test]
    fn a_mark_lies_where_its_segment_does_relative_to_the_files_origin() {
        let meshed = cornell();
        let origin_m = DVec3::new(0.5, -1.0, 2.0);
        let marks = Marker { meshed: &meshed, origin_m }.picked(PatchId::from(0), Some(DSegmentId::from(0)));
        let corners = meshed.mesh.polygon_m(PatchId::from(0));
        assert_eq!(marks.len(), corners.len() + 1);
        let expected = (meshed.prepared.origin_m + corners[0] - origin_m).as_vec3().to_array();
        assert_eq!(marks[0][..3], expected);
        assert_eq!(marks[0][12], 1.5);
    }
}
