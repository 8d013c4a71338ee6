//! The reader of glTF: what begins like a GLB, and what begins like JSON.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| umbrage_fuzz::read("gltf", bytes));
