//! How light travels between patches: form factors, links, the oracle and `subdivide`.

pub mod form_factor;
