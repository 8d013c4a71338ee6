//! Materials: the diffuse part of what MGF says, as materials of the scene.
//!
//! A material may be changed after it has been used, and names may be used again, so what a surface gets is the material
//! as it stands at that line: one material of the scene for each name and each set of values.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use umbrage::id::MaterialId;
use umbrage::scene::{Material, Rgb};

use super::colour::Colour;
use crate::builder::SceneBuilder;

/// The name of a material that has none.
const UNNAMED: &str = "unnamed";

/// A material context.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MgfMaterial {
    /// `rd`: photometric reflectance, 0 to 1, and its colour.
    pub(super) reflectance: (f64, Colour),
    /// `ed`: emittance in lm/m2, and its colour.
    pub(super) emittance: (f64, Colour),
    pub(super) double_sided: bool,
    /// Whether `rs` is above 0.
    pub(super) glossy: bool,
    /// Whether `td` or `ts` is above 0.
    pub(super) transmits: bool,
}

impl Default for MgfMaterial {
    /// Two-sided and black, as MGF has it.
    fn default() -> Self {
        let black = (0.0, Colour::default());
        Self { reflectance: black, emittance: black, double_sided: true, glossy: false, transmits: false }
    }
}

/// The materials of the scene, and what is counted of them.
#[derive(Debug, Default)]
pub(super) struct Materials {
    by_values: BTreeMap<(String, [u64; 6], [bool; 3]), MaterialId>,
    of_name: BTreeMap<String, usize>,
    pub(super) glossy: usize,
    pub(super) transmitting: usize,
    pub(super) out_of_gamut: usize,
}

impl Materials {
    /// The scene's material for a context as it stands. The second of a name is called `name (2)`, and so on.
    pub(super) fn id(&mut self, name: Option<&str>, material: &MgfMaterial, builder: &mut SceneBuilder) -> MaterialId {
        let name = name.unwrap_or(UNNAMED);
        let ((rho, rho_colour), (ed, ed_colour)) = (material.reflectance, material.emittance);
        let numbers = [rho, rho_colour.x, rho_colour.y, ed, ed_colour.x, ed_colour.y].map(f64::to_bits);
        let key = (name.to_owned(), numbers, [material.double_sided, material.glossy, material.transmits]);
        if let Some(&id) = self.by_values.get(&key) {
            return id;
        }
        self.glossy += usize::from(material.glossy);
        self.transmitting += usize::from(material.transmits);
        let (reflectance, reflectance_inside) = scaled(rho_colour, rho);
        let (emittance, emittance_inside) = scaled(ed_colour, ed);
        self.out_of_gamut += usize::from(!(reflectance_inside && emittance_inside));
        let of_name = self.of_name.entry(name.to_owned()).or_default();
        *of_name += 1;
        let name = if *of_name == 1 { name.to_owned() } else { format!("{name} ({of_name})") };
        let radiance = emittance / PI;
        let double_sided = material.double_sided;
        let id = builder.material(Material { radiance, double_sided, ..Material::diffuse(name, reflectance) });
        self.by_values.insert(key, id);
        id
    }
}

/// A colour at a brightness, and whether red, green and blue can mix it; black has no colour.
fn scaled(colour: Colour, brightness: f64) -> (Rgb, bool) {
    if brightness == 0.0 {
        return (Rgb::ZERO, true);
    }
    let (rgb, inside) = colour.rgb();
    (brightness * rgb, inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ReadOptions;

    #[test]
    fn each_state_of_a_material_is_one_material() {
        let mut builder = SceneBuilder::new(String::new(), 0, &ReadOptions::default());
        let mut materials = Materials::default();
        let mut paint = MgfMaterial::default();
        let black = materials.id(Some("paint"), &paint, &mut builder);
        paint.reflectance.0 = 0.5;
        paint.emittance.0 = PI;
        paint.glossy = true;
        let grey = materials.id(Some("paint"), &paint, &mut builder);
        assert_ne!(black, grey);
        assert_eq!(materials.id(Some("paint"), &paint, &mut builder), grey);
        materials.id(None, &paint, &mut builder);
        let (scene, _) = builder.finish();
        let names: Vec<&str> = scene.materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!((names, materials.glossy), (vec!["paint", "paint (2)", "unnamed"], 2));
        let grey = &scene.materials[grey];
        assert!((grey.reflectance - Rgb::splat(0.5)).length() < 1e-12 && (grey.radiance - Rgb::ONE).length() < 1e-12);
        assert!(grey.double_sided);
    }
}
