//! How much jumps across a d-segment, at a point of it: exactly, from the geometry of its event.
//!
//! An eye at the receiver point `x` sees lines at the distance `r` (source) and `d` (occluder) along one ray. When it
//! moves across the segment by `delta`, whose angle with the event's plane has the sine `sin`, the lines move against
//! each other in the image by the angle `delta sin (1/d - 1/r)`. Irradiance is radiance times the cosine at the
//! receiver, summed over the solid angle that is seen. So there jumps
//! - behind two lines in one plane (degree 1) the slope, by the sum of radiance, cosine and that speed over the angle
//!   in which the lines are seen upon one another (`plane_image`);
//! - behind a corner and a line (degree 2) the curvature, by radiance, cosine, that speed squared, and the jump of
//!   slope of the corner's image (`corner`);
//! - behind three lines (degree 2) the curvature (`strength_of_three`);
//! - in the source's plane the slope, by the sum of radiance and cosine over `r3` and the area that is seen;
//! - behind a lamp without extent (degree 0) the value, by all that it brings;
//! - where light of a lamp ends by itself, value, slope or curvature, from differences (`lamp_curve`);
//! - at a contact (degree 0) the value, at most by what the emitters give there unhindered.

use std::f64::consts::PI;
use std::sync::atomic::AtomicUsize;

use glam::DVec3;
use smallvec::SmallVec;

use super::corner;
use super::features::{Features, Surroundings};
use super::trace;
use super::wedge::{Crossing, Piece, Wedge};
use super::{DSegment, Degree, Emitter, Event};
use crate::geometry::{Plane, polygon};
use crate::id::{EdgeId, EmitterId, FaceId, LampId, PlaneId};
use crate::prepare::Prepared;
use crate::scene::Rgb;
use crate::visibility::Visibility;

/// Three points and weights of Gauss and Legendre on 0 to 1.
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];
/// What is farther by less than this stands upon a line at nearness 1.
const UPON_THE_LINE: f64 = 1.0 - 1e-5;
/// What is farther than a point by this share is behind it.
const BEHIND: f64 = 1e-5;
/// The angle under which lines are seen is divided into so many intervals at least for a sum over it.
const PARTS: usize = 4;

impl Features {
    /// How much jumps across a d-segment of this scene at a point of it: irradiance, or its first or second derivative
    /// across the segment, in W/m2, W/m3 or W/m4 by degree. Mean over the three colours.
    pub fn jump(&self, prepared: &Prepared, visibility: &Visibility, segment: &DSegment, at_m: DVec3) -> f64 {
        Surroundings { prepared, visibility, features: self, wedges: &AtomicUsize::new(0) }.jump(segment, at_m)
    }
}

/// A parabola misses a kink in the middle of its span by this share of kink times span.
const MISSED_KINK: f64 = 1.0 / 32.0;
/// A parabola misses a jump of curvature in the middle of its span by this share of jump times span squared: the least
/// greatest difference of `x |x|` and a multiple of `x` is `3 - 2 sqrt(2)`, an eighth of which counts.
const MISSED_CURVATURE: f64 = 0.021_447;

/// A d-segment in the light of a part of a face must change so many times as much as another to count. That light is
/// soft, and refinement finds its weak shadows with fewer triangles than cuts cost (measured: `docs/events.md`).
const PART_OF_FACE: f64 = 20.0;
/// One of degree 2 besides so many times as much as all light of the part, if its curvature went on over the width of
/// the face: then the penumbra is less than a hundredth of the face wide, and a line to most triangles.
const NARROW: f64 = 500.0;

/// The receiver at a point of a d-segment.
pub(super) struct Receiver {
    pub(super) face: FaceId,
    pub(super) at: DVec3,
    /// Its plane, towards its front.
    pub(super) plane: Plane,
    /// Unit vector in it across the segment.
    across: DVec3,
}

impl Surroundings<'_> {
    fn receiver(&self, segment: &DSegment, at: DVec3) -> Receiver {
        let plane = self.prepared.oriented_plane(segment.face);
        let along = (segment.ends_m[1] - segment.ends_m[0]).normalize_or_zero();
        Receiver { face: segment.face, at, across: plane.normal.cross(along), plane }
    }

    pub(super) fn jump(&self, segment: &DSegment, at: DVec3) -> f64 {
        let receiver = self.receiver(segment, at);
        let jump = match segment.event {
            Event::Contact { .. } => self.of_contact(&receiver),
            Event::LampEdge { lamp, .. } => self.of_lamp(&receiver, lamp),
            Event::LampCurve { lamp, .. } => self.of_lamp_curve(segment, at, receiver.across, lamp),
            Event::SourcePlane { emitter } => self.of_source_plane(&receiver, emitter),
            Event::OccluderPlane { emitter, occluder } => self.of_occluder_plane(&receiver, emitter, occluder),
            Event::EdgeEdge { source, occluder, .. } => self.of_edges(&receiver, source, occluder),
            Event::ThreeEdges { source, occluders, .. } => self.of_three_edges(&receiver, source, occluders),
            Event::VertexEdge { source, occluder, .. } => {
                let corner = self.position(source);
                let behind = self.emitted_behind(at, corner);
                self.of_corner(&receiver, corner, self.ends(occluder), |to_eye, across| {
                    let steps = corner::steps(self.features.corners.at(source), to_eye, corner::emitted(behind));
                    corner::slope_jump(&steps, to_eye, across)
                })
            }
            Event::EdgeVertex { source, occluder, .. } => {
                let corner = self.position(occluder);
                let Some(edge) = self.features.source_edge(source) else { return 0.0 };
                let Some(wedge) = Wedge::new(corner, edge.ends_m, self.weld_m()) else { return 0.0 };
                let behind = self.emitted_behind(at, corner + (corner - at) * wedge.nearness(at).abs());
                let step = edge.step(corner, self.coplanar_m(), behind);
                self.of_corner(&receiver, corner, self.ends(source), |to_eye, across| {
                    let steps = corner::steps(self.features.corners.at(occluder), to_eye, corner::open);
                    corner::slope_jump(&steps, to_eye, across) * step
                })
            }
        };
        jump.abs().element_sum() / 3.0
    }

    /// Whether a d-segment changes irradiance by at least `least`, in W/m2, over the width of its face; of a part of a
    /// face it must be more, and where it is of degree 2 the penumbra must be narrow.
    pub(super) fn counts(&self, segment: &DSegment, least: f64) -> bool {
        let effect = effect(self.prepared, self.visibility, segment);
        let emitter = segment.event.emitter().map(|id| &self.features.emitters[id]);
        let Some(part) = emitter.filter(|emitter| emitter.part_m.is_some()) else { return effect >= least };
        let receiver = self.receiver(segment, segment.ends_m[0].midpoint(segment.ends_m[1]));
        let narrow = || effect >= NARROW * unhindered(&receiver, part).element_sum() / 3.0;
        effect >= PART_OF_FACE * least && (segment.degree != Degree::D2 || narrow())
    }

    /// Behind a corner and a line, one of the source and one of the occluder.
    fn of_corner(
        &self,
        receiver: &Receiver,
        corner: DVec3,
        line: [DVec3; 2],
        slope_jump: impl Fn(DVec3, DVec3) -> Rgb,
    ) -> Rgb {
        let Some(wedge) = Wedge::new(corner, line, self.weld_m()) else { return Rgb::ZERO };
        let to_eye = receiver.at - corner;
        let to_corner_m = to_eye.length();
        // The nearness of the eye on the wedge through the line tells where its ray passes the line.
        let to_line_m = to_corner_m * (1.0 - wedge.nearness(receiver.at)).abs();
        let to_eye = to_eye / to_corner_m;
        let cosine = receiver.plane.normal.dot(to_eye).abs();
        let speed = receiver.across.dot(wedge.plane.normal) * (1.0 / to_line_m - 1.0 / to_corner_m);
        slope_jump(to_eye, wedge.plane.normal) * cosine * speed * speed
    }

    /// Behind a source edge and an occluder edge in one plane.
    fn of_edges(&self, receiver: &Receiver, source: EdgeId, occluder: EdgeId) -> Rgb {
        let (Some(edge), hider) = (self.features.source_edge(source), self.ends(occluder)) else { return Rgb::ZERO };
        let Some(plane) = self.common_plane(edge.ends_m, hider) else { return Rgb::ZERO };
        let Some(image) = self.plane_image(receiver, edge.ends_m, plane) else { return Rgb::ZERO };
        let Some(line) = image.place_of(hider) else { return Rgb::ZERO };
        let behind = self.emitted_behind(receiver.at, line);
        // The hider stands on the receiver's side of the source's line, or part of it does.
        let [from, to] = edge.ends_m;
        let across = plane.normal.cross(to - from);
        let is_before =
            |part: &[DVec3; 2]| across.dot(part[0].midpoint(part[1]) - from) * across.dot(receiver.at - from) > 0.0;
        let Some(part) = edge.parts_beside(&plane, hider, self.coplanar_m()).into_iter().find(is_before) else {
            return Rgb::ZERO;
        };
        image.jump(receiver, edge.sides(plane.normal, part[0].midpoint(part[1]), self.coplanar_m(), behind))
    }

    /// Where the faces of a plane are seen edge-on before an emitter.
    fn of_occluder_plane(&self, receiver: &Receiver, emitter: EmitterId, occluder: PlaneId) -> Rgb {
        let emitter = &self.features.emitters[emitter];
        let plane = self.prepared.planes[occluder].plane;
        let images =
            self.chords(emitter, &plane).into_iter().filter_map(|chord| self.plane_image(receiver, chord, plane));
        images.map(|image| image.jump(receiver, [emitter.radiance; 2])).sum()
    }

    /// In the plane of an emitter. Nothing stands inside a face, so where a ray reaches the near side of a face it sees
    /// all of it edge-on, unless something stands upon that side.
    fn of_source_plane(&self, receiver: &Receiver, emitter: EmitterId) -> Rgb {
        let emitter = &self.features.emitters[emitter];
        let sum: f64 = match &emitter.part_m {
            // No face lies along its sides.
            Some(part_m) => self.grows_beside(receiver, part_m, |_, _| false),
            None => {
                let of_face = |&face: &FaceId| {
                    let sides = &self.prepared.faces[face].sides;
                    let stands_on = |other: FaceId, side: usize| {
                        sides[side].iter().any(|edge| self.prepared.edges[edge.edge].faces.contains(&other))
                    };
                    self.grows_beside(receiver, &self.prepared.polygon_m(face), stands_on)
                };
                emitter.faces.iter().map(of_face).sum()
            }
        };
        emitter.radiance * sum
    }

    /// By how much the slope of irradiance grows in the plane of a source of unit radiance with these corners; whether
    /// a face stands upon a side is told by the number of the side.
    fn grows_beside(&self, receiver: &Receiver, corners: &[DVec3], stands_on: impl Fn(FaceId, usize) -> bool) -> f64 {
        let (inside, n) = (polygon::centroid(corners), corners.len());
        let mut sum = 0.0;
        for i in 0..n {
            let side = [corners[i], corners[(i + 1) % n]];
            let along = (side[1] - side[0]).normalize_or_zero();
            let across = |p: DVec3| (p - side[0]) - (p - side[0]).dot(along) * along;
            if across(inside).dot(across(receiver.at)) >= 0.0 {
                continue;
            }
            // Faces along the other sides stand upon those, if at all.
            let beside = |other: FaceId| (0..n).filter(|&j| j != i).any(|j| stands_on(other, j));
            let Some(view) = self.view(receiver, side, UPON_THE_LINE, beside) else { continue };
            let lines = view.lines((1..n).map(|j| [corners[(i + j) % n], corners[(i + j + 1) % n]]));
            let ends: SmallVec<[f64; 16]> = lines.iter().flat_map(|line| line.s).collect();
            sum += view.sum(
                receiver,
                |s| {
                    let far = lines.iter().filter(|line| line.s[0] < s && s < line.s[1]);
                    1.0 - far.map(|line| line.nearness_at(s)).fold(1.0, f64::min)
                },
                &ends,
            );
        }
        sum
    }

    /// At a contact: what the emitters before the receiver give unhindered, each as a disc of its area that is seen
    /// from its middle.
    fn of_contact(&self, receiver: &Receiver) -> Rgb {
        self.features.emitters.iter().map(|emitter| unhindered(receiver, emitter)).sum()
    }

    /// The radiance that comes to `eye` along the ray that passes `point`, from emitters behind it.
    pub(super) fn emitted_behind(&self, eye: DVec3, point: DVec3) -> Rgb {
        let ray = point - eye;
        let mut nearest = (f64::INFINITY, Rgb::ZERO);
        for emitter in &self.features.emitters {
            let (height_m, slope_m) = (emitter.plane.signed_distance_m(eye), emitter.plane.normal.dot(ray));
            let t = -height_m / slope_m;
            // In front of the emitter, and beyond the point.
            if !(height_m > 0.0 && t > 1.0 + BEHIND && t < nearest.0) {
                continue;
            }
            let at = eye + t * ray;
            let shines = |face: FaceId, corners: &[DVec3]| {
                let inside = |i: usize| {
                    let (from, to) = (corners[i], corners[(i + 1) % corners.len()]);
                    (to - from).cross(at - from).dot(emitter.plane.normal) >= 0.0
                };
                (0..corners.len()).all(inside)
                    && !self.visibility.occluded(point.lerp(at, BEHIND), at, [self.visibility.plane(face); 2])
            };
            let seen = match &emitter.part_m {
                Some(part_m) => shines(emitter.faces[0], part_m),
                None => emitter.faces.iter().any(|&face| shines(face, self.visibility.boundary_m(face))),
            };
            if seen {
                nearest = (t, emitter.radiance);
            }
        }
        nearest.1
    }

    /// At the shadow of a lamp: all that arrives.
    fn of_lamp(&self, receiver: &Receiver, lamp: LampId) -> Rgb {
        let Some(arriving) = self.features.lamps[lamp].arriving(receiver.at) else { return Rgb::ZERO };
        receiver.plane.normal.dot(arriving.towards).max(0.0) * arriving.irradiance
    }

    /// What the receiver point sees of a line on a source, in the plane of both. Faces `but` are looked through.
    ///
    /// What stands upon the line hides it where `up_to` is less than 1.
    fn view(&self, receiver: &Receiver, source: [DVec3; 2], up_to: f64, but: impl Fn(FaceId) -> bool) -> Option<View> {
        let wedge = Wedge::new(receiver.at, source, self.weld_m())?;
        let own = self.prepared.faces[receiver.face].plane;
        let looked_through = |face: FaceId| self.visibility.plane(face) == own || but(face);
        let pieces = wedge.pieces(self.visibility, up_to, looked_through);
        Some(View { hiding: trace::part_at(&pieces, up_to, true), wedge })
    }
}

/// Returns by how much irradiance errs, in W/m2, if it is taken to be smooth over the whole face of a d-segment: what the strength does
/// over the width of the face.
pub(super) fn effect(prepared: &Prepared, visibility: &Visibility, segment: &DSegment) -> f64 {
    let plane = prepared.oriented_plane(segment.face);
    let across = plane.normal.cross((segment.ends_m[1] - segment.ends_m[0]).normalize_or_zero());
    let offsets = visibility.boundary_m(segment.face).iter().map(|corner| across.dot(*corner));
    let (least, most) =
        offsets.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), x| (least.min(x), most.max(x)));
    let width_m = most - least;
    match segment.degree {
        Degree::D0 => f64::INFINITY,
        Degree::D1 => MISSED_KINK * segment.strength * width_m,
        Degree::D2 => MISSED_CURVATURE * segment.strength * width_m * width_m,
    }
}

/// What an emitter before a receiver gives unhindered, as a disc of its area that is seen from its middle.
fn unhindered(receiver: &Receiver, emitter: &Emitter) -> Rgb {
    let ray = emitter.centroid_m - receiver.at;
    let r2 = ray.length_squared().max(f64::MIN_POSITIVE);
    let direction = ray / r2.sqrt();
    let cosines = receiver.plane.normal.dot(direction).max(0.0) * (-emitter.plane.normal.dot(direction)).max(0.0);
    emitter.radiance * (PI * cosines * emitter.area_m2 / (PI * r2 + emitter.area_m2))
}

/// A line on a source, seen from a receiver point.
pub(super) struct View {
    /// From the point to the line.
    pub(super) wedge: Wedge,
    /// What stands between.
    pub(super) hiding: Vec<Piece>,
}

impl View {
    /// The parts of lines in the plane that are seen before or behind this one.
    pub(super) fn lines(&self, lines: impl Iterator<Item = [DVec3; 2]>) -> SmallVec<[Piece; 8]> {
        // Any face id does: these pieces stop nothing.
        lines.filter_map(|ends| self.wedge.piece(FaceId::from(0), Crossing::Through, ends)).collect()
    }

    /// The sum over the angle in which the line is seen of cosine, speed and `factor(direction)`, which is smooth
    /// between `ends`; the speed is that of a line at nearness `factor + 1` against this one.
    pub(super) fn sum(&self, receiver: &Receiver, factor: impl Fn(f64) -> f64, ends: &[f64]) -> f64 {
        let [u, v] = self.wedge.rays;
        let mut cuts: SmallVec<[f64; 16]> = (0..=PARTS).map(|i| i as f64 / PARTS as f64).collect();
        cuts.extend(ends.iter().copied());
        cuts.extend(self.hiding.iter().flat_map(|piece| piece.s));
        cuts.sort_by(f64::total_cmp);
        let sine = receiver.across.dot(self.wedge.plane.normal).abs();
        let turn = u.cross(v).length();
        let mut sum = 0.0;
        for pair in cuts.windows(2) {
            let width = pair[1] - pair[0];
            if width <= 0.0 || trace::is_stopped(&self.hiding, 0.5 * (pair[0] + pair[1])) {
                continue;
            }
            for (at, weight) in GAUSS {
                let s = pair[0] + at * width;
                let ray = u.lerp(v, s);
                // The angle of a step of s is turn / r2 of it, the speed of a line at nearness n is (n - 1) / r.
                let r4 = ray.length_squared().powi(2);
                sum += weight * width * factor(s) * receiver.plane.normal.dot(ray).max(0.0) * turn / r4;
            }
        }
        sum * sine
    }
}
