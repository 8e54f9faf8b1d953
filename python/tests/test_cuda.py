"""Pictures in the memory of CUDA's devices."""

from __future__ import annotations

import importlib.util
from typing import Any

import numpy as np
import pytest
from conftest import FRONT, lit

import raggio as rg
from raggio import _raggio


def missing() -> str | None:
    """Why there is no CUDA, if there is none."""
    try:
        return None if _raggio.cuda_devices() else "there is no device of CUDA"
    except rg.DeviceError as error:
        return str(error)


def vulkan() -> str | None:
    """The Vulkan device of an NVIDIA card, if there is one."""
    return next((device.id for device in rg.devices() if "NVIDIA" in device.name and not device.missing), None)


needs_cuda = pytest.mark.skipif(missing() is not None, reason=f"{missing()}")
needs_both = pytest.mark.skipif(missing() is not None or vulkan() is None, reason=f"{missing() or 'no Vulkan of NVIDIA'}")
SIZE = (67, 45)


def ball() -> rg.Scene:
    scene = lit()
    scene.add(rg.Sphere((0, 0, 0), 1), material=rg.Material(color=(0.8, 0.4, 0.2)))
    return scene


def on_host(array: Any) -> list[np.ndarray]:
    """The array as each library that is here reads it."""
    found = []
    if importlib.util.find_spec("torch"):
        import torch

        for tensor in (torch.from_dlpack(array), torch.as_tensor(array, device="cuda")):
            assert tensor.is_cuda and tensor.dtype == torch.float32
            found.append(tensor.cpu().numpy())
    if importlib.util.find_spec("cupy"):
        import cupy

        found += [cupy.asnumpy(cupy.from_dlpack(array)), cupy.asnumpy(cupy.asarray(array))]
    assert found, "neither torch nor cupy is here"
    return found


@pytest.mark.skipif(missing() is None, reason="CUDA is here")
def test_without_cuda_the_reason_is_told() -> None:
    image = rg.render(ball(), FRONT, size=(4, 4), samples=1, device="cpu")
    for ask in (image.cuda, lambda: image.__dlpack__(dl_device=(2, 0)), rg.Renderer(ball(), FRONT, device="cpu").cuda):
        with pytest.raises(rg.DeviceError, match="CUDA cannot be used: "):
            ask()
    with pytest.raises(rg.DeviceError, match="CUDA cannot be used: "):
        rg.render(ball(), FRONT, size=(4, 4), samples=1, device="cpu", cuda=True)
    # What the CPU has is there all the same.
    assert image.__dlpack_device__() == (1, 0) and (np.from_dlpack(image) == image.pixels).all()


@needs_cuda
def test_pictures_of_the_cpu_are_copied() -> None:
    image = rg.render(ball(), FRONT, size=SIZE, samples=4, device="cpu", alpha=True)
    array = image.cuda()
    assert array.shape == (45, 67, 4) and array.device == 0 and array.__dlpack_device__() == (2, 0)
    for found in on_host(array):
        np.testing.assert_array_equal(found, image.pixels)
    with pytest.raises(rg.DeviceError, match="there is no device 99"):
        image.cuda(99)
    with pytest.raises(BufferError, match="takes a copy"):
        image.__dlpack__(dl_device=(2, 0), copy=False)
    with pytest.raises(BufferError, match="on another device"):
        array.__dlpack__(dl_device=(1, 0))


@needs_both
def test_pictures_of_the_gpu_stay_there() -> None:
    device = vulkan()
    assert device is not None
    image = rg.render(ball(), FRONT, size=SIZE, samples=9, device=device, cuda=True)
    assert image.cuda() is image.cuda(), "nothing is copied"
    for found in on_host(image.cuda()):
        np.testing.assert_array_equal(found, image.pixels)
    # From step to step, and of large pictures in several buffers.
    renderer = rg.Renderer(ball(), FRONT, size=(1500, 1000), device=device)
    for _ in range(2):
        renderer.step(3)
        session = renderer._session.cuda()
        assert session is not None, "it does not go through the host"
        for found in on_host(session):
            np.testing.assert_array_equal(found, renderer.image.pixels)
    # What has alpha or is without noise comes from the host, and is the picture too.
    cut = rg.render(ball(), FRONT, size=SIZE, samples=4, device=device, cuda=True, alpha=True)
    for found in on_host(cut.cuda()):
        np.testing.assert_array_equal(found, cut.pixels)


@needs_both
def test_memory_of_the_gpu_is_given_back() -> None:
    torch = pytest.importorskip("torch", reason="torch is not installed")
    renderer = rg.Renderer(ball(), FRONT, size=(1000, 1000), device=vulkan() or "")
    renderer.step(1)
    kept = torch.from_dlpack(renderer.cuda())
    expected = kept.cpu()
    free = []
    for _ in range(60):
        renderer.cuda().__dlpack__()
        torch.from_dlpack(renderer.cuda())
        free.append(torch.cuda.mem_get_info()[0])
    assert free[10] - free[-1] < 60 << 20, f"{free[10]} and then {free[-1]} bytes are free"
    assert (kept.cpu() == expected).all()
