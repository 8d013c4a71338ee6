//! A field of irradiance on the mesh, and its values at the points where the mesh needs them.
//!
//! A value belongs to a point *of a side*: of all coplanar faces that look the same way, of all facets that are one smooth surface
//! there ([`super::joints`]), or of one patch alone where a contact (D0) passes through the point, since the value jumps there. The
//! limit is taken from inside a patch: at a vertex, a little towards the middle of the patch.
//!
//! Holds: what is interpolated between values is continuous over a smooth surface, since facets share them along their edges.
//!
//! Values are kept, so that a point that serves the estimate of the error and later the mesh is evaluated once.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::joints::Joints;
use crate::discontinuity::is_contact;
use crate::geometry::polygon;
use crate::id::{EdgeId, FaceId, PatchId, PlaneId, Table, VertexId};
use crate::mesh::{BoundaryPoint, Mesh};
use crate::prepare::{Facing, Prepared};
use crate::progress::{Cancelled, Progress, Stage};
use crate::scene::Rgb;
use crate::transport::BrightPlace;
use crate::visibility::ReceiverPoint;

/// How far inside a patch its limit at a vertex is taken, as a share of the distance to its centroid.
const INSIDE: f64 = 1e-3;
/// And at most this share of the extent: then the limit is good to about as much.
const INSIDE_OF_EXTENT: f64 = 1e-5;
/// Cuts along jumps lie within one shortest edge of the mesh of where light jumps: what is farther from all sides of a patch by this
/// factor is on the patch's side.
const JUMPS_WITHIN_FINEST: f64 = 1.5;
/// Points evaluated between two reports of progress.
const POINTS_A_REPORT: usize = 16;

/// Irradiance as a function of the place.
pub(super) trait Field: Sync {
    /// Prepares the evaluation at many points of these leaves.
    ///
    /// # Errors
    /// [`Cancelled`] where `report`, which is called for each of them, asks to stop.
    fn look_around(
        &mut self,
        _: &Mesh,
        _leaves: &[PatchId],
        _report: &(impl Fn() -> Result<(), Cancelled> + Sync),
    ) -> Result<(), Cancelled> {
        Ok(())
    }

    /// Places that sources are known to light: the field must be looked at there.
    fn bright_places(&self) -> &[BrightPlace] {
        &[]
    }

    /// Returns the irradiance around a patch, in W/m2, which its errors are compared with; where nothing is known of it, plenty.
    fn around(&self, _: &Mesh, _: PatchId) -> f64 {
        f64::INFINITY
    }

    /// Irradiance at a point of `patch`, in W/m2.
    fn at(&self, mesh: &Mesh, point: &ReceiverPoint, patch: PatchId) -> Rgb;
}

/// The side that a value belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Side {
    /// All coplanar faces that look this way.
    Plane(PlaneId, Facing),
    /// All facets that are one smooth surface here with this one, the least of them.
    Surface(FaceId),
    /// This patch alone: a contact passes through the point.
    Patch(PatchId),
}

/// A point of the mesh: the middle between two vertices, or a vertex that is not the middle of the edge that it split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct MeshPoint {
    vertices: [VertexId; 2],
    side: Side,
}

impl MeshPoint {
    /// Whether its value holds for all patches of a plane or smooth surface around it: no contact passes through it.
    pub(super) fn is_shared(&self) -> bool {
        !matches!(self.side, Side::Patch(_))
    }
}

/// A point to be evaluated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Request {
    pub(super) key: MeshPoint,
    pub(super) point: ReceiverPoint,
    pub(super) patch: PatchId,
}

/// Where contacts are, and how the points of patches are named.
#[derive(Debug)]
pub(super) struct Places<'a> {
    prepared: &'a Prepared,
    /// Whether a contact passes through a vertex of the prepared faces.
    contact_vertices: Table<VertexId, bool>,
    /// Whether a contact runs along an edge of the prepared faces.
    contact_edges: Vec<bool>,
    /// Where facets are one smooth surface.
    joints: Joints,
}

impl<'a> Places<'a> {
    pub(super) fn new(prepared: &'a Prepared) -> Self {
        let mut contact_vertices: Table<VertexId, bool> = vec![false; prepared.vertices_m.len()].into();
        let mut contact_edges = Vec::with_capacity(prepared.edges.len());
        for (id, edge) in prepared.edges.iter_enumerated() {
            let contact = edge.faces.iter().any(|&face| is_contact(prepared, id, face));
            contact_edges.push(contact);
            if contact {
                edge.ends.iter().for_each(|&end| contact_vertices[end] = true);
            }
        }
        // Around the foot of a thing the light still depends on the direction, though what is beneath it is hidden.
        for rim in &prepared.rims {
            prepared.edges[rim.edge].ends.iter().for_each(|&end| contact_vertices[end] = true);
        }
        Self { prepared, contact_vertices, contact_edges, joints: Joints::new(prepared) }
    }

    /// The scene's extent, in metres.
    pub(super) fn extent_m(&self) -> f64 {
        self.prepared.tolerance.extent_m
    }

    /// Whether a vertex is where contacts end or turn: there irradiance depends on the direction from which one comes.
    pub(super) fn is_contact_corner(&self, mesh: &Mesh, vertex: VertexId) -> bool {
        mesh.split_root(vertex).is_none() && self.contact_vertices[vertex]
    }

    fn on_contact(&self, mesh: &Mesh, vertex: VertexId) -> bool {
        mesh.is_jump_vertex(vertex)
            || match mesh.split_root(vertex) {
                Some(root) => self.contact_edges.get(root.index()).copied().unwrap_or(false),
                None => self.contact_vertices[vertex],
            }
    }

    /// The side of a point of `patch`; `surface` tells, of a face that is smooth, which surface it is there.
    fn side(&self, mesh: &Mesh, patch: PatchId, jumps: bool, surface: impl Fn(FaceId) -> FaceId) -> Side {
        let id = mesh.patch(patch).face;
        let face = &self.prepared.faces[id];
        match (jumps, self.prepared.is_smooth(id)) {
            (true, _) => Side::Patch(patch),
            (false, true) => Side::Surface(surface(id)),
            (false, false) => Side::Plane(face.plane, face.facing),
        }
    }

    /// The surface of a facet on an edge of the mesh: inside the facet, that is the facet.
    fn surface_at(&self, root: EdgeId, face: FaceId) -> FaceId {
        if root.index() < self.contact_edges.len() { self.joints.at_edge(root, face) } else { face }
    }

    /// Whether two faces beside an edge of the mesh, with this root, receive the same light along it, but for contacts.
    pub(super) fn is_one_side(&self, root: EdgeId, [one, other]: [FaceId; 2]) -> bool {
        if [one, other].iter().any(|&face| self.prepared.is_smooth(face)) {
            return self.surface_at(root, one) == self.surface_at(root, other);
        }
        let side = |face: FaceId| (self.prepared.faces[face].plane, self.prepared.faces[face].facing);
        side(one) == side(other)
    }

    /// The receiver point of `patch` next to `at_m`, which lies on its boundary.
    pub(super) fn inside(&self, mesh: &Mesh, patch: PatchId, at_m: DVec3) -> ReceiverPoint {
        let inward = mesh.patch(patch).centroid_m - at_m;
        let most_m = INSIDE_OF_EXTENT * self.prepared.tolerance.extent_m;
        let step_m = (INSIDE * inward.length()).min(most_m);
        self.receiver(mesh.patch(patch).face, at_m + step_m * inward.normalize_or_zero())
    }

    fn receiver(&self, face: FaceId, position_m: DVec3) -> ReceiverPoint {
        if self.prepared.is_smooth(face) {
            return ReceiverPoint::on_face(self.prepared, face, position_m);
        }
        ReceiverPoint::on_flat_face(self.prepared, face, position_m)
    }

    /// A receiver point that belongs to the side of a jump that the convex polygon `corners_m` of a face lies on.
    pub(super) fn beside_jump(
        &self,
        mesh: &Mesh,
        patch: PatchId,
        point: ReceiverPoint,
        corners_m: &[DVec3],
    ) -> ReceiverPoint {
        let centroid_m = polygon::centroid(corners_m);
        let clear_m = clear_m(corners_m, centroid_m);
        // From a point of the polygon to the centroid the distance to all sides grows at least in proportion.
        let share = (JUMPS_WITHIN_FINEST * mesh.finest_of(patch) / clear_m.max(f64::MIN_POSITIVE)).min(1.0);
        let inside = self.receiver(mesh.patch(patch).face, point.position_m.lerp(centroid_m, share));
        point.beside_jump(&inside)
    }

    /// The name of the value at a boundary point of a patch.
    pub(super) fn vertex_key(&self, mesh: &Mesh, patch: PatchId, vertex: VertexId) -> MeshPoint {
        let surface = |face| match mesh.split_root(vertex) {
            Some(root) => self.surface_at(root, face),
            None => self.joints.at_vertex(vertex, face),
        };
        let side = self.side(mesh, patch, self.on_contact(mesh, vertex), surface);
        MeshPoint { vertices: sorted(mesh.halved_by(vertex).unwrap_or([vertex; 2])), side }
    }

    /// The value at a boundary point of a patch.
    pub(super) fn vertex(&self, mesh: &Mesh, patch: PatchId, vertex: VertexId) -> Request {
        let key = self.vertex_key(mesh, patch, vertex);
        let at_m = mesh.vertex_m(vertex);
        let point = if mesh.is_jump_vertex(vertex) {
            self.beside_jump(mesh, patch, self.inside(mesh, patch, at_m), &mesh.polygon_m(patch))
        } else {
            self.inside(mesh, patch, at_m)
        };
        Request { key, point, patch }
    }

    /// The name of the value in the middle between two boundary points of a patch.
    pub(super) fn middle_key(&self, mesh: &Mesh, patch: PatchId, ends: [&BoundaryPoint; 2]) -> MeshPoint {
        let vertices = sorted(ends.map(|end| end.vertex));
        let along = ends.iter().map(|end| end.leaf.edge).find(|&edge| sorted(mesh.edges().ends(edge)) == vertices);
        let surface = |face| along.map_or(face, |edge| self.surface_at(mesh.edges().root(edge), face));
        let jumps = ends.iter().any(|end| {
            let root = mesh.edges().root(end.leaf.edge);
            mesh.is_jump(root) || self.contact_edges.get(root.index()).copied().unwrap_or(false)
        });
        MeshPoint { vertices, side: self.side(mesh, patch, jumps, surface) }
    }

    /// The value in the middle between two boundary points of a patch.
    pub(super) fn middle(&self, mesh: &Mesh, patch: PatchId, ends: [&BoundaryPoint; 2]) -> Request {
        let key = self.middle_key(mesh, patch, ends);
        let at_m = mesh.vertex_m(key.vertices[0]).midpoint(mesh.vertex_m(key.vertices[1]));
        let point = self.inside(mesh, patch, at_m);
        let is_jump = ends.iter().any(|end| mesh.is_jump(mesh.edges().root(end.leaf.edge)));
        let point = if is_jump { self.beside_jump(mesh, patch, point, &mesh.polygon_m(patch)) } else { point };
        Request { key, point, patch }
    }
}

/// Distance of a point inside a convex polygon from its nearest side, in metres.
fn clear_m(corners_m: &[DVec3], point_m: DVec3) -> f64 {
    let side = |(i, &from_m): (usize, &DVec3)| {
        let along = corners_m[(i + 1) % corners_m.len()] - from_m;
        along.cross(point_m - from_m).length() / along.length().max(f64::MIN_POSITIVE)
    };
    corners_m.iter().enumerate().map(side).fold(f64::INFINITY, f64::min)
}

fn sorted(mut vertices: [VertexId; 2]) -> [VertexId; 2] {
    vertices.sort_unstable();
    vertices
}

/// Requests in the order of their keys, one for each.
fn distinct(mut requests: Vec<Request>) -> Vec<Request> {
    requests.par_sort_by_key(|request| (request.key, request.patch));
    requests.dedup_by_key(|request| request.key);
    requests
}

/// Values of a field at points of the mesh, numbered in the order in which they were asked for.
#[derive(Debug, Default)]
pub(super) struct Values {
    numbers: FxHashMap<MeshPoint, u32>,
    values: Vec<Rgb>,
}

impl Values {
    /// The value of a point that was evaluated.
    pub(super) fn get(&self, key: &MeshPoint) -> Option<Rgb> {
        self.number(key).map(|number| self.values[number as usize])
    }

    /// The number of a point that was evaluated.
    pub(super) fn number(&self, key: &MeshPoint) -> Option<u32> {
        self.numbers.get(key).copied()
    }

    /// All values, by number.
    pub(super) fn as_slice(&self) -> &[Rgb] {
        &self.values
    }

    /// Adds to each value.
    pub(super) fn shift(&mut self, by: &[Rgb]) {
        self.values.iter_mut().zip(by).for_each(|(value, by)| *value += *by);
    }

    /// Evaluates what is not known yet.
    pub(super) fn evaluate(
        &mut self,
        mesh: &Mesh,
        field: &impl Field,
        requests: Vec<Request>,
        stage: Stage,
        progress: Progress<'_>,
    ) -> Result<(), Cancelled> {
        let is_new = |request: &Request| !self.numbers.contains_key(&request.key);
        let requests = distinct(requests.into_par_iter().filter(is_new).collect());
        let known = self.values.len();
        let values = requests
            .par_iter()
            .enumerate()
            .map(|(number, request)| {
                if number.is_multiple_of(POINTS_A_REPORT) {
                    progress.report(stage, number, requests.len())?;
                }
                Ok(field.at(mesh, &request.point, request.patch))
            })
            .collect::<Result<Vec<Rgb>, Cancelled>>()?;
        self.numbers.extend(requests.iter().enumerate().map(|(i, request)| (request.key, (known + i) as u32)));
        self.values.extend(values);
        Ok(())
    }
}
