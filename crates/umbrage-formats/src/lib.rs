//! Scene files in, baked GLB files out.
