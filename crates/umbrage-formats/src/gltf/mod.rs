//! glTF 2.0: scenes in, baked GLB out and in again.
//!
//! ```text
//! container, item -> buffer -> document -> accessor, tally -> material, node, primitive -> read
//!                                                          base_texture, camera, node, primitive -> read_baked
//! container, write_buffer, exposure -> write
//! ```

mod accessor;
mod base_texture;
mod buffer;
mod camera;
mod container;
mod document;
mod exposure;
mod item;
mod lamp;
mod material;
mod node;
mod primitive;
mod read;
mod read_baked;
mod tally;
mod write;
mod write_buffer;

pub(crate) use container::MAGIC;
pub(crate) use read::read;
pub(crate) use read_baked::read_baked;
pub use write::{BakeFacts, Written, baked_glb_bytes, write_baked_glb};
