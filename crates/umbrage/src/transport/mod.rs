//! How light travels between patches: form factors, links, the oracle and `subdivide` (paper, sections 2 and 6).

mod bright_places;
mod brightness;
mod contour;
mod direct;
mod emitting_parts;
pub mod exact;
mod exchange;
mod fit;
pub mod form_factor;
mod lamp_flux;
mod lamps;
mod link;
mod near_emitters;
mod near_surface;
mod obstacles;
mod oracle;
mod pairs;
mod places_of_leaves;
mod ray_lattice;
mod sample;
mod seen;
mod subdivide;
mod uneven;

pub use bright_places::{BrightPlace, LampFate, LightSent};
pub use brightness::BrightnessOracle;
pub use direct::DirectLight;
pub use fit::Linear;
pub use link::{Link, LinkError, Links, Node};
pub use obstacles::Obstacles;
pub use oracle::{Decision, FormFactorOracle, Oracle, OracleKind, PaperOracle, ParseOracleError};
pub use places_of_leaves::PlacesOfLeaves;
pub(crate) use ray_lattice::cosine_direction;
pub use seen::{KnownSources, SourceMemory, SourcesSeen};
pub use subdivide::{link_all, subdivide_all};
pub use uneven::split_where_uneven;
