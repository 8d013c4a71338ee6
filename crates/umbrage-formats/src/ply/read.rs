//! A PLY as a [`Scene`]: one node, one surface, the grey material `default`.
//!
//! Of vertices the properties `x`, `y` and `z` are taken, and `nx`, `ny` and `nz`, the normal of a smooth surface; of faces
//! the list `vertex_indices` (or `vertex_index`); polygons stay what they are. Colours of vertices (`red`, `green`, `blue`) are what polygons
//! reflect. Strips of triangles (`tristrips`) are read, with -1 between them. Other properties and elements are passed over with a warning.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;
use umbrage::id::{MaterialId, NodeId, SurfaceId};
use umbrage::scene::{Material, Rgb, Scene};

use super::body::Body;
use super::header::{self, Element, Property};
use crate::builder::{self, SceneBuilder};
use crate::tint::Tints;
use crate::warning::Unknown;
use crate::{FormatError, ReadOptions, Warning};

/// Names of the list of a face's corners.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];
/// Properties of vertices that are the position, and the normal.
const POSITION: [&str; 3] = ["x", "y", "z"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
/// Properties of vertices that are colours.
const COLOURS: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];

/// Whether a file begins like a PLY.
pub(crate) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply\n") || bytes.starts_with(b"ply\r")
}

/// Reads a PLY whose bytes are given.
pub(crate) fn read(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Scene, Vec<Warning>), FormatError> {
    let file = path.display().to_string();
    if !begins(bytes) {
        let (place, what) = ("line 1".to_owned(), "it does not begin with the word ply".to_owned());
        return Err(FormatError::BadStatement { file, place, what, cure: "export it again" });
    }
    let header = header::read(&file, bytes)?;
    let mut builder = SceneBuilder::new(builder::stem(path), bytes.len(), options);
    let colours = header.elements.iter().filter(|element| element.name == "vertex").find_map(colours_of);
    let material = match colours {
        Some(_) => builder.uncapped(Material::diffuse("default", Rgb::ONE)),
        None => builder.grey("default"),
    };
    let name = builder.name().to_owned();
    let node = builder.node(&name, None, &file, || "the header".into())?;
    let surface = builder.surface(node, material);
    let mut vertices = header.elements.iter().filter(|element| element.name == "vertex");
    let with_normals = vertices.all(|element| NORMAL.iter().all(|name| has(element, &[name])));
    let body = Body::new(&file, header.encoding, bytes, header.length);
    let mut reader = Reader {
        file: &file,
        body,
        builder,
        surface,
        with_normals,
        vertices: 0,
        unknown: Unknown::default(),
        too_few_corners: 0,
        painted: colours.map(|names| Painted {
            names,
            node,
            material,
            codes: Vec::new(),
            placed: HashMap::new(),
            tints: Tints::default(),
        }),
    };
    for element in &header.elements {
        reader.element(element)?;
    }
    let Reader { builder, unknown, too_few_corners, .. } = reader;
    Ok(builder.finish_without_materials(too_few_corners, unknown))
}

/// The names of the colours of vertices, if these have one.
fn colours_of(element: &Element) -> Option<[&'static str; 3]> {
    COLOURS.into_iter().find(|names| names.iter().all(|name| has(element, &[name])))
}

/// Vertices with colours: polygons of one colour become one surface, with vertices of its own.
struct Painted {
    names: [&'static str; 3],
    node: NodeId,
    /// White: what colours are multiplied with.
    material: MaterialId,
    /// Of each vertex, in codes from 0 to 1.
    codes: Vec<Rgb>,
    /// The number of each vertex in each surface.
    placed: HashMap<(SurfaceId, u32), u32>,
    tints: Tints,
}

impl Painted {
    /// The surface of a polygon and its corners there.
    fn place(&mut self, corners: &[u32], from: SurfaceId, builder: &mut SceneBuilder) -> (SurfaceId, Vec<u32>) {
        let codes = corners.iter().map(|&corner| self.codes.get(corner as usize).copied().unwrap_or(Rgb::ONE));
        let material = self.tints.tinted(self.material, codes, builder);
        let surface = builder.surface(self.node, material);
        let own = |&corner: &u32| {
            *self.placed.entry((surface, corner)).or_insert_with(|| builder.copy_position(from, corner, surface))
        };
        (surface, corners.iter().map(own).collect())
    }
}

struct Reader<'a> {
    file: &'a str,
    body: Body<'a>,
    builder: SceneBuilder,
    surface: SurfaceId,
    /// Whether all vertices have a normal.
    with_normals: bool,
    vertices: usize,
    unknown: Unknown,
    too_few_corners: usize,
    painted: Option<Painted>,
}

impl Reader<'_> {
    fn element(&mut self, element: &Element) -> Result<(), FormatError> {
        match element.name.as_str() {
            "vertex" => self.all(element, Self::vertex),
            "face" if has(element, &CORNERS) => self.all(element, Self::face),
            "tristrips" if has(element, &CORNERS) => self.all(element, Self::strip),
            name => {
                self.unknown.add(name);
                // Elements without properties take no bytes, however many there are.
                if element.properties.is_empty() { Ok(()) } else { self.all(element, Self::other) }
            }
        }
    }

    /// Reads the elements of a kind one by one.
    fn all(
        &mut self,
        element: &Element,
        read: fn(&mut Self, &Element, u64) -> Result<(), FormatError>,
    ) -> Result<(), FormatError> {
        for number in 0..element.count {
            self.builder.budget.spend(1, self.file, || place(element, number))?;
            read(self, element, number)?;
        }
        Ok(())
    }

    fn vertex(&mut self, element: &Element, number: u64) -> Result<(), FormatError> {
        let (mut position, mut normal, mut code) = (DVec3::ZERO, DVec3::ZERO, Rgb::ONE);
        let names = self.painted.as_ref().map(|painted| painted.names);
        for property in &element.properties {
            let axis_of = |names: [&str; 3]| names.iter().position(|name| *name == property.name);
            if let (Some(channel), None) = (names.and_then(axis_of), property.length) {
                code[channel] = self.body.number(property.kind, || place(element, number))? / property.kind.white();
                continue;
            }
            match (axis_of(POSITION), axis_of(NORMAL), property.length) {
                (Some(axis), _, None) => {
                    position[axis] = self.body.number(property.kind, || place(element, number))?;
                }
                (_, Some(axis), None) => {
                    normal[axis] = self.body.number(property.kind, || place(element, number))?;
                }
                _ => self.skip(property, element, number)?,
            }
        }
        self.builder.position(self.surface, position);
        if self.with_normals {
            self.builder.corner(self.surface, normal.normalize_or_zero(), None);
        }
        if !position.is_finite() {
            let (file, place) = (self.file.to_owned(), place(element, number));
            return Err(FormatError::NotFinite { file, place, value: position.to_string() });
        }
        self.vertices += 1;
        self.painted.iter_mut().for_each(|painted| painted.codes.push(code));
        Ok(())
    }

    fn face(&mut self, element: &Element, number: u64) -> Result<(), FormatError> {
        for property in &element.properties {
            let Some(length) = property.length.filter(|_| CORNERS.contains(&property.name.as_str())) else {
                self.skip(property, element, number)?;
                continue;
            };
            let count = self.body.whole(length, || place(element, number))?;
            let mut corners = Vec::new();
            for _ in 0..count {
                self.builder.budget.spend(1, self.file, || place(element, number))?;
                let index = self.body.whole(property.kind, || place(element, number))?;
                corners.push(self.corner(index, || place(element, number))?);
            }
            if corners.len() >= 3 {
                self.polygon(corners);
            } else {
                self.too_few_corners += 1;
            }
        }
        Ok(())
    }

    /// Strips of triangles: each vertex makes one with the two before it; -1 ends a strip.
    fn strip(&mut self, element: &Element, number: u64) -> Result<(), FormatError> {
        for property in &element.properties {
            let Some(length) = property.length.filter(|_| CORNERS.contains(&property.name.as_str())) else {
                self.skip(property, element, number)?;
                continue;
            };
            let count = self.body.whole(length, || place(element, number))?;
            let mut strip: Vec<u32> = Vec::new();
            for _ in 0..count {
                self.builder.budget.spend(3, self.file, || place(element, number))?;
                let index = self.body.number(property.kind, || place(element, number))?;
                if index < 0.0 {
                    strip.clear();
                    continue;
                }
                // Indices are whole and far below 2^53; others are not below the count.
                strip.push(self.corner(index as u64, || place(element, number))?);
                if let [.., a, b, c] = strip[..] {
                    let triangle = if strip.len() % 2 == 1 { [a, b, c] } else { [b, a, c] };
                    if a != b && b != c && c != a {
                        self.polygon(triangle.to_vec());
                    }
                }
            }
        }
        Ok(())
    }

    fn corner(&self, index: u64, place: impl Fn() -> String) -> Result<u32, FormatError> {
        let corner = u32::try_from(index).ok().filter(|_| index < self.vertices as u64);
        corner.ok_or_else(|| FormatError::BadIndex {
            file: self.file.to_owned(),
            place: place(),
            index,
            count: self.vertices,
        })
    }

    fn polygon(&mut self, corners: Vec<u32>) {
        let (surface, corners) = match &mut self.painted {
            None => (self.surface, corners),
            Some(painted) => painted.place(&corners, self.surface, &mut self.builder),
        };
        self.builder.polygon(surface, corners);
    }

    fn other(&mut self, element: &Element, number: u64) -> Result<(), FormatError> {
        element.properties.iter().try_for_each(|property| self.skip(property, element, number))
    }

    fn skip(&mut self, property: &Property, element: &Element, number: u64) -> Result<(), FormatError> {
        let count = match property.length {
            Some(length) => self.body.whole(length, || place(element, number))?,
            None => 1,
        };
        for _ in 0..count {
            self.body.number(property.kind, || place(element, number))?;
        }
        Ok(())
    }
}

fn has(element: &Element, names: &[&str]) -> bool {
    element.properties.iter().any(|property| names.contains(&property.name.as_str()))
}

fn place(element: &Element, number: u64) -> String {
    format!("{} {number}", crate::text::shortened(&element.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n\
        element face 2\nproperty uchar flags\nproperty list uchar int vertex_indices\nelement edge 1\n\
        property list uchar short ends\nend_header\n";

    fn text() -> String {
        let data = "0 0 0 9\n1 0 0 9\n1 1 0 9\n0 1 0 9\n 7 4 0 1 2 3\n 7 2 0 1\n1 5\n";
        format!("ply\nformat ascii 1.0\n{HEADER}{data}")
    }

    fn binary(big: bool) -> Vec<u8> {
        let name = if big { "big" } else { "little" };
        let mut bytes = format!("ply\nformat binary_{name}_endian 1.0\n{HEADER}").into_bytes();
        let mut put = |number: &[u8]| {
            let mut number = number.to_vec();
            if big {
                number.reverse();
            }
            bytes.extend(number);
        };
        for corner in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
            corner.iter().for_each(|x| put(&x.to_le_bytes()));
            put(&[9]);
        }
        for face in [&[0_i32, 1, 2, 3][..], &[0, 1]] {
            put(&[7]);
            put(&[face.len() as u8]);
            face.iter().for_each(|i| put(&i.to_le_bytes()));
        }
        put(&[1]);
        put(&5_i16.to_le_bytes());
        bytes
    }

    fn read(bytes: &[u8]) -> Result<(Scene, Vec<Warning>), FormatError> {
        super::read(Path::new("part.ply"), bytes, &ReadOptions::default())
    }

    #[test]
    fn text_and_both_binaries_hold_the_same() {
        let (scene, warnings) = read(text().as_bytes()).unwrap();
        assert_eq!(scene.surfaces.raw[0].polygons, [[0, 1, 2, 3]]);
        assert_eq!(scene.surfaces.raw[0].positions_m[2], DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(
            warnings,
            [
                Warning::TooFewCorners { polygons: 1 },
                Warning::WithoutMaterial { polygons: 1 },
                Warning::UnknownStatements { statements: 1, kinds: vec!["edge".into()] },
            ]
        );
        for big in [false, true] {
            assert_eq!(read(&binary(big)).unwrap(), (scene.clone(), warnings.clone()));
        }
    }

    #[test]
    fn normals_are_taken_where_all_of_them_are_there() {
        let with = text().replace("property uchar red", "property float nx\nproperty float ny\nproperty float nz");
        let normal = |i: usize| ["0 0 2", "0 3 0", "nan 0 1", "0 0 0"][i];
        let row = |(i, row): (usize, &str)| match row.strip_suffix(" 9") {
            Some(corner) => format!("{corner} {}", normal(i)),
            None => row.to_owned(),
        };
        let (header, rows) = with.split_once("end_header\n").unwrap();
        let rows: Vec<String> = rows.lines().enumerate().map(row).collect();
        let read_with = |header: &str| read(format!("{header}end_header\n{}\n", rows.join("\n")).as_bytes()).unwrap().0;
        assert_eq!(read_with(header).surfaces.raw[0].normals, [DVec3::Z, DVec3::Y, DVec3::ZERO, DVec3::ZERO]);
        assert!(read_with(&header.replace("ny", "confidence")).surfaces.raw[0].normals.is_empty());
    }

    #[test]
    fn colours_of_vertices_are_what_polygons_reflect() {
        let with =
            text().replace("property uchar red", "property uchar red\nproperty uchar green\nproperty uchar blue");
        let with = with.replace(" 9\n", " 255 0 188\n");
        let (scene, warnings) = read(with.as_bytes()).unwrap();
        let painted = scene.surfaces.iter().find(|surface| !surface.polygons.is_empty()).unwrap();
        assert_eq!((painted.polygons.clone(), painted.positions_m.len()), (vec![vec![0, 1, 2, 3]], 4));
        let reflectance = scene.materials[painted.material].reflectance;
        assert!((reflectance - Rgb::new(0.9, 0.0, 0.503)).abs().max_element() < 0.01, "{reflectance}");
        assert!(!warnings.iter().any(|warning| matches!(warning, Warning::WithoutMaterial { .. })), "{warnings:?}");
    }

    #[test]
    fn strips_of_triangles_are_read() {
        let header = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n\
            property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n";
        let read_strip = |strip: &str| read(format!("ply\nformat ascii 1.0\n{header}{strip}\n").as_bytes());
        let polygons = |strip: &str| read_strip(strip).unwrap().0.surfaces.raw[0].polygons.clone();
        assert_eq!(polygons("4 0 1 2 3"), [[0, 1, 2], [2, 1, 3]]);
        assert_eq!(polygons("7 0 1 2 -1 1 3 2"), [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(polygons("5 0 1 1 2 3"), [[1, 2, 3]], "what has no area is left out");
        assert!(read_strip("3 0 1 4").is_err());
    }

    #[test]
    fn cut_files_are_errors() {
        for bytes in [text().trim_end().as_bytes(), &binary(false), &binary(true)] {
            for end in 1..bytes.len() {
                let message = read(&bytes[..end]).expect_err("cut").to_string();
                assert!(message.starts_with("part.ply: "), "{message}");
            }
        }
    }

    #[test]
    fn bad_numbers_are_named_by_element() {
        for (from, to, words) in [
            (" 7 4 0 1 2 3", " 7 4 0 1 2 4", "face 0: refers to vertex 4, but there are only 4"),
            (" 7 4 0 1 2 3", " 7 4 0 1 2 -1", "face 0: -1 is not a whole number"),
            ("1 1 0 9", "1 nan 0 9", "vertex 2"),
            ("1 1 0 9", "1 x 0 9", "vertex 2: \"x\" is not a number"),
            ("vertex 4", "vertex 99999999999", "vertex "),
            ("face 2", "face 18446744073709551615", "face 2"),
            ("edge 1", "edge 18446744073709551615", "edge 1"),
        ] {
            let message = read(text().replace(from, to).as_bytes()).unwrap_err().to_string();
            assert!(message.contains(words), "no {words:?} in: {message}");
        }
    }
}
