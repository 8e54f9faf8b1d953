"""Renders."""

from __future__ import annotations

import importlib.util
import os
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal, NoReturn

from . import _raggio, _toml
from ._camera import Camera, checked_size
from ._cuda import CudaArray, check_cuda, to_cuda
from ._errors import Interrupted, SceneWarning
from ._image import Image
from ._progress import ProgressLike, Report, reporter
from ._scene import Scene, checked_time

#: Names of layers: one, several, or "all".
AovsLike = str | Iterable[str]
#: Who finds what rays meet on a GPU.
Tracer = Literal["auto", "software", "hardware"]


@dataclass(frozen=True)
class Device:
    """A device of this machine."""

    #: What ``device=`` calls it: "cpu", "vulkan:0".
    id: str
    #: Name of the processor.
    name: str
    #: Kind of the device, in a word.
    kind: str
    #: Driver; of the CPU, its cores and their instruction set.
    driver: str
    #: Memory in bytes, where it is known.
    memory_bytes: int | None
    #: What the device lacks to render; nothing when it can.
    missing: tuple[str, ...]
    #: Whether it can trace rays by hardware, or says so (VK_KHR_ray_query).
    has_ray_queries: bool
    #: Who finds what rays meet with ``tracer="auto"``: "software" or "hardware".
    tracer: str


def devices() -> list[Device]:
    """The devices of this machine, the CPU first."""
    found, _ = _raggio.devices()
    return [Device(*line[:5], tuple(line[5]), *line[6:]) for line in found]


def render(
    scene: Scene,
    camera: Camera | None = None,
    *,
    time: float | None = None,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    seed: int | None = None,
    max_depth: int | None = None,
    alpha: bool | None = None,
    device: str = "auto",
    tracer: Tracer = "auto",
    threads: int | None = None,
    aovs: AovsLike = (),
    denoise: bool = False,
    time_limit: float | None = None,
    noise: float | None = None,
    cuda: bool = False,
    progress: ProgressLike = None,
) -> Image:
    """Renders a picture.

    ``camera`` and what is ``None`` are the scene's own. ``time`` is the moment, in seconds, of animations and of the
    camera's keyframes: that of frame F is ``(F - 1) / fps``. ``size`` is (width, height) in pixels. Sampling ends after
    ``samples`` a pixel, ``time_limit`` seconds, or where the relative error is below ``noise``, whichever comes first.
    ``max_depth`` is the most rays along a path; 0 sets no limit. ``alpha`` leaves out the background where it is seen
    directly, and makes the image (height, width, 4) with premultiplied alpha. ``device`` is "auto" (a GPU if there is
    one), "cpu", "vulkan" or "vulkan:N"; several separated by commas share the picture, as does "all", every GPU with
    the CPU; ``threads`` are those of the CPU. ``tracer`` says who finds what rays meet on a GPU: "hardware" that traces rays,
    "software", or "auto", hardware where there is some. ``aovs`` are layers: :data:`AOVS` has their names, "all" stands for all.
    ``denoise`` removes noise by Intel Open Image Denoise (``pip install pyoidn``).

    ``cuda`` has the picture in CUDA's memory, too, for :meth:`Image.cuda`: on a GPU that Vulkan and CUDA have in common it never
    leaves that, unless it is denoised or has alpha.

    ``progress`` is a function of the part that is done, the samples and the seconds; ``True``: a bar by tqdm;
    ``None``: a bar on terminals and in notebooks, where tqdm is installed; ``False``: nothing.

    The same scene, seed and samples give the same picture: on one device bit for bit. The lock of Python is released
    meanwhile. Ctrl-C raises :class:`Interrupted`, a ``KeyboardInterrupt`` whose ``image`` is what there was by then; so
    does any exception of a signal handler or of ``progress`` carry it.

    Raises :class:`SceneError`, :class:`DeviceError` or :class:`DenoiseError`.
    """
    options = _Options(size, seed, max_depth, alpha, time)
    if cuda:
        check_cuda()
    session = _session(
        *(scene, camera, options, device, threads, aovs, denoise, samples, time_limit, noise), tracer=tracer
    )
    with reporter(progress) as report:
        return _run(session, report, cuda)


def render_many(
    scene: Scene,
    cameras: Iterable[Camera],
    *,
    time: float | None = None,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    seed: int | None = None,
    max_depth: int | None = None,
    alpha: bool | None = None,
    device: str = "auto",
    tracer: Tracer = "auto",
    threads: int | None = None,
    aovs: AovsLike = (),
    denoise: bool = False,
    time_limit: float | None = None,
    noise: float | None = None,
    cuda: bool = False,
) -> Iterator[tuple[int, Image]]:
    """Renders a scene from many cameras, one after another: yields the camera's place and the picture.

    The scene stays on the device; edits of it between two pictures are seen. Parameters are those of :func:`render`,
    the time limit being that of each picture.
    """
    options = _Options(size, seed, max_depth, alpha, time)
    if cuda:
        check_cuda()
    session: _raggio.Session | None = None
    for place, camera in enumerate(cameras):
        if session is None:
            session = _session(
                *(scene, camera, options, device, threads, aovs, denoise, samples, time_limit, noise), tracer=tracer
            )
        else:
            _look(session, scene, camera, options)
        yield place, _run(session, None, cuda)


class Renderer:
    """A scene that stays on its device, and a picture that grows better step by step.

    Another ``camera``, and edits of the scene (its materials, light, objects), begin the picture anew and bring no
    more to the device than has changed. Parameters are those of :func:`render`.

    A renderer may be used from several threads, one at a time; not in a process that was forked after it was made.
    """

    def __init__(
        self,
        scene: Scene,
        camera: Camera | None = None,
        *,
        time: float | None = None,
        size: tuple[int, int] | None = None,
        seed: int | None = None,
        max_depth: int | None = None,
        alpha: bool | None = None,
        device: str = "auto",
        tracer: Tracer = "auto",
        threads: int | None = None,
        aovs: AovsLike = (),
        denoise: bool = False,
    ) -> None:
        self._scene = scene
        self._camera = camera
        self._options = _Options(size, seed, max_depth, alpha, time)
        self._session = _session(
            *(scene, camera, self._options, device, threads, aovs, denoise, 1, None, None), tracer=tracer
        )
        self._seen = scene._text.revision
        self._samples = 0

    @property
    def scene(self) -> Scene:
        """The scene; its edits are seen at the next step."""
        return self._scene

    @property
    def camera(self) -> Camera:
        """The camera; setting another begins the picture anew."""
        camera = self._camera if self._camera is not None else self._scene.camera
        assert camera is not None
        return camera

    @camera.setter
    def camera(self, camera: Camera) -> None:
        self._camera = camera
        self._begin()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture in pixels; setting another begins it anew."""
        return self._options.size_for(self._camera) or self._scene.size

    @size.setter
    def size(self, size: tuple[int, int]) -> None:
        self._options = replace(self._options, size=size)
        self._begin()

    @property
    def time(self) -> float | None:
        """Moment in seconds; ``None``: the scene's own. Setting another begins the picture anew."""
        return self._options.time

    @time.setter
    def time(self, time: float | None) -> None:
        self._options = replace(self._options, time=time)
        self._begin()

    @property
    def device(self) -> str:
        """Name of the device."""
        return self._session.device

    @property
    def samples(self) -> int:
        """Samples of each pixel that were asked for since the picture began."""
        return self._samples

    def step(self, samples: int = 1, *, progress: ProgressLike = False) -> None:
        """Adds samples to each pixel.

        Ctrl-C raises :class:`Interrupted`, whose ``image`` is what there is; the next step goes on from there.
        """
        if samples < 1:
            raise ValueError(f"samples is {samples}: give at least 1")
        if self._scene._text.revision != self._seen:
            self._begin()
        self._samples += samples
        self._session.set_target(self._samples)
        with reporter(progress) as report:
            ended = self._session.sample(report)
        _warn(self._session)
        if ended is not None:
            _raise(ended, _developed(self._session, None)[0])

    @property
    def image(self) -> Image:
        """The picture as it is now; before the first step, of one sample."""
        if self._samples == 0 or self._scene._text.revision != self._seen:
            self.step(1)
        image, ended = _developed(self._session, None)
        _warn(self._session)
        if ended is not None:
            _raise(ended, image)
        return image

    def cuda(self) -> CudaArray:
        """The picture as it is now in the memory of a device of CUDA, float32 (height, width, 3), as :meth:`Image.cuda` has it.

        On a GPU that Vulkan and CUDA have in common nothing goes through the CPU, unless the picture is denoised or has alpha.
        """
        check_cuda()
        if self._samples == 0 or self._scene._text.revision != self._seen:
            self.step(1)
        return self._session.cuda() or self.image.cuda()

    def _begin(self) -> None:
        self._seen = self._scene._text.revision
        self._samples = 0
        _look(self._session, self._scene, self._camera, self._options)

    def __repr__(self) -> str:
        width, height = self.size
        return f"<raggio.Renderer {width}x{height}, {self._samples} samples, on {self.device}>"


@dataclass(frozen=True)
class _Options:
    """Settings in place of the scene's own."""

    size: tuple[int, int] | None
    seed: int | None
    max_depth: int | None
    alpha: bool | None
    time: float | None = None

    def __post_init__(self) -> None:
        if self.size is not None:
            object.__setattr__(self, "size", checked_size(self.size))
        _in_range("seed", self.seed, 0, 2**32 - 1)
        _in_range("max_depth", self.max_depth, 0, 65535)
        object.__setattr__(self, "time", checked_time(self.time))

    def size_for(self, camera: Camera | None) -> tuple[int, int] | None:
        return self.size if self.size is not None or camera is None else camera.size


def _in_range(name: str, number: int | None, least: int, most: int) -> None:
    if number is not None and not least <= number <= most:
        raise ValueError(f"{name} is {number}: give a number from {least} to {most}")


def _positive(name: str, number: float | None) -> None:
    if number is not None and not 0 < number < float("inf"):
        raise ValueError(f"{name} is {number}: give a number greater than 0")


def _table(scene: Scene, camera: Camera | None) -> str | None:
    if camera is None and scene.camera is None:
        raise ValueError("the scene has no camera: give one, such as raggio.Camera.look_at(position, target)")
    return None if camera is None else _toml.value(camera._table())


def _session(
    scene: Scene,
    camera: Camera | None,
    options: _Options,
    device: str,
    threads: int | None,
    aovs: AovsLike,
    denoise: bool,
    samples: int | None,
    time_limit: float | None,
    noise: float | None,
    *,
    tracer: Tracer = "auto",
    label: bool = False,
    integrator: str | None = None,
) -> _raggio.Session:
    _in_range("samples", samples, 1, 2**31 - 1)
    _in_range("threads", threads, 1, 4096)
    _positive("time_limit", time_limit)
    _positive("noise", noise)
    layers = _layers(aovs)
    if denoise:
        _find_denoiser()
    for warning in scene._text.check(options.time):
        warnings.warn(warning, SceneWarning, stacklevel=3)
    session = _raggio.Session(
        scene._text,
        name=scene._name,
        camera=_table(scene, camera),
        time=options.time,
        size=options.size_for(camera),
        samples=samples,
        seed=options.seed,
        max_depth=options.max_depth,
        alpha=options.alpha,
        noise=noise,
        time_limit=time_limit,
        device=device,
        tracer=tracer,
        threads=threads or 0,
        aovs=layers,
        denoise=denoise,
        label=label,
        integrator=integrator,
    )
    _warn(session)
    return session


def _layers(aovs: AovsLike) -> list[str]:
    """Names of the layers that are asked for, each once."""
    names = [aovs] if isinstance(aovs, str) else list(aovs)
    layers = list(_raggio.AOVS) if names == ["all"] else list(dict.fromkeys(names))
    if unknown := [name for name in layers if name not in _raggio.AOVS]:
        raise ValueError(f'there is no layer {unknown[0]!r}: give some of {", ".join(_raggio.AOVS)}, or "all"')
    return layers


def _find_denoiser() -> None:
    """Tells raggio of the libraries in the wheel pyoidn, unless the user has others."""
    if "OIDN_DIR" not in os.environ:
        found = importlib.util.find_spec("pyoidn")
        if found is not None and found.submodule_search_locations:
            os.environ["OIDN_DIR"] = os.path.join(next(iter(found.submodule_search_locations)), "oidn")


def _look(session: _raggio.Session, scene: Scene, camera: Camera | None, options: _Options) -> None:
    session.look(
        scene._text,
        camera=_table(scene, camera),
        time=options.time,
        size=options.size_for(camera),
        seed=options.seed,
        max_depth=options.max_depth,
        alpha=options.alpha,
    )


def _run(session: _raggio.Session, report: Report | None, cuda: bool) -> Image:
    ended = session.sample(report)
    # What is over is not to be stopped again.
    image, later = _developed(session, report if ended is None else None, cuda and ended is None)
    _warn(session)
    ended = ended if ended is not None else later
    if ended is not None:
        _raise(ended, image)
    return image


def _developed(
    session: _raggio.Session, report: Report | None, cuda: bool = False
) -> tuple[Image, BaseException | None]:
    developed, ended = session.develop(report)
    array = None
    if cuda and ended is None:
        array = session.cuda() or to_cuda(developed["pixels"], 0)
    return Image(developed, session.device, array), ended


def _warn(session: _raggio.Session) -> None:
    for warning in session.take_warnings():
        warnings.warn(warning, SceneWarning, stacklevel=4)


def _raise(ended: BaseException, image: Image) -> NoReturn:
    if type(ended) is KeyboardInterrupt:
        raise Interrupted(image) from None
    _attach(ended, image)
    raise ended


def _attach(ended: Any, image: Image) -> None:
    try:
        ended.image = image
    except AttributeError:
        pass
