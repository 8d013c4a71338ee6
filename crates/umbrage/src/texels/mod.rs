//! Radiosity in texels: what faces reflect, in a grid of cells, solved along rays.
//!
//! Reflected light at a point is a mean over all that it sees; so what it is gathered from may be coarse and noisy. A grid of some 60,000
//! cells over all faces carries it, whatever their number is: direct light of a cell from a few shadow rays, bounces along a few rays.
//! What is shown comes from fits to many rays that meet these cells (`shade::regression`).

mod grid;
mod light_tree;
mod next_event;
mod patches;
mod radiosity;
mod ray_tree;
mod sequence;
mod sources;

pub(crate) use grid::Texel;
pub(crate) use next_event::{BrightTexels, NextEvents};
pub use radiosity::TexelRadiosity;
pub(crate) use ray_tree::Ray;
pub use ray_tree::RayTree;
pub(crate) use sequence::{Draws, Sequence, key_of};
pub(crate) use sources::{Sources, Start};
