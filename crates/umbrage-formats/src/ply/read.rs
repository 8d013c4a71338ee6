//! A PLY as a [`Scene`]: one node, one surface, the grey material `default`.
//!
//! Of vertices the properties `x`, `y` and `z` are taken, and `nx`, `ny` and `nz`, the normal of a smooth surface; of faces
//! the list `vertex_indices` (or `vertex_index`); polygons stay what they are. Colours, other properties and other elements are passed over with a warning.

use std::path::Path;

use glam::DVec3;
use umbrage::id::SurfaceId;
use umbrage::scene::Scene;

use super::body::Body;
use super::header::{self, Element, Property};
use crate::builder::{self, SceneBuilder};
use crate::warning::Unknown;
use crate::{FormatError, ReadOptions, Warning};

/// Names of the list of a face's corners.
const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];
/// Properties of vertices that are the position, and the normal.
const POSITION: [&str; 3] = ["x", "y", "z"];
const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
/// Properties of vertices that are colours.
const COLOURS: [&str; 3] = ["red", "diffuse_red", "r"];

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
    let material = builder.grey("default");
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
        coloured: 0,
        too_few_corners: 0,
    };
    for element in &header.elements {
        reader.element(element)?;
    }
    let Reader { builder, unknown, coloured, too_few_corners, .. } = reader;
    Ok(builder.finish_without_materials(too_few_corners, coloured, unknown))
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
    coloured: usize,
    too_few_corners: usize,
}

impl Reader<'_> {
    fn element(&mut self, element: &Element) -> Result<(), FormatError> {
        match element.name.as_str() {
            "vertex" => {
                self.coloured += if has(element, &COLOURS) { element.count as usize } else { 0 };
                self.all(element, Self::vertex)
            }
            "face" if has(element, &CORNERS) => self.all(element, Self::face),
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
        let (mut position, mut normal) = (DVec3::ZERO, DVec3::ZERO);
        for property in &element.properties {
            let axis_of = |names: [&str; 3]| names.iter().position(|name| *name == property.name);
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
                let corner = u32::try_from(index).ok().filter(|_| index < self.vertices as u64);
                corners.push(corner.ok_or_else(|| FormatError::BadIndex {
                    file: self.file.to_owned(),
                    place: place(element, number),
                    index,
                    count: self.vertices,
                })?);
            }
            if corners.len() >= 3 {
                self.builder.polygon(self.surface, corners);
            } else {
                self.too_few_corners += 1;
            }
        }
        Ok(())
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
                Warning::ColouredVertices { vertices: 4 },
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
