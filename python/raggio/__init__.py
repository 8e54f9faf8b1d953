"""raggio: a progressive path tracer on Vulkan and the CPU.

>>> import raggio as rg
>>> scene = rg.Scene()
>>> scene.environment = rg.Environment(color=(1, 1, 1))
>>> _ = scene.add(rg.Sphere(center=(0, 0, 0), radius=1), material=rg.Material(color=(0.8, 0.4, 0.2)))
>>> image = rg.render(scene, rg.Camera.look_at((0, 0, 4), (0, 0, 0)), size=(64, 48), samples=4)
>>> image.shape
(48, 64, 3)
"""

from __future__ import annotations

import os as _os

from . import _raggio, datasets
from ._camera import Camera, Intrinsics
from ._cuda import CudaArray
from ._errors import (
    DenoiseError,
    DeviceError,
    Error,
    InternalError,
    Interrupted,
    OutputError,
    SceneError,
    SceneWarning,
)
from ._image import Image
from ._lights import DirectionalLight, PointLight, SpotLight
from ._materials import Environment, Material, Medium, Principled, Texture
from ._notebook import view
from ._render import Device, Renderer, devices, render, render_many
from ._scene import Animation, Object, Scene, load
from ._shapes import Box, Cone, Cylinder, Disk, Group, Mesh, Plane, Rectangle, Sphere

__version__: str = _raggio.__version__
#: Names of the layers that ``aovs=`` takes.
AOVS: tuple[str, ...] = tuple(_raggio.AOVS)

if hasattr(_os, "register_at_fork"):
    _os.register_at_fork(after_in_child=_raggio.forget_after_fork)

__all__ = [
    "AOVS",
    "Animation",
    "Box",
    "Camera",
    "Cone",
    "CudaArray",
    "Cylinder",
    "DenoiseError",
    "Device",
    "DeviceError",
    "DirectionalLight",
    "Disk",
    "Environment",
    "Error",
    "Group",
    "Image",
    "InternalError",
    "Interrupted",
    "Intrinsics",
    "Material",
    "Medium",
    "Mesh",
    "Object",
    "OutputError",
    "Plane",
    "PointLight",
    "Principled",
    "Rectangle",
    "Renderer",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Sphere",
    "SpotLight",
    "Texture",
    "__version__",
    "datasets",
    "devices",
    "load",
    "render",
    "render_many",
    "view",
]
