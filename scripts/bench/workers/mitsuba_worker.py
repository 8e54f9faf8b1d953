#!/usr/bin/env python3
"""mitsuba_worker.py VARIANT: renders scene files of raggio with Mitsuba 3, as it is asked on standard input.

mitsuba_worker.py VARIANT SCENE WIDTH HEIGHT SAMPLES PICTURE renders one to an EXR.
"""
import glob
import os
import re
import sys

import numpy

import channel
import world


def newest_llvm():
    """Path of the newest LLVM library under /usr/lib, if there is one: 15 and 16 crash on recent Xeons."""
    found = glob.glob("/usr/lib/*/libLLVM.so.*") + glob.glob("/usr/lib/llvm-*/lib/libLLVM*.so*")
    version = re.compile(r"llvm-(\d+)|libLLVM\.so\.(\d+)")
    return max(found, key=lambda path: int("".join(filter(None, version.search(path).groups()))), default=None)


if library := newest_llvm():
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", library)
import drjit  # noqa: E402
import mitsuba  # noqa: E402

# Half the side of the square that an endless plane becomes.
FAR = 20000.0


def rgb(color):
    return {"type": "rgb", "value": list(map(float, color))}


def bsdf(material):
    color = rgb(material.get("color", [1, 1, 1]))
    match world.kind(material):
        case "glass":
            return {"type": "dielectric", "int_ior": float(material["refractive_index"]), "ext_ior": 1.0,
                    "specular_reflectance": color, "specular_transmittance": color}
        case "mirror":
            inner = {"type": "conductor", "material": "none", "specular_reflectance": color}
        case _:
            inner = {"type": "diffuse", "reflectance": color}
    return {"type": "twosided", "inner": inner}


def transform(matrix):
    return mitsuba.ScalarTransform4f(matrix.tolist())


def square(corner, u, v):
    """Matrix that brings Mitsuba's square, from -1 to 1, between the edges."""
    corner, u, v = (numpy.array(vector, float) for vector in (corner, u, v))
    return world.matrix(u / 2, v / 2, world.unit(numpy.cross(u, v)), corner + u / 2 + v / 2)


def shapes(shape):
    """Shapes that show what `shape` does: a rectangle shines to both sides, which takes Mitsuba two."""
    if sphere := shape.get("sphere"):
        return [{"type": "sphere", "center": list(map(float, sphere["center"])), "radius": float(sphere["radius"])}]
    if plane := shape.get("plane"):
        x, normal = numpy.eye(3)[0], world.unit(numpy.array(plane["normal"], float))
        if abs(normal[0]) > 0.9:
            x = numpy.eye(3)[2]
        u = world.unit(numpy.cross(normal, x))
        v = numpy.cross(normal, u)
        return [{"type": "rectangle", "to_world": transform(world.matrix(FAR * u, FAR * v, normal, plane["point"]))}]
    if rectangle := shape.get("rectangle"):
        corner, u, v = (numpy.array(rectangle[key], float) for key in ("corner", "edge_u", "edge_v"))
        sides = [{"type": "rectangle", "to_world": transform(square(corner, u, v))}]
        if shape["lamp"]:
            away = 1e-4 * world.unit(numpy.cross(v, u))
            sides.append({"type": "rectangle", "to_world": transform(square(corner + u + away, -u, v))})
        return sides
    if box := shape.get("box"):
        turned = world.rotation(box.get("rotation_degrees", [0, 0, 0])) * (numpy.array(box["size"]) / 2)
        return [{"type": "cube", "to_world": transform(world.matrix(*turned.T, box["center"]))}]
    return [{"type": "ply", "filename": shape["mesh"]["file"], "face_normals": True}]


def camera(settings, width, height):
    # Mitsuba's cameras look along +Z and have +X on the left.
    matrix = world.world_from_camera(settings) @ numpy.diag([-1.0, 1.0, -1.0, 1.0])
    sensor = {"type": "perspective", "fov_axis": "y", "fov": float(settings["vertical_fov_degrees"]),
              "to_world": transform(matrix), "near_clip": 1e-4, "far_clip": 1e6,
              "film": {"type": "hdrfilm", "width": width, "height": height, "rfilter": {"type": "box"},
                       "pixel_format": "rgb", "component_format": "float32"},
              "sampler": {"type": "independent"}}
    if settings.get("aperture_radius", 0) > 0:
        sensor.update(type="thinlens", aperture_radius=float(settings["aperture_radius"]),
                      focus_distance=float(settings["focus_distance"]))
    return sensor


def scene(path, width, height, roulette):
    source = world.read(path)
    result = {"type": "scene", "sensor": camera(source["camera"], width, height),
              "integrator": {"type": "path", "max_depth": source["render"]["max_depth"], "rr_depth": roulette}}
    environment = source["environment"]
    if "image" in environment:
        # The centre of Mitsuba's image is seen along +Z.
        turned = mitsuba.ScalarTransform4f().rotate([0, 1, 0], 180)
        result["environment"] = {"type": "envmap", "filename": environment["image"], "to_world": turned,
                                 "scale": float(environment.get("intensity", 1))}
    elif any(environment["color"]):
        result["environment"] = {"type": "constant", "radiance": rgb(environment["color"])}
    for i, shape in enumerate(source["shapes"]):
        material = source["materials"][shape["material"]]
        lamp = world.kind(material) == "lamp"
        for side, made in enumerate(shapes(shape | {"lamp": lamp})):
            made["bsdf"] = bsdf(material)
            if lamp:
                radiance = numpy.array(material["emission_color"], float) * material.get("emission_strength", 1)
                made["emitter"] = {"type": "area", "radiance": rgb(radiance)}
            result[f"shape{i}_{side}"] = made
    return mitsuba.load_dict(result)


class Renderer:
    def load(self, path, width, height, roulette):
        self.scene, figures = channel.timed(lambda: scene(path, width, height, roulette))
        return figures

    def render(self, samples, seed, picture=None):
        pixels, figures = channel.timed(lambda: numpy.array(mitsuba.render(self.scene, spp=samples, seed=seed)))
        if picture:
            numpy.save(picture, pixels)
        return figures | {"mean": float(pixels.mean())}

    def version(self):
        if mitsuba.variant().startswith("llvm"):
            # Libraries that Dr.Jit does not work with fail here, before anything is measured.
            drjit.eval(mitsuba.Float([1, 2]) + 1)
        return {"name": f"Mitsuba {mitsuba.__version__}", "llvm": os.environ.get("DRJIT_LIBLLVM_PATH")}


if __name__ == "__main__":
    mitsuba.set_variant(sys.argv[1])
    if len(sys.argv) > 2:
        path, width, height, samples, picture = sys.argv[2:]
        image = mitsuba.render(scene(path, int(width), int(height), 5), spp=int(samples))
        mitsuba.Bitmap(image).write(picture)
    else:
        renderer = Renderer()
        channel.serve({"load": renderer.load, "render": renderer.render, "version": renderer.version})
