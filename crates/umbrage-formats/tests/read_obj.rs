//! What is read from an OBJ and its material libraries: polygons, nodes, materials, warnings.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use common::{material_polygons, polygons, read_files, scene_path};
use glam::DVec3;
use umbrage::prepare::prepare;
use umbrage::progress::Progress;
use umbrage::scene::cornell::cornell_box;
use umbrage::scene::{Alpha, Rgb, Scene};
use umbrage_formats::{FormatError, ReadOptions, UpAxis, Warning, read_scene, read_scene_bytes, read_scene_with};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn read(text: &str) -> Result<(Scene, Vec<Warning>), FormatError> {
    read_scene_bytes("test.obj", text.as_bytes().to_vec(), &ReadOptions::default())
}

fn grey(count: usize) -> Warning {
    Warning::WithoutMaterial { polygons: count }
}

#[test]
fn the_cornell_file_is_the_built_in_cornell_box() {
    let (scene, warnings) = read_scene(scene_path("cornell.obj")).unwrap();
    assert_eq!(warnings, []);
    assert_eq!(scene.validate(), Ok(()));
    let built = cornell_box();
    assert_eq!(material_polygons(&scene), material_polygons(&built));
    for material in &built.materials {
        assert!(scene.materials.iter().any(|m| m == material), "{}", material.name);
    }
}

#[test]
fn polygons_of_any_size_and_corners_of_every_form() {
    let text = format!(
        "{SQUARE}v .5 2 0 1.0\nvt 0 0\nvn 0 0 1\nf 1 2 3 5 4\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 \\\n 2/1/1 3/1/1 # last\n"
    );
    let (scene, warnings) = read(&text).unwrap();
    assert_eq!(warnings, [grey(4)]);
    assert_eq!(scene.surfaces.raw[0].polygons[0].len(), 5);
    assert_eq!(polygons(&scene)[1..], vec![vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]; 3]);
    // Three of the five are there with a normal, too.
    assert_eq!(scene.surfaces.raw[0].positions_m.len(), 8);
    assert_eq!(scene.materials.raw[0].reflectance, Rgb::splat(0.5));
    assert_eq!(scene.nodes.raw[0].name.as_deref(), Some("test"));
}

#[test]
fn negative_numbers_count_back_and_positive_ones_may_look_ahead() {
    let (scene, _) = read("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -4 -3 -2\n").unwrap();
    let all = polygons(&scene);
    assert_eq!((all.len(), &all[0], &all[0]), (3, &all[1], &all[2]));
}

#[test]
fn windows_files_open() {
    let (scene, warnings) =
        read(&format!("\u{feff}# made by x:\\\n{SQUARE}g\nf 1 2 3 4\n").replace('\n', "\r\n")).unwrap();
    assert_eq!((scene.polygon_count(), warnings), (1, vec![grey(1)]));
}

#[test]
fn objects_and_groups_become_nodes() {
    let text = format!(
        "{SQUARE}f 1 2 3\no room\nf 1 2 3\ng wall left\nf 1 2 3\no table\ng wall left\nf 1 2 3\ng nothing\no room\nf 1 3 4\n"
    );
    let (scene, _) = read(&text).unwrap();
    let nodes: Vec<_> = scene.nodes.iter().map(|n| (n.name.as_deref().unwrap(), n.parent.map(usize::from))).collect();
    let expected = [("test", None), ("room", None), ("wall left", Some(1)), ("table", None), ("wall left", Some(3))];
    assert_eq!(nodes, expected);
    let of_node: Vec<_> = scene.surfaces.iter().map(|s| (usize::from(s.node), s.polygons.len())).collect();
    assert_eq!(of_node, [(0, 1), (1, 2), (2, 1), (4, 1)]);
}

#[test]
fn materials_come_from_libraries_in_the_folder() {
    let room = format!(
        "mtllib lib/my paint.mtl\nmtllib lib/my paint.mtl\n{SQUARE}usemtl wall #1\nf 1 2 3\nusemtl lamp\nf 1 3 4\n"
    );
    let paint = "newmtl wall #1\nKd 0.2 0.3 0.4\nmap_Kd -o 0 0 0 wood.png\nnewmtl lamp\nKd 1\nKe 5 6 7\nd 0.5\n";
    let (scene, warnings) = read_files(&[("room.obj", &room), ("lib/my paint.mtl", paint)]).unwrap();
    let [wall, lamp] = scene.materials.raw.as_slice() else { panic!("{:?}", scene.materials) };
    assert_eq!((wall.reflectance, wall.name.as_str()), (Rgb::new(0.2, 0.3, 0.4), "wall #1"));
    assert_eq!((lamp.radiance, lamp.reflectance), (Rgb::new(5.0, 6.0, 7.0), Rgb::splat(0.9)));
    let [Warning::TexturesIgnored { uses: 1, first }, others @ ..] = warnings.as_slice() else {
        panic!("{warnings:?}")
    };
    assert!(first.starts_with("lib/wood.png: cannot be read"), "{first}");
    let capped = Warning::ReflectanceCapped { materials: 1, max_reflectance: 0.9 };
    assert_eq!(others, [Warning::AlphaIgnored { materials: 1 }, capped]);
    let two = format!("mtllib a.mtl b.mtl\n{SQUARE}usemtl b\nf 1 2 3\n");
    let (scene, warnings) =
        read_files(&[("r.obj", &two), ("a.mtl", "newmtl b\nKd 1 0 0"), ("b.mtl", "newmtl b\nKd 0 0.5 0")]).unwrap();
    assert_eq!((warnings, scene.materials.raw[0].reflectance), (vec![], Rgb::new(0.0, 0.5, 0.0)));
}

#[test]
fn what_is_fully_transparent_is_left_out() {
    let room = format!("mtllib r.mtl\n{SQUARE}usemtl glass\nf 1 2 3\nusemtl wall\nf 1 3 4\n");
    let (scene, warnings) = read_files(&[("r.obj", &room), ("r.mtl", "newmtl glass\nd 0\nnewmtl wall\n")]).unwrap();
    assert_eq!((scene.polygon_count(), scene.materials.len()), (1, 1));
    assert_eq!(warnings, [Warning::TransparentLeftOut { polygons: 1 }]);
}

#[test]
fn missing_materials_are_grey_and_a_renamed_library_is_found() {
    let room = format!("mtllib old name.mtl\n{SQUARE}usemtl a\nf 1 2 3\nusemtl b\nf 1 3 4\n");
    let (scene, warnings) = read_files(&[("room.obj", &room)]).unwrap();
    assert!(scene.materials.iter().all(|m| m.reflectance == Rgb::splat(0.5)));
    assert!(matches!(&warnings[0], Warning::MaterialLibraryMissing { replaced_by: None, .. }), "{warnings:?}");
    assert_eq!(warnings.last(), Some(&Warning::MaterialsMissing { materials: 2, first: "a".into() }));
    let (_, warnings) =
        read_files(&[("room.obj", &room.replace("old name", "old")), ("room.mtl", "newmtl a\nnewmtl b")]).unwrap();
    assert!(warnings[0].to_string().contains("\"room.mtl\" was read instead"), "{warnings:?}");
    assert_eq!(warnings.len(), 1);
    for library in ["../secret.mtl", "/etc/passwd", "C:\\secret.mtl"] {
        let (_, warnings) =
            read_files(&[("in/room.obj", &format!("mtllib {library}\n{SQUARE}f 1 2 3")), ("secret.mtl", "newmtl a")])
                .unwrap();
        assert!(matches!(&warnings[1], Warning::MaterialLibraryMissing { .. }), "{warnings:?}");
    }
}

#[test]
fn what_is_not_taken_over_is_counted() {
    let text = format!("{SQUARE}v 1 2 3 0.5 0.5 0.5\np 1\nl 1 2\nf 1 2\nf\ncurv 0 1 1 2\ncurv 0 1 1 2\nfoo\ns off\n");
    let (_, warnings) = read(&text).unwrap();
    assert_eq!(
        warnings,
        [
            Warning::PointsAndLines { primitives: 2 },
            Warning::TooFewCorners { polygons: 2 },
            Warning::UnknownStatements { statements: 3, kinds: vec!["curv".into(), "foo".into()] },
        ]
    );
}

#[test]
fn bad_lines_are_named() {
    for (text, words) in [
        ("f 1 2 5", "line 5: refers to vertex 5, but there are only 4"),
        ("f 1 2 -5", "line 5: refers to vertex -5, and there are 4 before it"),
        ("f 1 2 0", "line 5: refers to vertex 0"),
        ("f 1 2 x/1", "line 5: \"x/1\" is not a corner"),
        ("f 1 2 99999999999999999999", "not a corner"),
        ("f 1 2 -9223372036854775808", "line 5"),
        ("v 1 2", "line 5: a vertex has 2 coordinates"),
        ("v 1,0 2 3", "line 5: \"1,0\" is not a number"),
        ("v nan 0 0\nf 1 2 5", "line 6, vertex 5: is [NaN, 0, 0], which is not finite"),
    ] {
        let message = read(&format!("{SQUARE}{text}\n")).unwrap_err().to_string();
        assert!(message.starts_with("test.obj: ") && message.contains(words), "no {words:?} in: {message}");
    }
    let bad = read_files(&[("r.obj", "mtllib r.mtl\n"), ("r.mtl", "newmtl a\nKd 1 x 1")]).unwrap_err().to_string();
    assert!(bad.contains("r.mtl: line 2: \"x\" is not a number"), "{bad}");
    // A vertex that nothing uses does no harm.
    assert!(read(&format!("{SQUARE}v nan 0 0\nf 1 2 3\n")).is_ok());
}

#[test]
fn units_and_axes_are_the_caller_s() {
    let options = ReadOptions { unit_m: 0.001, up: UpAxis::Z, ..ReadOptions::default() };
    let (scene, _) =
        read_scene_bytes("test.obj", b"v 0 0 0\nv 1000 0 0\nv 0 0 3000\nf 1 2 3\n".to_vec(), &options).unwrap();
    assert_eq!(polygons(&scene), [[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 3.0, 0.0]]]);
    let (scene, _) = read_scene_with(scene_path("cornell.obj"), &options).unwrap();
    assert_eq!(scene.polygon_count(), 20);
    assert!(scene.surfaces.iter().flat_map(|s| &s.positions_m).all(|p| p.abs().max_element() < 6e-4));
    let options = ReadOptions { unit_m: 1e300, ..ReadOptions::default() };
    let error = read_scene_bytes("test.obj", b"v 1e10 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3".to_vec(), &options);
    assert!(matches!(error, Err(FormatError::NotFinite { .. })));
}

#[test]
fn a_keyhole_polygon_is_prepared_with_its_area() {
    // A square with a square hole, joined by a seam that is passed both ways.
    let text = "v 0 0 0\nv 4 0 0\nv 4 0 -4\nv 0 0 -4\nv 1 0 -1\nv 1 0 -3\nv 3 0 -3\nv 3 0 -1\nf 1 2 3 4 1 5 6 7 8 5\n";
    let (scene, _) = read(text).unwrap();
    let prepared = prepare(&scene, Progress::silent()).unwrap();
    let area: f64 = prepared.faces.keys().map(|f| umbrage::geometry::polygon::area_m2(&prepared.polygon_m(f))).sum();
    assert!((area - 12.0).abs() < 1e-5, "{area}");
}

#[test]
fn textures_and_normals_belong_to_corners() {
    // Two squares side by side: the first shows the white half of the image, the second the black one upside down.
    let mut image = Vec::new();
    let mut encoder = png::Encoder::new(&mut image, 2, 1);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(&[255, 0]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("lib")).unwrap();
    std::fs::write(folder.path().join("lib/half image.png"), &image).unwrap();
    let paint = "newmtl image\nKd 0.8 0.4 0.2\nmap_Kd -s 0.5 1 half image.png\nnewmtl plain\nKd 1 1 1\n";
    std::fs::write(folder.path().join("lib/a.mtl"), paint).unwrap();
    let room = "mtllib lib/a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 2\n\
        usemtl image\nf 1/1/1 2/2/1 3/3/1 4/4/-1\nusemtl plain\nf 1/1/1 2/2 3//1 4/9/9\n";
    std::fs::write(folder.path().join("room.obj"), room).unwrap();
    let (scene, warnings) = read_scene(folder.path().join("room.obj")).unwrap();
    let [image_surface, plain] = scene.surfaces.raw.as_slice() else { panic!("{:?}", scene.surfaces) };
    // v grows upwards in an OBJ; -s halves u, so that only the white half is seen.
    assert_eq!(
        image_surface.uvs.iter().map(|uv| uv.to_array()).collect::<Vec<_>>(),
        [[0., 1.], [0.5, 1.], [0.5, 0.], [0., 0.]]
    );
    assert_eq!(image_surface.normals, [DVec3::Z; 4]);
    let material = &scene.materials[image_surface.material];
    assert!((material.reflectance - Rgb::new(0.8, 0.4, 0.2)).length() < 1e-9, "{material:?}");
    assert_eq!(&*scene.images[material.look.texture.unwrap().image].bytes, image.as_slice());
    // Without an image nothing is laid on; a corner may have no normal.
    let (up, none) = (DVec3::Z, DVec3::ZERO);
    assert!(plain.uvs.is_empty() && plain.normals == [up, none, up, none], "{:?}", plain.normals);
    assert!(matches!(warnings.as_slice(), [Warning::ReflectanceCapped { materials: 1, .. }]), "{warnings:?}");
}

#[test]
fn emission_and_opacity_have_images_too() {
    let image = |color: png::ColorType, texels: &[u8]| {
        let mut image = Vec::new();
        let mut encoder = png::Encoder::new(&mut image, 2, 1);
        encoder.set_color(color);
        encoder.write_header().unwrap().write_image_data(texels).unwrap();
        image
    };
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("half.png", &image(png::ColorType::Grayscale, &[255, 0]));
    // A TGA of two greys, the first row being the upper one.
    write("colour.tga", &[0, 0, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 8, 0x20, 255, 0]);
    let paint = "newmtl lamp\nKd 0.2\nKe 4 8 12\nmap_Ke -s 0.5 1 half.png\nmap_Kd colour.tga\n\
        newmtl leaf\nKd 0.5\nmap_Kd colour.tga\nmap_d half.png\nnewmtl net\nKd 0.3\nmap_d half.png\n\
        newmtl dark\nKe 0\nmap_Ke half.png\nnewmtl torn\nKd 0.3\nmap_d none.png\n";
    write("a.mtl", paint.as_bytes());
    let square = "f 1/1 2/2 3/3 4/4\n";
    let materials = ["lamp", "leaf", "net", "dark", "torn"].map(|name| format!("usemtl {name}\n{square}"));
    let room = format!(
        "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n{}",
        materials.concat()
    );
    write("room.obj", room.as_bytes());
    let (scene, warnings) = read_scene(folder.path().join("room.obj")).unwrap();
    let [lamp, leaf, net, dark, torn] = scene.materials.raw.as_slice() else { panic!("{:?}", scene.materials) };
    let near = |found: Rgb, expected: Rgb| assert!((found - expected).abs().max_element() < 1e-9, "{found} {expected}");
    // Halved by its scale, the image of the emission shows its white half alone; that of the colour shows both.
    near(lamp.radiance, Rgb::new(4.0, 8.0, 12.0));
    near(lamp.reflectance, Rgb::splat(0.1));
    let image_of = |material: &umbrage::scene::Material| &scene.images[material.look.texture.unwrap().image];
    assert_eq!(image_of(lamp).name.as_deref(), Some("half"));
    assert_eq!(lamp.look.texture.unwrap().factor, Rgb::new(4.0, 8.0, 12.0));
    assert_eq!(scene.surfaces.raw[0].uvs[1].to_array(), [0.5, 1.0]);
    assert_eq!(scene.surfaces.raw[1].uvs[1].to_array(), [1.0, 1.0]);
    // Of a leaf the white half alone is seen, which is what reflects; a net has no other colour than its own.
    near(leaf.reflectance, Rgb::splat(0.5));
    near(net.reflectance, Rgb::splat(0.3));
    let mask = |material: &umbrage::scene::Material| matches!(material.look.alpha, Alpha::Mask { .. });
    assert_eq!([lamp, leaf, net, dark, torn].map(mask), [false, true, true, false, false]);
    assert!(image_of(leaf).bytes.starts_with(b"\x89PNG"), "viewers take no TGA");
    assert!(dark.look.texture.is_none() && !dark.emits() && torn.look.texture.is_none());
    let [Warning::TexturesIgnored { uses: 1, first }, Warning::AlphaIgnored { materials: 2 }] = warnings.as_slice()
    else {
        panic!("{warnings:?}")
    };
    assert!(first.starts_with("none.png: cannot be read"), "{first}");
}

/// Files of bytes, the first of which is read.
fn read_bytes(files: &[(&str, &[u8])]) -> (Scene, Vec<Warning>) {
    let folder = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, bytes)| std::fs::write(folder.path().join(name), bytes).unwrap());
    read_scene(folder.path().join(files[0].0)).unwrap()
}

#[test]
fn names_in_other_encodings_stay_different() {
    // Latin-1: \u{fc} and \u{f6}. Shift-JIS: the second byte of the first is a backslash, at the end of a line.
    for [a, b] in [[&b"gr\xfcn"[..], b"gr\xf6n"], [b"\x83\x5c", b"\x83\x41"]] {
        let obj =
            [SQUARE.as_bytes(), b"mtllib room.mtl\nusemtl ", a, b"\nf 1 2 3\nusemtl ", b, b"\nf 1 3 4\n"].concat();
        let mtl = [b"newmtl ", a, b"\nKd 0.1 0.1 0.1\nnewmtl ", b, b"\nKd 0.2 0.2 0.2\nKe 5 5 5\n"].concat();
        let (scene, warnings) = read_bytes(&[("room.obj", &obj), ("room.mtl", &mtl)]);
        assert_eq!(warnings, []);
        let all: Vec<f64> = scene.surfaces.iter().map(|s| scene.materials[s.material].reflectance.x).collect();
        assert_eq!(all, [0.1, 0.2]);
    }
    let utf16: Vec<u8> = [0xff, 0xfe]
        .into_iter()
        .chain(format!("{SQUARE}f 1 2 3 4\n").encode_utf16().flat_map(u16::to_le_bytes))
        .collect();
    assert_eq!(read_bytes(&[("room.obj", &utf16)]).0.polygon_count(), 1);
}

#[test]
fn normals_that_are_none_are_ignored_and_counted() {
    let text = format!("{SQUARE}vn 0 0 1\nvn nan nan nan\nvn -nan(ind) 0 0\nvn 1 2\nf 1//1 2//2 3//3 4//4\n");
    let (scene, warnings) = read(&text).unwrap();
    assert!(warnings.contains(&Warning::BadNormals { normals: 3 }), "{warnings:?}");
    let normals = &scene.surfaces.raw[0].normals;
    assert_eq!((normals[0], normals[1], normals[3]), (DVec3::Z, DVec3::ZERO, DVec3::ZERO));
    assert_eq!(scene.validate().is_err(), !scene.materials.iter().any(|m| m.emits()), "nothing else is wrong with it");
}

#[test]
fn colours_of_vertices_multiply_the_reflectance() {
    let vertices = "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 1 1 0 1 0 0\nv 0 1 0 1 0 0\n";
    let library = "newmtl a\nKd 0.8 0.8 0.8\n";
    let text = format!("mtllib a.mtl\n{vertices}usemtl a\nf 1 2 3 4\n");
    let (scene, warnings) = read_files(&[("room.obj", &text), ("a.mtl", library)]).unwrap();
    assert_eq!(warnings, []);
    let material = &scene.materials[scene.surfaces.raw[0].material];
    assert_eq!((material.name.as_str(), material.reflectance), ("a", Rgb::new(0.8, 0.0, 0.0)));
    // Some programs write 0 to 255.
    let bytes = text.replace(" 1 0 0\nv", " 255 0 0\nv").replace("0 1 0 1 0 0\nusemtl", "0 1 0 255 0 0\nusemtl");
    let (scene, _) = read_files(&[("room.obj", &bytes), ("a.mtl", library)]).unwrap();
    assert_eq!(scene.materials[scene.surfaces.raw[0].material].reflectance, Rgb::new(0.8, 0.0, 0.0));
}

#[test]
fn what_lets_through_half_of_the_light_is_glass() {
    let read_with = |statement: &str| {
        let text = format!("mtllib a.mtl\n{SQUARE}usemtl a\nf 1 2 3 4\n");
        read_files(&[("room.obj", &text), ("a.mtl", &format!("newmtl a\n{statement}\n"))]).unwrap()
    };
    for statement in ["d 0.3", "Tr 0.7"] {
        let (scene, warnings) = read_with(statement);
        assert_eq!((scene.polygon_count(), scene.see_through.len()), (0, 1));
        let Alpha::Blend { alpha } = scene.materials[scene.see_through[0].material].look.alpha else { panic!() };
        assert!((alpha - 0.3).abs() < 1e-12 && warnings == [Warning::GlassPassedOn { polygons: 1 }], "{warnings:?}");
    }
    let (scene, warnings) = read_with("d 0.7");
    assert!(scene.polygon_count() == 1 && warnings == [Warning::AlphaIgnored { materials: 1 }], "{warnings:?}");
    // What emits gives its light, and blocks.
    let (scene, _) = read_with("d 0.25\nKe 8 8 8");
    assert_eq!(scene.materials[scene.surfaces.raw[0].material].radiance, Rgb::splat(8.0));
}

#[test]
fn capitals_of_libraries_and_textures_do_not_count() {
    let text = format!("mtllib Room.MTL\n{SQUARE}usemtl a\nf 1 2 3 4\n");
    let (scene, warnings) = read_files(&[("in.obj", &text), ("room.mtl", "newmtl a\nKd 0.3 0.3 0.3\n")]).unwrap();
    assert!(warnings.is_empty() && scene.materials.raw[0].reflectance.x == 0.3, "{warnings:?}");
}

#[test]
fn a_bow_tie_is_left_out_with_its_reason() {
    let text = "v 0 0 0\nv 0 0 4\nv 4 0 0\nv 4 0 4\nf 1 2 3 4\nf 1 2 4\n";
    let (scene, warnings) = read(text).unwrap();
    assert_eq!(scene.polygon_count(), 1);
    assert!(warnings.contains(&Warning::CrossedLeftOut { polygons: 1 }), "{warnings:?}");
}
