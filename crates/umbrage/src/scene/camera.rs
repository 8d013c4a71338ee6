//! Cameras of a scene, which the bake passes on.

use glam::DAffine3;

use crate::id::NodeId;

/// A camera at its place in the world: it looks along its own -Z, with its own +Y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// The node that it belongs to.
    pub node: NodeId,
    /// Name, as in the file.
    pub name: Option<String>,
    /// From its own space to the world, in metres.
    pub to_world: DAffine3,
    /// How it projects.
    pub lens: Lens,
}

/// How a camera projects. Distances from the camera are in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// Towards a point.
    Perspective {
        /// Field of view from the lower to the upper edge, in radians.
        fov_y_rad: f64,
        /// Width over height; `None` is the viewer's choice.
        aspect: Option<f64>,
        /// Nothing nearer is seen.
        near_m: f64,
        /// Nothing farther is seen; `None` is no limit.
        far_m: Option<f64>,
    },
    /// In parallel.
    Orthographic {
        /// Half the width and half the height of what is seen.
        half_size_m: [f64; 2],
        /// Nothing nearer is seen.
        near_m: f64,
        /// Nothing farther is seen.
        far_m: f64,
    },
}

impl Lens {
    /// The same lens in other units of length.
    pub fn scaled(self, scale: f64) -> Self {
        match self {
            Self::Perspective { fov_y_rad, aspect, near_m, far_m } => {
                Self::Perspective { fov_y_rad, aspect, near_m: scale * near_m, far_m: far_m.map(|far_m| scale * far_m) }
            }
            Self::Orthographic { half_size_m, near_m, far_m } => Self::Orthographic {
                half_size_m: half_size_m.map(|half_m| scale * half_m),
                near_m: scale * near_m,
                far_m: scale * far_m,
            },
        }
    }
}
