//! An OBJ as a [`Scene`]: polygons of any number of corners, as they stand.
//!
//! `o` and `g` become nodes, a group below its object; what stands in neither hangs from a node that is named like the
//! file. The first pass takes the vertices and materials, the second the polygons, so that a polygon may come before its
//! corners. A face's front is where its corners run counter-clockwise, whatever its normals say. Units
//! are the caller's to say; nothing in an OBJ does.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use glam::{DVec2, DVec3};
use umbrage::id::{MaterialId, NodeId, SurfaceId};
use umbrage::scene::{Rgb, Scene};

use super::material::{Libraries, Materials, Use};
use crate::beside::Folder;
use crate::builder::{self, SceneBuilder};
use crate::text::{Cursor, EXPORT_AGAIN, Place, keyword, words};
use crate::tint::Tints;
use crate::warning::Unknown;
use crate::{FormatError, ReadOptions, Warning};

/// Reads an OBJ whose bytes are given, and whose libraries and images are in `folder`.
pub(crate) fn read(
    path: &Path,
    bytes: &[u8],
    folder: &Folder,
    options: &ReadOptions,
) -> Result<(Scene, Vec<Warning>), FormatError> {
    let file = path.display().to_string();
    let mut builder = SceneBuilder::new(builder::stem(path), bytes.len(), options);
    let mut unknown = Unknown::default();
    let mut libraries = Libraries::new(path, folder);
    let mut vertices = Vec::new();
    let (mut coordinates, mut normals) = (Vec::new(), Vec::new());
    let mut colours = Colours::default();
    let mut bad_normals = 0;

    let mut cursor = Cursor::default();
    while let Some(line) = cursor.next_line(bytes, false) {
        let place = Place { file: &file, line: line.number };
        match keyword(&line.text) {
            ("v", rest) => {
                let (position, colour) = vertex(place, rest)?;
                colours.push(vertices.len(), colour);
                vertices.push(position);
            }
            ("vt", rest) => coordinates.push(texture_vertex(place, rest)?),
            ("vn", rest) => {
                let normal = normal(rest);
                bad_normals += usize::from(normal.is_none());
                normals.push(normal.unwrap_or_default());
            }
            ("mtllib", names) => libraries.add(names, &mut builder, &mut unknown)?,
            _ => {}
        }
    }

    let materials = Materials::new(libraries, &mut builder);
    let mut reader = Reader {
        file: &file,
        vertices,
        coordinates,
        normals,
        seen: [0; 3],
        placed: HashMap::new(),
        builder,
        materials,
        material: None,
        object: String::new(),
        group: String::new(),
        nodes: BTreeMap::new(),
        node: None,
        tally: Tally { bad_normals, ..Tally::default() },
        colours,
        tints: Tints::default(),
    };
    let mut cursor = Cursor::default();
    while let Some(line) = cursor.next_line(bytes, false) {
        reader.statement(Place { file: &file, line: line.number }, &line.text, &mut unknown)?;
    }
    let Reader { mut builder, materials, tally, .. } = reader;
    materials.textures.finish(&mut builder);
    let (scene, capped) = builder.finish();
    let mut warnings = tally.warnings();
    warnings.extend(materials.warnings());
    warnings.extend(capped);
    warnings.extend(unknown.warning());
    Ok((scene, warnings))
}

/// A vertex, and its colour (x y z r g b), which is not in the format but found.
fn vertex(place: Place<'_>, rest: &str) -> Result<(DVec3, Option<Rgb>), FormatError> {
    let mut words = words(rest);
    let mut position = DVec3::ZERO;
    for i in 0..3 {
        let word = words.next();
        let word = word.ok_or_else(|| place.bad(format!("a vertex has {i} coordinates, and needs 3"), EXPORT_AGAIN))?;
        position[i] = place.number(word)?;
    }
    // A fourth number alone is a weight.
    let mut colour =
        || Some(Rgb::new(words.next()?.parse().ok()?, words.next()?.parse().ok()?, words.next()?.parse().ok()?));
    Ok((position, colour().filter(|colour| colour.is_finite())))
}

/// Colours of vertices, 0 to 1 or, where one is greater, 0 to 255.
#[derive(Debug, Default)]
struct Colours {
    /// Of each vertex up to the last that has one; white where it has none.
    codes: Vec<Rgb>,
    most: f64,
}

impl Colours {
    fn push(&mut self, vertex: usize, colour: Option<Rgb>) {
        let Some(colour) = colour else { return };
        self.most = self.most.max(colour.max_element());
        self.codes.resize(vertex, Rgb::INFINITY);
        self.codes.push(colour);
    }

    fn of(&self, vertex: usize) -> Rgb {
        let code = self.codes.get(vertex).copied().unwrap_or(Rgb::INFINITY);
        (code / if self.most > 1.0 { 255.0 } else { 1.0 }).min(Rgb::ONE)
    }
}

/// A normal, if it is three finite numbers: exporters write `nan`, `-nan(ind)` and less than three for faces without area.
fn normal(rest: &str) -> Option<DVec3> {
    let mut words = words(rest).map(|word| word.parse::<f64>().ok().filter(|number| number.is_finite()));
    Some(DVec3::new(words.next()??, words.next()??, words.next()??))
}

/// Texture coordinates: u, and v where it is given.
fn texture_vertex(place: Place<'_>, rest: &str) -> Result<DVec2, FormatError> {
    let mut words = words(rest);
    let [u] = place.numbers("vt", &mut words)?;
    Ok(DVec2::new(u, words.next().map_or(Ok(0.0), |v| place.finite(v))?))
}

/// What is counted for warnings.
#[derive(Debug, Default)]
struct Tally {
    points_and_lines: usize,
    too_few_corners: usize,
    transparent: usize,
    without_material: usize,
    bad_normals: usize,
    /// Polygons of materials that light passes through.
    glass: usize,
    /// Coloured polygons with an image, which says their colour.
    untinted: usize,
}

impl Tally {
    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let mut warn = |count: usize, warning: fn(usize) -> Warning| {
            if count > 0 {
                warnings.push(warning(count));
            }
        };
        warn(self.points_and_lines, |primitives| Warning::PointsAndLines { primitives });
        warn(self.too_few_corners, |polygons| Warning::TooFewCorners { polygons });
        warn(self.transparent, |polygons| Warning::TransparentLeftOut { polygons });
        warn(self.without_material, |polygons| Warning::WithoutMaterial { polygons });
        warn(self.bad_normals, |normals| Warning::BadNormals { normals });
        warn(self.glass, |polygons| Warning::GlassPassedOn { polygons });
        warn(self.untinted, |polygons| Warning::ColoursUnderImages { polygons });
        warnings
    }
}

/// A corner of a face: numbers in the tables of vertices, texture coordinates and normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Corner {
    vertex: usize,
    coordinates: Option<usize>,
    normal: Option<usize>,
}

/// The second pass.
struct Reader<'a> {
    file: &'a str,
    vertices: Vec<DVec3>,
    coordinates: Vec<DVec2>,
    normals: Vec<DVec3>,
    /// Vertices, texture coordinates and normals before the current line, from which negative numbers count back.
    seen: [usize; 3],
    /// The number of each corner in each surface.
    placed: HashMap<(SurfaceId, Corner), u32>,
    builder: SceneBuilder,
    materials: Materials,
    /// `None` before the first `usemtl`.
    material: Option<Use>,
    object: String,
    group: String,
    /// By object and group.
    nodes: BTreeMap<(String, String), NodeId>,
    /// The current one, once there is a polygon for it.
    node: Option<NodeId>,
    tally: Tally,
    colours: Colours,
    tints: Tints,
}

impl Reader<'_> {
    fn statement(&mut self, place: Place<'_>, text: &str, unknown: &mut Unknown) -> Result<(), FormatError> {
        match keyword(text) {
            ("v", _) => self.seen[0] += 1,
            ("vt", _) => self.seen[1] += 1,
            ("vn", _) => self.seen[2] += 1,
            ("f" | "fo", rest) => self.face(place, rest)?,
            ("usemtl", name) => self.material = Some(self.materials.named(name, &mut self.builder)),
            ("o", name) => {
                (self.object, self.group, self.node) = (name.to_owned(), String::new(), None);
            }
            ("g", name) => (self.group, self.node) = (name.to_owned(), None),
            ("p" | "l", _) => self.tally.points_and_lines += 1,
            // What the normals say better, and what the first pass took.
            ("s" | "mtllib", _) => {}
            (word, _) if word.starts_with('#') => {}
            (word, _) => unknown.add(word),
        }
        Ok(())
    }

    fn face(&mut self, place: Place<'_>, rest: &str) -> Result<(), FormatError> {
        let corners = words(rest).map(|word| self.corner(place, word)).collect::<Result<Vec<_>, _>>()?;
        self.builder.budget.spend(corners.len() as u64, self.file, || place.name())?;
        if corners.len() < 3 {
            self.tally.too_few_corners += 1;
            return Ok(());
        }
        let material = match self.material.unwrap_or_else(|| {
            self.tally.without_material += 1;
            self.materials.none(&mut self.builder)
        }) {
            Use::Opaque(material) => material,
            Use::Glass(material) => {
                self.tally.glass += 1;
                material
            }
            Use::Transparent => {
                self.tally.transparent += 1;
                return Ok(());
            }
        };
        let node = self.node(place)?;
        let material = self.tinted(material, &corners);
        let surface = self.builder.surface(node, material);
        let corners = corners.into_iter().map(|corner| {
            let position = self.vertices[corner.vertex];
            if !position.is_finite() {
                let (file, value) = (self.file.to_owned(), position.to_string());
                let place = format!("{}, vertex {}", place.name(), corner.vertex + 1);
                return Err(FormatError::NotFinite { file, place, value });
            }
            Ok(self.place(surface, material, corner))
        });
        let corners = corners.collect::<Result<_, _>>()?;
        self.builder.polygon(surface, corners);
        Ok(())
    }

    /// The material of a polygon, by the colours of its corners.
    fn tinted(&mut self, material: MaterialId, corners: &[Corner]) -> MaterialId {
        if self.colours.codes.is_empty() {
            return material;
        }
        if self.materials.textures.is_on(material) {
            self.tally.untinted += usize::from(corners.iter().any(|corner| self.colours.of(corner.vertex) != Rgb::ONE));
            return material;
        }
        let codes = corners.iter().map(|corner| self.colours.of(corner.vertex));
        self.tints.tinted(material, codes, &mut self.builder)
    }

    /// The number of a corner in a surface, to which it is added if it is new.
    fn place(&mut self, surface: SurfaceId, material: MaterialId, corner: Corner) -> u32 {
        // Where there is no image, coordinates would only keep polygons apart.
        let coordinates = corner.coordinates.filter(|_| self.materials.textures.is_on(material));
        let corner = Corner { coordinates, ..corner };
        if let Some(&known) = self.placed.get(&(surface, corner)) {
            return known;
        }
        let number = self.builder.position(surface, self.vertices[corner.vertex]);
        let normal = corner.normal.and_then(|normal| self.normals[normal].try_normalize());
        // Taken to places in the image once all surfaces are there.
        let uv = self
            .materials
            .textures
            .is_on(material)
            .then(|| coordinates.map_or(DVec2::ZERO, |coordinates| self.coordinates[coordinates]));
        self.builder.corner(surface, normal.unwrap_or_default(), uv);
        self.placed.insert((surface, corner), number);
        number
    }

    /// A corner `v`, `v/vt`, `v//vn` or `v/vt/vn`. What is wrong with its texture coordinates or its normal only loses these.
    fn corner(&self, place: Place<'_>, word: &str) -> Result<Corner, FormatError> {
        let vertex = self.vertex_number(place, word)?;
        let mut others = word.split('/').skip(1);
        let mut index = |kind: usize, count: usize| {
            let number: i64 = others.next()?.parse().ok()?;
            // Counts are far from the bounds of i64.
            let index =
                if number < 0 { (self.seen[kind] as i64).checked_add(number)? } else { number.checked_sub(1)? };
            usize::try_from(index).ok().filter(|index| *index < count)
        };
        let coordinates = index(1, self.coordinates.len());
        Ok(Corner { vertex, coordinates, normal: index(2, self.normals.len()) })
    }

    /// The vertex of a corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, from 0. Negative numbers count back from the line.
    fn vertex_number(&self, place: Place<'_>, word: &str) -> Result<usize, FormatError> {
        let digits = word.split('/').next().unwrap_or_default();
        let number: i64 = digits.parse().map_err(|_| {
            let word = crate::text::shortened(word);
            place.bad(format!("{word:?} is not a corner of a face"), EXPORT_AGAIN)
        })?;
        let index = if number < 0 {
            // Numbers of vertices are far from the bounds of i64.
            (self.seen[0] as i64).checked_add(number)
        } else {
            number.checked_sub(1)
        };
        match index.and_then(|index| usize::try_from(index).ok()) {
            Some(index) if index < self.vertices.len() => Ok(index),
            Some(_) => Err(FormatError::BadIndex {
                file: self.file.to_owned(),
                place: place.name(),
                index: number.unsigned_abs(),
                count: self.vertices.len(),
            }),
            None => Err(place.bad(
                format!("refers to vertex {number}, and there are {} before it", self.seen[0]),
                "vertices count from 1, or from -1 back: export the file again",
            )),
        }
    }

    /// The node of the current object and group.
    fn node(&mut self, place: Place<'_>) -> Result<NodeId, FormatError> {
        if let Some(node) = self.node {
            return Ok(node);
        }
        let (object, group) = (self.object.clone(), self.group.clone());
        let node = match (object.is_empty(), group.is_empty()) {
            (true, true) => {
                let name = self.builder.name().to_owned();
                self.named_node((object, group), &name, None, place)?
            }
            (false, true) => self.named_node((object.clone(), group), &object, None, place)?,
            (true, false) => self.named_node((object, group.clone()), &group, None, place)?,
            (false, false) => {
                let above = self.named_node((object.clone(), String::new()), &object, None, place)?;
                self.named_node((object, group.clone()), &group, Some(above), place)?
            }
        };
        self.node = Some(node);
        Ok(node)
    }

    fn named_node(
        &mut self,
        key: (String, String),
        name: &str,
        parent: Option<NodeId>,
        place: Place<'_>,
    ) -> Result<NodeId, FormatError> {
        if let Some(&node) = self.nodes.get(&key) {
            return Ok(node);
        }
        let node = self.builder.node(name, parent, self.file, || place.name())?;
        self.nodes.insert(key, node);
        Ok(node)
    }
}
