//! The command as a test runs it: what it says, and a folder for its files.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    reason = "shared by test binaries, each of which uses a part; a test fails by panicking"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the command to its end.
pub fn umbrage(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_umbrage")).args(arguments).output().unwrap()
}

/// An empty folder of this test's own: other test binaries have others for the same name.
pub fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(env!("CARGO_CRATE_NAME")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

/// The path of a scene for tests.
pub fn scene(name: &str) -> String {
    format!("{}/../../testdata/scenes/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The exit code.
pub fn code(output: &Output) -> Option<i32> {
    output.status.code()
}

/// What went to standard output.
pub fn out(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// What went to standard error.
pub fn err(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}
