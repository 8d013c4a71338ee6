"""The points of testdata/reference, and what a mesh with light at its corners shows there."""

import math
import pathlib
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ["cornell", "touching", "occluder"]
# A triangle further from a point is not its own (share of the extent), nor one that looks another way (cosine).
ON_PLANE_OF_EXTENT = 1e-4
SAME_WAY = 0.999
# A point may lie outside of its triangle by this share of it: corners are rounded.
OUTSIDE = 1e-3


def reference(scene):
    """Positions, normals, irradiance."""
    rows = np.loadtxt(ROOT / "testdata/reference" / f"{scene}.csv", delimiter=",", skiprows=1)
    return rows[:, 0:3], rows[:, 3:6], rows[:, 6:9]


def located(corners, points, normals):
    """For each point the triangle that it lies deepest in, and its barycentric coordinates there; -1 where there is none."""
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.maximum(np.linalg.norm(across, axis=1), 1e-30)
    unit = across / doubled[:, None]
    extent = np.ptp(corners.reshape(-1, 3), axis=0).max()
    found, weights = np.full(len(points), -1), np.zeros((len(points), 3))
    for i, (point, normal) in enumerate(zip(points, normals)):
        near = np.abs(np.einsum("ij,ij->i", point - corners[:, 0], unit)) < ON_PLANE_OF_EXTENT * extent
        own = np.nonzero(near & (unit @ normal > SAME_WAY))[0]
        if len(own) == 0:
            continue
        to = corners[own] - point
        parts = [np.cross(to[:, (k + 1) % 3], to[:, (k + 2) % 3]) for k in range(3)]
        w = np.stack([np.einsum("ij,ij->i", p, unit[own]) / doubled[own] for p in parts], axis=1)
        best = w.min(axis=1).argmax()
        if w[best].min() > -OUTSIDE:
            found[i], weights[i] = own[best], np.clip(w[best], 0, 1)
    return found, weights


def error(shown, truth, covered):
    """Relative root mean square error over points and colours."""
    if covered.mean() < 0.995:
        sys.exit(f"only {covered.sum()} of {len(covered)} reference points are on the mesh")
    return math.sqrt(((shown - truth)[covered] ** 2).mean()) / truth.mean()


def error_of_triangles(scene, corners, light):
    """Error of light that is linear over triangles, at the reference points of a scene."""
    points, normals, truth = reference(scene)
    found, weights = located(corners, points, normals)
    return error(np.einsum("ij,ijk->ik", weights, light[found]), truth, found >= 0)
