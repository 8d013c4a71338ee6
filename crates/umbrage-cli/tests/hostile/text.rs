//! Hostile OBJ, MGF, PLY, STL and TOML: floods, arrays, includes, lies about counts, numbers, encodings.

use fastrand::Rng;

use crate::{Hostile, Kind};

pub(crate) const KINDS: &[(&str, Kind)] = &[
    ("obj-numbers", obj_numbers),
    ("obj-usemtl", obj_usemtl),
    ("obj-garbage", obj_garbage),
    ("obj-libraries", obj_libraries),
    ("mgf-arrays", mgf_arrays),
    ("mgf-includes", mgf_includes),
    ("mgf-parts", mgf_parts),
    ("mgf-garbage", mgf_garbage),
    ("ply-counts", ply_counts),
    ("ply-garbage", ply_garbage),
    ("stl-counts", stl_counts),
    ("stl-garbage", stl_garbage),
    ("toml-values", toml_values),
    ("toml-depth", toml_depth),
];

const WILD: [&str; 14] = [
    "1e308",
    "-1e308",
    "1e100",
    "nan",
    "-nan(ind)",
    "inf",
    "1e-320",
    "0",
    "-0",
    "999999999999999999999",
    "x",
    "",
    "1,5",
    "0x1p4",
];

fn wild(rng: &mut Rng) -> &'static str {
    WILD[rng.usize(..WILD.len())]
}

/// A square in grey and one that gives light.
const SQUARES: &str = "mtllib a.mtl\nv 0 0 0\nv 2 0 0\nv 2 0 2\nv 0 0 2\nv 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1\nvt 0 0\nvn 0 1 0\n\
    usemtl w\nf 4/1/1 3/1/1 2/1/1 1/1/1\nusemtl l\nf 5 6 7 8\n";
const LIBRARY: &str = "newmtl w\nKd .5 .5 .5\nd 1\nnewmtl l\nKe 5 5 5\n";

/// A text with some of its words replaced.
fn replaced(text: &str, rng: &mut Rng) -> String {
    let words = text.split(' ').count();
    let chosen: Vec<usize> = (0..rng.usize(1..4)).map(|_| rng.usize(..words)).collect();
    let word =
        |(number, word): (usize, &str)| if chosen.contains(&number) { wild(rng).to_owned() } else { word.to_owned() };
    text.split(' ').enumerate().map(word).collect::<Vec<_>>().join(" ")
}

fn obj_numbers(rng: &mut Rng) -> Hostile {
    let (scene, library) = if rng.bool() {
        (replaced(SQUARES, rng), LIBRARY.to_owned())
    } else {
        (SQUARES.to_owned(), replaced(LIBRARY, rng))
    };
    let beside = vec![("a.mtl".to_owned(), library.into_bytes())];
    Hostile { beside, baked: true, ..Hostile::new("a.obj", scene) }
}

fn obj_usemtl(rng: &mut Rng) -> Hostile {
    let names = rng.usize(1..50_000);
    let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned();
    for i in 0..rng.usize(10_000..50_000) {
        text += &format!(
            "usemtl m{}\n{}f 1 2 3\n",
            i % names,
            if i % 2 == 0 { format!("o o{i}\ng g{i}\n") } else { String::new() }
        );
    }
    Hostile::new("a.obj", text)
}

fn garbage(rng: &mut Rng, seed: &str) -> Vec<u8> {
    let mut bytes = seed.as_bytes().to_vec();
    for _ in 0..rng.usize(1..20) {
        let place = rng.usize(..bytes.len());
        match rng.u8(..4) {
            0 => bytes[place] = rng.u8(..),
            1 => drop(bytes.drain(place..)),
            2 => drop(bytes.splice(place..place, (0..rng.usize(..2_000)).map(|_| b'\\'))),
            _ => drop(bytes.splice(
                place..place,
                (0..rng.usize(..200)).map(|_| [b' ', b'\n', b'#', 0x83, 0x5c, 0xff, b'-', b'9'][rng.usize(..8)]),
            )),
        }
        if bytes.is_empty() {
            bytes.push(b'#');
        }
    }
    bytes
}

fn obj_garbage(rng: &mut Rng) -> Hostile {
    Hostile { baked: true, ..Hostile::new("a.obj", garbage(rng, SQUARES)) }
}

fn obj_libraries(rng: &mut Rng) -> Hostile {
    let names = ["../a.mtl", "/etc/passwd", "a.obj", "C:\\x", "\u{1b}[2J", ".", "a.mtl", "/dev/zero", "a\0b"];
    let lines: String =
        (0..rng.usize(1..20_000)).map(|i| format!("mtllib {}{i}\n", names[rng.usize(..names.len())])).collect();
    let library = format!("{LIBRARY}newmtl t\nmap_Kd /dev/zero\nmap_d ../../x.png\nmap_Ke a.obj\nKe 1 1 1\n");
    let beside = vec![("a.mtl".to_owned(), library.into_bytes())];
    Hostile { beside, ..Hostile::new("a.obj", format!("{lines}{SQUARES}usemtl t\nf 1 2 3\n")) }
}

const MGF: &str =
    "v a =\np 0 0 0\nv b =\np 1 0 0\nv c =\np 1 1 0\nm l =\nc\ncxy .3 .3\nrd .5\ned 5\nsides 2\nf a b c\n";

fn mgf_arrays(rng: &mut Rng) -> Hostile {
    let fill = match rng.u8(..4) {
        0 => "\n".repeat(rng.usize(1..500_000)),
        1 => format!("# {}\n", "x ".repeat(rng.usize(1..250_000))),
        2 => format!("#{}\n", "\\\n".repeat(rng.usize(1..250_000))),
        _ => "f a b c\no x\no\n".to_owned(),
    };
    let times = [10, 1_000, 1_000_000][rng.usize(..3)];
    let depth = rng.usize(1..6);
    let text = format!("{MGF}{}{fill}{}", format!("xf -a {times} -t 0 0 1\n").repeat(depth), "xf\n".repeat(depth));
    Hostile::new("a.mgf", text)
}

fn mgf_includes(rng: &mut Rng) -> Hostile {
    let files = rng.usize(2..30);
    let body = |next: usize| format!("{MGF}{}", format!("i b{next}.mgf -a 10 -t 0 0 1\n").repeat(10)).into_bytes();
    let own = rng.usize(..files);
    let beside = (0..files)
        .map(|i| (format!("b{i}.mgf"), if i + 1 == files && rng.bool() { MGF.into() } else { body((i + 1) % files) }))
        .collect();
    Hostile { beside, ..Hostile::new("a.mgf", body(own)) }
}

fn mgf_parts(rng: &mut Rng) -> Hostile {
    let part = ["-t 0 0 .001 ", "-i 2 -t 0 0 .001 ", "-a 2 -rz 1 ", "-s 1.001 "][rng.usize(..4)];
    Hostile::new("a.mgf", format!("{MGF}xf {}-a 1000 -t 0 0 1\nf a b c\nxf\n", part.repeat(rng.usize(1_000..100_000))))
}

fn mgf_garbage(rng: &mut Rng) -> Hostile {
    let bytes = if rng.bool() { garbage(rng, MGF) } else { replaced(MGF, rng).into_bytes() };
    Hostile { baked: true, ..Hostile::new("a.mgf", bytes) }
}

fn ply(rng: &mut Rng, vertices: &str, faces: &str, list: &str) -> String {
    let format = ["ascii", "binary_little_endian", "binary_big_endian"][rng.usize(..3)];
    format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
         property uchar green\nproperty uchar blue\nelement {} {faces}\nproperty list {list} vertex_indices\nend_header\n\
         0 0 0 9 9 9\n1 0 0 9 9 9\n0 1 0 9 9 9\n3 0 1 2\n",
        ["face", "tristrips", "edge"][rng.usize(..3)]
    )
}

fn ply_counts(rng: &mut Rng) -> Hostile {
    let counts = ["3", "0", "18446744073709551615", "4294967296", "-1", "99999999", "1"];
    let lists = ["uchar int", "uint uint", "int float", "double double", "char short"];
    let mut count = || counts[rng.usize(..counts.len())];
    let (vertices, faces) = (count(), count());
    let list = lists[rng.usize(..lists.len())];
    Hostile::new("a.ply", ply(rng, vertices, faces, list))
}

fn ply_garbage(rng: &mut Rng) -> Hostile {
    let text = ply(rng, "3", "1", "uchar int");
    Hostile::new("a.ply", garbage(rng, &text))
}

fn stl_counts(rng: &mut Rng) -> Hostile {
    let mut bytes = vec![b' '; 80];
    let count = rng.u32(..6);
    let told = [count, 0, u32::MAX, count + 1][rng.usize(..4)];
    bytes.extend(told.to_le_bytes());
    bytes.extend((0..50 * count).map(|_| rng.u8(..)));
    Hostile::new("a.stl", bytes)
}

fn stl_garbage(rng: &mut Rng) -> Hostile {
    let text = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    Hostile::new("a.stl", if rng.bool() { garbage(rng, text) } else { replaced(text, rng).into_bytes() })
}

fn with_toml(toml: String) -> Hostile {
    let beside = vec![("a.mtl".to_owned(), LIBRARY.into()), ("a.umbrage.toml".to_owned(), toml.into_bytes())];
    Hostile { beside, baked: true, ..Hostile::new("a.obj", SQUARES) }
}

fn toml_values(rng: &mut Rng) -> Hostile {
    let keys =
        ["emission", "reflectance", "double_sided", "casts_shadow", "intensity", "position", "direction", "x\\u001b"];
    let values =
        ["1e308", "-1", "nan", "[1, 2]", "[1e100, 0, 0]", "true", "\"file\"", "{}", "[0, 1, 0]", "1979-05-27", "0.5"];
    let mut pick = |from: &[&'static str]| from[rng.usize(..from.len())];
    let tables = ["[materials.w]\n", "[nodes.a]\n", "[[lamps]]\n", "[materials.nowhere]\n", "[x]\n"];
    let table = |pick: &mut dyn FnMut(&[&'static str]) -> &'static str| {
        let (head, key, value, other) = (pick(&tables), pick(&keys), pick(&values), pick(&values));
        format!("{head}\"{key}\" = {value}\nirradiance = {other}\n")
    };
    let text: String = (0..3).map(|_| table(&mut pick)).collect();
    with_toml(text)
}

fn toml_depth(rng: &mut Rng) -> Hostile {
    let depth = rng.usize(1_000..200_000);
    with_toml(match rng.u8(..4) {
        0 => "[".repeat(depth),
        1 => format!("a = {}", "[".repeat(depth)),
        2 => format!("a = {}1{}", "{ a = ".repeat(depth), " }".repeat(depth)),
        _ => format!("[[lamps]]\nposition = [0, 3, 0]\nintensity = 1\nname = \"{}\"\n", "y".repeat(depth)).repeat(3),
    })
}
