//! A baked GLB read back as a [`BakedFile`].
//!
//! The file may have been through other tools: any component types, strides and transforms are taken, as long as the
//! attributes are there. Where nothing but one translation stands above the vertices, as this crate writes it, their
//! bits are kept.

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};

use super::accessor::{Accessor, Component};
use super::document::{Document, List};
use super::item::Item;
use super::node::{self, Placed};
use super::primitive;
use super::tally::{PRIMITIVE_COST, Tally};
use crate::{BakedFile, BakedFilePart, FormatError};

/// Types of colours and normals.
const ANY: [Component; 5] = [Component::F32, Component::I8, Component::U8, Component::I16, Component::U16];

/// Reads a baked `.glb` or `.gltf` whose bytes are given.
pub(crate) fn read_baked(path: &Path, bytes: Vec<u8>) -> Result<BakedFile, FormatError> {
    let document = Document::parse(path, bytes)?;
    let extras = document.root()?.child("asset")?.map(|asset| asset.child("extras")).transpose()?.flatten();
    let facts = extras.map(|extras| extras.child("umbrage")).transpose()?.flatten();
    let not_baked = || FormatError::NotBaked {
        file: document.file.clone(),
        place: "asset, extras".into(),
        what: "umbrage.exposure",
    };
    let facts = facts.ok_or_else(not_baked)?;
    let exposure_k = facts.number("exposure")?.ok_or_else(not_baked)?;

    let mut tally = Tally::default();
    let placed = node::hierarchy(&document, &mut tally)?;
    let origin_m =
        placed.iter().find(|node| node.item.get("mesh").is_some()).map_or(DVec3::ZERO, |node| node.world.translation);
    let mut parts = Vec::new();
    for node in &placed {
        let Some(index) = node.item.whole("mesh")? else { continue };
        let mesh = document.item(List::Meshes, index, &node.item.place)?;
        for (number, primitive) in mesh.children("primitives", "primitive")?.enumerate() {
            let place = format!("{}, {}, primitive {number}", node.item.place, mesh.place);
            let reader = PartReader { document: &document, node, mesh: &mesh, primitive: &primitive?, place };
            parts.push(reader.read(origin_m, &mut tally)?);
        }
    }
    let name = document.root()?.whole("scene")?.map(|scene| document.item(List::Scenes, scene, "the document"));
    let name = name.transpose()?.and_then(|scene| scene.name().map(str::to_owned)).unwrap_or_default();
    Ok(BakedFile { name, origin_m, parts, exposure_k, extras: facts.object().clone() })
}

/// A primitive, and where it stands.
struct PartReader<'a> {
    document: &'a Document,
    node: &'a Placed<'a>,
    mesh: &'a Item<'a>,
    primitive: &'a Item<'a>,
    place: String,
}

impl PartReader<'_> {
    fn read(&self, origin_m: DVec3, tally: &mut Tally) -> Result<BakedFilePart, FormatError> {
        let world = DAffine3 { translation: self.node.world.translation - origin_m, ..self.node.world };
        let positions = self.attribute("POSITION", &[3], &ANY)?;
        let normals = self.attribute("NORMAL", &[3], &ANY)?;
        let color = self.attribute("COLOR_0", &[3, 4], &ANY)?;
        let irradiance = self.attribute("_IRRADIANCE", &[3], &ANY)?;
        let count = positions.count;
        for accessor in [&normals, &color, &irradiance] {
            if accessor.count != count {
                let what = format!("has {} elements, and POSITION has {count}", accessor.count);
                let (file, place) = (self.document.file.clone(), accessor.place.clone());
                return Err(FormatError::BadProperty { file, place, what });
            }
        }
        tally.unfold(count.saturating_add(PRIMITIVE_COST), self.document, &self.place)?;

        let plain = world == DAffine3::IDENTITY;
        let turn = normal_matrix(&world);
        let mirrored = world.matrix3.determinant() < 0.0;
        let (material_name, base_color) = self.material()?;
        Ok(BakedFilePart {
            node_name: self.node.item.name().unwrap_or_default().to_owned(),
            name: self.mesh.name().unwrap_or_default().to_owned(),
            material_name,
            positions_m: self.all(&positions, 0.0, |p| {
                let moved = if plain { p.into() } else { world.transform_point3(p.into()) };
                moved.as_vec3().into()
            })?,
            normals: self.all(&normals, 0.0, |n| {
                let turned = if plain { n.into() } else { (turn * DVec3::from(n)).normalize_or_zero() };
                turned.as_vec3().into()
            })?,
            color: self.all(&color, 1.0, |c: [f64; 4]| c.map(|c| c.clamp(0.0, 1.0) as f32))?,
            base_color,
            irradiance: self.all(&irradiance, 0.0, |e: [f64; 3]| e.map(|e| e as f32))?,
            triangles: primitive::triangles(self.document, self.primitive, &self.place, count, mirrored, tally)?,
        })
    }

    /// An attribute that every baked primitive has.
    fn attribute(&self, key: &'static str, width: &[usize], types: &[Component]) -> Result<Accessor<'_>, FormatError> {
        let attributes = self.primitive.child("attributes")?;
        let index = attributes.map(|attributes| attributes.whole(key)).transpose()?.flatten();
        let index = index.ok_or_else(|| FormatError::NotBaked {
            file: self.document.file.clone(),
            place: self.place.clone(),
            what: key,
        })?;
        Accessor::open(self.document, index, &format!("{}, {key}", self.place), width, types)
    }

    /// All elements of an attribute, each made into what the part holds, which must be finite.
    fn all<const N: usize>(
        &self,
        accessor: &Accessor<'_>,
        fill: f64,
        make: impl Fn([f64; N]) -> [f32; N],
    ) -> Result<Vec<[f32; N]>, FormatError> {
        let one = |i| {
            let element = accessor.element::<N>(i, fill);
            let made = make(element);
            if element.iter().all(|e| e.is_finite()) && made.iter().all(|m| m.is_finite()) {
                return Ok(made);
            }
            Err(FormatError::NotFinite {
                file: self.document.file.clone(),
                place: format!("{}, vertex {i}", accessor.place),
                value: format!("{element:?}"),
            })
        };
        (0..accessor.count).map(one).collect()
    }

    /// Name and base colour of the primitive's material.
    fn material(&self) -> Result<(String, [f32; 4]), FormatError> {
        let white = [1.0; 4];
        let Some(index) = self.primitive.whole("material")? else { return Ok((String::new(), white)) };
        let material = self.document.item(List::Materials, index, &self.place)?;
        let base = match material.child("pbrMetallicRoughness")? {
            Some(metallic) => metallic.numbers::<4>("baseColorFactor")?,
            None => None,
        };
        let base = base.map_or(white, |base| base.map(|channel| channel.clamp(0.0, 1.0) as f32));
        Ok((material.name().unwrap_or_default().to_owned(), base))
    }
}

/// What turns normals with a surface: the inverse transpose, up to a positive factor.
fn normal_matrix(world: &DAffine3) -> DMat3 {
    let m = world.matrix3;
    let cofactors = DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if m.determinant() < 0.0 { cofactors * -1.0 } else { cofactors }
}
