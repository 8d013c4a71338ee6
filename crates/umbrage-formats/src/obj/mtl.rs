//! A material library: what of it concerns a diffuse surface.
//!
//! `Kd` is the reflectance, `Ke` the radiance in W/(m2 sr). A material that is fully transparent (`d 0`, or `Tr 1` where
//! there is no `d`) blocks nothing: its polygons are left out, counted. One that lets through half of the light or more is taken as glass: it
//! blocks nothing, and is passed on; less is opaque. `map_Kd` multiplies
//! `Kd`, and `map_Ke` `Ke`; `map_d` cuts out what is seen, and light is blocked as a whole. A material without `Kd` is grey.

use umbrage::scene::Rgb;

use crate::FormatError;
use crate::builder::DEFAULT_REFLECTANCE;
use crate::text::{Cursor, EXPORT_AGAIN, Place, keyword, words};

/// Statements that do not change what a diffuse surface does: gloss, bumps, and how to render.
const WITHOUT_EFFECT: [&str; 30] = [
    "Ka",
    "Ks",
    "Ns",
    "Ni",
    "Tf",
    "Km",
    "illum",
    "sharpness",
    "Pr",
    "Pm",
    "Ps",
    "Pc",
    "Pcr",
    "aniso",
    "anisor",
    "bump",
    "map_bump",
    "map_Bump",
    "norm",
    "disp",
    "decal",
    "refl",
    "map_Ka",
    "map_Ks",
    "map_Ns",
    "map_Pr",
    "map_Pm",
    "map_Ps",
    "map_aat",
    "map_refl",
];

/// A material as its library has it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MtlMaterial {
    pub(super) name: String,
    /// `Kd`, not capped.
    pub(super) reflectance: Rgb,
    /// `Ke`, in W/(m2 sr).
    pub(super) radiance: Rgb,
    /// `d`, or 1 - `Tr`: 1 is opaque.
    pub(super) opacity: f64,
    /// `map_Kd`.
    pub(super) texture: Option<MtlTexture>,
    /// `map_Ke`.
    pub(super) emission_texture: Option<MtlTexture>,
    /// `map_d`.
    pub(super) opacity_texture: Option<MtlTexture>,
    says_reflectance: bool,
    says_radiance: bool,
    opacity_is_d: bool,
}

/// An image on a material.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MtlTexture {
    /// The file, relative to the library.
    pub(super) file: String,
    /// What texture coordinates are multiplied with (`-s`), then moved by (`-o`).
    pub(super) scale: [f64; 2],
    pub(super) offset: [f64; 2],
    /// Whether nothing begins anew beyond its border (`-clamp on`).
    pub(super) clamp: bool,
}

impl MtlMaterial {
    fn new(name: String) -> Self {
        let reflectance = Rgb::splat(DEFAULT_REFLECTANCE);
        Self {
            name,
            reflectance,
            radiance: Rgb::ZERO,
            opacity: 1.0,
            texture: None,
            emission_texture: None,
            opacity_texture: None,
            says_reflectance: false,
            says_radiance: false,
            opacity_is_d: false,
        }
    }
}

/// Reads a library whose bytes are given. Statements that are not known are handed to `unknown`.
pub(super) fn read(file: &str, bytes: &[u8], mut unknown: impl FnMut(&str)) -> Result<Vec<MtlMaterial>, FormatError> {
    let mut materials: Vec<MtlMaterial> = Vec::new();
    let mut cursor = Cursor::default();
    while let Some(line) = cursor.next_line(bytes, false) {
        let place = Place { file, line: line.number };
        let (word, rest) = keyword(&line.text);
        if word == "newmtl" {
            materials.push(MtlMaterial::new(rest.to_owned()));
            continue;
        }
        if word.starts_with('#') || WITHOUT_EFFECT.contains(&word) {
            continue;
        }
        // What stands before the first material belongs to none.
        let Some(material) = materials.last_mut() else {
            unknown(word);
            continue;
        };
        match word {
            "Kd" | "Ke" if matches!(rest.split_ascii_whitespace().next(), Some("spectral" | "xyz")) => unknown(word),
            "Kd" => {
                material.reflectance = colour(place, word, rest)?;
                material.says_reflectance = true;
            }
            "Ke" => {
                material.radiance = colour(place, word, rest)?;
                material.says_radiance = true;
            }
            "d" | "Tr" => {
                let mut words = words(rest).filter(|word| *word != "-halo");
                let [value] = place.numbers(word, &mut words)?;
                if word == "d" {
                    (material.opacity, material.opacity_is_d) = (value, true);
                } else if !material.opacity_is_d {
                    material.opacity = 1.0 - value;
                }
            }
            "map_Kd" => material.texture = texture(place, rest)?,
            "map_Ke" => material.emission_texture = texture(place, rest)?,
            "map_d" => material.opacity_texture = texture(place, rest)?,
            _ => unknown(word),
        }
    }
    // An image says all of the colour where nothing else does.
    for material in &mut materials {
        if material.texture.is_some() && !material.says_reflectance {
            material.reflectance = Rgb::ONE;
        }
        if material.emission_texture.is_some() && !material.says_radiance {
            material.radiance = Rgb::ONE;
        }
    }
    Ok(materials)
}

/// The options of a texture, and its file, whose name may have spaces.
fn texture(place: Place<'_>, mut rest: &str) -> Result<Option<MtlTexture>, FormatError> {
    let mut texture = MtlTexture { file: String::new(), scale: [1.0; 2], offset: [0.0; 2], clamp: false };
    while rest.starts_with('-') {
        let (option, mut after) = keyword(rest);
        let mut next = || {
            let (word, others) = keyword(after);
            after = others;
            word
        };
        match option {
            "-s" | "-o" | "-t" => {
                // One to three numbers; the file's name may begin with a digit, so a number is what is one as a whole.
                let mut numbers = [None; 3];
                for number in &mut numbers {
                    match keyword(after) {
                        (word, others) if word.parse::<f64>().is_ok() => {
                            *number = Some(place.finite(word)?);
                            after = others;
                        }
                        _ => break,
                    }
                }
                let of = if option == "-s" { &mut texture.scale } else { &mut texture.offset };
                if option != "-t" {
                    of.iter_mut().zip(numbers).for_each(|(of, number)| *of = number.unwrap_or(*of));
                }
            }
            "-clamp" => texture.clamp = next() == "on",
            "-mm" => {
                next();
                next();
            }
            _ => {
                next();
            }
        }
        rest = after;
    }
    texture.file = rest.to_owned();
    Ok(Some(texture).filter(|texture| !texture.file.is_empty()))
}

/// Three channels, or one for all of them.
fn colour(place: Place<'_>, keyword: &str, rest: &str) -> Result<Rgb, FormatError> {
    let mut words = words(rest);
    let [red] = place.numbers(keyword, &mut words)?;
    let colour = match words.next() {
        None => Rgb::splat(red),
        Some(green) => {
            let [blue] = place.numbers("the rest of a colour", &mut words)?;
            Rgb::new(red, place.finite(green)?, blue)
        }
    };
    if colour.min_element() < 0.0 {
        return Err(place.bad(format!("{keyword} is {colour}, and should not be negative"), EXPORT_AGAIN));
    }
    Ok(colour)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(text: &str) -> MtlMaterial {
        read("a.mtl", format!("newmtl paint\n{text}").as_bytes(), |word| panic!("unknown: {word}")).unwrap().remove(0)
    }

    #[test]
    fn colours_and_opacity() {
        let paint = one("Kd 0.1 0.2 0.3 # dark\nKe 5\nKs 1 1 1\nNs 10\nillum 2\nmap_Kd wood.png");
        assert_eq!((paint.name.as_str(), paint.opacity), ("paint", 1.0));
        assert_eq!(paint.texture.map(|texture| texture.file), Some("wood.png".into()));
        assert_eq!((paint.reflectance, paint.radiance), (Rgb::new(0.1, 0.2, 0.3), Rgb::splat(5.0)));
        assert_eq!(one("").reflectance, Rgb::splat(DEFAULT_REFLECTANCE));
        for (text, opacity) in [("d 0.25", 0.25), ("Tr 1", 0.0), ("d 1\nTr 1", 1.0), ("Tr 1\nd 1", 1.0)] {
            assert_eq!(one(text).opacity, opacity, "{text}");
        }
        assert_eq!(one("d -halo 0.5").opacity, 0.5);
    }

    #[test]
    fn textures_have_options_and_names_with_spaces() {
        let texture = |text: &str| one(text).texture.unwrap();
        let moved = texture("map_Kd -clamp on -s 2 3 1 -o 0.5 -bm 1 -mm 0 1 my wood 2.png");
        let expected = MtlTexture { file: "my wood 2.png".into(), scale: [2.0, 3.0], offset: [0.5, 0.0], clamp: true };
        assert_eq!(moved, expected);
        assert_eq!(one("map_Kd a.png").reflectance, Rgb::ONE);
        assert_eq!(one("map_Kd a.png\nKd 0.5 0.5 0.5").reflectance, Rgb::splat(0.5));
        assert_eq!(texture("map_Kd -s 2 4.png").file, "4.png");
        assert_eq!((one("map_Ke a.png").radiance, one("map_Ke a.png\nKe 2").radiance), (Rgb::ONE, Rgb::splat(2.0)));
        assert_eq!(one("map_d -o 1 a.png").opacity_texture.map(|texture| texture.offset), Some([1.0, 0.0]));
        assert!(one("map_Kd").texture.is_none() && one("map_Kd -s 1 1 1").texture.is_none());
    }

    #[test]
    fn strange_statements_are_counted_and_bad_ones_named() {
        let mut unknown = Vec::new();
        let text = b"Kd 1 1 1\nnewmtl a\nKd spectral a.rfl 1\nfoo 3\nnewmtl b";
        let materials = read("a.mtl", text, |word| unknown.push(word.to_owned())).unwrap();
        assert_eq!(unknown, ["Kd", "Kd", "foo"]);
        assert_eq!(materials.len(), 2);
        for (text, words) in [
            ("Kd 1 2", "has 0 numbers, and needs 1"),
            ("Kd", "Kd has 0 numbers"),
            ("Ke -1 0 0", "negative"),
            ("d x", "\"x\" is not a number"),
            ("Kd nan", "not finite"),
        ] {
            let error = read("a.mtl", format!("newmtl a\n{text}").as_bytes(), |_| ()).unwrap_err().to_string();
            assert!(error.starts_with("a.mtl: line 2: ") && error.contains(words), "{error}");
        }
    }
}
