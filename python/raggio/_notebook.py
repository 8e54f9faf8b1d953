"""The live view in notebooks, which needs anywidget."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ._camera import Camera
from ._image import ToneMapper
from ._render import Renderer, Tracer
from ._scene import Scene

if TYPE_CHECKING:
    from ._view import View


def view(
    scene: Scene,
    camera: Camera | None = None,
    *,
    size: tuple[int, int] | None = None,
    samples: int = 1024,
    seed: int | None = None,
    max_depth: int | None = None,
    device: str = "auto",
    tracer: Tracer = "auto",
    threads: int | None = None,
    tone_mapper: ToneMapper = "neutral",
    exposure: float = 0.0,
) -> View:
    """A live view of a scene in a notebook (``pip install 'raggio[notebook]'``), as the last value of a cell.

    It converges while one looks at it, until each pixel has its samples. Dragging turns the camera around its target,
    the right button (or Shift) shifts both, the wheel goes nearer, a double click goes back. ``view.camera`` is the
    camera that it has come to. Other parameters are those of :func:`render` and of :meth:`Image.tonemap`.
    """
    try:
        from ._view import View
    except ImportError as error:
        raise ImportError("views in notebooks need anywidget: pip install 'raggio[notebook]'") from error
    if samples < 1:
        raise ValueError(f"samples is {samples}: give at least 1")
    renderer = Renderer(
        scene, camera, size=size, seed=seed, max_depth=max_depth, device=device, tracer=tracer, threads=threads
    )
    return View(renderer, samples, tone_mapper, exposure)
