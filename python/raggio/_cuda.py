"""Pictures in the memory of CUDA's devices, where there are any."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from . import _raggio
from ._errors import DeviceError

if TYPE_CHECKING:
    from ._raggio import CudaArray as CudaArray
else:
    #: Memory of a device of CUDA, as DLPack and the CUDA array interface have it.
    CudaArray = getattr(_raggio, "CudaArray", object)


def check_cuda() -> None:
    """Raises :class:`DeviceError`, with the reason, where there is no device of CUDA."""
    if not hasattr(_raggio, "CudaArray"):
        raise DeviceError("CUDA cannot be used: raggio hands memory to it on Linux alone")
    if _raggio.cuda_devices() == 0:
        raise DeviceError("CUDA cannot be used: there is no device")


def to_cuda(pixels: npt.NDArray[np.float32], device: int) -> CudaArray:
    """A copy of a picture in the memory of a device."""
    check_cuda()
    return _raggio.to_cuda(np.ascontiguousarray(pixels), device)
