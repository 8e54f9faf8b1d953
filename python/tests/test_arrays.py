"""Arrays of pictures and layers, against closed forms."""

from __future__ import annotations

import io
import subprocess
import sys
import typing

import numpy as np
import pytest
from conftest import FRONT, SQUARE, lit, render

import raggio as rg
from raggio import _raggio
from raggio._image import ToneMapper


def test_furnace() -> None:
    """A convex body of reflectance r in light of radiance L from everywhere has radiance r L."""
    scene = lit(2.0)
    scene.add(rg.Sphere((0, 0, 0), 1), material=rg.Material(color=(0.25, 0.5, 0.75)))
    image = render(scene, FRONT, size=(32, 32), samples=256)
    pixels = np.asarray(image)
    assert pixels.shape == (32, 32, 3) and pixels.dtype == np.float32
    np.testing.assert_allclose(pixels[12:20, 12:20].mean(axis=(0, 1)), [0.5, 1.0, 1.5], rtol=5e-3)
    np.testing.assert_allclose(pixels[0, 0], [2, 2, 2], rtol=1e-6)


def test_rows_begin_at_the_top() -> None:
    scene = lit()
    scene.environment = rg.Environment(horizon=(0, 0, 0), zenith=(1, 1, 1))
    pixels = np.asarray(render(scene, FRONT, size=(8, 8), samples=4))
    assert pixels[0].mean() > pixels[-1].mean()


def test_depth_and_distance_of_a_plane() -> None:
    scene = lit()
    scene.add(rg.Plane((0, 0, -3), (0, 0, 1)))
    camera = rg.Camera.look_at((0, 0, 0), (0, 0, -1), vfov_degrees=60)
    image = render(scene, camera, size=(9, 7), samples=64, aovs=("depth", "distance", "normal", "position"))
    np.testing.assert_allclose(image["depth"], np.full((7, 9), 3), rtol=1e-5)
    # Distances vary within a pixel, by the second order of its size.
    tangent = np.tan(np.radians(30)) / 3.5
    x, y = np.meshgrid(np.arange(9) - 4, np.arange(7) - 3)
    expected = 3 * np.sqrt(1 + tangent**2 * (x**2 + y**2))
    np.testing.assert_allclose(image["distance"], expected, rtol=5e-3)
    assert (image["distance"] >= image["depth"]).all()
    np.testing.assert_allclose(image["normal"], np.broadcast_to([0, 0, 1], (7, 9, 3)), atol=1e-4)
    np.testing.assert_allclose(image["position"][..., 2], -3, rtol=1e-5)


def test_nothing_is_infinitely_far_and_has_no_number() -> None:
    image = render(lit(), FRONT, size=(4, 4), samples=1, aovs=("depth", "distance", "object_id", "material_id"))
    assert np.isinf(image["depth"]).all() and np.isinf(image["distance"]).all()
    assert image["object_id"].dtype == np.int32 and not image["object_id"].any()
    assert image["material_id"].dtype == np.int32 and not image["material_id"].any()


def test_ids() -> None:
    scene = lit()
    scene.add(rg.Sphere((-1, 0, 0), 0.5), id=7, name="left")
    right = scene.add(rg.Sphere((1, 0, 0), 0.5))
    assert right == 8
    # Two meshes of one object.
    scene.add(SQUARE, transform=np.diag([0.2, 0.2, 0.2, 1]), id=40)
    scene.add(SQUARE, transform=[[0.2, 0, 0, 0], [0, 0.2, 0, 1], [0, 0, 0.2, 0], [0, 0, 0, 1]], id=40)
    ids = render(scene, FRONT, size=(64, 64), samples=1, aovs="object_id")["object_id"]
    assert set(np.unique(ids).tolist()) == {0, 7, 8, 40}
    # The camera sees x from -tan(20 degrees) 4 to as much at the origin.
    column = lambda x: int(32 + 32 * x / (4 * np.tan(np.radians(20))))  # noqa: E731
    assert ids[32, column(-1)] == 7 and ids[32, column(1)] == 8 and ids[32, column(0)] == 40
    assert ids[31 - (column(1) - 32), 32] == 40
    assert [item.name for item in scene.objects] == ["left", None, None, None]


def test_ids_of_files_come_first(file) -> None:
    scene = rg.load(file)
    assert scene.add(rg.Sphere((0, 3, 0), 0.2)) == 2
    with pytest.raises(ValueError, match="the id 1 is that of a shape of the file"):
        scene.add(rg.Sphere((0, 3, 0), 0.2), id=1)
    with pytest.raises(ValueError, match="0 is the background"):
        rg.Scene().add(rg.Sphere((0, 3, 0), 0.2), id=0)
    ids = render(scene, samples=1, aovs="object_id")["object_id"]
    assert ids[16, 24] == 1


def test_numbers_are_not_filtered() -> None:
    """Numbers at the edge of two objects are theirs, and no mean of them."""
    scene = lit()
    scene.add(rg.Sphere((-0.5, 0, 0), 0.7), id=100)
    scene.add(rg.Sphere((0.5, 0, 0), 0.7), id=300)
    ids = render(scene, FRONT, size=(50, 50), samples=64, aovs="object_id")["object_id"]
    assert set(np.unique(ids).tolist()) == {0, 100, 300}


def test_sharing_of_memory() -> None:
    image = render(lit(), FRONT, size=(5, 3), samples=1, aovs="depth")
    pixels = np.asarray(image)
    assert np.shares_memory(pixels, image.pixels) and np.shares_memory(np.array(image, copy=False), pixels)
    assert not np.shares_memory(np.array(image), pixels) and not np.shares_memory(np.array(image, copy=True), pixels)
    assert np.asarray(image, dtype=np.float64).dtype == np.float64
    with pytest.raises(ValueError):
        image.__array__(np.float64, copy=False)
    through = np.from_dlpack(image)
    assert np.shares_memory(through, pixels) and image.__dlpack_device__() == (1, 0)
    # Arrays outlive their image.
    depth = image["depth"]
    expected = pixels.copy()
    del image
    np.testing.assert_array_equal(pixels, expected)
    assert depth.shape == (3, 5)


def test_torch_and_others_take_the_memory() -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed")
    image = render(lit(), FRONT, size=(5, 3), samples=1)
    assert torch.from_dlpack(image).shape == (3, 5, 3)


def test_layers_that_were_not_asked_for() -> None:
    image = render(lit(), FRONT, size=(4, 4), samples=1, aovs=("depth", "depth"))
    assert list(image.layers) == ["depth"]
    with pytest.raises(KeyError, match="ask for it with aovs="):
        image["normal"]
    with pytest.raises(ValueError, match="there is no layer 'dept'"):
        render(lit(), FRONT, aovs="dept")
    everything = render(lit(), FRONT, size=(4, 4), samples=2, aovs="all")
    assert set(everything.layers) == set(rg.AOVS)
    assert everything["albedo"].shape == (4, 4, 3) and everything["motion"].shape == (4, 4, 2)
    assert (everything["samples"] == 2).all()


def test_files_are_those_of_the_program(file, tmp_path) -> None:
    """The program and the module write the same EXR, byte for byte, and the same PNG."""
    layers = ["depth", "distance", "normal", "object_id", "samples"]
    outputs = [str(tmp_path / name) for name in ("program.exr", "program.png")]
    arguments = ["raggio", "render", str(file), "--device", "cpu", "--quiet", "--aov", ",".join(layers)]
    assert run_program([*arguments, "-o", outputs[0], "-o", outputs[1]]) == 0
    image = render(rg.load(file), aovs=layers)
    image.save(tmp_path / "module.exr")
    image.save(tmp_path / "module.png")
    assert (tmp_path / "module.exr").read_bytes() == (tmp_path / "program.exr").read_bytes()
    assert (tmp_path / "module.png").read_bytes() == (tmp_path / "program.png").read_bytes()
    assert _raggio.AOVS == list(rg.AOVS)


def run_program(arguments: list[str]) -> int:
    """The program takes its process for its own."""
    return subprocess.run([sys.executable, "-m", *arguments], check=False).returncode


def test_exr_holds_the_array(tmp_path) -> None:
    openexr = pytest.importorskip("OpenEXR", reason="OpenEXR is not installed")
    scene = lit(1.5)
    scene.add(rg.Sphere((0, 0, 0), 1), id=9)
    image = render(scene, FRONT, size=(16, 12), samples=3, aovs=("depth", "object_id"))
    image.save(tmp_path / "a.exr")
    with openexr.File(str(tmp_path / "a.exr"), separate_channels=True) as stored:
        channels = stored.channels()
        stacked = np.stack([channels[name].pixels for name in "RGB"], axis=-1)
        np.testing.assert_array_equal(stacked, np.asarray(image))
        np.testing.assert_array_equal(channels["depth.Z"].pixels, image["depth"])
        np.testing.assert_array_equal(channels["object_id.I"].pixels, image["object_id"])


def test_tone_mapping_and_png() -> None:
    pillow = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    image = render(lit(0.18), FRONT, size=(6, 4), samples=1)
    shown = image.tonemap()
    assert shown.shape == (4, 6, 3) and shown.dtype == np.uint8
    png = np.asarray(pillow.open(io.BytesIO(image._repr_png_())))
    np.testing.assert_array_equal(png, shown)
    assert list(typing.get_args(ToneMapper)) == _raggio.TONE_MAPPERS
    assert image.tonemap(exposure=1).mean() > shown.mean() > image.tonemap(exposure=-1).mean()
    with pytest.raises(ValueError, match="unknown tone mapper"):
        image.tonemap(tone_mapper="sepia")  # type: ignore[arg-type]


def test_saving_refuses(tmp_path) -> None:
    image = render(lit(), FRONT, size=(4, 4), samples=1)
    with pytest.raises(rg.OutputError, match="the ending must be .png"):
        image.save(tmp_path / "a.jpg")
    with pytest.raises(OSError, match="cannot write"):
        image.save(tmp_path / "nowhere" / "a.png")
    image.save(tmp_path / "a.png", png_bits=16)
    assert (tmp_path / "a.png").exists() and "4x4" in repr(image)
