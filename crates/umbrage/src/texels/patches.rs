//! Light of patches from that of texels: for what asks for the hierarchy's values, such as secondary sources and the account of energy.

use super::radiosity::TexelRadiosity;
use crate::id::{FaceId, PatchId, Table};
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
    /// texel at its middle. Leaves may be smaller than texels, and may lie where a texel is half lit: so they are scaled until a face
    /// has the light of its texels.
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
        self.keep_light_of_faces(mesh, &mut sums);
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

    /// Scales the light of the leaves of each face until it is that of its texels.
    fn keep_light_of_faces(&self, mesh: &Mesh, sums: &mut Table<PatchId, Sums>) {
        let mut of_texels: Table<FaceId, [Rgb; 2]> = vec![[Rgb::ZERO; 2]; self.reflectance.len()].into();
        let mut of_leaves = of_texels.clone();
        for (number, texel) in self.grid.texels().iter().enumerate() {
            let light = self.direct[number] + self.indirect[number];
            let [irradiance_w, reflected_w] = &mut of_texels[texel.face];
            *irradiance_w += texel.area_m2 * light.as_dvec3();
            *reflected_w += texel.area_m2 * self.reflected[number].as_dvec3();
        }
        for leaf in mesh.leaves() {
            let (patch, sum) = (mesh.patch(leaf), &sums[leaf]);
            let [irradiance_w, reflected_w] = &mut of_leaves[patch.face];
            *irradiance_w += patch.area_m2 / sum.area_m2 * sum.irradiance;
            *reflected_w += patch.area_m2 / sum.area_m2 * sum.reflected;
        }
        for leaf in mesh.leaves() {
            let face = mesh.patch(leaf).face;
            let scale = |k: usize| {
                let (texels_w, leaves_w) = (of_texels[face][k], of_leaves[face][k]);
                Rgb::from_array([0, 1, 2].map(|c| if leaves_w[c] > 0.0 { texels_w[c] / leaves_w[c] } else { 1.0 }))
            };
            sums[leaf].irradiance *= scale(0);
            sums[leaf].reflected *= scale(1);
        }
    }
}
