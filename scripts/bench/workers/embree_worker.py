#!/usr/bin/env python3
"""embree_worker.py: makes the rays of diffuse bounces in a mesh, and traces them with Embree, as it is asked on standard input.

Rays are traced one by one on one thread, by `rtcIntersect1` in a robust scene, from a loop in compiled code.
"""
import pathlib
import sys

import embreex
import numpy
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import channel  # noqa: E402
import rock  # noqa: E402
import world  # noqa: E402

# Height above the surface at which the next ray starts, so that no rounding decides whether it meets the surface again.
ABOVE = 1e-4


class Tracer:
    def load(self, path):
        source = world.read(path)
        self.camera = source["camera"]
        self.points, self.faces = rock.read(source["shapes"][0]["mesh"]["file"])
        self.scene = EmbreeScene(robust=True)
        TriangleMesh(self.scene, self.points, self.faces)
        return {"triangles": len(self.faces)}

    def camera_rays(self, width, height, random):
        matrix = world.world_from_camera(self.camera)
        half = numpy.tan(numpy.radians(self.camera["vertical_fov_degrees"]) / 2)
        y, x = numpy.mgrid[:height, :width].reshape(2, -1) + random.random((2, width * height))
        local = [(2 * x - width) / height * half, (1 - 2 * y / height) * half, -numpy.ones_like(x)]
        directions = numpy.stack(local, 1) @ matrix[:3, :3].T
        return numpy.broadcast_to(matrix[:3, 3], directions.shape), directions

    def make_rays(self, width, height, bounces, file):
        """Writes the rays of all bounces of one path a pixel, in the order of the pixels for each bounce."""
        random = numpy.random.default_rng(1)
        origins, directions = self.camera_rays(width, height, random)
        made = []
        for _ in range(bounces):
            origins, directions = (numpy.ascontiguousarray(v, numpy.float32) for v in (origins, directions))
            hit = self.scene.run(origins, directions, output=1)
            found = hit["primID"] >= 0
            triangle = self.points[self.faces[hit["primID"][found]]].astype(float)
            normals = numpy.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0])
            normals /= numpy.linalg.norm(normals, axis=1, keepdims=True)
            incoming = directions[found].astype(float)
            normals *= -numpy.sign((normals * incoming).sum(1))[:, None]
            origins = origins[found] + hit["tfar"][found, None] * incoming + ABOVE * normals
            # A point of the unit sphere around the normal's end has the density of the cosine.
            ball = random.normal(size=normals.shape)
            directions = normals + (1 - 1e-6) * ball / numpy.linalg.norm(ball, axis=1, keepdims=True)
            directions /= numpy.linalg.norm(directions, axis=1, keepdims=True)
            made.append(numpy.concatenate([origins, directions], 1).astype("<f4"))
        rays = numpy.concatenate(made)
        rays.tofile(file)
        self.origins, self.directions = (numpy.ascontiguousarray(rays[:, i : i + 3]) for i in (0, 3))
        return {"rays": len(rays)}

    def trace(self, distances=None):
        """Traces the rays made; writes the distance of each, -1 where it meets nothing."""
        found, figures = channel.timed(lambda: self.scene.run(self.origins, self.directions))
        if distances:
            hit = self.scene.run(self.origins, self.directions, output=1)
            numpy.where(hit["primID"] >= 0, hit["tfar"], -1).astype("<f4").tofile(distances)
        return figures | {"hits": int((found >= 0).sum())}

    def version(self):
        return {"name": f"Embree {embreex.__version__.split('.post')[0]}"}


if __name__ == "__main__":
    tracer = Tracer()
    names = ("load", "make_rays", "trace", "version")
    channel.serve({name: getattr(tracer, name) for name in names})
