//! Discontinuities of the radiosity function: events, wedges, their tracing, contacts (paper, section 3.2).

mod contact;
mod d_segment;
mod emitter;
mod event;
mod find;
mod lamp;
mod merge;
mod silhouette;
mod source_plane;
mod strength;
mod trace;
mod wedge;

pub use contact::is_contact;
pub use d_segment::{DSegment, Degree, Event};
pub use emitter::{Emitter, emitters};
pub use find::{Discontinuities, find};
