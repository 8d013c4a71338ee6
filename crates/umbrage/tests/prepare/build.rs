//! Scenes written in a few lines.

use glam::DVec3;
use umbrage::id::{MaterialId, NodeId, SurfaceId};
use umbrage::scene::{Material, Node, Rgb, Scene, Surface};

/// A scene that grows polygon by polygon; one surface for each material.
pub(crate) struct Build(pub Scene);

pub(crate) const WHITE: usize = 0;
pub(crate) const RED: usize = 1;
/// A double-sided material.
pub(crate) const SHEET: usize = 2;

impl Build {
    pub(crate) fn new() -> Self {
        let mut scene = Scene::default();
        scene.nodes.push(Node { name: Some("test".into()), ..Node::default() });
        for name in ["white", "red", "sheet"] {
            let mut material = Material::diffuse(name, Rgb::splat(0.5));
            material.double_sided = name == "sheet";
            let material: MaterialId = scene.materials.push_and_get_key(material);
            let node = NodeId::from(0);
            scene.surfaces.push(Surface::new(node, material));
        }
        Self(scene)
    }

    pub(crate) fn polygon(&mut self, material: usize, corners: &[[f64; 3]]) -> &mut Self {
        self.0.surfaces[SurfaceId::from(material)].push_polygon(corners.iter().map(|&c| DVec3::from(c)));
        self
    }

    /// A rectangle at height `y` that looks up.
    pub(crate) fn floor(&mut self, material: usize, [x0, z0, x1, z1]: [f64; 4], y: f64) -> &mut Self {
        self.polygon(material, &[[x0, y, z0], [x0, y, z1], [x1, y, z1], [x1, y, z0]])
    }

    /// A rectangle at depth `z` that looks along +z.
    pub(crate) fn wall(&mut self, material: usize, [x0, y0, x1, y1]: [f64; 4], z: f64) -> &mut Self {
        self.polygon(material, &[[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]])
    }

    /// The outer sides of a box; its bottom on request.
    pub(crate) fn block(&mut self, material: usize, low: [f64; 3], high: [f64; 3], bottom: bool) -> &mut Self {
        let p = |i: usize, j: usize, k: usize| [[low, high][i][0], [low, high][j][1], [low, high][k][2]];
        self.polygon(material, &[p(0, 1, 0), p(0, 1, 1), p(1, 1, 1), p(1, 1, 0)]);
        self.polygon(material, &[p(0, 0, 1), p(1, 0, 1), p(1, 1, 1), p(0, 1, 1)]);
        self.polygon(material, &[p(1, 0, 0), p(0, 0, 0), p(0, 1, 0), p(1, 1, 0)]);
        self.polygon(material, &[p(1, 0, 1), p(1, 0, 0), p(1, 1, 0), p(1, 1, 1)]);
        self.polygon(material, &[p(0, 0, 0), p(0, 0, 1), p(0, 1, 1), p(0, 1, 0)]);
        if bottom {
            self.polygon(material, &[p(0, 0, 0), p(1, 0, 0), p(1, 0, 1), p(0, 0, 1)]);
        }
        self
    }

    /// The same scene with every corner moved.
    pub(crate) fn moved(&self, to: impl Fn(DVec3) -> DVec3) -> Scene {
        let mut scene = self.0.clone();
        scene.surfaces.iter_mut().flat_map(|s| &mut s.positions_m).for_each(|p| *p = to(*p));
        scene
    }
}
