//! The Cornell box as it was measured: the built-in scene.
//!
//! Geometry of the Cornell University Program of Computer Graphics (the box's published measurements, here in metres);
//! the left wall is not plane and is two triangles, the blocks have no bottom, the ceiling surrounds the light.
//! Reflectances and the light are the usual RGB reduction of the measured spectra.

use glam::DVec3;

use super::{Material, Node, Rgb, Scene, Surface};
use crate::id::{MaterialId, NodeId};

/// Corners of a polygon, in metres, +Y up.
type Corners = &'static [[f64; 3]];

const WHITE: &[Corners] = &[
    &[[0.5528, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.5592], [0.5496, 0.0, 0.5592]],
    &[[0.556, 0.5488, 0.0], [0.556, 0.5488, 0.5592], [0.343, 0.5488, 0.332], [0.343, 0.5488, 0.227]],
    &[[0.556, 0.5488, 0.5592], [0.0, 0.5488, 0.5592], [0.213, 0.5488, 0.332], [0.343, 0.5488, 0.332]],
    &[[0.0, 0.5488, 0.5592], [0.0, 0.5488, 0.0], [0.213, 0.5488, 0.227], [0.213, 0.5488, 0.332]],
    &[[0.0, 0.5488, 0.0], [0.556, 0.5488, 0.0], [0.343, 0.5488, 0.227], [0.213, 0.5488, 0.227]],
    &[[0.5496, 0.0, 0.5592], [0.0, 0.0, 0.5592], [0.0, 0.5488, 0.5592], [0.556, 0.5488, 0.5592]],
    &[[0.13, 0.165, 0.065], [0.082, 0.165, 0.225], [0.24, 0.165, 0.272], [0.29, 0.165, 0.114]],
    &[[0.29, 0.0, 0.114], [0.29, 0.165, 0.114], [0.24, 0.165, 0.272], [0.24, 0.0, 0.272]],
    &[[0.13, 0.0, 0.065], [0.13, 0.165, 0.065], [0.29, 0.165, 0.114], [0.29, 0.0, 0.114]],
    &[[0.082, 0.0, 0.225], [0.082, 0.165, 0.225], [0.13, 0.165, 0.065], [0.13, 0.0, 0.065]],
    &[[0.24, 0.0, 0.272], [0.24, 0.165, 0.272], [0.082, 0.165, 0.225], [0.082, 0.0, 0.225]],
    &[[0.423, 0.33, 0.247], [0.265, 0.33, 0.296], [0.314, 0.33, 0.456], [0.472, 0.33, 0.406]],
    &[[0.423, 0.0, 0.247], [0.423, 0.33, 0.247], [0.472, 0.33, 0.406], [0.472, 0.0, 0.406]],
    &[[0.472, 0.0, 0.406], [0.472, 0.33, 0.406], [0.314, 0.33, 0.456], [0.314, 0.0, 0.456]],
    &[[0.314, 0.0, 0.456], [0.314, 0.33, 0.456], [0.265, 0.33, 0.296], [0.265, 0.0, 0.296]],
    &[[0.265, 0.0, 0.296], [0.265, 0.33, 0.296], [0.423, 0.33, 0.247], [0.423, 0.0, 0.247]],
];

const RED: &[Corners] = &[
    &[[0.5528, 0.0, 0.0], [0.5496, 0.0, 0.5592], [0.556, 0.5488, 0.5592]],
    &[[0.5528, 0.0, 0.0], [0.556, 0.5488, 0.5592], [0.556, 0.5488, 0.0]],
];

const GREEN: &[Corners] = &[&[[0.0, 0.0, 0.5592], [0.0, 0.0, 0.0], [0.0, 0.5488, 0.0], [0.0, 0.5488, 0.5592]]];

const LIGHT: &[Corners] =
    &[&[[0.343, 0.5488, 0.227], [0.343, 0.5488, 0.332], [0.213, 0.5488, 0.332], [0.213, 0.5488, 0.227]]];

/// The measured Cornell box: 20 polygons, one of them the light.
pub fn cornell_box() -> Scene {
    let parts = [
        (Material::diffuse("white", Rgb::splat(0.73)), WHITE),
        (Material::diffuse("red", Rgb::new(0.63, 0.06, 0.04)), RED),
        (Material::diffuse("green", Rgb::new(0.14, 0.45, 0.09)), GREEN),
        (Material::emitting("light", Rgb::new(18.387, 13.9873, 6.75357)), LIGHT),
    ];
    let mut scene = Scene { name: "cornell".into(), ..Scene::default() };
    scene.nodes.push(Node { name: Some("cornell".into()), mesh_name: Some("cornell".into()), ..Node::default() });
    for (material, polygons) in parts {
        let material: MaterialId = scene.materials.push_and_get_key(material);
        let mut surface = Surface::new(NodeId::from(0), material);
        for corners in polygons {
            surface.push_polygon(corners.iter().map(|&c| DVec3::from(c)));
        }
        scene.surfaces.push(surface);
    }
    scene
}
