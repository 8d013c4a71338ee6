//! `umbrage bake --reuse FILE`: a bake that takes up what one before left in a file, or leaves it there.
//!
//! Holds: only a file that this program wrote is ever replaced.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::Context;
use umbrage::bake::{Bake, BakeError, BakeSettings};
use umbrage::progress::Progress;
use umbrage::rebake::{Change, Kept, RebakeError, bake_to_reuse, rebake};
use umbrage::scene::Scene;
use umbrage_formats::{KeptFileError, read_kept, write_kept};

use crate::output::{self, Output};
use crate::summary;

/// A file with a bake, and what became of it.
#[derive(Clone, Debug)]
pub(crate) struct Reuse {
    file: PathBuf,
    outcome: Arc<Mutex<Outcome>>,
}

/// What a bake did with the file.
#[derive(Debug, Default)]
enum Outcome {
    /// It is not done yet.
    #[default]
    Nothing,
    /// It took up what is there.
    TakenUp(Change),
    /// It found everything itself.
    Afresh {
        /// What is to be written.
        kept: Box<Kept>,
        /// Why what is there was of no use.
        because: Option<String>,
        /// Whether the file is not ours to replace.
        is_foreign: bool,
    },
}

impl Reuse {
    pub(crate) fn new(file: PathBuf) -> Self {
        Self { file, outcome: Arc::default() }
    }

    /// Bakes from what is in the file, if that fits.
    pub(crate) fn bake(
        &self,
        scene: &Scene,
        settings: &BakeSettings,
        progress: Progress<'_>,
    ) -> Result<Bake, BakeError> {
        let (mut because, mut is_foreign) = (None, false);
        match read_kept(&self.file) {
            Ok(Some(kept)) => match rebake(scene, settings, &kept, progress) {
                Ok((bake, change)) => {
                    self.end(Outcome::TakenUp(change));
                    return Ok(bake);
                }
                Err(RebakeError::Bake(error)) => return Err(error),
                Err(RebakeError::NotReusable(reason)) => {
                    because = Some(format!("what {} has cannot be taken up: {reason}", self.file.display()));
                }
            },
            Ok(None) => {}
            Err(error) => {
                is_foreign = matches!(error, KeptFileError::Foreign { .. } | KeptFileError::Unreadable { .. });
                because = Some(error.to_string());
            }
        }
        let (bake, kept) = bake_to_reuse(scene, settings, progress)?;
        self.end(Outcome::Afresh { kept: Box::new(kept), because, is_foreign });
        Ok(bake)
    }

    fn end(&self, outcome: Outcome) {
        *self.outcome.lock().unwrap_or_else(PoisonError::into_inner) = outcome;
    }

    /// Writes what is new, once the baked file is written, and tells what was done.
    pub(crate) fn finish(&self, output: Output) -> anyhow::Result<()> {
        let file = self.file.display();
        match std::mem::take(&mut *self.outcome.lock().unwrap_or_else(PoisonError::into_inner)) {
            Outcome::Nothing => Ok(()),
            Outcome::TakenUp(change) => output.say(&format!("Took up {file}: {}", told(change))),
            Outcome::Afresh { because: Some(because), is_foreign: true, .. } => {
                output::warning(&format!("{because}: it is left as it is. Give --reuse another name"));
                Ok(())
            }
            Outcome::Afresh { kept, because, .. } => {
                if let Some(because) = because {
                    output::warning(&format!("{because}. All was baked anew, and the file is replaced"));
                }
                let bytes = write_kept(&self.file, &kept).context("what was baked cannot be kept")?;
                let size = summary::bytes(bytes);
                output.say(&format!("Wrote {file} ({size}), which the next bake of these surfaces takes up"))
            }
        }
    }
}

fn told(change: Change) -> &'static str {
    match change {
        Change::Strength => "light changed by no more than a factor",
        Change::Light => "some lamps or surfaces have another brightness or colour",
        Change::Lamps => "lamps moved, came or went",
    }
}
