//! Discontinuities of the radiosity function: events, wedges, their tracing, contacts (paper, section 3.2).
//!
//! | degree | event | file |
//! |---|---|---|
//! | 0 | a surface ends on another | `contact` |
//! | 0 | an occluder edge before a lamp without extent | `lamp` |
//! | 0 to 2 | where light of a lamp without extent ends by itself: terminators, cones, ranges | `lamp_curve` |
//! | 1 | a source edge and an occluder edge in one plane | `edge_edge` |
//! | 1 | an occluder's face seen edge-on before a source | `occluder_plane` |
//! | 1 | the source's own plane | `source_plane` |
//! | 2 | every other VE and EV: a corner of one, an edge of the other | `event` |
//! | 2 | EEE: an edge of the source and two of occluders | `three_edges` |

mod bright_part;
mod casting;
mod closed_gap;
mod contact;
mod corner;
mod d_segment;
mod edge_edge;
mod emitter;
mod event;
mod features;
mod find;
mod implicit_curve;
mod in_plane;
mod lamp;
mod lamp_curve;
mod light_met;
mod merge;
mod near_edges;
mod occluder_plane;
mod plane_image;
mod polynomial;
mod ruled;
mod secondary;
mod silhouette;
mod source;
mod source_plane;
mod strength;
mod strength_of_three;
mod three_edges;
mod trace;
mod walled_off;
mod wedge;

pub use bright_part::Reflecting;
pub use contact::is_contact;
pub use d_segment::{DSegment, Degree, Event};
pub use emitter::Emitter;
pub(crate) use emitter::groups as coplanar_groups;
pub use features::Features;
pub use find::{Discontinuities, at_least, find};
pub use lamp_curve::LampCurve;
pub use near_edges::near_edges;
pub use secondary::find_secondary;
