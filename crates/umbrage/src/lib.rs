//! Umbrage bakes the light of a polygonal scene into the vertices of a triangle mesh that follows the shadow
//! boundaries, by the method of *Meshing for Discontinuity Driven Hierarchical Radiosity* (Maierhofer, Gervautz,
//! Karner).
//!
//! The modules stand in the order of the pipeline, and each uses only those before it; `tests/module_order.rs` keeps it
//! so. Every stage takes the results of earlier stages by reference and returns its own; ids are typed, and tables of
//! results lie beside the topology that they describe.
//!
//! ```text
//! scene -> prepare -> visibility -> hidden -> discontinuity -> mesh -> transport -> solve -> shade
//! ```

pub mod id;
pub mod progress;

pub mod geometry;

pub mod scene;

pub mod prepare;

pub mod visibility;

pub mod hidden;

pub mod discontinuity;

pub mod mesh;

pub mod transport;

pub mod solve;

pub mod texels;

pub mod shade;

mod settings;

mod bake_warning;

pub mod bake;

pub mod groundwork;

pub mod rebake;
