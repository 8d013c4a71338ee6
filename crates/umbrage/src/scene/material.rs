//! Diffuse, possibly emitting materials.

use std::f64::consts::PI;

use glam::DVec3;

use super::Look;

/// A linear colour, or a spectral quantity at red, green and blue.
pub type Rgb = DVec3;

/// A diffuse material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, as in the file.
    pub name: String,
    /// Share of the incident light that is reflected, 0 to 1: the base colour, with an image the average of both.
    pub reflectance: Rgb,
    /// Emitted radiance in W/(m2 sr), the same in all directions of the front.
    pub radiance: Rgb,
    /// Whether a face of it reflects and emits on both sides: it then becomes two faces, back to back.
    pub double_sided: bool,
    /// What it looks like beside that.
    pub look: Look,
}

impl Material {
    /// A material that reflects and does not emit.
    pub fn diffuse(name: impl Into<String>, reflectance: Rgb) -> Self {
        Self { name: name.into(), reflectance, radiance: Rgb::ZERO, double_sided: false, look: Look::default() }
    }

    /// A black material that emits `radiance`, in W/(m2 sr).
    pub fn emitting(name: impl Into<String>, radiance: Rgb) -> Self {
        Self { radiance, ..Self::diffuse(name, Rgb::ZERO) }
    }

    /// Emitted exitance `M = pi L`, in W/m2.
    pub fn exitance(&self) -> Rgb {
        PI * self.radiance
    }

    /// Radiance that is seen of it in the dark: what it emits, and what it only shows, in W/(m2 sr).
    pub fn shown_radiance(&self) -> Rgb {
        self.radiance + self.look.glow
    }

    /// Whether a face of it is seen in the dark.
    pub fn shines(&self) -> bool {
        self.shown_radiance().max_element() > 0.0
    }

    /// Whether a face of it is a light.
    pub fn emits(&self) -> bool {
        self.radiance.max_element() > 0.0
    }
}
