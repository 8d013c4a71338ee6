//! Discontinuities of the radiosity function: events, wedges, their tracing, contacts (paper, section 3.2).

mod d_segment;

pub use d_segment::{DSegment, Degree, Event};
