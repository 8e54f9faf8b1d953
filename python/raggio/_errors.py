"""Exceptions, whose sentences are those of the program."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._image import Image


class Error(Exception):
    """Any failure of raggio.

    Where a render had begun, ``image`` is the picture of what there was by then; otherwise it is ``None``.
    """

    image: Image | None = None


class SceneError(Error, ValueError):
    """A scene, a model or an image that cannot be read or rendered; the sentence names file and line."""


class DeviceError(Error, RuntimeError):
    """A device that is not there, or has failed."""


class OutputError(Error, OSError):
    """A file that cannot be written."""


class DenoiseError(Error, RuntimeError):
    """A denoiser that is not there, or has failed."""


class InternalError(Error, RuntimeError):
    """A fault of raggio's own, which should be reported."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a render.

    ``image`` is the picture of what there was by then; it is a complete picture with fewer samples.
    """

    image: Image

    def __init__(self, image: Image) -> None:
        super().__init__("interrupted; the exception's `image` is what had been rendered")
        self.image = image


class SceneWarning(UserWarning):
    """Something that is allowed but probably not meant, in the program's words."""
