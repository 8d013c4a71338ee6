//! Materials: glTF's base colour becomes a reflectance, its emission a radiance.
//!
//! Everything is taken as diffuse: the metallic factor is ignored (files leave it at 1), so are gloss, clear coats and
//! their like. The reflectance is capped in each channel, since a white closed room has no solution.
//!
//! What a textured material reflects, or emits, depends on the part of the image that a primitive shows, and on the colours
//! of its vertices. So a material of the file becomes a material of the scene for each different outcome; the first takes
//! its number, and all have its name.

use std::collections::BTreeMap;

use umbrage::id::{MaterialId, Table};
use umbrage::scene::{Alpha, Look, Material, Rgb, Texture};

use super::base_texture::BaseTexture;
use super::document::{Document, List};
use super::item::Item;
use super::primitive::VertexAlpha;
use super::tally::Tally;
use super::texture::ShownTexture;
use crate::{FormatError, ReadOptions};

/// What glTF gives a mask that says nothing.
const DEFAULT_CUTOFF: f64 = 0.5;
/// What transmits at least this share of the light blocks nothing.
const GLASS: f64 = 0.5;

/// Why a material blocks nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum SeenThrough {
    /// It is blended (`alphaMode` BLEND).
    Blended,
    /// It transmits most of the light (`KHR_materials_transmission`).
    Glass,
}

/// A material of the file.
#[derive(Debug)]
pub(super) struct GltfMaterial {
    /// As the file has it, without textures; not capped.
    plain: Material,
    /// The texture of its base colour.
    pub(super) base: Option<BaseTexture>,
    /// The texture of its emission.
    pub(super) emission: Option<BaseTexture>,
    /// Whether it transmits most of the light.
    is_glass: bool,
    /// Whether its base colour is to have a texture, whether that can be had or not.
    names_texture: bool,
}

/// What alpha makes of a material on one primitive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Passing {
    /// It blocks light. `emits` is the share of its emission that is seen: an emitter that is blended gives alpha times its light.
    Blocks { alpha: Alpha, emits: f64 },
    /// Light passes through unchanged.
    SeenThrough { why: SeenThrough, alpha: Alpha },
    /// Nothing of it is seen anywhere.
    Invisible,
}

impl GltfMaterial {
    /// Whether the alpha of its image says what is seen of it.
    pub(super) fn has_alpha(&self) -> bool {
        self.plain.look.alpha != Alpha::Opaque
    }

    /// What light does, where its vertices have this alpha and its base colour this texture; `emits` says whether it emits there.
    pub(super) fn passing(&self, vertices: VertexAlpha, base: Option<&ShownTexture>, emits: bool) -> Passing {
        let blocks = |alpha| Passing::Blocks { alpha, emits: 1.0 };
        match self.plain.look.alpha {
            Alpha::Opaque => blocks(Alpha::Opaque),
            Alpha::Mask { alpha, cutoff } if alpha * vertices.most < cutoff => Passing::Invisible,
            Alpha::Mask { alpha, cutoff } => blocks(Alpha::Mask { alpha, cutoff }),
            Alpha::Blend { .. } if self.is_glass && emits => blocks(Alpha::Opaque),
            alpha @ Alpha::Blend { .. } if self.is_glass => Passing::SeenThrough { why: SeenThrough::Glass, alpha },
            Alpha::Blend { alpha } if alpha * vertices.most == 0.0 => Passing::Invisible,
            // Exporters write BLEND for much that has neither an alpha below 1 nor a texture that has one.
            Alpha::Blend { alpha } => {
                let may_pass = base.map_or(self.names_texture, |base| base.has_alpha);
                let is_solid = alpha * vertices.least >= 1.0 && !may_pass;
                let alpha = alpha * vertices.mean;
                match (is_solid, emits) {
                    (true, _) => blocks(Alpha::Opaque),
                    (false, true) => {
                        let emits = alpha * base.map_or(1.0, |base| base.opacity);
                        Passing::Blocks { alpha: Alpha::Opaque, emits }
                    }
                    (false, false) => Passing::SeenThrough { why: SeenThrough::Blended, alpha: Alpha::Blend { alpha } },
                }
            }
        }
    }

    /// What it emits without texture, in W/(m2 sr).
    pub(super) fn radiance(&self) -> Rgb {
        self.plain.radiance
    }

    /// Its base colour without texture.
    pub(super) fn base_color(&self) -> Rgb {
        self.plain.reflectance
    }
}

/// What of a material is different from primitive to primitive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown {
    /// What its texture multiplies the base colour with.
    pub(super) reflects: Rgb,
    /// What the colour of the vertices multiplies the reflectance with.
    pub(super) tint: Rgb,
    /// What the emission is multiplied with.
    pub(super) emits: Rgb,
    /// What is seen on it.
    pub(super) texture: Option<Texture>,
    /// How it lets through what is behind it.
    pub(super) alpha: Alpha,
}

/// A material of the file on a primitive, as bits: its number, what it reflects and emits, the image on it, its alpha where it is blended.
type Outcome = (usize, [u64; 6], Option<usize>, Option<u64>);

/// The materials of the file, and those of the scene that they have become.
#[derive(Debug)]
pub(super) struct Materials {
    pub(super) of_file: Vec<GltfMaterial>,
    /// Those of the scene, the file's first.
    pub(super) all: Table<MaterialId, Material>,
    /// By the file's number and the bits of what is different.
    known: BTreeMap<Outcome, MaterialId>,
    /// The material of the scene that each of the file's becomes first, until it has.
    free: Vec<Option<MaterialId>>,
    /// Whether each of the file's reflects more than the cap somewhere.
    capped: Vec<bool>,
    cap: Rgb,
    default: Option<usize>,
}

impl Materials {
    /// All materials of a document, in order, named by number if they have no name.
    pub(super) fn read(document: &Document, options: &ReadOptions, tally: &mut Tally) -> Result<Self, FormatError> {
        let cap = Rgb::splat(options.max_reflectance.clamp(0.0, 1.0));
        let mut of_file = Vec::new();
        for index in 0..document.count(List::Materials)? {
            let item = document.item(List::Materials, index, "the document")?;
            let name = item.name().map_or_else(|| format!("material {index}"), str::to_owned);
            let mut material = read(document, &item, name, tally)?;
            if options.dark.contains(&material.plain.name) {
                material.plain.radiance = Rgb::ZERO;
                material.emission = None;
            }
            of_file.push(material);
        }
        let plain = |material: &GltfMaterial| Material {
            reflectance: material.plain.reflectance.min(cap),
            ..material.plain.clone()
        };
        let all: Table<MaterialId, Material> = of_file.iter().map(plain).collect();
        let free = all.keys().map(Some).collect();
        let exceeds = |material: &GltfMaterial| material.base.is_none() && material.plain.reflectance.cmpgt(cap).any();
        let capped = of_file.iter().map(exceeds).collect();
        Ok(Self { free, capped, of_file, all, known: BTreeMap::new(), cap, default: None })
    }

    /// The number of what glTF gives a primitive without a material: white, here up to the cap.
    pub(super) fn default(&mut self) -> usize {
        *self.default.get_or_insert_with(|| {
            let plain = Material::diffuse("default", Rgb::ONE);
            let first = Material { reflectance: self.cap, ..plain.clone() };
            self.free.push(Some(self.all.push_and_get_key(first)));
            self.capped.push(plain.reflectance.cmpgt(self.cap).any());
            self.of_file.push(GltfMaterial {
                plain,
                base: None,
                emission: None,
                is_glass: false,
                names_texture: false,
            });
            self.of_file.len() - 1
        })
    }

    /// The material of the scene for a material of the file as a primitive shows it.
    pub(super) fn shown(&mut self, number: usize, shown: Shown) -> MaterialId {
        let Shown { reflects, tint, emits, texture, alpha } = shown;
        let bits = [reflects * tint, emits].map(|colour| colour.to_array().map(f64::to_bits));
        let blended = match alpha {
            Alpha::Blend { alpha } => Some(alpha.to_bits()),
            Alpha::Opaque | Alpha::Mask { .. } => None,
        };
        let bits = [bits[0], bits[1]].as_flattened().try_into().unwrap_or([0; 6]);
        let key = (number, bits, texture.map(|t| t.image.index()), blended);
        if let Some(&known) = self.known.get(&key) {
            return known;
        }
        let plain = &self.of_file[number].plain;
        let uncapped = plain.reflectance * reflects;
        self.capped[number] |= uncapped.cmpgt(self.cap).any();
        let material = Material {
            reflectance: uncapped.min(self.cap) * tint,
            radiance: plain.radiance * emits,
            look: Look { texture, alpha, ..plain.look.clone() },
            ..plain.clone()
        };
        let id = match self.free[number].take() {
            Some(first) => {
                self.all[first] = material;
                first
            }
            None => self.all.push_and_get_key(material),
        };
        self.known.insert(key, id);
        id
    }

    /// How many of the file's reflect more than the cap somewhere.
    pub(super) fn capped_count(&self) -> usize {
        self.capped.iter().filter(|capped| **capped).count()
    }
}

/// The share of the light that a material transmits, by its factor alone: of its texture nothing is known here. What its
/// volume swallows (`KHR_materials_volume`) is not counted.
fn transmission(item: &Item<'_>) -> Result<f64, FormatError> {
    let Some(extension) = item.extension("KHR_materials_transmission")? else { return Ok(0.0) };
    Ok(extension.number("transmissionFactor")?.unwrap_or(0.0).clamp(0.0, 1.0))
}

fn read(document: &Document, item: &Item<'_>, name: String, tally: &mut Tally) -> Result<GltfMaterial, FormatError> {
    let metallic = item.child("pbrMetallicRoughness")?;
    let glossy = item.extension("KHR_materials_pbrSpecularGlossiness")?;
    let (holder, factor, slot) = match (glossy, metallic) {
        (Some(glossy), _) => (Some(glossy), "diffuseFactor", "diffuseTexture"),
        (None, metallic) => (metallic, "baseColorFactor", "baseColorTexture"),
    };
    let (mut base, mut alpha, mut texture) = (Rgb::ONE, 1.0, None);
    let names_texture = holder.as_ref().is_some_and(|holder| holder.get(slot).is_some());
    if let Some(holder) = &holder {
        if let Some([.., a]) = holder.numbers::<4>(factor)? {
            alpha = a.clamp(0.0, 1.0);
        }
        base = colour::<4>(holder, factor)?.unwrap_or(base);
        texture = usable(BaseTexture::in_slot(document, holder, slot), tally);
    }
    let emission = colour::<3>(item, "emissiveFactor")?.unwrap_or(Rgb::ZERO);
    let strength = match item.extension("KHR_materials_emissive_strength")? {
        Some(extension) => {
            let strength = extension.number("emissiveStrength")?.unwrap_or(1.0);
            if strength < 0.0 {
                return Err(extension.bad("emissiveStrength", format!("is {strength}, and should not be negative")));
            }
            strength
        }
        None => 1.0,
    };
    let radiance = emission * strength;
    if !radiance.is_finite() {
        return Err(item.bad("emissiveFactor", "is too large"));
    }
    let transmission = transmission(item)?;
    let mode = item.text("alphaMode")?;
    let is_glass = transmission >= GLASS && mode != Some("BLEND");
    tally.opaque_glass += usize::from(transmission > 0.0 && transmission < GLASS && mode != Some("BLEND"));
    let alpha = match mode {
        Some("BLEND") => Alpha::Blend { alpha },
        // What is not transmitted is seen of it.
        _ if is_glass => Alpha::Blend { alpha: 1.0 - transmission },
        Some("MASK") => {
            let cutoff = item.number("alphaCutoff")?.unwrap_or(DEFAULT_CUTOFF).max(0.0);
            Alpha::Mask { alpha, cutoff }
        }
        _ => Alpha::Opaque,
    };
    tally.masked_materials += usize::from(matches!(alpha, Alpha::Mask { .. }));
    let emission = (radiance != Rgb::ZERO)
        .then(|| usable(BaseTexture::in_slot(document, item, "emissiveTexture"), tally))
        .flatten();
    let look = Look { alpha, extras: item.json("extras"), ..Look::default() };
    let plain = Material { radiance, double_sided: item.flag("doubleSided")?, look, ..Material::diffuse(name, base) };
    Ok(GltfMaterial { plain, base: texture, emission, is_glass, names_texture })
}

/// A texture, unless something is wrong with it, or its image is only there in a format that is not read.
fn usable(texture: Result<Option<BaseTexture>, FormatError>, tally: &mut Tally) -> Option<BaseTexture> {
    texture.unwrap_or_else(|why| {
        tally.texture_ignored(why.to_string());
        None
    })
}

/// A colour of three channels, or of four of which the last is alpha.
fn colour<const N: usize>(item: &Item<'_>, key: &str) -> Result<Option<Rgb>, FormatError> {
    let Some(channels) = item.numbers::<N>(key)? else { return Ok(None) };
    let colour = Rgb::from_slice(&channels);
    if colour.min_element() < 0.0 {
        return Err(item.bad(key, format!("is {colour}, and should not be negative")));
    }
    Ok(Some(colour))
}
