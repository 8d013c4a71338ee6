//! Pictures of baked meshes: a small deterministic Gouraud rasteriser on the CPU.
//!
//! It draws what every ordinary renderer draws of a baked mesh (colours interpolated between vertices, single-sided
//! triangles, sRGB), but slowly and exactly: no crack between triangles that share an edge, the same bytes on every run
//! and with any number of threads. It is what the other ways of showing a bake are compared with.
//!
//! The crate knows neither scenes nor files; [`PictureMesh`] is plain tables. Design decision: samples on a regular 4 x
//! 4 grid and an average with equal weights, because a picture that is compared should be easy to predict.
//!
//! | file | holds |
//! |---|---|
//! | `color` | exposure, tone curve, clipping, sRGB, false colours: the only place that leaves linear light |
//! | `mesh`, `texture` | what is drawn |
//! | `decode`, `tga` | images of all formats
//! | `reencode` | images as viewers of glTF take them
//! | `mean_color` | the mean colour of an image, or of a part of it |
//! | `camera`, `view` | the camera, and the one where none is asked for |
//! | `project` | clipping, projection, snapping to the grid |
//! | `fill` | which samples a triangle covers |
//! | `line` | wireframes and segments over the picture |
//! | `band` | depth test and average of samples |
//! | `render` | all of it, in parallel |
//! | `picture` | pixels, PNG, EXR |
//! | `scale`, `glyph` | the legend of a picture in false colours |
//! | `compare` | pictures beside each other, and their difference |
//!
//! ```
//! use umbrage_picture::{Camera, PictureMesh, RenderSettings, default_camera, render};
//!
//! let mesh = PictureMesh {
//!     positions_m: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
//!     colors: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
//!     triangles: vec![[0, 1, 2]],
//!     ..PictureMesh::default()
//! };
//! let camera = default_camera(&[mesh.clone()], 64, 64, Camera::DEFAULT_FOV_DEG)?.expect("there is a triangle");
//! let settings = RenderSettings { width: 64, height: 64, ..RenderSettings::default() };
//! let png: Vec<u8> = render(&[mesh], &[], &camera, &settings)?.png()?;
//! # assert_eq!(&png[1..4], b"PNG");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod band;
mod camera;
pub mod color;
mod compare;
mod decode;
mod fill;
mod glyph;
mod line;
mod mean_color;
mod mesh;
mod picture;
mod project;
mod reencode;
mod render;
mod scale;
mod texture;
mod tga;
mod view;

pub use camera::{Camera, CameraError};
pub use color::{LinearRgb, Tone};
pub use compare::{Difference, beside, difference};
pub use decode::TextureError;
pub use line::{Line, LineColor, LineSet, SEGMENT_WIDTH_PX, WIRE_OPACITY, WIRE_WIDTH_PX, wireframe};
pub use mean_color::{MeanColor, Seen};
pub use mesh::{MeshError, PictureMesh, bounds_m};
#[cfg(feature = "exr")]
pub use picture::ExrError;
pub use picture::{Picture, PngError};
pub use reencode::{for_viewers, with_opacity};
pub use render::{Look, MAX_SIZE_PX, RenderError, RenderSettings, render};
pub use scale::{Scale, nice_ceiling};
pub use texture::{Texel, Texture, Wrap};
pub use view::{default_camera, fit};
