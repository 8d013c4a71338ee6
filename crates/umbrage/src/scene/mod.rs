//! What the user gave: surfaces, materials, lights and units, with no algorithm.
//!
//! Lengths are metres, colours linear RGB. Irradiance `E`, exitance `M` and radiosity `B = rho E + M` are W/m2;
//! radiance `L = B / pi` is W/(m2 sr). A face is lit on its front, the side from which its corners run
//! counter-clockwise; both sides always block light.

mod bounds;
mod camera;
pub mod cornell;
mod lamp;
mod look;
mod material;
#[expect(clippy::module_inception, reason = "the module's main type is named like the module")]
mod scene;

pub use bounds::{MAX_BRIGHTNESS, MAX_COORDINATE_M};
pub use camera::{Camera, Lens};
pub use lamp::{Arriving, Lamp, LampKind};
pub use look::{Alpha, Image, Look, Texture, Wrap};
pub use material::{Material, Rgb};
pub use scene::{Node, Scene, SceneError, Surface};
