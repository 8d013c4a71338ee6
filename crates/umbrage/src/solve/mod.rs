//! The balance of light: radiosity of every node of the hierarchy (Hanrahan, Salzman and Aupperle, *A rapid hierarchical
//! radiosity algorithm*, 1991; the paper's reference 4).
//!
//! `B = M + rho E`: radiosity is emitted exitance plus reflected irradiance. What is emitted arrives as direct light, exactly,
//! and what is reflected comes over links. An iteration
//! gathers over all links ([`gather`]), then pushes irradiance down to the leaves and pulls radiosity up ([`push_pull`]).

mod energy;
mod exactly;
mod gather;
mod iterate;
mod push_pull;
mod surfaces;

pub use energy::EnergyAccount;
pub use exactly::{missed, reflect};
pub use gather::{RadiosityMoments, gather};
pub use iterate::{Solution, SolutionError, SolveSettings, solve};
pub use push_pull::push_pull;
pub use surfaces::Surfaces;
