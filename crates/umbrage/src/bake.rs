//! `generate_mesh`, and the light on it: all stages in order (paper, sections 4 and 6).
//!
//! ```text
//! generate_mesh() {
//!     calculate all discontinuity segments                        discontinuity::find
//!     store segments as edge split-hints to the patches           Mesh::new
//!     for each pair of patches p,q with p != q                    transport::link_all
//!         subdivide(p,q);
//!     split patches that direct light is uneven on                transport::split_where_uneven
//!     solve, and split those that reflected light is uneven on    solve::solve, shade::bounce
//!     calculate d-segments of what reflects much                  discontinuity::find_secondary
//!     split patches until all point split-hints and all edge      Mesh::remove_d0_hints
//!       split-hints caused by d-segments of order 0 are removed
//!     for all polygons p with more than three vertices            Mesh::triangulate
//!         point_split(p)
//! }                                                               shade::assemble
//! ```

use std::borrow::Cow;
use std::time::Instant;

use glam::DVec3;

use crate::discontinuity::{self, DSegment, Discontinuities, Event, Reflecting};
use crate::hidden;
use crate::id::{DSegmentId, PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::{PrepareError, PrepareReport, PrepareSettings, Prepared};
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::{Rgb, Scene, SceneError};
use crate::shade::{
    self, BakedMesh, Bouncing, IndirectLight, Irradiance, LampAccount, LocalLight, Room, ShadeLight, ShadeMeshes, Terms,
};
use crate::solve::{self, EnergyAccount, Solution, Surfaces};
use crate::texels::{RayTree, TexelRadiosity};
use crate::transport::{
    self, BrightnessOracle, DirectLight, KnownSources, Linear, Links, OracleKind, PaperOracle, SourceMemory,
    SourcesSeen,
};
use crate::visibility::{AtPoints, Memory, Notes, Visibility};

use crate::bake_warning::Figures;
pub use crate::bake_warning::{BakeWarning, MAX_ENERGY_ERROR, MAX_ERROR_ESTIMATE, MAX_RESIDUAL};
pub use crate::settings::{BakeSettings, GatherKind, ParseGatherError};
use crate::settings::{total_area_m2, triangles_needed};

/// What a bake did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// What `prepare` mended.
    pub prepare: PrepareReport,
    /// Faces after `prepare`.
    pub faces: usize,
    /// d-segments of degree 0, 1 and 2.
    pub d_segments: [usize; 3],
    /// d-segments of faces and parts of faces that reflect so much that they are sources, too.
    pub secondary: usize,
    /// Patches that carry transport, split ones included.
    pub patches: usize,
    /// How well shaped the patches that carry transport and are not split are: 4 pi A / P^2, median and 5th percentile.
    pub compactness: [f64; 2],
    /// Of these, the ones that are not split.
    pub leaves: usize,
    /// Links between patches; none where reflected light is fitted to samples.
    pub links: usize,
    /// How many samples reflected light is fitted to, if it is not gathered from faces.
    pub samples: Option<usize>,
    /// Wall time of deciding on links, with the splits that this takes, and of finding their form factors, in seconds.
    pub linking_s: f64,
    /// Vertices of the baked mesh.
    pub vertices: usize,
    /// Triangles of the baked mesh.
    pub triangles: usize,
    /// Triangles flat as a needle that were taken out of it; what lies beside them closed the gap.
    pub flat_triangles: usize,
    /// Edges of hard shadows (d-segments of degree 0) that were not cut, or in part, since more triangles were not allowed: those of
    /// the least strength times length.
    pub uncut: usize,
    /// Estimated root mean square error of linear interpolation between vertices over the mean irradiance of all faces; of sides that
    /// are hidden there are no faces. Errors of the light at the vertices are not in it.
    pub error: f64,
    /// Iterations of the solution.
    pub iterations: usize,
    /// Residual of the solution.
    pub residual: f64,
    /// Where the light of the solution comes from and where it goes.
    pub energy: EnergyAccount,
    /// What becomes of the light of each lamp that gives any, before it is reflected.
    pub lamps: Vec<LampAccount>,
    /// Seconds of each stage, in order.
    pub seconds: Vec<(Stage, f64)>,
    /// Where the result is not as good as it should be.
    pub warnings: Vec<BakeWarning>,
}

impl Report {
    /// Links for each patch that is not split.
    pub fn links_a_leaf(&self) -> f64 {
        self.links as f64 / self.leaves.max(1) as f64
    }

    /// Wall time of a link, in seconds.
    pub fn seconds_a_link(&self) -> f64 {
        self.linking_s / self.links.max(1) as f64
    }
}

/// A baked scene.
#[derive(Clone, Debug)]
pub struct Bake {
    /// The triangles and their light.
    pub mesh: BakedMesh,
    /// What was done.
    pub report: Report,
}

/// Why a scene was not baked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BakeError {
    /// The scene cannot be baked as it is.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Its faces could not be prepared.
    #[error(transparent)]
    Prepare(PrepareError),
    /// The surfaces that are baked need more triangles than are allowed.
    #[error(
        "at most {asked} triangles are allowed, and the shapes of the surfaces alone need {needed}, before any light is shown: \
         allow {needed} or more"
    )]
    TooFewTriangles {
        /// The most that are allowed.
        asked: usize,
        /// The least with which the scene can be baked.
        needed: usize,
    },
    /// The progress callback asked to stop, in whatever stage.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl From<PrepareError> for BakeError {
    fn from(error: PrepareError) -> Self {
        match error {
            PrepareError::Cancelled(cancelled) => Self::Cancelled(cancelled),
            refused => Self::Prepare(refused),
        }
    }
}

/// Measures the stages.
#[derive(Debug)]
pub(crate) struct Clock {
    since: Instant,
    seconds: Vec<(Stage, f64)>,
    linking_s: f64,
}

impl Clock {
    pub(crate) fn start() -> Self {
        Self::after(Vec::new())
    }

    /// Goes on after stages that took so many seconds.
    pub(crate) fn after(seconds: Vec<(Stage, f64)>) -> Self {
        Self { since: Instant::now(), seconds, linking_s: 0.0 }
    }

    /// The seconds of each stage so far.
    pub(crate) fn into_seconds(self) -> Vec<(Stage, f64)> {
        self.seconds
    }

    pub(crate) fn end_of(&mut self, stage: Stage) {
        let seconds = self.since.elapsed().as_secs_f64();
        tracing::info!(%stage, seconds, "stage done");
        self.seconds.push((stage, seconds));
        self.since = Instant::now();
    }
}

/// Bakes a scene: `generate_mesh` and the irradiance of its vertices.
///
/// # Errors
/// A [`BakeError`] where the scene is refused or the callback cancels.
pub fn bake(scene: &Scene, settings: &BakeSettings, progress: Progress<'_>) -> Result<Bake, BakeError> {
    bake_and_keep(scene, settings, progress).map(|(bake, _)| bake)
}

/// Bakes a scene, and keeps what it came from: for programs that show where the light on a surface is from.
///
/// # Errors
/// As [`bake`].
pub fn bake_and_keep(
    scene: &Scene,
    settings: &BakeSettings,
    progress: Progress<'_>,
) -> Result<(Bake, Meshed), BakeError> {
    let mut clock = Clock::start();
    let mut linked = mesh_and_link(scene, settings, &mut clock, progress)?;
    let solved = solve(scene, settings, &mut linked, &Before::Nothing, progress)?;
    let lit = show(scene, settings, &linked, solved, &Before::Nothing, clock, progress)?;
    Ok((lit.bake, linked.meshed))
}

/// What the last stages note for another bake.
#[derive(Debug, Default)]
pub(crate) struct BakeNotes {
    /// The light sources that points see.
    pub(crate) sources: Notes<SourcesSeen>,
    /// Those that points see where indirect light is gathered to be shown.
    pub(crate) gathered: Notes<Terms>,
}

/// What a bake knows of one before.
#[derive(Clone, Debug)]
pub(crate) struct Known<'a> {
    pub(crate) sources: KnownSources<'a>,
    pub(crate) bounced: &'a AtPoints<Terms>,
    pub(crate) gathered: &'a AtPoints<Terms>,
    /// d-segments of what reflected much.
    pub(crate) secondary: Table<DSegmentId, DSegment>,
    /// What links miss, where light is that of before times a factor for each colour: then no more need bounce.
    pub(crate) missed: Option<Table<PatchId, Linear<Rgb>>>,
}

/// What there was before a bake.
#[derive(Clone, Debug)]
pub(crate) enum Before<'a> {
    /// Nothing, and nothing is wanted after it.
    Nothing,
    /// Nothing; what is found is noted for another bake.
    ToBeNoted(&'a BakeNotes),
    /// A bake of the same faces.
    Known(Known<'a>),
}

impl<'a> Before<'a> {
    fn sources(&self) -> SourceMemory<'a> {
        match self {
            Self::Nothing => SourceMemory::None,
            Self::ToBeNoted(notes) => SourceMemory::Noting(&notes.sources),
            Self::Known(known) => SourceMemory::Known(known.sources.clone()),
        }
    }

    fn bounced(&self) -> Option<&'a AtPoints<Terms>> {
        if let Self::Known(known) = self { Some(known.bounced) } else { None }
    }

    fn gathered(&self) -> Memory<'a, Terms> {
        match self {
            Self::Nothing => Memory::None,
            Self::ToBeNoted(notes) => Memory::Noting(&notes.gathered),
            Self::Known(known) => Memory::Known(known.gathered),
        }
    }
}

/// What patches receive and reflect.
#[derive(Debug)]
pub(crate) struct Solved<'a> {
    surfaces: Surfaces,
    pub(crate) solution: Solution,
    /// What points of the patches see of each other.
    bounced: Cow<'a, AtPoints<Terms>>,
    /// The light of texels, where it is gathered from these.
    texels: Option<(RayTree, TexelRadiosity)>,
}

/// A bake, and what of its light another one can start from.
#[derive(Debug)]
pub(crate) struct Lit {
    pub(crate) bake: Bake,
    /// d-segments of faces that reflect much.
    pub(crate) secondary: Table<DSegmentId, DSegment>,
    /// What links miss.
    pub(crate) missed: Table<PatchId, Linear<Rgb>>,
    /// What points of the patches that carry transport see of each other.
    pub(crate) bounced: AtPoints<Terms>,
}

/// Finds what patches receive and reflect, and splits those over which it is uneven.
pub(crate) fn solve<'a>(
    scene: &Scene,
    settings: &BakeSettings,
    linked: &mut Linked,
    before: &Before<'a>,
    progress: Progress<'_>,
) -> Result<Solved<'a>, BakeError> {
    let Linked { meshed: Meshed { prepared, mesh, .. }, visibility, links } = linked;
    let (prepared, visibility, links) = (&*prepared, &*visibility, &*links);
    let direct = DirectLight::new(scene, prepared, visibility).with_memory(before.sources());
    if settings.fits_samples(prepared) {
        let tree = RayTree::new(prepared);
        let light = TexelRadiosity::new(scene, prepared, visibility, (&direct, &tree), progress)?;
        let solution = light.over_patches(mesh);
        let bounced = Cow::Owned(AtPoints::new(Vec::new()));
        let surfaces = Surfaces::of_materials(scene, prepared, mesh);
        return Ok(Solved { surfaces, solution, bounced, texels: Some((tree, light)) });
    }
    let mut surfaces = Surfaces::new(scene, prepared, mesh, &direct);
    let (solution, bounced) = match before {
        Before::Known(Known { missed: Some(missed), bounced, .. }) => {
            surfaces.missed.clone_from(missed);
            (solve::solve(mesh, &surfaces, links, settings.solve, progress)?, Cow::Borrowed(*bounced))
        }
        _ => {
            let bouncing =
                Bouncing { solve: settings.solve, tolerance: settings.shade.tolerance, coarser: settings.coarseness() };
            let room = Room { scene, prepared, visibility, direct: &direct, links };
            let (solution, bounced) = shade::bounce(room, bouncing, mesh, &mut surfaces, before.bounced(), progress)?;
            (solution, Cow::Owned(bounced))
        }
    };
    Ok(Solved { surfaces, solution, bounced, texels: None })
}

/// About the share of `shade` that the d-segments of what reflects much take.
const SECONDARY_SHARE: f64 = 0.05;

/// Makes the mesh that is shown.
pub(crate) fn show(
    scene: &Scene,
    settings: &BakeSettings,
    linked: &Linked,
    Solved { surfaces, solution, bounced, texels }: Solved<'_>,
    before: &Before<'_>,
    mut clock: Clock,
    progress: Progress<'_>,
) -> Result<Lit, BakeError> {
    let Linked { meshed: Meshed { prepared, discontinuities, mesh }, visibility, links } = linked;
    check(|| solution.validate().map_err(|error| error.to_string()));
    let direct = DirectLight::new(scene, prepared, visibility).with_memory(before.sources());
    let energy = EnergyAccount::new(prepared, visibility, mesh, &surfaces, &direct, &solution);
    clock.end_of(Stage::Solve);

    let refined = settings.shade.tolerance.is_finite();
    let mean = solution.mean_irradiance(mesh, |face| prepared.shows_light(scene, face));
    let [of_secondary, progress] =
        [[0.0, SECONDARY_SHARE], [SECONDARY_SHARE, 1.0]].map(|part| progress.part(Stage::Shade, part));
    let secondary = match before {
        Before::Known(known) => known.secondary.clone(),
        _ if settings.discontinuities && settings.secondary_sources && refined => {
            let reflecting = what_patches_reflect(mesh, &solution);
            let least = settings.weak_share() * mean.element_sum() / 3.0;
            discontinuity::find_secondary(scene, prepared, visibility, &reflecting, least, of_secondary)?
        }
        _ => Table::new(),
    };

    let (irradiance, bright);
    let indirect = match &texels {
        Some((tree, light)) => IndirectLight::Sampled { visibility, tree, light },
        None => {
            irradiance = Irradiance::new(prepared, visibility, mesh, &solution.reflected, mean)
                .coarser(settings.coarser_to_be_shown())
                .with_memory(before.gathered());
            let least = settings.shade.tolerance * mean.element_sum() / 3.0;
            bright = shade::reflected_places(&irradiance, &solution, &surfaces, least);
            IndirectLight::Gathered { irradiance: &irradiance, bright: &bright, bounced: &bounced }
        }
    };
    let mean = mean.element_sum() / 3.0;
    let local = LocalLight::new(scene, (prepared, visibility), mesh, &solution.irradiance, mean);
    let light = ShadeLight { direct: &direct, indirect, local: &local };
    let mut meshes = if refined {
        let with = |segments| Mesh::new(prepared, segments, settings.mesh(discontinuities.mean_irradiance));
        let least = |face, point_m| shade::negligible(settings.weak_share(), mean, local.at(face, point_m));
        let faint = discontinuities.faint_that_count(prepared, visibility, least);
        let all = discontinuities.segments.iter().chain(&secondary).chain(faint).copied().collect();
        // What is reflected jumps at contacts, too; where it is fitted, edges close before faces must be cut in.
        let contacts = discontinuities.segments.iter().filter(|segment| matches!(segment.event, Event::Contact { .. }));
        let near = if texels.is_some() { near_edges_of(scene, prepared) } else { Vec::new() };
        let of_reflected = contacts.chain(&secondary).copied().chain(near).collect();
        let mut gathering = with(&of_reflected);
        if texels.is_some() {
            gathering.remove_d0_hints();
        }
        ShadeMeshes { shown: with(&all), gathering }
    } else {
        let all = || Mesh::new(prepared, &discontinuities.segments, settings.mesh(discontinuities.mean_irradiance));
        let shown = shade::within(scene, prepared, mesh.clone(), all, settings.shade_within(0).max_triangles);
        ShadeMeshes { shown, gathering: mesh.clone() }
    };
    let shaded = shade::shade(scene, prepared, &mut meshes, light, settings.shade_within(0), progress)?;
    check(|| meshes.shown.validate().map_err(|error| error.to_string()));
    check(|| shaded.mesh.validate().map_err(|error| error.to_string()));
    clock.end_of(Stage::Shade);

    let figures =
        Figures { energy: &energy, error: shaded.error, residual: solution.residual, iterations: solution.iterations };
    let report = Report {
        warnings: BakeWarning::about(figures, settings.shade),
        prepare: prepared.report.clone(),
        faces: prepared.faces.len(),
        d_segments: discontinuities.count_by_degree(),
        secondary: secondary.len(),
        patches: mesh.patch_count(),
        compactness: compactness_of(mesh),
        leaves: mesh.leaves().count(),
        links: links.len(),
        samples: shaded.samples,
        linking_s: clock.linking_s,
        vertices: shaded.mesh.vertex_count(),
        triangles: shaded.mesh.triangle_count(),
        flat_triangles: shaded.flat_triangles,
        uncut: shaded.uncut,
        error: shaded.error,
        iterations: solution.iterations,
        residual: solution.residual,
        energy,
        lamps: shaded.lamps,
        seconds: clock.seconds,
    };
    Ok(Lit {
        bake: Bake { mesh: shaded.mesh, report },
        secondary,
        missed: surfaces.missed,
        bounced: bounced.into_owned(),
    })
}

/// A d-segment in the world, for pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnSegment {
    /// 0, 1 or 2.
    pub degree: u8,
    /// Its ends, in metres.
    pub ends_m: [DVec3; 2],
    /// Unit normal of the face that it lies on.
    pub normal: DVec3,
}

/// The d-segments of a scene, in the world.
///
/// # Errors
/// A [`BakeError`] where the scene is refused or the callback cancels.
pub fn d_segments(scene: &Scene, progress: Progress<'_>) -> Result<Vec<DrawnSegment>, BakeError> {
    let Traced { prepared, discontinuities } = trace(scene, PrepareSettings::default(), 0.0, progress)?;
    let drawn = discontinuities.segments.iter().map(|segment| DrawnSegment {
        degree: segment.degree.number() as u8,
        ends_m: segment.ends_m.map(|end| prepared.origin_m + end),
        normal: prepared.normal(segment.face),
    });
    Ok(drawn.collect())
}

/// The faces of a scene and the d-segments on them: the stages up to `discontinuity`.
#[derive(Clone, Debug)]
pub struct Traced {
    /// The faces.
    pub prepared: Prepared,
    /// The emitters and d-segments.
    pub discontinuities: Discontinuities,
}

/// Runs the stages up to `discontinuity`: what made every d-segment is in the result. Those that are weaker than
/// `least_share` are left out (see [`discontinuity::find`]); 0 keeps all.
///
/// # Errors
/// A [`BakeError`] where the scene is refused or the callback cancels.
pub fn trace(
    scene: &Scene,
    prepare: PrepareSettings,
    least_share: f64,
    progress: Progress<'_>,
) -> Result<Traced, BakeError> {
    let clock = &mut Clock::start();
    let (prepared, visibility) = faces_of(scene, prepare, clock, progress)?;
    let discontinuities = shadows_on(scene, &prepared, &visibility, Some(least_share), clock, progress)?;
    Ok(Traced { prepared, discontinuities })
}

/// The faces of a scene, and what sees what.
pub(crate) fn faces_of(
    scene: &Scene,
    prepare: PrepareSettings,
    clock: &mut Clock,
    progress: Progress<'_>,
) -> Result<(Prepared, Visibility), BakeError> {
    scene.validate()?;
    let (prepared, visibility) = hidden::faces_in_sight(scene, prepare, progress)?;
    check(|| prepared.validate().map_err(|error| error.to_string()));
    clock.end_of(Stage::Prepare);
    Ok((prepared, visibility))
}

/// The d-segments on them; none where no `least_share` is given.
pub(crate) fn shadows_on(
    scene: &Scene,
    prepared: &Prepared,
    visibility: &Visibility,
    least_share: Option<f64>,
    clock: &mut Clock,
    progress: Progress<'_>,
) -> Result<Discontinuities, BakeError> {
    let discontinuities = match least_share {
        Some(share) => discontinuity::find(scene, prepared, visibility, share, progress)?,
        None => Discontinuities::default(),
    };
    clock.end_of(Stage::Discontinuity);
    Ok(discontinuities)
}

/// Fails where the faces alone are more triangles than are allowed.
pub(crate) fn check_triangles(scene: &Scene, prepared: &Prepared, settings: &BakeSettings) -> Result<(), BakeError> {
    let (asked, needed) = (settings.shade_within(0).max_triangles, triangles_needed(scene, prepared));
    if needed > asked { Err(BakeError::TooFewTriangles { asked, needed }) } else { Ok(()) }
}

/// A scene's hierarchy of patches, and what it came from: the stages up to `transport`.
#[derive(Clone, Debug)]
pub struct Meshed {
    /// The faces.
    pub prepared: Prepared,
    /// The emitters and d-segments.
    pub discontinuities: Discontinuities,
    /// The patches that carry transport.
    pub mesh: Mesh,
}

/// Runs the stages up to `transport`: what cut every patch is in the result.
///
/// # Errors
/// A [`BakeError`] where the scene is refused or the callback cancels.
pub fn subdivided(scene: &Scene, settings: &BakeSettings, progress: Progress<'_>) -> Result<Meshed, BakeError> {
    mesh_and_link(scene, settings, &mut Clock::start(), progress).map(|linked| linked.meshed)
}

/// The stages up to `transport`.
#[derive(Debug)]
pub(crate) struct Linked {
    pub(crate) meshed: Meshed,
    pub(crate) visibility: Visibility,
    pub(crate) links: Links,
}

/// The stages up to `transport`.
pub(crate) fn mesh_and_link(
    scene: &Scene,
    settings: &BakeSettings,
    clock: &mut Clock,
    progress: Progress<'_>,
) -> Result<Linked, BakeError> {
    let (prepared, visibility) = faces_of(scene, settings.prepare, clock, progress)?;
    check_triangles(scene, &prepared, settings)?;
    let least_share = settings.discontinuities.then(|| settings.weak_share());
    let discontinuities = shadows_on(scene, &prepared, &visibility, least_share, clock, progress)?;
    link(scene, settings, (Traced { prepared, discontinuities }, visibility), clock, progress)
}

/// The stage `transport` over faces and d-segments.
pub(crate) fn link(
    scene: &Scene,
    settings: &BakeSettings,
    (Traced { prepared, discontinuities }, visibility): (Traced, Visibility),
    clock: &mut Clock,
    progress: Progress<'_>,
) -> Result<Linked, BakeError> {
    let mesh_settings = settings.mesh(discontinuities.mean_irradiance);
    let mut mesh = Mesh::new(&prepared, &discontinuities.segments, mesh_settings);
    let form_factor = settings.form_factor_oracle(&prepared);
    let fits_samples = settings.fits_samples(&prepared);
    let brightness = match settings.oracle {
        OracleKind::Brightness if !fits_samples => {
            BrightnessOracle::new(form_factor, scene, &prepared, &visibility, &mesh)
        }
        _ => None,
    };
    let [linking, evening] = [[0.0, 0.5], [0.5, 1.0]].map(|part| progress.part(Stage::Transport, part));
    let begin = Instant::now();
    let links = match brightness {
        None if fits_samples => {
            transport::subdivide_all(&prepared, &visibility, &mut mesh, &form_factor, linking)?;
            Links::default()
        }
        Some(oracle) => transport::link_all(&prepared, &visibility, &mut mesh, &oracle, linking)?,
        None if settings.d0_before_links => {
            transport::link_all(&prepared, &visibility, &mut mesh, &form_factor, linking)?
        }
        None => transport::link_all(&prepared, &visibility, &mut mesh, &PaperOracle(form_factor), linking)?,
    };
    clock.linking_s = begin.elapsed().as_secs_f64();
    if settings.shade.tolerance.is_finite() {
        let direct = DirectLight::new(scene, &prepared, &visibility);
        transport::split_where_uneven(scene, &prepared, &direct, &mut mesh, evening)?;
    }
    clock.end_of(Stage::Transport);
    Ok(Linked { meshed: Meshed { prepared, discontinuities, mesh }, visibility, links })
}

/// Edges close before faces that show light.
fn near_edges_of(scene: &Scene, prepared: &Prepared) -> Vec<DSegment> {
    let least_m = shade::least_of_fit_m(total_area_m2(prepared));
    discontinuity::near_edges(prepared, least_m, |face| prepared.shows_light(scene, face))
}

/// What every patch that is not split reflects, for the secondary sources.
fn what_patches_reflect(mesh: &Mesh, solution: &Solution) -> Vec<Reflecting> {
    let boundary = |leaf| mesh.boundary(leaf).iter().map(|at| (at.vertex, mesh.vertex_m(at.vertex))).collect();
    let reflecting = |leaf| Reflecting {
        face: mesh.patch(leaf).face,
        boundary: boundary(leaf),
        reflected: solution.reflected[leaf].mean,
    };
    mesh.leaves().map(reflecting).collect()
}

/// In debug builds, a broken promise of a stage is a panic with its values.
fn check(validate: impl Fn() -> Result<(), String>) {
    if cfg!(debug_assertions) {
        let broken = validate().err();
        assert!(broken.is_none(), "{broken:?}");
    }
}

/// Median and 5th percentile of the compactness of all leaves.
fn compactness_of(mesh: &Mesh) -> [f64; 2] {
    let mut all: Vec<f64> = mesh.leaves().map(|leaf| mesh.compactness(leaf)).collect();
    all.sort_by(f64::total_cmp);
    [0.5, 0.05].map(|share| all.get((share * all.len() as f64) as usize).copied().unwrap_or(0.0))
}
