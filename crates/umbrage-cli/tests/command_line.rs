//! The command `umbrage` as a user meets it: its words, its files and its exit codes.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::{code, err, folder, out, scene, umbrage};

#[test]
fn help_names_every_command_and_shows_how() {
    let help = umbrage(&["--help"]);
    assert_eq!(code(&help), Some(0));
    for word in [
        "bake",
        "demo",
        "render",
        "page",
        "info",
        "form-factor",
        "verify",
        "inspect",
        "view",
        "Examples:",
        "Exit codes:",
    ] {
        assert!(out(&help).contains(word), "{word}");
    }
    for command in ["bake", "demo", "render", "page", "info", "form-factor", "verify", "inspect"] {
        let help = umbrage(&[command, "--help"]);
        assert_eq!(code(&help), Some(0), "{command}");
        assert!(out(&help).contains("Usage: umbrage"), "{command}");
    }
    assert!(out(&umbrage(&["--version"])).starts_with("umbrage 0."));
}

#[test]
fn where_the_window_is_not_installed_it_is_told_how_to() {
    // A copy of the program, which has no other beside it.
    let folder = folder("no_window");
    let copy = folder.join(format!("umbrage{}", std::env::consts::EXE_SUFFIX));
    fs::copy(env!("CARGO_BIN_EXE_umbrage"), &copy).unwrap();
    let told = Command::new(copy).args(["view", "room.glb"]).env("PATH", &folder).output().unwrap();
    assert_eq!(code(&told), Some(1));
    assert!(err(&told).contains("cargo install --path crates/umbrage-view"), "{}", err(&told));
}

#[test]
fn wrong_usage_is_told_with_code_2() {
    for arguments in [
        &["bake"][..],
        &["bake", "a.glb"],
        &["bake", "a.glb", "-o", "b.glb", "--max-form-factor", "0"],
        &["bake", "a.glb", "-o", "b.glb", "--score", "best"],
        &["render", "a.glb", "-o", "b.png", "--eye", "1,2,3"],
        &["render", "a.glb", "-o", "b.png", "--width", "0"],
        &["render", "a.glb", "-o", "b.png", "--difference"],
        &["render", "a.glb", "-o", "b.png", "--false-color", "--exposure", "2"],
        &["render", "a.glb", "-o", "b.png", "--scale-end", "2"],
        &["page", "a.glb"],
        &["demo", "--threads", "0"],
        &["info", "a.glb", "-q", "-v"],
        &["polish"],
        &[],
    ] {
        let refused = umbrage(arguments);
        assert_eq!(code(&refused), Some(2), "{arguments:?}");
        assert!(!err(&refused).is_empty(), "{arguments:?}");
    }
    let refused = umbrage(&["bake", "a.glb", "-o", "b.glb", "--score", "best"]);
    assert!(err(&refused).contains("eq1") && err(&refused).contains("well-shaped"), "{}", err(&refused));
}

#[test]
fn a_missing_file_is_named_with_code_1() {
    for arguments in [
        &["info", "no/such.glb"][..],
        &["bake", "no/such.glb", "-o", "b.glb"],
        &["render", "no/such.glb", "-o", "b.png"],
        &["page", "no/such.glb", "-o", "b.html"],
    ] {
        let failed = umbrage(arguments);
        assert_eq!(code(&failed), Some(1), "{arguments:?}");
        assert!(err(&failed).starts_with("error: ") && err(&failed).contains("no/such.glb"), "{}", err(&failed));
        assert!(out(&failed).is_empty());
        assert!(!err(&failed).contains('\u{1b}'), "colour without a terminal");
    }
}

#[test]
fn what_cannot_be_read_leaves_no_file() {
    let folder = folder("unreadable");
    let [scene, baked] = ["scene.glb", "baked.glb"].map(|name| folder.join(name).display().to_string());
    for bytes in [&b""[..], b"glTF", b"{}", b"not a scene at all"] {
        fs::write(&scene, bytes).unwrap();
        let failed = umbrage(&["bake", &scene, "-o", &baked]);
        assert_eq!(code(&failed), Some(1), "{}", err(&failed));
        assert!(err(&failed).contains("scene.glb") && !Path::new(&baked).exists(), "{}", err(&failed));
    }
}

#[test]
fn a_scene_without_light_says_what_to_do() {
    let folder = folder("lightless");
    let [scene, baked] = ["scene.gltf", "baked.glb"].map(|name| folder.join(name).display().to_string());
    // One triangle: (0,0,0), (1,0,0), (0,1,0).
    let gltf = r#"{
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                       "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36,
            "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]
    }"#;
    fs::write(&scene, gltf).unwrap();
    let failed = umbrage(&["bake", &scene, "-o", &baked]);
    assert_eq!(code(&failed), Some(1));
    assert!(err(&failed).contains("emissiveFactor"), "{}", err(&failed));
    let told = umbrage(&["info", &scene]);
    assert_eq!(code(&told), Some(0), "{}", err(&told));
    assert!(out(&told).contains("emitters    none") && out(&told).contains("0.5 m2"), "{}", out(&told));
    assert!(err(&told).contains("emissiveFactor"), "{}", err(&told));
}

#[test]
fn the_demo_leaves_a_glb_and_a_picture_that_renders_again() {
    let folder = folder("demo").join("new");
    let path = |name: &str| folder.join(name).display().to_string();
    let demo = umbrage(&["demo", "--out-dir", &folder.display().to_string()]);
    assert_eq!(code(&demo), Some(0), "{}", err(&demo));
    for word in ["faces", "d-segments", "patches", "links", "triangles", "residual", "prepare", "cornell.glb", "Next:"]
    {
        assert!(out(&demo).contains(word), "{word} is not in\n{}", out(&demo));
    }
    assert!(err(&demo).is_empty(), "{}", err(&demo));
    assert_eq!(fs::read(path("cornell.glb")).unwrap()[..4], *b"glTF");
    let picture = fs::read(path("cornell.png")).unwrap();
    assert_eq!(picture[1..4], *b"PNG");

    let again = umbrage(&["render", &path("cornell.glb"), "-o", &path("again.png"), "--threads", "1", "-q"]);
    assert_eq!((code(&again), out(&again)), (Some(0), String::new()), "{}", err(&again));
    assert_eq!(fs::read(path("again.png")).unwrap(), picture);

    let wires = umbrage(&["render", &path("cornell.glb"), "-o", &path("wires.png"), "--wireframe", "--width", "300"]);
    assert_eq!(code(&wires), Some(0), "{}", err(&wires));
    assert_ne!(fs::read(path("wires.png")).unwrap(), picture);

    let baked = path("cornell.glb");
    let render = |name: &str, more: &[&str]| {
        let picture = path(name);
        let arguments = [&["render", &baked, "-o", &picture, "--width", "90", "--height", "60"][..], more].concat();
        let done = umbrage(&arguments);
        (code(&done), out(&done) + &err(&done))
    };
    assert_eq!(render("lux.png", &["--false-color", "lx"]).0, Some(0));
    assert_eq!(render("film.png", &["--tone", "filmic", "--light-only"]).0, Some(0));
    // Twice the same file: no difference, and three pictures with two gaps between.
    let (done, told) = render("both.png", &[&baked, "--side-by-side", "--difference"]);
    assert_eq!(done, Some(0), "{told}");
    assert!(told.contains("root mean square 0.0000 W/m2, 0.00 %"), "{told}");
    let both = fs::read(path("both.png")).unwrap();
    let side = |at: usize| u32::from_be_bytes(both[at..at + 4].try_into().unwrap());
    assert_eq!((side(16), side(20)), (3 * 90 + 2 * 4, 60));
    for (name, more, word) in [
        ("none.png", &[&*baked][..], "--side-by-side"),
        ("none.png", &["--side-by-side"], "two baked files"),
        ("none.png", &["--camera", "door"], "the file has none"),
        ("none.jpg", &[], ".png or .exr"),
        ("none.exr", &["--tone", "filmic"], if cfg!(feature = "exr") { "leave out" } else { "--features exr" }),
    ] {
        let (failed, told) = render(name, more);
        assert_eq!(failed, Some(1), "{more:?}");
        assert!(told.contains(word) && !folder.join(name).exists(), "{told}");
    }
    if cfg!(feature = "exr") {
        assert_eq!(render("light.exr", &[]).0, Some(0));
        assert_eq!(fs::read(path("light.exr")).unwrap()[..4], [0x76, 0x2f, 0x31, 0x01]);
    }

    let page = umbrage(&["page", &baked, "-o", &path("cornell.html"), "--title", "<b>&\"quoted\""]);
    assert_eq!(code(&page), Some(0), "{}", err(&page));
    let html = fs::read_to_string(path("cornell.html")).unwrap();
    assert!(html.contains("<title>&lt;b&gt;&amp;&quot;quoted&quot;</title>") && !html.contains("<b>"));

    let unbaked = umbrage(&["render", &path("cornell.png"), "-o", &path("none.png")]);
    assert_eq!(code(&unbaked), Some(1));
    assert!(!folder.join("none.png").exists());
}

/// Ctrl-C during a bake ends it with 130 and leaves nothing behind.
#[cfg(unix)]
#[test]
fn an_interrupted_demo_leaves_nothing() {
    use std::io::{BufRead, BufReader};
    use std::process::Stdio;

    let folder = folder("interrupted");
    let mut demo = Command::new(env!("CARGO_BIN_EXE_umbrage"))
        .args(["demo", "-v", "--out-dir", &folder.display().to_string()])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The log tells when Ctrl-C is listened for.
    let mut log = BufReader::new(demo.stderr.take().unwrap());
    let mut line = String::new();
    log.read_line(&mut line).unwrap();
    assert!(line.contains("Ctrl-C"), "{line}");
    let kill = format!("kill -INT {}", demo.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    let rest: Vec<String> = log.lines().map(Result::unwrap).collect();
    assert_eq!(demo.wait().unwrap().code(), Some(130), "{rest:?}");
    assert!(rest.last().unwrap().contains("interrupted"), "{rest:?}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
}

#[test]
fn materials_and_units_are_said_beside_the_file() {
    let folder = folder("said");
    let path = |name: &str| folder.join(name).display().to_string();
    let (scene, baked) = (path("room.obj"), path("baked.glb"));
    // A lamp over a floor, in millimetres.
    let obj = "v 0 0 0\nv 4000 0 0\nv 4000 0 4000\nv 0 0 4000\nv 0 3000 0\nv 4000 3000 0\nv 4000 3000 4000\nv 0 3000 4000\n\
        usemtl floor\nf 4 3 2 1\nusemtl lamp\nf 5 6 7 8\n";
    fs::write(&scene, obj).unwrap();
    let told = umbrage(&["info", &scene]);
    assert_eq!(code(&told), Some(0));
    assert!(out(&told).contains("--unit mm") && out(&told).contains("0 closed, 2 open"), "{}", out(&told));
    assert!(err(&told).contains("--emit MATERIAL=r,g,b") && err(&told).contains("\"lamp\""), "{}", err(&told));

    let refused = umbrage(&["bake", &scene, "-o", &baked, "--emit", "lamb=1"]);
    assert_eq!(code(&refused), Some(1));
    assert!(err(&refused).contains("perhaps \"lamp\" is meant"), "{}", err(&refused));
    assert_eq!(code(&umbrage(&["bake", &scene, "-o", &baked, "--emit", "lamp"])), Some(2));
    let refused = umbrage(&["bake", &scene, "-o", &baked, "--emit", "lamp=1", "--skip", "rom"]);
    assert_eq!(code(&refused), Some(1));
    assert!(err(&refused).contains("no node \"rom\", perhaps \"room\" is meant"), "{}", err(&refused));
    assert!(!Path::new(&baked).exists());

    fs::write(
        path("room.umbrage.toml"),
        "[materials.lamp]\nemission = [1, 2, 4]\n[materials.floor]\nreflectance = 0.2\n",
    )
    .unwrap();
    let told = umbrage(&["info", &scene, "--unit", "mm", "--reflectance", "floor=0.1"]);
    // pi x 1 x 16 m2 = 50.27 W.
    assert!(out(&told).contains("total: 50.27 100.5 201.1") && out(&told).contains("0.1 0.1 0.1"), "{}", out(&told));
    assert!(!err(&told).contains("cannot be baked") && !out(&told).contains("perhaps"), "{}", err(&told));
    let done = umbrage(&["bake", &scene, "-o", &baked, "--unit", "mm"]);
    assert_eq!(code(&done), Some(0), "{}", err(&done));
    assert!(Path::new(&baked).exists());
}

#[test]
fn sides_are_said_for_the_whole_scene() {
    let folder = folder("sides");
    let path = |name: &str| folder.join(name).display().to_string();
    let scene = path("room.obj");
    let obj = "v 0 0 0\nv 4 0 0\nv 4 0 4\nv 0 0 4\nv 0 3 0\nv 4 3 0\nv 4 3 4\nv 0 3 4\n\
        usemtl floor\nf 4 3 2 1\nusemtl lamp\nf 5 6 7 8\n";
    fs::write(&scene, obj).unwrap();
    fs::write(path("room.umbrage.toml"), "[materials.lamp]\nemission = 1\ndouble_sided = false\n").unwrap();
    let sides = |more: &[&str]| {
        let told = umbrage(&[&["info", &scene], more].concat());
        assert_eq!(code(&told), Some(0), "{}", err(&told));
        let of = |name: &str| out(&told).lines().any(|line| line.contains(name) && line.contains("double-sided"));
        [of("\"floor\":"), of("\"lamp\":")]
    };
    assert_eq!(sides(&[]), [false, false]);
    assert_eq!(sides(&["--double-sided"]), [true, false], "the TOML says otherwise of the lamp");
    let whole = "double_sided = true\n[materials.lamp]\nemission = 1\n";
    fs::write(path("room.umbrage.toml"), whole).unwrap();
    assert_eq!((sides(&[]), sides(&["--single-sided"])), ([true; 2], [false; 2]));
    // Whatever reads a scene knows them, and none takes both.
    for command in ["bake", "info", "verify", "inspect", "render", "form-factor"] {
        let help = out(&umbrage(&[command, "--help"]));
        assert!(help.contains("--single-sided") && help.contains("--double-sided"), "{command}");
    }
    assert_eq!(code(&umbrage(&["info", &scene, "--single-sided", "--double-sided"])), Some(2));
    // A floor that is lit from below as well has twice the triangles.
    let triangles = |option: &str| {
        let baked = path("baked.glb");
        let done = umbrage(&["bake", &scene, "-o", &baked, "--tolerance", "none", option]);
        assert_eq!(code(&done), Some(0), "{}", err(&done));
        let line = out(&done).lines().find(|line| line.contains("triangles")).unwrap().to_owned();
        line.split_whitespace().nth(1).unwrap().replace(',', "").parse::<usize>().unwrap()
    };
    assert!(triangles("--double-sided") > triangles("--single-sided"));
}

#[test]
fn stages_are_told_and_drawn() {
    let folder = folder("inspect");
    let scene = "../../testdata/scenes/occluder.glb";
    let told = umbrage(&["inspect", scene, "--stage", "d-segments"]);
    assert_eq!(code(&told), Some(0), "{}", err(&told));
    let json: serde_json::Value = serde_json::from_str(&out(&told)).unwrap();
    assert_eq!(json["d_segments"].as_array().map(Vec::len), Some(8), "umbra and penumbra lines of four edges");
    for stage in ["d-segments", "patches", "mesh"] {
        let drawing = folder.join(format!("{stage}.svg"));
        let drawn = umbrage(&["inspect", scene, "--stage", stage, "-o", drawing.to_str().unwrap()]);
        assert_eq!(code(&drawn), Some(0), "{}", err(&drawn));
        assert!(fs::read_to_string(&drawing).unwrap().contains("class=\"bar\""), "{stage} has a scale bar");
    }
    let refused = umbrage(&["inspect", scene, "--stage", "mesh", "-o", "mesh.png"]);
    assert!(code(&refused) == Some(1) && err(&refused).contains(".svg"), "{}", err(&refused));
}

#[test]
fn form_factors_are_a_table() {
    let factor = |line: &str| line.split(',').nth(3).unwrap().parse::<f64>().unwrap();
    for (name, truth) in [("vf_parallel", 0.1998248957), ("vf_perp", 0.2000437761)] {
        let told = umbrage(&["form-factor", &scene(&format!("{name}.glb")), "--by", "material", "--from", "a"]);
        assert_eq!(code(&told), Some(0), "{}", err(&told));
        let text = out(&told);
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("receiver,receiver_area_m2,source,factor,error_bound"), "{text}");
        assert!(lines.len() == 3 && lines[1].starts_with("a,1,b,") && lines[2].starts_with("a,1,(sum),"), "{text}");
        assert!((factor(lines[1]) - truth).abs() < 1e-9, "{text}");
    }
    let path = folder("factors").join("furnace.csv").display().to_string();
    let done = umbrage(&["form-factor", &scene("furnace.glb"), "--by", "face", "-o", &path]);
    assert!(out(&done).contains("30 form factors between 6 faces"), "{} {}", out(&done), err(&done));
    let table = fs::read_to_string(&path).unwrap();
    let sums: Vec<f64> = table.lines().filter(|line| line.contains(",(sum),")).map(factor).collect();
    assert!(sums.len() == 6 && sums.iter().all(|sum| (sum - 1.0).abs() < 1e-9), "{table}");
    let refused = umbrage(&["form-factor", &scene("furnace.glb"), "--from", "sofa"]);
    assert_eq!(code(&refused), Some(1));
    assert!(err(&refused).contains("\"sofa\"") && err(&refused).contains("--by"), "{}", err(&refused));
}

#[test]
fn a_bake_is_verified_and_one_of_another_scene_is_not() {
    let baked = folder("verified").join("baked.glb").display().to_string();
    assert_eq!(code(&umbrage(&["bake", &scene("occluder.glb"), "-o", &baked])), Some(0));
    let few = ["--points", "200", "--paths", "128"];
    let verify = |more: &[&str]| umbrage(&[&["verify", &scene("occluder.glb"), &baked], &few[..], more].concat());
    let good = verify(&["--max-error", "0.05"]);
    assert_eq!(code(&good), Some(0), "{}{}", out(&good), err(&good));
    for word in ["error", "bias", "noise", "estimate", "leaks         none", "worst", "W/m2 baked"] {
        assert!(out(&good).contains(word), "{word} is not in\n{}", out(&good));
    }
    assert_eq!(err(&good), "");
    let coarse = ["bake", &scene("occluder.glb"), "-o", &baked, "--tolerance", "none", "--no-discontinuities"];
    assert_eq!(code(&umbrage(&coarse)), Some(0));
    let bad = verify(&["--max-error", "0.05"]);
    assert_eq!(code(&bad), Some(3), "{}{}", out(&bad), err(&bad));
    assert!(err(&bad).contains("should be at most 5.000 %"), "{}", err(&bad));
    let other = umbrage(&[&["verify", &scene("touching.glb"), &baked], &few[..]].concat());
    assert!(out(&other).contains("uncovered") || code(&other) == Some(1), "{}{}", out(&other), err(&other));
}
