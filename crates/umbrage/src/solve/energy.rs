//! The account of energy: what is emitted is absorbed, or leaves the scene, or falls on the backs of surfaces.
//!
//! What is absorbed is what the solution says arrives, times what is not reflected. What leaves is found apart from that, by
//! following rays: the power that all leaves radiate is cut into equal portions, and each is sent from a point of its leaf in a
//! direction of its hemisphere (Lambert's cosine). What meets no face has left; what meets the back of a face first is lost on
//! it, since backs block light and give none. So the two sides of the account share nothing but the radiosity, and their
//! difference is an error of the solution, besides the small one of the rays; in a closed scene no ray leaves, and it is that of
//! the solution alone.
//!
//! The points and directions are those of a lattice in four dimensions, the multiples of the powers of the generalised golden
//! ratio (Roberts, *The unreasonable effectiveness of quasirandom sequences*, 2018): spread more evenly than chance does, and
//! the same every time.

use rayon::prelude::*;

use super::{Solution, Surfaces};
use crate::geometry::polygon;
use crate::id::{FaceId, PatchId};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::scene::Rgb;
use crate::transport::{DirectLight, cosine_direction};
use crate::visibility::Visibility;

/// Rays that are followed in all: what leaves is then known to about a thousandth of itself.
const RAYS: usize = 1 << 16;
/// The positive root of `x^5 = x + 1`.
const GOLDEN: f64 = 1.167_303_978_261_418_7;
/// A ray of this many extents from anywhere inside the scene leaves it.
const OUTSIDE_EXTENTS: f64 = 2.0;

/// Where the light of a scene comes from and where it goes, in watts of each colour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyAccount {
    /// What surfaces emit, and what lamps without extent bring to the fronts of surfaces: their light that passes by the scene
    /// is in no account.
    pub emitted_w: Rgb,
    /// What the fronts of surfaces absorb.
    pub absorbed_w: Rgb,
    /// What falls on the backs of surfaces, which reflect nothing.
    pub on_backs_w: Rgb,
    /// What leaves the scene.
    pub leaving_w: Rgb,
}

impl EnergyAccount {
    /// Takes the account of a solution.
    pub fn new(
        prepared: &Prepared,
        visibility: &Visibility,
        mesh: &Mesh,
        surfaces: &Surfaces,
        direct: &DirectLight<'_>,
        solution: &Solution,
    ) -> Self {
        let leaves: Vec<PatchId> = mesh.leaves().collect();
        let area_m2 = |leaf: PatchId| mesh.patch(leaf).area_m2;
        let sum = |of: &dyn Fn(PatchId) -> Rgb| leaves.iter().map(|&leaf| area_m2(leaf) * of(leaf)).sum::<Rgb>();
        let lamps = direct.of_lamps_over_leaves(mesh);
        let mut account = Self {
            emitted_w: sum(&|leaf| surfaces.exitance[leaf] + lamps[leaf].mean),
            absorbed_w: sum(&|leaf| (Rgb::ONE - surfaces.reflectance[leaf]) * solution.irradiance[leaf].mean),
            ..Self::default()
        };
        let radiosity = |leaf: PatchId| surfaces.exitance[leaf] + solution.reflected[leaf].mean;
        let power = |leaf: PatchId| area_m2(leaf) * radiosity(leaf).element_sum();
        // Where the portions of each leaf end.
        let mut end = 0.0;
        let ends: Vec<f64> = leaves
            .iter()
            .map(|&leaf| {
                end += power(leaf);
                end
            })
            .collect();
        if end <= 0.0 {
            return account;
        }
        let portion = end / RAYS as f64;
        let fates: Vec<Option<(PatchId, Fate)>> = (0..RAYS)
            .into_par_iter()
            .map(|number| {
                let at = portion * (number as f64 + 0.5);
                let leaf = *leaves.get(ends.partition_point(|&end| end <= at))?;
                Some((leaf, fate(prepared, visibility, mesh, leaf, number)))
            })
            .collect();
        for (leaf, fate) in fates.into_iter().flatten() {
            let radiosity = radiosity(leaf);
            let power_w = portion / radiosity.element_sum() * radiosity;
            match fate {
                Fate::OnFront => {}
                Fate::OnBack => account.on_backs_w += power_w,
                Fate::Leaving => account.leaving_w += power_w,
            }
        }
        account
    }

    /// By how much more goes than comes, as a share of what is emitted, in the worst channel; below 0 light is lost.
    pub fn error(&self) -> f64 {
        let surplus_w = self.absorbed_w + self.on_backs_w + self.leaving_w - self.emitted_w;
        (0..3)
            .filter(|&channel| self.emitted_w[channel] > 0.0)
            .map(|channel| surplus_w[channel] / self.emitted_w[channel])
            .fold(0.0, |worst: f64, error| if error.abs() > worst.abs() { error } else { worst })
    }
}

/// What becomes of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    OnFront,
    OnBack,
    Leaving,
}

/// Follows a ray from a leaf.
fn fate(prepared: &Prepared, visibility: &Visibility, mesh: &Mesh, leaf: PatchId, number: usize) -> Fate {
    let face = mesh.patch(leaf).face;
    let [s, t, u, v] = lattice(number);
    let from_m = polygon::point_of(&mesh.polygon_m(leaf), s, t);
    let to_m = from_m + OUTSIDE_EXTENTS * prepared.tolerance.extent_m * cosine_direction(prepared.normal(face), u, v);
    let crossing = |other: FaceId| {
        let plane = prepared.oriented_plane(other);
        let [before_m, behind_m] = [from_m, to_m].map(|end| plane.signed_distance_m(end));
        (before_m / (before_m - behind_m), before_m < 0.0)
    };
    // Of the two faces of a double-sided one the front is met first.
    let slack = prepared.tolerance.coplanar_m() / from_m.distance(to_m);
    let first = visibility
        .crossed(from_m, to_m, prepared.faces[face].plane)
        .into_iter()
        .map(crossing)
        .map(|(at, back)| (if back { at + slack } else { at }, back))
        .reduce(|first, next| if next.0 < first.0 { next } else { first });
    match first {
        None => Fate::Leaving,
        Some((_, true)) => Fate::OnBack,
        Some((_, false)) => Fate::OnFront,
    }
}

/// A point of the unit cube of four dimensions.
fn lattice(number: usize) -> [f64; 4] {
    [1, 2, 3, 4].map(|power| (0.5 + number as f64 / GOLDEN.powi(power)).fract())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::Table;
    use crate::mesh::MeshSettings;
    use crate::progress::Progress;
    use crate::scene::{Lamp, LampKind, Material, Scene};
    use crate::solve::{SolveSettings, solve};
    use crate::transport::{FormFactorOracle, link_all};
    use crate::visibility::fixture::{self, square};
    use glam::DVec3;

    fn account(polygons: &[(Vec<DVec3>, usize)], scene: &Scene) -> EnergyAccount {
        let prepared = fixture::prepared_of_materials(polygons);
        let visibility = Visibility::new(&prepared);
        let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let coplanar_m = prepared.tolerance.coplanar_m();
        let oracle = FormFactorOracle { max_form_factor: 0.02, min_area_m2: 0.002, coplanar_m };
        let links = link_all(&prepared, &visibility, &mut mesh, &oracle, Progress::silent()).unwrap();
        let direct = DirectLight::new(scene, &prepared, &visibility);
        let surfaces = Surfaces::new(scene, &prepared, &mesh, &direct);
        let settings = SolveSettings { max_residual: 1e-7, max_iterations: 99 };
        let solution = solve(&mesh, &surfaces, &links, settings, Progress::silent()).unwrap();
        EnergyAccount::new(&prepared, &visibility, &mesh, &surfaces, &direct, &solution)
    }

    fn black_and_lamp() -> Scene {
        fixture::scene(vec![
            Material::diffuse("black", Rgb::ZERO),
            Material::emitting("lamp", Rgb::ONE / std::f64::consts::PI),
        ])
    }

    #[test]
    fn of_a_closed_room_nothing_leaves() {
        let glow = Material { reflectance: Rgb::splat(0.5), ..Material::emitting("glow", Rgb::ONE) };
        let room: Vec<_> = fixture::inward_box(DVec3::ZERO, DVec3::new(1.0, 2.0, 1.5));
        let room: Vec<_> = room.into_iter().map(|wall| (wall, 0)).collect();
        let account = account(&room, &fixture::scene(vec![glow]));
        assert_eq!((account.leaving_w, account.on_backs_w), (Rgb::ZERO, Rgb::ZERO));
        let area_m2 = 2.0 * (2.0 + 3.0 + 1.5);
        assert!((account.emitted_w - std::f64::consts::PI * area_m2).abs().max_element() < 1e-9, "{account:?}");
        assert!(account.error().abs() < 1e-3, "{}", account.error());
    }

    #[test]
    fn of_two_squares_in_the_open_as_much_leaves_as_they_do_not_see_of_one_another() {
        // Unit squares at distance 1, both black, one of which emits 1 W.
        const FACTOR: f64 = 0.199_824_895_7;
        let pair = [(square(DVec3::ZERO, 0.5, true), 0), (square(DVec3::Z, 0.5, false), 1)];
        let account = account(&pair, &black_and_lamp());
        assert!((account.emitted_w.x - 1.0).abs() < 1e-6);
        assert!((account.absorbed_w.x - FACTOR).abs() < 2e-5, "{account:?}");
        assert!((account.leaving_w.x - (1.0 - FACTOR)).abs() < 1e-3, "{account:?}");
        assert_eq!(account.on_backs_w, Rgb::ZERO);
    }

    #[test]
    fn what_falls_on_backs_is_told_apart() {
        // The lower square looks away.
        const FACTOR: f64 = 0.199_824_895_7;
        let pair = [(square(DVec3::ZERO, 0.5, false), 0), (square(DVec3::Z, 0.5, false), 1)];
        let account = account(&pair, &black_and_lamp());
        assert_eq!(account.absorbed_w, Rgb::ZERO);
        assert!((account.on_backs_w.x - FACTOR).abs() < 1e-3, "{account:?}");
        assert!((account.leaving_w.x - (1.0 - FACTOR)).abs() < 1e-3, "{account:?}");
    }

    #[test]
    fn of_a_lamp_that_patches_cannot_resolve_black_walls_absorb_it_all() {
        // 2 mm wide, 2 mm over a floor whose patches are some centimetres.
        let walls = fixture::inward_box(DVec3::ZERO, DVec3::ONE);
        let mut room: Vec<_> = walls.into_iter().map(|wall| (wall, 0)).collect();
        room.push((square(DVec3::new(0.43, 0.61, 0.002), 0.001, false), 1));
        let account = account(&room, &black_and_lamp());
        assert!(account.error().abs() < 2e-3, "{account:?}");
        assert!((account.absorbed_w.x / account.emitted_w.x - 1.0).abs() < 2e-3, "{account:?}");
    }

    #[test]
    fn of_a_lamp_without_extent_what_arrives_counts() {
        // A lamp of 1 W/sr, 2 m above the middle of a unit square: the solid angle is a closed form.
        let mut scene = fixture::scene(vec![Material::diffuse("grey", Rgb::splat(0.25))]);
        let kind = LampKind::Point { position_m: 2.0 * DVec3::Z, intensity: Rgb::ONE, range_m: None };
        scene.lamps.push(Lamp { name: String::new(), kind });
        let account = account(&[(square(DVec3::ZERO, 0.5, true), 0)], &scene);
        let arriving = 4.0 * (0.25 / (2.0 * 4.5_f64.sqrt())).atan();
        let expected = [arriving, 0.75 * arriving, 0.25 * arriving];
        for (found, expected) in [account.emitted_w.x, account.absorbed_w.x, account.leaving_w.x].iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 2e-3, "{account:?}");
        }
        assert!(account.error().abs() < 1e-9, "{}", account.error());
    }
}
