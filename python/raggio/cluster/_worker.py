"""What runs on the machines of a cluster: one worker on each, and sums of films."""

from __future__ import annotations

import os
import platform
import shutil
import socket
import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import raggio

from .. import _raggio, _render
from .._camera import Camera
from .._errors import Error
from .._scene import Scene
from ._files import Contents, Manifest, moved
from ._program import Frames, run_frames

#: What a worker tells of its work, and the work itself, which stays in its machine's object store until somebody asks for it.
Answer = tuple[dict[str, Any], Any]


@dataclass(frozen=True)
class Order:
    """Render that all workers take part in."""

    manifest: Manifest
    camera: Camera | None = None
    size: tuple[int, int] | None = None
    seed: int | None = None
    max_depth: int | None = None
    alpha: bool | None = None
    device: str = "all"
    tracer: _render.Tracer = "auto"
    threads: int | None = None
    aovs: tuple[str, ...] = ()
    denoise: bool = False
    samples: int | None = None
    integrator: str | None = None
    #: Whether films of ranges of samples are to be made, rather than pictures.
    films: bool = False
    #: Frames of an animation, if they are what is to be made.
    frames: Frames | None = None

    @property
    def options(self) -> _render._Options:
        """Settings in place of the scene's own."""
        return _render._Options(self.size, self.seed, self.max_depth, self.alpha)

    def session(self, scene: Scene, threads: int | None) -> _raggio.Session:
        """Brings the scene to the devices of this machine."""
        # A batch has a camera for each picture, and the scene may have none.
        camera = self.camera or (None if scene.camera else Camera.look_at((0, 0, 1), (0, 0, 0)))
        return _render._session(
            *(scene, camera, self.options, self.device, threads, self.aovs, self.denoise, self.samples, None, None),
            tracer=self.tracer,
            label=self.films,
            integrator=self.integrator,
        )


class Worker:
    """The devices of a machine at work on one scene. Its methods answer with errors in place of raising them."""

    def __init__(self, cores: int | None) -> None:
        self._cores = cores
        self._folder: Path | None = None
        self._order: Order
        self._scene: Scene
        self._session: _raggio.Session

    def hello(self) -> dict[str, Any]:
        """Tells who this is."""
        return {
            "raggio": raggio.__version__,
            "Python": platform.python_version(),
            "host": socket.gethostname(),
            "pid": os.getpid(),
        }

    def open(self, scene: Scene, order: Order, names: list[str], *contents: Contents) -> dict[str, Any]:
        """Reads a scene, and brings it to the devices. Answers with the files that this machine lacks, if it lacks some
        that are not among ``names``, whose contents come along."""
        return _told(lambda: (self._open(scene, order, dict(zip(names, contents))), None))[0]

    def _open(self, scene: Scene, order: Order, contents: dict[str, Contents]) -> dict[str, Any]:
        manifest = order.manifest
        if missing := [path for path in manifest.missing() if path not in contents]:
            return {"missing": missing}
        if contents:
            self._folder = Path(tempfile.mkdtemp(prefix="raggio-"))
            manifest.unpack(self._folder, contents)
            state = scene.__getstate__()
            state["_text"]["text"] = manifest.rewritten(state["_text"]["text"], self._folder)
            scene.__setstate__(state)
        self._scene, self._order = scene, order
        if order.frames is not None:
            return {"device": "the program"}
        with warnings.catch_warnings():
            # The driver has told them.
            warnings.simplefilter("ignore")
            self._session = order.session(scene, order.threads or self._cores)
        return {"device": self._session.device}

    def film(self, first: int, end: int) -> Answer:
        """The film of the samples from ``first`` to before ``end``, as bytes."""

        def work() -> Answer:
            begun = time.monotonic()
            film, seconds, ended = self._session.film(first, end)
            if ended is not None:
                raise ended
            packed = film.to_bytes()
            return {"sampling": seconds, "seconds": time.monotonic() - begun}, packed

        return _told(work)

    def picture(self, camera: Camera) -> Answer:
        """The picture that a camera takes, with its layers."""

        def work() -> Answer:
            begun = time.monotonic()
            _render._look(self._session, self._scene, camera, self._order.options)
            if (ended := self._session.sample()) is not None:
                raise ended
            developed, ended = self._session.develop()
            if ended is not None:
                raise ended
            metadata = developed["metadata"]
            told = {
                "seconds": time.monotonic() - begun,
                "denoiser": metadata.denoiser if metadata else None,
                "device": self._session.device,
            }
            return told, {**developed, "metadata": None}

        return _told(work)

    def frames(self, numbers: list[int]) -> Answer:
        """The files of some frames of an animation, by their names."""
        frames = self._order.frames
        assert frames is not None
        scene = frames.scene
        if self._folder is not None:
            place = moved(self._folder, scene)
            scene = str(place)
            if frames.is_text:
                place.write_text(self._scene._text.text())
        return _told(lambda: run_frames(frames, scene, numbers, frames.threads or self._cores))

    def close(self) -> None:
        """Removes the files that have come along."""
        if self._folder is not None:
            shutil.rmtree(self._folder, ignore_errors=True)


def add_up(*films: npt.NDArray[np.uint8]) -> Answer:
    """The sum of films that are given as bytes."""

    def work() -> Answer:
        first, *others = (_raggio.Film.from_bytes(film) for film in films)
        for film in others:
            first.merge(film)
        return {}, first.to_bytes()

    return _told(work)


def _told(work: Callable[[], Answer]) -> Answer:
    """What the work comes to; its error as the name of a class and a sentence."""
    try:
        return work()
    except Error as error:
        return {"error": (type(error).__name__, str(error))}, None
    except Exception as error:
        return {"error": ("InternalError", f"{type(error).__name__}: {error}")}, None
