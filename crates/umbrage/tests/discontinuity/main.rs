//! The d-segments of scenes, against light that is calculated without them, and against closed forms.
#![allow(
    unreachable_pub,
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails by panicking, and says what it counted"
)]

#[path = "../common/build.rs"]
#[allow(dead_code, reason = "shared by test binaries, each of which uses a part")]
mod build;

mod alone;
mod breaks;
mod closed_forms;
mod light;
mod proof;
mod random;
mod secondary;
mod two_sided;
mod two_sided_scenes;

/// All sides become faces: d-segments are proved on what is hidden, too.
fn all_sides() -> umbrage::prepare::PrepareSettings {
    umbrage::prepare::PrepareSettings { keep_hidden: true, ..umbrage::prepare::PrepareSettings::default() }
}
