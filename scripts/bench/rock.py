"""The rock of the crate raggio-scene as files: a bumpy sphere of 20 * 4^level triangles, and a square of two behind them."""
import pathlib
import subprocess

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def write(folder, level):
    """Path of the scene of `level` in `folder`; it and its mesh are written if they are not there."""
    scene = pathlib.Path(folder) / f"rock-{level}.toml"
    if not scene.exists():
        program = ["cargo", "run", "--release", "--quiet", "--package", "raggio-scene", "--example", "write_rock"]
        subprocess.run([*program, "--", str(level), folder], check=True, cwd=ROOT)
    return scene


def read(path):
    """Corners and faces of the mesh in a PLY of `write`, in float32 and int32."""
    header, body = pathlib.Path(path).read_bytes().split(b"end_header\n", 1)
    counts = {words[1]: int(words[2]) for words in map(str.split, header.decode().splitlines()) if words[0] == "element"}
    points = numpy.frombuffer(body, "<f4", 3 * counts["vertex"]).reshape(-1, 3)
    faces = numpy.frombuffer(body, [("count", "u1"), ("corners", "<i4", 3)], offset=points.nbytes)
    return points, numpy.ascontiguousarray(faces["corners"])
