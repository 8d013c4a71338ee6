//! glTF 2.0: scenes in, baked GLB out and in again.
//!
//! ```text
//! container, item -> buffer -> document -> tally; meshopt, draco -> unpack -> accessor -> base_texture -> node -> skin -> primitive -> texture -> material -> read
//!                                                                          camera, node, primitive -> read_baked
//! container, write_buffer, exposure -> write_material, write_camera, see_through -> write
//! ```

mod accessor;
mod base_texture;
mod buffer;
mod camera;
mod container;
mod document;
mod draco;
mod exposure;
mod item;
mod lamp;
mod material;
mod meshopt;
mod morph;
mod node;
mod primitive;
mod read;
mod read_baked;
mod see_through;
mod skin;
mod tally;
mod texture;
mod unpack;
mod write;
mod write_buffer;
mod write_camera;
mod write_material;

pub(crate) use container::MAGIC;
pub(crate) use read::read;
pub(crate) use read_baked::read_baked;
pub use write::{BakeFacts, Written, baked_glb_bytes, write_baked_glb};
