"""Types: an example under mypy's strict rules, and stubs that agree with what they describe."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mypy", reason="mypy is not installed")

EXAMPLE = """
from collections.abc import Iterator
from typing import assert_type

import numpy as np
import numpy.typing as npt
import raggio as rg
import raggio.cluster

scene = rg.load("room.glb")
number: int = scene.add((np.zeros((3, 3)), np.zeros((1, 3), int)), material=rg.Material(color=(1, 0, 0)), id=7)
scene.environment = rg.Environment(image=np.ones((4, 8, 3)), rotation_degrees=30)
scene.lights = [rg.PointLight(position=(0, 1, 2), intensity=3), rg.DirectionalLight(direction=(0, -1, 0))]
colors: list[rg.Material] = [rg.Material(color="#ff8800"), rg.Material(color={"srgb": (1, 0.5, 0)})]
scene.lights += (rg.SpotLight(position=(0, 1, 2), direction=(0, -1, 0)),)
camera = rg.Camera.from_matrix(np.eye(4), K=np.eye(3), size=(64, 48), convention="opencv")
image = rg.render(scene, camera, samples=64, seed=0, device="auto", aovs=("depth", "object_id"), denoise=False)
pixels: npt.NDArray[np.float32] = image.pixels
array = np.asarray(image)
shown: npt.NDArray[np.uint8] = image.tonemap(tone_mapper="agx")
views: Iterator[tuple[int, rg.Image]] = rg.render_many(scene, [camera], samples=16)
renderer = rg.Renderer(scene, camera)
renderer.step(16)
renderer.camera = rg.Camera.look_at((0, 0, 1), (0, 0, 0))
rg.view(scene, camera, size=(64, 48), tone_mapper="agx").camera = renderer.camera
try:
    renderer.image.save("a.png")
except rg.Interrupted as stop:
    stop.image.save("b.exr")
on_machines: rg.Image = raggio.cluster.render(scene, camera, samples=64, address="auto", preview="a.png")
of_batch: Iterator[tuple[int, rg.Image]] = raggio.cluster.render(scene, [camera], samples=16)
rg.datasets.CocoWriter({1: "cup"}).add("a.png", image["object_id"])
"""

MISTAKES = """
import raggio as rg, raggio.cluster
rg.render(rg.Scene(), None, (64, 48))
rg.Camera.look_at((0, 0, 1), "up")
rg.Material(colour=(1, 0, 0))
rg.render(rg.Scene(), samples="many")
raggio.cluster.render(rg.Scene(), [], preview="a.png")
"""


def mypy(text: str, folder) -> subprocess.CompletedProcess[str]:
    path = folder / "example.py"
    path.write_text(text)
    command = [
        sys.executable,
        "-m",
        "mypy",
        "--strict",
        "--python-version",
        "3.11",
        "--cache-dir",
        str(folder),
        str(path),
    ]
    return subprocess.run(command, text=True, capture_output=True, cwd=folder)


def test_an_example(tmp_path) -> None:
    done = mypy(EXAMPLE, tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_mistakes_are_found(tmp_path) -> None:
    done = mypy(MISTAKES, tmp_path)
    for line in (3, 4, 5, 6, 7):
        assert f"example.py:{line}: error" in done.stdout, done.stdout


def test_the_package_itself(tmp_path) -> None:
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(tmp_path), "-p", "raggio"]
    done = subprocess.run(command, text=True, capture_output=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr


def test_stubs(tmp_path) -> None:
    allowed = Path(__file__).parent / "stubtest-allowlist.txt"
    command = [sys.executable, "-m", "mypy.stubtest", "raggio", "--allowlist", str(allowed)]
    done = subprocess.run(command, text=True, capture_output=True, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
