"""Scenes and renders that tests share."""

from __future__ import annotations

import functools
import os
from pathlib import Path

import numpy as np
import pytest

import raggio as rg

ROOT = Path(__file__).resolve().parents[2]

# Tests keep nothing in the user's own folders.
os.environ["RAGGIO_NO_CACHE"] = "1"

#: Tests are of the CPU alone: what differs between devices is for the program's tests.
render = functools.partial(rg.render, device="cpu")

FRONT = rg.Camera.look_at((0, 0, 4), (0, 0, 0))
SQUARE = (
    np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=np.float32),
    np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32),
)

FILE = """version = 1
[render]
width = 48
height = 32
samples = 8
[camera]
position = [0, 1, 4]
look_at = [0, 1, 0]
vertical_fov_degrees = 40
[environment]
color = [0.7, 0.8, 1.0]
[materials.clay]
color = [0.8, 0.4, 0.2]
[[shapes]]
material = "clay"
sphere = { center = [0, 1, 0], radius = 1 }
"""


def lit(radiance: float = 1.0) -> rg.Scene:
    """A scene of nothing but light from everywhere."""
    scene = rg.Scene()
    scene.environment = rg.Environment(color=(radiance, radiance, radiance))
    return scene


def memory() -> int:
    """Memory of this process in bytes."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A scene file."""
    path = tmp_path / "scene.toml"
    path.write_text(FILE)
    return path
