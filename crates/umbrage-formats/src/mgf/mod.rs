//! MGF, the Materials and Geometry Format, version 2: the format of the field's own test scenes.
//!
//! ```text
//! colour -> material, context, transform, solid, hole, source -> shape -> read
//! ```
//! Diffuse scenes are read in full: named and unnamed contexts, transforms and arrays, includes, all surfaces. Gloss,
//! transmission and measured luminaires are left out with a warning. Lengths are metres in a right-handed frame, usually
//! with z up ([`crate::ReadOptions::up`] turns it).
//!
//! Units of light pass through: `ed` is an emittance in lm/m2, and the radiance of the material is `ed / pi` with the same
//! number, so what is baked is in lux and lm/m2 where a glTF's is in W/m2.
//!
//! Source: G. Ward, *The Materials and Geometry Format*, version 2.0, Lawrence Berkeley Laboratory, 1995 to 1998.

mod colour;
mod context;
mod hole;
mod material;
mod read;
mod shape;
mod solid;
mod source;
mod transform;

pub(crate) use read::read;
