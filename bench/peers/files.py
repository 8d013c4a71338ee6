"""GLB files: what the scenes of testdata/scenes are made of, and what Umbrage baked."""

import dataclasses
import json
import struct
import sys

import numpy as np

# How far into its triangle a vertex is moved, as a share of the way to the centroid, and how far above it, of the extent.
INSIDE = 1e-3
ABOVE = 3e-5


@dataclasses.dataclass
class Surface:
    """Triangles of one material, which is diffuse on its front and black on its back."""

    corners: np.ndarray
    # The number of the polygon that each triangle is of.
    polygon: np.ndarray
    # Both red, green and blue; radiance in W/(m2 sr).
    reflectance: np.ndarray
    radiance: np.ndarray

    def outlines(self):
        """The corners of each polygon, in order."""
        for number in np.unique(self.polygon):
            triangles = [[tuple(corner) for corner in triangle] for triangle in self.corners[self.polygon == number]]
            sides = {(t[k], t[(k + 1) % 3]) for t in triangles for k in range(3)}
            # A side that is passed both ways is inside.
            following = {start: end for start, end in sides if (end, start) not in sides}
            outline = [min(following)]
            while following[outline[-1]] != outline[0]:
                outline.append(following[outline[-1]])
            yield np.array(outline)


@dataclasses.dataclass
class Baked:
    """A baked mesh: positions, normals and irradiance of its vertices, and which of them are the corners of each triangle."""

    positions: np.ndarray
    normals: np.ndarray
    irradiance: np.ndarray
    triangles: np.ndarray

    def inside(self):
        """The vertices, each moved a little into one of its triangles, for on an edge light may have two values; and above it, for
        something may stand on it."""
        centroids = self.positions[self.triangles].mean(axis=1)
        of = np.zeros(len(self.positions), int)
        of[self.triangles] = np.arange(len(self.triangles))[:, None]
        above = ABOVE * np.ptp(self.positions, axis=0).max() * self.normals
        return self.positions + INSIDE * (centroids[of] - self.positions) + above


def primitives(path):
    """The file's JSON, and for each primitive itself, its offset, and a function that reads an accessor."""
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    gltf = json.loads(data[20 : 20 + length])
    binary = data[20 + length + 8 :]
    found = []

    def table(index):
        accessor = gltf["accessors"][index]
        view = gltf["bufferViews"][accessor["bufferView"]]
        kind = {5125: np.uint32, 5126: np.float32}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        if view.get("byteStride", width * 4) != width * 4:
            sys.exit(f"{path}: strides are not understood")
        return np.frombuffer(binary, kind, accessor["count"] * width, start).reshape(-1, width)

    def walk(number, offset):
        node = gltf["nodes"][number]
        if set(node) & {"matrix", "rotation", "scale"}:
            sys.exit(f"{path}: only translations are understood")
        offset = offset + np.array(node.get("translation", [0, 0, 0]))
        for primitive in gltf["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            found.append((primitive, offset))
        for child in node.get("children", []):
            walk(child, offset)

    for number in gltf["scenes"][gltf.get("scene", 0)]["nodes"]:
        walk(number, np.zeros(3))
    return gltf, found, table


def scene(path):
    """The surfaces of a scene."""
    gltf, found, table = primitives(path)
    surfaces = []
    for primitive, offset in found:
        material = gltf["materials"][primitive["material"]]
        strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
        indices = table(primitive["indices"]).reshape(-1, 3)
        surfaces.append(
            Surface(
                table(primitive["attributes"]["POSITION"])[indices].astype(float) + offset,
                table(primitive["attributes"]["_POLYGON"])[indices[:, 0]].ravel(),
                np.array(material["pbrMetallicRoughness"]["baseColorFactor"][:3]),
                strength * np.array(material.get("emissiveFactor", [0, 0, 0])),
            )
        )
    return surfaces


def baked(path):
    """A file that Umbrage baked."""
    _, found, table = primitives(path)
    parts = {name: [] for name in ["POSITION", "NORMAL", "_IRRADIANCE"]}
    triangles, count = [], 0
    for primitive, offset in found:
        for name, values in parts.items():
            values.append(table(primitive["attributes"][name]).astype(float) + (offset if name == "POSITION" else 0))
        triangles.append(table(primitive["indices"]).reshape(-1, 3).astype(int) + count)
        count += len(parts["POSITION"][-1])
    positions, normals, irradiance = (np.concatenate(values) for values in parts.values())
    return Baked(positions, normals, irradiance, np.concatenate(triangles))
