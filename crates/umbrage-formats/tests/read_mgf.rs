//! What is read from an MGF: contexts, colours, shapes, transforms, objects, includes.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

mod common;

use std::f64::consts::PI;

use common::{material_polygons, polygons, read_files, scene_path};
use umbrage::geometry::polygon;
use umbrage::prepare::prepare;
use umbrage::progress::Progress;
use umbrage::scene::cornell::cornell_box;
use umbrage::scene::{Rgb, Scene};
use umbrage_formats::{FormatError, ReadOptions, Warning, read_scene, read_scene_bytes};

/// Four corners, and a lamp.
const SQUARE: &str = "v a =\np 0 0 0\nv b =\np 1 0 0\nv c =\np 1 1 0\nv d =\np 0 1 0\nn 0 0 2\n";

fn read(text: &str) -> Result<(Scene, Vec<Warning>), FormatError> {
    read_scene_bytes("test.mgf", format!("{SQUARE}{text}").into_bytes(), &ReadOptions::default())
}

fn scene(text: &str) -> Scene {
    read(text).unwrap().0
}

/// The least corner of each polygon, in millimetres.
fn corners_mm(scene: &Scene) -> Vec<[i64; 3]> {
    let least = |p: &Vec<[f64; 3]>| {
        let fold = |low: [f64; 3], c: &[f64; 3]| std::array::from_fn(|i| low[i].min(c[i]));
        p.iter().fold([f64::MAX; 3], fold).map(|x| (1000.0 * x).round() as i64)
    };
    polygons(scene).iter().map(least).collect()
}

fn area_m2(scene: &Scene) -> f64 {
    let ids = (0..scene.surfaces.len()).map(umbrage::id::SurfaceId::from);
    let one = |id, n| polygon::area_m2(&scene.corners_m(id, n).collect::<Vec<_>>());
    ids.map(|id| (0..scene.surfaces[id].polygons.len()).map(|n| one(id, n)).sum::<f64>()).sum()
}

#[test]
fn the_cornell_file_is_the_built_in_cornell_box() {
    let (scene, warnings) = read_scene(scene_path("cornell.mgf")).unwrap();
    assert_eq!(warnings, []);
    assert_eq!(scene.validate(), Ok(()));
    let built = cornell_box();
    assert_eq!(material_polygons(&scene), material_polygons(&built));
    assert_eq!(scene.nodes, built.nodes);
    for (read, built) in scene.materials.iter().zip(&built.materials) {
        assert_eq!((&read.name, read.double_sided), (&built.name, false));
        assert!((read.reflectance - built.reflectance).length() < 1e-9, "{read:?}");
        assert!((read.radiance - built.radiance).length() < 1e-8, "{read:?}");
    }
}

#[test]
fn materials_are_taken_as_they_stand() {
    let text = "f a b c d\nm wall =\nsides 1\nc\nrd .4\nf a b c d\nm lamp = wall\ned 31.41592653589793\nf a b c d\n\
        m wall\nrd .3\nf a b c d\nrd .4\nf a b c d\n";
    let (scene, warnings) = read(text).unwrap();
    assert_eq!(warnings, []);
    let names: Vec<_> = scene.materials.iter().map(|m| (m.name.as_str(), m.double_sided)).collect();
    assert_eq!(names, [("unnamed", true), ("wall", false), ("lamp", false), ("wall (2)", false)]);
    let [black, wall, lamp, _] = scene.materials.raw.as_slice() else { panic!() };
    assert_eq!(black.reflectance, Rgb::ZERO);
    assert!((wall.reflectance - Rgb::splat(0.4)).length() < 1e-12);
    assert!((lamp.radiance - Rgb::splat(10.0)).length() < 1e-12 && lamp.reflectance == wall.reflectance);
    assert_eq!(scene.surfaces.raw[1].polygons.len(), 2);
}

#[test]
fn every_kind_of_colour() {
    let text = "m m =\nc r =\ncxy .64 .33\nc s =\ncspec 400 700 1 1 1 1\nc t =\ncct 2500\nc\ncmix 1 r 1 s 1 t\nrd .2\n\
        c r\ned 1\nf a b c d\n";
    let scene = scene(text);
    let m = &scene.materials.raw[0];
    assert!(m.reflectance.x > m.reflectance.y && m.reflectance.y > m.reflectance.z, "{m:?}");
    assert!(m.radiance.y < 1e-3 * m.radiance.x && m.radiance.z < 1e-3 * m.radiance.x, "{m:?}");
    let (_, warnings) =
        read("m m =\nc\ncxy .1 .8\nrd .3\nrs .1 .2\nts .1 0\nir 1.5 0\nf a b c d\nies x.ies\nfoo 1\n").unwrap();
    assert_eq!(
        warnings[..4],
        [
            Warning::LuminairesIgnored { luminaires: 1 },
            Warning::GlossIgnored { materials: 1 },
            Warning::TransmissionIgnored { materials: 1 },
            Warning::ColoursOutOfGamut { materials: 1 },
        ]
    );
    assert!(matches!(warnings.last(), Some(Warning::UnknownStatements { statements: 1, .. })));
}

#[test]
fn shapes_have_their_measures() {
    let curved = |text: &str| {
        let (scene, warnings) = read(text).unwrap();
        assert!(matches!(warnings[..], [Warning::CurvesTessellated { shapes: 1, .. }]), "{warnings:?}");
        area_m2(&scene)
    };
    // 24 chords take 1 to 3 % off.
    for (text, exact) in [
        ("sph a .5", PI),
        ("sph a -.5", PI),
        ("cyl a 1 b", 2.0 * PI),
        ("cone a 1 b 0", PI * 2_f64.sqrt()),
        ("ring d 0 1", PI),
        ("ring d 1 2", 3.0 * PI),
        ("torus d 1 2", 2.0 * PI * PI * 0.5 * 3.0 / 1.0),
    ] {
        let area = curved(text);
        assert!(area < exact && area > 0.95 * exact, "{text}: {area} {exact}");
    }
    let (prism, warnings) = read("prism a b c d 2").unwrap();
    assert_eq!(warnings, []);
    assert!((area_m2(&prism) - 10.0).abs() < 1e-12);
    assert!(corners_mm(&prism).iter().any(|c| c[2] == -2000));
}

#[test]
fn a_face_with_holes_is_prepared_with_its_area() {
    let text = "v e =\np .2 .2 0\nv f =\np .4 .2 0\nv g =\np .4 .4 0\nv h =\np .6 .6 0\nv i =\np .9 .6 0\nv j =\np .6 .9 0\n\
        fh a b c d - e f g - h j i\n";
    let (scene, warnings) = read(text).unwrap();
    assert_eq!((warnings, scene.polygon_count()), (vec![], 1));
    let exact = 1.0 - 0.02 - 0.045;
    assert!((area_m2(&scene) - exact).abs() < 1e-12);
    let prepared = prepare(&scene, Progress::silent()).unwrap();
    let area: f64 = prepared.faces.keys().map(|f| polygon::area_m2(&prepared.polygon_m(f))).sum();
    // Two-sided, as an unnamed material is.
    assert!((area - 2.0 * exact).abs() < 1e-5, "{area}");
}

#[test]
fn a_face_whose_vertices_have_normals_is_smooth() {
    let text =
        "v e =\np 2 0 0\nn 1 0 0\nv f =\np 3 0 0\nn 0 1 0\nv g =\np 3 1 0\nn 0 0 -5\nxf -rx 90\nf e f g\nf a b d\nxf\n";
    let normals: Vec<glam::DVec3> = scene(text).surfaces.raw[0].normals.clone();
    // Turned with what they belong to; where one vertex has none, the face has none.
    let expected = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0; 3], [0.0; 3], [0.0; 3]];
    assert_eq!(normals.len(), 6);
    assert!(normals.iter().zip(expected).all(|(n, e)| n.distance(e.into()) < 1e-12), "{normals:?}");
}

#[test]
fn transforms_nest_and_act_on_what_they_enclose() {
    let scene = scene("xf -t 10 0 0\nxf -s 2 -t 0 0 1\nf a b c d\nxf\nf a b c d\nxf\nf a b c d\n");
    assert_eq!(corners_mm(&scene), [[10_000, 0, 1000], [10_000, 0, 0], [0, 0, 0]]);
    assert!((area_m2(&scene) - 6.0).abs() < 1e-12);
}

#[test]
fn a_mirror_keeps_the_front() {
    let scene = scene("m w =\nsides 1\nprism d c b a 1\nxf -mx\nprism d c b a 1\nxf\n");
    let volume = |polygons: &[Vec<[f64; 3]>]| -> f64 {
        let fan = |p: &Vec<[f64; 3]>| {
            let v: Vec<glam::DVec3> = p.iter().map(|&c| c.into()).collect();
            (1..v.len() - 1).map(|i| v[0].dot(v[i].cross(v[i + 1])) / 6.0).sum::<f64>()
        };
        polygons.iter().map(fan).sum()
    };
    let all = polygons(&scene);
    assert!((volume(&all[..6]) - 1.0).abs() < 1e-12 && (volume(&all[6..]) - 1.0).abs() < 1e-12);
}

#[test]
fn arrays_repeat_statements_and_objects() {
    let text = "o shelf\nxf -t 0 0 1 -a 2 -t 0 0 10 -a 2 -t 5 0 0\no box\nf a b c d\no\nxf -a 2 -t 0 1 0\nf a b c d\nxf\nxf\no\n";
    let scene = scene(text);
    assert_eq!(
        corners_mm(&scene)
            .chunks(1)
            .map(|c| c[0])
            .collect::<std::collections::BTreeSet<_>>()
            .into_iter()
            .collect::<Vec<_>>(),
        [
            [0, 0, 1000],
            [0, 0, 11000],
            [0, 1000, 1000],
            [0, 1000, 11000],
            [5000, 0, 1000],
            [5000, 0, 11000],
            [5000, 1000, 1000],
            [5000, 1000, 11000]
        ]
    );
    assert_eq!(scene.polygon_count(), 12);
    let names: Vec<_> = scene.nodes.iter().map(|n| (n.name.as_deref().unwrap(), n.parent.is_some())).collect();
    assert_eq!(names, [("shelf", false), ("box", true), ("box", true), ("box", true), ("box", true)]);
}

#[test]
fn files_include_each_other_with_transforms_and_arrays() {
    let files = [
        ("main.mgf", "i lib/square.mgf\ni lib/square.mgf -t 1 0 0 -a 3 -t 0 2 0\nf a a2 a3\n"),
        ("lib/square.mgf", "v a =\np 0 0 0\nxf -s .5\ni corners.mgf\no square\nf a a2 a3\n"),
        ("lib/corners.mgf", "v a2 =\np 1 0 0\nv a3 =\np 1 1 0\n"),
    ];
    let (scene, warnings) = read_files(&files).unwrap();
    // `xf` and `o` of square.mgf are open at its end, four times each.
    assert_eq!(warnings, [Warning::UnclosedContexts { contexts: 8 }]);
    assert_eq!(corners_mm(&scene), [[0, 0, 0], [1000, 0, 0], [1000, 2000, 0], [1000, 4000, 0], [0, 0, 0]]);
    assert_eq!(scene.nodes.len(), 5);
    let include = |text: &str, other: &str| {
        let error = read_files(&[("in/main.mgf", text), ("in/o.mgf", other), ("up.mgf", "")]).unwrap_err().to_string();
        assert!(error.contains(".mgf: line "), "{error}");
        error
    };
    assert!(include("i o.mgf\n", "\ni main.mgf\n").contains("includes itself"));
    assert!(include("i o.mgf\n", "i o.mgf\n").contains("includes itself"));
    assert!(include("i ../../up.mgf\n", "").contains("leaves the root"));
    assert!(include("i none.mgf\n", "").contains("cannot be read"));
    assert!(include("i .\n", "").contains("is not a file"));
    assert!(include("i o.mgf\n", "f x y z\n").contains("o.mgf: line 1: there is no vertex \"x\""));
    assert!(include("i o.mgf\n", "xf\n").contains("closes what was not opened"));
}

#[test]
fn comments_and_lines_can_be_continued() {
    let scene = scene("# a comment \\\nthat f a b goes on\nf a \\\r\n b \\\n c\n\n");
    assert_eq!(scene.polygon_count(), 1);
    let (_, warnings) = read("f a b\nfh - a b c\nfh a b c - d\n").unwrap();
    assert_eq!(warnings, [Warning::TooFewCorners { polygons: 2 }]);
}

#[test]
fn bad_statements_are_named() {
    for (text, words) in [
        ("f a b x", "line 10: there is no vertex \"x\" yet"),
        ("v y", "there is no vertex \"y\" yet"),
        ("m y = z", "there is no material \"z\""),
        ("p 1 2", "p has 2 numbers, and needs 3"),
        ("p 1 2 nan", "not finite"),
        ("cxy .3", "cxy does not describe a colour"),
        ("cxy .3 nan", "not finite"),
        ("cspec 400 700 0", "cspec does not"),
        ("cmix 1", "cmix does not"),
        ("sides 3", "sides is 3"),
        ("rd 1.5", "rd is 1.5"),
        ("ed -1", "ed is -1"),
        ("sph a", "sph cannot have 1 arguments"),
        ("sph a 0", "has a size of 0"),
        ("cyl a 1 a", "both ends at one point"),
        ("cone a 1 b -1", "of two signs"),
        ("ring a 0 1", "needs a vertex with a normal"),
        ("ring d 2 1", "larger outer one"),
        ("torus d -1 2", "of one sign"),
        ("prism a b 1", "prism cannot have 3 arguments"),
        ("prism a b a 1", "without area"),
        ("o", "closes what was not opened"),
        ("xf", "closes what was not opened"),
        ("xf -q", "not an argument of a transform"),
        ("i", "names no file"),
        ("xf -s 1e300\nxf -s 1e300\nf a b c", "not finite"),
    ] {
        let message = read(&format!("{text}\n")).unwrap_err().to_string();
        assert!(message.starts_with("test.mgf: line ") && message.contains(words), "no {words:?} in: {message}");
    }
}

#[test]
fn nested_arrays_end() {
    let deep = "xf -a 1000 -t 1 0 0\n".repeat(6);
    let start = std::time::Instant::now();
    assert!(matches!(read(&format!("{deep}f a b c d\n")), Err(FormatError::TooLarge { .. })));
    assert!(matches!(read(&deep), Err(FormatError::TooLarge { .. })));
    assert!(matches!(read(&"xf -i 1000000\n".repeat(1000)), Err(FormatError::BadStatement { .. })));
    assert!(start.elapsed().as_secs() < 20);
}

#[test]
fn includes_may_come_from_beside_the_folder_and_no_farther() {
    let files = [
        ("rooms/a/main.mgf", "i ../lib/v.mgf\nf a b c\n"),
        ("rooms/lib/v.mgf", "v a =\np 0 0 0\nv b =\np 1 0 0\nv c =\np 1 1 0\n"),
    ];
    assert_eq!(read_files(&files).unwrap().0.polygon_count(), 1);
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [("x/rooms/a/main.mgf", "i ../../../v.mgf\nf a b c\n"), ("v.mgf", files[1].1)] {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    let path = folder.path().join("x/rooms/a/main.mgf");
    let message = read_scene(&path).unwrap_err().to_string();
    assert!(
        message.contains("line 1") && message.contains("leaves the root") && message.contains("--root"),
        "{message}"
    );
    let options = ReadOptions { root: Some(folder.path().to_path_buf()), ..ReadOptions::default() };
    assert_eq!(umbrage_formats::read_scene_with(&path, &options).unwrap().0.polygon_count(), 1);
}

#[test]
fn colours_that_are_none_are_counted_and_the_nearest_taken() {
    let shape = "v a =\np 0 0 0\nv b =\np 1 0 0\nv c =\np 1 1 0\n";
    let text = format!(
        "{shape}c x =\ncxy 0.7 0.6\nc y =\ncspec 400 700 0 0 0\nc z =\ncspec 400 700 -0.02 0.1 0.9\nm w =\nc x\nrd 0.5\nf a b c\n"
    );
    let (scene, warnings) = read_files(&[("a.mgf", &text)]).unwrap();
    assert!(warnings.contains(&Warning::OddColours { colours: 2 }), "{warnings:?}");
    assert!(scene.materials.iter().all(|m| m.reflectance.is_finite() && m.reflectance.min_element() >= 0.0));
}

#[test]
fn a_statement_that_is_not_known_is_named() {
    let (_, warnings) = read_files(&[("a.mgf", "v a =\nfoo 1 2\nbar\nfoo\n")]).unwrap();
    assert!(warnings.iter().any(|w| w.to_string().contains("3 unknown statements ignored: foo, bar")), "{warnings:?}");
}
