"""Scene files of raggio as others need them: numbers with their defaults, and matrices.

Read is what the reference scenes have; any other key is an error, so that no scene is silently another one.
"""
import math
import pathlib

import numpy

try:
    import tomllib
except ModuleNotFoundError:  # before Python 3.11
    import tomli as tomllib

CAMERA = {"position", "look_at", "vertical_fov_degrees", "aperture_radius", "focus_distance"}
MATERIAL = {"color", "smoothness", "refractive_index", "emission_color", "emission_strength"}


def read(path):
    path = pathlib.Path(path)
    world = tomllib.loads(path.read_text())
    known(world, {"version", "render", "camera", "environment", "materials", "shapes"})
    known(world["camera"], CAMERA)
    for material in world["materials"].values():
        known(material, MATERIAL)
    for name in (environment := world.setdefault("environment", {"color": [0, 0, 0]})):
        known({name: 0}, {"color", "image", "intensity"})
    if "image" in environment:
        environment["image"] = str((path.parent / environment["image"]).resolve())
    for shape in world["shapes"]:
        if "mesh" in shape:
            shape["mesh"]["file"] = str((path.parent / shape["mesh"]["file"]).resolve())
    return world


def known(table, names):
    if unknown := set(table) - names:
        raise ValueError(f"{', '.join(sorted(unknown))}: a key that is read by raggio alone")


def kind(material):
    """Kind of a material: diffuse, mirror, glass or lamp."""
    if "emission_color" in material:
        return "lamp"
    if material.get("smoothness", 0) not in (0, 1):
        raise ValueError("a smoothness between 0 and 1")
    if "refractive_index" in material:
        return "glass"
    return "mirror" if material.get("smoothness", 0) == 1 else "diffuse"


def world_from_camera(camera):
    """Columns right, up, backward and position: a camera looks along -Z."""
    position = numpy.array(camera["position"], float)
    backward = unit(position - camera["look_at"])
    right = unit(numpy.cross([0, 1, 0], backward))
    return matrix(right, numpy.cross(backward, right), backward, position)


def unit(vector):
    return vector / numpy.linalg.norm(vector)


def matrix(x, y, z, origin):
    result = numpy.eye(4)
    result[:3] = numpy.stack([x, y, z, origin], 1)
    return result


def rotation(degrees):
    """Rotation about x, then y, then z."""
    a, b, c = numpy.radians(degrees)
    def turn(angle, i, j):
        result = numpy.eye(3)
        result[i, i] = result[j, j] = math.cos(angle)
        result[i, j], result[j, i] = -math.sin(angle), math.sin(angle)
        return result
    return turn(c, 0, 1) @ turn(b, 2, 0) @ turn(a, 1, 2)
