//! Exact form factors: for people who want the numbers themselves, with a bound of their error.
//!
//! Links between patches use quick rules ([`super::form_factor`]); this module has the slow and sure ones:
//! - [`polygon_to_polygon`]: two polygons in clear sight of one another, in any position, to rounding;
//! - [`visible_polygon_to_polygon`]: past occluders, by adaptive integration of the exact visible part;
//! - [`FactorTable`]: all pairs of the faces of a scene.

mod apart;
mod cell;
mod clear;
mod edge_pair;
mod kink;
mod penumbra;
mod quadrature;
mod table;
mod visible;

pub use clear::polygon_to_polygon;
pub use table::{FacePair, FactorTable, FactorTotals};
pub use visible::{Effort, visible_polygon_to_polygon};

/// A form factor, and how far it may be off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange {
    /// Share of the light that leaves the receiver, uniformly, and arrives at the source.
    pub factor: f64,
    /// The true factor differs by at most this much, as far as two rules of different degree tell.
    pub error_bound: f64,
}
