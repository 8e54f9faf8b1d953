#!/usr/bin/env python3
"""cycles_worker.py: renders scene files of raggio with Blender's Cycles on the CPU, as it is asked on standard input.

cycles_worker.py SCENE WIDTH HEIGHT SAMPLES PICTURE renders one to an EXR.

Spheres are meshes, for Cycles has no glass of closed forms: icospheres of 20,480 triangles, shaded smooth, and for radii
from 100 on rings around the top that are the finer the nearer to it, which is where the other spheres stand.
"""
import math
import sys

import bpy
import numpy

import channel
import world

RINGS, SEGMENTS = 96, 128


def settings(source, width, height):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.use_compositing = scene.render.use_sequencer = False
    # Kept are the scene and its hierarchies from one render to the next, so that the time is that of sampling.
    scene.render.use_persistent_data = True
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    # raggio counts all rays of a path but those to lights, Cycles the bounces before the light is sampled.
    bounces = source["render"]["max_depth"] - 2
    for kind in ("max", "diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", bounces)
    return scene


def material(name, source):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    kind = world.kind(source)
    node = nodes.new({"diffuse": "ShaderNodeBsdfDiffuse", "mirror": "ShaderNodeBsdfGlossy", "glass": "ShaderNodeBsdfGlass",
                      "lamp": "ShaderNodeEmission"}[kind])
    node.inputs["Color"].default_value = [*source.get("emission_color" if kind == "lamp" else "color", [1, 1, 1]), 1]
    if kind == "lamp":
        node.inputs["Strength"].default_value = source.get("emission_strength", 1)
    else:
        node.inputs["Roughness"].default_value = 0.0
    if kind == "glass":
        node.inputs["IOR"].default_value = source["refractive_index"]
    links.new(node.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def sphere():
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=6, radius=1)
    made = bpy.context.object
    bpy.ops.object.shade_smooth()
    mesh = made.data
    bpy.data.objects.remove(made)
    mesh.materials.append(None)
    return mesh


def large_sphere():
    """Unit sphere of rings around +Y, whose distance from the top grows by a constant factor."""
    angles = numpy.geomspace(5e-4, math.pi * 0.99, RINGS)
    around = numpy.arange(SEGMENTS) * 2 * math.pi / SEGMENTS
    rings = numpy.stack(numpy.broadcast_arrays(
        numpy.sin(angles)[:, None] * numpy.cos(around), numpy.cos(angles)[:, None],
        -numpy.sin(angles)[:, None] * numpy.sin(around)), -1)
    points = [*rings.reshape(-1, 3).tolist(), [0, 1, 0], [0, -1, 0]]
    top, bottom = len(points) - 2, len(points) - 1
    faces = []
    for i in range(SEGMENTS):
        j = (i + 1) % SEGMENTS
        faces.append((top, i, j))
        faces += [(k + i, k + SEGMENTS + i, k + SEGMENTS + j, k + j) for k in range(0, (RINGS - 1) * SEGMENTS, SEGMENTS)]
        faces.append(((RINGS - 1) * SEGMENTS + i, bottom, (RINGS - 1) * SEGMENTS + j))
    mesh = bpy.data.meshes.new("large sphere")
    mesh.from_pydata(points, [], faces)
    mesh.shade_smooth()
    mesh.materials.append(None)
    return mesh


def load_mesh(file):
    bpy.ops.wm.ply_import(filepath=file, forward_axis="NEGATIVE_Z", up_axis="Y", import_colors="NONE")
    made = bpy.context.object
    # Turned from one convention for up to the other as it was read.
    made.matrix_world.identity()
    mesh = made.data
    bpy.data.objects.remove(made)
    mesh.shade_flat()
    mesh.materials.append(None)
    return mesh


def build(path, width, height):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    source = world.read(path)
    scene = settings(source, width, height)
    if "color" not in source["environment"]:
        raise ValueError("a sky by an image")
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    sky = scene.world.node_tree.nodes["Background"]
    sky.inputs["Color"].default_value = [*source["environment"]["color"], 1]

    materials = {name: material(name, value) for name, value in source["materials"].items()}
    small, large = sphere(), None
    for i, shape in enumerate(source["shapes"]):
        if "sphere" in shape:
            ball = shape["sphere"]
            if ball["radius"] >= 100 and large is None:
                large = large_sphere()
            mesh = large if ball["radius"] >= 100 else small
            made = bpy.data.objects.new(f"shape{i}", mesh)
            made.location, made.scale = ball["center"], [ball["radius"]] * 3
        elif "mesh" in shape:
            made = bpy.data.objects.new(f"shape{i}", load_mesh(shape["mesh"]["file"]))
        else:
            raise ValueError("a shape that is neither a sphere nor a mesh")
        made.material_slots[0].link = "OBJECT"
        made.material_slots[0].material = materials[shape["material"]]
        scene.collection.objects.link(made)

    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = math.radians(source["camera"]["vertical_fov_degrees"])
    data.clip_start, data.clip_end = 1e-4, 1e6
    if source["camera"].get("aperture_radius", 0) > 0:
        data.dof.use_dof, data.dof.focus_distance = True, source["camera"]["focus_distance"]
        # Focal lengths are in millimetres.
        data.dof.aperture_fstop = data.lens * 1e-3 / (2 * source["camera"]["aperture_radius"])
    scene.camera = bpy.data.objects.new("camera", data)
    scene.collection.objects.link(scene.camera)
    # Matrices are those of world.py, column by column.
    scene.camera.matrix_world = world.world_from_camera(source["camera"]).T.tolist()
    return scene


class Renderer:
    def load(self, path, width, height):
        self.scene, figures = channel.timed(lambda: build(path, width, height))
        return figures

    def render(self, samples, seed, picture=None):
        self.scene.cycles.samples, self.scene.cycles.seed = samples, seed
        if picture:
            self.scene.render.filepath = picture
        _, figures = channel.timed(lambda: bpy.ops.render.render(write_still=bool(picture)))
        return figures

    def version(self):
        return {"name": f"Cycles of Blender {bpy.app.version_string}"}


if __name__ == "__main__":
    renderer = Renderer()
    if len(sys.argv) > 1:
        path, width, height, samples, picture = sys.argv[1:]
        renderer.load(path, int(width), int(height))
        renderer.render(int(samples), 0, picture)
    else:
        channel.serve({"load": renderer.load, "render": renderer.render, "version": renderer.version})
