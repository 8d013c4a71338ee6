//! Exact bounces: what links miss, found by gathering at a few points of every leaf with exact visibility.
//!
//! Links are linear over their receivers, which may be large, and rays tell what stands between their ends. What the leaves
//! reflect errs by that, in one direction over whole regions. So the solution `B` of the links' equation `B = rho (D + F B)`
//! is put into the exact one, and what each leaf then receives more, `d = D + G B - (D + F B)`, is handed back to be solved
//! with: `B = rho (D + d + F B)`. What is left is the error that links make about the correction alone (defect correction:
//! Stetter, *The defect correction principle and discretization methods*, 1978). What a point sees of which patch is found once,
//! and kept as the terms of a sum ([`super::bounced`]); so later bounces cost next to nothing.
//!
//! In a narrow gap links may err so much that corrections swing without end. Then light bounces by the exact sums alone,
//! `B = rho (D + G B)`, slower and surely, since no surface reflects all.
//!
//! At first light is gathered in the middles of leaves alone, until what is seen of which patch is looked at as closely as that needs.
//! Then gathering splits the leaves over which gathered light is uneven and near others. After that, points that look closely at a patch
//! which is split now gather again from its face.

use std::cell::RefCell;

use super::bounced::{BouncedLight, Evenness};
use super::bright_leaves::BrightLeaves;
use super::field::Places;
use super::irradiance::{Irradiance, Terms};
use super::reflected_places::reflected_places;
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage, share_of_way};
use crate::scene::{Rgb, Scene};
use crate::solve::{self, Solution, SolveSettings, Surfaces};
use crate::transport::{DirectLight, Linear, Links};
use crate::visibility::{AtPoints, Memory, Visibility};

/// Bounces go on until one changes the light by less than this share of it.
const UNBOUNCED: f64 = 1e-5;
/// What is seen of which patch is looked at as closely as that patch reflects; and anew where the light changes by more than
/// this share of it.
const LIKE: f64 = 0.2;
/// Or by more than this, where patches are split since.
const SETTLED: f64 = 1e-2;
/// But no more often than that.
const MOST_GATHERINGS: usize = 6;
/// At first, what links left darker than this share of the mean is looked at as if it had that: it may be lit by faces that no link
/// leads to.
const LEAST_LIT: f64 = 0.1;
/// Gatherings in the middles of leaves alone.
const MOST_IN_MIDDLES: usize = 2;
/// Bounces that may follow one gathering.
const MOST_BOUNCES: usize = 100;
/// About the shares of the stage that the solution over links takes, and each gathering of what is then left.
const OVER_LINKS_SHARE: f64 = 0.05;
const GATHERING_OF_REST: f64 = 0.6;
/// Steps that progress is told in.
const STEPS: f64 = 1000.0;
/// Links are of use as long as each correction leaves less than this share of the change that the one before made.
const OF_USE: f64 = 0.5;

/// What light bounces in.
#[derive(Clone, Copy, Debug)]
pub struct Room<'a> {
    /// Its materials.
    pub scene: &'a Scene,
    /// Its faces.
    pub prepared: &'a Prepared,
    /// What sees what.
    pub visibility: &'a Visibility,
    /// The light that bounces.
    pub direct: &'a DirectLight<'a>,
    /// The links that it bounces over.
    pub links: &'a Links,
}

/// How exactly it bounces.
#[derive(Clone, Copy, Debug)]
pub struct Bouncing {
    /// When the solution over links ends.
    pub solve: SolveSettings,
    /// How uneven what leaves gather may be, as a share of the mean irradiance: infinite for no splits.
    pub tolerance: f64,
    /// How many times as much light may err as at the default tolerance.
    pub coarser: f64,
}

/// Solves for what leaves exactly receive of what they reflect, and splits those over which that is too uneven. What links
/// miss is in [`Surfaces::missed`] then: with that, their solution is the one returned, with the terms of the last gathering.
/// From those that are `known` of a scene whose light changed since they are taken, and points that are not known are
/// gathered at.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn bounce(
    room: Room<'_>,
    bouncing: Bouncing,
    mesh: &mut Mesh,
    surfaces: &mut Surfaces,
    known: Option<&AtPoints<Terms>>,
    progress: Progress<'_>,
) -> Result<(Solution, AtPoints<Terms>), Cancelled> {
    let Room { scene, prepared, visibility, direct, links } = room;
    let over_links = progress.part(Stage::Solve, [0.0, OVER_LINKS_SHARE]);
    let solved = |mesh: &Mesh, surfaces: &Surfaces| solve::solve(mesh, surfaces, links, bouncing.solve, over_links);
    let mut solution = solved(mesh, surfaces)?;
    let places = Places::new(prepared);
    let mut bounced_light = BouncedLight::default();
    let mut in_middles_alone = true;
    let mut told = OVER_LINKS_SHARE;
    for gathering in 0..MOST_GATHERINGS {
        // Each may be the last, and is most of what is left.
        let end = told + GATHERING_OF_REST * (1.0 - told);
        let [to_gather, to_settle] =
            [[told, 0.5 * (told + end)], [0.5 * (told + end), end]].map(|part| progress.part(Stage::Solve, part));
        told = end;
        let (sources, looked_at) = (mesh.clone(), solution.clone());
        let mean = looked_at.mean_irradiance(&sources, |face| prepared.shows_light(scene, face));
        let least = if gathering == 0 { LEAST_LIT * mean } else { Rgb::ZERO };
        let reflected = lit_at_least(&looked_at, surfaces, least);
        let light = Irradiance::new(prepared, visibility, &sources, &reflected, mean).coarser(bouncing.coarser);
        let light = light.with_memory(known.map_or(Memory::None, Memory::Known));
        let least = bouncing.tolerance * light.mean;
        let bright = match in_middles_alone {
            true => Vec::new(),
            false => reflected_places(&light, &looked_at, surfaces, least),
        };
        let evenness = Evenness {
            reflectance: &surfaces.reflectance,
            tolerance: bouncing.tolerance,
            bright: &bright,
            in_middles_alone,
        };
        bounced_light = BouncedLight::gather(bounced_light, mesh, &places, &light, evenness, to_gather)?;
        let has_split = mesh.patch_count() > sources.patch_count();
        if has_split {
            surfaces.extend(scene, prepared, mesh, direct);
            solution = solved(mesh, surfaces)?;
        }
        let bright = RefCell::new(BrightLeaves::default());
        let gathered = |mesh: &Mesh, solution: &Solution, surfaces: &Surfaces| {
            let slope = |leaf: PatchId| (solution.irradiance[leaf] - surfaces.direct[leaf]).gradient;
            bounced_light.over_leaves(mesh, &light, &solution.reflected, &mut bright.borrow_mut(), slope)
        };
        solution = settled(links, &solved, &gathered, mesh, surfaces, solution, to_settle)?;
        let change = solution.relative_change(&sources, &looked_at);
        tracing::debug!(change, leaves = mesh.leaves().count(), "gathered");
        let is_settled = !in_middles_alone && (change < if has_split { SETTLED } else { LIKE } || known.is_some());
        if is_settled || progress.is_hurried() {
            break;
        }
        if change >= LIKE {
            bounced_light = BouncedLight::default();
        }
        in_middles_alone &= change >= LIKE && gathering + 1 < MOST_IN_MIDDLES;
    }
    Ok((solution, bounced_light.into_points()))
}

/// What patches reflect where their irradiance is at least `least`, in W/m2.
fn lit_at_least(solution: &Solution, surfaces: &Surfaces, least: Rgb) -> Table<PatchId, Linear<Rgb>> {
    let patches = solution.reflected.iter().zip(&surfaces.reflectance);
    patches.map(|(of, &reflectance)| Linear { mean: of.mean.max(reflectance * least), ..*of }).collect()
}

/// Bounces until light changes no more.
fn settled(
    links: &Links,
    solved: &impl Fn(&Mesh, &Surfaces) -> Result<Solution, Cancelled>,
    gathered: &impl Fn(&Mesh, &Solution, &Surfaces) -> Vec<(PatchId, Linear<Rgb>)>,
    mesh: &Mesh,
    surfaces: &mut Surfaces,
    mut solution: Solution,
    progress: Progress<'_>,
) -> Result<Solution, Cancelled> {
    let (mut over_links, mut before) = (!links.is_empty(), f64::INFINITY);
    let mut changes = 1.0;
    for _ in 0..MOST_BOUNCES {
        progress.report(Stage::Solve, (STEPS * share_of_way(changes, UNBOUNCED)) as usize, STEPS as usize)?;
        let of_leaves = gathered(mesh, &solution, surfaces).into_iter();
        let exactly: Vec<_> = of_leaves.map(|(leaf, gathered)| (leaf, surfaces.direct[leaf] + gathered)).collect();
        let bounced = if over_links {
            for (leaf, exactly) in exactly {
                surfaces.missed[leaf] = surfaces.missed[leaf] + exactly - solution.irradiance[leaf];
            }
            solved(mesh, surfaces)?
        } else {
            solve::reflect(mesh, surfaces, &exactly, &solution)
        };
        let change = bounced.relative_change(mesh, &solution);
        changes = change;
        solution = bounced;
        if !over_links {
            solution.residual = change;
        }
        tracing::debug!(change, over_links, "bounced");
        if change < UNBOUNCED {
            break;
        }
        over_links &= change < OF_USE * before;
        before = change;
    }
    if !over_links {
        surfaces.missed = solve::missed(mesh, surfaces, links, &solution);
    }
    Ok(solution)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshSettings;
    use crate::scene::Material;
    use crate::transport::{DirectLight, FormFactorOracle, link_all};
    use crate::visibility::fixture;
    use glam::DVec3;
    use std::f64::consts::PI;

    #[test]
    fn a_furnished_furnace_is_even_once_what_links_miss_is_known() {
        // Everything emits 1 and reflects a half: irradiance is 2 everywhere.
        let glow = Material { reflectance: Rgb::splat(0.5), ..Material::emitting("glow", Rgb::ONE / PI) };
        let mut room = fixture::inward_box(DVec3::ZERO, DVec3::new(2.0, 1.5, 1.0));
        room.extend(fixture::outward_box(DVec3::new(0.5, 0.5, 0.25), DVec3::new(1.0, 1.0, 0.75)));
        let polygons: Vec<_> = room.into_iter().map(|polygon| (polygon, 0)).collect();
        let (prepared, scene) = (fixture::prepared_of_materials(&polygons), fixture::scene(vec![glow]));
        let index = Visibility::new(&prepared);
        let mut mesh = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let coplanar_m = prepared.tolerance.coplanar_m();
        let oracle = FormFactorOracle { max_form_factor: 0.1, min_area_m2: 0.02, coplanar_m };
        let links = link_all(&prepared, &index, &mut mesh, &oracle, Progress::silent()).unwrap();
        let direct = DirectLight::new(&scene, &prepared, &index);
        let mut surfaces = Surfaces::new(&scene, &prepared, &mesh, &direct);
        let settings = SolveSettings { max_residual: 1e-7, max_iterations: 99 };
        let error = |mesh: &Mesh, solution: &Solution| {
            let squared = |leaf| mesh.patch(leaf).area_m2 * (solution.irradiance[leaf].mean.x - 2.0).powi(2);
            let area_m2: f64 = mesh.leaves().map(|leaf| mesh.patch(leaf).area_m2).sum();
            (mesh.leaves().map(squared).sum::<f64>() / area_m2).sqrt() / 2.0
        };
        let room = Room { scene: &scene, prepared: &prepared, visibility: &index, direct: &direct, links: &links };
        let bouncing = Bouncing { solve: settings, tolerance: f64::INFINITY, coarser: 1.0 };
        let linked = solve::solve(&mesh, &surfaces, &links, settings, Progress::silent()).unwrap();
        let linked = error(&mesh, &linked);
        let (bounced, _) = bounce(room, bouncing, &mut mesh, &mut surfaces, None, Progress::silent()).unwrap();
        let errors = [linked, error(&mesh, &bounced)];
        // What stays, however often light bounces, is what a few rays err about weak patches behind the box.
        assert!(errors[1] < 0.2 * errors[0] && errors[1] < 0.01, "{errors:?}");
    }
}
