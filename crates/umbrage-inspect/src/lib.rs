//! What the stages of a bake made, to be read, compared and looked at.
//!
//! Each stage has a function that makes JSON ([`d_segments::json`], [`patches::json`], [`mesh::json`]) and one that
//! draws SVG (`svg` beside it). The JSON has a record per line in an order that depends on the scene only, so that two
//! files can be compared by `diff`; `docs/inspect.md` tells its fields. A drawing is one sheet with a picture of every
//! receiver, seen from its front.
//!
//! The crate reads what `umbrage` makes public, and writes text; files are its callers' business.

pub mod d_segments;
mod json;
pub mod mesh;
pub mod patches;
mod receiver;
mod sheet;
