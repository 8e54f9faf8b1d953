"""Renders on several machines, seen from the one that keeps the film."""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from typing import Any, overload

from .. import _raggio
from .._camera import Camera
from .._errors import OutputError, SceneError, SceneWarning
from .._image import Image
from .._progress import ProgressLike, Report, reporter
from .._render import AovsLike, Tracer, _in_range, _layers, _Options, _positive, _raise, _table
from .._scene import Scene
from .._types import Developed
from ._connect import connected
from ._crew import Crew
from ._files import Manifest
from ._jobs import Pictures, Range, Samples
from ._worker import Order

#: Where a preview goes: the path of a file, a function of the picture, or ``True``: the output of a notebook's cell.
PreviewLike = bool | str | os.PathLike[str] | Callable[[Image], object] | None

#: Bytes of a film for each pixel, and of the object store of a cluster that is this machine alone, beside some films.
PIXEL, STORE = 72, 256 << 20
#: Seconds from one report of progress to the next.
PAUSE = 0.25


@overload
def render(
    scene: Scene,
    camera: Camera | None = None,
    *,
    address: str | None = None,
    time: float | None = None,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    seed: int | None = None,
    max_depth: int | None = None,
    alpha: bool | None = None,
    device: str = "all",
    tracer: Tracer = "auto",
    threads: int | None = None,
    aovs: AovsLike = (),
    denoise: bool = False,
    time_limit: float | None = None,
    progress: ProgressLike = None,
    preview: PreviewLike = None,
    preview_every: float = 10.0,
    checkpoint: str | os.PathLike[str] | None = None,
    checkpoint_every: float = 60.0,
    resume: bool = False,
    logs: bool = False,
) -> Image: ...


@overload
def render(
    scene: Scene,
    camera: Iterable[Camera],
    *,
    address: str | None = None,
    time: float | None = None,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    seed: int | None = None,
    max_depth: int | None = None,
    alpha: bool | None = None,
    device: str = "all",
    tracer: Tracer = "auto",
    threads: int | None = None,
    aovs: AovsLike = (),
    denoise: bool = False,
    time_limit: None = None,
    progress: ProgressLike = None,
    preview: None = None,
    preview_every: float = 10.0,
    checkpoint: None = None,
    checkpoint_every: float = 60.0,
    resume: bool = False,
    logs: bool = False,
) -> Iterator[tuple[int, Image]]: ...


def render(
    scene: Scene,
    camera: Camera | Iterable[Camera] | None = None,
    *,
    address: str | None = None,
    time: float | None = None,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    seed: int | None = None,
    max_depth: int | None = None,
    alpha: bool | None = None,
    device: str = "all",
    tracer: Tracer = "auto",
    threads: int | None = None,
    aovs: AovsLike = (),
    denoise: bool = False,
    time_limit: float | None = None,
    progress: ProgressLike = None,
    preview: PreviewLike = None,
    preview_every: float = 10.0,
    checkpoint: str | os.PathLike[str] | None = None,
    checkpoint_every: float = 60.0,
    resume: bool = False,
    logs: bool = False,
) -> Image | Iterator[tuple[int, Image]]:
    """Renders on the machines of a Ray cluster (``pip install 'raggio[cluster]'``).

    One picture is spread by its samples, and is bit for bit that of :func:`raggio.render` on one machine. Several
    cameras are spread by pictures: then this is an iterator of the camera's place and the picture, in the order in which
    they are done. Machines may join, leave, be lost or hang meanwhile.

    ``address`` is HOST:PORT of the cluster's head, "auto" for the cluster that this machine is part of, "local" for this
    machine alone, or ``None``: what the process is connected to, else ``RAY_ADDRESS``, else "local". Machines that have
    the scene's files read them, and the others get them; meshes and images in memory travel too. ``device`` and ``tracer``
    are those of each machine. Layers and noise of one picture are seen to on this machine.

    ``preview`` is refreshed every ``preview_every`` seconds: the path of a ``.png`` or ``.exr`` that is written whole, a
    function of the :class:`Image`, or ``True`` for the output of a notebook's cell. The film is kept in ``checkpoint``
    every ``checkpoint_every`` seconds and at the end, and ``resume`` goes on from it, or begins where there is none.
    ``logs`` prints what the workers say. Other parameters are those of :func:`raggio.render`, which are numbers of
    samples from 0 on for each pixel.

    Ctrl-C raises :class:`Interrupted`, whose ``image`` is what there was by then.

    Raises :class:`ClusterError` where there is no cluster or no machine that can render, and the errors of
    :func:`raggio.render`.
    """
    _in_range("samples", samples, 1, 2**31 - 1)
    _in_range("threads", threads, 1, 4096)
    _positive("time_limit", time_limit)
    _positive("preview_every", preview_every)
    _positive("checkpoint_every", checkpoint_every)
    if resume and checkpoint is None:
        raise ValueError("resume goes on from a checkpoint: give checkpoint=")
    scene = scene.copy()
    if time is not None:
        scene.time = time
    for warning in scene._text.check():
        warnings.warn(warning, SceneWarning, stacklevel=2)
    one = camera if camera is None or isinstance(camera, Camera) else None
    options = _Options(size, seed, max_depth, alpha)
    order = Order(
        manifest=Manifest.of(scene._text, scene._folder),
        camera=one,
        size=options.size,
        seed=seed,
        max_depth=max_depth,
        alpha=alpha,
        device=device,
        tracer=tracer,
        threads=threads,
        aovs=tuple(_layers(aovs)),
        denoise=denoise,
        samples=samples,
    )
    if camera is not one:
        assert not isinstance(camera, Camera) and camera is not None
        for name, value in (("time_limit", time_limit), ("preview", preview), ("checkpoint", checkpoint)):
            if value is not None:
                raise ValueError(f"{name} is for one picture: leave it out, or give one camera")
        return _pictures(scene, list(camera), order, address, progress, logs)
    # What is at fault here is told before any machine is asked.
    _table(scene, one)
    wanted = samples or (2**31 - 1 if time_limit is not None else _own_samples(scene))
    film_order = replace(order, aovs=(), denoise=False, films=True, samples=None)
    render = FilmRender(scene, film_order, (0, wanted), address, time_limit, logs)
    shown = _shown(preview)
    path = None if checkpoint is None else os.fspath(checkpoint)
    ended: BaseException | None = None
    with reporter(progress) as report:
        try:
            render.run(path, checkpoint_every, resume, shown, preview_every, report)
        except BaseException as error:
            ended = error
            if render.film is None:
                raise
    image = render.image(shows_all=ended is None, order=order)
    if shown is not None:
        shown(image)
    if ended is not None:
        _raise(ended, image)
    return image


class FilmRender:
    """Render whose film grows here while others take its samples."""

    def __init__(
        self,
        scene: Scene,
        order: Order,
        wanted: Range,
        address: str | None,
        time_limit: float | None = None,
        logs: bool = False,
        warn: Callable[[str], None] | None = None,
    ) -> None:
        self._scene = scene
        self._order = order
        self._wanted = wanted
        self._address = address
        self._time_limit = time_limit
        self._logs = logs
        self._warn = warn or _warn
        self.film: _raggio.Film | None = None
        self.devices: list[str] = []
        self.seconds = 0.0
        self.finished = False
        self._has_warned = False
        #: Path of the film that the render went on from, if there was one.
        self.resumed: str | None = None

    def run(
        self,
        checkpoint: str | None,
        checkpoint_every: float,
        resume: bool,
        preview: Callable[[Image], object] | None,
        preview_every: float,
        report: Report | None,
        stops: Callable[[], bool] = lambda: False,
    ) -> None:
        """Takes all samples, or as many as there are when ``stops`` says so, or when something else ends it."""
        if checkpoint is not None and not os.access(os.path.dirname(checkpoint) or ".", os.W_OK):
            raise OutputError(f"cannot write {checkpoint}: its folder is missing, or cannot be written to")
        if resume and checkpoint is not None and os.path.exists(checkpoint):
            self.film = _film_to_go_on_from(checkpoint, self._wanted)
            self.resumed = checkpoint
        width, height = self._order.options.size_for(self._order.camera) or self._scene.size
        store = STORE + 8 * PIXEL * width * height
        with connected(self._address, logs=self._logs, store_bytes=store) as ray:
            crew = Crew(ray, self._scene, self._order, self._warn)
            name = str(self.resumed)
            job = Samples(ray, crew, self._wanted, self.film, self._time_limit, name)
            now = time.monotonic()
            saved = [job.revision, now + checkpoint_every]
            shown = [job.revision, now + min(preview_every, 2.0)]
            reported = 0.0
            try:
                for _ in crew.run(job):
                    job.absorb()
                    self.film, self.seconds = job.film, job.seconds
                    self.devices = crew.devices or self.devices
                    now = time.monotonic()
                    if report is not None and now > reported + PAUSE:
                        reported = now
                        report(job.fraction(), job.samples, job.seconds)
                    if job.film is not None and checkpoint and now > saved[1] and job.revision > saved[0]:
                        self._keep(job.film, checkpoint)
                        saved = [job.revision, time.monotonic() + checkpoint_every]
                    if job.film is not None and preview and now > shown[1] and job.revision > shown[0]:
                        preview(self.image())
                        shown = [job.revision, time.monotonic() + max(preview_every, 10 * (time.monotonic() - now))]
                    if stops():
                        break
                self.finished = job.samples == job.total
                if report is not None and self.finished:
                    report(1.0, job.samples, job.seconds)
            finally:
                self.film, self.seconds = job.film, job.seconds
                if checkpoint and job.film is not None and job.revision > saved[0]:
                    job.film.save(checkpoint)
                crew.close()

    def _keep(self, film: _raggio.Film, checkpoint: str) -> None:
        """Writes a checkpoint; if that fails the render goes on, and the last one stays."""
        try:
            film.save(checkpoint)
        except OutputError as error:
            if not self._has_warned:
                self._warn(f"{error}; the render goes on without checkpoints until there is room again")
            self._has_warned = True

    def image(self, *, shows_all: bool = False, order: Order | None = None) -> Image:
        """The picture of the film; with the layers and without the noise that ``order`` asks for, where it ``shows_all``."""
        assert self.film is not None
        names = list(dict.fromkeys(self.devices))
        device = f"{len(self.devices)} machines: {', '.join(names)}" if len(self.devices) > 1 else "".join(names)
        developed: Developed
        # A film that was whole from the beginning has been compared with nothing yet.
        is_unknown = self.resumed is not None and not self.devices
        if shows_all and order is not None and (order.aovs or order.denoise or is_unknown):
            at_hand = replace(order, device="auto", tracer="auto", samples=self._wanted[1])
            session = at_hand.session(self._scene, order.threads)
            developed, ended = session.develop_film(self.film, self.resumed or "the cluster's film", self.seconds)
            image = Image(developed, device or session.device)
            if ended is not None:
                _raise(ended, image)
            return image
        developed = self.film.develop()
        developed["seconds"], developed["finished"] = self.seconds, self.finished
        return Image(developed, device)


def _pictures(
    scene: Scene, cameras: list[Camera], order: Order, address: str | None, progress: ProgressLike, logs: bool
) -> Iterator[tuple[int, Image]]:
    """Pictures of many cameras, as they are done."""
    begun = time.monotonic()
    with connected(address, logs=logs, store_bytes=STORE) as ray, reporter(progress) as report:
        crew = Crew(ray, scene, order, _warn)
        job = Pictures(crew, "picture", cameras, bundled=False)
        try:
            for _ in until_empty(crew, job):
                for (place,), told, made in job.take_made():
                    if report is not None:
                        report(1 - job.left / len(cameras), made["samples"][0], time.monotonic() - begun)
                    camera = cameras[place]
                    made["metadata"] = _raggio.metadata(
                        scene._text,
                        name=scene._name,
                        camera=_table(scene, camera),
                        size=order.options.size_for(camera),
                        samples=made["samples"][1],
                        seed=order.seed,
                        max_depth=order.max_depth,
                        alpha=order.alpha,
                        denoiser=told["denoiser"],
                    )
                    yield place, Image(_owned(made), told["device"])
        finally:
            crew.close()


def until_empty(crew: Crew, job: Pictures[Any]) -> Iterator[None]:
    """The run of a crew, and once more for what has come last."""
    yield from crew.run(job)
    yield


def _owned(made: dict[str, Any]) -> Developed:
    """A picture in memory of its own: what comes out of the object store holds on to it, and cannot be written to."""
    channels = {name: values.copy() for name, values in made["channels"].items()}
    owned: Developed = {**made, "pixels": made["pixels"].copy(), "channels": channels}  # type: ignore[typeddict-item]
    return owned


def _own_samples(scene: Scene) -> int:
    return int((scene._text.get(["render"]) or {}).get("samples", 256))


def _film_to_go_on_from(path: str, wanted: Range) -> _raggio.Film:
    film = _raggio.Film.load(path)
    ranges = film.ranges
    if ranges is None:
        raise SceneError(
            f"cannot go on from {path}: its last samples are in a part of its rows alone, as one machine leaves them; "
            "`raggio render --resume` on one machine goes on"
        )
    if ranges and not wanted[0] <= ranges[0][0] <= ranges[-1][1] <= wanted[1]:
        raise SceneError(
            f"cannot go on from {path}: it has samples {ranges[0][0]}..{ranges[-1][1]}, and {wanted[0]}..{wanted[1]} are "
            "to be rendered"
        )
    return film


def _warn(sentence: str) -> None:
    warnings.warn(sentence, SceneWarning, stacklevel=2)


def _shown(preview: PreviewLike) -> Callable[[Image], object] | None:
    """Function that shows a picture."""
    if preview is None or preview is False:
        return None
    if preview is True:
        return _in_notebook()
    if callable(preview):
        return preview
    return lambda image: image.save(preview)


def _in_notebook() -> Callable[[Image], object]:
    """Function that shows a picture in the place of the one before."""
    if "IPython" not in sys.modules:
        raise ValueError("preview=True is for notebooks: give the path of a file, or a function of the picture")
    from IPython.display import display  # type: ignore[import-not-found,unused-ignore]

    handle: Any = None

    def show(image: Image) -> None:
        nonlocal handle
        if handle is None:
            handle = display(image, display_id=True)  # type: ignore[no-untyped-call,unused-ignore]
        else:
            handle.update(image)

    return show
