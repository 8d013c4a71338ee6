//! Ctrl-C, and the signals that ask a process to end (SIGTERM, SIGHUP): the first one asks a bake to stop, the second one ends the process at
//! once.
//!
//! Holds: the signal handler only sets a flag, which the progress callback reads, and whoever waits for a bake;
//! commands that report no progress keep the system's behaviour.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

use crate::exit_code::ExitCode;

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on, Ctrl-C sets the flag.
pub(crate) fn listen() -> anyhow::Result<()> {
    ctrlc::set_handler(|| {
        if INTERRUPTED.swap(true, Ordering::Relaxed) {
            process::exit(ExitCode::Interrupted.into());
        }
    })
    .context("cannot listen for Ctrl-C")?;
    tracing::info!("Ctrl-C cancels");
    Ok(())
}

/// Ctrl-C was pressed.
#[derive(Clone, Copy, Debug, thiserror::Error)]
#[error("interrupted, nothing was written")]
pub(crate) struct Interrupted;

/// Ctrl-C was pressed, and there is a result all the same, which is described.
#[derive(Clone, Debug, thiserror::Error)]
#[error("interrupted; {0}")]
pub(crate) struct Kept(pub(crate) String);

/// Whether Ctrl-C was pressed since [`listen`].
pub(crate) fn was_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}
