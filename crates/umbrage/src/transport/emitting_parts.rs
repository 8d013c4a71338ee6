//! The convex parts of what emits: touching faces of one plane and one material are one source, whatever is pictured on them.
//!
//! Faces end where their picture does: a sky of tiles, a pool of lava or a stained window are hundreds of faces that emit alike. Light at a
//! point is a sum over sources, each less what stands before it. So the union of such faces is taken, by its outline, and cut into convex
//! parts afresh. Where that makes no fewer parts, the faces stay as they are, bit for bit.
//!
//! Holds: the parts cover what the faces cover; each has a face of its own among them, which names it. Which faces are one source depends on
//! their materials and not on how bright these are, so that what points see of a part can be kept from bake to bake.

use glam::DVec3;

use crate::discontinuity;
use crate::id::FaceId;
use crate::prepare::{self, Prepared};
use crate::scene::Scene;

/// A convex part of emitting faces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct EmittingPart {
    /// One of its faces' group, and of no other part: it names the part.
    pub(super) face: FaceId,
    /// Its corners, counter-clockwise seen from the front, in metres.
    pub(super) corners_m: Vec<DVec3>,
}

/// The parts of all that emits, by their faces.
pub(super) fn emitting_parts(scene: &Scene, prepared: &Prepared) -> Vec<EmittingPart> {
    let material = |face: FaceId| prepared.faces[face].material;
    let emits = |face: FaceId| scene.materials[material(face)].emits();
    let alike = |one: FaceId, other: FaceId| material(one) == material(other) && emits(one);
    let mut parts: Vec<EmittingPart> = discontinuity::coplanar_groups(prepared, alike)
        .iter()
        .filter(|faces| emits(faces[0]))
        .flat_map(|faces| parts_of_group(prepared, faces))
        .collect();
    parts.sort_by_key(|part| part.face);
    parts
}

fn parts_of_group(prepared: &Prepared, faces: &[FaceId]) -> Vec<EmittingPart> {
    let as_they_are = || faces.iter().map(|&face| prepared.polygon_m(face)).collect::<Vec<_>>();
    let united = (faces.len() > 1).then(|| prepare::convex_parts(prepared, faces)).flatten();
    let polygons = united.filter(|parts| parts.len() < faces.len()).unwrap_or_else(as_they_are);
    faces.iter().zip(polygons).map(|(&face, corners_m)| EmittingPart { face, corners_m }).collect()
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;
    use crate::geometry::polygon;
    use crate::id::{ImageId, NodeId};
    use crate::prepare::prepare;
    use crate::progress::Progress;
    use crate::scene::{Image, Material, Node, Rgb, Surface, Texture, Wrap};
    use crate::transport::DirectLight;
    use crate::transport::form_factor::point_to_polygon;
    use crate::visibility::{ReceiverPoint, Visibility};

    /// A sky of `n` by `n` tiles 2 m over a floor, each with the whole picture on it; those for which `is_there` holds.
    fn tiled_sky(n: usize, is_there: impl Fn(usize, usize) -> bool) -> Scene {
        let mut scene = Scene::default();
        scene.nodes.push(Node::default());
        let image = scene.images.push_and_get_key(Image { name: None, bytes: Vec::new().into() });
        assert_eq!(image, ImageId::from(0));
        let picture = Texture { image, wrap: [Wrap::Repeat; 2], filters: [None; 2], factor: Rgb::ONE };
        let mut sky = Material::emitting("sky", Rgb::ONE);
        sky.look.texture = Some(picture);
        let [grey, sky] =
            [Material::diffuse("grey", Rgb::splat(0.5)), sky].map(|m| scene.materials.push_and_get_key(m));
        let mut floor = Surface::new(NodeId::from(0), grey);
        floor.push_polygon([[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]].map(|[x, z]| DVec3::new(x, 0.0, z)));
        scene.surfaces.push(floor);
        let mut tiles = Surface::new(NodeId::from(0), sky);
        let at = |i: usize| 4.0 * i as f64 / n as f64 - 2.0;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))).filter(|&(i, j)| is_there(i, j)) {
            let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
            tiles.push_polygon(corners.map(|[u, v]| DVec3::new(at(i + u), 2.0, at(j + v))));
            tiles.uvs.extend(corners.map(|[u, v]| DVec2::new(u as f64, v as f64)));
        }
        scene.surfaces.push(tiles);
        scene
    }

    fn parts_and_faces(scene: &Scene) -> (Vec<EmittingPart>, Prepared) {
        let prepared = prepare(scene, Progress::silent()).unwrap();
        (emitting_parts(scene, &prepared), prepared)
    }

    #[test]
    fn a_sky_of_tiles_is_one_source_with_the_light_of_one() {
        let scene = tiled_sky(8, |_, _| true);
        let (parts, prepared) = parts_and_faces(&scene);
        assert_eq!(prepared.faces.len(), 65, "the picture begins anew on each tile");
        assert_eq!(parts.len(), 1, "{parts:?}");
        let visibility = Visibility::new(&prepared);
        let light = DirectLight::new(&scene, &prepared, &visibility);
        let floor = prepared.faces.keys().find(|&face| prepared.shows_light(&scene, face)).unwrap();
        let sky = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]].map(|[x, z]| DVec3::new(x, 2.0, z));
        for at in [DVec3::ZERO, DVec3::new(0.7, 0.0, -0.3), DVec3::new(-0.9, 0.0, 0.9)] {
            let receiver = ReceiverPoint::on_face(&prepared, floor, at - prepared.origin_m);
            let exact = std::f64::consts::PI * point_to_polygon(at, DVec3::Y, &sky);
            let found = light.at(&receiver).x;
            assert!((found - exact).abs() < 1e-6 * exact, "{found} is not {exact} at {at}");
        }
    }

    #[test]
    fn parts_cover_what_tiles_do_with_holes_and_bays_and_by_few() {
        for (n, is_there, most) in [
            (6, (|i, j| !(2..4).contains(&i) || !(2..4).contains(&j)) as fn(usize, usize) -> bool, 4),
            (6, |i, j| i < 2 || j < 2, 2),
            (5, |i, j| (i + j).is_multiple_of(2), 13),
            // Two that do not touch.
            (7, |i, _| i != 3, 2),
        ] {
            let (parts, prepared) = parts_and_faces(&tiled_sky(n, is_there));
            let area = |corners: &[DVec3]| polygon::area_m2(corners);
            let whole: f64 = prepared.faces.keys().skip(1).map(|face| area(&prepared.polygon_m(face))).sum();
            let floor_is_first = area(&prepared.polygon_m(FaceId::from(0)));
            assert!((floor_is_first - 4.0).abs() < 1e-9);
            let covered: f64 = parts.iter().map(|part| area(&part.corners_m)).sum();
            assert!((covered - whole).abs() < 1e-9 * whole, "{covered} of {whole}");
            assert!(parts.len() <= most, "{} parts", parts.len());
            assert!(parts.windows(2).all(|two| two[0].face < two[1].face));
        }
    }
}
