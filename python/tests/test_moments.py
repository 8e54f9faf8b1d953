"""Animations: scenes at one moment and another."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import numpy as np
import pytest
from conftest import FILE, render

import raggio as rg

KEYFRAMES = """interpolation = "linear"
keyframes = [{ time = 0.5, position = [0, 1, 4] }, { time = 2.5, position = [2, 1, 4] }]
"""


def moving(folder: Path) -> Path:
    """A scene whose camera moves, and a triangle in it: to the right by 2 within two seconds."""
    corners = np.array([[-1, 0, 1], [1, 0, 1], [0, 1, 1]], dtype="<f4")
    times, places = np.array([0, 2], dtype="<f4"), np.array([[0, 0, 0], [2, 0, 0]], dtype="<f4")
    data = b"".join(array.tobytes() for array in (corners, times, places))
    view = {"buffer": 0, "byteLength": len(data)}
    kinds = ((3, "VEC3", 0), (2, "SCALAR", 36), (2, "VEC3", 44))
    accessors = [
        {"bufferView": 0, "byteOffset": offset, "componentType": 5126, "count": count, "type": kind}
        for count, kind, offset in kinds
    ]
    document = {
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "animations": [
            {
                "name": "slide",
                "samplers": [{"input": 1, "output": 2}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            }
        ],
        "buffers": [{"byteLength": len(data), "uri": "data:;base64," + base64.b64encode(data).decode()}],
        "bufferViews": [view],
        "accessors": accessors,
    }
    (folder / "triangle.gltf").write_text(json.dumps(document))
    text = FILE.replace("vertical_fov_degrees = 40\n", "vertical_fov_degrees = 40\n" + KEYFRAMES)
    path = folder / "scene.toml"
    path.write_text(text + '[[shapes]]\nmaterial = "clay"\nmesh = { file = "triangle.gltf", time = 0 }\n')
    return path


def test_each_moment_is_that_of_a_scene_loaded_there(tmp_path: Path) -> None:
    path = moving(tmp_path)
    scene = rg.load(path)
    renderer = rg.Renderer(scene, device="cpu")
    camera = rg.Camera.look_at((0, 1, 6), (0, 1, 0))
    pictures = []
    for time in (0.0, 1.5, 0.75, 9.0):
        expected = np.asarray(render(rg.load(path, time=time), samples=4))
        assert (np.asarray(render(scene, time=time, samples=4)) == expected).all()
        assert scene.time is None, "the scene stays as it is"
        renderer.time = time
        renderer.step(4)
        assert renderer.time == time and (np.asarray(renderer.image) == expected).all()
        [(_, many)] = rg.render_many(scene, [camera], time=time, samples=4, device="cpu")
        assert (np.asarray(many) == np.asarray(render(scene, camera, time=time, samples=4))).all()
        pictures.append(expected)
    assert all((one != other).any() for one, other in zip(pictures, pictures[1:], strict=False))


def test_a_scene_has_its_moment(tmp_path: Path) -> None:
    scene = rg.load(moving(tmp_path))
    at_rest = np.asarray(render(scene, samples=2))
    scene.time = 1
    later = np.asarray(render(scene, samples=2))
    assert scene.time == 1.0 and scene.copy().time == 1.0 and (at_rest != later).any()
    # Another camera stands still, and what it sees moves.
    camera = rg.Camera.look_at((0, 1, 6), (0, 1, 0))
    depths = [render(scene, camera, time=time, samples=1, aovs="depth")["depth"] for time in (0.0, 2.0)]
    assert (depths[0] != depths[1]).any()
    scene.time = None
    assert (np.asarray(render(scene, samples=2)) == at_rest).all()


def test_animations_are_listed(tmp_path: Path) -> None:
    path = moving(tmp_path)
    camera, slide = rg.load(path).animations
    assert camera == rg.Animation("camera", 0.5, 2.5, None)
    assert slide == rg.Animation("slide", 0.0, 2.0, tmp_path.resolve() / "triangle.gltf")
    assert rg.load(tmp_path / "triangle.gltf", time=0).animations == (slide,)
    assert rg.Scene().animations == ()


@pytest.mark.parametrize("time", [-1, float("nan"), float("inf")])
def test_moments_before_the_beginning_are_refused(tmp_path: Path, time: float) -> None:
    scene = rg.load(moving(tmp_path))
    for refused in (lambda: rg.load(tmp_path / "scene.toml", time=time), lambda: render(scene, time=time)):
        with pytest.raises(ValueError, match="time is .*: give seconds, 0 or more"):
            refused()


def test_a_scene_that_does_not_move_says_so(file: Path) -> None:
    with pytest.warns(rg.SceneWarning, match="nothing in the scene moves"):
        render(rg.load(file), time=1, samples=1)
