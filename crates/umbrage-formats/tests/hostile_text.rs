//! Bad OBJ, MGF, PLY and STL files: bytes flipped, cut, put in and mixed never make a reader panic, and whatever it
//! accepts holds together.
#![allow(clippy::expect_used, reason = "a test fails by panicking")]

mod common;

use proptest::prelude::*;
use umbrage_formats::{ReadOptions, read_scene_bytes};

const OBJ: &str =
    "mtllib none.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no a\ng b\nusemtl red\nf 1 2 3 4\nf -1/1 -2//2 -3\nl 1 2\n";

const MGF: &str = "m w =\nsides 1\nc x =\ncxy .3 .4\ncspec 400 700 1 2 3\ncct 3000\ncmix 1 x 2 x\nrd .5\ned 3\nv a =\np 0 0 0\nn 0 0 1\n\
    v b =\np 1 0 0\nv c = a\np 0 1 0\nv d =\np .1 .1 0\nv e =\np .2 .1 0\nv f =\np .1 .2 0\no box\nxf -t 1 2 3 -a 3 -rx 30\nf a b c\n\
    fh a b c - d e f\nxf\nsph a 1\ncyl a 1 b\ncone a 1 b 0\nring a 1 2\ntorus a 1 2\nprism a b c 1\no\ni none.mgf\n";

const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty double y\nproperty int z\nelement face 1\n\
    property list uchar uint vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";

const STL: &str =
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";

fn sound(name: &str, bytes: &[u8]) {
    match read_scene_bytes(name, bytes.to_vec(), &ReadOptions::default()) {
        Err(error) => assert!(error.to_string().starts_with(name), "{error}"),
        Ok((scene, _)) => {
            for surface in &scene.surfaces {
                assert!(surface.polygons.iter().all(|p| p.len() >= 3));
                assert!(surface.polygons.iter().flatten().all(|&i| (i as usize) < surface.positions_m.len()));
                assert!(surface.positions_m.iter().all(|p| p.is_finite()));
            }
            for material in &scene.materials {
                assert!(material.reflectance.is_finite() && material.reflectance.min_element() >= 0.0);
                assert!(material.reflectance.max_element() <= 0.9 && material.radiance.is_finite());
            }
        }
    }
}

fn samples() -> [(&'static str, Vec<u8>); 6] {
    let ply_header = |name: &str| PLY.split("0 0 0").next().unwrap_or_default().replace("ascii", name).into_bytes();
    let mut ply_binary = ply_header("binary_little_endian");
    for corner in 0..4_u8 {
        ply_binary.extend(f32::from(corner).to_le_bytes());
        ply_binary.extend(f64::from(corner * corner).to_le_bytes());
        ply_binary.extend(0_i32.to_le_bytes());
    }
    ply_binary.push(3);
    ply_binary.extend([0_u32, 1, 2].into_iter().flat_map(u32::to_le_bytes));
    let mut stl_binary = vec![b' '; 80];
    stl_binary.extend(2_u32.to_le_bytes());
    stl_binary.extend([0; 100]);
    [
        ("a.obj", OBJ.into()),
        ("a.mgf", MGF.replace("i none.mgf\n", "").into()),
        ("a.ply", PLY.into()),
        ("a.ply", ply_binary),
        ("a.stl", STL.into()),
        ("a.stl", stl_binary),
    ]
}

#[test]
fn the_samples_are_sound_and_so_is_every_beginning_of_them() {
    for (name, bytes) in samples() {
        let read = read_scene_bytes(name, bytes.clone(), &ReadOptions::default());
        assert!(read.is_ok_and(|(scene, _)| scene.polygon_count() > 0), "{name}");
        for end in 0..bytes.len() {
            sound(name, &bytes[..end]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn flipped_bytes_never_panic(
        sample in 0..6_usize,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let (name, mut bytes) = samples()[sample].clone();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        sound(name, &bytes);
    }

    #[test]
    fn odd_words_never_panic(
        sample in prop::sample::select(vec![0, 1, 2, 4]),
        at in any::<prop::sample::Index>(),
        word in prop::sample::select(vec![
            "", "0", "-1", "1e308", "-1e308", "1e-308", "nan", "inf", "18446744073709551615", "-9223372036854775808", "f", "v",
            "xf", "o", "-", "=", "#", "\\", "é", "/", "//", "\r", "-a 1000 -t 0 0 1", "1000000",
        ]),
    ) {
        let (name, bytes) = samples()[sample].clone();
        let text = String::from_utf8(bytes).expect("these samples are texts");
        let words: Vec<(usize, &str)> = text.match_indices(|c: char| c.is_ascii_whitespace()).collect();
        let start = words[at.index(words.len() - 1)].0 + 1;
        let length = text[start..].find(|c: char| c.is_ascii_whitespace()).unwrap_or(0);
        sound(name, format!("{}{word}{}", &text[..start], &text[start + length..]).as_bytes());
    }

    #[test]
    fn any_bytes_never_panic(name in prop::sample::select(vec!["a.obj", "a.mgf", "a.stl"]), bytes in prop::collection::vec(any::<u8>(), 1..400)) {
        sound(name, &bytes);
    }
}
