"""Bakes a scene with Blender's Cycles, as a denoised lightmap and into vertices, and with Umbrage: seconds and error of each.

Error is the relative root mean square error of the irradiance at the points of testdata/reference, as docs/convergence.md has it.
Seconds are those of baking and denoising alone for Cycles, and of the whole process for Umbrage. Both use all processors.
"""

import argparse
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

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


# ---------------------------------------------------------------------------------------------------------------- Umbrage


def glb_triangles(path):
    """Corners in the world and irradiance of the triangles of a baked GLB."""
    data = path.read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    gltf = json.loads(data[20 : 20 + length])
    binary = data[20 + length + 8 :]

    def table(index):
        accessor = gltf["accessors"][index]
        view = gltf["bufferViews"][accessor["bufferView"]]
        kind = {5125: np.uint32, 5126: np.float32}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        if view.get("byteStride", width * 4) != width * 4:
            sys.exit(f"{path}: strides are not understood")
        return np.frombuffer(binary, kind, accessor["count"] * width, start).reshape(-1, width)

    corners, light = [], []

    def walk(number, offset):
        node = gltf["nodes"][number]
        if set(node) & {"matrix", "rotation", "scale"}:
            sys.exit(f"{path}: only translations are understood")
        offset = offset + np.array(node.get("translation", [0, 0, 0]))
        for primitive in gltf["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            indices = table(primitive["indices"]).reshape(-1, 3)
            corners.append(table(primitive["attributes"]["POSITION"])[indices].astype(float) + offset)
            light.append(table(primitive["attributes"]["_IRRADIANCE"])[indices].astype(float))
        for child in node.get("children", []):
            walk(child, offset)

    for number in gltf["scenes"][gltf.get("scene", 0)]["nodes"]:
        walk(number, np.zeros(3))
    return np.concatenate(corners), np.concatenate(light)


def by_umbrage(program, scene, tolerance):
    """Seconds, error, triangles."""
    points, normals, truth = reference(scene)
    with tempfile.TemporaryDirectory() as folder:
        baked = pathlib.Path(folder) / "baked.glb"
        begin = time.perf_counter()
        subprocess.run(
            [program, "bake", "--quiet", ROOT / f"testdata/scenes/{scene}.glb", "-o", baked, "--tolerance", str(tolerance)],
            check=True,
        )
        seconds = time.perf_counter() - begin
        corners, light = glb_triangles(baked)
    found, weights = located(corners, points, normals)
    shown = np.einsum("ij,ijk->ik", weights, light[found])
    return seconds, error(shown, truth, found >= 0), len(corners)


# ----------------------------------------------------------------------------------------------------------------- Cycles


def diffuse_only(bpy, material):
    """Replaces a material by one that is diffuse and emits, on its front."""
    principled = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    colour = list(principled.inputs["Base Color"].default_value)
    strength = principled.inputs["Emission Strength"].default_value
    emission = [strength * c for c in list(principled.inputs["Emission Color"].default_value)[:3]]
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    out, mix, add = (nodes.new("ShaderNode" + name) for name in ["OutputMaterial", "MixShader", "AddShader"])
    diffuse, light, black = (nodes.new("ShaderNode" + name) for name in ["BsdfDiffuse", "Emission", "BsdfDiffuse"])
    side = nodes.new("ShaderNodeNewGeometry")
    diffuse.inputs["Color"].default_value = colour
    black.inputs["Color"].default_value = [0, 0, 0, 1]
    light.inputs["Color"].default_value = [*(c / max(max(emission), 1e-30) for c in emission), 1]
    light.inputs["Strength"].default_value = max(emission)
    links.new(diffuse.outputs[0], add.inputs[0])
    links.new(light.outputs[0], add.inputs[1])
    links.new(side.outputs["Backfacing"], mix.inputs[0])
    links.new(add.outputs[0], mix.inputs[1])
    links.new(black.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], out.inputs[0])
    # All that receives light is baked; a reflectance of 0 would be left out by Cycles, though light arrives there.
    if max(colour[:3]) == 0 and max(emission) == 0:
        diffuse.inputs["Color"].default_value = [1e-3, 1e-3, 1e-3, 1]


def loaded(scene, samples):
    """Blender's module with the scene in it as one object, ready to bake."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(ROOT / f"testdata/scenes/{scene}.glb"), loglevel=50)
    for material in bpy.data.materials:
        if material.users > 0:
            diffuse_only(bpy, material)
    meshes = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    bpy.ops.object.select_all(action="DESELECT")
    for thing in meshes:
        thing.select_set(True)
    bpy.context.view_layer.objects.active = meshes[0]
    bpy.ops.object.make_single_user(object=True, obdata=True)
    if len(meshes) > 1:
        bpy.ops.object.join()
    bpy.ops.object.transform_apply(location=True, rotation=True, scale=True)
    # Faces that share corners are one island of the lightmap.
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.remove_doubles(threshold=1e-6)
    bpy.ops.object.mode_set(mode="OBJECT")
    settings = bpy.context.scene
    settings.render.engine = "CYCLES"
    cycles = settings.cycles
    cycles.device = "CPU"
    cycles.samples = samples
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.max_bounces = cycles.diffuse_bounces = 64
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    return bpy


def bake(bpy, target, margin):
    """Bakes diffuse light without colour: irradiance over pi. Seconds."""
    begin = time.perf_counter()
    bpy.ops.object.bake(type="DIFFUSE", pass_filter={"DIRECT", "INDIRECT"}, target=target, margin=margin, use_clear=True)
    return time.perf_counter() - begin


def triangles_of(bpy):
    """Corners of the triangles in glTF's axes, and the loops (face corners) that they are."""
    mesh = bpy.context.object.data
    mesh.calc_loop_triangles()
    corners = np.array([[mesh.vertices[i].co for i in triangle.vertices] for triangle in mesh.loop_triangles])
    loops = np.array([triangle.loops for triangle in mesh.loop_triangles])
    # Blender's Z is up.
    return np.stack([corners[..., 0], corners[..., 2], -corners[..., 1]], axis=-1), loops


def by_lightmap(scene, size, samples):
    """Seconds, error with the denoiser and without it, texels."""
    import pyoidn

    bpy = loaded(scene, samples)
    mesh = bpy.context.object.data
    mesh.uv_layers.active = mesh.uv_layers.new(name="lightmap")
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(island_margin=4 / size)
    bpy.ops.object.mode_set(mode="OBJECT")
    image = bpy.data.images.new("lightmap", size, size, alpha=False, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    for material in mesh.materials:
        node = material.node_tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        material.node_tree.nodes.active = node
    baking = bake(bpy, "IMAGE_TEXTURES", 4)
    noisy = np.array(image.pixels[:], np.float32).reshape(size, size, 4)[..., :3]
    begin = time.perf_counter()
    clean = pyoidn.denoise(noisy, filter_type=pyoidn.OIDN_FILTER_TYPE_RT_LIGHTMAP)
    denoising = time.perf_counter() - begin

    points, normals, truth = reference(scene)
    corners, loops = triangles_of(bpy)
    found, weights = located(corners, points, normals)
    uv = np.array([loop.uv for loop in bpy.context.object.data.uv_layers["lightmap"].data])
    at = np.einsum("ij,ijk->ik", weights, uv[loops[found]]) * size - 0.5

    def shown(texels):
        low = np.floor(at).astype(int)
        part = at - low
        value = np.zeros((len(at), 3))
        for dx in (0, 1):
            for dy in (0, 1):
                x, y = np.clip(low[:, 0] + dx, 0, size - 1), np.clip(low[:, 1] + dy, 0, size - 1)
                weight = np.abs(1 - dx - part[:, 0]) * np.abs(1 - dy - part[:, 1])
                value += weight[:, None] * texels[y, x]
        return math.pi * value

    errors = [error(shown(texels), truth, found >= 0) for texels in (clean, noisy)]
    return baking, denoising, *errors


def by_vertices(scene, most_triangles, samples):
    """Seconds, error, triangles: the mesh is cut evenly first."""
    bpy = loaded(scene, samples)
    thing = bpy.context.object
    while 4 * len(triangles_of(bpy)[1]) <= most_triangles:
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide(number_cuts=1)
        bpy.ops.object.mode_set(mode="OBJECT")
    layer = thing.data.color_attributes.new("light", "FLOAT_COLOR", "CORNER")
    thing.data.attributes.active_color = layer
    seconds = bake(bpy, "VERTEX_COLORS", 0)
    light = np.array([corner.color[:3] for corner in thing.data.color_attributes["light"].data])
    points, normals, truth = reference(scene)
    corners, loops = triangles_of(bpy)
    found, weights = located(corners, points, normals)
    shown = math.pi * np.einsum("ij,ijk->ik", weights, light[loops[found]])
    return seconds, error(shown, truth, found >= 0), len(corners)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default="cornell,touching", help="with commas between: " + ", ".join(SCENES))
    parser.add_argument("--size", type=int, default=512, help="texels on a side of the lightmap")
    parser.add_argument("--samples", type=int, default=64, help="paths from each texel or vertex")
    parser.add_argument("--vertex-samples", type=int, default=256, help="paths from each vertex")
    parser.add_argument("--tolerance", type=float, default=0.01, help="of Umbrage")
    parser.add_argument("--umbrage", default=ROOT / "target/release/umbrage", help="the program")
    args = parser.parse_args()
    rows = [["scene", "by", "seconds", "error", "of what"]]
    for scene in args.scenes.split(","):
        seconds, wrong, triangles = by_umbrage(args.umbrage, scene, args.tolerance)
        rows.append([scene, "Umbrage", f"{seconds:.2f}", f"{wrong:.2%}", f"{triangles} triangles"])
        baking, denoising, clean, noisy = by_lightmap(scene, args.size, args.samples)
        texels = f"{args.size} x {args.size} texels, {args.samples} paths each"
        rows.append([scene, "Cycles, lightmap", f"{baking:.2f}", f"{noisy:.2%}", texels])
        rows.append([scene, "Cycles, denoised", f"{baking + denoising:.2f}", f"{clean:.2%}", texels])
        seconds, wrong, made = by_vertices(scene, 2 * triangles, args.vertex_samples)
        what = f"{made} triangles, {args.vertex_samples} paths each corner"
        rows.append([scene, "Cycles, vertices", f"{seconds:.2f}", f"{wrong:.2%}", what])
    widths = [max(len(row[i]) for row in rows) for i in range(5)]
    rows.insert(1, ["-" * width for width in widths])
    for row in rows:
        print("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |")


if __name__ == "__main__":
    main()
