//! How much jumps across a d-segment: an estimate from the geometry of its event, at the middle of the segment.
//!
//! Seen from the receiver point `x`, at distance `r` from the source feature and `d` from the occluder feature, a step
//! of `delta` across the segment moves the occluder by `w = delta (r - d) / d` over the source. The irradiance changes
//! by radiance times cosines / r2 times the area that appears: `length * w` for two parallel edges (degree 1, per
//! metre), `w^2 / 2` for a corner (degree 2, per square metre).

use glam::DVec3;

use super::Emitter;
use crate::geometry::Plane;

/// The geometry of an event at a receiver point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight<'a> {
    pub(super) emitter: &'a Emitter,
    /// The oriented plane of the receiver.
    pub(super) receiver: &'a Plane,
    /// The plane of the wedge.
    pub(super) wedge: &'a Plane,
    /// The receiver point, in metres.
    pub(super) at: DVec3,
}

impl Sight<'_> {
    /// Radiance times both cosines over r2, and the sine between the receiver and the wedge: what a square metre of the
    /// source at `source` gives at the point, in W/m4.
    fn power(&self, source: DVec3) -> (f64, f64) {
        let ray = source - self.at;
        let r2 = ray.length_squared().max(f64::MIN_POSITIVE);
        let direction = ray / r2.sqrt();
        let cosines = direction.dot(self.receiver.normal).abs() * direction.dot(self.emitter.plane.normal).abs();
        let sine = self.receiver.normal.cross(self.wedge.normal).length();
        (self.emitter.mean_radiance() * cosines / r2, sine)
    }

    fn magnification(&self, source: DVec3, occluder: DVec3) -> f64 {
        let (r, d) = (source.distance(self.at), occluder.distance(self.at));
        ((r - d) / d.max(f64::MIN_POSITIVE)).max(0.0)
    }

    /// Jump of the slope behind two coplanar edges that overlap over `length_m` of the source, in W/m3.
    pub(super) fn of_edges(&self, source: DVec3, occluder: DVec3, length_m: f64) -> f64 {
        let (power, sine) = self.power(source);
        power * length_m * sine * self.magnification(source, occluder)
    }

    /// Jump of the curvature behind a corner and an edge, in W/m4.
    pub(super) fn of_corner(&self, source: DVec3, occluder: DVec3) -> f64 {
        let (power, sine) = self.power(source);
        power * (sine * self.magnification(source, occluder)).powi(2)
    }

    /// Jump of the slope where the receiver passes through the source's plane, in W/m3.
    pub(super) fn of_source_plane(&self) -> f64 {
        let ray = self.emitter.centroid_m - self.at;
        let r = ray.length().max(f64::MIN_POSITIVE);
        let cosine = (ray / r).dot(self.receiver.normal).abs();
        let sine = self.receiver.normal.cross(self.wedge.normal).length();
        self.emitter.mean_radiance() * self.emitter.area_m2 * cosine * sine / (r * r * r)
    }
}
