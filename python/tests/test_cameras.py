"""Cameras: conventions agree, and what raggio has not is refused."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from conftest import lit, render

import raggio as rg


def views() -> rg.Scene:
    """Spheres that look different from everywhere."""
    scene = lit()
    for place, radius in (((0, 0, 0), 0.5), ((1, 0.2, 0), 0.3), ((0, 1, 0.3), 0.2), ((-0.4, -0.7, 0.9), 0.25)):
        scene.add(rg.Sphere(place, radius))
    return scene


POSITION, TARGET = (2.0, 1.5, 3.0), (0.1, 0.2, 0.3)


def test_conventions_agree() -> None:
    """The same pose by look_at, by OpenGL's matrix and by OpenCV's matrix with K shows the same."""
    size = (40, 30)
    looking = rg.Camera.look_at(POSITION, TARGET, vfov_degrees=50, size=size)
    gl = rg.Camera.from_matrix(
        looking.world_from_camera(convention="opengl"), vfov_degrees=50, size=size, convention="opengl"
    )
    focal = 15 / math.tan(math.radians(25))
    K = [[focal, 0, 20], [0, focal, 15], [0, 0, 1]]
    # By hand: x right, y down, z forward.
    forward = np.subtract(TARGET, POSITION) / np.linalg.norm(np.subtract(TARGET, POSITION))
    right = np.cross(forward, [0, 1, 0]) / np.linalg.norm(np.cross(forward, [0, 1, 0]))
    pose = np.eye(4)
    pose[:3] = np.stack([right, np.cross(forward, right), forward, POSITION], axis=1)
    cv = rg.Camera.from_matrix(pose, K=K, size=size, convention="opencv")
    pictures = [render(views(), camera, samples=1, aovs=("depth", "object_id")) for camera in (looking, gl, cv)]
    assert len(np.unique(pictures[0]["object_id"])) == 5
    for picture in pictures[1:]:
        assert (picture["object_id"] == pictures[0]["object_id"]).mean() > 0.995
        same = np.isfinite(picture["depth"]) & np.isfinite(pictures[0]["depth"])
        np.testing.assert_allclose(picture["depth"][same], pictures[0]["depth"][same], rtol=1e-2)
    np.testing.assert_allclose(cv.world_from_camera(convention="opencv"), pose, atol=1e-6)
    np.testing.assert_allclose(cv.intrinsics(), K, rtol=1e-9)


def test_intrinsics_project_points() -> None:
    """A small ball is seen in the pixel to which K and the pose project its centre."""
    size = (80, 60)
    camera = rg.Camera.look_at(POSITION, TARGET, vfov_degrees=35, size=size)
    K, pose = camera.intrinsics(), np.linalg.inv(camera.world_from_camera(convention="opencv"))
    for place in [(0.1, 0.2, 0.3), (0.5, 0.0, 0.0), (-0.3, 0.6, 0.4)]:
        u, v, w = K @ (pose @ [*place, 1])[:3]
        scene = lit()
        scene.add(rg.Sphere(place, 0.03))
        rows, columns = np.nonzero(render(scene, camera, samples=1, aovs="object_id")["object_id"])
        assert abs(columns.mean() + 0.5 - u / w) < 0.6 and abs(rows.mean() + 0.5 - v / w) < 0.6


def test_parallel_rays() -> None:
    scene = lit()
    scene.add(rg.Sphere((0, 0, 0), 1))
    camera = rg.Camera.look_at((0, 0, 9), (0, 0, 0), orthographic_height=4)
    ids = render(scene, camera, size=(40, 40), samples=1, aovs="object_id")["object_id"]
    # A disk of radius 1 in a picture 4 units high.
    assert abs(ids.sum() / 1600 - math.pi / 16) < 0.01


def test_lenses() -> None:
    with pytest.raises(ValueError, match="give focus_distance"):
        rg.Camera.from_matrix(np.eye(4), vfov_degrees=40, aperture_radius=0.1, convention="opengl")
    sharp = rg.Camera.look_at((0, 0, 4), (0, 0, 0))
    blurred = dataclasses.replace(sharp, aperture_radius=0.5, focus_distance=1.0)
    scene = lit(1)
    scene.add(rg.Sphere((0, 0, 0), 1), material=rg.Material(color=(0, 0, 0)))
    edge = [np.asarray(render(scene, camera, size=(32, 32), samples=64)).std() for camera in (sharp, blurred)]
    assert edge[1] < 0.9 * edge[0]


K = np.array([[50.0, 0, 20], [0, 50, 15], [0, 0, 1]])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((0, 2, 19.5), "principal point at .* where whole numbers are the middles of pixels, add 0.5"),
        ((1, 2, 14.5), "principal point"),
        ((0, 1, 2.0), "skew of 2.0"),
        ((0, 0, 51.0), "fx = 51.0 and fy = 50.0"),
        ((1, 0, 1.0), "give \\[\\[fx, skew, cx\\]"),
        ((1, 1, -50.0), "give \\[\\[fx, skew, cx\\]"),
    ],
)
def test_intrinsics_that_there_are_not_yet(change: tuple[int, int, float], words: str) -> None:
    changed = K.copy()
    changed[change[0], change[1]] = change[2]
    with pytest.raises(ValueError, match=words):
        rg.Camera.from_matrix(np.eye(4), K=changed, size=(40, 30), convention="opencv")


def test_what_is_no_camera() -> None:
    with pytest.raises(ValueError, match="same point as `position`"):
        rg.Camera.look_at((1, 2, 3), (1, 2, 3))
    with pytest.raises(ValueError, match="parallel to the viewing direction"):
        rg.Camera.look_at((0, 5, 0), (0, 0, 0))
    with pytest.raises(ValueError, match="vertical_fov_degrees"):
        rg.Camera.look_at((0, 0, 5), (0, 0, 0), vfov_degrees=180)
    with pytest.raises(ValueError, match="stretches, shears or mirrors"):
        rg.Camera.from_matrix(np.diag([1, 1, -1, 1]), vfov_degrees=40, convention="opencv")
    with pytest.raises(ValueError, match='give "opencv" or "opengl"'):
        rg.Camera.from_matrix(np.eye(4), vfov_degrees=40, convention="blender")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="give size"):
        rg.Camera.from_matrix(np.eye(4), K=K, convention="opencv")
    with pytest.raises(ValueError, match="give one of K, vfov_degrees"):
        rg.Camera.from_matrix(np.eye(4), convention="opencv")
    with pytest.raises(ValueError, match="three finite numbers"):
        rg.Camera.look_at((0, 0), (0, 0, 0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="the scene has no camera"):
        render(lit())
