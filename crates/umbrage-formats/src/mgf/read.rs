//! An MGF as a [`Scene`]: its statements carried out in order.
//!
//! Files are not unfolded: an array (`xf -a`) or an array of includes goes back to where it began for each element, as
//! the format means it, so contexts are set anew each time. Every statement that is carried out is charged to the
//! budget, so nested arrays end.
//!
//! Objects (`o`) become nodes, one for each time that one is opened and has surfaces.

use std::path::Path;
use std::rc::Rc;

use glam::{DAffine3, DVec3};
use umbrage::id::{NodeId, SurfaceId};
use umbrage::scene::Scene;

use super::colour::Colour;
use super::context::Context;
use super::material::{Materials, MgfMaterial};
use super::shape::{Statement, Vertex};
use super::solid::Solid;
use super::source::{Source, Sources};
use super::transform::Transform;
use crate::beside::Folder;
use crate::builder::{self, SceneBuilder};
use crate::text::{Cursor, EXPORT_AGAIN, Line, Place};
use crate::warning::Unknown;
use crate::{FormatError, ReadOptions, Warning};

/// So many bytes of a text take about as much time as a corner.
const BYTES_PER_CORNER: u64 = 64;

/// Open transforms or objects within each other: more are refused.
const MAX_NESTING: usize = 512;

/// Reads an MGF whose bytes are given, and whose includes are in `folder`.
pub(crate) fn read(
    path: &Path,
    bytes: &[u8],
    folder: &Folder,
    options: &ReadOptions,
) -> Result<(Scene, Vec<Warning>), FormatError> {
    let (sources, main) = Sources::new(path, bytes, folder);
    let mut reader = Reader {
        builder: SceneBuilder::new(builder::stem(path), bytes.len(), options),
        segments: options.circle_segments.clamp(3, 4096),
        sources,
        files: Vec::new(),
        transforms: Vec::new(),
        objects: Vec::new(),
        root: None,
        vertices: Context::new("vertex"),
        colours: Context::new("colour"),
        mgf_materials: Context::new("material"),
        materials: Materials::default(),
        unknown: Unknown::default(),
        tally: Tally::default(),
    };
    reader.open(main, None);
    while let Some((source, line)) = reader.next_line()? {
        reader.statement(Place { file: &source.file, line: line.number }, &line.text)?;
    }
    Ok(reader.finish())
}

/// What is counted for warnings.
#[derive(Debug, Default)]
struct Tally {
    luminaires: usize,
    too_few_corners: usize,
    curved_shapes: usize,
    curved_polygons: usize,
    unclosed: usize,
    odd_colours: usize,
}

/// An open file.
#[derive(Debug)]
struct OpenFile {
    source: Rc<Source>,
    cursor: Cursor,
    /// Transforms that were open when it was opened, its own included.
    transforms: usize,
    objects: usize,
}

/// An open transform.
#[derive(Debug)]
struct OpenTransform {
    transform: Transform,
    /// It and all around it.
    world: DAffine3,
    /// Behind the line that opened it.
    begin: Cursor,
    objects: usize,
}

/// An open object.
#[derive(Debug)]
struct OpenObject {
    name: String,
    /// Once it has a surface.
    node: Option<NodeId>,
}

struct Reader {
    builder: SceneBuilder,
    segments: usize,
    sources: Sources,
    files: Vec<OpenFile>,
    transforms: Vec<OpenTransform>,
    objects: Vec<OpenObject>,
    /// The node of what is in no object.
    root: Option<NodeId>,
    vertices: Context<Vertex>,
    colours: Context<Colour>,
    mgf_materials: Context<MgfMaterial>,
    materials: Materials,
    unknown: Unknown,
    tally: Tally,
}

impl Reader {
    fn finish(self) -> (Scene, Vec<Warning>) {
        let Self { builder, materials, tally, .. } = self;
        let (mut scene, capped) = builder.finish();
        // What the format says: emittance is in lm/m2.
        scene.photometric = true;
        let mut warnings = Vec::new();
        let mut warn = |count: usize, warning: fn(usize) -> Warning| {
            if count > 0 {
                warnings.push(warning(count));
            }
        };
        warn(tally.too_few_corners, |polygons| Warning::TooFewCorners { polygons });
        warn(tally.luminaires, |luminaires| Warning::LuminairesIgnored { luminaires });
        warn(tally.unclosed, |contexts| Warning::UnclosedContexts { contexts });
        warn(tally.odd_colours, |colours| Warning::OddColours { colours });
        warn(materials.glossy, |materials| Warning::GlossIgnored { materials });
        warn(materials.transmitting, |materials| Warning::TransmissionIgnored { materials });
        warn(materials.out_of_gamut, |materials| Warning::ColoursOutOfGamut { materials });
        let (shapes, polygons) = (tally.curved_shapes, tally.curved_polygons);
        if shapes > 0 {
            warnings.push(Warning::CurvesTessellated { shapes, polygons, circle_segments: self.segments });
        }
        warnings.extend(capped);
        warnings.extend(self.unknown.warning());
        (scene, warnings)
    }

    /// Opens a file, within a transform of its own if it has one.
    fn open(&mut self, source: Rc<Source>, transform: Option<Transform>) {
        let begin = Cursor::default();
        let transform = transform.map(|transform| self.opened(transform, begin));
        self.transforms.extend(transform);
        let (transforms, objects) = (self.transforms.len(), self.objects.len());
        self.files.push(OpenFile { source, cursor: begin, transforms, objects });
    }

    fn opened(&self, transform: Transform, begin: Cursor) -> OpenTransform {
        let world = self.world() * transform.current();
        OpenTransform { transform, world, begin, objects: self.objects.len() }
    }

    fn world(&self) -> DAffine3 {
        self.transforms.last().map_or(DAffine3::IDENTITY, |open| open.world)
    }

    /// The next line of the innermost file, and that file; closes files at their ends.
    fn next_line(&mut self) -> Result<Option<(Rc<Source>, Line<'static>)>, FormatError> {
        while let Some(file) = self.files.last_mut() {
            let source = Rc::clone(&file.source);
            let before = file.cursor.offset();
            let line = file.cursor.next_line(&source.bytes, true);
            // Comments, blank lines and continued ones are gone over once for each element of an array.
            let passed = (file.cursor.offset() - before) as u64 / BYTES_PER_CORNER;
            self.builder.budget.spend(passed, &source.file, || "its lines".into())?;
            if let Some(line) = line {
                let line = Line { number: line.number, text: line.text.into_owned().into() };
                return Ok(Some((source, line)));
            }
            self.end_of_file(&source)?;
        }
        Ok(None)
    }

    /// Closes what the innermost file left open, and the file, unless something in it is to be repeated.
    fn end_of_file(&mut self, source: &Source) -> Result<(), FormatError> {
        let Some(file) = self.files.last() else { return Ok(()) };
        // An array with nothing in it takes time too.
        self.builder.budget.spend(1, &source.file, || "its end".into())?;
        let (own, outer_objects) = (file.transforms, file.objects);
        if self.transforms.len() > own {
            if !self.close_transform(&source.file)? {
                self.tally.unclosed += 1;
            }
            return Ok(());
        }
        // The first line of an include's file is where its own transform begins.
        let has_own = self.files.len() > 1;
        if has_own && self.close_transform(&source.file)? {
            return Ok(());
        }
        self.tally.unclosed += self.objects.len().saturating_sub(outer_objects);
        self.objects.truncate(outer_objects);
        self.files.pop();
        Ok(())
    }

    /// Closes the innermost transform, or goes back to its beginning for the next element of its array: then true.
    fn close_transform(&mut self, file: &str) -> Result<bool, FormatError> {
        let Some(mut open) = self.transforms.pop() else { return Ok(false) };
        self.builder.budget.spend(open.transform.part_count() as u64, file, || "an xf".into())?;
        self.tally.unclosed += self.objects.len().saturating_sub(open.objects);
        self.objects.truncate(open.objects);
        if !open.transform.advance() {
            return Ok(false);
        }
        if let Some(file) = self.files.last_mut() {
            file.cursor = open.begin;
        }
        open.world = self.world() * open.transform.current();
        self.transforms.push(open);
        Ok(true)
    }

    fn statement(&mut self, place: Place<'_>, text: &str) -> Result<(), FormatError> {
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let Some((&keyword, words)) = words.split_first() else { return Ok(()) };
        self.builder.budget.spend(1 + words.len() as u64 / 4, place.file, || place.name())?;
        match keyword {
            "v" => self.vertices.select(place, words)?,
            "c" => self.colours.select(place, words)?,
            "m" => self.mgf_materials.select(place, words)?,
            "p" => self.vertices.current_mut().position = place.numbers(keyword, &mut words.iter().copied())?.into(),
            "n" => self.vertices.current_mut().normal = place.numbers(keyword, &mut words.iter().copied())?.into(),
            "cxy" | "cspec" | "cct" | "cmix" => {
                let colour = self.colour(place, keyword, words)?;
                *self.colours.current_mut() = colour;
            }
            "sides" | "rd" | "ed" | "rs" | "td" | "ts" => self.material(place, keyword, words)?,
            // Refraction needs transmission, which has a warning of its own.
            "ir" => {}
            "f" | "fh" | "sph" | "cyl" | "cone" | "prism" | "ring" | "torus" => self.surface(place, keyword, words)?,
            "o" => self.object(place, words)?,
            "xf" => self.transform(place, words)?,
            "i" => self.include(place, words)?,
            "ies" => self.tally.luminaires += 1,
            _ if keyword.starts_with('#') => {}
            _ => self.unknown.add(keyword),
        }
        Ok(())
    }

    /// A colour; what says one that there is not, but in numbers, is the nearest that there is, counted.
    fn colour(&mut self, place: Place<'_>, keyword: &str, words: &[&str]) -> Result<Colour, FormatError> {
        let finite = |words: &[&str]| words.iter().map(|word| place.finite(word)).collect::<Result<Vec<f64>, _>>();
        let (colour, nearest) = match (keyword, words) {
            ("cxy", [x, y]) => {
                let (x, y) = (place.finite(x)?, place.finite(y)?);
                (Colour::new(x, y), Colour::nearest(x, y))
            }
            ("cct", [kelvin]) => (Colour::of_black_body(place.finite(kelvin)?), Colour::default()),
            ("cspec", [from, to, values @ ..]) if values.len() >= 2 => {
                let (from, to) = (place.finite(from)?, place.finite(to)?);
                (Colour::of_spectrum(from, to, &finite(values)?), Colour::default())
            }
            ("cmix", [_, _, ..]) if words.len().is_multiple_of(2) => {
                let part = |pair: &[&str]| Ok((place.finite(pair[0])?, *self.colours.get(place, pair[1])?));
                let parts = words.chunks_exact(2).map(part).collect::<Result<Vec<_>, FormatError>>()?;
                (Colour::mixture(&parts), Colour::default())
            }
            _ => return Err(place.bad(format!("{keyword} does not describe a colour"), EXPORT_AGAIN)),
        };
        self.tally.odd_colours += usize::from(colour.is_none());
        Ok(colour.unwrap_or(nearest))
    }

    fn material(&mut self, place: Place<'_>, keyword: &str, words: &[&str]) -> Result<(), FormatError> {
        let [value] = place.numbers(keyword, &mut words.iter().copied())?;
        let (share, colour) = ((0.0..=1.0).contains(&value), *self.colours.current());
        let material = self.mgf_materials.current_mut();
        match keyword {
            "sides" if value == 1.0 || value == 2.0 => material.double_sided = value == 2.0,
            "rd" if share => material.reflectance = (value, colour),
            "ed" if value >= 0.0 => material.emittance = (value, colour),
            "rs" if share => material.glossy = value > 0.0,
            "td" | "ts" if share => material.transmits = value > 0.0,
            "sides" => return Err(place.bad(format!("sides is {value}"), "give 1 or 2 sides")),
            "ed" => return Err(place.bad(format!("ed is {value}"), "give an emittance of 0 or more")),
            _ => return Err(place.bad(format!("{keyword} is {value}"), "give a share between 0 and 1")),
        }
        Ok(())
    }

    fn surface(&mut self, place: Place<'_>, keyword: &str, words: &[&str]) -> Result<(), FormatError> {
        let (vertices, segments) = (&self.vertices, self.segments);
        let statement = Statement { place, keyword, words, vertices, segments };
        let solid = if keyword == "f" || keyword == "fh" {
            let (face, cost) = statement.face()?;
            self.builder.budget.spend(cost, place.file, || place.name())?;
            let Some(face) = face else {
                self.tally.too_few_corners += 1;
                return Ok(());
            };
            face
        } else {
            let (solid, curved) = statement.solid()?;
            self.tally.curved_shapes += usize::from(curved);
            self.tally.curved_polygons += if curved { solid.polygons.len() } else { 0 };
            solid
        };
        self.add(place, solid)
    }

    /// Takes a shape to the world, in the current object and material; a curved one with the normals of the curve.
    fn add(&mut self, place: Place<'_>, mut solid: Solid) -> Result<(), FormatError> {
        self.builder.budget.spend(solid.corners() as u64, place.file, || place.name())?;
        let world = self.world();
        if world.matrix3.determinant() < 0.0 {
            solid.turn_over();
        }
        let surface = self.current_surface(place)?;
        let mut numbers = Vec::with_capacity(solid.positions.len());
        solid.normals.resize(solid.positions.len(), DVec3::ZERO);
        for (position, normal) in solid.positions.into_iter().zip(solid.normals) {
            let position_m = world.transform_point3(position);
            // Transforms of the format turn, and scale the same in all directions.
            let normal = (world.matrix3 * normal).normalize_or_zero();
            if !position_m.is_finite() {
                let value = format!("{position_m} in the world");
                return Err(FormatError::NotFinite { file: place.file.to_owned(), place: place.name(), value });
            }
            numbers.push(self.builder.position(surface, position_m));
            self.builder.corner(surface, normal, None);
        }
        for polygon in solid.polygons {
            self.builder.polygon(surface, polygon.into_iter().map(|i| numbers[i as usize]).collect());
        }
        Ok(())
    }

    fn current_surface(&mut self, place: Place<'_>) -> Result<SurfaceId, FormatError> {
        let mut node = None;
        for object in &mut self.objects {
            node = match object.node {
                None => Some(self.builder.node(&object.name, node, place.file, || place.name())?),
                known => known,
            };
            object.node = node;
        }
        let node = match (node, self.root) {
            (Some(node), _) | (None, Some(node)) => node,
            (None, None) => {
                let name = self.builder.name().to_owned();
                *self.root.insert(self.builder.node(&name, None, place.file, || place.name())?)
            }
        };
        let (name, material) = (self.mgf_materials.current_name(), self.mgf_materials.current());
        let material = self.materials.id(name, material, &mut self.builder);
        Ok(self.builder.surface(node, material))
    }

    fn object(&mut self, place: Place<'_>, words: &[&str]) -> Result<(), FormatError> {
        match words.first() {
            Some(name) => {
                self.check_nesting(place, self.objects.len())?;
                self.objects.push(OpenObject { name: (*name).to_owned(), node: None });
            }
            None if self.objects.pop().is_none() => return Err(unmatched(place, "o")),
            None => {}
        }
        Ok(())
    }

    fn transform(&mut self, place: Place<'_>, words: &[&str]) -> Result<(), FormatError> {
        let (cursor, own) = self.files.last().map(|file| (file.cursor, file.transforms)).unwrap_or_default();
        if !words.is_empty() {
            self.check_nesting(place, self.transforms.len())?;
            let open = self.opened(Transform::parse(place, words)?, cursor);
            self.transforms.push(open);
        } else if self.transforms.len() <= own {
            return Err(unmatched(place, "xf"));
        } else {
            self.close_transform(place.file)?;
        }
        Ok(())
    }

    fn include(&mut self, place: Place<'_>, words: &[&str]) -> Result<(), FormatError> {
        let Some((name, arguments)) = words.split_first() else {
            return Err(place.bad("i names no file", EXPORT_AGAIN));
        };
        let transform = Transform::parse(place, arguments)?;
        let open: Vec<&Rc<Source>> = self.files.iter().map(|file| &file.source).collect();
        let (source, bytes) = self.sources.include(place, name, &open)?;
        self.builder.budget.grow(bytes);
        self.open(source, Some(transform));
        Ok(())
    }

    fn check_nesting(&self, place: Place<'_>, depth: usize) -> Result<(), FormatError> {
        if depth < MAX_NESTING {
            return Ok(());
        }
        Err(place.bad(format!("more than {MAX_NESTING} are open within each other"), "close them"))
    }
}

fn unmatched(place: Place<'_>, keyword: &str) -> FormatError {
    place.bad(format!("this {keyword} closes what was not opened"), "remove the line, or open it before")
}
