//! Baking again after lamps or colours changed, from what a bake before left: `umbrage bake --reuse`.
//!
//! Nearly all of a bake's time goes into what points and patches see of each other. That depends on where surfaces are, and not on how
//! bright or of what colour. So a bake may keep it ([`bake_to_reuse`]), and another one of the same faces takes it from there
//! ([`rebake`]). It is the same bake, stage by stage, but for what it need not find again:
//!
//! | what changed since | prepare | d-segments | patches, links | bounces | direct light | gathered light |
//! |---|---|---|---|---|---|---|
//! | nothing, or all light by one factor for each colour | anew | kept | kept | none | sums | sums |
//! | brightness of some lamps, colours of surfaces | anew | kept | kept, split further where light is uneven now | sums | sums | sums |
//! | a lamp moved, came, or went; a material that begins or ends to emit | anew | anew | as above | sums | of that lamp | sums |
//! | a corner of a polygon, the settings of the bake | refused | | | | | |
//!
//! A sum is what is left of gathering at a point: factors times what patches reflect now. Points are known by their bits
//! ([`crate::visibility::Memory`]). Refinement runs anew for the new light, asks for points as it needs them, and those that nobody
//! asked for before are found: so the mesh follows the new light, the tolerance holds, and the estimate of the error is one of this
//! bake. What it does not do is to look closer at what was dim and is bright: patches and links, and how closely a point looked at a
//! patch, are those that were good for the light before.
//!
//! Holds:
//! - where nothing changed, the same bytes come out as from the bake that was kept, and as from [`crate::bake::bake`];
//! - where all light changed by a power of two, every vertex has exactly that times the light;
//! - what is kept is checked before it is used: nothing in it can cause a panic, and where it does not fit, [`NotReusable`] says why.

mod faces;
mod lights;

use serde::{Deserialize, Serialize};

use faces::Faces;
use lights::Lights;

use crate::bake::{
    Bake, BakeError, BakeNotes, BakeSettings, Before, Clock, Known, Linked, Lit, Meshed, check_triangles,
    mesh_and_link, show, solve,
};
use crate::discontinuity::{self, DSegment, Discontinuities};
use crate::hidden;
use crate::id::PatchId;
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::progress::{Progress, Stage};
use crate::scene::{Rgb, Scene};
use crate::shade::Terms;
use crate::transport::{self, DirectLight, KnownSources, Linear, Link, Links, SourceMemory, SourcesSeen};
use crate::visibility::{AtPoints, Visibility};

/// No form factor is more than 1, but for rounding.
const MOST_FACTOR: f64 = 1.0 + 1e-6;

/// What a bake leaves for another one of the same faces.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Kept {
    /// All settings, as they are printed for debugging: numbers to the last bit.
    settings: String,
    faces: Faces,
    lights: Lights,
    /// Those that lamps and emitters cast: with `splits`, what makes the patches that carry transport again.
    segments: Vec<DSegment>,
    /// Those that count in dim places alone.
    faint: Vec<DSegment>,
    /// What they were measured against, in W/m2.
    mean_irradiance: f64,
    /// Those of what reflects much.
    secondary: Vec<DSegment>,
    splits: Vec<PatchId>,
    links: Vec<Link>,
    /// What links missed of reflected light, of each patch.
    missed: Vec<Linear<Rgb>>,
    /// What points see of the light sources.
    sources: AtPoints<SourcesSeen>,
    /// What points of the patches that carry transport see of each other.
    bounced: AtPoints<Terms>,
    /// What points see of these patches where indirect light is gathered to be shown.
    gathered: AtPoints<Terms>,
}

/// What changed since the bake before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Change {
    /// Nothing, or all light by one factor for each colour.
    Strength,
    /// How bright some lamps are, or what surfaces reflect.
    Light,
    /// Which lamps there are and where, or which surfaces emit.
    Lamps,
}

/// Why a bake cannot be taken up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotReusable {
    /// It was done with other settings.
    #[error("it was baked with other options")]
    Settings,
    /// It is one of other surfaces, or light reached other regions than now, so that other sides were hidden.
    #[error("surfaces moved, came or went since, or light reaches sides that were hidden")]
    Surfaces,
    /// What is kept of it contradicts itself.
    #[error("it contradicts itself")]
    Damaged,
}

/// Why a scene was not baked again.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RebakeError {
    /// The bake before cannot be taken up: bake as if there were none.
    #[error(transparent)]
    NotReusable(#[from] NotReusable),
    /// The scene was not baked.
    #[error(transparent)]
    Bake(#[from] BakeError),
}

impl Kept {
    /// Whether what it says of faces is about faces that are there. What comes from a file is checked, so that nothing in it can cause a
    /// panic.
    fn fits(&self, prepared: &Prepared, visibility: &Visibility) -> bool {
        let (faces, extent_m) = (prepared.faces.len(), prepared.tolerance.extent_m);
        let counts = (self.missed.len(), visibility.cluster_count());
        let of_face = |segment: &DSegment| {
            segment.face.index() < faces
                && segment.ends_m.iter().all(|end_m| end_m.is_finite())
                && segment.strength.is_finite()
        };
        let terms =
            |known: &AtPoints<Terms>| known.is_ordered() && known.iter().all(|terms| terms.fits(counts, extent_m));
        self.lights.fits(faces)
            && self.mean_irradiance.is_finite()
            && self.segments.iter().chain(&self.faint).chain(&self.secondary).all(of_face)
            && self.sources.is_ordered()
            && self.sources.iter().all(|seen| seen.fits(faces, self.lights.lamps.len()))
            && terms(&self.bounced)
            && terms(&self.gathered)
    }

    /// Whether what it says of patches is about the patches of `mesh`.
    fn fits_mesh(&self, mesh: &Mesh) -> bool {
        let is_there = |link: &Link| link.receiver.index().max(link.source.index()) < mesh.patch_count();
        let possible = |link: &Link| {
            (0.0..=MOST_FACTOR).contains(&link.form_factor)
                && link.gradient.is_finite()
                && link.moment_factor.is_finite()
        };
        let finite = |missed: &Linear<Rgb>| missed.mean.is_finite() && missed.gradient.iter().all(|g| g.is_finite());
        self.missed.len() == mesh.patch_count()
            && self.missed.iter().all(finite)
            && self.links.iter().all(|link| is_there(link) && possible(link))
    }
}

/// Bakes a scene as [`crate::bake::bake`] does, and keeps what another bake can take up.
///
/// # Errors
/// A [`BakeError`] where the scene is refused or the callback cancels.
pub fn bake_to_reuse(
    scene: &Scene,
    settings: &BakeSettings,
    progress: Progress<'_>,
) -> Result<(Bake, Kept), BakeError> {
    let mut clock = Clock::start();
    let mut linked = mesh_and_link(scene, settings, &mut clock, progress)?;
    let notes = BakeNotes::default();
    let before = Before::ToBeNoted(&notes);
    let solved = solve(scene, settings, &mut linked, &before, progress)?;
    let Lit { bake, secondary, missed, bounced } = show(scene, settings, &linked, solved, &before, clock, progress)?;
    let Linked { meshed: Meshed { prepared, discontinuities, mesh }, links, .. } = linked;
    let kept = Kept {
        settings: format!("{settings:?}"),
        faces: Faces::of(&prepared),
        lights: Lights::of(scene, &prepared),
        mean_irradiance: discontinuities.mean_irradiance,
        segments: discontinuities.segments.into(),
        faint: discontinuities.faint,
        secondary: secondary.into(),
        splits: mesh.splits_asked().to_vec(),
        links: links.as_slice().to_vec(),
        missed: missed.into(),
        sources: notes.sources.finish(),
        bounced,
        gathered: notes.gathered.finish(),
    };
    Ok((bake, kept))
}

/// Bakes a scene from what a bake before left, and says what changed since.
///
/// # Errors
/// [`NotReusable`] where surfaces or settings are others; a [`BakeError`] where the scene is refused or the callback cancels.
pub fn rebake(
    scene: &Scene,
    settings: &BakeSettings,
    kept: &Kept,
    progress: Progress<'_>,
) -> Result<(Bake, Change), RebakeError> {
    if kept.settings != format!("{settings:?}") {
        return Err(NotReusable::Settings.into());
    }
    let mut clock = Clock::start();
    scene.validate().map_err(BakeError::from)?;
    let (prepared, visibility) = hidden::faces_in_sight(scene, settings.prepare, progress).map_err(BakeError::from)?;
    if kept.faces != Faces::of(&prepared) {
        return Err(NotReusable::Surfaces.into());
    }
    check_triangles(scene, &prepared, settings)?;
    if !kept.fits(&prepared, &visibility) {
        return Err(NotReusable::Damaged.into());
    }
    clock.end_of(Stage::Prepare);

    let lights = Lights::of(scene, &prepared);
    let (change, factor) = lights.since(&kept.lights);
    let discontinuities = if change == Change::Lamps && settings.discontinuities {
        discontinuity::find(scene, &prepared, &visibility, settings.weak_share(), progress).map_err(BakeError::from)?
    } else {
        let (segments, faint) = (kept.segments.clone().into(), kept.faint.clone());
        Discontinuities { segments, faint, mean_irradiance: kept.mean_irradiance, ..Discontinuities::default() }
    };
    clock.end_of(Stage::Discontinuity);

    let mut mesh = Mesh::new(&prepared, &kept.segments.clone().into(), settings.mesh(kept.mean_irradiance));
    if !mesh.split_as(&kept.splits) || !kept.fits_mesh(&mesh) {
        return Err(NotReusable::Damaged.into());
    }
    let links = Links::new(kept.links.clone(), mesh.patch_count());
    let sources = KnownSources::new(&kept.sources, &kept.lights.emitters, &kept.lights.lamps, &scene.lamps);
    if change > Change::Strength && settings.shade.tolerance.is_finite() {
        let direct = DirectLight::new(scene, &prepared, &visibility).with_memory(SourceMemory::Known(sources.clone()));
        transport::split_where_uneven(scene, &prepared, &direct, &mut mesh, progress).map_err(BakeError::from)?;
    }
    clock.end_of(Stage::Transport);

    // What links missed of other light is no start: where it was much brighter, more would be taken off than there is.
    let missed =
        (change == Change::Strength).then(|| kept.missed.iter().map(|missed| scaled(missed, factor)).collect());
    let known = Known {
        sources,
        bounced: &kept.bounced,
        gathered: &kept.gathered,
        secondary: kept.secondary.clone().into(),
        missed,
    };
    let mut linked = Linked { meshed: Meshed { prepared, discontinuities, mesh }, visibility, links };
    let before = Before::Known(known);
    let solved = solve(scene, settings, &mut linked, &before, progress)?;
    if solved.solution.validate().is_err() {
        return Err(NotReusable::Damaged.into());
    }
    let lit = show(scene, settings, &linked, solved, &before, clock, progress)?;
    // Numbers that fit their places can still be of no light at all.
    if lit.bake.mesh.validate().is_err() {
        return Err(NotReusable::Damaged.into());
    }
    Ok((lit.bake, change))
}

/// A linear function times a factor for each colour.
fn scaled(of: &Linear<Rgb>, factor: Rgb) -> Linear<Rgb> {
    Linear { mean: factor * of.mean, gradient: of.gradient.map(|along| factor * along) }
}
