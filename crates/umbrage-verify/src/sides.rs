//! The sides of a scene: its polygons as triangles, each with what its front and its back do with light.

use earcut::Earcut;
use glam::{DVec2, DVec3};
use umbrage::id::MaterialId;
use umbrage::scene::Scene;

/// A triangle of a polygon of the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    pub(crate) corner_m: DVec3,
    /// From the first corner to the second and to the third, in metres.
    pub(crate) edges_m: [DVec3; 2],
    /// Unit normal of the polygon's front.
    pub(crate) normal: DVec3,
    pub(crate) area_m2: f64,
    pub(crate) material: MaterialId,
    /// Area of the whole polygon: of polygons in one place the smallest is seen.
    pub(crate) polygon_area_m2: f64,
}

impl Triangle {
    fn new(corners_m: [DVec3; 3], material: MaterialId, polygon_area_m2: f64) -> Option<Self> {
        let edges_m = [corners_m[1] - corners_m[0], corners_m[2] - corners_m[0]];
        let across = edges_m[0].cross(edges_m[1]);
        let normal = across.try_normalize()?;
        Some(Self {
            corner_m: corners_m[0],
            edges_m,
            normal,
            area_m2: 0.5 * across.length(),
            material,
            polygon_area_m2,
        })
    }

    /// The point with these coordinates in the unit square, evenly spread for evenly spread coordinates.
    pub(crate) fn point_m(&self, [s, t]: [f64; 2]) -> DVec3 {
        let root = s.sqrt();
        self.corner_m + root * (1.0 - t) * self.edges_m[0] + root * t * self.edges_m[1]
    }

    pub(crate) fn corners_m(&self) -> [DVec3; 3] {
        [self.corner_m, self.corner_m + self.edges_m[0], self.corner_m + self.edges_m[1]]
    }
}

/// All triangles of a scene that is valid.
pub(crate) fn triangles(scene: &Scene) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    let (mut earcut, mut indices) = (Earcut::new(), Vec::<u32>::new());
    for (id, surface) in scene.surfaces.iter_enumerated() {
        for polygon in 0..surface.polygons.len() {
            let corners: Vec<DVec3> = scene.corners_m(id, polygon).collect();
            let doubled: DVec3 = corners.windows(2).map(|p| (p[0] - corners[0]).cross(p[1] - corners[0])).sum();
            let Some(normal) = doubled.try_normalize() else { continue };
            match corners[..] {
                [_, _, _] => indices.splice(.., [0, 1, 2]).for_each(drop),
                _ => {
                    let (u, v) = normal.any_orthonormal_pair();
                    let flat =
                        corners.iter().map(|p| p - corners[0]).map(|d| DVec2::new(d.dot(u), d.dot(v)).to_array());
                    earcut.earcut(flat, &[], &mut indices);
                }
            }
            for cut in indices.chunks_exact(3) {
                let mut three = [cut[0], cut[1], cut[2]].map(|i| corners[i as usize]);
                if (three[1] - three[0]).cross(three[2] - three[0]).dot(normal) < 0.0 {
                    three.swap(1, 2);
                }
                triangles.extend(Triangle::new(three, surface.material, 0.5 * doubled.length()));
            }
        }
    }
    triangles
}

/// The largest side of the box around all triangles, in metres.
pub(crate) fn extent_m(triangles: &[Triangle]) -> f64 {
    let corners = || triangles.iter().flat_map(Triangle::corners_m);
    let (low, high) = (corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max));
    (high - low).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::id::NodeId;
    use umbrage::scene::{Material, Node, Rgb, Surface, cornell};

    #[test]
    fn a_concave_polygon_keeps_its_area_and_its_front() {
        let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)];
        let mut scene = Scene::default();
        scene.nodes.push(Node::default());
        let material = scene.materials.push_and_get_key(Material::diffuse("grey", Rgb::ONE));
        scene.surfaces.push(Surface {
            positions_m: corners.map(|(x, y)| DVec3::new(x, y, 2.0)).to_vec(),
            polygons: vec![(0..6).collect()],
            ..Surface::new(NodeId::from(0), material)
        });
        let triangles = triangles(&scene);
        assert_eq!(triangles.len(), 4);
        assert!((triangles.iter().map(|t| t.area_m2).sum::<f64>() - 6.0).abs() < 1e-12);
        assert!(triangles.iter().all(|t| t.normal.distance(DVec3::Z) < 1e-12 && t.polygon_area_m2 == 6.0));
    }

    #[test]
    fn the_cornell_box_has_its_triangles() {
        // 18 quadrilaterals and two triangles.
        assert_eq!(triangles(&cornell::cornell_box()).len(), 38);
    }
}
