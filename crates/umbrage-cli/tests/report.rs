//! `umbrage bake --report`: every key is documented, every documented key is there, and counts are those of the file.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::Value;

use common::{code, err, folder, out, scene, umbrage};

/// Two floors that look at nothing but a lamp, one corner above the other in reading order, so that the file has each kind of entry.
const OBJ: &str = "v 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nv 1 3 1\nv 3 3 1\nv 3 3 3\nv 1 3 3\n\
    usemtl floor\nf 4 3 2 1\nusemtl lamp\nf 5 6 7 8\n";
const TOML: &str = "[materials.lamp]\nemission = 1\n[materials.floor]\nreflectance = 0.95\n\
    [[lamps]]\nname = \"bulb\"\nposition = [2, 1, 2]\nintensity = 8\n";

/// The paths of all numbers, texts and truths of a report: `lamps[].name`. An array of numbers is one value.
fn keys(value: &Value, path: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                keys(value, &path, found);
            }
        }
        Value::Array(items) if items.iter().any(Value::is_object) => {
            items.iter().for_each(|item| keys(item, &format!("{path}[]"), found));
        }
        _ => {
            found.insert(path.to_owned());
        }
    }
}

/// The first column of the tables of a section of the documentation.
fn documented(section: &str) -> BTreeSet<String> {
    let page = fs::read_to_string(format!("{}/../../docs/report.md", env!("CARGO_MANIFEST_DIR"))).unwrap();
    let section = page.split("\n## ").find(|text| text.starts_with(section)).unwrap();
    let cells = section.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` |"));
    cells.map(|(key, _)| key.to_owned()).collect()
}

fn report(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// Vertices and triangles of a GLB, by its own accessors.
fn counts_of_glb(path: &Path) -> [u64; 2] {
    let bytes = fs::read(path).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let gltf: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let count = |accessor: &Value| gltf["accessors"][accessor.as_u64().unwrap() as usize]["count"].as_u64().unwrap();
    let meshes = gltf["meshes"].as_array().unwrap().iter();
    let primitives: Vec<&Value> = meshes.flat_map(|mesh| mesh["primitives"].as_array().unwrap()).collect();
    let sum = |of: &dyn Fn(&Value) -> u64| primitives.iter().map(|&primitive| of(primitive)).sum();
    [sum(&|p| count(&p["attributes"]["POSITION"])), sum(&|p| count(&p["indices"]) / 3)]
}

#[test]
fn every_key_is_documented_and_every_documented_key_is_there() {
    let folder = folder("keys");
    let path = |name: &str| folder.join(name).display().to_string();
    fs::write(path("room.obj"), OBJ).unwrap();
    fs::write(path("room.umbrage.toml"), TOML).unwrap();
    let done = umbrage(&["bake", &path("room.obj"), "-o", &path("baked.glb"), "--report", &path("baked.json")]);
    assert_eq!(code(&done), Some(0), "{}", err(&done));
    assert!(out(&done).contains("baked.json") && err(&done).contains("warning"), "{}{}", out(&done), err(&done));
    let told = report(&folder.join("baked.json"));
    let mut found = BTreeSet::new();
    keys(&told, "", &mut found);
    assert_eq!(found, documented("Keys\n"));

    let text = fs::read_to_string(folder.join("baked.json")).unwrap();
    assert!(!text.contains(&folder.display().to_string()), "no folder of this machine is in it: {text}");
    assert_eq!((told["input"].as_str(), told["output"].as_str()), (Some("room.obj"), Some("baked.glb")));
    assert_eq!(told["lamps"][0]["name"], "bulb");
    // 8 W/sr in all directions.
    let emitted = told["lamps"][0]["emitted_w"][0].as_f64().unwrap();
    assert!((emitted / (32.0 * std::f64::consts::PI) - 1.0).abs() < 1e-12, "{emitted}");
    // All of it goes somewhere, and surfaces show what falls on them.
    let lamp_w = |key: &str| told["lamps"][0][key][0].as_f64().unwrap();
    let fates_w = ["expected_w", "on_backs_w", "leaving_w", "fading_w"].map(lamp_w).iter().sum::<f64>();
    assert!((fates_w / emitted - 1.0).abs() < 1e-6 && (lamp_w("sent_w") / emitted - 1.0).abs() < 1e-6, "{fates_w}");
    let share = told["lamps"][0]["received_share"].as_f64().unwrap();
    assert!((share - 1.0).abs() < 0.05 && (lamp_w("received_w") / lamp_w("expected_w") / share - 1.0).abs() < 1e-6);
    assert_eq!(told["warnings"][0]["about"], "scene");
    let warned = told["warnings"][0]["text"].as_str().unwrap();
    assert!(err(&done).contains(warned), "{warned} is not in {}", err(&done));
}

#[test]
fn counts_settings_and_energy_are_those_of_the_bake() {
    let folder = folder("counts");
    let (baked, json) = (folder.join("baked.glb"), folder.join("baked.json"));
    let arguments = ["bake", &scene("occluder.glb"), "-o", baked.to_str().unwrap(), "--report", json.to_str().unwrap()];
    let done = umbrage(&[&arguments[..], &["--tolerance", "0.03", "--exposure", "0.5", "--keep-hidden"]].concat());
    assert_eq!((code(&done), err(&done)), (Some(0), String::new()), "{}", out(&done));
    let told = report(&json);
    let [vertices, triangles] = counts_of_glb(&baked);
    assert_eq!(
        (told["counts"]["vertices"].as_u64(), told["counts"]["triangles"].as_u64()),
        (Some(vertices), Some(triangles))
    );
    assert_eq!(told["output_bytes"].as_u64(), Some(fs::metadata(&baked).unwrap().len()));
    // Edges of lamp and plate are parallel, so all of an edge is seen at once: the slope of light jumps, at umbra and penumbra.
    assert_eq!(told["counts"]["d_segments"], serde_json::json!([0, 8, 0]));
    let settings = &told["settings"];
    assert_eq!((settings["tolerance"].as_f64(), settings["exposure"].as_f64()), (Some(0.03), Some(0.5)));
    assert_eq!((&settings["keep_hidden"], &settings["max_triangles"]), (&Value::Bool(true), &Value::Null));
    assert_eq!(told["warnings"], Value::Array(Vec::new()));
    // What comes goes, in each colour, by as much as the account says.
    let sum = |key: &str| told["energy"][key][0].as_f64().unwrap();
    let (comes, goes) = (sum("arriving_w"), sum("absorbed_w") + sum("on_backs_w") + sum("leaving_w"));
    assert!((goes / comes - 1.0).abs() < 0.01, "{comes} W come, {goes} W go");
    assert!((goes / comes - 1.0 - told["energy"]["error"].as_f64().unwrap()).abs() < 1e-9);
    let stages = told["time"]["stages"].as_array().unwrap();
    let seconds: f64 = stages.iter().map(|stage| stage["seconds"].as_f64().unwrap()).sum();
    assert!(stages.len() == 5 && seconds > 0.0 && seconds <= told["time"]["total_s"].as_f64().unwrap(), "{stages:?}");
}

#[test]
fn a_report_that_cannot_be_written_is_refused_before_the_bake() {
    let folder = folder("refused");
    let path = |name: &str| folder.join(name).display().to_string();
    fs::copy(scene("occluder.glb"), path("room.glb")).unwrap();
    let before = fs::read(path("room.glb")).unwrap();
    for (report, words) in [
        (path("no/such/r.json"), "no/such/r.json"),
        (path("room.glb"), "is the same file as"),
        (path("./out.glb"), "is the same file as"),
        (path("kept"), "is the same file as"),
        (path("room.umbrage.toml"), "is the same file as"),
        (folder.display().to_string(), "cannot be written"),
    ] {
        let bake = ["bake", &path("room.glb"), "-o", &path("out.glb"), "--report", &report, "--reuse", &path("kept")];
        let refused = umbrage(&bake);
        assert_eq!(code(&refused), Some(1), "{report}");
        assert!(err(&refused).contains(words), "no {words} in: {}", err(&refused));
    }
    assert_eq!(fs::read(path("room.glb")).unwrap(), before);
    let names: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(names, ["room.glb"], "nothing was baked, and nothing is left");
}

#[test]
fn warnings_about_the_result_are_documented() {
    // A lamp that crosses the edge of a black plate, of 1/500 of the scene.
    let folder = folder("warned");
    let path = |name: &str| folder.join(name).display().to_string();
    fs::write(path("bulb.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl grey\nf 1 2 3 4\n").unwrap();
    // A bulb that is in the plate's own edge, but for rounding: its light on the plate has no bound.
    let toml = "double_sided = true\n[[lamps]]\nname = \"bulb\"\nposition = [0.5, 0.5, 1e-9]\nintensity = 1\n";
    fs::write(path("bulb.umbrage.toml"), toml).unwrap();
    let bake = ["bake", &path("bulb.obj"), "-o", &path("baked.glb"), "--report", &path("r.json")];
    let done = umbrage(&[&bake[..], &["--tolerance", "0.0005"]].concat());
    assert_eq!(code(&done), Some(0), "{}", err(&done));
    let told = report(&folder.join("r.json"));
    let known = documented("Warnings about the result");
    assert_eq!(known.len(), 4);
    for warning in told["warnings"].as_array().unwrap() {
        if warning["about"] == "bake" {
            assert!(known.contains(warning["name"].as_str().unwrap()), "{warning}");
            assert!(err(&done).contains(warning["text"].as_str().unwrap()), "{}", err(&done));
        }
    }
    assert!(told["warnings"].as_array().unwrap().iter().any(|warning| warning["about"] == "bake"), "{told}");
}
