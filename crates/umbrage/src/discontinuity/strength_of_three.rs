//! How much the curvature jumps where three edges pass through one point of what the eye sees.
//!
//! In the image, the lines have the unit normals `n1, n2, n3` and move by `c1, c2, c3` across themselves. Before they
//! meet in a point they bound a triangle, and after it one that is turned over, of area `c^2 / |2 D12 D23 D31|` with
//! `Dij = ni x nj` and `c = c1 D23 + c2 D31 + c3 D12`. One of both triangles is seen differently than smooth motion
//! would have it, whatever sides the three lines hide. So the second derivative jumps by the step of radiance across
//! the source's line, times the cosine, times `c'^2 / |D12 D23 D31|`. A line at the distance `r` moves by `n / r` times
//! the eye's step.

use glam::DVec3;

use super::features::Surroundings;
use super::strength::Receiver;
use crate::id::EdgeId;
use crate::scene::Rgb;

impl Surroundings<'_> {
    /// Behind a source edge and two occluder edges, the first of which is nearer to the source.
    pub(super) fn of_three_edges(&self, receiver: &Receiver, source: EdgeId, occluders: [EdgeId; 2]) -> Rgb {
        let Some(edge) = self.features.source_edge(source) else { return Rgb::ZERO };
        let lines = [edge.ends_m, self.ends(occluders[0]), self.ends(occluders[1])];
        let n = lines.map(|[p, q]| (p - receiver.at).cross(q - receiver.at).normalize_or_zero());
        let ray = n[1].cross(n[2]).normalize_or_zero();
        let r = lines.map(|[p, q]| {
            // Where the ray passes the line, or nearest to it.
            let (from, along) = (p - receiver.at, q - p);
            let across = ray.cross(along);
            from.cross(along).dot(across) / across.length_squared()
        });
        let d = [n[1].cross(n[2]), n[2].cross(n[0]), n[0].cross(n[1])].map(|cross| cross.dot(ray));
        let speed: DVec3 = (0..3).map(|i| n[i] * (d[i] / r[i])).sum();
        let along_receiver = speed - speed.dot(receiver.plane.normal) * receiver.plane.normal;
        let cosine = receiver.plane.normal.dot(ray).abs();
        // On the source's very line, so that the source itself is not behind it.
        let [from, to] = edge.ends_m;
        let along = (to - from).normalize_or_zero();
        let behind = self.emitted_behind(receiver.at, from + along.dot(receiver.at + r[0] * ray - from) * along);
        let step = edge.step(receiver.at, self.coplanar_m(), behind);
        let jump = step * (cosine * along_receiver.length_squared() / (d[0] * d[1] * d[2]).abs());
        if jump.is_finite() { jump } else { Rgb::ZERO }
    }
}
