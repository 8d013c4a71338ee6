//! The scenes that are measured, by name.

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use umbrage::scene::Scene;
use umbrage_bench::box_field;
use umbrage_formats::{Overrides, ReadOptions, read_scene_with};

use crate::positive;

/// A path in the project, from where the program runs if it runs in the project.
pub(crate) fn in_project(path: &str) -> PathBuf {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let here = || root.canonicalize().ok().zip(std::env::current_dir().ok()).is_some_and(|(root, here)| root == here);
    if here() { path.into() } else { root.join(path) }
}

/// Scenes that a run has where none are named: those that are quick.
pub(crate) const SMALL: [&str; 5] = ["cornell", "touching", "occluder", "room", "field-100"];
/// What the name `fields` stands for: how time and memory grow.
const FIELDS: [&str; 4] = ["field-100", "field-1000", "field-10000", "field-100000"];

/// Lamps above a field of boxes.
const LAMPS: usize = 3;

/// A scene to be baked, and how finely where it is not as all others: `room`, `room@0.03`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    /// As it was written.
    pub(crate) told: String,
    /// Name or path of the scene.
    pub(crate) name: String,
    /// A tolerance of its own.
    pub(crate) tolerance: Option<f64>,
}

impl Wanted {
    /// What a word of the command line asks for: a scene or a group of scenes.
    pub(crate) fn of(word: &str) -> Vec<Self> {
        // A path may hold the sign, too.
        let own = word.rsplit_once('@').and_then(|(name, t)| positive(t).ok().map(|t| (name, t)));
        let (name, tolerance) = own.map_or((word, None), |(name, tolerance)| (name, Some(tolerance)));
        let names = if name == "fields" { FIELDS.to_vec() } else { vec![name] };
        let suffix = &word[name.len()..];
        names.into_iter().map(|name| Self { told: format!("{name}{suffix}"), name: name.into(), tolerance }).collect()
    }
}

/// The file of a scene of the project.
fn file(name: &str) -> Option<PathBuf> {
    let file = match name {
        "cornell" => "cornell.glb",
        "touching" => "touching.glb",
        "occluder" => "occluder.glb",
        "room" => "room.obj",
        "home" => "../others/single_family_home.obj",
        _ => return None,
    };
    Some(in_project("testdata/scenes").join(file))
}

/// The number of polygons of a field of boxes, from its name: `field-1000`.
pub(crate) fn field_polygons(name: &str) -> Option<usize> {
    name.strip_prefix("field-")?.parse().ok()
}

/// The scene of a name, or of a path where there is none of that name.
pub(crate) fn scene(name: &str) -> anyhow::Result<Scene> {
    if let Some(polygons) = field_polygons(name) {
        return Ok(box_field(polygons, LAMPS));
    }
    let path = file(name).unwrap_or_else(|| name.into());
    if !path.exists() {
        bail!(
            "{name} is neither a file nor one of: cornell, touching, occluder, room, home, field-N (boxes of N faces in all)"
        );
    }
    let options = ReadOptions::default();
    let unread = || format!("cannot read {}", path.display());
    let (mut scene, mut warnings) = read_scene_with(&path, &options).with_context(unread)?;
    // As `umbrage bake` does it.
    let beside = Overrides::path_beside(&path);
    if beside.exists() {
        warnings.extend(Overrides::read(&beside)?.apply(&mut scene, options.max_reflectance)?);
    }
    warnings.iter().for_each(|warning| crate::tell(&format!("{name}: {warning}")));
    Ok(scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_small_scene_is_there() {
        for name in SMALL {
            assert!(scene(name).unwrap().polygon_count() > 2, "{name}");
        }
    }

    #[test]
    fn light_that_is_said_beside_a_scene_is_in_it() {
        assert!(scene("home").unwrap().materials.iter().any(|material| material.emits()));
    }

    #[test]
    fn a_scene_may_have_a_tolerance_of_its_own() {
        let wanted = |name: &str, suffix: &str, tolerance| Wanted {
            told: format!("{name}{suffix}"),
            name: name.into(),
            tolerance,
        };
        assert_eq!(Wanted::of("room"), [wanted("room", "", None)]);
        assert_eq!(Wanted::of("room@0.03"), [wanted("room", "@0.03", Some(0.03))]);
        assert_eq!(Wanted::of("parts/@home/a.glb"), [wanted("parts/@home/a.glb", "", None)]);
        assert_eq!(Wanted::of("fields@0.1"), FIELDS.map(|name| wanted(name, "@0.1", Some(0.1))));
    }

    #[test]
    fn a_field_has_as_many_polygons_as_its_name_says() {
        assert!(scene("field-300").unwrap().polygon_count().abs_diff(300) < 10);
        let unknown = scene("field").unwrap_err().to_string();
        assert!(unknown.starts_with("field is neither a file"), "{unknown}");
    }
}
