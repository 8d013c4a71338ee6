//! `prepare` on small scenes with known answers and on random ones, checked by brute force that shares no code with it.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod build;
mod cases;
mod check;
mod degenerate;
mod random;
mod soups;
