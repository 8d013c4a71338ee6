//! Bakes in steps as a user meets them: limits of time and memory, early results, Ctrl-C.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use common::{err, folder, scene, umbrage};

/// A tolerance that no bake of the occluder reaches in the time of a test, though its first step does.
const OUT_OF_REACH: &str = "0.00001";

/// The tolerance that a baked file says it was made with.
fn tolerance_in(path: &Path) -> f64 {
    let bytes = fs::read(path).unwrap();
    // The JSON of a GLB follows 12 bytes of its head and 8 of the chunk's, which begin with its length.
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    assert_eq!(u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize, bytes.len(), "a whole file");
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    json["asset"]["extras"]["umbrage"]["tolerance"].as_f64().unwrap()
}

#[test]
fn a_limit_that_ends_before_the_first_step_says_so_and_leaves_nothing() {
    let folder = folder("too_short");
    let baked = folder.join("baked.glb");
    let begin = Instant::now();
    let ended = umbrage(&["bake", &scene("room.obj"), "-o", baked.to_str().unwrap(), "--time-limit", "0.2"]);
    assert_eq!(ended.status.code(), Some(1), "{}", err(&ended));
    assert!(err(&ended).contains("Give it more time") && err(&ended).contains("tolerance 0.16"), "{}", err(&ended));
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
    // A process needs a while to start, more so beside other tests.
    assert!(begin.elapsed() < Duration::from_secs(2), "{:?}", begin.elapsed());
}

#[test]
fn what_a_limit_allows_is_the_bake_of_the_tolerance_that_it_names() {
    let folder = folder("limit");
    let [limited, alone] = ["limited.glb", "alone.glb"].map(|name| folder.join(name));
    let begin = Instant::now();
    let line = ["--threads", "1", "--time-limit", "10", "--tolerance", OUT_OF_REACH];
    let ended = umbrage(&[&["bake", &scene("occluder.glb"), "-o", limited.to_str().unwrap()], &line[..]].concat());
    assert!(begin.elapsed() < Duration::from_secs(11), "{:?}", begin.elapsed());
    assert_eq!(ended.status.code(), Some(0), "{}", err(&ended));
    let tolerance = tolerance_in(&limited);
    let warning = format!("{}: the time limit is too short for tolerance {OUT_OF_REACH}", limited.display());
    assert!(err(&ended).starts_with(&format!("warning: {warning}")), "{}", err(&ended));
    assert!(err(&ended).contains(&format!("at tolerance {tolerance}")), "{}", err(&ended));
    // Most of the time is used, and what time ran short for is said to be cut short.
    assert!(begin.elapsed() > Duration::from_secs(5), "{:?}", begin.elapsed());
    if err(&ended).contains("cut short") {
        return;
    }
    let line = ["--tolerance", &tolerance.to_string()];
    let done = umbrage(&[&["bake", &scene("occluder.glb"), "-o", alone.to_str().unwrap()], &line[..]].concat());
    assert_eq!(done.status.code(), Some(0), "{}", err(&done));
    assert_eq!(fs::read(limited).unwrap(), fs::read(alone).unwrap());
}

#[test]
fn little_time_is_used_for_light_with_shadows() {
    let folder = folder("little");
    let baked = folder.join("little.glb");
    // Far less than the tolerance takes: most of it goes into a step with the edges of shadows, and what that found is kept.
    let line =
        ["bake", &scene("room.obj"), "-o", baked.to_str().unwrap(), "--time-limit", "40", "--tolerance", "0.001"];
    let begin = Instant::now();
    let ended = umbrage(&line);
    assert!(begin.elapsed() < Duration::from_secs(41), "{:?}", begin.elapsed());
    assert_eq!(ended.status.code(), Some(0), "{}", err(&ended));
    assert!(!err(&ended).contains("in a sketch"), "{}", err(&ended));
}

#[test]
fn early_results_end_in_the_one_asked_for() {
    let folder = folder("progressive");
    let [early, alone] = ["early.glb", "alone.glb"].map(|name| folder.join(name));
    let bake = |path: &Path, more: &[&str]| {
        let done = umbrage(&[&["bake", &scene("occluder.glb"), "-o", path.to_str().unwrap()], more].concat());
        assert_eq!(done.status.code(), Some(0), "{}", err(&done));
        String::from_utf8(done.stdout).unwrap()
    };
    let told = bake(&early, &["--progressive"]);
    // At 16, 4 and 1 times the default tolerance.
    let [first, second] = ["at tolerance 0.16", "at tolerance 0.04"].map(|words| told.find(words).unwrap());
    assert!(first < second && told.matches("Wrote").count() == 3, "{told}");
    bake(&alone, &[]);
    assert_eq!(fs::read(early).unwrap(), fs::read(alone).unwrap());
}

/// What the summary of a bake says that the process has held, in bytes.
#[cfg(unix)]
fn peak_bytes(done: &Output) -> f64 {
    let told = String::from_utf8_lossy(&done.stdout);
    let line = told.lines().find_map(|line| line.trim().strip_prefix("peak memory")).unwrap();
    let mebibytes: f64 = line.trim().strip_suffix("MiB").unwrap().trim().parse().unwrap();
    mebibytes * f64::from(1 << 20)
}

#[cfg(unix)]
#[test]
fn a_step_that_memory_is_too_little_for_is_given_up_and_the_one_before_is_kept() {
    let folder = folder("memory");
    let [limited, alone] = ["limited.glb", "alone.glb"].map(|name| folder.join(name));
    let bake = |path: &Path, more: &[&str]| {
        let line = ["bake", &scene("occluder.glb"), "-o", path.to_str().unwrap(), "--threads", "1"];
        let done = umbrage(&[&line[..], more].concat());
        assert_eq!(done.status.code(), Some(0), "{}", err(&done));
        done
    };
    // A limit that a step may come within an eighth and 8 MiB of, so that the first step keeps within it, and the
    // second does not.
    let (asked, first, second) = (0.0001, 0.0016, 0.0012);
    let held = [second, first].map(|tolerance| peak_bytes(&bake(&alone, &["--tolerance", &tolerance.to_string()])));
    let limit = (0.5 * (held[0] + held[1]) + f64::from(8 << 20)) / 0.875;
    for more in [&[][..], &["--progressive"]] {
        let limits = ["--memory-limit", &format!("{}", limit as u64), "--time-limit", "1000"];
        let done = bake(&limited, &[&limits[..], &["--tolerance", &asked.to_string()], more].concat());
        assert!(peak_bytes(&done) <= limit, "{} of {limit}", peak_bytes(&done));
        // Steps before have left some memory in use: the one before may have been too large, too.
        let reached = tolerance_in(&limited);
        assert!(second < reached && reached <= 2.0 * first, "{reached}");
        bake(&alone, &["--tolerance", &reached.to_string()]);
        assert_eq!(fs::read(&limited).unwrap(), fs::read(&alone).unwrap());
        let (told, warned) = (String::from_utf8_lossy(&done.stdout), err(&done));
        let limit_in = format!("warning: {}: the memory limit of ", limited.display());
        assert!(warned.starts_with(&limit_in) && warned.contains("was reached"), "{warned}");
        assert!(warned.contains(&format!("at tolerance {reached}, between vertices in error by 0.")), "{warned}");
        assert!(told.contains(&format!("tolerance     {reached}: the memory limit of ")), "{told}");
    }
}

#[cfg(unix)]
#[test]
fn memory_that_is_too_little_for_the_first_step_is_told_and_leaves_nothing() {
    let folder = folder("too_small");
    let baked = folder.join("baked.glb");
    let line = ["bake", &scene("occluder.glb"), "-o", baked.to_str().unwrap(), "--time-limit", "1000"];
    let ended = umbrage(&[&line[..], &["--memory-limit", "9MiB", "--progressive"]].concat());
    assert_eq!(ended.status.code(), Some(1), "{}", err(&ended));
    for part in ["memory limit of 9.0 MiB", "step, at tolerance 0.16", "had held", "Give it more memory"] {
        assert!(err(&ended).contains(part), "{}", err(&ended));
    }
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
    let refused = umbrage(&[&line[..], &["--memory-limit", "much"]].concat());
    assert_eq!(refused.status.code(), Some(2));
    assert!(err(&refused).contains("such as 500MB or 2GiB"), "{}", err(&refused));
}

#[cfg(unix)]
#[test]
fn memory_that_is_enough_changes_nothing() {
    let folder = folder("enough");
    let [limited, alone] = ["limited.glb", "alone.glb"].map(|name| folder.join(name));
    for (path, more) in [(&alone, &[][..]), (&limited, &["--memory-limit", "64GiB"])] {
        let done = umbrage(&[&["bake", &scene("occluder.glb"), "-o", path.to_str().unwrap()], more].concat());
        assert_eq!((done.status.code(), err(&done).as_str()), (Some(0), ""));
    }
    assert_eq!(fs::read(limited).unwrap(), fs::read(alone).unwrap());
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_the_best_early_result_within_a_second() {
    use std::io::Read;
    use std::process::Stdio;
    use std::thread::sleep;

    let folder = folder("interrupted");
    let baked = folder.join("baked.glb");
    let mut bake = Command::new(env!("CARGO_BIN_EXE_umbrage"))
        .args(["bake", &scene("occluder.glb"), "-o", baked.to_str().unwrap()])
        .args(["--threads", "1", "--tolerance", OUT_OF_REACH, "--progressive"])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while !baked.exists() {
        assert!(bake.try_wait().unwrap().is_none(), "it ended without a result");
        sleep(Duration::from_millis(20));
    }
    let pressed = Instant::now();
    let kill = format!("kill -INT {}", bake.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    let ended = bake.wait().unwrap();
    assert!(pressed.elapsed() < Duration::from_secs(1), "{:?}", pressed.elapsed());
    assert_eq!(ended.code(), Some(130));
    let mut told = String::new();
    bake.stderr.take().unwrap().read_to_string(&mut told).unwrap();
    let tolerance = tolerance_in(&baked);
    assert!(told.contains("interrupted") && told.contains(&format!("at tolerance {tolerance}")), "{told}");
    let kept: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(kept, ["baked.glb"]);
}
