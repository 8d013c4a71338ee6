//! `umbrage form-factor`: form factors between the surfaces of a scene, as a table.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;

use anyhow::{Context, anyhow, ensure};
use clap::{Args, ValueEnum};
use umbrage::id::{FaceId, Table};
use umbrage::prepare::{self, Prepared};
use umbrage::progress::Progress;
use umbrage::scene::{Scene, SceneError};
use umbrage::transport::exact::{Effort, FactorTable, FactorTotals};
use umbrage::visibility::Visibility;
use umbrage_formats::write_atomically;

use crate::interrupt;
use crate::method::positive;
use crate::output::{Output, answer};
use crate::progress::Bar;
use crate::scene_file::SceneArgs;
use crate::summary::count;

const HELP: &str = "\
Examples:
  umbrage form-factor room.glb -o factors.csv                       all pairs of surfaces
  umbrage form-factor room.glb --by face -o factors.csv             all pairs of faces
  umbrage form-factor room.glb --by node --from heater --to desk    one pair, to the terminal
  umbrage form-factor room.obj --by material --tolerance 1e-7 -o factors.csv

The form factor from a receiver to a source is the share of the light that leaves the receiver, evenly and diffusely, and \
arrives at the source; sides count where they look (glTF: counter-clockwise), both sides block. Columns of the table:

  receiver, receiver_area_m2, source    by name; the source (sum) is the sum of the row
  factor, error_bound                   the form factor, and by how much it is off at most
  reciprocity_residual                  (A1 F12 - A2 F21) / A1, each direction computed for itself

Pairs that exchange nothing have no line. In a closed room each row sums to 1, but for areas that are covered.";

/// Form factors (view factors) between the surfaces of a scene, with occluders and error bounds, as CSV
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub(crate) struct FormFactorArgs {
    /// The scene: glTF 2.0 (.glb or .gltf), OBJ, MGF, PLY or STL; it needs no light
    scene: PathBuf,
    /// The table to write (.csv); replaced if it exists [default: the terminal]
    #[arg(short, long, value_name = "OUT.csv")]
    output: Option<PathBuf>,
    /// What a row and a column stand for
    #[arg(long, value_enum, default_value_t)]
    by: By,
    /// Only factors from this receiver, as the table names it; may be repeated
    #[arg(long, value_name = "NAME")]
    from: Vec<String>,
    /// Only factors to this source, as the table names it; may be repeated
    #[arg(long, value_name = "NAME")]
    to: Vec<String>,
    /// Go on until the factor of each pair of faces is off by at most this
    #[arg(long, value_name = "T", value_parser = positive, default_value_t = Effort::default().tolerance)]
    tolerance: f64,
    #[command(flatten)]
    reading: SceneArgs,
}

/// What is taken together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum By {
    /// Each convex plane face, by number
    Face,
    /// The faces of one material under one node
    #[default]
    Surface,
    /// The faces under one node
    Node,
    /// The faces of one material
    Material,
}

pub(crate) fn run(args: &FormFactorArgs, output: Output) -> anyhow::Result<()> {
    interrupt::listen()?;
    let scene = args.reading.read(&args.scene, 1.0)?;
    match scene.validate() {
        // Form factors are of the geometry alone.
        Ok(()) | Err(SceneError::Lightless { .. }) => {}
        Err(error) => return Err(error).with_context(|| format!("cannot use {}", args.scene.display())),
    }
    let bar = Bar::new(output);
    let callback = |update| bar.update(update);
    let progress = Progress::new(&callback);
    let prepared = prepare::prepare(&scene, progress)?;
    let groups = Groups::new(&scene, &prepared, args.by);
    let (receivers, sources) = (groups.chosen(&args.from)?, groups.chosen(&args.to)?);
    let is_in = |chosen: &[bool], face: FaceId| chosen[groups.of_face[face]];
    let effort = Effort { tolerance: args.tolerance, ..Effort::default() };
    let factors = FactorTable::new(
        &prepared,
        &Visibility::new(&prepared),
        |face| is_in(&receivers, face),
        |face| is_in(&sources, face),
        &effort,
        progress,
    );
    bar.clear();
    let factors = factors?;
    let (text, rows) = csv(&groups, &factors, &receivers, &sources);
    let Some(path) = &args.output else { return answer(&text) };
    write_atomically(path, text.as_bytes())?;
    output.say(&format!(
        "{} between {} of {}\nWrote {}",
        count(rows, "form factor"),
        count(groups.names.len(), args.by.noun()),
        count(prepared.faces.len(), "face"),
        path.display()
    ))
}

impl By {
    fn noun(self) -> &'static str {
        match self {
            Self::Face => "face",
            Self::Surface => "surface",
            Self::Node => "node",
            Self::Material => "material",
        }
    }
}

/// The rows and columns of the table.
struct Groups {
    names: Vec<String>,
    of_face: Table<FaceId, usize>,
}

impl Groups {
    fn new(scene: &Scene, prepared: &Prepared, by: By) -> Self {
        let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
        let mut names: Vec<String> = Vec::new();
        let mut of_face: Table<FaceId, usize> = Table::new();
        for (id, face) in prepared.faces.iter_enumerated() {
            let surface = &scene.surfaces[face.surface];
            let node = &scene.nodes[surface.node];
            let node_name = node.name.as_deref().or(node.mesh_name.as_deref()).unwrap_or("unnamed");
            let material_name = &scene.materials[face.material].name;
            let (key, name) = match by {
                By::Face => (id.index(), format!("face {}", id.index())),
                By::Surface => (face.surface.index(), format!("{node_name}/{material_name}")),
                By::Node => (surface.node.index(), node_name.to_owned()),
                By::Material => (face.material.index(), material_name.clone()),
            };
            let number = *numbers.entry(key).or_insert_with(|| {
                let namesakes = names.iter().filter(|other| is_namesake(other, &name)).count();
                names.push(if namesakes == 0 { name } else { format!("{name} #{}", namesakes + 1) });
                names.len() - 1
            });
            of_face.push(number);
        }
        Self { names, of_face }
    }

    /// Which groups are meant: all where no name is given.
    fn chosen(&self, names: &[String]) -> anyhow::Result<Vec<bool>> {
        for name in names {
            ensure!(self.names.contains(name), self.unknown(name));
        }
        Ok(self.names.iter().map(|name| names.is_empty() || names.contains(name)).collect())
    }

    fn unknown(&self, name: &str) -> anyhow::Error {
        const LISTED: usize = 12;
        let known: Vec<String> = self.names.iter().take(LISTED).map(|name| format!("{name:?}")).collect();
        let more = if self.names.len() > LISTED { ", ..." } else { "" };
        anyhow!("there is no {name:?}: the table would have {}{more}; --by chooses others", known.join(", "))
    }
}

/// Whether `other` is `name`, or `name` with a number.
fn is_namesake(other: &str, name: &str) -> bool {
    other.strip_prefix(name).is_some_and(|rest| {
        rest.is_empty() || rest.strip_prefix(" #").is_some_and(|n| n.bytes().all(|b| b.is_ascii_digit()))
    })
}

/// The table, and how many factors are in it.
fn csv(groups: &Groups, factors: &FactorTable, receivers: &[bool], sources: &[bool]) -> (String, usize) {
    let mut text = String::from("receiver,receiver_area_m2,source,factor,error_bound,reciprocity_residual\n");
    let mut rows = 0;
    let totals = factors.totals(groups.names.len(), |face| Some(groups.of_face[face]));
    for (receiver, row) in totals.iter().enumerate().filter(|(receiver, _)| receivers[*receiver]) {
        let faces = groups.of_face.iter_enumerated().filter(|(_, group)| **group == receiver);
        let area_m2: f64 = faces.map(|(face, _)| factors.areas_m2[face]).sum();
        let mut line = |source: &str, total: &FactorTotals| {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{},{area_m2},{source},{:.12},{:.1e},{:.1e}",
                quoted(&groups.names[receiver]),
                total.factor,
                total.error_bound,
                total.reciprocity_residual
            );
        };
        let mut sum = FactorTotals::default();
        for (source, total) in row.iter().enumerate().filter(|(source, _)| sources[*source]) {
            if total.factor > 0.0 || total.error_bound > 0.0 {
                line(&quoted(&groups.names[source]), total);
                rows += 1;
                sum.factor += total.factor;
                sum.error_bound += total.error_bound;
                sum.reciprocity_residual += total.reciprocity_residual;
            }
        }
        line("(sum)", &sum);
    }
    (text, rows)
}

/// A field of a CSV (RFC 4180).
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage::scene::cornell::cornell_box;

    #[test]
    fn groups_have_names_of_their_own() {
        let mut scene = cornell_box();
        for material in &mut scene.materials {
            material.name = "paint, matt".into();
        }
        let prepared = prepare::prepare(&scene, Progress::silent()).unwrap();
        let groups = Groups::new(&scene, &prepared, By::Material);
        assert_eq!(groups.names, ["paint, matt", "paint, matt #2", "paint, matt #3", "paint, matt #4"]);
        assert_eq!(quoted(&groups.names[0]), "\"paint, matt\"");
        assert_eq!(groups.chosen(&["paint, matt #3".into()]).unwrap(), [false, false, true, false]);
        assert!(groups.chosen(&["oak".into()]).unwrap_err().to_string().contains("paint, matt #4"));
        assert_eq!(Groups::new(&scene, &prepared, By::Node).names, ["cornell"]);
        assert_eq!(Groups::new(&scene, &prepared, By::Face).names.len(), prepared.faces.len());
    }
}
