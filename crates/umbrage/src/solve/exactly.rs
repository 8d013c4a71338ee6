//! One bounce of light whose arrival on the leaves is known exactly, and what links miss of it.

use super::gather::gather;
use super::iterate::{Solution, linear};
use super::push_pull::{pull, push};
use super::surfaces::Surfaces;
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::scene::Rgb;
use crate::transport::{Linear, Links};

/// What patches reflect where leaves receive `irradiance`, in W/m2. Its residual is that of `before`.
pub fn reflect(mesh: &Mesh, surfaces: &Surfaces, irradiance: &[(PatchId, Linear<Rgb>)], before: &Solution) -> Solution {
    let mut arriving = Table::from(vec![Linear::default(); mesh.patch_count()]);
    for &(leaf, exactly) in irradiance {
        arriving[leaf] = exactly;
    }
    let (irradiance, moments) = pull(mesh, surfaces, arriving);
    let reflected = moments.iter_enumerated().map(|(id, node)| linear(surfaces, id, node)).collect();
    Solution { reflected, irradiance, residual: before.residual, iterations: before.iterations + 1 }
}

/// What links miss of what the leaves receive in `solution`: with it in [`Surfaces::missed`], the solution over links is this one.
pub fn missed(mesh: &Mesh, surfaces: &Surfaces, links: &Links, solution: &Solution) -> Table<PatchId, Linear<Rgb>> {
    let nothing = Surfaces { missed: vec![Linear::default(); mesh.patch_count()].into(), ..surfaces.clone() };
    let (_, moments) = pull(mesh, surfaces, solution.irradiance.clone());
    let over_links = push(mesh, &nothing, gather(links, &moments));
    let mut missed = nothing.missed;
    for leaf in mesh.leaves() {
        missed[leaf] = solution.irradiance[leaf] - over_links[leaf];
    }
    missed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshSettings;
    use crate::progress::Progress;
    use crate::scene::Material;
    use crate::solve::{SolveSettings, solve};
    use crate::transport::{DirectLight, FormFactorOracle, link_all};
    use crate::visibility::{Visibility, fixture};
    use glam::DVec3;

    #[test]
    fn with_what_they_miss_links_have_the_solution_that_is_asked_of_them() {
        let room: Vec<_> =
            fixture::inward_box(DVec3::ZERO, DVec3::new(1.0, 2.0, 0.5)).into_iter().map(|p| (p, 0)).collect();
        let scene = fixture::scene(vec![Material::diffuse("grey", Rgb::new(0.8, 0.5, 0.1))]);
        let prepared = fixture::prepared_of_materials(&room);
        let index = Visibility::new(&prepared);
        let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let coplanar_m = prepared.tolerance.coplanar_m();
        let oracle = FormFactorOracle { max_form_factor: 0.1, min_area_m2: 0.02, coplanar_m };
        let links = link_all(&prepared, &index, &mut mesh, &oracle, Progress::silent()).unwrap();
        // A leaf that came after the links.
        let first = mesh.leaves().next().unwrap();
        assert!(mesh.split(first));
        let direct = DirectLight::new(&scene, &prepared, &index);
        let mut surfaces = Surfaces::new(&scene, &prepared, &mesh, &direct);
        let asked: Vec<(PatchId, Linear<Rgb>)> = mesh
            .leaves()
            .map(|leaf| {
                let bright = 1.0 + 0.9 * (leaf.index() as f64).sin();
                (leaf, Linear { mean: Rgb::splat(bright), gradient: [Rgb::splat(0.3 * bright), Rgb::ZERO] })
            })
            .collect();
        let settings = SolveSettings { max_residual: 1e-9, max_iterations: 200 };
        let before = solve(&mesh, &surfaces, &links, settings, Progress::silent()).unwrap();
        let exact = reflect(&mesh, &surfaces, &asked, &before);
        surfaces.missed = missed(&mesh, &surfaces, &links, &exact);
        let over_links = solve(&mesh, &surfaces, &links, settings, Progress::silent()).unwrap();
        for (leaf, light) in asked {
            let found = over_links.irradiance[leaf];
            assert!((found.mean - light.mean).abs().max_element() < 1e-6, "{leaf:?}: {found:?} is not {light:?}");
            assert!((found.gradient[0] - light.gradient[0]).abs().max_element() < 1e-6, "{leaf:?}: {found:?}");
        }
        assert!(over_links.relative_change(&mesh, &exact) < 1e-6);
    }
}
