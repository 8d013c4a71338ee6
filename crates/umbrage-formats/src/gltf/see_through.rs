//! What light passes through (`alphaMode` BLEND, `KHR_materials_transmission`): glass, curtains, leaves. It is in the output
//! as it came, in mean light; glass is blended there.

use glam::DVec3;
use serde_json::{Value, json};
use umbrage::scene::{Alpha, Rgb, Scene, Surface};

use super::write_buffer::WriteBuffer;

/// A surface in the frame of the output.
pub(super) struct SeeThrough {
    positions_m: Vec<[f32; 3]>,
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl SeeThrough {
    /// The triangles of a surface that have an area; nothing if it has none.
    pub(super) fn new(scene: &Scene, surface: &Surface, origin_m: DVec3) -> Option<Self> {
        let positions_m: Vec<[f32; 3]> =
            surface.positions_m.iter().map(|&p| (p - origin_m).as_vec3().to_array()).collect();
        let has_area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|i| DVec3::from(positions_m[i as usize].map(f64::from)));
            (b - a).cross(c - a).length_squared() > 0.0
        };
        let fan = |polygon: &Vec<u32>| -> Vec<[u32; 3]> {
            (2..polygon.len()).map(|i| [polygon[0], polygon[i - 1], polygon[i]]).collect()
        };
        let triangles: Vec<[u32; 3]> = surface.polygons.iter().flat_map(fan).filter(has_area).collect();
        // Baked materials are one-sided; what is blended is not, and what casts no shadow has the same material as what does.
        let material = &scene.materials[surface.material];
        let both = material.double_sided && !matches!(material.look.alpha, Alpha::Blend { .. });
        let backs = triangles.iter().filter(|_| both).map(|&[a, b, c]| [a, c, b]);
        let triangles: Vec<[u32; 3]> = triangles.iter().copied().chain(backs).collect();
        let shows_image = scene.materials[surface.material].look.texture.is_some();
        let uvs = if shows_image { surface.uvs.iter().map(|uv| uv.as_vec2().to_array()).collect() } else { Vec::new() };
        (!triangles.is_empty()).then_some(Self { positions_m, uvs, triangles })
    }

    /// The primitive, in this light.
    pub(super) fn primitive(&self, buffer: &mut WriteBuffer, light: Rgb, material: usize) -> Value {
        let [red, green, blue] = light.to_array().map(|channel| (channel.clamp(0.0, 1.0) * 65_535.0).round() as u16);
        let colours = vec![[red, green, blue, u16::MAX]; self.positions_m.len()];
        let mut attributes =
            json!({"POSITION": buffer.positions(&self.positions_m), "COLOR_0": buffer.colours(&colours)});
        if !self.uvs.is_empty() {
            attributes["TEXCOORD_0"] = json!(buffer.coordinates(&self.uvs));
        }
        let indices = buffer.triangles(&self.triangles);
        // Who measures the light leaves it out.
        let extras = json!({"umbrage": {"takes_part": false}});
        json!({"attributes": attributes, "indices": indices, "material": material, "extras": extras})
    }
}
