//! The sides of a scene: its polygons as triangles, each with what its front and its back do with light.

use earcut::Earcut;
use glam::{DVec2, DVec3};
use umbrage::id::{MaterialId, SurfaceId};
use umbrage::scene::{Scene, Surface};

use crate::smooth::Corners;

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
    /// Which polygon of the scene it is of, counted over all surfaces.
    pub(crate) polygon: usize,
    /// Its corners, where it is part of a smooth surface.
    pub(crate) smooth: Option<Corners>,
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
            polygon: 0,
            smooth: None,
        })
    }

    /// The point with these coordinates in the unit square, evenly spread for evenly spread coordinates.
    pub(crate) fn point_m(&self, [s, t]: [f64; 2]) -> DVec3 {
        let root = s.sqrt();
        self.corner_m + root * (1.0 - t) * self.edges_m[0] + root * t * self.edges_m[1]
    }

    /// Distance of a point from the triangle, in metres.
    pub(crate) fn distance_m(&self, point_m: DVec3) -> f64 {
        let corners_m = self.corners_m();
        let sides = [0, 1, 2].map(|i| [corners_m[i], corners_m[(i + 1) % 3]]);
        let is_over = sides.iter().all(|[from, to]| (to - from).cross(point_m - from).dot(self.normal) >= 0.0);
        if is_over {
            return self.normal.dot(point_m - self.corner_m).abs();
        }
        let from_side = |[from, to]: [DVec3; 2]| {
            let along = to - from;
            let share = ((point_m - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            point_m.distance(from + share * along)
        };
        sides.map(from_side).into_iter().fold(f64::INFINITY, f64::min)
    }

    pub(crate) fn corners_m(&self) -> [DVec3; 3] {
        [self.corner_m, self.corner_m + self.edges_m[0], self.corner_m + self.edges_m[1]]
    }
}

/// All triangles of a scene that is valid; `normals` are those of the corners of each polygon, none where it is flat.
pub(crate) fn triangles(scene: &Scene, normals: &[Vec<DVec3>]) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    let (mut earcut, mut indices) = (Earcut::new(), Vec::<u32>::new());
    let mut count = 0;
    for (id, surface) in scene.surfaces.iter_enumerated() {
        for polygon in 0..surface.polygons.len() {
            let corners: Vec<DVec3> = scene.corners_m(id, polygon).collect();
            let doubled: DVec3 = corners.windows(2).map(|p| (p[0] - corners[0]).cross(p[1] - corners[0])).sum();
            let number = count;
            count += 1;
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
                let mut cut = [cut[0], cut[1], cut[2]].map(|i| i as usize);
                let across = (corners[cut[1]] - corners[cut[0]]).cross(corners[cut[2]] - corners[cut[0]]);
                if across.dot(normal) < 0.0 {
                    cut.swap(1, 2);
                }
                let at_m = cut.map(|i| corners[i]);
                let of_polygon = normals.get(number).filter(|normals| !normals.is_empty());
                let smooth = of_polygon.map(|normals| Corners { at_m, normals: cut.map(|i| normals[i]) });
                let triangle = Triangle::new(at_m, surface.material, 0.5 * doubled.length());
                triangles.extend(triangle.map(|triangle| Triangle { polygon: number, smooth, ..triangle }));
            }
        }
    }
    triangles
}

/// The largest side of the box around all polygons, in metres.
pub(crate) fn extent_m(scene: &Scene) -> f64 {
    let polygons = |(id, surface): (SurfaceId, &Surface)| (0..surface.polygons.len()).map(move |p| (id, p));
    let corners = || scene.surfaces.iter_enumerated().flat_map(polygons).flat_map(|(id, p)| scene.corners_m(id, p));
    let (low, high) = (corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max));
    (high - low).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::id::NodeId;
    use umbrage::scene::{Material, Node, Rgb, cornell};

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
        let triangles = triangles(&scene, &[]);
        assert_eq!(triangles.len(), 4);
        assert!((triangles.iter().map(|t| t.area_m2).sum::<f64>() - 6.0).abs() < 1e-12);
        assert!(triangles.iter().all(|t| t.normal.distance(DVec3::Z) < 1e-12 && t.polygon_area_m2 == 6.0));
    }

    #[test]
    fn the_cornell_box_has_its_triangles() {
        // 18 quadrilaterals and two triangles.
        assert_eq!(triangles(&cornell::cornell_box(), &[]).len(), 38);
    }
}
