//! An oracle beside the paper's: the form factor estimate, weighed by how bright the source is, how much the receiver reflects, how
//! large the patches are, and whether anything stands between them.
//!
//! A bare threshold splits a black curtain as finely as a sunlit wall. What a link errs goes with what it carries: with what
//! the source reflects, and it matters by what the receiver reflects on. How bright patches are must be known before there are
//! links: direct light in the middles of some hundred patches, and one mean for all that bounces more often, is enough.
//!
//! ```text
//! estimate(p, q) * weight > Fmax             weight = brightness^1/2 * size * sight
//!
//! brightness   what the source reflects times the reflectance of the receiver, the greater of both ways, over their means;
//!              its root, since halving the ends of a link about halves its error and doubles the number of links
//! size         what errs on a large patch is more of the mean than what errs on a small one
//! sight        factors of pairs with something between are steeper than those of pairs in clear sight
//! ```
//!
//! The weights were measured: docs/oracle.md.

use rayon::prelude::*;

use super::direct::DirectLight;
use super::link::Node;
use super::oracle::{Decision, FormFactorOracle, Oracle};
use crate::id::{FaceId, PatchId, Table};
use crate::mesh::Mesh;
use crate::prepare::Prepared;
use crate::scene::Scene;
use crate::visibility::{ReceiverPoint, SourcePolygon, Visibility};

/// The weight of brightness lies between this and its inverse: dark patches may be lit by a later bounce.
const LEAST_OF_BRIGHTNESS: f64 = 0.25;
/// The power of area in the weight.
const SIZE_POWER: f64 = 0.15;
/// A patch of so many smallest areas has the weight 1.
const MIDDLE_OF_LEAST_AREAS: f64 = 20.0;
/// The weight of a pair with something between.
const HIDDEN_WEIGHT: f64 = 1.5;

/// Brightness is known of patches of at most the area of all faces over this number.
const PATCHES: f64 = 500.0;
/// No reflectance counts for more in what bounces on and on.
const MOST_REFLECTANCE: f64 = 0.9;

/// Weighs form factors by the light that they carry.
#[derive(Debug)]
pub struct BrightnessOracle<'a> {
    /// The oracle whose estimate is weighed.
    form_factor: FormFactorOracle,
    prepared: &'a Prepared,
    visibility: &'a Visibility,
    /// Coarse patches, and what each reflects, over the three colours, over the area mean of all.
    coarse: Mesh,
    reflected: Table<PatchId, f64>,
    /// Reflectance of the faces, over its area mean.
    reflectance: Table<FaceId, f64>,
}

impl<'a> BrightnessOracle<'a> {
    /// The oracle of a scene whose `mesh` is not split yet; `None` where nothing reflects light.
    pub fn new(
        form_factor: FormFactorOracle,
        scene: &Scene,
        prepared: &'a Prepared,
        visibility: &'a Visibility,
        mesh: &Mesh,
    ) -> Option<Self> {
        let mut coarse = mesh.clone();
        let mut open: Vec<PatchId> = coarse.leaves().collect();
        let most_m2 = open.iter().map(|&leaf| coarse.patch(leaf).area_m2).sum::<f64>() / PATCHES;
        while let Some(patch) = open.pop() {
            if coarse.patch(patch).area_m2 > most_m2 && coarse.split(patch) {
                open.extend(coarse.patch(patch).subpatches.into_iter().flatten());
            }
        }
        let reflected = reflected_by(scene, prepared, &DirectLight::new(scene, prepared, visibility), &coarse);
        Self::with_light(form_factor, scene, prepared, visibility, coarse, reflected)
    }

    /// The oracle of a scene in which the patches of `coarse` reflect this, in W/m2 of the mean over the three colours.
    fn with_light(
        form_factor: FormFactorOracle,
        scene: &Scene,
        prepared: &'a Prepared,
        visibility: &'a Visibility,
        coarse: Mesh,
        mut reflected: Table<PatchId, f64>,
    ) -> Option<Self> {
        let mut reflectance: Table<FaceId, f64> =
            prepared.faces.keys().map(|face| mean_reflectance(scene, prepared, face)).collect();
        let (mut area_m2, mut of_light, mut of_faces) = (0.0, 0.0, 0.0);
        for leaf in coarse.leaves() {
            let patch = coarse.patch(leaf);
            area_m2 += patch.area_m2;
            of_light += patch.area_m2 * reflected[leaf];
            of_faces += patch.area_m2 * reflectance[patch.face];
        }
        if of_light <= 0.0 || of_faces <= 0.0 {
            return None;
        }
        reflected.iter_mut().for_each(|light| *light *= area_m2 / of_light);
        reflectance.iter_mut().for_each(|share| *share *= area_m2 / of_faces);
        Some(Self { form_factor, prepared, visibility, coarse, reflected, reflectance })
    }

    /// What a patch reflects, as far as is known: what the coarse patch of its place does that is not smaller, if there is one.
    fn reflected(&self, mesh: &Mesh, node: Node) -> f64 {
        let patch = mesh.patch(node);
        let mut there = self.coarse.leaf_at(patch.face, patch.centroid_m);
        while let Some(parent) = self.coarse.patch(there).parent
            && self.coarse.patch(there).area_m2 < patch.area_m2
        {
            there = parent;
        }
        self.reflected[there]
    }

    /// The weight of a pair, whatever stands between.
    fn weight(&self, mesh: &Mesh, pair: [Node; 2]) -> f64 {
        let [first, second] = pair;
        let reflectance = |node: Node| self.reflectance[mesh.patch(node).face];
        let there = self.reflected(mesh, first) * reflectance(second);
        let back = self.reflected(mesh, second) * reflectance(first);
        let brightness = there.max(back).sqrt().clamp(LEAST_OF_BRIGHTNESS, 1.0 / LEAST_OF_BRIGHTNESS);
        let larger_m2 = mesh.patch(first).area_m2.max(mesh.patch(second).area_m2);
        brightness * (larger_m2 / (MIDDLE_OF_LEAST_AREAS * self.form_factor.min_area_m2)).powf(SIZE_POWER)
    }

    fn may_be_blocked(&self, mesh: &Mesh, pair: [Node; 2]) -> bool {
        let polygon = |node: Node| SourcePolygon::on_face(self.prepared, mesh.patch(node).face, mesh.polygon_m(node));
        self.visibility.may_be_blocked(&polygon(pair[0]), &polygon(pair[1]))
    }
}

fn mean_reflectance(scene: &Scene, prepared: &Prepared, face: FaceId) -> f64 {
    scene.materials[prepared.faces[face].material].reflectance.element_sum() / 3.0
}

/// About what each patch reflects, in W/m2 of the mean over the three colours: of its direct light in the middle, and of what
/// bounces more often, as if it were the same everywhere.
fn reflected_by(scene: &Scene, prepared: &Prepared, direct: &DirectLight<'_>, mesh: &Mesh) -> Table<PatchId, f64> {
    let leaves: Vec<PatchId> = mesh.leaves().collect();
    let reflectance = |leaf: PatchId| mean_reflectance(scene, prepared, mesh.patch(leaf).face);
    let once = |&leaf: &PatchId| {
        let patch = mesh.patch(leaf);
        let receiver = ReceiverPoint::on_face(prepared, patch.face, patch.centroid_m);
        reflectance(leaf) * direct.at(&receiver).element_sum() / 3.0
    };
    let once: Vec<f64> = leaves.par_iter().map(once).collect();
    let (mut area_m2, mut of_light, mut of_faces) = (0.0, 0.0, 0.0);
    for (&leaf, once) in leaves.iter().zip(&once) {
        area_m2 += mesh.patch(leaf).area_m2;
        of_light += mesh.patch(leaf).area_m2 * once;
        of_faces += mesh.patch(leaf).area_m2 * reflectance(leaf);
    }
    // Irradiance by all later bounces in a closed room.
    let later = of_light / area_m2 / (1.0 - (of_faces / area_m2).min(MOST_REFLECTANCE));
    let mut reflected: Table<PatchId, f64> = vec![0.0; mesh.patch_count()].into();
    for (&leaf, once) in leaves.iter().zip(&once) {
        reflected[leaf] = once + reflectance(leaf) * later;
    }
    for index in (0..mesh.patch_count()).rev() {
        let patch = PatchId::from(index);
        if let Some(parts) = mesh.patch(patch).subpatches {
            let areas_m2 = parts.map(|part| mesh.patch(part).area_m2);
            let power = areas_m2[0] * reflected[parts[0]] + areas_m2[1] * reflected[parts[1]];
            reflected[patch] = power / (areas_m2[0] + areas_m2[1]).max(f64::MIN_POSITIVE);
        }
    }
    reflected
}

impl Oracle for BrightnessOracle<'_> {
    fn decide(&self, mesh: &Mesh, pair: [Node; 2]) -> Decision {
        let Some(estimate) = self.form_factor.estimate(mesh, pair) else { return Decision::Unseen };
        let mut weighed = self.weight(mesh, pair) * estimate;
        // What stands between is looked for only where it decides.
        let decides =
            weighed <= self.form_factor.max_form_factor && HIDDEN_WEIGHT * weighed > self.form_factor.max_form_factor;
        if decides && self.may_be_blocked(mesh, pair) {
            weighed *= HIDDEN_WEIGHT;
        }
        self.form_factor.decide_by(mesh, pair, weighed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshSettings;
    use crate::progress::Progress;
    use crate::scene::{Material, Rgb};
    use crate::transport::{Links, link_all};
    use crate::visibility::fixture;
    use glam::DVec3;

    /// Two cubes apart, a bright and a dark one, or of which one reflects little; `bright` is what the faces of each reflect.
    fn linked(reflectances: [f64; 2], bright: [f64; 2]) -> [usize; 2] {
        let mut polygons = Vec::new();
        for (cube, x) in [0.0, 3.0].into_iter().enumerate() {
            let low = DVec3::new(x, 0.0, 0.0);
            polygons.extend(fixture::inward_box(low, low + 1.0).into_iter().map(|wall| (wall, cube)));
        }
        let prepared = fixture::prepared_of_materials(&polygons);
        let material = |reflectance: f64| Material::diffuse("", Rgb::splat(reflectance));
        let scene = fixture::scene(reflectances.map(material).to_vec());
        let visibility = Visibility::new(&prepared);
        let coarse = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let reflected = coarse.patches().map(|(id, _)| bright[id.index() / 6]).collect();
        let coplanar_m = prepared.tolerance.coplanar_m();
        let form_factor = FormFactorOracle { max_form_factor: 0.05, min_area_m2: 0.001, coplanar_m };
        let oracle =
            BrightnessOracle::with_light(form_factor, &scene, &prepared, &visibility, coarse.clone(), reflected)
                .unwrap();
        let mut mesh = coarse.clone();
        let links: Links = link_all(&prepared, &visibility, &mut mesh, &oracle, Progress::silent()).unwrap();
        let of_cube = |cube: usize| {
            let in_cube = |node: Node| usize::from(mesh.patch(node).centroid_m.x > 2.0) == cube;
            links.as_slice().iter().filter(|link| in_cube(link.receiver) && in_cube(link.source)).count()
        };
        [of_cube(0), of_cube(1)]
    }

    #[test]
    fn where_it_is_bright_there_are_more_links() {
        let [bright, dark] = linked([0.5, 0.5], [2.0, 0.5]);
        assert!(2 * bright > 3 * dark, "{bright} and {dark}");
        let [reflecting, black] = linked([0.8, 0.1], [1.0, 1.0]);
        assert!(2 * reflecting > 3 * black, "{reflecting} and {black}");
        // Alike but for rounding, by which ties between cuts fall one way or the other.
        let [first, second] = linked([0.5, 0.5], [1.0, 1.0]);
        assert!(first.abs_diff(second) * 10 < first, "{first} and {second}");
    }

    #[test]
    fn in_the_dark_there_is_nothing_to_weigh() {
        let prepared = fixture::prepared(&fixture::inward_box(DVec3::ZERO, DVec3::ONE));
        let visibility = Visibility::new(&prepared);
        let coarse = Mesh::new(&prepared, &Table::new(), MeshSettings::default());
        let scene = fixture::scene(vec![Material::diffuse("grey", Rgb::splat(0.5))]);
        let form_factor = FormFactorOracle { max_form_factor: 0.05, min_area_m2: 0.001, coplanar_m: 1e-6 };
        assert!(BrightnessOracle::new(form_factor, &scene, &prepared, &visibility, &coarse).is_none());
    }
}
