//! A baked GLB, read back: what a picture, a viewer or a measurement needs of it.
//!
//! Holds, for every [`BakedFile`] that this crate returns:
//! - the vertex tables of a part have one length, and no triangle refers beyond them;
//! - all numbers are finite, `color` and `base_color` lie between 0 and 1;
//! - a part that refers to an image refers to one that there is, and has a place in it for every vertex;
//! - of a file that this crate wrote and nobody altered, positions and irradiance have the bits that were written.

use std::f64::consts::PI;

use glam::DVec3;
use serde_json::{Map, Value};
use umbrage::scene::Wrap;

/// An image on the surface of a part: it multiplies the base colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakedTexture {
    /// Its number among the file's images.
    pub image: usize,
    /// What it does beyond its border, along u and along v.
    pub wrap: [Wrap; 2],
}

/// What the material of an emitter was before the bake, which its clipped colours do not tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakedEmission {
    /// Emitted radiance, linear RGB, in W/(m2 sr).
    pub radiance: [f64; 3],
    /// Reflectance, linear RGB, 0 to 1.
    pub reflectance: [f64; 3],
}

/// A perspective camera of a baked file.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedCamera {
    /// Name of its node, or its own; empty if neither has one.
    pub name: String,
    /// Where it stands in the world, in metres.
    pub eye_m: DVec3,
    /// Unit vector along which it looks.
    pub ahead: DVec3,
    /// Unit vector that is up in its picture, unless the node is sheared at a right angle to `ahead`.
    pub up: DVec3,
    /// Field of view from the lower to the upper edge of the picture, in degrees.
    pub fov_y_deg: f64,
}

/// One primitive of a baked file: the triangles of one surface.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedFilePart {
    /// Name of the node that it hangs from; empty if it has none.
    pub node_name: String,
    /// Name of its mesh; empty if it has none.
    pub name: String,
    /// Name of its material; empty if it has none.
    pub material_name: String,
    /// Vertices in world space relative to the file's `origin_m`, in metres.
    pub positions_m: Vec<[f32; 3]>,
    /// Unit normal of each vertex, in world space.
    pub normals: Vec<[f32; 3]>,
    /// `COLOR_0`: linear RGB and alpha, 0 to 1; `clamp(k E / pi)` where the surface only reflects.
    pub color: Vec<[f32; 4]>,
    /// `baseColorFactor` of its material, linear RGB and alpha, 0 to 1. The colour shown is `base_color * color`, times
    /// the texture.
    pub base_color: [f32; 4],
    /// Its base colour texture.
    pub texture: Option<BakedTexture>,
    /// Where the alpha of the texture is less, nothing is shown (`alphaMode` MASK); `None` shows all.
    pub cutoff: Option<f32>,
    /// Where each vertex lies in the texture, (0, 0) being its upper left corner; empty without texture.
    pub uvs: Vec<[f32; 2]>,
    /// What its material emitted; `None` if it only reflects.
    pub emission: Option<BakedEmission>,
    /// `_IRRADIANCE`: irradiance on the front at each vertex, linear RGB, in W/m2.
    pub irradiance: Vec<[f32; 3]>,
    /// Triangles, counter-clockwise seen from the front.
    pub triangles: Vec<[u32; 3]>,
}

/// A baked GLB.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedFile {
    /// Name of the scene; empty if it has none.
    pub name: String,
    /// What is added to a position to place it in the world, in metres.
    pub origin_m: DVec3,
    /// The primitives, in the order of the file's nodes.
    pub parts: Vec<BakedFilePart>,
    /// Its perspective cameras, in the order of the file's nodes.
    pub cameras: Vec<BakedCamera>,
    /// Its images, as the files that they are (PNG, JPEG); empty where no part refers to it.
    pub images: Vec<Vec<u8>>,
    /// The exposure `k`, per W/(m2 sr): `COLOR_0 = clamp(k E / pi)`.
    pub exposure_k: f64,
    /// Whether irradiance is in lux, and not in W/m2.
    pub photometric: bool,
    /// All that the bake left in `asset.extras.umbrage`.
    pub extras: Map<String, Value>,
}

impl BakedFilePart {
    /// What the base colour and texture are multiplied with at each vertex, without the cut at white that a file's
    /// `COLOR_0` needs: linear RGB, 0 or more. `exposure_k` is the file's.
    ///
    /// Where `COLOR_0` is not cut off it is the value. Where it is, a surface that only reflects has at least `k E / pi`;
    /// an emitter has what its radiance and reflectance say.
    pub fn light(&self, exposure_k: f64) -> Vec<[f32; 3]> {
        let at = |vertex: usize| {
            std::array::from_fn(|channel| {
                self.light_of(vertex, channel, exposure_k).clamp(0.0, f64::from(f32::MAX)) as f32
            })
        };
        (0..self.color.len()).map(at).collect()
    }

    fn light_of(&self, vertex: usize, channel: usize, exposure_k: f64) -> f64 {
        let color = f64::from(self.color[vertex][channel]);
        let reflected = exposure_k * f64::from(self.irradiance[vertex][channel]) / PI;
        let base = f64::from(self.base_color[channel]);
        match self.emission {
            Some(_) if base == 0.0 => color,
            Some(emission) => {
                (exposure_k * emission.radiance[channel] + emission.reflectance[channel] * reflected) / base
            }
            None if color < 1.0 => color,
            None => reflected.max(1.0),
        }
    }
}

impl BakedFile {
    /// Number of triangles of all parts.
    pub fn triangle_count(&self) -> usize {
        self.parts.iter().map(|part| part.triangles.len()).sum()
    }

    /// What the irradiance, as the sum of its channels times `weights`, does not exceed on `share` (0 to 1) of the area,
    /// in W/m2; 0 without triangles.
    pub fn irradiance_quantile(&self, share: f64, weights: [f32; 3]) -> f64 {
        let mut corners = Vec::new();
        for part in &self.parts {
            for triangle in &part.triangles {
                let [a, b, c] = triangle.map(|v| DVec3::from(part.positions_m[v as usize].map(f64::from)));
                let third_m2 = (b - a).cross(c - a).length() / 6.0;
                corners.extend(triangle.map(|v| {
                    let weighted = part.irradiance[v as usize].iter().zip(weights).map(|(e, w)| f64::from(e * w));
                    (weighted.sum::<f64>(), third_m2)
                }));
            }
        }
        corners.sort_by(|x, y| x.0.total_cmp(&y.0));
        let wanted_m2 = share * corners.iter().map(|(_, area_m2)| area_m2).sum::<f64>();
        let mut below_m2 = 0.0;
        let found = corners.iter().find(|(_, area_m2)| {
            below_m2 += area_m2;
            below_m2 >= wanted_m2
        });
        found.or(corners.last()).map_or(0.0, |(value, _)| *value)
    }

    /// Number of vertices of all parts.
    pub fn vertex_count(&self) -> usize {
        self.parts.iter().map(|part| part.positions_m.len()).sum()
    }
}
