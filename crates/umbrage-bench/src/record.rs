//! What a run of the suite leaves: one JSON file.

use std::fs;
use std::path::Path;

use anyhow::Context;
use serde::{Deserialize, Serialize};

use crate::machine::Machine;

/// A run of the suite.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Run {
    /// Coordinated universal time, as RFC 3339 has it.
    pub(crate) date: String,
    /// Version and commit.
    pub(crate) version: String,
    /// What it was measured on.
    pub(crate) machine: Machine,
    /// What the bakes were asked for: error as a share of the mean irradiance.
    pub(crate) tolerance: f64,
    /// The scenes, in the order asked for.
    pub(crate) scenes: Vec<Measured>,
    /// Bakes that left nothing to measure.
    #[serde(default)]
    pub(crate) unfinished: Vec<Unfinished>,
}

/// A bake that did not end in time, or failed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Unfinished {
    /// Name or path.
    pub(crate) scene: String,
    pub(crate) threads: usize,
    /// What came between.
    pub(crate) why: String,
}

/// A scene, baked with several numbers of threads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Measured {
    /// Name or path, and the tolerance where it is one of its own: `room@0.03`.
    pub(crate) scene: String,
    /// Whether all bakes of it left the same bytes.
    pub(crate) same_bytes: bool,
    /// What path tracing found.
    pub(crate) verified: Verified,
    /// A bake for each number of threads, the fewest first.
    pub(crate) bakes: Vec<Timed>,
}

/// One bake.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Timed {
    pub(crate) threads: usize,
    /// Polygons of the file.
    pub(crate) polygons: usize,
    /// Faces that were made of them.
    pub(crate) faces: usize,
    /// d-segments of degree 0, 1 and 2.
    pub(crate) d_segments: [usize; 3],
    pub(crate) patches: usize,
    /// Of these, the ones that are not split; older runs do not tell.
    #[serde(default)]
    pub(crate) leaves: Option<usize>,
    /// Wall time of linking, in seconds; older runs do not tell.
    #[serde(default)]
    pub(crate) linking_seconds: Option<f64>,
    pub(crate) links: usize,
    pub(crate) triangles: usize,
    /// The bake's own estimate of its error, as a share of the mean irradiance.
    pub(crate) estimate: f64,
    /// Reading, baking and making the bytes of the baked file, in seconds.
    pub(crate) seconds: f64,
    /// The stages of the bake in order, in seconds.
    pub(crate) stage_seconds: Vec<(String, f64)>,
    /// Processor time of all threads, in seconds.
    pub(crate) cpu_seconds: Option<f64>,
    /// The most memory that was held at a time, in bytes.
    pub(crate) peak_bytes: Option<u64>,
    /// Tells baked files of one program apart.
    pub(crate) digest: String,
}

/// Error of a bake by path tracing (crate `umbrage-verify`), in shares of the mean irradiance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Verified {
    /// Root mean square error, without the noise of the check, and its standard error.
    pub(crate) error: [f64; 2],
    /// Mean error, and its standard error.
    pub(crate) bias: [f64; 2],
    /// Root mean square error of the check itself.
    pub(crate) noise: f64,
    /// Points that were compared.
    pub(crate) points: usize,
    /// Points that should be dark and are not.
    pub(crate) leaks: usize,
}

impl Measured {
    /// The bake with the most threads.
    pub(crate) fn last(&self) -> &Timed {
        // The suite leaves scenes out that have none; `read` checks.
        &self.bakes[self.bakes.len() - 1]
    }

    /// The bake with a number of threads.
    pub(crate) fn with_threads(&self, threads: usize) -> Option<&Timed> {
        self.bakes.iter().find(|bake| bake.threads == threads)
    }
}

impl Run {
    /// Reads a stored run.
    pub(crate) fn read(path: &Path) -> anyhow::Result<Self> {
        let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        let run: Self = serde_json::from_str(&text).with_context(|| format!("{} is not a run", path.display()))?;
        anyhow::ensure!(
            run.scenes.iter().all(|scene| !scene.bakes.is_empty()),
            "{}: a scene without bakes",
            path.display()
        );
        Ok(run)
    }

    /// Writes it, with the folder that it goes into.
    pub(crate) fn write(&self, path: &Path) -> anyhow::Result<()> {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
        }
        let text = serde_json::to_string_pretty(self)? + "\n";
        fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A bake that took `seconds` with one thread and `0.6 * seconds` with two.
    pub(crate) fn measured(scene: &str, polygons: usize, seconds: f64) -> Measured {
        let bake = |threads: usize, seconds: f64| Timed {
            threads,
            polygons,
            faces: polygons,
            d_segments: [1, 2, 3],
            patches: 10,
            leaves: Some(8),
            linking_seconds: Some(4e-5),
            links: 20,
            triangles: 30,
            estimate: 0.01,
            seconds,
            stage_seconds: vec![("prepare".into(), 0.25 * seconds), ("shade".into(), 0.75 * seconds)],
            cpu_seconds: Some(seconds),
            peak_bytes: Some(1 << 20),
            digest: "0".into(),
        };
        let verified = Verified { error: [0.008, 0.0001], bias: [-0.001, 0.0002], noise: 0.01, points: 1000, leaks: 0 };
        Measured {
            scene: scene.into(),
            same_bytes: true,
            verified,
            bakes: vec![bake(1, seconds), bake(2, 0.6 * seconds)],
        }
    }

    pub(crate) fn run(scenes: Vec<Measured>) -> Run {
        let machine = Machine { cores: 2, cpu: "some".into(), system: "some".into() };
        Run {
            date: "2026-01-02T03:04:05Z".into(),
            version: "0".into(),
            machine,
            tolerance: 0.01,
            scenes,
            unfinished: Vec::new(),
        }
    }

    #[test]
    fn a_run_is_read_as_it_was_written() {
        let folder = std::env::temp_dir().join(format!("umbrage-bench-{}", std::process::id()));
        let path = folder.join("runs/run.json");
        let run = run(vec![measured("cornell", 20, 1.0 / 3.0)]);
        run.write(&path).unwrap();
        assert_eq!(Run::read(&path).unwrap(), run);
        fs::write(&path, "{}").unwrap();
        assert!(Run::read(&path).is_err());
        fs::remove_dir_all(folder).unwrap();
    }
}
