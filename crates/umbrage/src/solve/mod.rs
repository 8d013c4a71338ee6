//! The balance of light: radiosity of every node of the hierarchy (Hanrahan, Salzman and Aupperle, *A rapid hierarchical
//! radiosity algorithm*, 1991; the paper's [4]).
//!
//! `B = M + rho E`: radiosity is emitted exitance plus reflected irradiance, and irradiance comes over links. An iteration
//! gathers over all links ([`gather`]), then pushes irradiance down to the leaves and pulls radiosity up ([`push_pull`]).

mod gather;
mod iterate;
mod push_pull;

pub use gather::{LinearIrradiance, RadiosityMoments, gather};
pub use iterate::{Solution, SolutionError, SolveSettings, solve};
pub use push_pull::{Surfaces, push_pull};
