//! Light of patches from that of texels: for what asks for the hierarchy's values, such as secondary sources and the account of energy.

use super::radiosity::TexelRadiosity;
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::scene::Rgb;
use crate::solve::Solution;
use crate::transport::Linear;

/// Sums over texels of one patch.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    irradiance: Rgb,
    reflected: Rgb,
    area_m2: f64,
}

impl TexelRadiosity {
    /// The solution over the patches of a mesh: means of the texels whose points lie in them. A leaf without any has the light of the
    /// texel at its middle.
    pub(crate) fn over_patches(&self, mesh: &Mesh) -> Solution {
        let mut sums: Table<PatchId, Sums> = vec![Sums::default(); mesh.patch_count()].into();
        let light = |number: usize| {
            let irradiance = (self.direct[number] + self.indirect[number]).as_dvec3();
            (irradiance, self.reflected[number].as_dvec3())
        };
        for (number, texel) in self.grid.texels().iter().enumerate() {
            let sum = &mut sums[mesh.leaf_at(texel.face, texel.point_m)];
            let (irradiance, reflected) = light(number);
            sum.irradiance += texel.area_m2 * irradiance;
            sum.reflected += texel.area_m2 * reflected;
            sum.area_m2 += texel.area_m2;
        }
        for (id, patch) in mesh.patches().filter(|(_, patch)| patch.subpatches.is_none()) {
            if sums[id].area_m2 <= 0.0 {
                let (irradiance, reflected) = light(self.grid.texel_at(patch.face, patch.centroid_m.as_vec3()));
                sums[id] = Sums { irradiance, reflected, area_m2: 1.0 };
            }
        }
        // The parts of a patch come after it.
        let mut means: Table<PatchId, [Rgb; 2]> = vec![[Rgb::ZERO; 2]; mesh.patch_count()].into();
        for index in (0..mesh.patch_count()).rev() {
            let id = PatchId::from(index);
            means[id] = match mesh.patch(id).subpatches {
                None => [sums[id].irradiance, sums[id].reflected].map(|sum| sum / sums[id].area_m2),
                Some(parts) => {
                    let area_m2: f64 = parts.iter().map(|&part| mesh.patch(part).area_m2).sum();
                    let mean = |k: usize| {
                        let sum: Rgb = parts.iter().map(|&part| mesh.patch(part).area_m2 * means[part][k]).sum();
                        sum / area_m2.max(f64::MIN_POSITIVE)
                    };
                    [mean(0), mean(1)]
                }
            };
        }
        let even = |k: usize| means.iter().map(|mean| Linear { mean: mean[k], ..Linear::default() }).collect();
        Solution { irradiance: even(0), reflected: even(1), residual: self.residual, iterations: self.bounces }
    }
}
