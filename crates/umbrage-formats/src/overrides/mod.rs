//! What the user says beside what the file says: emission, reflectance and sides of materials, by name, and lamps.
//!
//! Files from elsewhere seldom have lamps that give light. A TOML beside the scene, or options of a command, say it:
//!
//! ```toml
//! double_sided = false        # all materials but those below that say otherwise
//!
//! [materials.lamp]
//! emission = [12, 11, 9]      # radiance in W/(m2 sr); one number is for red, green and blue
//! reflectance = 0.5           # share of light, 0 to 1
//! double_sided = true
//!
//! [materials.dome]
//! casts_shadow = false        # light passes through it; it is shown in mean light
//!
//! [nodes.chandelier]          # all that hangs below it
//! emission = 40
//! casts_shadow = false
//!
//! [[lamps]]                   # a sun: where its light goes to, and W/m2 on what faces it
//! direction = [-1, -3, -2]
//! irradiance = [3, 2.9, 2.7]
//!
//! [[lamps]]                   # a bulb: where it is, in metres with Y up, and W/sr
//! name = "bulb"
//! position = [0, 2.2, 0]
//! intensity = 8
//! ```
//! With `lamp_unit = "file"` at the top, positions of lamps are in the unit of the scene's file, as far as that was said.
//! A bulb with a `direction` is a spot, of `outer_degrees` from its axis (45 if it does not say), soft from `inner_degrees` (0) on.
//! A name that the scene has not is an error, which names the most similar one: a lamp that silently stays dark would be
//! worse. All materials of a name change; what is said later wins, but that of the whole scene never wins over that of one material.

mod faint;
mod lamp;
mod node;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use toml::{Table, Value};
use umbrage::scene::{Lamp, MAX_BRIGHTNESS, Rgb, Scene};

use self::lamp::read_lamp;
use self::node::{NodeChange, NodeChanges};
use crate::beside::read_up_to;
use crate::similar::{alike, most_similar};
use crate::text::{shortened, utf8};
use crate::{FormatError, Warning};

/// What a message calls the options of a command.
const OPTIONS: &str = "the options";

/// Larger files are refused: what a TOML becomes takes some hundred times its bytes.
const MAX_TOML_BYTES: u64 = 4 << 20;

/// A lamp is far away where it is farther than so many times the scene's extent from its middle.
const FAR_IN_EXTENTS: f64 = 10.0;

/// A material's name and a colour, as `MATERIAL=r,g,b` or `MATERIAL=grey`.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialColour {
    /// The material's name; it may have `=` in it.
    pub material: String,
    /// Red, green and blue, linear, finite and not negative.
    pub colour: Rgb,
}

impl FromStr for MaterialColour {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = "must be MATERIAL=r,g,b or MATERIAL=x, as in lamp=12,11,9";
        let (material, colour) = text.rsplit_once('=').ok_or(form)?;
        let numbers: Option<Vec<f64>> = colour.split(',').map(|number| number.trim().parse().ok()).collect();
        let colour = match numbers.as_deref() {
            Some(&[grey]) => Rgb::splat(grey),
            Some(&[red, green, blue]) => Rgb::new(red, green, blue),
            _ => return Err(form.into()),
        };
        check(colour)?;
        Ok(Self { material: material.to_owned(), colour })
    }
}

fn check(colour: Rgb) -> Result<(), String> {
    if !(colour.is_finite() && colour.min_element() >= 0.0) {
        Err("must be finite and not negative".into())
    } else if colour.max_element() > MAX_BRIGHTNESS {
        Err(format!("must be at most {MAX_BRIGHTNESS:e}"))
    } else {
        Ok(())
    }
}

fn check_share(colour: Rgb) -> Result<(), String> {
    check(colour)?;
    if colour.max_element() <= 1.0 { Ok(()) } else { Err("must be at most 1, as it is a share of the light".into()) }
}

/// A change to the materials of one name.
#[derive(Clone, Debug, PartialEq)]
struct Override {
    /// Where it is from: a file, or the options.
    from: String,
    material: String,
    change: Change,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Emission(Rgb),
    Reflectance(Rgb),
    DoubleSided(bool),
    CastsShadow(bool),
}

/// Changes to materials, in the order in which they are made, and lamps.
#[derive(Clone, Debug, PartialEq)]
pub struct Overrides {
    /// Whether all materials are double-sided, but for those that `list` changes.
    double_sided: Option<bool>,
    list: Vec<Override>,
    nodes: NodeChanges,
    lamps: Vec<Lamp>,
    lamps_in_file_unit: bool,
    /// Length of the file's unit, in metres.
    unit_m: f64,
}

impl Default for Overrides {
    fn default() -> Self {
        let nodes = NodeChanges::default();
        Self { double_sided: None, list: Vec::new(), nodes, lamps: Vec::new(), lamps_in_file_unit: false, unit_m: 1.0 }
    }
}

impl Overrides {
    /// The file that goes with a scene if it exists: `room.umbrage.toml` beside `room.glb`.
    pub fn path_beside(scene: impl AsRef<Path>) -> PathBuf {
        scene.as_ref().with_extension("umbrage.toml")
    }

    /// Reads a TOML as the head of this file has it.
    ///
    /// # Errors
    /// A [`FormatError`] that names the file and the line or the entry.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, FormatError> {
        let file = path.as_ref().display().to_string();
        let unreadable = |source| FormatError::Unreadable { file: file.clone(), source };
        let bytes = read_up_to(path.as_ref(), MAX_TOML_BYTES).map_err(unreadable)?;
        let text =
            String::from_utf8(utf8(bytes)).map_err(|error| unreadable(std::io::Error::other(error.utf8_error())))?;
        Self::parse(&file, &text)
    }

    /// Parses a TOML; `file` names it in messages.
    ///
    /// # Errors
    /// A [`FormatError`] that names the file and the line or the entry.
    pub fn parse(file: &str, text: &str) -> Result<Self, FormatError> {
        let table: Table = toml::from_str(text).map_err(|error| {
            let before = error.span().map_or("", |span| text.get(..span.start).unwrap_or(text));
            let place = format!("line {}", 1 + before.matches('\n').count());
            let what = error.message().trim().to_owned();
            FormatError::BadStatement { file: file.to_owned(), place, what, cure: "it has to be TOML" }
        })?;
        let mut overrides = Self::default();
        for (key, value) in &table {
            match (key.as_str(), value) {
                ("materials", Value::Table(materials)) => {
                    for (material, value) in materials {
                        overrides.material(file, material, value)?;
                    }
                }
                ("lamps", Value::Array(lamps)) => {
                    for (number, lamp) in lamps.iter().enumerate() {
                        overrides.lamps.push(read_lamp(file, number + 1, lamp)?);
                    }
                }
                ("nodes", Value::Table(nodes)) => {
                    for (node, value) in nodes {
                        overrides.nodes.read(file, node, value)?;
                    }
                }
                ("lamp_unit", Value::String(unit)) if unit == "file" => overrides.lamps_in_file_unit = true,
                ("lamp_unit", Value::String(unit)) if unit == "m" => overrides.lamps_in_file_unit = false,
                ("lamp_unit", _) => return Err(bad(file, key.clone(), "is neither \"m\" nor \"file\"".into())),
                ("double_sided", Value::Boolean(double_sided)) => overrides.double_sided = Some(*double_sided),
                ("double_sided", _) => return Err(bad(file, key.clone(), "is neither true nor false".into())),
                ("materials" | "nodes" | "lamps", _) => {
                    return Err(bad(
                        file,
                        key.clone(),
                        format!("should be [materials.NAME], [nodes.NAME] or [[lamps]], not {key} = ..."),
                    ));
                }
                _ => {
                    return Err(bad(
                        file,
                        key.clone(),
                        unknown_key(key, &["materials", "nodes", "lamps", "lamp_unit", "double_sided"]),
                    ));
                }
            }
        }
        Ok(overrides)
    }

    fn material(&mut self, file: &str, material: &str, value: &Value) -> Result<(), FormatError> {
        let place = format!("materials.{material}");
        let Value::Table(properties) = value else {
            return Err(bad(file, place, "is not a table".into()));
        };
        for (key, value) in properties {
            let refuse = |what: String| bad(file, format!("{place}.{key}"), what);
            let colour = || colour(value).ok_or_else(|| refuse("is neither a number nor a list of three".into()));
            let change = match (key.as_str(), value) {
                ("emission", _) => {
                    let emission = colour()?;
                    check(emission).map_err(refuse)?;
                    Change::Emission(emission)
                }
                ("reflectance", _) => {
                    let reflectance = colour()?;
                    check_share(reflectance).map_err(refuse)?;
                    Change::Reflectance(reflectance)
                }
                ("double_sided", Value::Boolean(double_sided)) => Change::DoubleSided(*double_sided),
                ("casts_shadow", Value::Boolean(casts_shadow)) => Change::CastsShadow(*casts_shadow),
                ("double_sided" | "casts_shadow", _) => return Err(refuse("is neither true nor false".into())),
                _ => {
                    return Err(refuse(unknown_key(key, &["emission", "reflectance", "double_sided", "casts_shadow"])));
                }
            };
            self.list.push(Override { from: file.to_owned(), material: material.to_owned(), change });
        }
        Ok(())
    }

    /// Adds that a material emits a radiance, in W/(m2 sr).
    pub fn emit(&mut self, emission: MaterialColour) {
        self.option(emission.material, Change::Emission(emission.colour));
    }

    /// Adds that a material reflects a share of the light.
    ///
    /// # Errors
    /// In words, if it is more than 1.
    pub fn reflect(&mut self, reflectance: MaterialColour) -> Result<(), String> {
        check_share(reflectance.colour).map_err(|what| format!("reflectance of {:?} {what}", reflectance.material))?;
        self.option(reflectance.material, Change::Reflectance(reflectance.colour));
        Ok(())
    }

    /// Makes all materials double-sided or single-sided, but for those that a TOML names with `double_sided`.
    pub fn set_double_sided(&mut self, double_sided: bool) {
        self.double_sided = Some(double_sided);
    }

    fn option(&mut self, material: String, change: Change) {
        self.list.push(Override { from: OPTIONS.into(), material, change });
    }

    /// Adds all of `later`, which win.
    pub fn extend(&mut self, later: Self) {
        self.double_sided = later.double_sided.or(self.double_sided);
        let lamps = later.lamps.iter().map(|lamp| later.in_metres(lamp));
        self.lamps = self.lamps.iter().map(|lamp| self.in_metres(lamp)).chain(lamps).collect();
        self.lamps_in_file_unit = false;
        self.list.extend(later.list);
        self.nodes.extend(later.nodes);
    }

    /// Whether nothing is changed.
    pub fn is_empty(&self) -> bool {
        self.double_sided.is_none() && self.list.is_empty() && self.nodes.is_empty() && self.lamps.is_empty()
    }

    /// Says how long the file's unit of length is, in metres: lamps with `lamp_unit = "file"` are in it.
    pub fn set_unit_m(&mut self, unit_m: f64) {
        self.unit_m = unit_m;
    }

    /// The materials that give no light, whatever the scene's file says: what is seen on them is then their base colour, if the scene
    /// is read with them in [`ReadOptions::dark`](crate::ReadOptions::dark).
    pub fn dark_materials(&self) -> Vec<String> {
        let mut last: BTreeMap<&str, Rgb> = BTreeMap::new();
        for change in &self.list {
            if let Change::Emission(radiance) = change.change {
                last.insert(&change.material, radiance);
            }
        }
        last.into_iter().filter(|(_, radiance)| *radiance == Rgb::ZERO).map(|(name, _)| name.to_owned()).collect()
    }

    /// Lets all light pass through the nodes of a name, or that show a mesh of it, and all below them.
    pub fn cast_no_shadow(&mut self, node: String) {
        self.nodes.push(OPTIONS, node, NodeChange::CastsShadow(false));
    }

    /// Adds that what hangs below a node emits a radiance, in W/(m2 sr).
    pub fn emit_from_node(&mut self, emission: MaterialColour) {
        self.nodes.push(OPTIONS, emission.material, NodeChange::Emission(emission.colour));
    }

    fn in_metres(&self, lamp: &Lamp) -> Lamp {
        let unit_m = if self.lamps_in_file_unit { self.unit_m } else { 1.0 };
        lamp.clone().moved(|p| unit_m * p, |direction| direction, unit_m)
    }

    /// Changes the materials of a scene and adds the lamps; reflectances are capped at `max_reflectance` like those of the file, counted.
    ///
    /// # Errors
    /// [`FormatError::UnknownMaterial`]; the scene is then as it was.
    pub fn apply(&self, scene: &mut Scene, max_reflectance: f64) -> Result<Vec<Warning>, FormatError> {
        for change in &self.list {
            if !scene.materials.iter().any(|material| material.name == change.material) {
                return Err(unknown_material(scene, change));
            }
        }
        let cap = Rgb::splat(max_reflectance.clamp(0.0, 1.0));
        let mut capped = 0;
        if let Some(double_sided) = self.double_sided {
            scene.materials.iter_mut().for_each(|material| material.double_sided = double_sided);
        }
        for &Override { ref material, change, .. } in &self.list {
            for changed in scene.materials.iter_mut().filter(|m| m.name == *material) {
                match change {
                    Change::Emission(radiance) => changed.radiance = radiance,
                    Change::Reflectance(reflectance) => {
                        capped += usize::from(reflectance.cmpgt(cap).any());
                        changed.reflectance = reflectance.min(cap);
                    }
                    Change::DoubleSided(double_sided) => changed.double_sided = double_sided,
                    // That is of surfaces.
                    Change::CastsShadow(_) => {}
                }
            }
        }
        let no_shadow = self.nodes.change(scene, &self.list)?;
        let lamps: Vec<Lamp> = self.lamps.iter().map(|lamp| self.in_metres(lamp)).collect();
        let far = far_lamps(scene, &lamps);
        scene.lamps.extend(lamps);
        let emitting = self.list.iter().filter(|change| matches!(change.change, Change::Emission(_)));
        let faint = faint::show_only(scene, &emitting.map(|change| change.material.as_str()).collect());
        let warning = Warning::ReflectanceCapped { materials: capped, max_reflectance };
        Ok((capped > 0).then_some(warning).into_iter().chain(no_shadow).chain(far).chain(faint).collect())
    }
}

fn bad(file: &str, place: String, what: String) -> FormatError {
    let cure = "see `umbrage help bake` for what it can hold";
    FormatError::BadStatement { file: file.to_owned(), place, what, cure }
}

/// A number, or three.
fn colour(value: &Value) -> Option<Rgb> {
    let number = |value: &Value| match value {
        Value::Integer(number) => Some(*number as f64),
        Value::Float(number) => Some(*number),
        _ => None,
    };
    match value {
        Value::Array(channels) => match channels.as_slice() {
            [red, green, blue] => Some(Rgb::new(number(red)?, number(green)?, number(blue)?)),
            _ => None,
        },
        one => number(one).map(Rgb::splat),
    }
}

fn unknown_key(key: &str, known: &[&str]) -> String {
    let like =
        most_similar(key, known.iter().copied()).map_or(String::new(), |like| format!(", perhaps {like} is meant"));
    format!("is not one of {}{like}", known.join(", "))
}

fn unknown_material(scene: &Scene, change: &Override) -> FormatError {
    let (like, known) = alike(&change.material, scene.materials.iter().map(|material| material.name.as_str()));
    FormatError::UnknownMaterial { file: change.from.clone(), name: shortened(&change.material), like, known }
}

/// The warning of lamps that are far away from a scene: they were meant in another unit.
fn far_lamps(scene: &Scene, lamps: &[Lamp]) -> Option<Warning> {
    let corners = || scene.surfaces.iter().flat_map(|surface| &surface.positions_m);
    let (low, high) = corners().fold((Rgb::INFINITY, Rgb::NEG_INFINITY), |(low, high), &p| (low.min(p), high.max(p)));
    let (middle, size_m) = (0.5 * (low + high), (high - low).length());
    let distance = |lamp: &Lamp| Some((lamp.position_m()? - middle).length());
    let is_far = |lamp: &&Lamp| distance(lamp).is_some_and(|distance_m| distance_m > FAR_IN_EXTENTS * size_m);
    let first = lamps.iter().find(is_far)?;
    let (name, distance_m) = (shortened(&first.name), distance(first)?);
    Some(Warning::LampsFarAway { lamps: lamps.iter().filter(is_far).count(), first: name, distance_m, size_m })
}

#[cfg(test)]
mod tests {
    use umbrage::scene::LampKind;
    use umbrage::scene::cornell::cornell_box;

    use super::*;

    fn parse(text: &str) -> Result<Overrides, FormatError> {
        Overrides::parse("room.umbrage.toml", text)
    }

    #[test]
    fn a_file_and_options_change_materials_and_the_last_wins() {
        let mut overrides = parse(
            "[materials.white]\nemission = [1, 2.5, 3]\nreflectance = 0.25\ndouble_sided = true\n\
             [materials.\"red\"]\nreflectance = [1, 0, 0]",
        )
        .unwrap();
        overrides.emit("white=7".parse().unwrap());
        let mut scene = cornell_box();
        let warnings = overrides.apply(&mut scene, 0.9).unwrap();
        assert_eq!(warnings, [Warning::ReflectanceCapped { materials: 1, max_reflectance: 0.9 }]);
        let [white, red, green, _] = scene.materials.raw.as_slice() else { panic!() };
        assert_eq!((white.radiance, white.reflectance), (Rgb::splat(7.0), Rgb::splat(0.25)));
        assert!(white.double_sided && !red.double_sided);
        assert_eq!(red.reflectance, Rgb::new(0.9, 0.0, 0.0));
        assert_eq!(green, &cornell_box().materials.raw[2]);
    }

    #[test]
    fn sides_of_the_whole_scene_give_way_to_those_of_a_material() {
        let sides = |overrides: &Overrides| {
            let mut scene = cornell_box();
            overrides.apply(&mut scene, 0.9).unwrap();
            scene.materials.iter().map(|material| material.double_sided).collect::<Vec<_>>()
        };
        let mut overrides = parse("double_sided = true\n[materials.red]\ndouble_sided = false\n").unwrap();
        assert_eq!(sides(&overrides), [true, false, true, true]);
        // What is said later, by an option, wins over the file's word on the whole scene, and not over that on a material.
        overrides.set_double_sided(false);
        assert_eq!(sides(&overrides), [false; 4]);
        let mut file = parse("[materials.red]\ndouble_sided = false\n").unwrap();
        file.extend(parse("double_sided = true").unwrap());
        assert_eq!(sides(&file), [true, false, true, true]);
        let mut only = Overrides::default();
        only.set_double_sided(true);
        assert!(!only.is_empty());
    }

    #[test]
    fn suns_bulbs_and_spots_are_added_to_the_lamps_of_the_file() {
        let overrides = parse(
            "[[lamps]]\ndirection = [0, -2, 0]\nirradiance = [3, 2, 1]\n[[lamps]]\nname = \"bulb\"\nposition = [1, 2, 3]\n\
             intensity = 8\n[[lamps]]\nposition = [1, 2, 3]\ndirection = [1, 0, 0]\nintensity = 8\nouter_degrees = 30\n",
        );
        let mut scene = cornell_box();
        overrides.unwrap().apply(&mut scene, 0.9).unwrap();
        let [sun, bulb, spot] = scene.lamps.raw.as_slice() else { panic!("{:?}", scene.lamps) };
        let expected = LampKind::Directional { direction: -Rgb::Y, irradiance: Rgb::new(3.0, 2.0, 1.0) };
        assert_eq!((sun.name.as_str(), sun.kind), ("lamp 1", expected));
        let (position_m, intensity, range_m) = (Rgb::new(1.0, 2.0, 3.0), Rgb::splat(8.0), None);
        assert_eq!((bulb.name.as_str(), bulb.kind), ("bulb", LampKind::Point { position_m, intensity, range_m }));
        let LampKind::Spot { inner_rad, outer_rad, direction, .. } = spot.kind else { panic!("{spot:?}") };
        assert!(inner_rad == 0.0 && (outer_rad - std::f64::consts::FRAC_PI_6).abs() < 1e-12 && direction == Rgb::X);
    }

    #[test]
    fn lamps_far_away_are_told_and_may_be_in_the_unit_of_the_file() {
        let text = "[[lamps]]\nposition = [2, 2000, 3]\nintensity = 8\n";
        let (mut scene, mut overrides) = (cornell_box(), parse(text).unwrap());
        overrides.set_unit_m(0.001);
        let warnings = overrides.apply(&mut scene, 0.9).unwrap();
        assert!(matches!(warnings[..], [Warning::LampsFarAway { lamps: 1, .. }]), "{warnings:?}");
        let message = warnings[0].to_string();
        assert!(message.contains("\"lamp 1\"") && message.contains("lamp_unit = \"file\""), "{message}");
        let mut overrides = parse(&format!("lamp_unit = \"file\"\n{text}")).unwrap();
        overrides.set_unit_m(0.001);
        let mut scene = cornell_box();
        assert_eq!(overrides.apply(&mut scene, 0.9).unwrap(), []);
        assert_eq!(scene.lamps.raw[0].position_m(), Some(Rgb::new(0.002, 2.0, 0.003)));
    }

    #[test]
    fn equal_cones_are_read() {
        let text = "[[lamps]]\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\nintensity = 8\ninner_degrees = 30\nouter_degrees = 30\n";
        let mut scene = cornell_box();
        parse(text).unwrap().apply(&mut scene, 0.9).unwrap();
        assert_eq!(scene.validate(), Ok(()));
    }

    #[test]
    fn materials_that_give_no_light_are_told_to_the_reader() {
        let mut overrides = parse("[materials.a]\nemission = 0\n[materials.b]\nemission = 0\n").unwrap();
        overrides.emit("b=1".parse().unwrap());
        assert_eq!(overrides.dark_materials(), ["a"]);
    }

    #[test]
    fn a_name_that_is_not_there_is_told_with_those_that_are() {
        let mut overrides = Overrides::default();
        overrides.emit("Whit=1,1,1".parse().unwrap());
        let mut scene = cornell_box();
        let message = overrides.apply(&mut scene, 0.9).unwrap_err().to_string();
        for words in ["the options", "\"Whit\"", "perhaps \"white\"", "\"white\", \"red\", \"green\", \"light\""] {
            assert!(message.contains(words), "no {words} in: {message}");
        }
        assert_eq!(scene, cornell_box());
    }

    #[test]
    fn bad_files_are_named_by_line_or_entry() {
        for (text, words) in [
            ("[materials.a]\nemission = \n", "line 2"),
            (
                "[material.a]\n",
                "material: is not one of materials, nodes, lamps, lamp_unit, double_sided, perhaps materials is meant",
            ),
            ("double_sided = 1\n", "double_sided: is neither true nor false"),
            ("lamps = 3\n", "[[lamps]]"),
            ("[[lamps]]\n", "lamps, number 1: should have either"),
            ("[[lamps]]\nposition = [0, 0]\nintensity = 1\n", "position is not three"),
            ("[[lamps]]\nposition = [0, nan, 0]\nintensity = 1\n", "position is not three finite"),
            ("[[lamps]]\ndirection = [0, 0, 0]\nirradiance = 1\n", "direction has no length"),
            ("[[lamps]]\ndirection = [0, -1, 0]\nirradiance = -1\n", "not negative"),
            ("[[lamps]]\nposition = [0, 0, 0]\nintensty = 1\n", "perhaps intensity is meant"),
            ("[[lamps]]\nposition = [0, 0, 0]\ndirection = [0, -1, 0]\nintensity = 1\nouter_degrees = 91\n", "90"),
            ("[materials.a]\nemision = 1\n", "materials.a.emision: is not one of emission"),
            ("[materials.a]\nemission = [1, 2]\n", "neither a number nor a list of three"),
            ("[materials.a]\nemission = -1\n", "not negative"),
            ("[materials.a]\nemission = inf\n", "finite"),
            ("[materials.a]\nreflectance = 1.5\n", "at most 1"),
            ("[materials.a]\nemission = 1e100\n", "at most 1e15"),
            ("lamp_unit = \"mm\"\n", "neither \"m\" nor \"file\""),
            ("[nodes.a]\ncasts_shadow = 1\n", "nodes.a.casts_shadow: is neither true nor false"),
            ("[nodes.a]\nemision = 1\n", "perhaps emission is meant"),
            ("[materials.a]\ndouble_sided = 1\n", "neither true nor false"),
            ("materials = { a = 1 }\n", "materials.a: is not a table"),
        ] {
            let message = parse(text).unwrap_err().to_string();
            assert!(message.starts_with("room.umbrage.toml: ") && message.contains(words), "{message}");
        }
        assert!(parse(&"[".repeat(100_000)).is_err() && parse(&format!("a = {}", "[".repeat(100_000))).is_err());
        assert!(parse("").unwrap().is_empty());
    }

    #[test]
    fn colours_of_options() {
        let colour = |text: &str| text.parse::<MaterialColour>();
        assert_eq!(
            colour("a=b=1,2, 3").unwrap(),
            MaterialColour { material: "a=b".into(), colour: Rgb::new(1., 2., 3.) }
        );
        for text in ["lamp", "lamp=1,2", "lamp=x", "lamp=-1", "lamp=nan", "lamp="] {
            assert!(colour(text).is_err(), "{text}");
        }
        assert!(Overrides::default().reflect(colour("a=1.5").unwrap()).is_err());
        assert_eq!(Overrides::path_beside("a/room.glb"), PathBuf::from("a/room.umbrage.toml"));
    }
}
