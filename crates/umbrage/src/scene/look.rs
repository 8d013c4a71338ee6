//! What a material looks like beside what it does to light: its image, its transparency. The bake passes it on.

use std::sync::Arc;

use super::Rgb;
use crate::id::ImageId;

/// An image file, as it came.
#[derive(Clone, PartialEq)]
pub struct Image {
    /// Name, as in the scene's file.
    pub name: Option<String>,
    /// The bytes of a PNG or a JPEG.
    pub bytes: Arc<[u8]>,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Image").field("name", &self.name).field("bytes", &self.bytes.len()).finish()
    }
}

/// What an image does beyond its border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// Begins anew.
    #[default]
    Repeat,
    /// Begins anew, every other time turned over.
    Mirror,
    /// Goes on with its last texel.
    Clamp,
}

/// An image on the surfaces of a material, which have texture coordinates for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Texture {
    /// The image.
    pub image: ImageId,
    /// What it does beyond its border, along u and along v.
    pub wrap: [Wrap; 2],
    /// How it is magnified and minified, in OpenGL's numbers, as glTF has them; `None` is the viewer's choice.
    pub filters: [Option<u32>; 2],
    /// What its colours are multiplied with, linear RGB.
    pub factor: Rgb,
}

/// How a material lets through what is behind it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// Not at all.
    #[default]
    Opaque,
    /// Where alpha, times that of its image, is below the cutoff. It blocks light as a whole.
    Mask {
        /// Alpha, 0 to 1.
        alpha: f64,
        /// The least alpha that is shown.
        cutoff: f64,
    },
    /// By the share that alpha leaves. It blocks no light.
    Blend {
        /// Alpha, 0 to 1.
        alpha: f64,
    },
}

/// What the bake passes on of a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Look {
    /// The image on it; without one it shows its reflectance.
    pub texture: Option<Texture>,
    /// Its transparency.
    pub alpha: Alpha,
    /// Radiance that it shows beside what it emits and reflects, and does not cast, in W/(m2 sr).
    pub glow: Rgb,
    /// What an application has put beside it, as JSON.
    pub extras: Option<String>,
}
