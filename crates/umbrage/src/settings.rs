//! How a scene is baked: what a caller may ask for, and what follows from the tolerance where nothing is asked.

use std::fmt;
use std::str::FromStr;

use crate::geometry::polygon;
use crate::mesh::{MeshSettings, SplitScore};
use crate::prepare::{PrepareSettings, Prepared};
use crate::scene::Scene;
use crate::shade::ShadeSettings;
use crate::solve::SolveSettings;
use crate::transport::{FormFactorOracle, OracleKind};

/// `Fmax` at the default tolerance.
const FMAX: f64 = 0.04;
/// Where no smallest area is given, this share of the area of all faces at the default tolerance: 1,500 patches if all were
/// as small.
const MIN_AREA_OF_TOTAL: f64 = 7e-4;

/// Light that is gathered to be shown alone may err so many times what it may where it bounces: there errors of one direction add up
/// from bounce to bounce.
const TO_BE_SHOWN: f64 = 3.0;

/// About how many processor seconds gathers by faces take for each face at a tolerance of 1; they grow as one over the tolerance.
/// Measured at 0.01 and 0.02 on the Cornell box, a spiral, a curtain, 36 chair legs, two furnished rooms: within a factor of three.
const FACE_S: f64 = 3e-4;
/// The same for fits to samples: for texels, and at a tolerance of 1, as one over its square. So much it takes in rooms where small bright
/// places give much of the light; where none do, a tenth.
const TEXELS_S: f64 = 0.3;
const SAMPLES_S: f64 = 8.5e-4;

/// Shadow edges of lamps are cut at once where light jumps by so many tolerances of its mean. Of lamps that each give
/// less, as many as give the mean at a point cast so many weaker lines that cuts along all of them would grow with the
/// square of the lamps; refinement cuts the ones that it finds to matter.
const JUMP_OF_TOLERANCE: f64 = 10.0;

/// What gathers reflected light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GatherKind {
    /// The one that is expected to be faster.
    #[default]
    Fastest,
    /// Exact gathers at points, face by face, over the hierarchy and its links.
    Faces,
    /// Fits to scattered samples, from texels.
    Regression,
}

impl fmt::Display for GatherKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Fastest => "fastest",
            Self::Faces => "faces",
            Self::Regression => "regression",
        })
    }
}

/// The name is that of no way to gather light.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no gather {0:?}: use fastest, faces or regression")]
pub struct ParseGatherError(String);

impl FromStr for GatherKind {
    type Err = ParseGatherError;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let all = [Self::Fastest, Self::Faces, Self::Regression];
        all.into_iter().find(|kind| kind.to_string() == name).ok_or_else(|| ParseGatherError(name.to_owned()))
    }
}

/// How a scene is baked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeSettings {
    /// Fmax: pairs of patches with a greater form factor estimate are subdivided; `None`: as the tolerance asks.
    pub max_form_factor: Option<f64>,
    /// A patch smaller than this is not split for its form factor, in square metres; `None`: a share of the scene, as the
    /// tolerance asks.
    pub min_area_m2: Option<f64>,
    /// What decides which pairs of patches are subdivided.
    pub oracle: OracleKind,
    /// Whether a patch that holds a split-hint of degree 0 is split before it is linked, whatever the oracle says.
    pub d0_before_links: bool,
    /// What `point_split` minimises.
    pub score: SplitScore,
    /// Whether badly shaped patches get point split-hints.
    pub mend_bad_shapes: bool,
    /// How faces are made.
    pub prepare: PrepareSettings,
    /// Whether shadow boundaries are calculated and cut into the mesh.
    pub discontinuities: bool,
    /// d-segments that change irradiance by less than this share of the tolerance are left out; 0 keeps all.
    pub weak_of_tolerance: f64,
    /// Whether those of what reflects much are calculated, too.
    pub secondary_sources: bool,
    /// What gathers reflected light.
    pub gather: GatherKind,
    /// When the iteration ends.
    pub solve: SolveSettings,
    /// How finely light is shown.
    pub shade: ShadeSettings,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            max_form_factor: None,
            min_area_m2: None,
            oracle: OracleKind::default(),
            d0_before_links: true,
            score: SplitScore::default(),
            mend_bad_shapes: true,
            prepare: PrepareSettings::default(),
            discontinuities: true,
            weak_of_tolerance: 1.0,
            secondary_sources: true,
            gather: GatherKind::default(),
            solve: SolveSettings::default(),
            shade: ShadeSettings::default(),
        }
    }
}

impl BakeSettings {
    /// The algorithm as the paper prints it: patches are split where the form factor estimate is above Fmax, along their hints or
    /// by Eq. (1), and linked; then D0 hints are removed, and what is left is cut into triangles and shown. No mending of
    /// shapes, no d-segments of what reflects, no refinement.
    pub fn as_in_paper() -> Self {
        Self {
            oracle: OracleKind::FormFactor,
            d0_before_links: false,
            score: SplitScore::Eq1,
            mend_bad_shapes: false,
            secondary_sources: false,
            shade: ShadeSettings { tolerance: f64::INFINITY, ..ShadeSettings::default() },
            ..Self::default()
        }
    }

    /// d-segments weaker than this share of the mean irradiance are not looked at.
    pub(crate) fn weak_share(&self) -> f64 {
        if self.shade.tolerance.is_finite() { self.weak_of_tolerance * self.shade.tolerance } else { 0.0 }
    }

    /// `Fmax`, given or as the tolerance asks.
    pub fn fmax(&self) -> f64 {
        self.max_form_factor.unwrap_or_else(|| FMAX * self.coarseness())
    }

    /// How much coarser the hierarchy, and what light is gathered from, may be than at the default tolerance: what the light itself
    /// errs goes nearly with `Fmax`, but is only a part of the error.
    pub(crate) fn coarseness(&self) -> f64 {
        let tolerance = self.shade.tolerance;
        if tolerance.is_finite() {
            (tolerance / ShadeSettings::default().tolerance).sqrt().clamp(0.1, 3.0)
        } else {
            1.0
        }
    }

    /// How many times what it may at the default tolerance light may err that is gathered to be shown alone.
    pub(crate) fn coarser_to_be_shown(&self) -> f64 {
        TO_BE_SHOWN * self.coarseness()
    }

    /// Whether reflected light is fitted to samples.
    pub(crate) fn fits_samples(&self, prepared: &Prepared) -> bool {
        match self.gather {
            // The paper's oracle decides about links: it is heeded, however many there are.
            _ if !self.shade.tolerance.is_finite() || self.oracle == OracleKind::FormFactor => false,
            GatherKind::Faces => false,
            GatherKind::Regression => true,
            GatherKind::Fastest => self.is_faster_from_samples(prepared.faces.len()),
        }
    }

    /// Whether fits to samples are expected to take less time than gathers by faces, in a scene of so many.
    fn is_faster_from_samples(&self, faces: usize) -> bool {
        let tolerance = self.shade.tolerance;
        TEXELS_S + SAMPLES_S / (tolerance * tolerance) < FACE_S * faces as f64 / tolerance
    }

    /// How light is shown with `apart` triangles that are added to the baked mesh afterwards: the one place that says how
    /// many refinement may make.
    pub(crate) fn shade_within(&self, apart: usize) -> ShadeSettings {
        let most = self.shade.max_triangles;
        let max_triangles = if most == usize::MAX { most } else { most.saturating_sub(apart) };
        ShadeSettings { max_triangles, ..self.shade }
    }

    /// How patches are split under light of this mean irradiance, in W/m2.
    pub(crate) fn mesh(&self, mean_irradiance: f64) -> MeshSettings {
        let tolerance = self.shade.tolerance;
        // Without refinement nothing asks for the cuts that are left out.
        let least_jump = if tolerance.is_finite() { JUMP_OF_TOLERANCE * tolerance * mean_irradiance } else { 0.0 };
        MeshSettings { score: self.score, mend_bad_shapes: self.mend_bad_shapes, least_jump }
    }

    pub(crate) fn form_factor_oracle(&self, prepared: &Prepared) -> FormFactorOracle {
        FormFactorOracle {
            max_form_factor: self.fmax(),
            min_area_m2: self
                .min_area_m2
                .unwrap_or_else(|| MIN_AREA_OF_TOTAL * self.coarseness() * total_area_m2(prepared)),
            coplanar_m: prepared.tolerance.coplanar_m(),
        }
    }
}

/// How many triangles the faces of the surfaces that are baked need: with every boundary point anchored, and nothing refined.
pub(crate) fn triangles_needed(scene: &Scene, prepared: &Prepared) -> usize {
    let baked = prepared.faces.iter().filter(|face| scene.surfaces[face.surface].baked);
    // A polygon with n boundary points is n - 2 triangles.
    baked.map(|face| face.sides.iter().map(|side| side.len()).sum::<usize>() - 2).sum()
}

/// Area of all faces, in square metres.
pub(crate) fn total_area_m2(prepared: &Prepared) -> f64 {
    prepared.faces.keys().map(|face| polygon::area_m2(&prepared.polygon_m(face))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::visibility::fixture;
    use glam::DVec3;

    #[test]
    fn samples_are_taken_where_faces_are_many_and_not_against_the_papers_oracle() {
        let settings = |tolerance: f64, oracle| {
            let shade = ShadeSettings { tolerance, ..ShadeSettings::default() };
            BakeSettings { oracle, shade, ..BakeSettings::default() }
        };
        let at = |i: usize| DVec3::new((i % 30) as f64, (i / 30) as f64, (i % 7) as f64);
        let squares: Vec<_> = (0..600).map(|i| fixture::square(at(i), 0.3, true)).collect();
        let many = fixture::prepared(&squares);
        let fits = |oracle| settings(0.1, oracle).fits_samples(&many);
        assert!(fits(OracleKind::Brightness) && !fits(OracleKind::FormFactor));
        // As of exact gathers, at a tolerance that asks for too many samples.
        assert!(!settings(1e-4, OracleKind::Brightness).is_faster_from_samples(300));
    }

    #[test]
    fn what_is_added_afterwards_is_taken_off_what_refinement_may_make() {
        let within = |max_triangles, apart| {
            let shade = ShadeSettings { max_triangles, ..ShadeSettings::default() };
            BakeSettings { shade, ..BakeSettings::default() }.shade_within(apart).max_triangles
        };
        assert_eq!([within(100, 0), within(100, 30), within(10, 30), within(usize::MAX, 30)], [100, 70, 0, usize::MAX]);
    }
}
