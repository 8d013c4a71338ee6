//! A window on a baked scene, and on a scene while it is baked.
//!
//! It draws what a picture of `umbrage-picture` shows, with the same numbers for exposure, tone curve, sRGB and false
//! colours, on a graphics processor (or on a driver that does its work): surfaces and lines into linear half floats
//! with four samples a pixel, and then the mean of the samples as dithered sRGB codes. A scene is baked in a thread,
//! into the same bytes as `umbrage bake` writes.
//!
//! | file | holds |
//! |---|---|
//! | `options` | what is opened, and how it is shown first |
//! | `load`, `watch` | opening, baking in a thread; whether files have changed |
//! | `layout` | a baked file as tables |
//! | `viewpoint`, `lens` | where the eye is and how hands move it; the camera as shaders take it |
//! | `marks` | lines of d-segments and patches |
//! | `pick`, `provenance` | what is under the pointer; where its light is from |
//! | `gpu`, `pipelines`, `upload`, `targets`, `draw` | drawing; `shader` and the `.wgsl` files are the shaders |
//! | `headless` | a picture without a window |
//! | `frame_time` | how long a frame of a million triangles takes |
//! | `window`, `session`, `screen` | the window, the file that is open in it, and the scene on its screen |
//! | `navigate`, `panel`, `controls`, `progress`, `legend`, `facts`, `save`, `dress` | hands, the panel and its parts |
//!
//! Holds: no text of a file and no driver makes it panic; what a graphics processor draws is within two codes of the
//! picture, but for pixels at edges (`tests/agreement.rs`).

mod controls;
mod draw;
mod dress;
mod facts;
#[cfg(test)]
mod frame_time;
mod gpu;
mod headless;
mod layout;
mod legend;
mod lens;
mod load;
mod marks;
mod navigate;
mod options;
mod panel;
mod pick;
mod pipelines;
mod progress;
mod provenance;
mod save;
mod screen;
mod session;
mod shader;
mod targets;
mod upload;
mod viewpoint;
mod watch;
mod window;

pub use gpu::{Gpu, GpuError};
pub use headless::screenshot;
pub use load::Job;
pub use options::{LineArgs, ViewOptions};
pub use window::open;
