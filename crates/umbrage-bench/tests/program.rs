//! The program as one runs it: it starts itself for every bake.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::PathBuf;
use std::process::{Command, Output};

fn run(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_umbrage-bench")).args(arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A place for a file of this test.
fn temporary(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn a_run_of_the_suite_is_stored_and_compared_with_itself() {
    let path = temporary("run.json");
    let file = path.to_str().unwrap();
    let suite = run(&["suite", "--scenes", "occluder,field-12", "--tolerance", "0.1", "-o", file]);
    assert!(suite.status.success(), "{}", text(&suite.stderr));
    let stored: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    assert_eq!(stored["scenes"].as_array().unwrap().len(), 2);
    for scene in stored["scenes"].as_array().unwrap() {
        let [one, two] = [0, 1].map(|i| &scene["bakes"][i]);
        assert_eq!([one["threads"].as_u64(), two["threads"].as_u64()], [Some(1), Some(2)]);
        assert_eq!(one["digest"], two["digest"]);
        let stages = one["stage_seconds"].as_array().unwrap();
        let sum: f64 = stages.iter().map(|stage| stage[1].as_f64().unwrap()).sum();
        assert_eq!(stages.len(), 5);
        assert!(0.0 < sum && sum < one["seconds"].as_f64().unwrap());
        // It was asked for 10 %.
        let [error, uncertain] = [0, 1].map(|i| scene["verified"]["error"][i].as_f64().unwrap());
        assert!(error > 0.0 && error < 0.1 + 3.0 * uncertain, "{error} +- {uncertain}");
    }
    let compare = run(&["compare", file, file]);
    assert!(compare.status.success(), "{}", text(&compare.stderr));
    assert_eq!(text(&compare.stdout).matches("| field-12 |").count(), 2, "{}", text(&compare.stdout));
}

#[test]
fn scenes_that_are_not_there_are_told_and_the_others_are_measured() {
    let path = temporary("missing.json");
    let suite = run(&["suite", "--scenes", "nowhere.obj,field-12", "--tolerance", "0.5", "-o", path.to_str().unwrap()]);
    assert!(!suite.status.success());
    assert!(text(&suite.stderr).contains("nowhere.obj is neither a file nor one of"), "{}", text(&suite.stderr));
    assert!(text(&suite.stdout).contains("| field-12 |"), "{}", text(&suite.stdout));
    assert!(
        text(&suite.stdout).contains("nowhere.obj with 2 threads failed: exit status: 1"),
        "{}",
        text(&suite.stdout)
    );
    let convergence = run(&["convergence", "--scenes", "room", "-o", temporary("room.svg").to_str().unwrap()]);
    assert!(text(&convergence.stderr).contains("room has no reference points"), "{}", text(&convergence.stderr));
}

#[test]
fn a_bake_that_takes_too_long_is_recorded_as_one_that_did_not_end() {
    let path = temporary("long.json");
    let line = ["suite", "--scenes", "field-5000@0.001,field-12@0.5", "--limit", "0.5", "-o", path.to_str().unwrap()];
    let suite = run(&line);
    assert!(!suite.status.success());
    let stored: serde_json::Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    assert_eq!(stored["unfinished"].as_array().map(Vec::len), Some(1), "with one thread it was not even tried");
    assert_eq!(stored["unfinished"][0]["scene"], "field-5000@0.001");
    assert_eq!(stored["unfinished"][0]["why"], "did not end in 0.5 s");
    assert_eq!(stored["scenes"][0]["scene"], "field-12@0.5");
}
