//! What is shown: triangles that follow the shadow boundaries, and the light of their vertices.

mod assemble;
mod baked_mesh;
mod bounce;
mod bounced;
mod bright_leaves;
mod corner_group;
mod crowd;
mod direct;
mod element;
mod errors;
mod field;
mod flat;
mod gathering;
mod interpolated;
mod irradiance;
mod joints;
mod lamp_account;
mod local_light;
mod part;
mod plain;
mod refine;
mod reflected;
mod reflected_places;
mod regression;
mod rim;
#[expect(clippy::module_inception, reason = "the module's main function is named like the module")]
mod shade;
mod straight_joint;

pub use baked_mesh::{BakedMesh, BakedMeshError, BakedPart};
pub use bounce::{Bouncing, Room, bounce};
pub use irradiance::{Irradiance, Terms};
pub use lamp_account::{LampAccount, LampDefect};
pub use local_light::{LocalLight, negligible};
pub use reflected_places::reflected_places;
pub(crate) use regression::least_of_fit_m;
pub use shade::{IndirectLight, ShadeLight, ShadeMeshes, ShadeSettings, Shaded, shade, within};
