//! Scene files in, baked GLB files out.

mod baked_file;

pub use baked_file::{BakedFile, BakedFilePart};
