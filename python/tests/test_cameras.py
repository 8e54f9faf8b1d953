"""Cameras: conventions agree, and projections are those that numpy computes."""

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


Place = tuple[float, float, float]


def seen(camera: rg.Camera, places: list[Place], size: tuple[int, int]) -> list[tuple[float, float]]:
    """Where small balls are seen: the mean (column, row) of the pixels of each, whose middles are whole numbers."""
    scene = lit()
    for place in places:
        scene.add(rg.Sphere(place, 0.02))
    ids = render(scene, camera, size=size, samples=1, aovs="object_id")["object_id"]
    found = [np.nonzero(ids == number) for number in range(1, len(places) + 1)]
    return [(float(columns.mean()), float(rows.mean())) for rows, columns in found]


#: fx != fy, a principal point far off the middle, skew.
K = np.array([[210.0, 15, 31.25], [0, 260, 88.5], [0, 0, 1]])


@pytest.mark.parametrize("pixel_origin", ["corner", "center"])
@pytest.mark.parametrize("convention", ["opencv", "opengl"])
def test_intrinsics_of_any_kind(convention: rg._camera.Convention, pixel_origin: rg._camera.PixelOrigin) -> None:
    """Balls are seen where numpy projects their centres by K, in both conventions of axes and of pixels."""
    size = (160, 120)
    pose_cv = rg.Camera.look_at(POSITION, TARGET).world_from_camera(convention="opencv")
    pose = pose_cv if convention == "opencv" else pose_cv * np.array([1, -1, -1, 1])
    camera = rg.Camera.from_matrix(pose, K=K, size=size, convention=convention, pixel_origin=pixel_origin)
    np.testing.assert_allclose(camera.intrinsics(pixel_origin=pixel_origin), K, rtol=1e-12)
    # Points that are seen in chosen pixels, at several distances.
    pixels = [(20.0, 30.0), (130.0, 100.0), (80.0, 60.0), (40.0, 95.0)]
    rays = [np.linalg.inv(K) @ (u, v, 1.0) * depth for (u, v), depth in zip(pixels, (2, 3, 4, 5))]
    places = [tuple((pose_cv @ (*ray, 1.0))[:3].tolist()) for ray in rays]
    # The array's pixel [row, column] has its middle half a pixel from the outer corner.
    shift = 0.5 if pixel_origin == "corner" else 0.0
    for (u, v), (column, row) in zip(pixels, seen(camera, places, size)):
        assert abs(column + shift - u) < 0.3 and abs(row + shift - v) < 0.3

    # At another size all is in proportion; the camera says which K that is.
    twice = camera.intrinsics((320, 240), pixel_origin=pixel_origin)
    for ray, (column, row) in zip(rays, seen(camera, places, (320, 240))):
        u, v, w = twice @ ray
        assert abs(column + shift - u / w) < 0.5 and abs(row + shift - v / w) < 0.5
    # Wider than before: as much more to the left as to the right.
    wider = camera.intrinsics((200, 120))
    assert wider[0, 2] - camera.intrinsics()[0, 2] == 20 and (wider[:, :2] == camera.intrinsics()[:, :2]).all()


def test_a_plain_matrix_is_a_field_of_view() -> None:
    """K with its principal point in the middle and square pixels gives the picture of the angle."""
    size = (40, 30)
    looking = rg.Camera.look_at(POSITION, TARGET, vfov_degrees=50, size=size)
    pose = looking.world_from_camera(convention="opencv")
    same = rg.Camera.from_matrix(pose, K=looking.intrinsics(), size=size, convention="opencv")
    pictures = [np.asarray(render(views(), camera, samples=16)) for camera in (looking, same)]
    assert np.abs(pictures[0] - pictures[1]).mean() < 2e-3


def test_a_lens_with_intrinsics() -> None:
    """What is in focus stays where K puts it."""
    pose = rg.Camera.look_at((0, 0, 4), (0, 0, 0)).world_from_camera(convention="opencv")
    ray = np.linalg.inv(K) @ (100.0, 60.0, 1.0) * 3
    place = tuple((pose @ (*ray, 1.0))[:3].tolist())
    camera = rg.Camera.from_matrix(
        pose, K=K, size=(160, 120), convention="opencv", aperture_radius=0.5, focus_distance=3.0
    )
    [(column, row)] = seen(camera, [place], (160, 120))
    assert abs(column + 0.5 - 100) < 0.3 and abs(row + 0.5 - 60) < 0.3


def test_panoramas() -> None:
    """A panorama of the sky alone is the sky's image, and directions are where they should be."""
    size = (64, 32)
    image = np.random.default_rng(3).uniform(0.1, 2.0, (32, 64, 3)).astype(np.float32)
    scene = rg.Scene()
    scene.environment = rg.Environment(image=image)
    ahead = rg.Camera.look_at((1, 2, 3), (1, 2, 0), panorama="latitude-longitude")
    scene_file = rg.Scene()
    scene_file.camera = ahead
    assert scene_file.camera == ahead
    # Samples all over the pixels see the blend of texels, whose mean weighs the neighbours evenly.
    found = np.asarray(render(scene, ahead, size=size, samples=256))
    padded = np.pad(np.pad(image, ((0, 0), (1, 1), (0, 0)), mode="wrap"), ((1, 1), (0, 0), (0, 0)), mode="edge")
    near = np.lib.stride_tricks.sliding_window_view(padded, (3, 3), axis=(0, 1))
    weights = np.outer((1 / 8, 3 / 4, 1 / 8), (1 / 8, 3 / 4, 1 / 8))
    np.testing.assert_allclose(found, (near * weights).sum((-1, -2)), atol=0.02)

    # right, up, behind and to the left
    places = [(9.0, 2.0, 3.0), (1.0, 10.0, 3.5), (0.0, 2.0, 10.0), (-7.0, 2.0, 3.0)]
    world = np.array(places) - (1, 2, 3)
    columns = (0.5 + np.arctan2(world[:, 0], -world[:, 2]) / math.tau) * 256 - 0.5
    rows = (0.5 - np.arctan2(world[:, 1], np.hypot(world[:, 0], world[:, 2])) / math.pi) * 128 - 0.5
    scene = lit()
    for place in places:
        scene.add(rg.Sphere(place, 0.3))
    picture = render(scene, ahead, size=(256, 128), samples=1, aovs=("object_id", "depth", "distance"))
    for number, (column, row) in enumerate(zip(columns, rows), 1):
        there = np.nonzero(picture["object_id"] == number)
        assert abs(there[0].mean() - row) < 0.6
        if number != 2:
            assert abs(there[1].mean() - column) < 0.6
    np.testing.assert_array_equal(picture["depth"], picture["distance"])
    with pytest.raises(ValueError, match="intrinsics are those of a pinhole"):
        ahead.intrinsics((4, 4))


def test_cameras_in_scenes() -> None:
    """A scene keeps a camera of any kind, and its text says all of it."""
    pose = rg.Camera.look_at(POSITION, TARGET).world_from_camera(convention="opencv")
    for camera in (
        rg.Camera.look_at(POSITION, TARGET),
        rg.Camera.look_at(POSITION, TARGET, orthographic_height=2.5),
        rg.Camera.look_at(POSITION, TARGET, panorama="latitude-longitude"),
        rg.Camera.from_matrix(pose, K=K, size=(160, 120), convention="opencv"),
    ):
        scene = rg.Scene()
        scene.environment = rg.Environment(color=(1, 1, 1))
        scene.camera = camera
        assert scene.camera is not None and dataclasses.replace(scene.camera, size=camera.size) == camera


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ((1, 0, 1.0), "give \\[\\[fx, skew, cx\\]"),
        ((1, 1, -50.0), "give \\[\\[fx, skew, cx\\]"),
        ((2, 2, 2.0), "give \\[\\[fx, skew, cx\\]"),
        ((0, 0, math.nan), "finite numbers"),
        ((0, 1, 1e5), "`skew` in \\[camera.intrinsics\\] must be at most 10 times"),
        ((0, 2, 1e12), "`principal_point` in \\[camera.intrinsics\\] must be at most 1e9"),
    ],
)
def test_what_is_no_matrix(change: tuple[int, int, float], words: str) -> None:
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
    with pytest.raises(ValueError, match="orthographic_height cannot stand beside vfov_degrees"):
        rg.Camera.look_at((0, 0, 5), (0, 0, 0), vfov_degrees=40, orthographic_height=2)
    with pytest.raises(ValueError, match="`aperture_radius` in \\[camera\\] cannot stand beside `panorama`"):
        rg.Camera.look_at((0, 0, 5), (0, 0, 0), panorama="latitude-longitude", aperture_radius=0.1)
    with pytest.raises(ValueError, match='"latitude-longitude"'):
        rg.Camera.look_at((0, 0, 5), (0, 0, 0), panorama="fisheye")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match='give "corner" or "center"'):
        rg.Camera.from_matrix(
            np.eye(4), K=K, size=(4, 4), convention="opencv", pixel_origin="edge"  # type: ignore[arg-type]
        )
    with pytest.raises(ValueError, match="three finite numbers"):
        rg.Camera.look_at((0, 0), (0, 0, 0))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="the scene has no camera"):
        render(lit())
