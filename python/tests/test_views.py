"""Many views of one scene, as data sets are made."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import lit, memory

import raggio as rg

#: Growth that is none, in bytes.
FLAT = 20e6


@pytest.mark.parametrize("aovs", [(), ("depth", "normal", "object_id")])
def test_memory_of_many_views_is_flat(aovs) -> None:
    """Views take the same memory however many there are; were each kept, it would be 50 MB and more."""
    scene = lit()
    for x in range(8):
        scene.add(rg.Sphere((x - 3.5, 0, 0), 0.5), material=rg.Material(color=(0.8, 0.4, 0.2)))
    angles = np.linspace(0, 2 * np.pi, 300)
    cameras = (rg.Camera.look_at((9 * np.sin(a), 2, 9 * np.cos(a)), (0, 0, 0)) for a in angles)
    before = 0
    for i, view in rg.render_many(scene, cameras, size=(128, 128), samples=1, aovs=aovs, device="cpu"):
        assert view.shape == (128, 128, 3) and set(view.layers) == set(aovs)
        if i == 50:
            before = memory()
    assert memory() - before < FLAT
