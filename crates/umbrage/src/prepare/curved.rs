//! The curved surface that a smooth face stands for, near a point of the face.
//!
//! The plane through each corner of a facet that its normal is perpendicular to touches the curved surface there. A point of the
//! facet is moved to where those planes are over it, each as much as its corner weighs at the point (after Hanika, *Hacking the shadow
//! terminator*, Ray Tracing Gems II, 2021). So a point of a convex surface comes to lie outside of its facets, and one of a concave
//! surface stays where it is.
//!
//! Holds: the offset is zero at corners of the input, and on an edge it depends on the ends of the edge alone; so it is continuous
//! over a smooth surface, as is the normal. It does not change where a facet is cut.

use glam::DVec3;

use super::Prepared;
use crate::id::FaceId;

impl Prepared {
    /// From a point of a smooth face to the curved surface in front of it, in metres; zero where the face lies in front of that.
    pub fn offset_to_curved_m(&self, face: FaceId, at_m: DVec3) -> DVec3 {
        let normal = self.smooth_normal(face, at_m);
        // The normals of a skin look to the front of its polygon, which may be the back of this face.
        let sign = self.faces[face].skin.map_or(0.0, |skin| self.skins[skin].side_of(normal, at_m));
        let over_m = self.faces[face].skin.map_or(0.0, |skin| self.skins[skin].over_m(at_m));
        (sign * over_m).max(0.0) * normal
    }
}

#[cfg(test)]
mod tests {
    use super::super::{PrepareSettings, prepare_with};
    use super::*;
    use crate::id::{MaterialId, NodeId};
    use crate::progress::Progress;
    use crate::scene::{Material, Node, Rgb, Scene, Surface};

    /// A strip of two facets of a cylinder of radius 1 m around the y axis, seen from outside or from inside.
    fn strip(outside: bool) -> Prepared {
        let sign = if outside { 1.0 } else { -1.0 };
        let mut surface = Surface::new(NodeId::from(0), MaterialId::from(0));
        for angle in [-0.4_f64, 0.0, 0.4] {
            for y in [0.0, 1.0] {
                surface.positions_m.push(DVec3::new(angle.sin(), y, angle.cos()));
                surface.normals.push(sign * DVec3::new(angle.sin(), 0.0, angle.cos()));
            }
        }
        let quad = |i: u32| if outside { vec![i, i + 2, i + 3, i + 1] } else { vec![i, i + 1, i + 3, i + 2] };
        surface.polygons = vec![quad(0), quad(2)];
        let mut scene = Scene::default();
        scene.nodes.push(Node::default());
        scene.materials.push(Material::diffuse("grey", Rgb::splat(0.5)));
        scene.surfaces.push(surface);
        prepare_with(&scene, PrepareSettings::default(), Progress::silent()).unwrap()
    }

    #[test]
    fn the_middle_of_a_chord_is_moved_to_where_the_tangents_meet() {
        let prepared = strip(true);
        for face in prepared.faces.keys() {
            let corners_m = prepared.polygon_m(face);
            let middle_m = corners_m.iter().sum::<DVec3>() / 4.0;
            let height_m = 0.2_f64.sin() * 0.2_f64.sin();
            assert!(prepared.offset_to_curved_m(face, middle_m).distance(height_m * prepared.normal(face)) < 1e-6);
            for corner_m in corners_m {
                assert!(prepared.offset_to_curved_m(face, corner_m).length() < 1e-6);
            }
        }
    }

    #[test]
    fn a_point_of_a_concave_surface_stays() {
        let prepared = strip(false);
        for face in prepared.faces.keys() {
            let middle_m = prepared.polygon_m(face).iter().sum::<DVec3>() / 4.0;
            assert!(prepared.is_smooth(face) && prepared.offset_to_curved_m(face, middle_m) == DVec3::ZERO);
        }
    }
}
