//! What a bake mends or refuses for the sake of whoever gave it the scene, as they meet it.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::fs;

use common::{err, folder, out, umbrage};

/// A closed room of 2 x 2 x 2 m that looks in, its floor turned over or not, and a lamp in it.
fn room(floor: &str) -> String {
    format!(
        "mtllib room.mtl\nv 0 0 0\nv 2 0 0\nv 0 2 0\nv 2 2 0\nv 0 0 2\nv 2 0 2\nv 0 2 2\nv 2 2 2\nusemtl wall\n\
         f 1 2 4 3\nf 6 5 7 8\nf {floor}\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n\
         usemtl lamp\nv 0.7 1.9 0.7\nv 1.3 1.9 0.7\nv 1.3 1.9 1.3\nv 0.7 1.9 1.3\nf 9 10 11 12\n"
    )
}

#[test]
fn a_wall_that_looks_out_of_a_closed_room_is_turned_over_with_a_warning_and_verified_so() {
    let folder = folder("turned");
    let path = |name: &str| folder.join(name).display().to_string();
    fs::write(path("room.mtl"), "newmtl wall\nKd .5 .5 .5\nnewmtl lamp\nKe 9 9 9\n").unwrap();
    fs::write(path("sound.obj"), room("1 5 6 2")).unwrap();
    fs::write(path("room.obj"), room("2 6 5 1")).unwrap();
    for (scene, turned) in [("sound", false), ("room", true)] {
        let (scene, baked) = (path(&format!("{scene}.obj")), path(&format!("{scene}.glb")));
        let bake = umbrage(&["bake", &scene, "-o", &baked, "--tolerance", "0.05"]);
        assert!(bake.status.success(), "{}", err(&bake));
        assert_eq!(err(&bake).contains("were turned over"), turned, "{}", err(&bake));
        assert_eq!(out(&bake).contains("1 polygon turned over"), turned, "{}", out(&bake));
        let info = umbrage(&["info", &scene]);
        assert_eq!(out(&info).contains("1 polygon turned over"), turned, "{}", out(&info));
        let verify = umbrage(&["verify", &scene, &baked, "--max-error", "0.1", "--points", "200", "--paths", "1024"]);
        assert!(verify.status.success(), "{}{}", out(&verify), err(&verify));
        assert_eq!(err(&verify).contains("were turned over"), turned, "{}", err(&verify));
    }
}

#[test]
fn a_bake_never_replaces_its_own_scene() {
    let folder = folder("own_scene");
    let scene = folder.join("room.obj");
    fs::write(&scene, room("1 5 6 2")).unwrap();
    let before = fs::read(&scene).unwrap();
    // By whatever name.
    let output = folder.join("..").join("own_scene").join("room.obj");
    let [scene, output] = [scene, output].map(|path| path.display().to_string());
    let refused = umbrage(&["bake", &scene, "-o", &output, "--emit", "lamp=9"]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(err(&refused).contains("is the scene itself"), "{}", err(&refused));
    assert_eq!(fs::read(&scene).unwrap(), before);
}
