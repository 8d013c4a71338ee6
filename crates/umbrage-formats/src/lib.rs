//! Scene files in, baked GLB files out.
//!
//! - [`read_scene`] reads a scene (glTF, OBJ, MGF, PLY, STL) and says in typed [`Warning`]s what it did not take over;
//!   [`read_scene_and_files`] tells also what files it is made of;
//! - [`Overrides`] say what the file does not: which of its materials give light, and lamps;
//! - [`choose_nodes`] says which of its nodes are baked, while the others only take part in the light;
//! - [`write_baked_glb`] writes a baked mesh as one ordinary GLB, all or nothing;
//! - [`read_baked`] reads a baked file back, for pictures and measurements;
//! - [`write_kept`] and [`read_kept`] keep what a bake found, for another one of the same surfaces.
//!
//! Files come from anywhere: whatever their bytes, reading ends in a scene or in a [`FormatError`] that names the place,
//! never in a panic, and takes memory in proportion to the input. Formats stay at this edge; nothing here computes light.

mod atomic;
mod baked_file;
mod beside;
mod builder;
mod choice;
mod error;
mod gltf;
mod kept_file;
mod mgf;
mod obj;
mod overrides;
mod ply;
mod read;
mod similar;
mod stl;
mod text;
mod texture_mean;
mod tint;
mod warning;

pub use atomic::{check_writable, write_atomically};
pub use baked_file::{BakedCamera, BakedEmission, BakedFile, BakedFilePart, BakedTexture};
pub use choice::choose_nodes;
pub use error::FormatError;
pub use gltf::{BakeFacts, Written, baked_glb_bytes, write_baked_glb};
pub use kept_file::{KeptFileError, kept_bytes, kept_from_bytes, read_kept, write_kept};
pub use overrides::{MaterialColour, Overrides};
pub use read::{
    LampUnits, ReadOptions, SceneAndFiles, UpAxis, read_baked, read_baked_bytes, read_scene, read_scene_and_files,
    read_scene_bytes, read_scene_with,
};
pub use text::shortened;
pub use texture_mean::picture_wrap;
pub use umbrage::scene::Wrap as TextureWrap;
pub use warning::Warning;
