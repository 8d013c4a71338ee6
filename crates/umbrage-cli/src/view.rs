//! `umbrage view`: opens a window, which is a program of its own (`umbrage-view`), because it takes long to build.

use std::env;
use std::ffi::OsString;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::process::{self, Command};

use anyhow::{Context, bail};
use clap::Args;

/// Name of the program.
const PROGRAM: &str = "umbrage-view";

/// Show a baked GLB, or a scene while it is baked, in a window (needs `umbrage-view`)
#[derive(Debug, Args)]
#[command(disable_help_flag = true)]
pub(crate) struct ViewArgs {
    /// The file, and options: `umbrage view --help` tells them
    #[arg(required = true, num_args = 1.., trailing_var_arg = true, allow_hyphen_values = true, value_name = "FILE")]
    words: Vec<OsString>,
}

pub(crate) fn run(args: &ViewArgs) -> anyhow::Result<()> {
    let beside = env::current_exe().ok().map(|own| own.with_file_name(format!("{PROGRAM}{}", env::consts::EXE_SUFFIX)));
    let program = beside.filter(|path| path.is_file()).unwrap_or_else(|| PathBuf::from(PROGRAM));
    match Command::new(&program).args(&args.words).status() {
        Ok(status) if status.success() => Ok(()),
        // It has said why.
        Ok(status) => process::exit(status.code().unwrap_or(1)),
        Err(error) if error.kind() == ErrorKind::NotFound => bail!(
            "the window is a program of its own, {PROGRAM}, which is not installed: install it with `cargo install --path \
             crates/umbrage-view`"
        ),
        Err(error) => Err(error).with_context(|| format!("cannot start {}", program.display())),
    }
}
