//! A glTF's default scene as a [`Scene`].
//!
//! Every node of the scene is kept. Every primitive with triangles becomes a [`Surface`] of its own, once for every node
//! that shows its mesh, already in world space. Colours of vertices multiply the reflectance, as one colour for a primitive;
//! what is blended (`alphaMode` BLEND), and glass, blocks nothing and is left out. Units stay as glTF has them: metres, +Y up,
//! linear colours.

use std::path::Path;

use glam::{DAffine3, DVec2};
use umbrage::id::{MaterialId, NodeId};
use umbrage::scene::{Node, Rgb, Scene, Surface};

use super::document::{Document, List};
use super::item::Item;
use super::material::{Materials, Passing, SeenThrough, Shown};
use super::node::{self, Placed};
use super::primitive::Polygons;
use super::skin::{self, Pose};
use super::tally::Tally;
use super::texture::{Images, ShownTexture};
use super::{camera, lamp, morph, primitive};
use crate::beside::Folder;
use crate::{FormatError, LampUnits, ReadOptions, Warning};

/// Extensions that are read, that only concern what has a warning of its own, or that only add gloss to a surface, which is taken as diffuse anyway.
const KNOWN_EXTENSIONS: [&str; 24] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
];

/// Reads the default scene of a `.gltf` or `.glb` whose bytes are given, and whose buffers and images are in `folder`.
pub(crate) fn read(
    path: &Path,
    bytes: Vec<u8>,
    folder: &Folder,
    options: &ReadOptions,
) -> Result<(Scene, Vec<Warning>), FormatError> {
    let document = Document::parse(path, bytes, folder.clone())?;
    let mut tally = Tally::default();
    tally.unknown_extensions = unknown_extensions(&document)?;
    tally.animations = document.root()?.list("animations")?.len();
    let materials = Materials::read(&document, options, &mut tally)?;
    let mut reader = Reader {
        document: &document,
        options,
        tally,
        scene: Scene { name: scene_name(&document, path)?, ..Scene::default() },
        materials,
        images: Images::default(),
    };

    let placed = node::hierarchy(&document, &mut reader.tally)?;
    let worlds = skin::worlds(&placed, document.count(List::Nodes)?);
    let mut ids: Vec<NodeId> = Vec::with_capacity(placed.len());
    for node in &placed {
        let parent = node.parent.map(|parent| ids[parent]);
        let id = reader.node(node, parent, &worlds)?;
        match camera::of_node(&document, node, id) {
            Ok(camera) => reader.scene.cameras.extend(camera),
            Err(_) => reader.tally.bad_cameras += 1,
        }
        ids.push(id);
    }
    let extras = document.root()?.whole("scene")?.map(|scene| document.item(List::Scenes, scene, "the document"));
    reader.scene.extras = extras.transpose()?.and_then(|scene| scene.json("extras"));
    let asset = document.root()?.child("asset")?;
    if let Some(asset) = &asset {
        reader.scene.asset_extras = asset.json("extras");
        reader.scene.copyright = asset.text("copyright")?.map(str::to_owned);
    }
    reader.tally.capped_materials = reader.materials.capped_count();
    reader.scene.materials = reader.materials.all;
    reader.scene.images = reader.images.all;
    // The extension says candela and lux, and then emission is in cd/m2.
    reader.scene.photometric = options.lamp_units == LampUnits::Same && !reader.scene.lamps.is_empty();
    reader.tally.blender_lamps = blender_lamps(&document, &reader.scene, options)?;
    Ok((reader.scene, reader.tally.warnings(options.max_reflectance)))
}

/// What is being built, and from what.
struct Reader<'a> {
    document: &'a Document,
    options: &'a ReadOptions,
    tally: Tally,
    scene: Scene,
    materials: Materials,
    images: Images,
}

impl Reader<'_> {
    /// Adds a node and what it shows.
    fn node(
        &mut self,
        placed: &Placed<'_>,
        parent: Option<NodeId>,
        worlds: &[Option<DAffine3>],
    ) -> Result<NodeId, FormatError> {
        let item = &placed.item;
        self.tally.hidden_nodes += usize::from(!placed.visible);
        if placed.visible
            && let Some(lamp) = lamp::of_node(self.document, placed, self.options.lamp_units, &mut self.tally)?
        {
            self.scene.lamps.push(lamp);
        }
        let mesh = match item.whole("mesh")?.filter(|_| placed.visible) {
            Some(mesh) => Some(self.document.item(List::Meshes, mesh, &item.place)?),
            None => None,
        };
        let instances = match &mesh {
            Some(_) => node::instances(self.document, item, &mut self.tally)?,
            None => None,
        };
        let shown = mesh.as_ref().filter(|_| instances.is_none());
        let node = self.push_node(item.name(), parent, shown)?;
        self.scene.nodes[node].extras = item.json("extras");
        if let Some(mesh) = &mesh {
            let weights = morph::weights(item, mesh)?;
            // They are copied for each node that shows the mesh.
            self.tally.unfold(weights.len(), self.document, &item.place)?;
            match instances {
                None => {
                    let pose = Pose::of_node(self.document, placed, worlds, &mut self.tally)?;
                    self.mesh((mesh, &weights), &item.place, node, &pose)?;
                }
                // Each instance becomes a node below, as each gets a mesh of its own in the output.
                Some(instances) => {
                    for (number, instance) in instances.iter().enumerate() {
                        let below = self.push_node(None, Some(node), Some(mesh))?;
                        let place = format!("{}, instance {number}", item.place);
                        self.mesh((mesh, &weights), &place, below, &Pose::Rigid(placed.world * *instance))?;
                    }
                }
            }
        }
        Ok(node)
    }

    fn push_node(
        &mut self,
        name: Option<&str>,
        parent: Option<NodeId>,
        mesh: Option<&Item<'_>>,
    ) -> Result<NodeId, FormatError> {
        let mesh_name = mesh.and_then(Item::name);
        let mesh_extras = mesh.and_then(|mesh| mesh.json("extras"));
        if let Some(mesh) = mesh {
            // Long names and extras shown by many nodes take memory too.
            let length = mesh_name.map_or(0, str::len) + mesh_extras.as_ref().map_or(0, String::len);
            self.tally.unfold(length, self.document, &mesh.place)?;
        }
        let (name, mesh_name) = (name.map(str::to_owned), mesh_name.map(str::to_owned));
        Ok(self.scene.nodes.push_and_get_key(Node { name, parent, mesh_name, extras: None, mesh_extras }))
    }

    /// Adds the surfaces of a mesh that a node shows, its morph targets at these weights.
    fn mesh(
        &mut self,
        (mesh, weights): (&Item<'_>, &[f64]),
        shown_by: &str,
        node: NodeId,
        pose: &Pose,
    ) -> Result<(), FormatError> {
        for (number, primitive) in mesh.children("primitives", "primitive")?.enumerate() {
            let primitive = primitive?;
            let place = format!("{shown_by}, {}, primitive {number}", mesh.place);
            let polygons = primitive::polygons(self.document, &primitive, &place, (pose, weights), &mut self.tally)?;
            let Some(polygons) = polygons else { continue };
            let number = match primitive.whole("material")? {
                Some(index) => {
                    self.document.item(List::Materials, index, &place)?;
                    index
                }
                None => self.materials.default(),
            };
            let Some(made) = self.material(number, (&primitive, &place), &polygons)? else {
                self.tally.invisible_polygons += polygons.triangles.len();
                continue;
            };
            let surface = Surface {
                positions_m: polygons.positions_m,
                uvs: made.uvs,
                normals: polygons.normals,
                polygons: polygons.triangles.iter().map(|triangle| triangle.to_vec()).collect(),
                ..Surface::new(node, made.material)
            };
            match made.seen_through {
                Some(SeenThrough::Blended) => self.tally.blended_polygons += surface.polygons.len(),
                Some(SeenThrough::Glass) => self.tally.glass_polygons += surface.polygons.len(),
                None => {}
            }
            if made.seen_through.is_some() {
                self.scene.see_through.push(surface);
            } else {
                self.scene.surfaces.push(surface);
            }
        }
        Ok(())
    }

    /// The material of the scene for a primitive, and the places of its corners in the image that is seen on it: of its
    /// emission if it emits by one, else of its base colour. Nothing where it is invisible.
    fn material(
        &mut self,
        number: usize,
        primitive: (&Item<'_>, &str),
        polygons: &Polygons,
    ) -> Result<Option<Made>, FormatError> {
        let Self { document, tally, materials, images, .. } = self;
        let material = &materials.of_file[number];
        let tint = polygons.colour;
        let base = match &material.base {
            Some(texture) => {
                let of = (texture, material.base_color() * tint, material.has_alpha());
                images.shown(document, of, primitive, polygons, tally)?
            }
            None => None,
        };
        let emission = match &material.emission {
            Some(texture) => {
                images.shown(document, (texture, material.radiance(), false), primitive, polygons, tally)?
            }
            None => None,
        };
        let mean = |shown: &Option<ShownTexture>| shown.as_ref().map_or(Rgb::ONE, |shown| shown.mean);
        let (reflects, emits) = (mean(&base), mean(&emission));
        let does_emit = material.radiance() * emits != Rgb::ZERO;
        let (alpha, share, seen_through) = match material.passing(polygons.alpha, base.as_ref(), does_emit) {
            Passing::Invisible => return Ok(None),
            Passing::Blocks { alpha, emits } => (alpha, emits, None),
            Passing::SeenThrough { why, alpha } => (alpha, 1.0, Some(why)),
        };
        let seen = if does_emit { emission } else { base };
        let (texture, uvs) = seen.map_or((None, Vec::new()), |seen| (Some(seen.texture), seen.uvs));
        let material = materials.shown(number, Shown { reflects, tint, emits: share * emits, texture, alpha });
        Ok(Some(Made { material, uvs, seen_through }))
    }
}

/// What a primitive's material has become.
struct Made {
    material: MaterialId,
    uvs: Vec<DVec2>,
    seen_through: Option<SeenThrough>,
}

/// How many lamps are too bright by Blender's factor beside the surfaces that emit.
fn blender_lamps(document: &Document, scene: &Scene, options: &ReadOptions) -> Result<usize, FormatError> {
    let asset = document.root()?.child("asset")?;
    let generator = asset.as_ref().map(|asset| asset.text("generator")).transpose()?.flatten().unwrap_or_default();
    let beside_surfaces = scene.surfaces.iter().any(|surface| scene.materials[surface.material].emits());
    let doubtful = options.lamp_units == LampUnits::Same && beside_surfaces && generator.contains("Blender");
    Ok(if doubtful { scene.lamps.len() } else { 0 })
}

/// The default scene's name, else the file's without its ending.
fn scene_name(document: &Document, path: &Path) -> Result<String, FormatError> {
    let index = document.root()?.whole("scene")?.unwrap_or(0);
    if document.count(List::Scenes)? > 0
        && let Some(name) = document.item(List::Scenes, index, "the document")?.name()
    {
        return Ok(name.to_owned());
    }
    Ok(path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default())
}

/// The extensions that the file names and this reader does not know, and whether it requires them.
fn unknown_extensions(document: &Document) -> Result<Vec<(String, bool)>, FormatError> {
    let root = document.root()?;
    let mut unknown: Vec<(String, bool)> = Vec::new();
    for (key, required) in [("extensionsRequired", true), ("extensionsUsed", false)] {
        for name in root.list(key)?.iter().filter_map(|name| name.as_str()) {
            if !KNOWN_EXTENSIONS.contains(&name) {
                unknown.push((crate::text::shortened(name), required));
            }
        }
    }
    // Of those in both lists, the entry of the required one stays.
    unknown.sort_by(|a, b| (&a.0, !a.1).cmp(&(&b.0, !b.1)));
    unknown.dedup_by(|later, earlier| later.0 == earlier.0);
    Ok(unknown)
}
