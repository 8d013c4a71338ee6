//! How light travels between patches: form factors, links, the oracle and `subdivide` (paper, sections 2 and 6).

mod brightness;
mod contour;
mod direct;
pub mod exact;
mod exchange;
mod fit;
pub mod form_factor;
mod lamps;
mod link;
mod near_emitters;
mod obstacles;
mod oracle;
mod pairs;
mod sample;
mod seen;
mod subdivide;
mod uneven;

pub use brightness::BrightnessOracle;
pub use direct::DirectLight;
pub use fit::Linear;
pub use link::{Link, LinkError, Links, Node};
pub use obstacles::Obstacles;
pub use oracle::{Decision, FormFactorOracle, Oracle, OracleKind, PaperOracle, ParseOracleError};
pub use seen::{KnownSources, SourceMemory, SourcesSeen};
pub use subdivide::{link_all, subdivide_all};
pub use uneven::split_where_uneven;
