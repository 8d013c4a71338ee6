//! The reader of PLY.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| umbrage_fuzz::read("ply", bytes));
