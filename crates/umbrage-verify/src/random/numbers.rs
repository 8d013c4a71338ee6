//! Random numbers of the kinds that scenes need.

use std::f64::consts::TAU;

use fastrand::Rng;
use glam::{DQuat, DVec3};
use umbrage::scene::Rgb;

pub(super) struct Numbers(Rng);

impl Numbers {
    pub(super) fn new(seed: u64) -> Self {
        Self(Rng::with_seed(seed))
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.f64()
    }

    /// A number between two positive ones, of each magnitude as likely.
    pub(super) fn log_between(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    pub(super) fn below(&mut self, count: usize) -> usize {
        self.0.usize(..count)
    }

    pub(super) fn chance(&mut self, share: f64) -> bool {
        self.0.f64() < share
    }

    /// A count from 1 on, of each magnitude as likely.
    pub(super) fn count(&mut self, most: usize) -> usize {
        (self.log_between(1.0, most as f64 + 1.0) as usize).clamp(1, most.max(1))
    }

    pub(super) fn point(&mut self, half: DVec3) -> DVec3 {
        half * DVec3::from([(); 3].map(|()| self.between(-1.0, 1.0)))
    }

    /// A unit vector, of all directions as likely.
    pub(super) fn direction(&mut self) -> DVec3 {
        let (z, turn) = (self.between(-1.0, 1.0), self.between(0.0, TAU));
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * turn.cos(), radius * turn.sin(), z)
    }

    /// A turn about the upright, or any turn.
    pub(super) fn turn(&mut self, upright: bool) -> DQuat {
        let axis = if upright { DVec3::Y } else { self.direction() };
        // Straight turns make planes and edges meet exactly.
        let angle = if self.chance(0.3) { 0.25 * TAU * self.below(4) as f64 } else { self.between(0.0, TAU) };
        DQuat::from_axis_angle(axis, angle)
    }

    /// A distance between things that nearly touch, in metres; often none.
    pub(super) fn gap_m(&mut self) -> f64 {
        if self.chance(0.5) { 0.0 } else { self.log_between(1e-5, 1e-2) }
    }

    /// A colour whose channels are from 0 to `most`; often grey, now and then black.
    pub(super) fn colour(&mut self, most: f64) -> Rgb {
        match self.below(8) {
            0 => Rgb::ZERO,
            1..5 => Rgb::splat(self.between(0.0, most)),
            _ => Rgb::from([(); 3].map(|()| self.between(0.0, most))),
        }
    }
}
