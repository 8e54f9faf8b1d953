#!/usr/bin/env python3
"""views_worker.py NAME MESH VIEWS WARM_UP SIZE SAMPLES: renders views with raggio, Mitsuba or pyrender; its last line is JSON.

Each makes the same of each view: colours, depth, normals and numbers of objects as arrays. pyrender rasterises, and renders
three times: with its own shader, with colours in place of normals, and with one colour for each object.
"""
import json
import os
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import channel  # noqa: E402
import rock  # noqa: E402

FOV_DEGREES = 40.0
SKY = (0.75, 0.85, 1.0)


def memory_mb():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def position(i):
    """Place of the camera of view number `i`: all around, higher and lower."""
    angle = 2.399963 * i
    return (4 * numpy.sin(angle), 1.6 + 1.4 * numpy.sin(0.37 * i), 4 * numpy.cos(angle))


def with_raggio(points, faces, size, samples):
    import raggio

    scene = raggio.Scene()
    scene.environment = raggio.Environment(color=SKY)
    clay = raggio.Material(color=(0.7, 0.7, 0.7))
    scene.add((points[:-4], faces[:-2]), material=clay, id=1)
    scene.add((points, faces[-2:]), material=clay, id=2)
    cameras = (raggio.Camera.look_at(position(i), (0, 1, 0), vfov_degrees=FOV_DEGREES) for i in range(1 << 30))
    views = raggio.render_many(scene, cameras, size=(size, size), samples=samples, device="cpu",
                               aovs=("depth", "normal", "object_id"))

    def render(i):
        _, view = next(views)
        return view.pixels, view["depth"], view["normal"], view["object_id"]

    return f"raggio {raggio.__version__}", render


def with_mitsuba(points, faces, size, samples):
    from mitsuba_worker import drjit, mitsuba

    mitsuba.set_variant("llvm_ad_rgb")
    clay = {"type": "twosided", "inner": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.7}}}

    def mesh(points, faces):
        made = mitsuba.Mesh("", len(points), len(faces), props=properties())
        parameters = mitsuba.traverse(made)
        parameters["vertex_positions"], parameters["faces"] = points.ravel(), faces.ravel()
        parameters.update()
        return made

    def properties():
        found = mitsuba.Properties()
        found["bsdf"] = mitsuba.load_dict(clay)
        found["face_normals"] = True
        return found

    scene = mitsuba.load_dict({"type": "scene", "rock": mesh(points[:-4], faces[:-2]),
                               "ground": mesh(points[-4:], faces[-2:] - (len(points) - 4)),
                               "sky": {"type": "constant", "radiance": {"type": "rgb", "value": list(SKY)}}})
    inner = {"type": "path", "max_depth": 11, "rr_depth": 5}
    integrator = mitsuba.load_dict({"type": "aov", "aovs": "depth:depth,normal:sh_normal,id:shape_index", "image": inner})
    # One sensor, which is moved, so that nothing is compiled anew.
    sensor = mitsuba.load_dict({"type": "perspective", "fov": FOV_DEGREES, "fov_axis": "y",
                                "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"},
                                         "pixel_format": "rgb", "component_format": "float32"}})
    parameters = mitsuba.traverse(sensor)

    def render(i):
        pose = mitsuba.ScalarTransform4f().look_at(origin=position(i), target=[0, 1, 0], up=[0, 1, 0])
        parameters["to_world"] = mitsuba.Transform4f(pose)
        parameters.update()
        layers = numpy.array(mitsuba.render(scene, sensor=sensor, integrator=integrator, spp=samples, seed=i))
        return layers[..., :3], layers[..., -5], layers[..., -4:-1], layers[..., -1]

    assert drjit
    return f"Mitsuba {mitsuba.__version__} `llvm_ad_rgb`", render


def with_pyrender(points, faces, size, samples):
    os.environ.setdefault("PYOPENGL_PLATFORM", "egl")
    # pyrender is older than NumPy 2.
    numpy.infty = numpy.inf
    import pyrender
    import trimesh

    parts = [trimesh.Trimesh(points[:-4], faces[:-2], process=False),
             trimesh.Trimesh(points[-4:], faces[-2:] - (len(points) - 4), process=False)]
    scene = pyrender.Scene(ambient_light=SKY, bg_color=SKY)
    normals = pyrender.Scene(ambient_light=(1, 1, 1), bg_color=(0, 0, 0))
    nodes = {}
    for number, part in enumerate(parts, 1):
        nodes[scene.add(pyrender.Mesh.from_trimesh(part, smooth=False))] = (number, 0, 0)
        colored = part.copy()
        colored.visual.vertex_colors = (127.5 + 127.5 * part.vertex_normals).astype(numpy.uint8)
        normals.add(pyrender.Mesh.from_trimesh(colored))
    lens = pyrender.PerspectiveCamera(yfov=numpy.radians(FOV_DEGREES))
    cameras = [(each, each.add(lens)) for each in (scene, normals)]
    renderer = pyrender.OffscreenRenderer(size, size)

    def render(i):
        back = numpy.array(position(i)) - (0, 1, 0)
        pose = numpy.eye(4)
        pose[:3, 2] = back / numpy.linalg.norm(back)
        pose[:3, 0] = numpy.cross((0, 1, 0), pose[:3, 2])
        pose[:3, 0] /= numpy.linalg.norm(pose[:3, 0])
        pose[:3, 1] = numpy.cross(pose[:3, 2], pose[:3, 0])
        pose[:3, 3] = position(i)
        for each, camera in cameras:
            each.set_pose(camera, pose)
        color, depth = renderer.render(scene)
        flat, _ = renderer.render(normals, flags=pyrender.RenderFlags.FLAT)
        numbers, _ = renderer.render(scene, flags=pyrender.RenderFlags.SEG, seg_node_map=nodes)
        return color, depth, flat, numbers[..., 0]

    return f"pyrender {pyrender.__version__}, {os.environ['PYOPENGL_PLATFORM']}", render


def main():
    name, mesh, views, warm_up, size, samples = *sys.argv[1:3], *map(int, sys.argv[3:])
    ready = {"raggio": with_raggio, "mitsuba": with_mitsuba, "pyrender": with_pyrender}[name]
    title, render = ready(*rock.read(mesh), size, samples)
    for i in range(warm_up):
        arrays = [numpy.asarray(array) for array in render(i)]
    # Each shows the scene: rock in the middle, all three of ground, rock and sky somewhere.
    shapes = [array.shape for array in arrays]
    assert shapes == [(size, size, 3), (size, size), (size, size, 3), (size, size)], shapes
    assert 2 < arrays[1][size // 2, size // 2] < 4, arrays[1][size // 2, size // 2]
    assert len(numpy.unique(numpy.round(arrays[3]))) >= 2
    before = memory_mb()
    _, figures = channel.timed(lambda: [render(warm_up + i) and None for i in range(views)])
    print(json.dumps({"name": title, "memory_mb": before, "growth_mb": memory_mb() - before} | figures))


if __name__ == "__main__":
    main()
