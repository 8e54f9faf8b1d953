"""The live view in notebooks, and the thread that renders for it."""

from __future__ import annotations

import atexit
import math
import threading
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import anywidget
import numpy as np

from . import _raggio
from ._camera import Camera, vector
from ._errors import Error
from ._image import Image, ToneMapper
from ._render import Renderer

#: Seconds that a step of rendering should take, so that the view answers.
STEP = 0.15
#: Seconds that a sample of each pixel may take while the camera moves; pictures are made smaller until it does.
MOVING = 0.05
#: Seconds without a movement after which pictures are whole again.
REST = 0.2
#: Seconds after which a frame that the browser does not acknowledge stops the rendering: nobody looks.
PATIENCE = 5.0
#: Seconds between looks for edits of the scene.
POLL = 0.1
#: Angle in radians of a drag over the view's height.
ORBIT = math.pi
#: Steps of the wheel, in pixels, to a distance that is e times as long.
DOLLY = 800.0


class _Stale(Exception):
    """Ends a step of rendering whose picture is no longer wanted."""


class View(anywidget.AnyWidget):
    """A view of a scene that converges while one looks at it; :func:`view` makes one.

    Dragging turns the camera around its target, the right button (or Shift) shifts both, the wheel goes nearer, and a
    double click goes back to where it began. Edits of the scene are seen. It renders while it is on a page, until
    each pixel has its samples.
    """

    _esm = Path(__file__).with_name("view.js")

    def __init__(self, renderer: Renderer, samples: int, tone_mapper: ToneMapper, exposure: float) -> None:
        super().__init__()
        self._renderer = renderer
        self._size = renderer.size
        self._shown = self._camera = self._home = renderer.camera
        self._target = samples
        self._tone_mapper, self._exposure = tone_mapper, exposure
        # What follows, and the camera, are read and changed by two threads.
        self._changed = threading.Condition()
        self._ended = False
        self._views = 0
        self._moved_at = -math.inf
        # Newest frame, that which the browser has still to acknowledge, and whether the picture is newer than both.
        self._frame = 0
        self._awaited: int | None = None
        self._sent_at = 0.0
        self._newer = True
        # Seconds of a sample of each pixel, were the picture whole, and by how much its sides are divided.
        self._cost = 16 * MOVING
        self._divisor = 1
        # What the renderer belongs to: one step, or a reader of its picture.
        self._busy = threading.Lock()
        self.on_msg(lambda _, message, buffers: self._hear(message))
        self._thread = threading.Thread(target=self._run, name="raggio.view", daemon=True)
        self._thread.start()
        # A thread that renders must not outlive Python.
        atexit.register(self.close)

    @property
    def camera(self) -> Camera:
        """The camera of the view; setting another moves the view there."""
        return self._camera

    @camera.setter
    def camera(self, camera: Camera) -> None:
        with self._changed:
            self._camera = camera
            self._changed.notify_all()

    @property
    def samples(self) -> int:
        """Samples of each pixel at which the view rests; setting more goes on."""
        return self._target

    @samples.setter
    def samples(self, samples: int) -> None:
        with self._changed:
            self._target = samples
            self._changed.notify_all()

    @property
    def image(self) -> Image:
        """The picture as it is now, which is smaller while the camera moves."""
        with self._busy:
            return self._renderer.image

    def close(self) -> None:
        """Ends the view and its rendering."""
        atexit.unregister(self.close)
        with self._changed:
            self._ended = True
            self._changed.notify_all()
        if threading.current_thread() is not self._thread:
            self._thread.join()
        super().close()

    # ---- The browser

    def _hear(self, message: dict[str, Any]) -> None:
        """Takes a message of the browser."""
        with self._changed:
            if "opened" in message:
                self._views += 1
                self._awaited, self._newer = None, True
            elif "closed" in message:
                self._views -= 1
            elif "shown" in message and message["shown"] == self._awaited:
                self._awaited = None
            elif "reset" in message:
                self._camera = self._home
            elif "move" in message:
                for kind, (x, y) in message["move"].items():
                    self._camera = MOVES[kind](self._camera, x, y)
                self._moved_at = time.monotonic()
            self._changed.notify_all()

    def _send_frame(self) -> None:
        with self._busy:
            image = self._renderer.image
        png = _raggio.encode_png(image._contiguous(), exposure=self._exposure, tone_mapper=self._tone_mapper)
        with self._changed:
            self._frame += 1
            self._awaited, self._sent_at, self._newer = self._frame, time.monotonic(), False
        width, height = self._size
        words = {"frame": self._frame, "samples": image.samples, "of": self._target, "width": width, "height": height}
        self.send(words, buffers=[png])

    # ---- The thread

    def _run(self) -> None:
        while self._wait():
            try:
                if self._unfinished():
                    with self._busy:
                        self._render()
                    self._newer = True
                if self._newer and self._awaited is None:
                    self._send_frame()
            except _Stale:
                pass
            except Error as error:
                self._tell(error)

    def _wait(self) -> bool:
        """Waits until something can be done; whether the view is still there then."""
        with self._changed:
            while not self._ended:
                patient = self._awaited is None or time.monotonic() < self._sent_at + PATIENCE
                if self._views > 0 and patient and (self._unfinished() or (self._newer and self._awaited is None)):
                    return True
                self._changed.wait(POLL if self._views > 0 else None)
        return False

    def _unfinished(self) -> bool:
        return self._stale() or self._renderer.samples < self._target

    def _stale(self) -> bool:
        """Whether the renderer's picture is of another camera, size or scene than it should be."""
        edited = self._renderer._seen != self._renderer.scene._text.revision
        return self._ended or edited or self._shown is not self._camera or self._divisor != self._wanted_divisor()

    def _wanted_divisor(self) -> int:
        if time.monotonic() > self._moved_at + REST:
            return 1
        return next((divisor for divisor in (1, 2, 4) if self._cost < MOVING * divisor**2), 8)

    def _render(self) -> None:
        """Takes a step, from the beginning where the picture is stale."""
        renderer = self._renderer
        if self._stale():
            self._shown, self._divisor = self._camera, self._wanted_divisor()
            width, height = (max(1, side // self._divisor) for side in self._size)
            if renderer.size != (width, height):
                renderer.size = (width, height)
            renderer.camera = self._shown
        # Frames come early, and then as often as steps are long.
        fitting = int(STEP * self._divisor**2 / self._cost)
        samples = max(1, min(fitting, renderer.samples, self._target - renderer.samples))
        began = time.monotonic()
        renderer.step(samples, progress=self._check)
        self._cost = max(1e-6, (time.monotonic() - began) * self._divisor**2 / samples)

    def _check(self, part: float, samples: int, seconds: float) -> None:
        if self._stale():
            raise _Stale

    def _tell(self, error: Error) -> None:
        """Shows an error until something is changed."""
        self.send({"error": str(error)})
        camera, revision = self._camera, self._renderer.scene._text.revision
        with self._changed:
            while not self._ended and camera is self._camera and revision == self._renderer.scene._text.revision:
                self._changed.wait(POLL)


def _orbit(camera: Camera, x: float, y: float) -> Camera:
    """Turns the camera around its target and the axis upwards; it stops short of the axis."""
    target, up = np.array(camera.target), np.array(camera.up) / np.linalg.norm(camera.up)
    offset = np.array(camera.position) - target
    distance = np.linalg.norm(offset)
    level = offset - (offset @ up) * up
    level /= np.linalg.norm(level)
    elevation = math.asin(float(np.clip(offset @ up / distance, -1.0, 1.0))) + ORBIT * y
    elevation = max(-1.55, min(elevation, 1.55))
    level = math.cos(ORBIT * x) * level - math.sin(ORBIT * x) * np.cross(up, level)
    offset = distance * (math.cos(elevation) * level + math.sin(elevation) * up)
    return replace(camera, position=vector("position", target + offset))


def _pan(camera: Camera, x: float, y: float) -> Camera:
    """Shifts the camera and its target so that what is at the target's distance follows the mouse."""
    position, target = np.array(camera.position), np.array(camera.target)
    height = camera.orthographic_height
    if height is None:
        height = float(np.linalg.norm(target - position)) * _height_at_1(camera)
    axes = camera.world_from_camera(convention="opengl")[:3, :3]
    shift = height * (y * axes[:, 1] - x * axes[:, 0])
    return replace(camera, position=vector("position", position + shift), target=vector("target", target + shift))


def _height_at_1(camera: Camera) -> float:
    """Height of the picture at the distance 1; that of a panorama, which has none, is of half as many degrees."""
    if camera.calibration is not None:
        return camera.calibration.size[1] / camera.calibration.focal[1]
    return 2.0 * math.tan(0.5 * math.radians(90.0 if camera.vfov_degrees is None else camera.vfov_degrees))


def _dolly(camera: Camera, x: float, y: float) -> Camera:
    """Goes nearer to the target, or farther; parallel rays show less, or more."""
    factor = math.exp(max(-4.0, min(y / DOLLY, 4.0)))
    target = np.array(camera.target)
    position = vector("position", target + factor * (np.array(camera.position) - target))
    height = camera.orthographic_height
    return replace(camera, position=position, orthographic_height=None if height is None else factor * height)


MOVES = {"orbit": _orbit, "pan": _pan, "dolly": _dolly}
