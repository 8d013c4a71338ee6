//! Gathering at one point: which patches it sees, and how much of each.
//!
//! ```text
//! gather(cluster) {
//!     if (below the horizon, or hidden by a screen)   return;
//!     if (far away and faint)                         one ray tells for all of it
//!     else if (cluster has parts)                     gather(each part)
//!     else                                            add_patch(each face)
//! }
//! ```

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::crowd::{CrowdTerm, CrowdView, drawn};
use super::irradiance::{Irradiance, ReflectingPatch};
use super::reflected::Term;
use crate::id::{ClusterId, FaceId, PatchId};
use crate::transport::form_factor::factor_in_view;
use crate::visibility::{FlatSource, PlaneView, ReceiverPoint, Screens};

/// Below this share of what is weak a patch is faint: one ray tells whether it is seen.
const FAINT_OF_WEAK: f64 = 0.25;
/// Rays to a weak patch above that.
const RAYS: usize = 4;
/// A patch with subpatches is looked at as a whole past at most so many faces: the time that shadows take grows with the square
/// of their number.
const MOST_BETWEEN: usize = 12;
/// What is seen of a weak patch past no more than so many faces is found exactly: that takes no longer than a few rays.
const FEW_BETWEEN: usize = 3;
/// A faint patch farther away than so many of its radii is a point: what that errs of its factor is about a hundredth.
const FAR_RADII: f64 = 8.0;
/// Faces that together could not bring more than this share of what is weak are a crowd, where they are far away.
const CROWD_OF_WEAK: f64 = 0.1;

/// The terms of a point, as they are found.
pub(super) struct Gathering<'a, F> {
    light: &'a Irradiance<'a>,
    receiver: &'a ReceiverPoint,
    screens: Screens<'a>,
    /// What stopped the last ray that was stopped: often it stops the next one, too.
    stopped_by: Option<FaceId>,
    /// Takes the terms of patches.
    add: F,
}

/// A plane as the point sees it.
#[derive(Clone, Copy)]
struct Sight<'a> {
    view: PlaneView,
    /// The faces that may stand between; all where none are given.
    among: Option<&'a [FaceId]>,
}

impl<'a, F: FnMut(Term)> Gathering<'a, F> {
    pub(super) fn new(light: &'a Irradiance<'a>, receiver: &'a ReceiverPoint, add: F) -> Self {
        Self { light, receiver, screens: Screens::new(light.visibility, receiver), stopped_by: None, add }
    }

    /// Adds the terms of patches that are not in crowds; those of crowds are returned.
    pub(super) fn gather(&mut self) -> Vec<CrowdTerm> {
        let (light, visibility, receiver) = (self.light, self.light.visibility, self.receiver);
        let mut of_crowds = Vec::new();
        let mut open: SmallVec<[ClusterId; 64]> = visibility.whole_cluster().into_iter().collect();
        while let Some(id) = open.pop() {
            if light.most[id] <= 0.0 {
                continue;
            }
            let cluster = visibility.cluster(id);
            let Some(view) = CrowdView::new(receiver.position_m, receiver.normal, &cluster) else { continue };
            if self.screens.hide(cluster.middle_m, cluster.half_m) {
                continue;
            }
            if view.most(light.most[id]).is_some_and(|most| most < CROWD_OF_WEAK * light.weak) {
                if self.sees_crowd(id, view.towards()) {
                    of_crowds.push(view.term(id));
                }
                continue;
            }
            open.extend(cluster.parts.into_iter().flatten());
            for face in visibility.cluster_faces(id) {
                let [middle_m, half_m] = visibility.box_m(face);
                if !self.screens.hide(middle_m, half_m) {
                    self.gather_from(face);
                }
            }
        }
        of_crowds
    }

    /// Adds the terms of the patches of a face.
    pub(super) fn gather_from(&mut self, face: FaceId) {
        let root = self.light.mesh.root(face);
        if let Some(view) = self.light.visibility.view(self.receiver, &self.light.sources[root].source) {
            self.add_patch(&Sight { view, among: None }, root);
        }
    }

    /// Whether a ray to one of its faces sees a crowd, which sends `towards` the point.
    fn sees_crowd(&mut self, crowd: ClusterId, towards: DVec3) -> bool {
        let light = self.light;
        let sent = |face: FaceId| {
            let ReflectingPatch { source, area_m2, greatest, .. } = &light.sources[light.mesh.root(face)];
            source.frame.plane.normal.dot(towards).max(0.0) * area_m2 * greatest.max(0.0)
        };
        drawn(light.visibility, &light.crowds, sent, crowd, towards).is_some_and(|face| {
            let ReflectingPatch { source, middle_m, .. } = &light.sources[light.mesh.root(face)];
            let to_m = source.frame.to_3d(*middle_m);
            // A ray to what lies below the horizon would leave through the receiver's own plane.
            self.receiver.normal.dot(to_m - self.receiver.position_m) > 0.0 && self.sees(None, source, to_m)
        })
    }

    /// Adds the terms of a patch.
    fn add_patch(&mut self, sight: &Sight<'_>, patch: PatchId) {
        let (light, view) = (self.light, &sight.view);
        let reflecting = &light.sources[patch];
        let height_m = view.over_horizon_m(reflecting.middle_m);
        if reflecting.greatest <= 0.0 || height_m <= -reflecting.radius_m {
            return;
        }
        let faint = FAINT_OF_WEAK * light.weak;
        let most = |factor: f64| reflecting.greatest * factor;
        let from_afar = reflecting.factor_from_afar(view).filter(|&factor| most(factor) < faint);
        let factor = from_afar.unwrap_or_else(|| reflecting.factor(view));
        let most = most(factor);
        if most <= 0.0 {
            return;
        }
        let is_weak = most < light.weak;
        let subpatches = light.reflected.subpatches(patch);
        if is_weak && subpatches.is_some() && !light.reflected.is_linear(patch, factor) {
            return subpatches.into_iter().flatten().for_each(|part| self.add_patch(sight, part));
        }
        if most < faint && height_m > 0.0 {
            let at_m = reflecting.source.frame.to_3d(reflecting.middle_m);
            if self.sees(sight.among, &reflecting.source, at_m) {
                (self.add)(light.reflected.term_of_whole(view, patch, factor));
            }
            return;
        }
        let Some(beam) = light.visibility.beam(self.receiver, *view, &reflecting.source) else { return };
        let between = light.visibility.between(&beam, sight.among);
        let sight = Sight { among: Some(&between), ..*sight };
        if is_weak && between.len() > FEW_BETWEEN {
            return self.add_rays(&sight, patch, factor);
        }
        if between.len() > MOST_BETWEEN && subpatches.is_some() {
            return subpatches.into_iter().flatten().for_each(|part| self.add_patch(&sight, part));
        }
        let seen = light.visibility.seen_past(beam, &between);
        if !seen.is_nothing() {
            light.reflected.add_terms(view, patch, seen, &mut self.add);
        }
    }

    /// Adds what a few rays see of a patch of this factor, as if it were so all over it above the horizon.
    fn add_rays(&mut self, sight: &Sight<'_>, patch: PatchId, factor: f64) {
        let ReflectingPatch { source, middle_m, .. } = &self.light.sources[patch];
        let view = &sight.view;
        let mut whole = 0.0;
        let mut seen: SmallVec<[(f64, DVec2); RAYS]> = SmallVec::new();
        for ray in 0..RAYS {
            // Half way from the middle to corners that are spread around.
            let at_m = middle_m.midpoint(source.corners_m[ray * source.corners_m.len() / RAYS]);
            let along = view.towards_m(at_m);
            let exchange = view.normal.dot(along).max(0.0) * view.height_m / along.length_squared().powi(2);
            whole += exchange;
            if exchange > 0.0 && self.sees(sight.among, source, source.frame.to_3d(at_m)) {
                seen.push((exchange, at_m));
            }
        }
        for (exchange, at_m) in seen {
            (self.add)(Term::new(patch, factor * exchange / whole, at_m - *middle_m));
        }
    }

    /// Whether a point of a source is seen past some faces, or past all where none are given.
    fn sees(&mut self, among: Option<&[FaceId]>, source: &FlatSource, to_m: DVec3) -> bool {
        let (visibility, source) = (self.light.visibility, Some(source.plane));
        if self.stopped_by.is_some_and(|face| visibility.stops(face, self.receiver, to_m, source)) {
            return false;
        }
        let stopper = visibility.stopper(self.receiver, to_m, source, among);
        if let Some(face) = stopper {
            self.screens.note(face);
            self.stopped_by = stopper;
        }
        stopper.is_none()
    }
}

impl ReflectingPatch {
    /// Factor of a point to the patch, if nothing stood between.
    fn factor(&self, view: &PlaneView) -> f64 {
        let above = view.above_horizon(&self.source.corners_m);
        factor_in_view(view, above.as_deref().unwrap_or(&self.source.corners_m)).max(0.0)
    }

    /// The same as if it were a point, where it is far away and wholly above the horizon.
    fn factor_from_afar(&self, view: &PlaneView) -> Option<f64> {
        let towards = view.towards_m(self.middle_m);
        let (over_m, squared) = (view.normal.dot(towards), towards.length_squared());
        let is_far = squared >= (FAR_RADII * self.radius_m).powi(2) && over_m >= self.radius_m;
        is_far.then(|| self.area_m2 * over_m * view.height_m / (PI * squared * squared))
    }
}
