//! From the solved hierarchy to what is shown.
//!
//! Indirect light is smooth: it is gathered from the hierarchy at few points, between which it is quadratic within a
//! share of the tolerance, on a mesh of its own; on plain faces the points of the bounces are enough. Then what is
//! shown is refined for the sum of exact direct light and that. At last every leaf is cut into triangles, and the light
//! of each vertex is written down.
//!
//! The mesh that is shown is not the one that carried transport: that one must be well shaped, this one must follow the
//! light, and where light is even it stays coarse.

use super::BakedMesh;
use super::assemble::{Lighting, assemble};
use super::direct::Direct;
use super::field::{Field, Places, Values};
use super::interpolated::Interpolated;
use super::irradiance::{self, Irradiance, Terms};
use super::lamp_account::{LampAccount, Shown, lamp_accounts};
use super::local_light::LocalLight;
use super::plain::plain_faces;
use super::refine::{Interpolation, RefineSettings, Refined, refine};
use super::regression::{FittedLight, Gathering, RegressionSettings, bright_places, regress};
use crate::id::{FaceId, PatchId};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::{Rgb, Scene};
use crate::texels::{BrightTexels, RayTree, Sources, TexelRadiosity};
use crate::transport::{BrightPlace, DirectLight};
use crate::visibility::{AtPoints, ReceiverPoint, Visibility};

/// The share of the tolerance that interpolation of indirect light may take.
const INDIRECT_SHARE: f64 = 0.3;
/// The share of the tolerance that linear interpolation of all light may take: what is left is for the errors of the
/// light itself.
const LINEAR_SHARE: f64 = 0.5;

/// About the parts of the stage in which indirect light, what is shown, and triangles are made.
const SHARES: [[f64; 2]; 3] = [[0.0, 0.5], [0.5, 0.95], [0.95, 1.0]];

/// Where triangles are few, hard shadows take no more than this share of them before refinement tells where they err least.
const CUTS_OF_ROOM: f64 = 0.5;

/// What light is gathered on is not written: with few triangles it may be finer than what is shown, up to so many.
const LEAST_GATHERED: usize = 4_000;

/// Emitters show their own colour: what they receive besides may err ten times what others may. Slats before a luminous window took a
/// quarter of all samples to it.
const WEIGHT_OF_EMITTERS: f64 = 0.01;

/// Next events go with samples where they take off so much of the variance of what rays bring.
const WORTH_EVENTS: f64 = 2.5;

/// Up to so many polygons the default tolerance is the one of a room; with more it grows in proportion, up to the greatest.
const POLYGONS_OF_ROOM: usize = 5_000;
const GREATEST_DEFAULT: f64 = 0.05;

/// How finely light is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadeSettings {
    /// Root mean square error of linear interpolation over the mean irradiance; infinite for no refinement.
    pub tolerance: f64,
    /// No more triangles than this are made of the surfaces that are baked.
    pub max_triangles: usize,
}

impl ShadeSettings {
    /// The tolerance that suits a scene of so many polygons, where no other is asked for: each of them is a smaller part of what is
    /// seen, and has its triangles all the same.
    pub fn default_tolerance(polygons: usize) -> f64 {
        let times = (polygons as f64 / POLYGONS_OF_ROOM as f64).max(1.0);
        // A number that one can say.
        let rounded = (1e3 * times * Self::default().tolerance).round() / 1e3;
        rounded.min(GREATEST_DEFAULT)
    }
}

impl Default for ShadeSettings {
    fn default() -> Self {
        Self { tolerance: 0.01, max_triangles: usize::MAX }
    }
}

/// The baked mesh, and the estimate of its error.
#[derive(Clone, Debug)]
pub struct Shaded {
    /// Triangles and the light of their vertices.
    pub mesh: BakedMesh,
    /// Estimated root mean square error over the mean irradiance: that of interpolation, and that of the fit where reflected light is
    /// fitted to samples.
    pub error: f64,
    /// Triangles flat as a needle that were taken out.
    pub flat_triangles: usize,
    /// d-segments of degree 0 that were not cut, or in part, since there may be no more triangles.
    pub uncut: usize,
    /// What becomes of the light of each lamp that gives any.
    pub lamps: Vec<LampAccount>,
    /// How many samples reflected light was fitted to, if it was.
    pub samples: Option<usize>,
}

/// Indirect light as a function of the place.
enum Indirect<'a> {
    /// Interpolated between points where it was gathered.
    Interpolated(Interpolated<'a>),
    /// Fitted to samples.
    Fitted(Box<FittedLight>),
}

impl Indirect<'_> {
    fn at(&self, point: &ReceiverPoint, face: FaceId) -> Rgb {
        match self {
            Self::Interpolated(light) => light.at(point, face),
            Self::Fitted(light) => light.at(point.position_m, face),
        }
    }
}

/// Direct light exactly, plus indirect light from few points.
struct Total<'a> {
    direct: Direct<'a>,
    indirect: Indirect<'a>,
    bright: &'a [BrightPlace],
    local: &'a LocalLight<'a>,
}

impl Field for Total<'_> {
    fn look_around(
        &mut self,
        mesh: &Mesh,
        leaves: &[PatchId],
        report: &(impl Fn() -> Result<(), Cancelled> + Sync),
    ) -> Result<(), Cancelled> {
        self.direct.look_around(mesh, leaves, report)
    }

    fn bright_places(&self) -> &[BrightPlace] {
        self.bright
    }

    fn around(&self, mesh: &Mesh, patch: PatchId) -> f64 {
        let patch = mesh.patch(patch);
        self.local.at(patch.face, patch.centroid_m)
    }

    fn at(&self, mesh: &Mesh, point: &ReceiverPoint, patch: PatchId) -> Rgb {
        self.direct.at(mesh, point, patch) + self.indirect.at(point, mesh.patch(patch).face)
    }
}

/// The meshes that the light refines.
#[derive(Clone, Debug)]
pub struct ShadeMeshes {
    /// What is shown, with all d-segments as hints.
    pub shown: Mesh,
    /// What indirect light is gathered on, which shadows of direct light need not cut.
    pub gathering: Mesh,
}

/// Where indirect light is known from.
#[derive(Clone, Copy, Debug)]
pub enum IndirectLight<'a> {
    /// From gathers at points.
    Gathered {
        /// What gathers it.
        irradiance: &'a Irradiance<'a>,
        /// Small places that are known to be bright.
        bright: &'a [BrightPlace],
        /// What points of the patches that it bounced on see of each other.
        bounced: &'a AtPoints<Terms>,
    },
    /// From samples along rays that meet texels.
    Sampled {
        /// What covers what.
        visibility: &'a Visibility,
        /// All faces, for rays.
        tree: &'a RayTree,
        /// Their texels.
        light: &'a TexelRadiosity,
    },
}

impl IndirectLight<'_> {
    /// Mean of all irradiance, in W/m2.
    fn mean(&self) -> f64 {
        match self {
            Self::Gathered { irradiance, .. } => irradiance.mean,
            Self::Sampled { light, .. } => light.mean.element_sum() / 3.0,
        }
    }
}

/// What is known of the light that is shown.
#[derive(Clone, Copy, Debug)]
pub struct ShadeLight<'a> {
    /// Exact direct light.
    pub direct: &'a DirectLight<'a>,
    /// Where reflected light is known from.
    pub indirect: IndirectLight<'a>,
    /// What is around.
    pub local: &'a LocalLight<'a>,
}

/// Refines the meshes, cuts the one that is shown into triangles and evaluates the light of their corners.
///
/// # Errors
/// [`Cancelled`] where the progress callback asks to stop.
pub fn shade(
    scene: &Scene,
    prepared: &Prepared,
    ShadeMeshes { shown: mesh, gathering }: &mut ShadeMeshes,
    ShadeLight { direct, indirect, local }: ShadeLight<'_>,
    settings: ShadeSettings,
    progress: Progress<'_>,
) -> Result<Shaded, Cancelled> {
    let is_shown = |face: FaceId| {
        let face = &prepared.faces[face];
        scene.surfaces[face.surface].baked && !scene.materials[face.material].emits()
    };
    let receives = |mesh: &Mesh, patch: PatchId| is_shown(mesh.patch(patch).face);
    let places = Places::new(prepared);
    mesh.count_triangles_of(|face| scene.surfaces[prepared.faces[face].surface].baked);
    let most = settings.max_triangles;
    cut_first(mesh, most);
    let mean = indirect.mean();
    let [of_indirect, of_shown, of_triangles] = SHARES.map(|[from, to]| progress.part(Stage::Shade, [from, to]));
    let sent = direct.light_sent();
    let mut bright = sent.places.clone();
    let light = match indirect {
        IndirectLight::Gathered { irradiance, bright: of_reflected, bounced } => {
            let smooth = RefineSettings {
                interpolation: Interpolation::Quadratic,
                tolerance: INDIRECT_SHARE * settings.tolerance,
                mean,
                max_triangles: most.max(LEAST_GATHERED),
            };
            let tolerances = [smooth.tolerance, settings.tolerance].map(|tolerance| tolerance * mean);
            let (plain, known) = plain_faces(gathering, &places, irradiance, bounced, tolerances, of_indirect)?;
            let is_not_plain = |mesh: &Mesh, patch: PatchId| plain[mesh.patch(patch).face].is_none();
            let field = &mut irradiance::Indirect { light: irradiance, bright: of_reflected };
            let gathered = refine(gathering, &places, field, known, is_not_plain, smooth, of_indirect)?;
            bright.extend(of_reflected);
            Indirect::Interpolated(Interpolated::new(gathering, &gathered, &plain))
        }
        IndirectLight::Sampled { visibility, tree, light } => {
            let sources = Sources::new(scene, prepared, direct, tree);
            let events = BrightTexels::new(prepared, &light.grid, &light.reflected, WORTH_EVENTS);
            let from = Gathering { prepared, visibility, tree, sources: &sources, light, bright: events.as_ref() };
            // Without next events texels are too noisy to tell.
            let least = if from.bright.is_some() { settings.tolerance * mean } else { f64::INFINITY };
            let texels = bright_places(light, least);
            let settings = RegressionSettings { tolerance: settings.tolerance, mean, bright: &texels };
            let weight = |face: FaceId| match scene.surfaces[prepared.faces[face].surface].baked {
                true if prepared.shows_light(scene, face) => 1.0,
                true => WEIGHT_OF_EMITTERS,
                false => 0.0,
            };
            let fitted = regress(from, gathering.clone(), &places, weight, settings, of_indirect)?;
            let fitted_at =
                |place: &BrightPlace| BrightPlace { irradiance: fitted.at(place.point_m, place.face), ..*place };
            bright.extend(texels.iter().map(fitted_at));
            Indirect::Fitted(Box::new(fitted))
        }
    };
    let (samples, of_fit) = match &light {
        // Where nothing that is shown receives light there is nothing to be a share of.
        Indirect::Fitted(light) => (Some(light.samples), if mean > 0.0 { light.error } else { 0.0 }),
        Indirect::Interpolated(_) => (None, 0.0),
    };
    let mut total = Total { direct: Direct::new(direct), indirect: light, bright: &bright, local };
    let whole = RefineSettings {
        interpolation: Interpolation::Linear,
        tolerance: LINEAR_SHARE * settings.tolerance,
        mean,
        max_triangles: most,
    };
    let Refined { mut values, shifts, error, elements } =
        refine(mesh, &places, &mut total, Values::default(), receives, whole, of_shown)?;
    // At borders points may lie in a patch beside the one that they are of: for these all is looked at.
    total.direct = Direct::new(direct);
    let shown = Shown { prepared, mesh, places: &places, elements: &elements, values: &values, shifts: &shifts };
    let lamps = lamp_accounts(scene, direct, &sent, &shown, is_shown);
    values.shift(&shifts);
    let uncut = mesh.remove_d0_hints_within(most);
    mesh.triangulate();
    let lighting = Lighting { known: &values, irradiance: &total };
    let (mesh, flat_triangles) = assemble(scene, prepared, mesh, &places, lighting, most, of_triangles)?;
    Ok(Shaded { mesh, error: error.hypot(of_fit), flat_triangles, uncut, lamps, samples })
}

/// The mesh that carried transport, if it is no more than `most` triangles with its hard shadows cut: as the paper shows it. Else
/// `coarse`, the faces with all their hints, cut as far as that allows, the largest leaves first.
pub fn within(scene: &Scene, prepared: &Prepared, mut mesh: Mesh, coarse: impl Fn() -> Mesh, most: usize) -> Mesh {
    if most == usize::MAX {
        return mesh;
    }
    let is_written = |face: FaceId| scene.surfaces[prepared.faces[face].surface].baked;
    mesh.count_triangles_of(is_written);
    let mut cut = mesh.clone();
    cut.remove_d0_hints();
    if cut.triangle_count() <= most {
        return mesh;
    }
    let mut coarse = coarse();
    coarse.count_triangles_of(is_written);
    cut_first(&mut coarse, most);
    coarse.split_largest_within(most);
    coarse
}

/// Cuts along all d-segments of degree 0, if that leaves enough of the triangles that may be made; else along the most important
/// ones: refinement cuts along others where the light asks for it most.
fn cut_first(mesh: &mut Mesh, most: usize) {
    if most == usize::MAX {
        return mesh.remove_d0_hints();
    }
    let share = mesh.triangle_count() + (CUTS_OF_ROOM * most.saturating_sub(mesh.triangle_count()) as f64) as usize;
    let whole = mesh.clone();
    mesh.remove_d0_hints();
    if mesh.triangle_count() > share {
        *mesh = whole;
        mesh.remove_d0_hints_within(share);
    }
}
