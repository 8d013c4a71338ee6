//! Random points on what gives light.

use umbrage::scene::{Rgb, Scene};

use crate::tracer::Tracer;

/// The triangles that emit, by power.
pub(crate) struct Emitters {
    /// Number of the triangle, and the sum of the powers up to and with it, in watts.
    cumulative: Vec<(usize, f64)>,
    total: f64,
}

/// The mean of the colours: what points are spread by.
pub(crate) fn brightness(colour: Rgb) -> f64 {
    colour.element_sum() / 3.0
}

impl Emitters {
    pub(crate) fn new(scene: &Scene, tracer: &Tracer) -> Self {
        let mut total = 0.0;
        let emitting = tracer.triangles.iter().enumerate().filter(|(_, t)| scene.materials[t.material].emits());
        let cumulative = emitting
            .map(|(number, triangle)| {
                total += triangle.area_m2 * brightness(scene.materials[triangle.material].exitance());
                (number, total)
            })
            .collect();
        Self { cumulative, total }
    }

    /// The triangle at a share of the power, from 0 to 1.
    pub(crate) fn choose(&self, share: f64) -> Option<usize> {
        let target = share * self.total;
        let last = self.cumulative.len().checked_sub(1)?;
        let place = self.cumulative.partition_point(|(_, sum)| *sum <= target).min(last);
        Some(self.cumulative[place].0)
    }

    /// How densely points are spread over a triangle of this exitance, per square metre.
    pub(crate) fn density(&self, exitance: Rgb) -> f64 {
        brightness(exitance) / self.total
    }
}
