//! Writes the furnished room of `testdata/scenes`: `room.obj` and `room.mtl`.
//!
//! ```sh
//! cargo run -p umbrage-formats --example room -- testdata/scenes
//! ```
//!
//! Idea: everything is a closed box, and a box stands on the floor, on another box or against one, face on face, as in a
//! carefully made model: no gaps, no overlaps, no loose edges. One chair is turned, so that not all edges are parallel.
//! Metres, +Y up, fronts counter-clockwise; light in W/(m2 sr). Made for this project, licence MIT OR Apache-2.0.
#![allow(dead_code, reason = "the test that compares the files with this text includes it without its `main`")]

use std::fmt::Write;
use std::path::PathBuf;

/// A point, in metres.
type Point = [f64; 3];

/// Reflectance and radiance of the materials.
const MATERIALS: [(&str, Point, Point); 14] = [
    ("wall", [0.75, 0.73, 0.68], [0.0; 3]),
    ("ceiling", [0.8, 0.8, 0.8], [0.0; 3]),
    ("floor", [0.45, 0.3, 0.18], [0.0; 3]),
    ("wood", [0.5, 0.32, 0.17], [0.0; 3]),
    ("board", [0.65, 0.62, 0.57], [0.0; 3]),
    ("fabric", [0.14, 0.24, 0.42], [0.0; 3]),
    ("rug", [0.5, 0.14, 0.11], [0.0; 3]),
    ("metal", [0.3, 0.3, 0.31], [0.0; 3]),
    ("red", [0.6, 0.09, 0.07], [0.0; 3]),
    ("green", [0.1, 0.34, 0.14], [0.0; 3]),
    ("yellow", [0.7, 0.58, 0.18], [0.0; 3]),
    ("daylight", [0.0; 3], [7.0, 8.5, 10.0]),
    ("ceiling lamp", [0.0; 3], [22.0, 18.0, 13.0]),
    ("reading lamp", [0.0; 3], [60.0, 45.0, 28.0]),
];

/// Size of the room: width, height, depth.
const ROOM_M: Point = [5.0, 2.7, 4.0];

/// The text of the scene, grown piece by piece.
#[derive(Default)]
struct Obj {
    text: String,
    vertices: usize,
}

impl Obj {
    fn object(&mut self, name: &str) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.text, "o {name}");
    }

    fn polygon(&mut self, material: &str, corners: &[Point]) {
        let _ = writeln!(self.text, "usemtl {material}");
        for [x, y, z] in corners {
            let [x, y, z] = [x, y, z].map(|v| (v * 1e4).round() / 1e4 + 0.0);
            let _ = writeln!(self.text, "v {x} {y} {z}");
        }
        let numbers: Vec<_> = (1..=corners.len()).map(|i| (self.vertices + i).to_string()).collect();
        let _ = writeln!(self.text, "f {}", numbers.join(" "));
        self.vertices += corners.len();
    }

    /// A closed box between two corners, whose bottom has a material of its own; `place` moves its corners.
    fn block(&mut self, [material, bottom]: [&str; 2], low: Point, high: Point, place: &dyn Fn(Point) -> Point) {
        let at = |x: usize, y: usize, z: usize| place([[low, high][x][0], [low, high][y][1], [low, high][z][2]]);
        self.polygon(bottom, &[at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)]);
        self.polygon(material, &[at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0)]);
        self.polygon(material, &[at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)]);
        self.polygon(material, &[at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)]);
        self.polygon(material, &[at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)]);
        self.polygon(material, &[at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)]);
    }

    fn plain(&mut self, material: &str, low: Point, high: Point) {
        self.block([material, material], low, high, &|p| p);
    }

    /// Floor, ceiling and walls; in the wall z = 0 a window: a pane that gives light behind a reveal.
    fn shell(&mut self) {
        let [w, h, d] = ROOM_M;
        self.object("room");
        self.polygon("floor", &[[0.0, 0.0, 0.0], [0.0, 0.0, d], [w, 0.0, d], [w, 0.0, 0.0]]);
        self.polygon("ceiling", &[[0.0, h, 0.0], [w, h, 0.0], [w, h, d], [0.0, h, d]]);
        self.polygon("wall", &[[0.0, 0.0, 0.0], [0.0, h, 0.0], [0.0, h, d], [0.0, 0.0, d]]);
        self.polygon("wall", &[[w, 0.0, 0.0], [w, 0.0, d], [w, h, d], [w, h, 0.0]]);
        self.polygon("wall", &[[0.0, 0.0, d], [0.0, h, d], [w, h, d], [w, 0.0, d]]);
        // Counter-clockwise, as one looks at the wall from inside.
        let outer = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]];
        let inner = [[1.2, 0.9], [2.8, 0.9], [2.8, 2.1], [1.2, 2.1]];
        let on = |[x, y]: [f64; 2], z: f64| [x, y, z];
        for i in 0..4 {
            let j = (i + 1) % 4;
            let ring = [on(outer[i], 0.0), on(outer[j], 0.0), on(inner[j], 0.0), on(inner[i], 0.0)];
            let reveal = [on(inner[i], 0.0), on(inner[j], 0.0), on(inner[j], -0.15), on(inner[i], -0.15)];
            self.polygon("wall", &ring);
            self.polygon("wall", &reveal);
        }
        self.polygon("daylight", &inner.map(|corner| on(corner, -0.15)));
    }

    fn table(&mut self) {
        self.object("table");
        self.plain("wood", [1.3, 0.71, 1.2], [2.7, 0.75, 2.0]);
        for (x, z) in [(1.35, 1.25), (2.59, 1.25), (1.35, 1.89), (2.59, 1.89)] {
            self.plain("wood", [x, 0.0, z], [x + 0.06, 0.71, z + 0.06]);
        }
        self.plain("yellow", [1.85, 0.75, 1.5], [2.1, 0.83, 1.75]);
    }

    /// A chair around its own middle, its back towards +z, turned and moved to its place.
    fn chair(&mut self, [x, z]: [f64; 2], turn_deg: f64) {
        let (sin, cos) = turn_deg.to_radians().sin_cos();
        let place = move |[px, py, pz]: Point| [x + cos * px + sin * pz, py, z + cos * pz - sin * px];
        self.object("chair");
        self.block(["wood"; 2], [-0.22, 0.43, -0.22], [0.22, 0.47, 0.22], &place);
        self.block(["wood"; 2], [-0.22, 0.47, 0.19], [0.22, 0.92, 0.22], &place);
        for (px, pz) in [(-0.2, -0.2), (0.16, -0.2), (-0.2, 0.16), (0.16, 0.16)] {
            self.block(["wood"; 2], [px, 0.0, pz], [px + 0.04, 0.43, pz + 0.04], &place);
        }
    }

    fn shelf(&mut self) {
        self.object("shelf");
        self.plain("board", [0.03, 0.0, 0.6], [0.33, 1.8, 0.63]);
        self.plain("board", [0.03, 0.0, 1.77], [0.33, 1.8, 1.8]);
        self.plain("board", [0.03, 0.0, 0.63], [0.05, 1.8, 1.77]);
        for y in [0.1, 0.65, 1.2, 1.77] {
            self.plain("board", [0.05, y, 0.63], [0.33, y + 0.03, 1.77]);
        }
        let books: [(&str, Point, Point); 5] = [
            ("red", [0.08, 0.68, 0.7], [0.28, 0.95, 0.76]),
            ("green", [0.08, 0.68, 0.78], [0.26, 0.92, 0.86]),
            ("yellow", [0.08, 0.68, 1.2], [0.28, 0.76, 1.5]),
            ("green", [0.08, 1.23, 1.4], [0.27, 1.5, 1.48]),
            ("red", [0.08, 1.23, 1.55], [0.28, 1.53, 1.66]),
        ];
        for (material, low, high) in books {
            self.plain(material, low, high);
        }
    }

    fn sofa(&mut self) {
        self.object("sofa");
        self.plain("fabric", [4.0, 0.0, 1.0], [4.9, 0.4, 2.8]);
        self.plain("fabric", [4.68, 0.4, 1.0], [4.9, 0.85, 2.8]);
        self.plain("fabric", [4.0, 0.4, 1.0], [4.68, 0.6, 1.18]);
        self.plain("fabric", [4.0, 0.4, 2.62], [4.68, 0.6, 2.8]);
        self.object("rug");
        self.plain("rug", [2.95, 0.0, 1.1], [3.85, 0.01, 2.7]);
    }

    fn sideboard(&mut self) {
        self.object("sideboard");
        self.plain("board", [0.6, 0.0, 3.5], [2.2, 0.8, 3.95]);
        self.plain("red", [0.8, 0.8, 3.65], [0.95, 1.1, 3.8]);
    }

    fn lamps(&mut self) {
        self.object("ceiling lamp");
        self.block(["metal", "ceiling lamp"], [1.4, 2.64, 1.48], [2.6, 2.7, 1.73], &|p| p);
        self.object("reading lamp");
        self.plain("metal", [4.2, 0.0, 0.4], [4.5, 0.03, 0.7]);
        self.plain("metal", [4.33, 0.03, 0.53], [4.36, 1.7, 0.56]);
        self.block(["board", "reading lamp"], [4.36, 1.45, 0.38], [4.7, 1.7, 0.72], &|p| p);
    }
}

/// The scene and its materials, as text.
pub(crate) fn room() -> (String, String) {
    let mut obj = Obj::default();
    obj.text += "# A furnished room for tests, pictures and measurements. Made for this project; licence MIT OR Apache-2.0.\n\
                 # Generated by crates/umbrage-formats/examples/room.rs. Metres, +Y up.\n\
                 mtllib room.mtl\n";
    obj.shell();
    obj.table();
    obj.chair([1.7, 2.25], 0.0);
    obj.chair([2.45, 2.4], 25.0);
    obj.shelf();
    obj.sofa();
    obj.sideboard();
    obj.lamps();
    let mut mtl = String::from("# Kd is reflectance, Ke is radiance in W/(m2 sr).\n");
    for (name, [r, g, b], [er, eg, eb]) in MATERIALS {
        let _ = write!(mtl, "newmtl {name}\nKd {r} {g} {b}\n");
        if er + eg + eb > 0.0 {
            let _ = writeln!(mtl, "Ke {er} {eg} {eb}");
        }
    }
    (obj.text, mtl)
}

fn main() -> std::io::Result<()> {
    let folder = PathBuf::from(std::env::args_os().nth(1).unwrap_or_else(|| ".".into()));
    let (obj, mtl) = room();
    std::fs::write(folder.join("room.obj"), obj)?;
    std::fs::write(folder.join("room.mtl"), mtl)
}
