"""Renders: settings, resident scenes, progress."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest
from conftest import FRONT, lit, render

import raggio as rg


def ball(color: tuple[float, float, float] = (0.8, 0.4, 0.2)) -> rg.Scene:
    scene = lit()
    scene.materials["clay"] = rg.Material(color=color)
    scene.add(rg.Sphere((0, 0, 0), 1), material="clay")
    return scene


def test_seeds_and_samples() -> None:
    first = render(ball(), FRONT, size=(16, 16), samples=4)
    np.testing.assert_array_equal(first, render(ball(), FRONT, size=(16, 16), samples=4, threads=1))
    assert not np.array_equal(first, render(ball(), FRONT, size=(16, 16), samples=4, seed=1))
    assert first.samples == 4 and first.finished and first.rays > 16 * 16 * 4 and "cpu" in first.device
    assert render(ball(), FRONT.with_size(20, 10), samples=1).shape == (10, 20, 3)


def test_ends_of_sampling() -> None:
    limited = render(ball(), FRONT, size=(64, 64), time_limit=0.2)
    assert limited.samples > 0 and not limited.finished and 0.1 < limited.seconds < 2
    quiet = render(ball(), FRONT, size=(64, 64), noise=0.05, samples=4096, aovs="samples")
    assert quiet["samples"].min() < 4096 and quiet.finished


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"samples": 0}, "samples is 0"),
        ({"seed": -1}, "seed is -1"),
        ({"time_limit": 0}, "time_limit is 0"),
        ({"noise": float("nan")}, "noise is nan"),
        ({"size": (0, 5)}, "size is"),
        ({"size": 5}, "size is 5"),
        ({"max_depth": 70000}, "max_depth is 70000"),
        ({"threads": 0}, "threads is 0"),
    ],
)
def test_settings_that_are_wrong(options, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        render(ball(), FRONT, **options)


def test_devices() -> None:
    assert rg.devices()[0].id == "cpu" and not rg.devices()[0].missing
    assert rg.devices()[0].tracer == "software" and not rg.devices()[0].has_ray_queries
    with pytest.raises(rg.DeviceError, match="nothing that is cpu here traces rays by hardware"):
        rg.render(ball(), FRONT, device="cpu", tracer="hardware")
    with pytest.raises(ValueError, match="tracer: unknown tracer: give auto, software or hardware"):
        rg.render(ball(), FRONT, device="cpu", tracer="magic")  # type: ignore[arg-type]
    with pytest.raises(rg.DeviceError, match="device: .*cpu"):
        rg.render(ball(), FRONT, device="toaster")
    with pytest.raises(rg.Error):
        rg.render(ball(), FRONT, device="vulkan:99")
    with pytest.raises(rg.SceneError, match="GiB of memory"):
        render(ball(), FRONT, size=(65536, 65536))


def test_many_views_are_single_views() -> None:
    cameras = [rg.Camera.look_at((np.sin(a), 0.3, np.cos(a)), (0, 0, 0)) for a in (2.5, 3.5, 4.5)]
    cameras = [
        rg.Camera.look_at(4 * np.array(c.position), (0, 0, 0), size=(16 + 4 * i, 12)) for i, c in enumerate(cameras)
    ]
    scene = ball()
    for i, image in rg.render_many(scene, cameras, samples=4, device="cpu", aovs=("depth", "object_id", "normal")):
        alone = render(scene, cameras[i], samples=4, aovs=("depth", "object_id", "normal"))
        np.testing.assert_array_equal(image, alone)
        for layer in alone.layers:
            np.testing.assert_array_equal(image[layer], alone[layer])
    assert i == 2


def test_steps_add_up() -> None:
    renderer = rg.Renderer(ball(), FRONT, size=(16, 16), device="cpu", aovs="depth")
    renderer.step(3)
    renderer.step(5)
    image = renderer.image
    assert image.samples == 8 == renderer.samples and "8 samples" in repr(renderer)
    np.testing.assert_array_equal(image, render(ball(), FRONT, size=(16, 16), samples=8))
    renderer.step(2)
    assert renderer.image.samples == 10 and image.samples == 8


def test_edits_begin_anew() -> None:
    scene = ball()
    renderer = rg.Renderer(scene, FRONT, size=(16, 16), device="cpu", aovs="object_id")
    renderer.step(4)
    side = rg.Camera.look_at((4, 0, 0), (0, 1, 0))
    renderer.camera = side
    assert renderer.samples == 0 and renderer.camera is side
    renderer.step(4)
    np.testing.assert_array_equal(renderer.image, render(ball(), side, size=(16, 16), samples=4))
    scene.materials["clay"] = rg.Material(color=(0, 1, 0))
    renderer.step(4)
    np.testing.assert_array_equal(renderer.image, render(ball((0, 1, 0)), side, size=(16, 16), samples=4))
    scene.add(rg.Sphere((0, 1, 0), 0.3), id=50)
    assert 50 in renderer.image["object_id"] and renderer.samples == 1
    renderer.size = (20, 10)
    assert renderer.image.shape == (10, 20, 3) == (*renderer.size[::-1], 3)


def test_progress_is_told() -> None:
    told: list[tuple[float, int, float]] = []
    render(ball(), FRONT, size=(64, 64), samples=64, progress=lambda *report: told.append(report))
    fractions = [fraction for fraction, _, _ in told]
    assert fractions == sorted(fractions) and fractions[-1] == 1.0 and told[-1][1] == 64


def test_progress_that_fails_ends_the_render() -> None:
    def fail(fraction: float, samples: int, seconds: float) -> None:
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough") as caught:
        render(ball(), FRONT, size=(64, 64), samples=10**6, progress=fail)
    assert caught.value.image.shape == (64, 64, 3)  # type: ignore[attr-defined]


def test_bars(capsys) -> None:
    pytest.importorskip("tqdm", reason="tqdm is not installed")
    render(ball(), FRONT, size=(32, 32), samples=16, progress=True)
    assert "raggio" in capsys.readouterr().err
    render(ball(), FRONT, size=(32, 32), samples=16)
    assert capsys.readouterr().err == ""


def test_denoising() -> None:
    if importlib.util.find_spec("pyoidn") is None:
        pytest.skip("pyoidn is not installed")
    # A lamp makes noise.
    scene = rg.Scene()
    scene.add(rg.Plane((0, -1, 0), (0, 1, 0)))
    scene.add(rg.Sphere((2, 2, 2), 0.4), material=rg.Material(emission_strength=30))
    camera = rg.Camera.look_at((0, 1, 6), (0, 0, 0))
    noisy, clean, truth = (
        np.asarray(render(scene, camera, size=(48, 48), samples=samples, denoise=denoise))
        for samples, denoise in ((4, False), (4, True), (1024, False))
    )
    error = lambda image: float(np.square(image - truth).mean())  # noqa: E731
    assert error(clean) < 0.5 * error(noisy)
