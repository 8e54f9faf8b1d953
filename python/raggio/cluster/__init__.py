"""Renders on several machines, by Ray (``pip install 'raggio[cluster]'``).

>>> import raggio as rg
>>> import raggio.cluster
>>> scene = rg.load("room.glb")  # doctest: +SKIP
>>> image = rg.cluster.render(scene, samples=4096, address="auto")  # doctest: +SKIP
"""

from __future__ import annotations

from ._connect import ClusterError
from ._render import render

__all__ = ["ClusterError", "render"]
