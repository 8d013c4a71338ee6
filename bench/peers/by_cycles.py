"""Cycles of Blender: a lightmap, the same with Open Image Denoise, and light at the vertices of an evenly cut mesh."""

import math
import time

import numpy as np

from points import ROOT, error, error_of_triangles, located, reference


def rows(scene, umbrage, args):
    """What there is to tell of a scene: by whom, seconds, error, of what."""
    baking, denoising, clean, noisy = by_lightmap(scene, args.size, args.samples)
    texels = f"{args.size} x {args.size} texels, {args.samples} paths each"
    yield "Cycles, lightmap", baking, noisy, texels
    yield "Cycles, denoised", baking + denoising, clean, texels
    seconds, wrong, made = by_vertices(scene, 2 * len(umbrage.triangles), args.vertex_samples)
    yield "Cycles, vertices", seconds, wrong, f"{made} triangles, {args.vertex_samples} paths each corner"


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
    corners, loops = triangles_of(bpy)
    return seconds, error_of_triangles(scene, corners, math.pi * light[loops]), len(corners)
