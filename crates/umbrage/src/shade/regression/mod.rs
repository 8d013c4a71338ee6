//! Reflected irradiance by regression: fits to scattered samples in place of gathers at points.
//!
//! No point is gathered exactly. Samples lie all over each leaf, one ray each, place and direction together; a quadratic function over the
//! triangles of a mesh is fitted to them by least squares (Veach and others call it a density fit; here of irradiance):
//!
//! ```text
//! regress() {
//!     repeat {
//!         draw samples over each leaf, along one ray each           sample
//!         add up the normal equations of each triangle              element
//!         solve them over each smooth sheet                         normal_equations
//!         see from the residuals what the fit misses                evidence
//!         buy splits and samples at one price                       plan
//!     } until noise and misfit are what is allowed
//! }
//! ```
//!
//! So the noise of hundreds of rays of a neighbourhood is averaged, and never paid for at a point. What a ray sees depends mostly on where
//! it goes: constants for classes of directions are fitted beside the function, which takes most of the noise out.

mod bright;
mod element;
mod evidence;
mod fit;
mod normal_equations;
mod plan;
mod sample;

pub(crate) use bright::bright_places;
pub(crate) use fit::{FittedLight, RegressionSettings, least_of_fit_m, regress};
pub(crate) use sample::Gathering;
