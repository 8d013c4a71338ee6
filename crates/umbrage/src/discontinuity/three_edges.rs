//! Events of three edges (EEE): an edge of the source and two edges of occluders, no two of which lie in one plane,
//! pass through one point of what the eye sees (Heckbert 1992; Drettakis and Fiume 1994).
//!
//! On the receiver they are pieces of conics, here polylines of chords, each a d-segment of degree 2 of its own.
//!
//! For every emitter and every edge that may be passed last, the edges are asked that reach into the hull of both: few,
//! since rays between them pass little. Of those three edges the rays are an interval of the source edge, or several
//! (`ruled`).

use std::cell::Cell;
use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::sync::atomic::Ordering;

use glam::DVec3;
use rayon::prelude::*;
use smallvec::SmallVec;

use super::features::Surroundings;
use super::ruled::{Ray, Reach, Ruled};
use super::silhouette::OccluderEdge;
use super::source::SourceEdge;
use super::{DSegment, Degree, Emitter, Event};
use crate::geometry::{Plane, PlaneFrame};
use crate::id::{EdgeId, EmitterId, FaceId};
use crate::scene::Rgb;

/// A chord leaves its curve by at most this share of what the curve spans on its face.
const SAG: f64 = 0.01;
/// A curve has at most two to the power of this many chords on a face.
const MOST_HALVINGS: u32 = 6;
/// Intervals of the source edge shorter than this share of it are points.
const SHORTEST: f64 = 1e-9;
/// Emitters with more corners are bounded by a rectangle: the planes of a hull grow with the square of its corners.
const MOST_CORNERS: usize = 6;
/// What a ray passes within this share of its way to the last edge from where it starts, or from that edge, is passed
/// there.
const SAME_PLACE: f64 = 1e-7;

/// So many triples of a source edge and two occluder edges are looked at for each edge of an occluder, and besides. Where most edges pass
/// between an emitter and an edge, each hides the least of the light, and events are left out. A room has one or two for each edge,
/// blinds of 20 slats 15; 2,000 needles 580, where the search took 137 s, and takes 3 s with this.
const TRIPLES_OF_EDGE: usize = 40;
const TRIPLES_OF_SCENE: usize = 50_000;

impl Surroundings<'_> {
    /// The events of an emitter's edges and two occluder edges, of which the given one is nearer to the receiver; none where more than
    /// `most` triples of edges would have to be looked at.
    pub(super) fn three_edges(&self, id: EmitterId, last: &OccluderEdge, most: usize) -> Vec<DSegment> {
        let nearer = self.edges_between(id, last);
        if self.triples(id, &nearer) > most {
            return Vec::new();
        }
        let mut segments = Vec::new();
        for nearer in nearer {
            for &number in &self.features.sources.of_emitter[id] {
                let source = &self.features.sources.edges[number];
                if source.edge != last.edge && source.edge != nearer.edge {
                    segments.extend(self.three(id, source, nearer, last));
                }
            }
        }
        segments
    }

    /// The most triples for one emitter and one last edge such that all together are in proportion to the occluders' edges.
    pub(super) fn most_triples(&self, emitters: &[EmitterId]) -> usize {
        let edges = &self.features.occluders.edges;
        let count = |number: usize| {
            let id = emitters[number / edges.len()];
            self.triples(id, &self.edges_between(id, &edges[number % edges.len()]))
        };
        let all = (0..emitters.len() * edges.len()).into_par_iter().map(count);
        let mut counts: Vec<usize> = all.filter(|&count| count > 0).collect();
        counts.sort_unstable();
        let mut left = TRIPLES_OF_EDGE * edges.len() + TRIPLES_OF_SCENE;
        let fits = |&count: &usize| {
            let enough = left >= count;
            left = left.saturating_sub(count);
            enough
        };
        counts.into_iter().take_while(fits).last().unwrap_or(0)
    }

    fn triples(&self, id: EmitterId, nearer: &[&OccluderEdge]) -> usize {
        nearer.len() * self.features.sources.of_emitter[id].len()
    }

    /// The edges that rays from an emitter to an edge may pass.
    fn edges_between(&self, id: EmitterId, last: &OccluderEdge) -> Vec<&OccluderEdge> {
        let emitter = &self.features.emitters[id];
        let corners = self.hull_corners(emitter);
        if !self.may_be_silhouette(last, &corners) {
            return Vec::new();
        }
        let planes = self.hull(emitter, &corners, last.ends_m);
        let slack_m = self.coplanar_m();
        let reaches = |ends_m: [DVec3; 2]| {
            planes.iter().all(|plane| ends_m.iter().any(|&end| plane.signed_distance_m(end) > slack_m))
        };
        let mut others: BTreeSet<EdgeId> = BTreeSet::new();
        self.visibility.walk(
            |lo, hi| planes.iter().all(|plane| heights_m(plane, lo, hi)[1] > slack_m),
            |face| {
                others.extend(self.prepared.faces[face].sides.iter().flatten().map(|side| side.edge));
                ControlFlow::Continue(())
            },
        );
        let nearer = others.into_iter().filter(|&edge| edge != last.edge);
        let nearer = nearer.filter_map(|edge| self.features.occluders.of(edge));
        nearer.filter(|edge| reaches(edge.ends_m) && self.may_be_silhouette(edge, &corners)).collect()
    }

    /// Points that hold an emitter in their hull.
    fn hull_corners(&self, emitter: &Emitter) -> SmallVec<[DVec3; MOST_CORNERS]> {
        let corners = emitter.corners.iter().map(|&corner| self.position(corner));
        if emitter.corners.len() <= MOST_CORNERS {
            return corners.collect();
        }
        let frame = PlaneFrame::new(emitter.plane, emitter.centroid_m);
        let flat = corners.map(|corner| frame.to_2d(corner));
        let (lo, hi) = flat.fold((glam::DVec2::INFINITY, glam::DVec2::NEG_INFINITY), |(lo, hi), corner| {
            (lo.min(corner), hi.max(corner))
        });
        [(lo.x, lo.y), (hi.x, lo.y), (hi.x, hi.y), (lo.x, hi.y)]
            .map(|(x, y)| frame.to_3d(glam::DVec2::new(x, y)))
            .into_iter()
            .collect()
    }

    /// Whether an edge hides one side only as seen from some point between these. Which sides it hides changes only
    /// where the point passes the plane of a face along the edge.
    fn may_be_silhouette(&self, edge: &OccluderEdge, corners: &[DVec3]) -> bool {
        let has_corners_on_both_sides = |face: FaceId| {
            let plane = self.prepared.oriented_plane(face);
            let heights_m = || corners.iter().map(|&corner| plane.signed_distance_m(corner));
            heights_m().any(|height_m| height_m > 0.0) && heights_m().any(|height_m| height_m < 0.0)
        };
        if edge.faces().any(has_corners_on_both_sides) {
            return true;
        }
        // All points see the same, so which sides are hidden is asked for one of them.
        let seen_from = corners.iter().copied().sum::<DVec3>() / corners.len() as f64;
        let normal = (edge.ends_m[0] - seen_from).cross(edge.ends_m[1] - seen_from);
        let Some(normal) = normal.try_normalize() else { return true };
        edge.hidden_sides(&Plane::through(edge.ends_m[0], normal), self.coplanar_m()) != [true, true]
    }

    /// Half-spaces that hold the hull of an emitter and an edge.
    fn hull(&self, emitter: &Emitter, corners: &[DVec3], edge: [DVec3; 2]) -> SmallVec<[Plane; 12]> {
        let slack_m = self.coplanar_m();
        let mut planes: SmallVec<[Plane; 12]> = SmallVec::from_slice(&[emitter.plane]);
        let mut support = |through: DVec3, along: DVec3, apex: DVec3| {
            let Some(normal) = along.cross(apex - through).try_normalize() else { return };
            let heights_m = || corners.iter().chain(&edge).map(|&p| normal.dot(p - through));
            if heights_m().all(|height_m| height_m >= -slack_m) {
                planes.push(Plane::through(through, normal));
            } else if heights_m().all(|height_m| height_m <= slack_m) {
                planes.push(Plane::through(through, -normal));
            }
        };
        for (i, &corner) in corners.iter().enumerate() {
            support(edge[0], edge[1] - edge[0], corner);
            for &next in &corners[i + 1..] {
                edge.iter().for_each(|&end| support(corner, next - corner, end));
            }
        }
        planes
    }

    /// The event of three edges, the last of which is nearest to the receiver, where of the emitters along the source's
    /// edge this is the first that is turned to the receiver.
    fn three(&self, id: EmitterId, source: &SourceEdge, nearer: &OccluderEdge, last: &OccluderEdge) -> Vec<DSegment> {
        let ruled = Ruled { source: source.ends_m, nearer: nearer.ends_m, last: last.ends_m };
        if ruled.is_empty()
            || self.common_plane(ruled.nearer, ruled.last).is_some()
            || self.common_plane(ruled.source, ruled.nearer).is_some()
            || self.common_plane(ruled.source, ruled.last).is_some()
        {
            return Vec::new();
        }
        let direction = ruled.direction();
        // The image changes where a ray passes the end of an edge, or lies in the plane of a face along one.
        let mut ends = ruled.passes_ends();
        let faces = [nearer, last].into_iter().flat_map(OccluderEdge::faces).map(|face| self.prepared.normal(face));
        for normal in faces.chain(source.normals()) {
            ends.extend(super::polynomial::roots(&direction.map(|power| normal.dot(power))));
        }
        let is_event = |t: f64| {
            let Some(ray) = ruled.ray(t) else { return false };
            let hides = |edge: &OccluderEdge| {
                let normal = (edge.ends_m[0] - ray.from).cross(edge.ends_m[1] - ray.from).normalize_or_zero();
                let [front, back] = edge.hidden_sides(&Plane::through(ray.from, normal), self.coplanar_m());
                front != back
            };
            let turned = |&&emitter: &&EmitterId| {
                self.features.emitters[emitter].plane.signed_distance_m(ray.last) > self.coplanar_m()
            };
            source.emitters.iter().find(turned) == Some(&id)
                && source.step(ray.last, self.coplanar_m(), Rgb::ZERO) != Rgb::ZERO
                && hides(nearer)
                && hides(last)
        };
        let event =
            Event::ThreeEdges { emitter: source.emitter, source: source.edge, occluders: [nearer.edge, last.edge] };
        let beside = |face: FaceId| {
            nearer.is_beside(face) || last.is_beside(face) || self.prepared.edges[source.edge].faces.contains(&face)
        };
        let mut segments = Vec::new();
        for interval in parts([0.0, 1.0], ends, |t| is_event(t).then_some(())) {
            self.wedges.fetch_add(1, Ordering::Relaxed);
            for (part, face) in self.received_by(&ruled, &direction, interval.0, beside) {
                self.chords_of(&ruled, part, face, event, &mut segments);
            }
        }
        segments
    }

    /// The faces that receive the rays of an interval of the source line, each with its part of the interval.
    fn received_by(
        &self,
        ruled: &Ruled,
        direction: &[DVec3; 3],
        interval: [f64; 2],
        beside: impl Fn(FaceId) -> bool,
    ) -> Vec<([f64; 2], FaceId)> {
        let [Some(first), Some(final_ray)] = inside(ruled, interval).map(|t| ruled.ray(t)) else { return Vec::new() };
        let reach = Reach::new([first.from, final_ray.from], [first.last, final_ray.last]);
        let slack_m = self.coplanar_m();
        let mut faces: Vec<FaceId> = Vec::new();
        self.visibility.walk(
            |lo, hi| reach.may_meet(|plane| heights_m(plane, lo, hi), slack_m),
            |face| {
                let heights_m = |plane: &Plane| {
                    let heights_m = self.visibility.boundary_m(face).iter().map(|&p| plane.signed_distance_m(p));
                    heights_m.fold([f64::INFINITY, f64::NEG_INFINITY], |[lo, hi], h| [lo.min(h), hi.max(h)])
                };
                if !beside(face) && reach.may_meet(heights_m, slack_m) {
                    faces.push(face);
                }
                ControlFlow::Continue(())
            },
        );
        faces.sort_unstable();
        let mut ends: SmallVec<[f64; 4]> = SmallVec::new();
        for &face in &faces {
            let boundary = self.visibility.boundary_m(face);
            for i in 0..boundary.len() {
                ends.extend(ruled.meets(direction, [boundary[i], boundary[(i + 1) % boundary.len()]]));
            }
        }
        // The face that stops one ray mostly stops the next.
        let stopper = Cell::new(None);
        parts(interval, ends, |t| self.receiver_of(&faces, &ruled.ray(t)?, &stopper))
    }

    /// The face among these that a ray reaches past the last edge, if none is before it. Of several at one place, the
    /// two sides of a sheet, it is the one that shows light. `stopper`, the face before the last edge that stopped a ray, is asked first.
    fn receiver_of(&self, faces: &[FaceId], ray: &Ray, stopper: &Cell<Option<FaceId>>) -> Option<FaceId> {
        let is_before = |at: f64| SAME_PLACE < at && at < 1.0 - SAME_PLACE;
        if stopper.get().and_then(|face| self.hit(face, ray)).is_some_and(is_before) {
            return None;
        }
        let mut beyond: SmallVec<[(f64, FaceId); 8]> = SmallVec::new();
        for &face in faces {
            let Some(at) = self.hit(face, ray) else { continue };
            if is_before(at) {
                stopper.set(Some(face));
                return None;
            }
            if at > 1.0 + SAME_PLACE {
                beyond.push((at, face));
            }
        }
        let nearest = beyond.iter().copied().reduce(|best, next| if next.0 < best.0 { next } else { best })?;
        let plane = self.visibility.plane(nearest.1);
        let at_one_place = |&&(at, face): &&(f64, FaceId)| {
            at <= nearest.0 * (1.0 + SAME_PLACE) || self.visibility.plane(face) == plane
        };
        beyond.iter().filter(at_one_place).map(|found| found.1).find(|&face| self.lit(face, ray.from))
    }

    /// Where a ray passes through a face, in its length to the last edge.
    fn hit(&self, face: FaceId, ray: &Ray) -> Option<f64> {
        let boundary = self.visibility.boundary_m(face);
        let direction = ray.direction();
        let turn = |i: usize| {
            let (p, q) = (boundary[i] - ray.from, boundary[(i + 1) % boundary.len()] - ray.from);
            p.cross(q).dot(direction)
        };
        let turns = || (0..boundary.len()).map(turn);
        (turns().all(|turn| turn >= 0.0) || turns().all(|turn| turn <= 0.0)).then(|| self.reach_of(face, ray))
    }

    /// Where a ray meets the plane of a face, in its length to the last edge.
    fn reach_of(&self, face: FaceId, ray: &Ray) -> f64 {
        let plane = self.prepared.oriented_plane(face);
        -plane.signed_distance_m(ray.from) / plane.normal.dot(ray.direction())
    }

    /// Adds the chords of the curve that an interval of rays leaves on a face.
    fn chords_of(&self, ruled: &Ruled, interval: [f64; 2], face: FaceId, event: Event, segments: &mut Vec<DSegment>) {
        let point = |t: f64| ruled.ray(t).map(|ray| ray.from + self.reach_of(face, &ray) * ray.direction());
        let interval = inside(ruled, interval);
        let at = |share: f64| point(interval[0] + share * (interval[1] - interval[0]));
        let [Some(from), Some(before), Some(after), Some(to)] = [0.0, 0.25, 0.75, 1.0].map(at) else { return };
        let span_m =
            [from, before, after].windows(2).map(|pair| pair[0].distance(pair[1])).sum::<f64>() + after.distance(to);
        let mut waiting = vec![(interval, [from, to], 0)];
        while let Some(([t0, t1], ends_m, halvings)) = waiting.pop() {
            let along = (ends_m[1] - ends_m[0]).normalize_or_zero();
            let sag_m = |share: f64| {
                let at = point(t0 + share * (t1 - t0)).map(|p| p - ends_m[0]);
                at.map_or(0.0, |d| (d - d.dot(along) * along).length())
            };
            let middle = 0.5 * (t0 + t1);
            match point(middle) {
                Some(at)
                    if halvings < MOST_HALVINGS
                        && [0.25, 0.5, 0.75].into_iter().any(|share| sag_m(share) > SAG * span_m) =>
                {
                    waiting.push(([middle, t1], [at, ends_m[1]], halvings + 1));
                    waiting.push(([t0, middle], [ends_m[0], at], halvings + 1));
                }
                _ => segments.extend(self.segment_between(face, ends_m, event, Degree::D2)),
            }
        }
    }
}

/// An interval without its ends where there is no ray at those: they are roots, a rounding farther the ray misses an
/// edge.
fn inside(ruled: &Ruled, [from, to]: [f64; 2]) -> [f64; 2] {
    let step = SHORTEST * (to - from);
    let end = |exact: f64, inner: f64| if ruled.ray(exact).is_some() { exact } else { inner };
    [end(from, from + step), end(to, to - step)]
}

/// The parts of an interval, divided at `ends`, in whose middles there is an answer; neighbours with the same one are
/// united.
fn parts<T: PartialEq + Copy>(
    interval: [f64; 2],
    mut ends: SmallVec<[f64; 4]>,
    answer: impl Fn(f64) -> Option<T>,
) -> Vec<([f64; 2], T)> {
    ends.retain(|end| interval[0] < *end && *end < interval[1]);
    ends.extend(interval);
    ends.sort_by(f64::total_cmp);
    let mut parts: Vec<([f64; 2], T)> = Vec::new();
    for pair in ends.windows(2).filter(|pair| pair[1] - pair[0] > SHORTEST) {
        let Some(answer) = answer(0.5 * (pair[0] + pair[1])) else { continue };
        match parts.last_mut().filter(|last| last.1 == answer && pair[0] - last.0[1] <= SHORTEST) {
            Some(last) => last.0[1] = pair[1],
            None => parts.push(([pair[0], pair[1]], answer)),
        }
    }
    parts
}

/// Least and greatest height of a box over a plane, in metres.
fn heights_m(plane: &Plane, lo_m: DVec3, hi_m: DVec3) -> [f64; 2] {
    let middle = plane.signed_distance_m(0.5 * (lo_m + hi_m));
    let reach = plane.normal.abs().dot(0.5 * (hi_m - lo_m));
    [middle - reach, middle + reach]
}
