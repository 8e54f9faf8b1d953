"""A bumpy sphere of 20 * 4^level triangles on a square of two, as a PLY: what `Scene::rock` of the crate raggio-scene makes."""
import numpy

FACES = [[0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
         [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]

SCENE = """version = 1
[render]
width = 1024
height = 1024
max_depth = 11
[camera]
position = [0.0, 1.6, 4.0]
look_at = [0.0, 1.45, 3.0]
vertical_fov_degrees = 61.9
[environment]
color = [0.75, 0.85, 1.0]
[materials.clay]
color = [0.7, 0.7, 0.7]
[[shapes]]
material = "clay"
mesh = {{ file = "{file}" }}
"""


def corners():
    golden = (1 + 5**0.5) / 2
    a, b, c, d = (-1, golden), (1, golden), (-1, -golden), (1, -golden)
    points = [(x, y, 0) for x, y in (a, b, c, d)] + [(0, x, y) for x, y in (a, b, c, d)] + [(y, 0, x) for x, y in (a, b, c, d)]
    return unit(numpy.array(points, float))


def unit(points):
    return points / numpy.linalg.norm(points, axis=1, keepdims=True)


def triangles(level):
    """Corners and faces, in float32 and int32."""
    points, faces = corners(), numpy.array(FACES)
    for _ in range(level):
        edges = numpy.sort(numpy.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        # One number an edge sorts ten times as fast as two.
        edges, place = numpy.unique(edges[:, 0] * len(points) + edges[:, 1], return_inverse=True)
        a, b, c = len(points) + place.reshape(3, -1)
        middles = unit(points[edges // len(points)] + points[edges % len(points)])
        points = numpy.concatenate([points, middles])
        parts = (faces[:, 0], a, c), (faces[:, 1], b, a), (faces[:, 2], c, b), (a, b, c)
        faces = numpy.concatenate([numpy.stack(part, 1) for part in parts])
    x, y, z = points.T
    sin = numpy.sin
    wide = sin(9 * x + 2 * sin(7 * y)) * sin(8 * y + 3 * sin(5 * z)) * sin(7 * z + x)
    fine = sin(40 * x) * sin(37 * y) * sin(43 * z)
    points = points * (1 + 0.12 * wide + 0.03 * fine)[:, None] + [0, 1, 0]
    ground = len(points)
    points = numpy.concatenate([points, [[-20, 0, -20], [20, 0, -20], [20, 0, 20], [-20, 0, 20]]])
    faces = numpy.concatenate([faces, ground + numpy.array([[0, 2, 1], [0, 3, 2]])])
    return points.astype("<f4"), faces.astype("<i4")


def write(folder, level):
    """Path of the scene of `level` in `folder`; it and its mesh are written if they are not there."""
    scene, mesh = folder / f"rock-{level}.toml", folder / f"rock-{level}.ply"
    if not scene.exists():
        folder.mkdir(parents=True, exist_ok=True)
        points, faces = triangles(level)
        listed = numpy.empty(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
        listed["count"], listed["corners"] = 3, faces
        header = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\n"
                  f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
        mesh.write_bytes(header.encode() + points.tobytes() + listed.tobytes())
        scene.write_text(SCENE.format(file=mesh.name))
    return scene
