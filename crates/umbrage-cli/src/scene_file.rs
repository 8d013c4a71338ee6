//! Reading a scene for a command: the options that say how, and its warnings told.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::{Args, ValueEnum};
use umbrage::scene::Scene;
use umbrage_formats::{
    FormatError, LampUnits, MaterialColour, Overrides, ReadOptions, SceneAndFiles, UpAxis, Warning,
    read_scene_and_files,
};

use crate::output;

/// A scene, and what of its file was not taken over.
type Read = (Scene, Vec<Warning>);

/// What a scene's file does not say, or says wrongly.
#[derive(Clone, Debug, Default, Args)]
#[command(next_help_heading = "Scene")]
pub struct SceneArgs {
    /// Let a material give light: its radiance in W/(m2 sr), red, green and blue, or one number for all; may be
    /// repeated
    #[arg(long, value_name = "MATERIAL=R,G,B")]
    emit: Vec<MaterialColour>,
    /// Let all that hangs below a node give light: as --emit, by the node's name or its mesh's; may be repeated
    #[arg(long, value_name = "NODE=R,G,B")]
    emit_node: Vec<MaterialColour>,
    /// Let light pass through a node, by its name or its mesh's, with all below it, such as a dome of sky; may be repeated. It is shown
    /// in mean light
    #[arg(long, value_name = "NODE")]
    no_shadow: Vec<String>,
    /// Let a material reflect this share of the light, 0 to 1, red, green and blue, or one number; may be repeated
    #[arg(long, value_name = "MATERIAL=R,G,B")]
    reflectance: Vec<MaterialColour>,
    /// Light all materials on their front only, whatever the file says; materials that the TOML names with `double_sided`
    /// keep that
    #[arg(long, conflicts_with = "double_sided")]
    single_sided: bool,
    /// Light all materials on both sides, whatever the file says; materials that the TOML names with `double_sided` keep
    /// that
    #[arg(long)]
    double_sided: bool,
    /// A TOML that says such things of materials, and may have lamps [default: SCENE.umbrage.toml beside the scene, if
    /// there is one]
    #[arg(long, value_name = "FILE")]
    materials: Option<PathBuf>,
    /// The unit of length of the file
    #[arg(long, value_enum, default_value_t)]
    unit: Unit,
    /// The axis of the file that points up
    #[arg(long, value_enum, default_value_t)]
    up_axis: Up,
    /// What the brightness of lamps (points, spots, suns) is in, beside that of surfaces that emit
    #[arg(long, value_enum, default_value_t)]
    lamp_units: Lamps,
    /// Read files that the scene refers to (textures, libraries, includes) from anywhere below this folder [default: the scene's
    /// folder; for MGF, its parent]
    #[arg(long, value_name = "FOLDER")]
    root: Option<PathBuf>,
    /// Cut a full circle of curved shapes (MGF) into so many straight pieces [default: 24]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(3..=4096))]
    curve_sides: Option<u16>,
}

/// A unit of length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Unit {
    /// Millimetre
    Mm,
    /// Centimetre
    Cm,
    /// Metre
    #[default]
    M,
    /// Inch
    In,
    /// Foot
    Ft,
}

impl Unit {
    /// Its length in metres.
    pub fn metres(self) -> f64 {
        match self {
            Self::Mm => 0.001,
            Self::Cm => 0.01,
            Self::M => 1.0,
            Self::In => 0.0254,
            Self::Ft => 0.3048,
        }
    }
}

/// What lamps are in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Lamps {
    /// The same as surfaces: photometric both, or radiometric both
    #[default]
    Same,
    /// Lumens, and surfaces watts, as Blender writes them: lamps are divided by 683
    Lumens,
}

/// The axis that points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Up {
    /// Y, as in glTF
    #[default]
    Y,
    /// Z, as in most MGF and STL files
    Z,
}

impl SceneArgs {
    /// The unit that the file is taken to be in.
    pub fn unit(&self) -> Unit {
        self.unit
    }

    /// Reads a scene with what these options and the TOML say of it, and tells what of the file was not taken over.
    ///
    /// # Errors
    /// Where the scene or the TOML cannot be read.
    pub fn read(&self, path: &Path, max_reflectance: f64) -> anyhow::Result<Scene> {
        self.read_and_warn(path, max_reflectance).map(|(scene, _)| scene)
    }

    /// Does the same, and hands back the warnings that it told.
    ///
    /// # Errors
    /// Where the scene or the TOML cannot be read.
    pub fn read_and_warn(&self, path: &Path, max_reflectance: f64) -> anyhow::Result<Read> {
        let (scene, warnings) = self.read_silently(path, max_reflectance).1?;
        for warning in &warnings {
            output::warning(&format!("{}: {warning}", path.display()));
        }
        Ok((scene, warnings))
    }

    /// The same for a program that tells the warnings itself. Also tells what files it is made of, those that are not
    /// there included, and those that were asked for until reading failed.
    pub fn read_silently(&self, path: &Path, max_reflectance: f64) -> (Vec<PathBuf>, anyhow::Result<Read>) {
        let up = match self.up_axis {
            Up::Y => UpAxis::Y,
            Up::Z => UpAxis::Z,
        };
        let lamp_units = match self.lamp_units {
            Lamps::Same => LampUnits::Same,
            Lamps::Lumens => LampUnits::Lumens,
        };
        let unit_m = self.unit.metres();
        let toml = self.materials_path(path);
        let mut overrides = match self.overrides(path) {
            Ok(overrides) => overrides,
            Err(error) => return (vec![path.to_path_buf(), toml], Err(error)),
        };
        overrides.set_unit_m(unit_m);
        let options = ReadOptions {
            max_reflectance,
            unit_m,
            up,
            lamp_units,
            circle_segments: self.curve_sides.map_or(ReadOptions::default().circle_segments, usize::from),
            dark: overrides.dark_materials(),
            root: self.root.clone(),
        };
        let SceneAndFiles { scene, mut files } = read_scene_and_files(path, &options);
        files.push(toml);
        (files, overridden(&overrides, scene, max_reflectance))
    }

    /// The TOML that says more of a scene, whether it is there or not.
    pub fn materials_path(&self, scene: &Path) -> PathBuf {
        self.materials.clone().unwrap_or_else(|| Overrides::path_beside(scene))
    }

    fn overrides(&self, path: &Path) -> anyhow::Result<Overrides> {
        let file = self.materials_path(path);
        let mut overrides = match &self.materials {
            None if !file.is_file() => Overrides::default(),
            _ => Overrides::read(file)?,
        };
        if self.single_sided || self.double_sided {
            overrides.set_double_sided(self.double_sided);
        }
        for emission in &self.emit {
            overrides.emit(emission.clone());
        }
        for emission in &self.emit_node {
            overrides.emit_from_node(emission.clone());
        }
        for node in &self.no_shadow {
            overrides.cast_no_shadow(node.clone());
        }
        for reflectance in &self.reflectance {
            overrides.reflect(reflectance.clone()).map_err(|what| anyhow!("--reflectance: {what}"))?;
        }
        Ok(overrides)
    }
}

fn overridden(overrides: &Overrides, read: Result<Read, FormatError>, max_reflectance: f64) -> anyhow::Result<Read> {
    let (mut scene, mut warnings) = read?;
    warnings.extend(overrides.apply(&mut scene, max_reflectance)?);
    Ok((scene, warnings))
}
