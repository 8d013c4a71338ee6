//! A baked GLB read back as a [`BakedFile`].
//!
//! The file may have been through other tools: any component types, strides and transforms are taken, as long as the
//! attributes are there. Where nothing but one translation stands above the vertices, as this crate writes it, their
//! bits are kept.

use std::path::Path;

use glam::{DAffine3, DVec3};
use umbrage::id::NodeId;
use umbrage::scene::{Camera, Lens};

use super::accessor::{Accessor, Component};
use super::base_texture::BaseTexture;
use super::camera;
use super::document::{Document, List};
use super::item::Item;
use super::node::{self, Placed};
use super::primitive;
use super::tally::{PRIMITIVE_COST, Tally};
use super::write::PHOTOMETRIC;
use crate::beside::Folder;
use crate::{BakedCamera, BakedEmission, BakedFile, BakedFilePart, FormatError};

/// Types of colours and normals.
const ANY: [Component; 5] = [Component::F32, Component::I8, Component::U8, Component::I16, Component::U16];

/// Reads a baked `.glb` or `.gltf` whose bytes are given.
pub(crate) fn read_baked(path: &Path, bytes: Vec<u8>) -> Result<BakedFile, FormatError> {
    let document = Document::parse(path, bytes, Folder::of(path, None))?;
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
            let primitive = primitive?;
            if is_passed_on(&document, &primitive, &place)? {
                continue;
            }
            let reader = PartReader { document: &document, node, mesh: &mesh, primitive: &primitive, place };
            parts.push(reader.read(origin_m, &mut tally)?);
        }
    }
    let name = document.root()?.whole("scene")?.map(|scene| document.item(List::Scenes, scene, "the document"));
    let name = name.transpose()?.and_then(|scene| scene.name().map(str::to_owned)).unwrap_or_default();
    let mut images = vec![Vec::new(); document.count(List::Images)?];
    for texture in parts.iter().filter_map(|part: &BakedFilePart| part.texture) {
        if images[texture.image].is_empty() {
            images[texture.image] = document.image(texture.image, "a base colour texture")?;
        }
    }
    let mut cameras = Vec::new();
    for (number, node) in placed.iter().enumerate() {
        cameras.extend(
            camera::of_node(&document, node, NodeId::from(number))?.and_then(|camera| perspective(camera, &node.item)),
        );
    }
    let photometric = facts.get("units").is_some_and(|units| units == PHOTOMETRIC);
    let extras = facts.object().clone();
    Ok(BakedFile { name, origin_m, parts, cameras, images, exposure_k, photometric, extras })
}

/// Whether a primitive took no part in the bake: it has no irradiance, and is blended or says so.
fn is_passed_on(document: &Document, primitive: &Item<'_>, place: &str) -> Result<bool, FormatError> {
    let attributes = primitive.child("attributes")?;
    if attributes.is_some_and(|attributes| attributes.get("_IRRADIANCE").is_some()) {
        return Ok(false);
    }
    let facts = primitive.get("extras").and_then(|extras| extras.get("umbrage"));
    if facts.and_then(|facts| facts.get("takes_part")).is_some_and(|part| part == false) {
        return Ok(true);
    }
    let Some(material) = primitive.whole("material")? else { return Ok(false) };
    Ok(document.item(List::Materials, material, place)?.text("alphaMode")? == Some("BLEND"))
}

/// A camera for a picture: those that project in parallel are no use.
fn perspective(camera: Camera, node: &Item<'_>) -> Option<BakedCamera> {
    let Lens::Perspective { fov_y_rad, .. } = camera.lens else { return None };
    let axes = camera.to_world.matrix3;
    Some(BakedCamera {
        name: node.name().map(str::to_owned).or(camera.name).unwrap_or_default(),
        eye_m: camera.to_world.translation,
        ahead: -axes.z_axis.normalize_or_zero(),
        up: axes.y_axis.normalize_or_zero(),
        fov_y_deg: fov_y_rad.to_degrees(),
    })
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
        let material = self.material()?;
        let uvs = match &material.texture {
            Some(texture) => Some(self.coordinates(texture.set)?),
            None => None,
        };
        for accessor in [&normals, &color, &irradiance].into_iter().chain(&uvs) {
            if accessor.count != count {
                let what = format!("has {} elements, and POSITION has {count}", accessor.count);
                let (file, place) = (self.document.file.clone(), accessor.place.clone());
                return Err(FormatError::BadProperty { file, place, what });
            }
        }
        tally.unfold(count.saturating_add(PRIMITIVE_COST), self.document, &self.place)?;

        let plain = world == DAffine3::IDENTITY;
        let turn = node::normal_matrix(&world);
        let mirrored = world.matrix3.determinant() < 0.0;
        let uvs = match (&uvs, &material.texture) {
            (Some(uvs), Some(texture)) => self.all(uvs, 0.0, |uv| texture.place(uv).as_vec2().into())?,
            _ => Vec::new(),
        };
        Ok(BakedFilePart {
            node_name: self.node.item.name().unwrap_or_default().to_owned(),
            name: self.mesh.name().unwrap_or_default().to_owned(),
            material_name: material.name,
            positions_m: self.all(&positions, 0.0, |p| {
                let moved = if plain { p.into() } else { world.transform_point3(p.into()) };
                moved.as_vec3().into()
            })?,
            normals: self.all(&normals, 0.0, |n| {
                let turned = if plain { n.into() } else { (turn * DVec3::from(n)).normalize_or_zero() };
                turned.as_vec3().into()
            })?,
            color: self.all(&color, 1.0, |c: [f64; 4]| c.map(|c| c.clamp(0.0, 1.0) as f32))?,
            base_color: material.base_color,
            cutoff: material.cutoff.filter(|_| material.texture.is_some()),
            texture: material.texture.map(|texture| texture.texture),
            uvs,
            emission: material.emission,
            irradiance: self.all(&irradiance, 0.0, |e: [f64; 3]| e.map(|e| e as f32))?,
            triangles: primitive::triangles(self.document, self.primitive, &self.place, count, mirrored, tally)?,
        })
    }

    /// An attribute that every baked primitive has.
    fn attribute(&self, key: &'static str, width: &[usize], types: &[Component]) -> Result<Accessor<'_>, FormatError> {
        let index = self.index(key)?.ok_or_else(|| FormatError::NotBaked {
            file: self.document.file.clone(),
            place: self.place.clone(),
            what: key,
        })?;
        Accessor::open(self.document, index, &format!("{}, {key}", self.place), width, types)
    }

    /// The texture coordinates of a set, which a material with a texture needs.
    fn coordinates(&self, set: usize) -> Result<Accessor<'_>, FormatError> {
        let key = format!("TEXCOORD_{set}");
        let index =
            self.index(&key)?.ok_or_else(|| self.primitive.bad(&key, "is missing, and its texture needs it"))?;
        Accessor::open(self.document, index, &format!("{}, {key}", self.place), &[2], &ANY)
    }

    fn index(&self, key: &str) -> Result<Option<usize>, FormatError> {
        let attributes = self.primitive.child("attributes")?;
        Ok(attributes.map(|attributes| attributes.whole(key)).transpose()?.flatten())
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

    /// The primitive's material.
    fn material(&self) -> Result<Material, FormatError> {
        let white = [1.0; 4];
        let Some(index) = self.primitive.whole("material")? else {
            return Ok(Material {
                name: String::new(),
                base_color: white,
                texture: None,
                cutoff: None,
                emission: None,
            });
        };
        let material = self.document.item(List::Materials, index, &self.place)?;
        let base = match material.child("pbrMetallicRoughness")? {
            Some(metallic) => metallic.numbers::<4>("baseColorFactor")?,
            None => None,
        };
        let base = base.map_or(white, |base| base.map(|channel| channel.clamp(0.0, 1.0) as f32));
        let cutoff = match material.text("alphaMode")? {
            // The texture's alpha is multiplied with that of the base colour.
            Some("MASK") => Some(material.number("alphaCutoff")?.unwrap_or(0.5) as f32 / base[3]),
            _ => None,
        };
        Ok(Material {
            name: material.name().unwrap_or_default().to_owned(),
            base_color: base,
            texture: BaseTexture::of(self.document, &material)?,
            cutoff,
            emission: emission(&material)?,
        })
    }
}

/// What a part takes over from its material.
struct Material {
    name: String,
    base_color: [f32; 4],
    texture: Option<BaseTexture>,
    /// The least alpha of the texture that is shown.
    cutoff: Option<f32>,
    emission: Option<BakedEmission>,
}

/// What the writer left in the extras of an emitter.
fn emission(material: &Item<'_>) -> Result<Option<BakedEmission>, FormatError> {
    let Some(extras) = material.get("extras").filter(|extras| extras.is_object()) else { return Ok(None) };
    let extras = Item::new(material.file, format!("{}, extras", material.place), extras)?;
    let Some(facts) = extras.child("umbrage")? else { return Ok(None) };
    let (radiance, reflectance) = (facts.numbers::<3>("radiance")?, facts.numbers::<3>("reflectance")?);
    Ok(radiance.zip(reflectance).map(|(radiance, reflectance)| BakedEmission { radiance, reflectance }))
}
