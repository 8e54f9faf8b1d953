"""Types of what goes between Python and Rust."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypedDict

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from ._raggio import Metadata

Vector = tuple[float, float, float]


class Developed(TypedDict):
    """A picture that was just rendered."""

    #: float32 (height, width, 3), or with alpha (height, width, 4).
    pixels: npt.NDArray[np.float32]
    #: Channels of layers by their names, such as "normal.X", (height, width) each.
    channels: dict[str, npt.NDArray[np.float32] | npt.NDArray[np.int32]]
    metadata: Metadata | None
    #: Fewest and most samples of a pixel.
    samples: tuple[int, int]
    rays: int
    seconds: float
    finished: bool
