//! What the visible part of a source reflects towards a point: a sum down the source's patches.
//!
//! Lambert's sum is linear in contours. So the part of a face that a point sees is found once, and cut along the cuts of
//! its patches by half-planes; edges that a cut leaves twice cancel. A patch stands for its parts where the difference is a
//! trifle. A leaf that varies by more is taken in slices across its gradient:
//!
//! ```text
//!    ____________________          ##  in shadow, as seen from the point: not in the contours
//!   |        |    |######|
//!   |  one   | two|#.....|         the cuts are those of the patch tree, the values its radiosity
//!   |________|____|______|
//! ```

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use crate::geometry::clip;
use crate::id::{PatchId, Table};
use crate::mesh::Mesh;
use crate::scene::Rgb;
use crate::transport::Linear;
use crate::transport::form_factor::contour_factor;
use crate::visibility::ReceiverPoint;

/// Contours of a part of a source: outer ones counter-clockwise seen from its front, holes clockwise.
pub(super) type Part = SmallVec<[Vec<DVec3>; 1]>;

/// A patch stands for its parts, and a slice for its points, where that changes irradiance by no more than this share of
/// its mean: a point gathers over some hundred patches, whose errors partly cancel.
const TRIFLE_OF_MEAN: f64 = 1e-4;
/// And of a change of light, which is smaller.
const TRIFLE_OF_CHANGE: f64 = 5e-5;
/// A leaf is sliced into at most two to this power.
const MOST_HALVINGS: usize = 3;

/// The middle that is seen lies within this share of a part's reach from its centroid: next to the horizon the factor
/// changes by more than an exponential tells.
const MOST_SHIFT: f64 = 0.5;

/// How the radiosity of a patch varies, in the worst colour, in W/m2.
#[derive(Clone, Copy, Debug, Default)]
struct Variation {
    /// How far its linear fit departs from the mean.
    linear: f64,
    /// How far the radiosity of its leaves departs from its linear fit.
    departure: f64,
}

/// What patches reflect.
#[derive(Debug)]
pub(super) struct Reflected<'a> {
    mesh: &'a Mesh,
    /// Radiosity by reflection, `B - M`, in W/m2.
    radiosity: &'a Table<PatchId, Linear<Rgb>>,
    variation: Table<PatchId, Variation>,
    /// A change of irradiance that does not matter, in W/m2.
    trifle: f64,
}

impl<'a> Reflected<'a> {
    /// What the patches of `mesh` reflect, for points whose mean irradiance is `mean`, in W/m2.
    pub(super) fn new(mesh: &'a Mesh, radiosity: &'a Table<PatchId, Linear<Rgb>>, mean: f64) -> Self {
        let mut variation: Table<PatchId, Variation> = vec![Variation::default(); mesh.patch_count()].into();
        for index in (0..mesh.patch_count()).rev() {
            let id = PatchId::from(index);
            let patch = mesh.patch(id);
            let frame = mesh.frame(patch.face);
            let offset = |corner: DVec2, of: PatchId| corner - frame.to_2d(mesh.patch(of).centroid_m);
            let greatest = |corners: Vec<DVec2>, change: &dyn Fn(DVec2) -> Rgb| {
                corners.into_iter().map(|corner| change(corner).abs().max_element()).fold(0.0, f64::max)
            };
            let own = |corner: DVec2| radiosity[id].at(offset(corner, id));
            let linear = greatest(mesh.polygon_2d_m(id), &|corner| own(corner) - radiosity[id].mean);
            let from_part = |part: PatchId| {
                let change = |corner: DVec2| own(corner) - radiosity[part].at(offset(corner, part));
                greatest(mesh.polygon_2d_m(part), &change) + variation[part].departure
            };
            let departure = patch.subpatches.map_or(0.0, |[left, right]| from_part(left).max(from_part(right)));
            variation[id] = Variation { linear, departure };
        }
        Self { mesh, radiosity, variation, trifle: TRIFLE_OF_MEAN * mean }
    }

    /// The same, of a change of light.
    pub(super) fn of_change(self) -> Self {
        Self { trifle: TRIFLE_OF_CHANGE / TRIFLE_OF_MEAN * self.trifle, ..self }
    }

    /// What a patch reflects at a point of its plane, by its linear fit, in W/m2.
    pub(super) fn at(&self, patch: PatchId, point_m: DVec3) -> Rgb {
        let node = self.mesh.patch(patch);
        let frame = self.mesh.frame(node.face);
        self.radiosity[patch].at(frame.to_2d(point_m) - frame.to_2d(node.centroid_m))
    }

    /// The most that a patch reflects anywhere, in the brightest colour, in W/m2.
    pub(super) fn greatest(&self, patch: PatchId) -> f64 {
        let Variation { linear, departure } = self.variation[patch];
        self.radiosity[patch].mean.abs().max_element() + linear + departure
    }

    /// Whether the linear fit of a patch tells what all of it reflects well enough for a point with this factor to it.
    pub(super) fn is_linear(&self, patch: PatchId, factor: f64) -> bool {
        factor * self.variation[patch].departure <= self.trifle
    }

    /// Irradiance at a point by what `part` of a patch reflects, in W/m2.
    pub(super) fn by(&self, receiver: &ReceiverPoint, patch: PatchId, part: &Part) -> Rgb {
        self.by_patch(receiver, patch, part, factor(receiver, part))
    }

    fn by_patch(&self, receiver: &ReceiverPoint, patch: PatchId, part: &Part, factor: f64) -> Rgb {
        if factor <= 0.0 || part.is_empty() {
            return Rgb::ZERO;
        }
        let Variation { linear, departure } = self.variation[patch];
        if self.is_trifle(factor, linear, departure) {
            return factor * self.radiosity_of(receiver, patch, part);
        }
        let node = self.mesh.patch(patch);
        let frame = self.mesh.frame(node.face);
        match (node.subpatches, self.mesh.cut_m(patch)) {
            (Some([left, right]), Some([from_m, to_m])) => {
                let [on_left, on_right] = halves(part, from_m, frame.plane.normal.cross(to_m - from_m));
                let of_left = self::factor(receiver, &on_left);
                self.by_patch(receiver, left, &on_left, of_left)
                    + self.by_patch(receiver, right, &on_right, factor - of_left)
            }
            _ => {
                let [s, t] = self.radiosity[patch].gradient.map(Rgb::element_sum);
                let along = (frame.to_3d(DVec2::new(s, t)) - frame.to_3d(DVec2::ZERO)).normalize_or_zero();
                self.by_slices(receiver, patch, part, factor, along, MOST_HALVINGS)
            }
        }
    }

    /// Irradiance by a part of a leaf whose radiosity changes in the direction `along`.
    fn by_slices(
        &self,
        receiver: &ReceiverPoint,
        leaf: PatchId,
        part: &Part,
        factor: f64,
        along: DVec3,
        halvings_left: usize,
    ) -> Rgb {
        if factor <= 0.0 || part.is_empty() {
            return Rgb::ZERO;
        }
        let heights = || part.iter().flatten().map(|p| p.dot(along));
        let (low_m, high_m) = (heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max));
        let slope = self.radiosity[leaf].gradient.iter().map(|g| g.abs()).sum::<Rgb>().max_element();
        if halvings_left == 0 || self.is_trifle(factor, slope * 0.5 * (high_m - low_m), 0.0) {
            return factor * self.radiosity_of(receiver, leaf, part);
        }
        let centre_m = self.mesh.patch(leaf).centroid_m;
        let at_m = centre_m + (0.5 * (low_m + high_m) - centre_m.dot(along)) * along;
        let [beyond, before] = halves(part, at_m, along);
        let of_beyond = self::factor(receiver, &beyond);
        self.by_slices(receiver, leaf, &beyond, of_beyond, along, halvings_left - 1)
            + self.by_slices(receiver, leaf, &before, factor - of_beyond, along, halvings_left - 1)
    }

    /// Whether a patch's linear fit is as good as its parts. The fit is taken at the middle of what is seen of it, weighted
    /// by the factor to second order: what is left goes with the square of the angle that it spans, which the factor is.
    fn is_trifle(&self, factor: f64, linear: f64, departure: f64) -> bool {
        factor * (factor * linear + departure) <= self.trifle
    }

    /// A patch's linear fit at the middle of a part of it, as seen from a point.
    fn radiosity_of(&self, receiver: &ReceiverPoint, patch: PatchId, part: &Part) -> Rgb {
        let normal = self.mesh.frame(self.mesh.patch(patch).face).plane.normal;
        seen_middle_m(receiver, part, normal).map_or(self.radiosity[patch].mean, |middle_m| self.at(patch, middle_m))
    }
}

/// Lambert's factor of a point to a part of a source.
fn factor(receiver: &ReceiverPoint, part: &Part) -> f64 {
    part.iter().map(|contour| contour_factor(receiver.position_m, receiver.normal, contour)).sum()
}

/// The parts on the side that `towards` points to, and on the other, of a line through `at_m`.
fn halves(part: &Part, at_m: DVec3, towards: DVec3) -> [Part; 2] {
    [1.0, -1.0].map(|sign| {
        let side = |contour: &Vec<DVec3>| clip::where_positive(contour, |p| sign * towards.dot(p - at_m));
        part.iter().map(side).filter(|contour| !contour.is_empty()).collect()
    })
}

/// The middle of a part of a source with the unit normal `normal`, weighted by the factor `cos cos / r^2` of each of its
/// points, which is taken to be exponential over the part; `None` where it has no area.
fn seen_middle_m(receiver: &ReceiverPoint, part: &Part, normal: DVec3) -> Option<DVec3> {
    let (mut moment, mut doubled_m2) = (DVec3::ZERO, 0.0);
    let first = *part.first()?.first()?;
    let triangles = || {
        part.iter()
            .flat_map(|contour| contour.windows(2))
            .map(|pair| (pair[0] - first, pair[1] - first))
            .chain(part.iter().map(|contour| (contour[contour.len() - 1] - first, contour[0] - first)))
            .map(|(p, q)| (p, q, p.cross(q).dot(normal)))
    };
    for (p, q, area) in triangles() {
        moment += area / 3.0 * (p + q);
        doubled_m2 += area;
    }
    if doubled_m2 <= 0.0 {
        return None;
    }
    let centroid = moment / doubled_m2;
    let from_point = first + centroid - receiver.position_m;
    let growth = receiver.normal / receiver.normal.dot(from_point) + normal / normal.dot(from_point)
        - 4.0 * from_point / from_point.length_squared();
    let along = |v: DVec3| v * v.dot(growth);
    let spread = triangles().map(|(p, q, area)| area / 12.0 * (along(p) + along(q) + along(p + q))).sum::<DVec3>()
        / doubled_m2
        - along(centroid);
    let reach_m = part.iter().flatten().map(|&p| p.distance(first + centroid)).fold(0.0, f64::max);
    // On the horizon itself the factor's growth is infinite.
    let shift = spread.clamp_length_max(MOST_SHIFT * reach_m);
    Some(first + centroid + if shift.is_finite() { shift } else { DVec3::ZERO })
}
