"""Mitsuba 3: its path integrator looks straight at each vertex of Umbrage's mesh from just above, and irradiance is what it sees
times pi over what is reflected there."""

import math
import pathlib
import sys
import tempfile
import time

import numpy as np

import files
from points import ROOT, error_of_triangles, located

# Paths at a time: Mitsuba holds them all in memory.
PATHS_AT_A_TIME = 4_000_000


def write_obj(path, corners):
    """Triangles as OBJ, for Mitsuba to read."""
    lines = ["v {!r} {!r} {!r}\n".format(*map(float, point)) for point in corners.reshape(-1, 3)]
    lines += [f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n" for i in range(len(corners))]
    path.write_text("".join(lines))


def loaded(mi, surfaces):
    """Mitsuba's scene."""
    with tempfile.TemporaryDirectory() as folder:
        parts = {"type": "scene", "integrator": {"type": "path", "max_depth": 64, "rr_depth": 5}}
        for i, surface in enumerate(surfaces):
            file = pathlib.Path(folder) / f"{i}.obj"
            write_obj(file, surface.corners)
            colour = {"type": "rgb", "value": surface.reflectance.tolist()}
            part = {"type": "obj", "filename": str(file), "face_normals": True}
            part["bsdf"] = {"type": "diffuse", "reflectance": colour}
            if surface.radiance.any():
                radiance = {"type": "rgb", "value": surface.radiance.tolist()}
                part["emitter"] = {"type": "area", "radiance": radiance}
            parts[f"part{i}"] = part
        return mi.load_dict(parts)


def rows(scene, umbrage, args):
    """What there is to tell of a scene: by whom, seconds, error, of what."""
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb")
    surfaces = files.scene(ROOT / f"testdata/scenes/{scene}.glb")
    if not any(surface.reflectance.any() for surface in surfaces):
        print(f"{scene}: left out for Mitsuba, which is asked for reflected light; nothing reflects", file=sys.stderr)
        return
    world = loaded(mi, surfaces)
    # What is reflected at each vertex: that of the surface below.
    corners = np.concatenate([surface.corners for surface in surfaces])
    reflected = np.concatenate([np.tile(surface.reflectance, (len(surface.corners), 1)) for surface in surfaces])
    points, normals = umbrage.inside(), umbrage.normals
    found, _ = located(corners, points, normals)
    reflectance = np.where((found >= 0)[:, None], reflected[found], 0)

    def seen(numbers, samples, seed):
        """Mean radiance that comes up from vertices."""
        each = np.repeat(numbers, samples)
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, len(each))
        ray = mi.RayDifferential3f(mi.Ray3f(mi.Point3f(points[each].T), mi.Vector3f(-normals[each].T)))
        radiance, _, _ = world.integrator().sample(world, sampler, ray)
        return np.array(radiance).T.reshape(len(numbers), samples, 3).mean(axis=1)

    lit = np.nonzero(reflectance.any(axis=1))[0]
    seen(lit[:1], 1, 0)  # Kernels are compiled before time is taken.
    at_a_time = max(1, PATHS_AT_A_TIME // args.vertex_samples)
    irradiance = np.zeros_like(points)
    begin = time.perf_counter()
    for start in range(0, len(lit), at_a_time):
        numbers = lit[start : start + at_a_time]
        with np.errstate(divide="ignore", invalid="ignore"):
            light = math.pi * seen(numbers, args.vertex_samples, start + 1) / reflectance[numbers]
        irradiance[numbers] = np.where(reflectance[numbers] > 0, light, 0)
    seconds = time.perf_counter() - begin
    wrong = error_of_triangles(scene, umbrage.positions[umbrage.triangles], irradiance[umbrage.triangles])
    yield "Mitsuba 3, vertices", seconds, wrong, f"{len(lit)} vertices, {args.vertex_samples} paths each"
