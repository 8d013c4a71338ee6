//! Pictures of baked meshes: a small deterministic Gouraud rasteriser on the CPU.
