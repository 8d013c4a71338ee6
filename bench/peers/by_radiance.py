"""Radiance: rtrace gathers the irradiance at each vertex of Umbrage's mesh, with its ambient cache."""

import os
import pathlib
import tempfile
import time

import numpy as np

import files
from points import ROOT, error_of_triangles

# Radiance's own settings: light between surfaces to many bounces, with a dense cache; lamps cut finely, and not at random.
SETTINGS = "-ab 8 -aa 0.15 -ar 64 -ad 512 -as 128 -lw 1e-3 -ds 0.1 -dt 0 -dc 1 -dj 0".split()


def text(surfaces):
    """The scene in Radiance's words."""

    def numbers(values):
        return " ".join(repr(float(value)) for value in values)

    lines = []
    for i, surface in enumerate(surfaces):
        if surface.radiance.any():
            lines.append(f"void light m{i} 0 0 3 {numbers(surface.radiance)}\n")
        else:
            lines.append(f"void plastic m{i} 0 0 5 {numbers(surface.reflectance)} 0 0\n")
        # Whole polygons: a lamp that is a triangle would be taken for a parallelogram.
        for k, corners in enumerate(surface.outlines()):
            lines.append(f"m{i} polygon p{i}_{k} 0 0 {corners.size} {numbers(corners.ravel())}\n")
    return "".join(lines)


def rows(scene, umbrage, args):
    """What there is to tell of a scene: by whom, seconds, error, of what."""
    import pyradiance

    points, normals = umbrage.inside(), umbrage.normals
    rays = "".join("{!r} {!r} {!r} {!r} {!r} {!r}\n".format(*map(float, ray)) for ray in np.hstack([points, normals]))
    processes = len(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory() as folder:
        source, octree = (pathlib.Path(folder) / name for name in ["scene.rad", "scene.oct"])
        source.write_text(text(files.scene(ROOT / f"testdata/scenes/{scene}.glb")))
        octree.write_bytes(pyradiance.oconv(str(source)))
        cache = ["-af", str(pathlib.Path(folder) / "cache.amb")]
        begin = time.perf_counter()
        told = pyradiance.rtrace(
            rays.encode(), octree, header=False, irradiance=True, nproc=processes, params=SETTINGS + cache
        )
        seconds = time.perf_counter() - begin
    irradiance = np.array(told.split(), float).reshape(-1, 3)
    wrong = error_of_triangles(scene, umbrage.positions[umbrage.triangles], irradiance[umbrage.triangles])
    yield "Radiance, vertices", seconds, wrong, f"{len(points)} vertices, {' '.join(SETTINGS[:8])}"
