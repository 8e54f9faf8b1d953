"""Pictures."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, Literal, cast

import numpy as np
import numpy.typing as npt

from . import _raggio
from ._cuda import CudaArray, to_cuda
from ._types import Developed

Floats = npt.NDArray[np.float32]
Layer = npt.NDArray[np.float32] | npt.NDArray[np.int32]
#: Kind of CUDA's devices, as DLPack has it.
_CUDA = 2
ToneMapper = Literal["neutral", "agx", "aces", "filmic", "reinhard", "none"]


def _stacked(parts: list[Layer]) -> Layer:
    """Channels of a layer as the last axis of one array."""
    return cast(Layer, np.stack(parts, axis=-1))


class Image:
    """A picture of linear radiance, with the layers (AOVs) that were asked for.

    ``np.asarray(image)`` is float32 (height, width, 3), linear Rec. 709, row 0 on top, without a copy. Rendered with
    ``alpha=True`` it is (height, width, 4) with premultiplied alpha: over a background of linear radiance the picture
    is ``pixels[..., :3] + (1 - pixels[..., 3:]) * background``. ``numpy.from_dlpack`` and other consumers of DLPack
    share the memory too; :meth:`cuda` has it in the memory of CUDA's devices. ``image["depth"]`` is a layer: float32
    (height, width) or (height, width, 3), or int32 (height, width) for numbers, where 0 is nothing.
    """

    __slots__ = ("_channels", "_cuda", "_layers", "_metadata", "_pixels", "_facts")

    def __init__(self, developed: Developed, device: str, cuda: CudaArray | None = None) -> None:
        self._cuda = cuda
        self._pixels: Floats = developed["pixels"]
        self._metadata = developed["metadata"]
        self._facts = (developed["samples"], developed["seconds"], developed["finished"], developed["rays"], device)
        self._channels: dict[str, list[str]] = {}
        self._layers: dict[str, Layer] = {}
        for name in developed["channels"]:
            self._channels.setdefault(name.split(".")[0], []).append(name)
        for layer, names in self._channels.items():
            parts = [developed["channels"][name] for name in names]
            self._layers[layer] = parts[0] if len(parts) == 1 else _stacked(parts)

    @property
    def width(self) -> int:
        """Width in pixels."""
        return int(self._pixels.shape[1])

    @property
    def height(self) -> int:
        """Height in pixels."""
        return int(self._pixels.shape[0])

    @property
    def shape(self) -> tuple[int, int, int]:
        """(height, width, 3), or with alpha (height, width, 4)."""
        return (self.height, self.width, int(self._pixels.shape[2]))

    @property
    def dtype(self) -> np.dtype[np.float32]:
        """float32."""
        return self._pixels.dtype

    @property
    def pixels(self) -> Floats:
        """The picture itself: float32 (height, width, 3), linear Rec. 709, row 0 on top.

        With alpha it is (height, width, 4), and premultiplied.
        """
        return self._pixels

    @property
    def alpha(self) -> Floats | None:
        """Part of each pixel that is covered, 0 to 1: float32 (height, width); ``None`` with the background."""
        return self._pixels[..., 3] if self._pixels.shape[2] == 4 else None

    @property
    def layers(self) -> Mapping[str, Layer]:
        """The layers by their names."""
        return dict(self._layers)

    @property
    def samples(self) -> int:
        """Samples of the pixel that has the fewest."""
        return self._facts[0][0]

    @property
    def seconds(self) -> float:
        """Time that was spent on taking samples, in seconds."""
        return self._facts[1]

    @property
    def finished(self) -> bool:
        """Whether every pixel has all samples that were asked for."""
        return self._facts[2]

    @property
    def rays(self) -> int:
        """Rays that were traced, shadow rays included."""
        return self._facts[3]

    @property
    def device(self) -> str:
        """Name of the device that rendered the picture."""
        return self._facts[4]

    def __getitem__(self, layer: str) -> Layer:
        """A layer by its name.

        Raises :class:`KeyError` where it was not asked for: ``render(..., aovs=("depth",))``.
        """
        try:
            return self._layers[layer]
        except KeyError:
            has = ", ".join(self._layers) or "none"
            raise KeyError(f"{layer!r} is not among this image's layers ({has}): ask for it with aovs=") from None

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """The picture as an array; without a copy unless ``dtype`` or ``copy`` ask for one."""
        if dtype is None or np.dtype(dtype) == self._pixels.dtype:
            return self._pixels.copy() if copy else self._pixels
        if copy is False:
            raise ValueError(f"the picture is float32: as {np.dtype(dtype)} it takes a copy")
        return self._pixels.astype(dtype)

    @property
    def __array_interface__(self) -> dict[str, Any]:
        """The array's place in memory, as NumPy's array interface has it."""
        return self._pixels.__array_interface__

    def __dlpack__(self, **options: Any) -> Any:
        """The picture as a DLPack capsule: in the memory of the CPU, or that of ``dl_device=(2, n)``, a device of CUDA."""
        device = options.get("dl_device")
        if device is not None and int(device[0]) == _CUDA:
            if options.get("copy") is False and self._cuda is None:
                raise BufferError("the picture is in the memory of the CPU: on a device of CUDA it takes a copy")
            return self.cuda(int(device[1])).__dlpack__(stream=options.get("stream"))
        return self._pixels.__dlpack__(**options)

    def __dlpack_device__(self) -> tuple[int, int]:
        """The CPU, as DLPack calls it."""
        kind, number = self._pixels.__dlpack_device__()
        return (int(kind), int(number))

    def cuda(self, device: int | None = None) -> CudaArray:
        """The picture in the memory of a device of CUDA: float32, of this image's shape.

        ``torch.as_tensor(image.cuda(), device="cuda")``, ``cupy.asarray(image.cuda())`` and ``torch.from_dlpack(image.cuda())``
        share that memory. It is there already where the picture was rendered with ``cuda=True``, unless ``device``, CUDA's
        number, is another; otherwise it is copied there, to device 0 if none is given.

        Raises :class:`DeviceError` where there is no such device.
        """
        if self._cuda is not None and device in (None, self._cuda.device):
            return self._cuda
        return to_cuda(self._pixels, device or 0)

    def tonemap(self, *, tone_mapper: ToneMapper = "neutral", exposure: float = 0.0) -> npt.NDArray[np.uint8]:
        """The picture as a display shows it: sRGB bytes (height, width, 3).

        With alpha it is (height, width, 4), not premultiplied, and no curve bends the alpha. ``exposure`` is in stops,
        each of which doubles the brightness.
        """
        return _raggio.tonemap(self._contiguous(), exposure=exposure, tone_mapper=tone_mapper)

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        tone_mapper: ToneMapper = "neutral",
        exposure: float = 0.0,
        png_bits: Literal[8, 16] = 8,
    ) -> None:
        """Writes the picture, whole or not at all.

        ``.exr`` holds linear radiance in 32-bit floats, the layers, and how the picture was made; ``.png`` what a
        display shows. With alpha, colours of ``.exr`` are premultiplied and those of ``.png`` are not, as the formats
        demand. Raises :class:`OutputError` where the file cannot be written or its ending is another.
        """
        floats: list[tuple[str, Floats]] = []
        numbers: list[tuple[str, npt.NDArray[np.int32]]] = []
        for layer, names in self._channels.items():
            whole = self._layers[layer]
            for place, name in enumerate(names):
                part = whole if whole.ndim == 2 else whole[..., place]
                if part.dtype == np.int32:
                    numbers.append((name, np.ascontiguousarray(part, dtype=np.int32)))
                else:
                    floats.append((name, np.ascontiguousarray(part, dtype=np.float32)))
        _raggio.write_image(
            os.fspath(path),
            self._contiguous(),
            floats=floats,
            numbers=numbers,
            metadata=self._metadata,
            png_bits=str(png_bits),
            exposure=exposure,
            tone_mapper=tone_mapper,
        )

    def _contiguous(self) -> Floats:
        return np.ascontiguousarray(self._pixels)

    def _repr_png_(self) -> bytes:
        return _raggio.encode_png(self._contiguous(), exposure=0.0, tone_mapper="neutral")

    def __repr__(self) -> str:
        layers = "".join(f", {name}" for name in self._layers)
        return f"<raggio.Image {self.width}x{self.height}, {self.samples} samples{layers}>"
