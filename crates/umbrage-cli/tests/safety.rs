//! What a command may write and replace, what it says, and what ends it.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::fs;
use std::process::Command;

use common::{code, err, folder, out, scene, umbrage};

/// A baked Cornell box in a folder of its own, coarse.
fn baked(name: &str) -> (std::path::PathBuf, String) {
    let folder = folder(name);
    let baked = folder.join("b.glb").display().to_string();
    let done = umbrage(&["bake", &scene("cornell.obj"), "-o", &baked, "--tolerance", "1"]);
    assert!(done.status.success(), "{}", err(&done));
    (folder, baked)
}

#[test]
fn no_command_replaces_what_it_could_not_have_made() {
    let (folder, baked) = baked("replace");
    let before = fs::read(&baked).unwrap();
    let foreign = folder.join("cornell.glb").display().to_string();
    fs::write(&foreign, b"glTF of somebody").unwrap();
    let out_dir = folder.display().to_string();
    let cornell = scene("cornell.obj");
    for arguments in [
        &["page", &baked, "-o", &baked][..],
        &["bake", &cornell, "-o", &foreign],
        &["demo", "--out-dir", &out_dir],
        &["bake", &cornell, "-o", &baked, "--report", &foreign],
        &["inspect", &cornell, "--stage", "mesh", "-o", "Cargo.json"],
    ] {
        let cargo = folder.join("Cargo.json");
        fs::write(&cargo, "{}").unwrap();
        let cargo = cargo.display().to_string();
        let arguments: Vec<&str> = arguments.iter().map(|a| if *a == "Cargo.json" { &cargo } else { *a }).collect();
        let refused = umbrage(&arguments);
        assert_eq!(code(&refused), Some(1), "{arguments:?}: {}", err(&refused));
        assert!(err(&refused).contains("--force"), "{}", err(&refused));
    }
    assert_eq!(fs::read(&baked).unwrap(), before);
    assert_eq!(fs::read(&foreign).unwrap(), b"glTF of somebody");
    // Its own it replaces, and others when it must.
    assert!(umbrage(&["bake", &cornell, "-o", &baked, "--tolerance", "1"]).status.success());
    assert!(umbrage(&["bake", &cornell, "-o", &foreign, "--tolerance", "1", "--force"]).status.success());
    let page = folder.join("p.html").display().to_string();
    assert!((0..2).all(|_| umbrage(&["page", &baked, "-o", &page]).status.success()));
}

#[test]
fn a_baked_file_is_no_scene() {
    let (folder, baked) = baked("no_scene");
    let told = umbrage(&["bake", &baked, "-o", folder.join("c.glb").to_str().unwrap()]);
    assert!(code(&told) == Some(1) && err(&told).contains("is a baked file and no scene"), "{}", err(&told));
}

#[test]
fn an_exposure_is_one_number_for_baking_and_drawing() {
    let (folder, first) = baked("exposure");
    let cornell = scene("cornell.obj");
    let path = |name: &str| folder.join(name).display().to_string();
    let told = out(&umbrage(&["bake", &cornell, "-o", &first, "--tolerance", "1"]));
    let k = told.lines().find_map(|line| line.trim().strip_prefix("exposure")).unwrap().trim().to_owned();
    let k = k.split(',').next().unwrap().to_owned();
    assert!(k.trim_matches('0').replace('.', "").len() <= 4, "{k}");
    // What was told gives the same file when it is asked for, but for the words that say who chose it.
    assert!(
        umbrage(&["bake", &cornell, "-o", &path("again.glb"), "--tolerance", "1", "--exposure", &k]).status.success()
    );
    for (file, picture) in [(&first, "one.png"), (&path("again.glb"), "two.png")] {
        assert!(umbrage(&["render", file, "-o", &path(picture), "--width", "64", "--height", "64"]).status.success());
    }
    assert_eq!(fs::read(path("one.png")).unwrap(), fs::read(path("two.png")).unwrap());
    let double = (2.0 * k.parse::<f64>().unwrap()).to_string();
    assert!(
        umbrage(&["bake", &cornell, "-o", &path("double.glb"), "--tolerance", "1", "--exposure", &double])
            .status
            .success()
    );
    let small = ["--width", "64", "--height", "64", "--light-only"];
    let draw = |file: &str, picture: &str, more: &[&str]| {
        assert!(umbrage(&[&["render", file, "-o", picture], &small[..], more].concat()).status.success());
    };
    draw(&first, &path("drawn.png"), &["--exposure", &k]);
    draw(&path("double.glb"), &path("other.png"), &["--exposure", &k]);
    let pixels = |name: &str| {
        let mut reader =
            png::Decoder::new(std::io::BufReader::new(fs::File::open(path(name)).unwrap())).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        bytes
    };
    let (drawn, other) = (pixels("drawn.png"), pixels("other.png"));
    let differ = drawn.iter().zip(&other).filter(|(a, b)| a.abs_diff(**b) > 2).count();
    assert!(differ * 50 < drawn.len(), "{differ} of {}", drawn.len());
}

#[test]
fn photometric_scenes_are_told_in_lumens() {
    let told = out(&umbrage(&["info", &scene("cornell.mgf")]));
    assert!(told.contains("in lm") && told.contains("cd/m2") && !told.contains(" W"), "{told}");
    let told = out(&umbrage(&["info", &scene("cornell.obj")]));
    assert!(told.contains("in W") && !told.contains("lm"), "{told}");
    // And so are their bakes, where they are checked and where they are shown.
    let folder = folder("lumens");
    let path = |name: &str| folder.join(name).display().to_string();
    for (file, unit, other) in [("cornell.mgf", " lx ", "W/m2"), ("cornell.obj", " W/m2 ", " lx")] {
        let baked = path("b.glb");
        assert!(umbrage(&["bake", &scene(file), "-o", &baked, "--tolerance", "1"]).status.success());
        let told = out(&umbrage(&["verify", &scene(file), &baked, "--points", "20", "--paths", "8"]));
        assert!(told.contains(unit) && !told.contains(other), "{told}");
        let page = path("p.html");
        assert!(umbrage(&["page", &baked, "-o", &page]).status.success());
        let is_photometric = format!("\"photometric\":{}", file.ends_with("mgf"));
        assert!(fs::read_to_string(&page).unwrap().contains(&is_photometric));
    }
}

#[test]
fn numbers_that_mean_nothing_are_told_in_words() {
    for (arguments, words) in [
        (["--tolerance", "-1"], "share of the mean light"),
        (["--tolerance", "1e308"], "share of the mean light"),
        (["--max-triangles", "-5"], "whole number"),
        (["--exposure", "-5"], "more than 0"),
    ] {
        let told = umbrage(&[&["bake", "a.obj", "-o", "b.glb"], &arguments[..]].concat());
        assert!(code(&told) == Some(2) && err(&told).contains(words), "{arguments:?}: {}", err(&told));
    }
}

#[test]
fn more_threads_than_help_are_not_started() {
    let info = Command::new(env!("CARGO_BIN_EXE_umbrage"))
        .args(["--threads", "65535", "info", &scene("cornell.obj")])
        .output()
        .unwrap();
    assert!(info.status.success(), "{}", err(&info));
}

#[test]
fn files_of_other_programs_are_named_with_what_to_do() {
    let folder = folder("others");
    for (name, bytes, words) in [
        ("a.blend", &b"BLENDER-v300"[..], "Punctual Lights"),
        ("a.fbx", b"Kaydara FBX Binary", "Blender"),
        ("a.usdc", b"PXR-USDC", "Blender"),
        ("renamed", b"BLENDER-v300", "a Blender file"),
    ] {
        let path = folder.join(name);
        fs::write(&path, bytes).unwrap();
        let told = umbrage(&["info", path.to_str().unwrap()]);
        assert!(code(&told) == Some(1) && err(&told).contains(words), "{}", err(&told));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn memory_is_limited_while_a_scene_is_read() {
    // A PNG of 8192 x 8192 texels in a file of some kilobytes: all rows are alike.
    let folder = folder("memory");
    let mut picture = Vec::new();
    let mut encoder = png::Encoder::new(&mut picture, 8192, 8192);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&vec![128; 4 << 26]).unwrap();
    writer.finish().unwrap();
    fs::write(folder.join("p.png"), picture).unwrap();
    fs::write(folder.join("a.mtl"), "newmtl w\nKd 1 1 1\nmap_Kd p.png\nnewmtl l\nKe 5 5 5\n").unwrap();
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\nvt 0 0\nusemtl w\nf 1/1 2/1 3/1\nusemtl l\nf 1 2 4\n";
    fs::write(folder.join("a.obj"), text).unwrap();
    let (scene, output) = (folder.join("a.obj"), folder.join("a.glb"));
    let told = umbrage(&["bake", scene.to_str().unwrap(), "-o", output.to_str().unwrap(), "--memory-limit", "100MiB"]);
    assert!(code(&told) == Some(1) && err(&told).contains("while the scene was read"), "{}", err(&told));
    assert!(!output.exists());
}

#[cfg(unix)]
#[test]
fn a_signal_to_end_is_heeded_as_ctrl_c_is() {
    let folder = folder("signal");
    for signal in ["TERM", "HUP"] {
        let output = folder.join("o.glb");
        let mut child = Command::new(env!("CARGO_BIN_EXE_umbrage"))
            .args(["bake", &scene("cornell.obj"), "-o", output.to_str().unwrap(), "--tolerance", "0.0005"])
            .stderr(std::process::Stdio::piped())
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(700));
        let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        assert_eq!(child.wait().unwrap().code(), Some(130), "SIG{signal}");
        assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "nothing is left behind");
    }
}
