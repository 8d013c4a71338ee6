//! The reader of OBJ.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| umbrage_fuzz::read("obj", bytes));
