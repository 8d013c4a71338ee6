//! The materials of an output file, with the images on them.
//!
//! All are `KHR_materials_unlit`, one-sided, without emission. Those that look alike and have one name are one, as they were
//! in the input; the images that are shown are in the file.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};
use umbrage::id::{ImageId, MaterialId, Table};
use umbrage::scene::{Alpha, Image, Material, Rgb, Scene, Texture, Wrap};

use super::write::put_name;
use super::write_buffer::WriteBuffer;

/// What materials refer to, and themselves.
#[derive(Debug, Default)]
pub(super) struct Materials {
    /// The file's number of each material of the scene.
    pub(super) number_of: Table<MaterialId, usize>,
    materials: Vec<Value>,
    textures: Vec<Value>,
    samplers: Vec<Value>,
    images: Vec<Value>,
    image_of: BTreeMap<ImageId, usize>,
}

impl Materials {
    /// The materials of a scene with their base colours; the images on those that are `shown` are added to the buffer.
    pub(super) fn new(
        scene: &Scene,
        base_colours: &Table<MaterialId, Rgb>,
        shown: &Table<MaterialId, bool>,
        buffer: &mut WriteBuffer,
    ) -> Self {
        let mut all = Self::default();
        let mut known: BTreeMap<String, usize> = BTreeMap::new();
        for ((id, material), &base) in scene.materials.iter_enumerated().zip(base_colours) {
            let texture = material.look.texture.filter(|_| shown[id]);
            let texture = texture.map(|texture| all.texture(&texture, &scene.images, buffer));
            let value = unlit(material, base, texture);
            let next = all.materials.len();
            let number = *known.entry(value.to_string()).or_insert(next);
            if number == next {
                all.materials.push(value);
            }
            all.number_of.push(number);
        }
        all
    }

    /// Puts all of them into a document.
    pub(super) fn put_into(self, document: &mut Value) {
        let lists = [
            ("materials", self.materials),
            ("textures", self.textures),
            ("samplers", self.samplers),
            ("images", self.images),
        ];
        for (key, list) in lists {
            if !list.is_empty() {
                document[key] = json!(list);
            }
        }
    }

    /// The number of a texture.
    fn texture(&mut self, texture: &Texture, images: &Table<ImageId, Image>, buffer: &mut WriteBuffer) -> usize {
        let number = self.images.len();
        let image = *self.image_of.entry(texture.image).or_insert_with(|| {
            let image = &images[texture.image];
            let mut value = json!({"bufferView": buffer.file(&image.bytes), "mimeType": media_type(&image.bytes)});
            put_name(&mut value, image.name.as_deref());
            self.images.push(value);
            number
        });
        let [u, v] = texture.wrap.map(wrap);
        let mut sampler = json!({"wrapS": u, "wrapT": v});
        for (key, filter) in ["magFilter", "minFilter"].into_iter().zip(texture.filters) {
            if let Some(filter) = filter {
                sampler[key] = json!(filter);
            }
        }
        let sampler = number_in(&mut self.samplers, sampler);
        number_in(&mut self.textures, json!({"source": image, "sampler": sampler}))
    }
}

/// The number of a value in a list, to which it is added if it is new.
fn number_in(list: &mut Vec<Value>, value: Value) -> usize {
    list.iter().position(|known| *known == value).unwrap_or_else(|| {
        list.push(value);
        list.len() - 1
    })
}

fn media_type(bytes: &[u8]) -> &'static str {
    if bytes.starts_with(&[0xff, 0xd8]) { "image/jpeg" } else { "image/png" }
}

fn wrap(wrap: Wrap) -> u32 {
    match wrap {
        Wrap::Repeat => 10_497,
        Wrap::Mirror => 33_648,
        Wrap::Clamp => 33_071,
    }
}

fn unlit(material: &Material, base: Rgb, texture: Option<usize>) -> Value {
    let [red, green, blue] = base.to_array();
    let alpha = match material.look.alpha {
        Alpha::Opaque => 1.0,
        Alpha::Mask { alpha, .. } | Alpha::Blend { alpha } => alpha,
    };
    let mut out = json!({
        "pbrMetallicRoughness": {
            "baseColorFactor": [red, green, blue, alpha],
            // What the extension advises for renderers that do not know it.
            "metallicFactor": 0.0,
            "roughnessFactor": 1.0,
        },
        "extensions": {"KHR_materials_unlit": {}},
    });
    put_name(&mut out, Some(&material.name));
    if let Some(texture) = texture {
        out["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": texture});
    }
    match material.look.alpha {
        Alpha::Opaque => {}
        Alpha::Mask { cutoff, .. } => {
            out["alphaMode"] = json!("MASK");
            out["alphaCutoff"] = json!(cutoff);
        }
        Alpha::Blend { .. } => {
            out["alphaMode"] = json!("BLEND");
            // Nobody lit its two sides apart.
            out["doubleSided"] = json!(material.double_sided);
        }
    }
    if let Some(extras) = material.look.extras.as_deref().and_then(value_of) {
        out["extras"] = extras;
    }
    if material.shines() {
        // What is seen of an image that emits is that image alone.
        let (radiance, reflectance) = match material.look.texture {
            Some(texture) => (texture.factor, Rgb::ZERO),
            None => (material.shown_radiance(), material.reflectance),
        };
        let facts = json!({"radiance": radiance.to_array(), "reflectance": reflectance.to_array()});
        put_facts(&mut out["extras"], facts);
    }
    out
}

/// The value of a JSON text that was carried along.
pub(super) fn value_of(text: &str) -> Option<Value> {
    serde_json::from_str(text).ok()
}

/// Puts what this crate has to say beside what others have said in `extras`.
pub(super) fn put_facts(extras: &mut Value, facts: Value) {
    if !extras.is_object() {
        *extras = Value::Object(Map::new());
    }
    extras["umbrage"] = facts;
}
