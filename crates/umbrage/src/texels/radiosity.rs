//! Radiosity of texels: direct light once, then bounces along rays that are followed once.
//!
//! From the point of each texel a few rays leave, distributed as the cosine; each is kept as the texel that it meets. A bounce is then a
//! sweep over these numbers (Jacobi's iteration on `B = rho (D + G B)`, with `G` of equal entries along rays). What few rays err is
//! averaged over the hundreds of texels that a point gathers from; of what all together reflect nothing is left of it.

use glam::Vec3;
use rayon::prelude::*;

use super::grid::{Texel, TexelGrid};
use super::next_event::BrightTexels;
use super::ray_tree::{Ray, RayTree};
use super::sequence::{Draws, Sequence, key_of};
use super::sources::{Sources, Start};
use crate::id::{FaceId, Table};
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::{Rgb, Scene};
use crate::transport::DirectLight;
use crate::visibility::Visibility;

/// Rays from each texel. With 4 what is shown errs a tenth more, with 16 no less.
const RAYS: usize = 8;
/// Next events from each texel, where they take off so much of the variance of what rays bring.
const EVENTS: usize = 4;
const WORTH_EVENTS: f64 = 5.0;
/// Nodes of the tree of bright texels that the events of a texel choose from.
const NODES_OF_CUT: usize = 12;
/// A texel lies within so many sides around each point of it.
const DIAGONAL_OF_SIDE: f64 = std::f64::consts::SQRT_2;
/// Shadow rays from each texel to each source that matters.
const SHADOW_RAYS: usize = 2;
/// Bounces end where one changes less than this share of all light: with a reflectance of 0.9 a tenfold of that is missing.
const MAX_RESIDUAL: f64 = 1e-5;
/// Or after so many.
const MAX_BOUNCES: usize = 400;
/// A texel is rough where direct light around it varies by this share of the greatest.
const ROUGH: f32 = 0.2;
/// A face with fewer texels across is rough, too.
const FEW_ACROSS: f64 = 3.0;
/// Texels between two reports of progress.
const TEXELS_A_REPORT: usize = 1024;

/// A ray that meets no front.
const NOTHING: u32 = u32::MAX;
/// Uses of random numbers.
const OF_SHADOWS: u64 = 2;
const OF_BOUNCES: u64 = 3;

/// The light of all texels.
#[derive(Debug)]
pub struct TexelRadiosity {
    /// The texels.
    pub(crate) grid: TexelGrid,
    /// Direct irradiance of each, in W/m2.
    pub(crate) direct: Vec<Vec3>,
    /// Reflected irradiance of each, in W/m2.
    pub(crate) indirect: Vec<Vec3>,
    /// Radiosity of each by reflection, in W/m2.
    pub(crate) reflected: Vec<Vec3>,
    /// Whether direct light varies much around each.
    pub(crate) rough: Vec<bool>,
    /// Reflectance of each face.
    pub(crate) reflectance: Table<FaceId, Vec3>,
    /// Mean irradiance over all faces that show it, in W/m2.
    pub(crate) mean: Rgb,
    /// What the last bounce changed, as a share of all light.
    pub(crate) residual: f64,
    /// Bounces.
    pub(crate) bounces: usize,
}

impl TexelRadiosity {
    /// Solves for the radiosity of all texels.
    ///
    /// # Errors
    /// [`Cancelled`] where the progress callback asks to stop.
    pub(crate) fn new(
        scene: &Scene,
        prepared: &Prepared,
        visibility: &Visibility,
        (direct, tree): (&DirectLight<'_>, &RayTree),
        progress: Progress<'_>,
    ) -> Result<Self, Cancelled> {
        let grid = TexelGrid::new(prepared);
        let texels = grid.texels();
        let sources = Sources::new(scene, prepared, direct, tree);
        let start = |number: usize| Start::new(prepared, tree, texels[number].face, texels[number].point_m);
        // Covered texels get nothing: rays start beyond what covers them.
        let covered: Vec<bool> =
            (0..texels.len()).into_par_iter().map(|number| visibility.is_covered(&start(number).receiver)).collect();
        let direct = (0..texels.len())
            .into_par_iter()
            .map(|number| {
                if number.is_multiple_of(TEXELS_A_REPORT) {
                    progress.report(Stage::Solve, number, 2 * texels.len())?;
                }
                if covered[number] {
                    return Ok(Vec3::ZERO);
                }
                let mut draws = Draws::new(key_of(number, OF_SHADOWS));
                let Texel { face, point_m, .. } = texels[number];
                let untold = direct.untold_by_point(face, point_m, DIAGONAL_OF_SIDE * grid.side_m());
                let told = sources.irradiance(&start(number), &untold, SHADOW_RAYS, || draws.next());
                let outline_m = || grid.outline_m(prepared, &texels[number]);
                Ok((told + direct.mean_of_lamps(&untold, face, outline_m)).as_vec3())
            })
            .collect::<Result<Vec<Vec3>, Cancelled>>()?;
        let reflectance: Table<FaceId, Vec3> =
            prepared.faces.iter().map(|face| scene.materials[face.material].reflectance.as_vec3()).collect();
        let reflects = |number: usize, light: Vec3| reflectance[texels[number].face] * light;
        let mut reflected: Vec<Vec3> = direct.iter().enumerate().map(|(i, &light)| reflects(i, light)).collect();
        let bright = BrightTexels::new(prepared, &grid, &reflected, WORTH_EVENTS);
        let hits = (0..texels.len())
            .into_par_iter()
            .map(|number| {
                if number.is_multiple_of(TEXELS_A_REPORT) {
                    progress.report(Stage::Solve, texels.len() + number, 2 * texels.len())?;
                }
                if covered[number] {
                    return Ok(([NOTHING; RAYS], Vec3::ZERO));
                }
                let start = start(number);
                Ok(bounce(tree, &grid, &start, key_of(number, OF_BOUNCES), (&reflected, bright.as_ref())))
            })
            .collect::<Result<Vec<([u32; RAYS], Vec3)>, Cancelled>>()?;
        let mut indirect = vec![Vec3::ZERO; texels.len()];
        let (mut residual, mut bounces) = (1.0, 0);
        while residual > MAX_RESIDUAL && bounces < MAX_BOUNCES {
            progress.report(Stage::Solve, bounces, 0)?;
            let arriving = |(hits, by_events): &([u32; RAYS], Vec3)| {
                let brought = hits.iter().filter(|&&hit| hit != NOTHING).map(|&hit| reflected[hit as usize]);
                (brought.sum::<Vec3>() / RAYS as f32 + by_events).max(Vec3::ZERO)
            };
            let next: Vec<Vec3> = hits.par_iter().map(arriving).collect();
            let (mut change, mut all) = (0.0, 0.0);
            for (number, texel) in texels.iter().enumerate() {
                let share = |light: Vec3| texel.area_m2 * f64::from(light.element_sum());
                change += share((next[number] - indirect[number]).abs());
                all += share(next[number] + direct[number]);
            }
            residual = if all > 0.0 { change / all } else { 0.0 };
            indirect = next;
            reflected = (0..texels.len()).map(|number| reflects(number, direct[number] + indirect[number])).collect();
            bounces += 1;
        }
        let (mut power, mut area_m2) = (Rgb::ZERO, 0.0);
        // Where nothing but emitters is there, the mean is theirs.
        let some_show = prepared.faces.keys().any(|face| prepared.shows_light(scene, face));
        let counts = |face: FaceId| !some_show || prepared.shows_light(scene, face);
        for (number, texel) in texels.iter().enumerate().filter(|(_, texel)| counts(texel.face)) {
            power += texel.area_m2 * (direct[number] + indirect[number]).as_dvec3();
            area_m2 += texel.area_m2;
        }
        let rough = rough(prepared, &grid, &direct);
        let mean = power / area_m2.max(f64::MIN_POSITIVE);
        tracing::debug!(texels = texels.len(), bounces, residual, "texels");
        Ok(Self { grid, direct, indirect, reflected, rough, reflectance, mean, residual, bounces })
    }
}

/// The texels that the rays of a texel meet, and what next events bring of the light that bright ones send first, less the share of it
/// that they take from the rays.
fn bounce(
    tree: &RayTree,
    grid: &TexelGrid,
    start: &Start,
    key: u64,
    (first, bright): (&[Vec3], Option<&BrightTexels>),
) -> ([u32; RAYS], Vec3) {
    let (sequence, normal) = (Sequence::new(key), start.axes[2]);
    let events = bright.map(|bright| bright.events(&[start.from], normal, EVENTS as f32 / RAYS as f32, NODES_OF_CUT));
    let mut by_events = Vec3::ZERO;
    let hits = std::array::from_fn(|number| {
        let [s, t, ..] = sequence.at(number);
        let ray = Ray { from: start.from, along: start.direction(s, t) };
        let Some((face, distance_m)) = tree.first(ray).and_then(|hit| Some((hit.front?, hit.distance_m))) else {
            return NOTHING;
        };
        let texel = grid.texel_at(face, ray.from + distance_m * ray.along);
        if let Some(events) = &events {
            by_events -= events.share_of(texel, normal, ray, distance_m) * first[texel];
        }
        texel as u32
    });
    if let Some(events) = &events {
        for number in 0..EVENTS {
            let event = events.draw(tree, start.from, normal, sequence.more_at(number));
            by_events += event.map_or(Vec3::ZERO, |event| event.weight * first[event.texel]);
        }
    }
    (hits, by_events / RAYS as f32)
}

/// Which texels have neighbours whose direct light is much unlike theirs.
fn rough(prepared: &Prepared, grid: &TexelGrid, direct: &[Vec3]) -> Vec<bool> {
    let mut rough = vec![false; direct.len()];
    for face in prepared.faces.keys() {
        let is_narrow = grid.count(face).map(f64::from).into_iter().fold(f64::INFINITY, f64::min) < FEW_ACROSS;
        for (texel, around) in grid.neighbourhoods(face) {
            let lights = around.map(|texel| direct[texel].element_sum());
            let least = lights.into_iter().fold(f32::INFINITY, f32::min);
            let most = lights.into_iter().fold(0.0, f32::max);
            rough[texel] |= is_narrow || most - least > ROUGH * most;
        }
    }
    rough
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Lamp, LampKind, Material};
    use crate::visibility::fixture;
    use glam::DVec3;
    use std::f64::consts::PI;

    #[test]
    fn in_a_furnished_furnace_all_texels_have_the_same_light() {
        // Everything emits 1 and reflects nine tenths: irradiance is 10 everywhere.
        let glow = Material { reflectance: Rgb::splat(0.9), ..Material::emitting("glow", Rgb::ONE / PI) };
        let mut room = fixture::inward_box(DVec3::ZERO, DVec3::new(2.0, 1.5, 1.0));
        room.extend(fixture::outward_box(DVec3::new(0.5, 0.5, 0.25), DVec3::new(1.0, 1.0, 0.75)));
        let polygons: Vec<_> = room.into_iter().map(|polygon| (polygon, 0)).collect();
        let (prepared, scene) = (fixture::prepared_of_materials(&polygons), fixture::scene(vec![glow]));
        let visibility = Visibility::new(&prepared);
        let direct = DirectLight::new(&scene, &prepared, &visibility);
        let tree = RayTree::new(&prepared);
        let light = TexelRadiosity::new(&scene, &prepared, &visibility, (&direct, &tree), Progress::silent()).unwrap();
        let (mut power, mut area_m2) = (0.0, 0.0);
        for (number, texel) in light.grid.texels().iter().enumerate() {
            power += texel.area_m2 * f64::from((light.direct[number] + light.indirect[number]).x);
            area_m2 += texel.area_m2;
        }
        assert!((power / area_m2 / 10.0 - 1.0).abs() < 2e-3, "{}", power / area_m2);
        let errs = |number: &usize| (light.direct[*number] + light.indirect[*number]).x - 10.0;
        let squared: f32 = (0..light.direct.len()).map(|number| errs(&number).powi(2)).sum();
        // What is left is what two shadow rays to each face err.
        assert!((squared / light.direct.len() as f32).sqrt() < 1.0);
    }

    #[test]
    fn texels_receive_what_spots_and_bulbs_send_though_it_be_less_than_a_texel() {
        // Circles of 3 mm to 30 cm on the wall of a room whose texels are 4 cm wide, and bulbs before it.
        let room = fixture::inward_box(DVec3::ZERO, DVec3::new(4.0, 3.0, 5.0));
        let prepared = fixture::prepared(&room);
        let visibility = Visibility::new(&prepared);
        let tree = RayTree::new(&prepared);
        let from = DVec3::new(1.513, 1.27, 2.711);
        let spot = |outer_rad: f64, softness: f64| LampKind::Spot {
            position_m: from,
            direction: DVec3::new(-0.8, 0.1, 0.3).normalize(),
            intensity: Rgb::ONE,
            range_m: None,
            inner_rad: (1.0 - softness) * outer_rad,
            outer_rad,
        };
        let bulb = |x: f64| LampKind::Point { position_m: DVec3::new(x, 1.2, 2.2), intensity: Rgb::ONE, range_m: None };
        for kind in
            [spot(2e-3, 1e-3), spot(0.02, 1e-3), spot(0.07, 1.0), spot(0.2, 1e-3), bulb(1e-3), bulb(0.05), bulb(1.0)]
        {
            let mut scene = fixture::scene(vec![Material::diffuse("grey", Rgb::splat(0.5))]);
            scene.lamps.push(Lamp { name: String::new(), kind });
            let direct = DirectLight::new(&scene, &prepared, &visibility);
            let light =
                TexelRadiosity::new(&scene, &prepared, &visibility, (&direct, &tree), Progress::silent()).unwrap();
            let received: f64 =
                light.grid.texels().iter().zip(&light.direct).map(|(texel, e)| texel.area_m2 * f64::from(e.x)).sum();
            let sent = scene.lamps.first().unwrap().flux_w().unwrap().x;
            assert!((received / sent - 1.0).abs() < 0.02, "{received} of {sent} W of {kind:?}");
        }
    }
}
