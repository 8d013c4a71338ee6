//! PLY, text and binary: a list of vertices and a list of faces, without materials.
//!
//! ```text
//! header -> body -> read
//! ```
//! Source: G. Turk, *The PLY Polygon File Format*, Stanford, 1994.

mod body;
mod header;
mod read;

pub(crate) use read::{begins, read};
