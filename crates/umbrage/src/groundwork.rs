//! What bakes of one scene at several tolerances have in common, found once: its faces, what sees what, and the d-segments.
//!
//! A d-segment that is too weak for one tolerance counts at a finer one. So they are found for the finest, and a coarser bake
//! takes the strong ones of them: those that it would have found itself.
//!
//! Holds: [`Groundwork::bake`] makes the same bytes as [`crate::bake::bake`] with the same settings.

use crate::bake::{
    Bake, BakeError, BakeSettings, Before, Clock, Lit, Traced, check_triangles, faces_of, link, shadows_on, show, solve,
};
use crate::discontinuity::{self, Discontinuities};
use crate::prepare::{PrepareSettings, Prepared};
use crate::progress::{Progress, Stage};
use crate::scene::Scene;
use crate::visibility::Visibility;

/// The faces of a scene, and the d-segments on them once they are found.
#[derive(Debug)]
pub struct Groundwork {
    prepare: PrepareSettings,
    prepared: Prepared,
    visibility: Visibility,
    /// With the least share of the mean irradiance that they change.
    shadows: Option<(f64, Discontinuities)>,
    /// What this took, in seconds.
    seconds: Vec<(Stage, f64)>,
}

impl Groundwork {
    /// The faces of a scene, as `settings` has them; no d-segments yet.
    ///
    /// # Errors
    /// A [`BakeError`] where the scene is refused or the callback cancels.
    pub fn new(scene: &Scene, settings: &BakeSettings, progress: Progress<'_>) -> Result<Self, BakeError> {
        let mut clock = Clock::start();
        let (prepared, visibility) = faces_of(scene, settings.prepare, &mut clock, progress)?;
        check_triangles(scene, &prepared, settings)?;
        Ok(Self { prepare: settings.prepare, prepared, visibility, shadows: None, seconds: clock.into_seconds() })
    }

    /// The prepared faces.
    pub fn prepared(&self) -> &Prepared {
        &self.prepared
    }

    /// Finds the d-segments for bakes with `settings` and coarser ones; nothing is done where they are known.
    ///
    /// # Errors
    /// A [`BakeError`] where the callback cancels.
    pub fn find_shadows(
        &mut self,
        scene: &Scene,
        settings: &BakeSettings,
        progress: Progress<'_>,
    ) -> Result<(), BakeError> {
        let share = settings.weak_share();
        if settings.discontinuities && self.shadows.as_ref().is_none_or(|(known, _)| *known > share) {
            let mut clock = Clock::start();
            let found = shadows_on(scene, &self.prepared, &self.visibility, Some(share), &mut clock, progress)?;
            self.shadows = Some((share, found));
            self.seconds.retain(|(stage, _)| *stage != Stage::Discontinuity);
            self.seconds.extend(clock.into_seconds());
        }
        Ok(())
    }

    /// Whether bakes with two settings gather reflected light in the same way, from faces or from samples: if not, what one takes
    /// says little of what the other will.
    pub fn gathers_alike(&self, one: &BakeSettings, other: &BakeSettings) -> bool {
        one.fits_samples(&self.prepared) == other.fits_samples(&self.prepared)
    }

    /// Bakes the scene that this is of. d-segments that were not found for settings as fine are found anew, and not kept.
    ///
    /// # Errors
    /// A [`BakeError`] where the callback cancels, or faces are to be made in another way.
    pub fn bake(&self, scene: &Scene, settings: &BakeSettings, progress: Progress<'_>) -> Result<Bake, BakeError> {
        if settings.prepare != self.prepare {
            return crate::bake::bake(scene, settings, progress);
        }
        check_triangles(scene, &self.prepared, settings)?;
        let mut clock = Clock::after(self.seconds.clone());
        let (prepared, visibility) = (self.prepared.clone(), self.visibility.clone());
        let share = settings.weak_share();
        let discontinuities = match &self.shadows {
            _ if !settings.discontinuities => Discontinuities::default(),
            Some((known, shadows)) if *known <= share => {
                discontinuity::at_least(scene, &prepared, &visibility, shadows, share)
            }
            _ => shadows_on(scene, &prepared, &visibility, Some(share), &mut clock, progress)?,
        };
        let traced = Traced { prepared, discontinuities };
        let mut linked = link(scene, settings, (traced, visibility), &mut clock, progress)?;
        let solved = solve(scene, settings, &mut linked, &Before::Nothing, progress)?;
        let Lit { bake, .. } = show(scene, settings, &linked, solved, &Before::Nothing, clock, progress)?;
        Ok(bake)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::cornell::cornell_box;
    use crate::shade::ShadeSettings;

    #[test]
    fn a_bake_on_known_ground_is_the_bake_alone() {
        let scene = cornell_box();
        let settings = |tolerance| BakeSettings {
            shade: ShadeSettings { tolerance, ..ShadeSettings::default() },
            ..BakeSettings::default()
        };
        let mut ground = Groundwork::new(&scene, &settings(0.05), Progress::silent()).unwrap();
        ground.find_shadows(&scene, &settings(0.05), Progress::silent()).unwrap();
        for tolerance in [0.4, 0.1, 0.05] {
            let there = ground.bake(&scene, &settings(tolerance), Progress::silent()).unwrap();
            let alone = crate::bake::bake(&scene, &settings(tolerance), Progress::silent()).unwrap();
            assert_eq!(there.mesh, alone.mesh);
            assert_eq!(there.report.d_segments, alone.report.d_segments);
        }
        let none = BakeSettings { discontinuities: false, ..settings(0.4) };
        let there = ground.bake(&scene, &none, Progress::silent()).unwrap();
        assert_eq!(there.report.d_segments, [0; 3]);
    }

    #[test]
    fn as_in_the_paper_the_patches_that_carried_light_are_shown() {
        let (scene, mut settings) = (cornell_box(), BakeSettings::as_in_paper());
        settings.prepare.keep_hidden = true;
        let (bake, meshed) = crate::bake::bake_and_keep(&scene, &settings, Progress::silent()).unwrap();
        let mut mesh = meshed.mesh;
        let total_m2: f64 = meshed.prepared.faces.keys().map(|face| mesh.patch(mesh.root(face)).area_m2).sum();
        let split = mesh.patches().filter(|(_, patch)| patch.subpatches.is_some());
        let least_m2 = split.map(|(_, patch)| patch.area_m2).fold(f64::INFINITY, f64::min);
        assert!(least_m2 > 7e-4 * total_m2, "the least size that is split is {least_m2} of {total_m2} m2");
        mesh.remove_d0_hints();
        mesh.triangulate();
        assert_eq!((bake.report.flat_triangles, bake.report.secondary), (0, 0));
        assert_eq!(bake.mesh.triangle_count(), mesh.leaves().count());
        assert!(bake.report.links > 0 && bake.report.patches > meshed.prepared.faces.len());
    }

    #[test]
    fn a_hurried_bake_ends_with_what_it_has() {
        let scene = cornell_box();
        let settings = BakeSettings {
            shade: ShadeSettings { tolerance: 0.02, ..ShadeSettings::default() },
            ..BakeSettings::default()
        };
        let ground = Groundwork::new(&scene, &settings, Progress::silent()).unwrap();
        let whole = ground.bake(&scene, &settings, Progress::silent()).unwrap();
        let hurried = ground.bake(&scene, &settings, Progress::silent().hurried_by(&|| true)).unwrap();
        hurried.mesh.validate().unwrap();
        assert!(hurried.mesh.triangle_count() < whole.mesh.triangle_count() / 2);
        assert!(hurried.report.error > whole.report.error);
    }
}
