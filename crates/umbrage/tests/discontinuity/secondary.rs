//! Bright parts of faces as sources: a spot of light on a ceiling and a patch of sun on a floor, which alone reflect,
//! and a plate whose shadow in that light is known by hand. +Z is up.

use glam::{DVec2, DVec3, Vec3Swizzles as _};
use umbrage::bake::{BakeSettings, Meshed, bake, subdivided};
use umbrage::discontinuity::{DSegment, Degree, Event, Reflecting, find_secondary};
use umbrage::id::PatchId;
use umbrage::prepare::Prepared;
use umbrage::progress::Progress;
use umbrage::scene::{Lamp, LampKind, Material, Rgb, Scene};
use umbrage::shade::ShadeSettings;
use umbrage::transport::{DirectLight, Linear};
use umbrage::visibility::Visibility;

use super::build::{add, quad};

/// Where the ceiling is, over the floor.
const CEILING_M: f64 = 2.0;
/// Rounding of `f32` coordinates, and by how much a part lies in front of its faces, magnified by a shadow.
const ROUNDING_M: f64 = 1e-4;
const REFLECTANCE: f64 = 0.8;

/// Fine enough for a small spot.
fn settings() -> BakeSettings {
    BakeSettings { shade: ShadeSettings { tolerance: 0.003, ..ShadeSettings::default() }, ..BakeSettings::default() }
}

/// The prepared faces of a scene and what its direct light, once reflected, casts: all there is, if no two faces that
/// reflect see one another.
fn cast(scene: &Scene) -> (Prepared, Vec<DSegment>) {
    let Meshed { prepared, mesh, .. } = subdivided(scene, &settings(), Progress::silent()).unwrap();
    let visibility = Visibility::new(&prepared);
    let leaves: Vec<PatchId> = mesh.leaves().collect();
    let light = DirectLight::new(scene, &prepared, &visibility).over_leaves_of(&mesh, &leaves);

    let reflecting = |(&leaf, light): (&PatchId, &Linear<Rgb>)| {
        let face = mesh.patch(leaf).face;
        let reflectance = scene.materials[prepared.faces[face].material].reflectance;
        let boundary = mesh.boundary(leaf).iter().map(|at| (at.vertex, mesh.vertex_m(at.vertex))).collect();
        Reflecting { face, boundary, reflected: reflectance * light.mean.max(Rgb::ZERO) }
    };
    let patches: Vec<Reflecting> = leaves.iter().zip(&light).map(reflecting).collect();
    let found = find_secondary(scene, &prepared, &visibility, &patches, 0.0, Progress::silent()).unwrap();
    (prepared, found.raw)
}

/// The lines through segments that look at the viewer along `normal` in the plane at a height.
fn at_height<'a>(prepared: &Prepared, segments: &'a [DSegment], normal: DVec3, height_m: f64) -> Vec<&'a DSegment> {
    let lies = |segment: &&DSegment| {
        prepared.normal(segment.face).dot(normal) > 0.999
            && segment.ends_m.iter().all(|end| (end.z + prepared.origin_m.z - height_m).abs() < ROUNDING_M)
    };
    segments.iter().filter(lies).collect()
}

fn down(middle: DVec3, half_m: f64) -> Vec<DVec3> {
    quad(middle, half_m * DVec3::X, -half_m * DVec3::Y)
}

/// A plate over a black floor, under a white ceiling.
fn under_a_ceiling(lamp: LampKind) -> Scene {
    let mut scene = Scene::default();
    let floor = quad(DVec3::ZERO, 1.5 * DVec3::X, 1.5 * DVec3::Y);
    // Turned, so that no side of the spot's outline is parallel to it.
    let along = DVec2::from_angle(0.27);
    let halves_m = [along, along.perp()].map(|way| (PLATE_HALF_M * way).extend(0.0));
    let plate = quad(PLATE_M, halves_m[0], halves_m[1]);
    add(&mut scene, Material::diffuse("black", Rgb::ZERO), &[floor, plate]);
    let ceiling = Material::diffuse("ceiling", Rgb::splat(REFLECTANCE));
    add(&mut scene, ceiling, &[down(CEILING_M * DVec3::Z, 1.5)]);
    scene.lamps.push(Lamp { name: "lamp".into(), kind: lamp });
    scene
}

/// Next to the floor, so that penumbrae are narrow.
const PLATE_M: DVec3 = DVec3::new(0.4, 0.3, 0.02);
const PLATE_HALF_M: f64 = 0.1;
/// Radius of the spot of light on the ceiling.
const SPOT_M: f64 = 0.15;

/// A lamp that throws a spot on the ceiling, a metre above it, which is even within this share of its radius.
fn spot(even: f64) -> LampKind {
    LampKind::Spot {
        position_m: (CEILING_M - 1.0) * DVec3::Z,
        direction: DVec3::Z,
        intensity: Rgb::splat(10.0),
        range_m: None,
        inner_rad: (even * SPOT_M).atan(),
        outer_rad: SPOT_M.atan(),
    }
}

/// A cone with a border.
const HARD: f64 = 0.95;

/// Where the line between two points of a plane at the height `z` meets another.
fn meeting([p, q]: [DVec2; 2], [r, s]: [DVec2; 2]) -> DVec2 {
    p + (q - p) * ((r - p).perp_dot(s - r) / (q - p).perp_dot(s - r))
}

fn distance_m(point: DVec2, [p, q]: [DVec2; 2]) -> f64 {
    (point - p).perp_dot((q - p).normalize()).abs()
}

#[test]
fn a_spot_on_a_ceiling_casts_what_one_polygon_in_its_place_would() {
    let (prepared, segments) = cast(&under_a_ceiling(spot(HARD)));
    let floor = at_height(&prepared, &segments, DVec3::Z, 0.0);
    assert!(floor.len() >= 24, "at least a triangle, a plate of four edges and corners: {}", floor.len());
    let origin = prepared.origin_m;
    // A point of the floor behind one of the plate, as seen from the ceiling: back there, at the height of the ceiling.
    let back = |on_floor: DVec3, on_plate: DVec3| {
        on_floor.xy() + (on_plate - on_floor).xy() * CEILING_M / (on_plate.z - on_floor.z)
    };
    let world = |segment: &DSegment| segment.ends_m.map(|end| end + origin);
    // The plane through a plate's edge and the line on the floor meets the ceiling in a line through the source's
    // vertex: two such planes tell where that is.
    let mut lines: Vec<(usize, [DVec2; 2])> = Vec::new();
    for segment in &floor {
        let Event::VertexEdge { source, occluder, .. } = segment.event else { continue };
        assert_eq!(segment.degree, Degree::D2);
        let edge = prepared.edges[occluder].ends.map(|v| prepared.vertices_m[v] + origin);
        let ends = world(segment);
        // Edge and line are parallel in space: the plate and the floor are.
        lines.push((source.index(), [back(ends[0], edge[0]), back(ends[1], edge[0])]));
    }
    lines.sort_by_key(|line| line.0);
    let corners: Vec<DVec2> = lines
        .chunk_by(|one, other| one.0 == other.0)
        .map(|of_vertex| {
            let first = of_vertex[0].1;
            let turned = |line: &&(usize, [DVec2; 2])| {
                let [one, other] = [first, line.1].map(|[p, q]| (q - p).normalize());
                one.perp_dot(other).abs() > 0.5
            };
            let corner = meeting(first, of_vertex.iter().find(turned).unwrap().1);
            of_vertex.iter().for_each(|line| assert!(distance_m(corner, line.1) < ROUNDING_M, "{line:?} {corner}"));
            corner
        })
        .collect();
    let [least, most] = [f64::min, f64::max].map(|of| corners.iter().map(|corner| corner.length()).reduce(of).unwrap());
    println!("a spot of {SPOT_M} m: {} corners, {least:.3} to {most:.3} m from its middle", corners.len());
    assert!((4..=8).contains(&corners.len()) && least > 0.5 * SPOT_M && most < 1.15 * SPOT_M, "{corners:?}");
    // The plane through a plate's corner and a line of it meets the ceiling in the line through two of these vertices.
    let mut edges = 0;
    for segment in &floor {
        let Event::EdgeVertex { occluder, .. } = segment.event else { continue };
        let (at, ends) = (prepared.vertices_m[occluder] + origin, world(segment));
        let line = ends.map(|end| back(end, at));
        let on_it = corners.iter().filter(|&&corner| distance_m(corner, line) < ROUNDING_M).count();
        assert_eq!(on_it, 2, "{segment:?} is cast by a side of {corners:?}");
        edges += 1;
    }
    assert!(edges >= 12, "three sides and four corners: {edges}");
}

#[test]
fn what_has_no_bright_part_casts_nothing() {
    let even = LampKind::Directional { direction: DVec3::Z, irradiance: Rgb::splat(10.0) };
    let evenly_lit = under_a_ceiling(even);
    assert!(cast(&evenly_lit).1.is_empty(), "the whole ceiling is bright");
    let secondary = |scene: &Scene| bake(scene, &settings(), Progress::silent()).unwrap().report.secondary;
    assert_eq!(secondary(&evenly_lit), 0);
    assert!(cast(&under_a_ceiling(spot(0.5))).1.is_empty(), "the spot fades: it has no border");
    assert!(secondary(&under_a_ceiling(spot(HARD))) > 0);
}

#[test]
fn a_patch_of_sun_on_a_floor_casts_as_a_lamp_there_would() {
    /// Half a side of the hole in the ceiling.
    const HOLE_M: f64 = 0.25;
    const HALF_M: f64 = 3.0;
    let mut scene = Scene::default();
    let floor = quad(DVec3::ZERO, HALF_M * DVec3::X, HALF_M * DVec3::Y);
    add(&mut scene, Material::diffuse("floor", Rgb::splat(REFLECTANCE)), &[floor]);
    let around: Vec<Vec<DVec3>> = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]
        .map(|[x, y]| {
            let (out, along) = (DVec2::new(x, y), DVec2::new(-y, x));
            let corners =
                [HOLE_M * (out - along), HOLE_M * (out + along), HALF_M * (out + along), HALF_M * (out - along)];
            corners.map(|corner| corner.extend(CEILING_M)).to_vec()
        })
        .to_vec();
    let middle_m = DVec3::new(0.8, 0.0, 0.5 * CEILING_M);
    let plate = quad(middle_m, 0.1 * DVec3::X, 0.1 * DVec3::Y);
    add(&mut scene, Material::diffuse("black", Rgb::ZERO), &[around, vec![plate]].concat());
    let sun = LampKind::Directional { direction: -DVec3::Z, irradiance: Rgb::splat(1000.0) };
    scene.lamps.push(Lamp { name: "sun".into(), kind: sun });

    let (prepared, segments) = cast(&scene);
    let ceiling = at_height(&prepared, &segments, -DVec3::Z, CEILING_M);
    // The plate is half way: a line at twice the plate's edge less the hole's, for each of both.
    let mut lines: Vec<(bool, i64)> = ceiling
        .iter()
        .map(|segment| {
            assert_eq!(segment.degree, Degree::D1, "{segment:?}");
            let [p, q] = segment.ends_m.map(|end| (end + prepared.origin_m).xy());
            let is_x = (p.x - q.x).abs() < ROUNDING_M;
            assert!(is_x || (p.y - q.y).abs() < ROUNDING_M, "{segment:?} is parallel to an axis");
            (is_x, (1e3 * if is_x { p.x } else { p.y }).round() as i64)
        })
        .collect();
    lines.sort_unstable();
    lines.dedup();
    let at = |plate_m: f64| [-0.1, 0.1].map(|edge_m| [-HOLE_M, HOLE_M].map(|hole_m| 2.0 * (plate_m + edge_m) - hole_m));
    let mut expected: Vec<(bool, i64)> = [(true, middle_m.x), (false, middle_m.y)]
        .into_iter()
        .flat_map(|(is_x, plate_m)| {
            at(plate_m).as_flattened().iter().map(|x| (is_x, (1e3 * x).round() as i64)).collect::<Vec<_>>()
        })
        .collect();
    expected.sort_unstable();
    assert_eq!(lines, expected);
}
