"""The alpha channel: what is covered, and how it goes to arrays and files."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from conftest import FRONT, lit, render

import raggio as rg

OpenEXR = pytest.importorskip("OpenEXR", reason="OpenEXR is not installed")
PIL = pytest.importorskip("PIL.Image", reason="Pillow is not installed")


def lamp(background: float) -> rg.Scene:
    """A red lamp that reflects nothing, before a background."""
    scene = lit(background)
    red = rg.Material(color=(0, 0, 0), emission_color=(2, 0.2, 0.1), emission_strength=1)
    scene.add(rg.Sphere((0, 0, 0), 1), material=red)
    return scene


def test_composites() -> None:
    """Over a background the picture is that with the background."""
    for samples in (1, 7, 64):
        image = render(lamp(0.75), FRONT, size=(40, 30), samples=samples, alpha=True)
        rgba = np.asarray(image)
        assert rgba.shape == image.shape == (30, 40, 4) and rgba.dtype == np.float32 and image.alpha is not None
        np.testing.assert_array_equal(image.alpha, rgba[..., 3])
        whole = render(lamp(0.75), FRONT, size=(40, 30), samples=samples)
        assert whole.shape == (30, 40, 3) and whole.alpha is None
        np.testing.assert_allclose(rgba[..., :3] + (1 - rgba[..., 3:]) * 0.75, whole, atol=1e-6)
        assert rgba[15, 20, 3] == 1 and not rgba[0, 0].any()


def test_a_silhouette() -> None:
    camera = rg.Camera.look_at((0, 0, 9), (0, 0, 0), orthographic_height=4)
    alpha = render(lamp(1), camera, size=(40, 40), samples=64, alpha=True).alpha
    assert alpha is not None and abs(alpha.sum() / 1600 - np.pi / 16) < 1e-3


def test_the_background_is_seen_through_glass() -> None:
    scene = lit()
    scene.add(rg.Sphere((0, 0, 0), 1), material=rg.Material(color=(1, 1, 1), refractive_index=1.5))
    rgba = np.asarray(render(scene, FRONT, size=(16, 16), samples=16, alpha=True, max_depth=0))
    assert rgba[8, 8, 3] == 1 and abs(rgba[8, 8, :3].mean() - 1) < 0.05 and not rgba[0, 0].any()


def test_files(tmp_path: Path) -> None:
    image = render(lamp(1), FRONT, size=(40, 30), samples=16, alpha=True, aovs="depth")
    rgba = np.asarray(image)
    image.save(tmp_path / "a.exr")
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as exr:
        channels = exr.channels()
        stored = np.stack([channels[name].pixels for name in "RGBA"], axis=-1)
        assert "depth.Z" in channels
    np.testing.assert_array_equal(stored, rgba)
    shown = image.tonemap(tone_mapper="none", exposure=-2)
    assert shown.shape == (30, 40, 4) and shown.dtype == np.uint8
    np.testing.assert_array_equal(shown[..., 3], np.round(rgba[..., 3] * 255))
    # Edges have the lamp's own colour, however little of it is there.
    covered = rgba[..., 3] > 0
    assert (0 < rgba[..., 3]).sum() > (rgba[..., 3] == 1).sum()
    assert np.ptp(shown[covered][:, :3].astype(int), axis=0).max() <= 1
    for bits in (8, 16):
        image.save(tmp_path / "a.png", tone_mapper="none", exposure=-2, png_bits=bits)  # type: ignore[arg-type]
        opened = PIL.open(tmp_path / "a.png")
        assert opened.mode == "RGBA"
        assert np.abs(np.asarray(opened).astype(int) - shown).max() <= (0 if bits == 8 else 1)
    assert np.asarray(PIL.open(io.BytesIO(image._repr_png_()))).shape == (30, 40, 4)


def test_a_picture_that_grows() -> None:
    """Coverage keeps up with the samples, and begins anew with the picture."""
    renderer = rg.Renderer(lamp(0.5), FRONT, size=(40, 30), device="cpu", alpha=True)
    for samples in (3, 5):
        renderer.step(samples)
        once = render(lamp(0.5), FRONT, size=(40, 30), samples=renderer.samples, alpha=True)
        np.testing.assert_array_equal(renderer.image, once)
        np.testing.assert_array_equal(renderer.image, once)
    renderer.camera = rg.Camera.look_at((3, 0, 0), (0, 0, 0))
    renderer.step(2)
    once = render(lamp(0.5), renderer.camera, size=(40, 30), samples=2, alpha=True)
    np.testing.assert_array_equal(renderer.image, once)
    cameras = [FRONT, renderer.camera]
    views = list(rg.render_many(lamp(0.5), cameras, size=(40, 30), samples=2, device="cpu", alpha=True))
    np.testing.assert_array_equal(views[1][1], once)


def test_scenes_may_say_it(file: Path) -> None:
    file.write_text(file.read_text().replace("samples = 8", "samples = 8\nalpha = true"))
    scene = rg.load(file)
    assert render(scene).shape == (32, 48, 4)
    assert render(scene, alpha=False).shape == (32, 48, 3)
