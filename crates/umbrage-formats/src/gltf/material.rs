//! Materials: glTF's base colour becomes a reflectance, its emission a radiance.
//!
//! Everything is taken as diffuse: the metallic factor is ignored (files leave it at 1), so are gloss, clear coats and
//! their like. The reflectance is capped in each channel, since a white closed room has no solution.

use umbrage::scene::{Material, Rgb};

use super::document::{Document, List};
use super::item::Item;
use super::tally::Tally;
use crate::FormatError;

/// Texture slots by the object that holds them.
const TEXTURES: [(&str, &[&str]); 3] = [
    ("", &["emissiveTexture"]),
    ("pbrMetallicRoughness", &["baseColorTexture"]),
    ("KHR_materials_pbrSpecularGlossiness", &["diffuseTexture"]),
];

/// All materials of a document, in order, named by number if they have no name.
pub(super) fn materials(
    document: &Document,
    max_reflectance: f64,
    tally: &mut Tally,
) -> Result<Vec<Material>, FormatError> {
    let all = 0..document.count(List::Materials)?;
    all.map(|index| {
        let item = document.item(List::Materials, index, "the document")?;
        let name = item.name().map_or_else(|| format!("material {index}"), str::to_owned);
        read(&item, name, max_reflectance, tally)
    })
    .collect()
}

/// Whether a material blocks nothing: it is blended (`alphaMode` BLEND), and not opaque all the same. Exporters write BLEND
/// for much that has neither an alpha below 1 nor a texture that could have one.
pub(super) fn is_transparent(item: &Item<'_>) -> Result<bool, FormatError> {
    if item.text("alphaMode")? != Some("BLEND") {
        return Ok(false);
    }
    let metallic = item.child("pbrMetallicRoughness")?;
    let glossy = item.extension("KHR_materials_pbrSpecularGlossiness")?;
    for (holder, factor, texture) in
        [(glossy, "diffuseFactor", "diffuseTexture"), (metallic, "baseColorFactor", "baseColorTexture")]
    {
        let Some(holder) = holder else { continue };
        let [.., alpha] = holder.numbers::<4>(factor)?.unwrap_or([1.0; 4]);
        if alpha < 1.0 || holder.get(texture).is_some() {
            return Ok(true);
        }
    }
    Ok(false)
}

/// What glTF gives a primitive without a material: white, here up to the cap.
pub(super) fn default(max_reflectance: f64, tally: &mut Tally) -> Material {
    Material::diffuse("default", capped(Rgb::ONE, max_reflectance, tally))
}

fn read(item: &Item<'_>, name: String, max_reflectance: f64, tally: &mut Tally) -> Result<Material, FormatError> {
    let metallic = item.child("pbrMetallicRoughness")?;
    let glossy = item.extension("KHR_materials_pbrSpecularGlossiness")?;
    let base = match (&glossy, &metallic) {
        (Some(glossy), _) => colour::<4>(glossy, "diffuseFactor")?,
        (None, Some(metallic)) => colour::<4>(metallic, "baseColorFactor")?,
        (None, None) => None,
    };
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

    for (holder, slots) in TEXTURES {
        let holder = match holder {
            "" => Some(item.clone()),
            "pbrMetallicRoughness" => metallic.clone(),
            _ => glossy.clone(),
        };
        tally.textures += slots.iter().filter(|slot| holder.as_ref().is_some_and(|h| h.get(slot).is_some())).count();
    }
    tally.masked_materials += usize::from(item.text("alphaMode")? == Some("MASK"));

    let reflectance = capped(base.unwrap_or(Rgb::ONE), max_reflectance, tally);
    Ok(Material { name, reflectance, radiance, double_sided: item.flag("doubleSided")? })
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

/// A material times the colour of the vertices.
pub(super) fn tinted(material: &Material, colour: Rgb) -> Material {
    Material { reflectance: material.reflectance * colour, ..material.clone() }
}

fn capped(colour: Rgb, max_reflectance: f64, tally: &mut Tally) -> Rgb {
    let cap = Rgb::splat(max_reflectance.clamp(0.0, 1.0));
    tally.capped_materials += usize::from(colour.cmpgt(cap).any());
    colour.min(cap)
}
