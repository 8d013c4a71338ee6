//! Direct light as a field, which knows what may stand between each leaf and the emitters.
//!
//! Most leaves have nothing there: then the light at each of their points is a closed form.

use rayon::prelude::*;

use super::field::Field;
use crate::id::PatchId;
use crate::mesh::Mesh;
use crate::progress::Cancelled;
use crate::scene::Rgb;
use crate::transport::{DirectLight, Obstacles};
use crate::visibility::ReceiverPoint;

/// Direct light as a field.
#[derive(Debug)]
pub(super) struct Direct<'a> {
    light: &'a DirectLight<'a>,
    /// Of the leaves that were looked around, by the number of the patch.
    obstacles: Vec<Option<Obstacles>>,
}

impl<'a> Direct<'a> {
    /// The field, which knows of no obstacles yet.
    pub(super) fn new(light: &'a DirectLight<'a>) -> Self {
        Self { light, obstacles: Vec::new() }
    }

    /// The obstacles of the smallest patch around a patch that was looked around.
    fn around(&self, mesh: &Mesh, patch: PatchId) -> Option<&Obstacles> {
        let mut around = std::iter::successors(Some(patch), |&patch| mesh.patch(patch).parent);
        around.find_map(|patch| self.obstacles.get(patch.index())?.as_ref())
    }
}

impl Field for Direct<'_> {
    fn look_around(
        &mut self,
        mesh: &Mesh,
        leaves: &[PatchId],
        report: &(impl Fn() -> Result<(), Cancelled> + Sync),
    ) -> Result<(), Cancelled> {
        self.obstacles.resize(mesh.patch_count(), None);
        let is_new = |leaf: &&PatchId| self.obstacles[leaf.index()].is_none();
        let looked_around = |&leaf: &PatchId| {
            report()?;
            let around = mesh.patch(leaf).parent.and_then(|parent| self.around(mesh, parent));
            Ok((leaf, self.light.obstacles(mesh, leaf, around)))
        };
        let found = leaves.par_iter().filter(is_new).map(looked_around).collect::<Result<Vec<_>, Cancelled>>()?;
        for (leaf, obstacles) in found {
            self.obstacles[leaf.index()] = Some(obstacles);
            // Both parts of a patch that is split are new at one time: no one asks for what is around it any more.
            if let Some(parent) = mesh.patch(leaf).parent {
                self.obstacles[parent.index()] = None;
            }
        }
        Ok(())
    }

    fn at(&self, mesh: &Mesh, point: &ReceiverPoint, patch: PatchId) -> Rgb {
        self.light.at_past(point, self.around(mesh, patch))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::id::Table;
    use crate::mesh::MeshSettings;
    use crate::prepare::prepare;
    use crate::progress::Progress;
    use crate::scene::cornell::cornell_box;
    use crate::shade::field::Places;
    use crate::visibility::Visibility;

    #[test]
    fn what_was_looked_around_is_lit_as_by_all_faces() {
        let scene = cornell_box();
        let prepared = prepare(&scene, Progress::silent()).unwrap();
        let visibility = Visibility::new(&prepared);
        let light = DirectLight::new(&scene, &prepared, &visibility);
        let (mut mesh, places) = (Mesh::new(&prepared, &Table::new(), MeshSettings::default()), Places::new(&prepared));
        let mut field = Direct::new(&light);
        let mut in_penumbra = 0;
        for _ in 0..7 {
            let leaves: Vec<PatchId> = mesh.leaves().collect();
            field.look_around(&mesh, &leaves, &|| Ok(())).unwrap();
            for &leaf in &leaves {
                let corners = mesh.corners(leaf).map(|corner| mesh.vertex_m(corner));
                for at_m in corners.chain([mesh.patch(leaf).centroid_m]) {
                    let point = places.inside(&mesh, leaf, at_m);
                    let (near, truth) = (field.at(&mesh, &point, leaf), light.at(&point));
                    assert!((near - truth).abs().max_element() < 1e-12, "{near} is not {truth} at {at_m}");
                }
                let around = field.around(&mesh, leaf).unwrap().before(0).unwrap();
                in_penumbra += usize::from((1..8).contains(&around.len()));
            }
            leaves.into_iter().for_each(|leaf| assert!(mesh.split(leaf)));
        }
        assert!(in_penumbra > 100, "{in_penumbra}");
        let kept = field.obstacles.iter().flatten().count();
        assert!(kept < mesh.patch_count() / 2, "{kept}");
    }
}
