"""Cameras."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _raggio, _toml
from ._types import CameraNumbers, Vector

VectorLike = Sequence[float] | npt.NDArray[Any]
Convention = Literal["opencv", "opengl"]

#: Signs of the camera's axes x, y and z in raggio's: x to the right, y up, z backwards.
_SIGNS: dict[str, tuple[float, float, float]] = {"opengl": (1.0, 1.0, 1.0), "opencv": (1.0, -1.0, -1.0)}


def vector(name: str, of: VectorLike) -> Vector:
    """Three finite numbers."""
    array = np.asarray(of, dtype=np.float64)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ValueError(f"{name} is {of!r}: give three finite numbers")
    x, y, z = array.tolist()
    return (x, y, z)


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A pinhole, a thin lens (``aperture_radius`` above 0), or parallel rays (``orthographic_height``).

    :meth:`look_at` and :meth:`from_matrix` make one. Lengths are in the scene's units. A camera never changes;
    :func:`dataclasses.replace` makes another of it.
    """

    #: Position of the pinhole, or of the lens's centre.
    position: Vector
    #: Point in the middle of the picture.
    target: Vector
    #: Direction upwards, of any length and not parallel to the viewing direction.
    up: Vector = (0.0, 1.0, 0.0)
    #: Angle in degrees between the picture's top and bottom edges.
    vfov_degrees: float = 40.0
    #: Height of the picture in the scene's units, for parallel rays; the angle counts for nothing then.
    orthographic_height: float | None = None
    #: Radius of the lens; 0 is a pinhole.
    aperture_radius: float = 0.0
    #: Distance of the plane in focus along the viewing direction; ``None``: that of ``target``.
    focus_distance: float | None = None
    #: Width and height of the picture in pixels; ``None``: as the scene or the call says.
    size: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        for name in ("position", "target", "up"):
            object.__setattr__(self, name, vector(name, getattr(self, name)))
        if self.size is not None:
            object.__setattr__(self, "size", checked_size(self.size))
        _raggio.check_camera(_toml.value(self._table()))

    @classmethod
    def look_at(
        cls,
        position: VectorLike,
        target: VectorLike,
        *,
        up: VectorLike = (0.0, 1.0, 0.0),
        vfov_degrees: float = 40.0,
        orthographic_height: float | None = None,
        aperture_radius: float = 0.0,
        focus_distance: float | None = None,
        size: tuple[int, int] | None = None,
    ) -> Camera:
        """A camera at ``position`` with ``target`` in the middle of its picture.

        Raises :class:`ValueError` where the two are one point, or ``up`` is parallel to the viewing direction.
        """
        return cls(
            position=vector("position", position),
            target=vector("target", target),
            up=vector("up", up),
            vfov_degrees=vfov_degrees,
            orthographic_height=orthographic_height,
            aperture_radius=aperture_radius,
            focus_distance=focus_distance,
            size=size,
        )

    @classmethod
    def from_matrix(
        cls,
        world_from_camera: npt.ArrayLike,
        *,
        convention: Convention,
        K: npt.ArrayLike | None = None,
        vfov_degrees: float | None = None,
        orthographic_height: float | None = None,
        aperture_radius: float = 0.0,
        focus_distance: float | None = None,
        size: tuple[int, int] | None = None,
    ) -> Camera:
        """A camera of a pose (4, 4) or (3, 4) and of intrinsics (3, 3).

        ``convention`` says where the camera's axes point: ``"opencv"`` x right, y down, z forward (COLMAP too);
        ``"opengl"`` x right, y up, z backward (Blender, nerfstudio and glTF too).

        ``K`` is in pixels and needs ``size``, which is (width, height). Its principal point counts from the outer
        corner of the top left pixel, so that the middle of the picture is (width / 2, height / 2), as COLMAP and
        nerfstudio have it; where whole numbers are the middles of pixels, add 0.5 to both. Without ``K`` give
        ``vfov_degrees`` or ``orthographic_height``.

        Raises :class:`ValueError` where the matrix is no rotation with a translation, and where ``K`` is of a camera
        that raggio has not yet: one with a principal point off the middle, with skew, or with pixels that are not
        square.
        """
        if convention not in _SIGNS:
            raise ValueError(f'convention is {convention!r}: give "opencv" or "opengl"')
        matrix = np.asarray(world_from_camera, dtype=np.float64)
        if matrix.shape not in ((4, 4), (3, 4)) or not np.isfinite(matrix).all():
            raise ValueError(f"world_from_camera is of shape {matrix.shape}: give (4, 4) or (3, 4) finite numbers")
        if matrix.shape == (4, 4) and not np.allclose(matrix[3], (0, 0, 0, 1)):
            raise ValueError(f"the last row of world_from_camera is {matrix[3].tolist()}: it should be [0, 0, 0, 1]")
        rotation, position = matrix[:3, :3], matrix[:3, 3]
        if not np.allclose(rotation.T @ rotation, np.eye(3), atol=1e-4) or np.linalg.det(rotation) < 0:
            raise ValueError("world_from_camera is no rotation with a translation: it stretches, shears or mirrors")
        axes = rotation * np.array(_SIGNS[convention])
        angles = [K is not None, vfov_degrees is not None, orthographic_height is not None]
        if sum(angles) != 1:
            raise ValueError("give one of K, vfov_degrees and orthographic_height")
        if K is not None:
            if size is None:
                raise ValueError("K is in pixels: give size=(width, height) too")
            vfov_degrees = _vfov_of(np.asarray(K, dtype=np.float64), checked_size(size))
        if aperture_radius > 0 and focus_distance is None:
            raise ValueError("a lens is in focus at one distance: give focus_distance")
        # Far enough for 32-bit floats to tell the direction.
        reach = max(1.0, float(np.abs(position).max()))
        return cls(
            position=vector("position", position),
            target=vector("target", position - reach * axes[:, 2]),
            up=vector("up", axes[:, 1]),
            vfov_degrees=40.0 if vfov_degrees is None else vfov_degrees,
            orthographic_height=orthographic_height,
            aperture_radius=aperture_radius,
            focus_distance=focus_distance,
            size=size,
        )

    def world_from_camera(self, *, convention: Convention) -> npt.NDArray[np.float64]:
        """The pose as a matrix (4, 4); :meth:`from_matrix` says what the conventions are."""
        position, target = np.array(self.position), np.array(self.target)
        back = (position - target) / np.linalg.norm(position - target)
        right = np.cross(np.array(self.up), back)
        right /= np.linalg.norm(right)
        matrix = np.eye(4)
        matrix[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1) * np.array(_SIGNS[convention])
        matrix[:3, 3] = position
        return matrix

    def intrinsics(self, size: tuple[int, int] | None = None) -> npt.NDArray[np.float64]:
        """The matrix ``K`` (3, 3) for a picture of ``size``, or of the camera's own size, in pixels.

        Raises :class:`ValueError` where neither is known, and for parallel rays, which have none.
        """
        size = size if size is not None else self.size
        if size is None or self.orthographic_height is not None:
            raise ValueError("intrinsics are those of a pinhole, for a size=(width, height)")
        width, height = checked_size(size)
        focal = 0.5 * height / math.tan(0.5 * math.radians(self.vfov_degrees))
        return np.array([[focal, 0.0, 0.5 * width], [0.0, focal, 0.5 * height], [0.0, 0.0, 1.0]])

    def with_size(self, width: int, height: int) -> Camera:
        """The camera with a picture of another size."""
        return replace(self, size=(width, height))

    def _table(self) -> dict[str, Any]:
        """The camera as the scene file has it."""
        return {
            "position": self.position,
            "look_at": self.target,
            "up": self.up,
            "vertical_fov_degrees": float(self.vfov_degrees),
            "orthographic_height": self.orthographic_height,
            "aperture_radius": float(self.aperture_radius),
            "focus_distance": self.focus_distance,
        }

    @classmethod
    def _of_table(cls, table: Mapping[str, Any]) -> Camera:
        return cls(
            position=table["position"],
            target=table["look_at"],
            up=table.get("up", (0.0, 1.0, 0.0)),
            vfov_degrees=table["vertical_fov_degrees"],
            orthographic_height=table.get("orthographic_height"),
            aperture_radius=table.get("aperture_radius", 0.0),
            focus_distance=table.get("focus_distance"),
        )

    def _numbers(self) -> CameraNumbers:
        # As 32-bit floats, for that is what the distance is measured between when a scene file is read.
        target, position = (np.array(of, dtype=np.float32).astype(np.float64) for of in (self.target, self.position))
        focus = self.focus_distance if self.focus_distance is not None else float(np.linalg.norm(target - position))
        return (
            self.position,
            self.target,
            self.up,
            self.vfov_degrees,
            self.orthographic_height,
            self.aperture_radius,
            focus,
        )


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """Width and height in pixels."""
    try:
        width, height = (int(side) for side in size)
    except (TypeError, ValueError):
        raise ValueError(f"size is {size!r}: give (width, height) in pixels") from None
    if not (1 <= width <= 65536 and 1 <= height <= 65536):
        raise ValueError(f"size is {size!r}: give width and height in pixels, each 1 to 65536")
    return (width, height)


def _vfov_of(K: npt.NDArray[np.float64], size: tuple[int, int]) -> float:
    """Vertical field of view in degrees of intrinsics that raggio has."""
    if K.shape != (3, 3) or not np.isfinite(K).all():
        raise ValueError(f"K is of shape {K.shape}: give (3, 3) finite numbers")
    width, height = size
    (fx, skew, cx), (zero, fy, cy), last = K.tolist()
    if zero != 0 or last != [0, 0, 1] or fx <= 0 or fy <= 0:
        raise ValueError(f"K is {K.tolist()}: give [[fx, skew, cx], [0, fy, cy], [0, 0, 1]]")
    if abs(skew) > 1e-6 * fx:
        raise ValueError(f"K has a skew of {skew}, which raggio's cameras do not have yet: it must be 0")
    if abs(fx - fy) > 1e-6 * fy:
        raise ValueError(
            f"K has fx = {fx} and fy = {fy}: raggio's pixels are square so far, so that they must be equal"
        )
    middle = (0.5 * width, 0.5 * height)
    if max(abs(cx - middle[0]), abs(cy - middle[1])) > 1e-6 * max(size):
        raise ValueError(
            f"K has its principal point at ({cx}, {cy}) and raggio's cameras have it in the middle so far, which is "
            f"{middle} for {width} x {height} pixels counted from the outer corner of the top left one; where whole "
            "numbers are the middles of pixels, add 0.5"
        )
    return math.degrees(2.0 * math.atan(0.5 * height / fy))
