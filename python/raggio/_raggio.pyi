"""Rust's part of the module."""

from pathlib import Path
from typing import Any, final

import numpy as np
import numpy.typing as npt

from ._progress import Report
from ._types import Developed

__all__ = [
    "AOVS",
    "CudaArray",
    "Film",
    "Metadata",
    "SceneText",
    "Session",
    "TONE_MAPPERS",
    "__version__",
    "check_camera",
    "cuda_devices",
    "devices",
    "encode_png",
    "forget_after_fork",
    "main",
    "metadata",
    "panic_for_tests",
    "to_cuda",
    "tonemap",
    "write_image",
]

__version__: str
AOVS: list[str]
TONE_MAPPERS: list[str]

#: A mesh as arrays: the name of its part, positions, triangles, normals, texture coordinates, colours.
_Mesh = tuple[
    str,
    npt.NDArray[np.float32],
    npt.NDArray[np.uint32],
    npt.NDArray[np.float32] | None,
    npt.NDArray[np.float32] | None,
    npt.NDArray[np.float32] | None,
]

@final
class Metadata:
    @property
    def denoiser(self) -> str | None: ...

@final
class Film:
    @staticmethod
    def load(path: str) -> Film: ...
    @staticmethod
    def from_bytes(bytes: npt.NDArray[np.uint8]) -> Film: ...
    def to_bytes(self) -> npt.NDArray[np.uint8]: ...
    def merge(self, other: Film) -> None: ...
    @property
    def ranges(self) -> list[tuple[int, int]] | None: ...
    @property
    def size(self) -> tuple[int, int]: ...
    def save(self, path: str) -> None: ...
    def develop(self) -> Developed: ...

@final
class SceneText:
    @staticmethod
    def load(
        path: str, *, allow_outside: bool, time_seconds: float | None, camera: str | None
    ) -> tuple[SceneText, list[str]]: ...
    @staticmethod
    def empty() -> SceneText: ...
    def copy(self) -> SceneText: ...
    def files(self) -> list[Path]: ...
    def state(self) -> dict[str, Any]: ...
    @staticmethod
    def restored(
        *,
        text: str,
        path: str | Path,
        allow_outside: bool,
        time_seconds: float | None,
        numbers: tuple[int, int, int, list[int]],
        placed: dict[str, tuple[str, list[float]]],
        meshes: dict[str, _Mesh],
        images: dict[str, npt.NDArray[Any]],
    ) -> SceneText: ...
    @property
    def revision(self) -> int: ...
    @property
    def shapes(self) -> int: ...
    def text(self) -> str: ...
    def check(self, time: float | None = None) -> list[str]: ...
    time: float | None
    def animations(self) -> list[tuple[str, str, float, float]]: ...
    def equals(self, other: SceneText) -> bool: ...
    def get(self, path: list[str]) -> Any: ...
    def set(self, path: list[str], text: str | None, *, checked: bool = False) -> None: ...
    @staticmethod
    def check_shape(shape: str, material: str | None) -> None: ...
    def add_shape(self, text: str, id: int | None = None, *, checked: bool = False) -> int: ...
    @property
    def added(self) -> int: ...
    def take_last(self) -> None: ...
    def give_mesh(
        self,
        label: str,
        positions: npt.NDArray[np.float32],
        triangles: npt.NDArray[np.uint32],
        normals: npt.NDArray[np.float32] | None,
        uvs: npt.NDArray[np.float32] | None,
        colors: npt.NDArray[np.float32] | None,
    ) -> tuple[str, str | None]: ...
    def place_mesh(self, name: str, rows: list[float]) -> str: ...
    def give_radiance(self, image: npt.NDArray[np.float32]) -> str: ...
    def give_bytes(self, image: npt.NDArray[np.uint8]) -> str: ...

@final
class CudaArray:
    @property
    def shape(self) -> tuple[int, int, int]: ...
    @property
    def device(self) -> int: ...
    @property
    def __cuda_array_interface__(self) -> dict[str, Any]: ...
    def __dlpack__(
        self,
        *,
        stream: Any = None,
        max_version: tuple[int, int] | None = None,
        dl_device: tuple[int, int] | None = None,
        copy: bool | None = None,
    ) -> Any: ...
    def __dlpack_device__(self) -> tuple[int, int]: ...

@final
class Session:
    def __new__(
        cls,
        scene: SceneText,
        *,
        name: str,
        camera: str | None,
        time: float | None,
        size: tuple[int, int] | None,
        samples: int | None,
        seed: int | None,
        max_depth: int | None,
        alpha: bool | None,
        noise: float | None,
        time_limit: float | None,
        device: str,
        tracer: str,
        threads: int,
        aovs: list[str],
        denoise: bool,
        label: bool = False,
        integrator: str | None = None,
    ) -> Session: ...
    @property
    def device(self) -> str: ...
    def take_warnings(self) -> list[str]: ...
    def look(
        self,
        scene: SceneText,
        *,
        camera: str | None,
        time: float | None,
        size: tuple[int, int] | None,
        seed: int | None,
        max_depth: int | None,
        alpha: bool | None,
    ) -> None: ...
    def set_target(self, samples: int) -> None: ...
    def sample(self, report: Report | None = None) -> BaseException | None: ...
    def cuda(self) -> CudaArray | None: ...
    def develop(self, report: Report | None = None) -> tuple[Developed, BaseException | None]: ...
    def develop_film(
        self, film: Film, name: str, seconds: float, report: Report | None = None
    ) -> tuple[Developed, BaseException | None]: ...
    def film(self, first: int, end: int, report: Report | None = None) -> tuple[Film, float, BaseException | None]: ...

def check_camera(text: str) -> None: ...
def cuda_devices() -> int: ...
def devices() -> tuple[list[tuple[str, str, str, str, int | None, list[str], bool, str]], str | None]: ...
def encode_png(array: npt.NDArray[np.float32], *, exposure: float, tone_mapper: str) -> bytes: ...
def forget_after_fork() -> None: ...
def main(arguments: list[str]) -> int: ...
def metadata(
    scene: SceneText,
    *,
    name: str,
    camera: str | None,
    size: tuple[int, int] | None,
    samples: int,
    seed: int | None,
    max_depth: int | None,
    alpha: bool | None,
    denoiser: str | None,
) -> Metadata: ...
def panic_for_tests() -> None: ...
def to_cuda(array: npt.NDArray[np.float32], device: int) -> CudaArray: ...
def tonemap(array: npt.NDArray[np.float32], *, exposure: float, tone_mapper: str) -> npt.NDArray[np.uint8]: ...
def write_image(
    path: str,
    array: npt.NDArray[np.float32],
    *,
    floats: list[tuple[str, npt.NDArray[np.float32]]],
    numbers: list[tuple[str, npt.NDArray[np.int32]]],
    metadata: Metadata | None,
    png_bits: str,
    exposure: float,
    tone_mapper: str,
) -> None: ...
