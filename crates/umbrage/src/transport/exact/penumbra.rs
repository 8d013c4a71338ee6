//! Where on a receiver an occluder takes something of a source: the outer border of its penumbra.
//!
//! A corner of the source and a corner of the occluder throw a point on the receiver; the convex hull of all those points is
//! the penumbra. A rule whose points all lie outside of it knows nothing of the occluder, so the hull tells where to look.
//!
//! Like kinks, penumbrae are hints. Corners of the occluder next to the height of the source's corner throw their points
//! towards infinity, and are left out.

use glam::{DVec2, DVec3};

use crate::geometry::{PlaneFrame, clip, convex};
use crate::visibility::{SourcePolygon, Visibility};

/// A corner of the source must be higher over the receiver than this many times the height of the occluder's corner.
const LEAST_HEIGHT_RATIO: f64 = 1.01;

/// The penumbrae on the receiver, in its frame, each convex and counter-clockwise.
pub(super) fn penumbrae(
    visibility: &Visibility,
    receiver: &SourcePolygon,
    source: &SourcePolygon,
    frame: &PlaneFrame,
) -> Vec<Vec<DVec2>> {
    let whole: Vec<DVec2> = receiver.corners_m.iter().map(|&p| frame.to_2d(p)).collect();
    let slack_m = visibility.tolerance().coplanar_m();
    visibility
        .faces_between(receiver, source)
        .into_iter()
        .map(|face| {
            let above = clip::in_front_of(visibility.boundary_m(face), &receiver.oriented_plane, slack_m);
            let between = clip::in_front_of(&above, &source.oriented_plane, slack_m);
            clip::intersection(&convex::hull(thrown(&between, &source.corners_m, frame)), &whole)
        })
        .filter(|penumbra| penumbra.len() >= 3)
        .collect()
}

/// Where lines from the source's corners through the occluder's meet the receiver.
fn thrown(occluder: &[DVec3], source: &[DVec3], frame: &PlaneFrame) -> Vec<DVec2> {
    let height = |p: DVec3| frame.plane.signed_distance_m(p);
    let pairs = source.iter().flat_map(|&s| occluder.iter().map(move |&p| (s, p)));
    pairs
        .filter(|&(s, p)| height(s) > LEAST_HEIGHT_RATIO * height(p) && height(s) > 0.0)
        .map(|(s, p)| frame.to_2d(s + (p - s) * (height(s) / (height(s) - height(p)))))
        .collect()
}

/// Whether a convex counter-clockwise polygon contains a point.
pub(super) fn contains(convex: &[DVec2], point: DVec2) -> bool {
    (0..convex.len()).all(|i| (convex[(i + 1) % convex.len()] - convex[i]).perp_dot(point - convex[i]) >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::polygon;
    use crate::id::FaceId;
    use crate::visibility::fixture::{self, square};

    #[test]
    fn the_penumbra_of_a_plate_is_as_wide_as_the_light_makes_it() {
        let polygons =
            [square(DVec3::ZERO, 3.0, true), square(DVec3::Z, 0.5, true), square(DVec3::Z * 2.0, 0.25, false)];
        let prepared = fixture::prepared(&polygons);
        let [receiver, source] = [0, 2].map(|face| SourcePolygon::of_face(&prepared, FaceId::from(face)));
        let frame = PlaneFrame::new(receiver.oriented_plane, DVec3::ZERO);
        let found = penumbrae(&Visibility::new(&prepared), &receiver, &source, &frame);
        // Twice the plate's half side, and the light's: 1.25.
        assert_eq!(found.len(), 1);
        assert!((polygon::signed_area_2d_m2(&found[0]) - 6.25).abs() < 1e-6, "{found:?}");
        assert!(contains(&found[0], DVec2::splat(1.2)) && !contains(&found[0], DVec2::new(0.0, 1.3)));
    }
}
