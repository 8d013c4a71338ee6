//! STL, binary and text: triangles without materials.
//!
//! All triangles get the grey material `default`. Normals in the file are ignored: the front is where the corners run
//! counter-clockwise. Capitals do not count in a text. Every `solid` of a text becomes a node. Source: 3D Systems, *StereoLithography Interface
//! Specification*, 1989.

use std::path::Path;

use glam::DVec3;
use umbrage::id::SurfaceId;
use umbrage::scene::Scene;

use crate::builder::{self, SceneBuilder};
use crate::text::{Cursor, EXPORT_AGAIN, Place, keyword, words};
use crate::warning::Unknown;
use crate::{FormatError, ReadOptions, Warning};

/// Bytes before the count of triangles.
const HEADER: usize = 80;
/// Bytes of a triangle: a normal and three corners in f32, and two bytes of attributes.
const TRIANGLE: usize = 50;

/// Reads an STL whose bytes are given.
pub(crate) fn read(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Scene, Vec<Warning>), FormatError> {
    let file = path.display().to_string();
    let mut builder = SceneBuilder::new(builder::stem(path), bytes.len(), options);
    let material = builder.grey("default");
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let is_text = text.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let triangles = triangle_count(bytes);
    let fits = |n: usize| n.checked_mul(TRIANGLE).and_then(|n| n.checked_add(HEADER + 4));
    // Binary files may begin with "solid" too, so what decides is whether the count fits the length.
    let is_binary = triangles.and_then(fits) == Some(bytes.len());
    let mut unknown = Unknown::default();
    let mut too_few_corners = 0;
    if is_binary || !is_text {
        let wanted = triangles.map_or(HEADER as u64 + 4, |n| fits(n).map_or(u64::MAX, |end| end as u64));
        if wanted > bytes.len() as u64 {
            let (place, length) = ("the triangles".to_owned(), bytes.len() as u64);
            return Err(FormatError::BeyondEnd { file, place, end: wanted, length });
        }
        let name = builder.name().to_owned();
        let node = builder.node(&name, None, &file, || "the header".into())?;
        let surface = builder.surface(node, material);
        binary(&mut builder, surface, &file, bytes)?;
    } else {
        let mut surface = None;
        let mut corners: Vec<DVec3> = Vec::new();
        let mut cursor = Cursor::default();
        while let Some(line) = cursor.next_line(bytes, false) {
            let place = Place { file: &file, line: line.number };
            let (word, rest) = keyword(&line.text);
            match (word.to_ascii_lowercase().as_str(), rest) {
                ("solid", name) => {
                    let name = if name.is_empty() { builder.name().to_owned() } else { name.to_owned() };
                    let node = builder.node(&name, None, &file, || place.name())?;
                    surface = Some(builder.surface(node, material));
                }
                ("vertex", rest) => corners.push(place.numbers::<3>("vertex", &mut words(rest))?.into()),
                ("endloop", _) => {
                    let Some(surface) = surface else {
                        return Err(place.bad("there is no solid yet", EXPORT_AGAIN));
                    };
                    builder.budget.spend(corners.len() as u64, &file, || place.name())?;
                    if corners.len() >= 3 {
                        add(&mut builder, surface, &corners);
                    } else {
                        too_few_corners += 1;
                    }
                    corners.clear();
                }
                ("facet" | "outer" | "endfacet" | "endsolid", _) => {}
                (word, _) => unknown.add(word),
            }
        }
        if !corners.is_empty() {
            let (place, length) = ("the last facet".to_owned(), bytes.len() as u64);
            return Err(FormatError::BeyondEnd { file, place, end: length + 1, length });
        }
    }
    Ok(builder.finish_without_materials(too_few_corners, unknown))
}

/// The count in the header of a binary file; where a writer left it at 0, what follows counts.
fn triangle_count(bytes: &[u8]) -> Option<usize> {
    let (count, body) = bytes.get(HEADER..)?.split_first_chunk::<4>()?;
    match usize::try_from(u32::from_le_bytes(*count)).ok()? {
        0 if body.len().is_multiple_of(TRIANGLE) => Some(body.len() / TRIANGLE),
        count => Some(count),
    }
}

fn binary(builder: &mut SceneBuilder, surface: SurfaceId, file: &str, bytes: &[u8]) -> Result<(), FormatError> {
    let count = triangle_count(bytes).unwrap_or(0);
    for (number, triangle) in bytes[HEADER + 4..].chunks_exact(TRIANGLE).take(count).enumerate() {
        let (numbers, _) = triangle.as_chunks::<4>();
        let number_at = |i: usize| f64::from(f32::from_le_bytes(numbers[i]));
        let corners = [3, 6, 9].map(|i| DVec3::new(number_at(i), number_at(i + 1), number_at(i + 2)));
        if let Some(bad) = corners.iter().find(|corner| !corner.is_finite()) {
            let (file, place) = (file.to_owned(), format!("triangle {number}"));
            return Err(FormatError::NotFinite { file, place, value: bad.to_string() });
        }
        add(builder, surface, &corners);
    }
    Ok(())
}

fn add(builder: &mut SceneBuilder, surface: SurfaceId, corners: &[DVec3]) {
    let corners = corners.iter().map(|&corner| builder.position(surface, corner)).collect();
    builder.polygon(surface, corners);
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid a chair\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n   vertex 0 2 0\n  \
        endloop\n endfacet\nendsolid\n";

    fn read(bytes: &[u8]) -> Result<(Scene, Vec<Warning>), FormatError> {
        super::read(Path::new("part.stl"), bytes, &ReadOptions::default())
    }

    fn a_binary(corners: &[[f32; 3]]) -> Vec<u8> {
        let mut bytes = b"solid, but binary".to_vec();
        bytes.resize(HEADER, 0);
        bytes.extend((corners.len() as u32 / 3).to_le_bytes());
        for triangle in corners.chunks(3) {
            bytes.extend([0; 12]);
            bytes.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    #[test]
    fn text_and_binary_hold_the_same() {
        let (text, warnings) = read(TEXT.as_bytes()).unwrap();
        assert_eq!(warnings, [Warning::WithoutMaterial { polygons: 1 }]);
        assert_eq!(text.nodes.raw[0].name.as_deref(), Some("a chair"));
        let (binary, _) = read(&a_binary(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])).unwrap();
        assert_eq!(binary.surfaces, text.surfaces);
        assert_eq!(binary.nodes.raw[0].name.as_deref(), Some("part"));
        assert_eq!(binary.materials.raw[0].name, "default");
    }

    #[test]
    fn capitals_a_byte_order_mark_and_a_count_of_0_are_read() {
        let (plain, _) = read(TEXT.as_bytes()).unwrap();
        for text in [TEXT.to_uppercase(), format!("\u{feff}{TEXT}")] {
            assert_eq!(read(text.as_bytes()).unwrap().0.surfaces, plain.surfaces, "{text}");
        }
        let mut binary = a_binary(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
        binary[HEADER..HEADER + 4].fill(0);
        binary[0] = b'x';
        assert_eq!(read(&binary).unwrap().0.surfaces, plain.surfaces);
    }

    #[test]
    fn cut_and_bad_files_are_named() {
        let binary = a_binary(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, f32::NAN, 0.0]]);
        let message = read(&binary).unwrap_err().to_string();
        assert!(message.starts_with("part.stl: triangle 0: ") && message.contains("not finite"), "{message}");
        let mut binary = a_binary(&[[0.0; 3]; 3]);
        binary[0] = b'x';
        for end in 1..binary.len() {
            assert!(read(&binary[..end]).is_err(), "{end}");
        }
        for (text, words) in [
            (TEXT.replace("vertex 1 0 0", "vertex 1 0"), "line 5: vertex has 2 numbers"),
            (TEXT.replace("1 0 0", "1 0 inf"), "line 5"),
            (TEXT[..TEXT.find("endloop").unwrap()].to_owned(), "the last facet"),
        ] {
            let message = read(text.as_bytes()).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
        let (_, warnings) = read(TEXT.replace("vertex 1 0 0", "colour 1 0 0").as_bytes()).unwrap();
        assert_eq!(warnings[0], Warning::TooFewCorners { polygons: 1 });
    }
}
