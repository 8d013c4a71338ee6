//! Three failures that the manuals of earlier radiosity programs told their users to work around: light that leaks under a wall
//! into a dark room, a thin table leg that loses its shadow, a switch plate that floats off a wall or is glued to it. Whole bakes
//! with the default settings, against darkness, or against light that is calculated exactly here (`exact.rs`).
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

#[path = "../common/mod.rs"]
mod common;

mod build;
mod dark_room;
mod exact;
mod switch_plate;
mod table_leg;
