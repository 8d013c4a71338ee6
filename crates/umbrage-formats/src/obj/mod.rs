//! Wavefront OBJ and its material libraries (MTL): the polygonal part of the format.
//!
//! ```text
//! mtl -> texture -> material -> read
//! ```
//! Source: *Object Files (.obj)* and *MTL material format*, Alias|Wavefront, Advanced Visualizer manual, appendix B.

mod material;
mod mtl;
mod read;
mod texture;

pub(crate) use read::read;
