"""Cameras."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _raggio, _toml
from ._types import Vector

VectorLike = Sequence[float] | npt.NDArray[Any]
Convention = Literal["opencv", "opengl"]
PixelOrigin = Literal["corner", "center"]
Panorama = Literal["latitude-longitude"]

#: Signs of the camera's axes x, y and z in raggio's: x to the right, y up, z backwards.
_SIGNS: dict[str, tuple[float, float, float]] = {"opengl": (1.0, 1.0, 1.0), "opencv": (1.0, -1.0, -1.0)}


def vector(name: str, of: VectorLike) -> Vector:
    """Three finite numbers."""
    array = np.asarray(of, dtype=np.float64)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ValueError(f"{name} is {of!r}: give three finite numbers")
    x, y, z = array.tolist()
    return (x, y, z)


#: What is added to places in pixels to count them from the outer corner of the top left pixel.
_ORIGINS: dict[str, float] = {"corner": 0.0, "center": 0.5}

#: Angle of cameras that are not said to be any other.
_VFOV_DEGREES = 40.0


@dataclass(frozen=True, kw_only=True)
class Intrinsics:
    """Intrinsics of a pinhole, in pixels of a picture of ``size``.

    A point x to the right, y down and z forward of the camera is seen ``focal[0] * x / z + skew * y / z +
    principal_point[0]`` to the right and ``focal[1] * y / z + principal_point[1]`` down from the outer corner of the
    top left pixel.
    """

    #: Focal lengths across and down.
    focal: tuple[float, float]
    #: Point of the picture that lies straight ahead, from the outer corner of the top left pixel.
    principal_point: tuple[float, float]
    #: Width and height of the picture in pixels.
    size: tuple[int, int]
    #: Skew, 0 where pixels are rectangles.
    skew: float = 0.0

    @classmethod
    def from_matrix(
        cls, K: npt.ArrayLike, size: tuple[int, int], *, pixel_origin: PixelOrigin = "corner"
    ) -> Intrinsics:
        """Intrinsics of a matrix (3, 3) in pixels of a picture of ``size``; see :meth:`Camera.from_matrix`."""
        matrix = np.asarray(K, dtype=np.float64)
        if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
            raise ValueError(f"K is of shape {matrix.shape}: give (3, 3) finite numbers")
        (fx, skew, cx), (zero, fy, cy), last = matrix.tolist()
        if zero != 0 or last != [0, 0, 1] or fx <= 0 or fy <= 0:
            raise ValueError(f"K is {matrix.tolist()}: give [[fx, skew, cx], [0, fy, cy], [0, 0, 1]]")
        add = _origin(pixel_origin)
        return cls(focal=(fx, fy), principal_point=(cx + add, cy + add), skew=skew, size=checked_size(size))

    def matrix(self, *, pixel_origin: PixelOrigin = "corner") -> npt.NDArray[np.float64]:
        """The matrix ``K`` (3, 3)."""
        (fx, fy), (cx, cy), add = self.focal, self.principal_point, _origin(pixel_origin)
        return np.array([[fx, self.skew, cx - add], [0.0, fy, cy - add], [0.0, 0.0, 1.0]])

    def resized(self, width: int, height: int) -> Intrinsics:
        """Intrinsics of the same camera for a picture of another size, whose height shows what it did before."""
        scale = height / self.size[1]
        (fx, fy), (cx, cy) = self.focal, self.principal_point
        return Intrinsics(
            focal=(fx * scale, fy * scale),
            principal_point=((cx - 0.5 * self.size[0]) * scale + 0.5 * width, cy * scale),
            skew=self.skew * scale,
            size=(width, height),
        )

    def _table(self) -> dict[str, Any]:
        """The intrinsics as the scene file has them."""
        return {
            "focal": [float(number) for number in self.focal],
            "principal_point": [float(number) for number in self.principal_point],
            "skew": float(self.skew),
            "size": list(self.size),
        }

    @classmethod
    def _of_table(cls, table: Mapping[str, Any]) -> Intrinsics:
        width, height = table["size"]
        fx, fy = table["focal"]
        cx, cy = table.get("principal_point", (0.5 * width, 0.5 * height))
        return cls(focal=(fx, fy), principal_point=(cx, cy), skew=table.get("skew", 0.0), size=(width, height))


def _origin(pixel_origin: PixelOrigin) -> float:
    if pixel_origin not in _ORIGINS:
        raise ValueError(f'pixel_origin is {pixel_origin!r}: give "corner" or "center"')
    return _ORIGINS[pixel_origin]


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A pinhole, a thin lens (``aperture_radius`` above 0), parallel rays (``orthographic_height``), or a picture of
    all directions (``panorama``).

    :meth:`look_at` and :meth:`from_matrix` make one. Lengths are in the scene's units. A camera never changes;
    :func:`dataclasses.replace` makes another of it.
    """

    #: Position of the pinhole, or of the lens's centre.
    position: Vector
    #: Point in the middle of the picture.
    target: Vector
    #: Direction upwards, of any length and not parallel to the viewing direction.
    up: Vector = (0.0, 1.0, 0.0)
    #: Angle in degrees between the picture's top and bottom edges; 40 where this and the next three are ``None``.
    vfov_degrees: float | None = None
    #: Intrinsics, in place of the angle.
    calibration: Intrinsics | None = None
    #: Height of the picture in the scene's units, for parallel rays.
    orthographic_height: float | None = None
    #: Layout of a picture of all directions: "latitude-longitude", with the viewing direction in the middle.
    panorama: Panorama | None = None
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
        given = [name for name in _PROJECTIONS if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(f"{given[1]} cannot stand beside {given[0]}: keep one, and make the other None")
        if not given:
            object.__setattr__(self, "vfov_degrees", _VFOV_DEGREES)
        _raggio.check_camera(_toml.value(self._table()))

    @classmethod
    def look_at(
        cls,
        position: VectorLike,
        target: VectorLike,
        *,
        up: VectorLike = (0.0, 1.0, 0.0),
        vfov_degrees: float | None = None,
        orthographic_height: float | None = None,
        panorama: Panorama | None = None,
        aperture_radius: float = 0.0,
        focus_distance: float | None = None,
        size: tuple[int, int] | None = None,
    ) -> Camera:
        """A camera at ``position`` with ``target`` in the middle of its picture.

        Give one of ``vfov_degrees`` (40 by default), ``orthographic_height`` and ``panorama``.

        Raises :class:`ValueError` where the two are one point, or ``up`` is parallel to the viewing direction.
        """
        return cls(
            position=vector("position", position),
            target=vector("target", target),
            up=vector("up", up),
            vfov_degrees=vfov_degrees,
            orthographic_height=orthographic_height,
            panorama=panorama,
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
        pixel_origin: PixelOrigin = "corner",
        vfov_degrees: float | None = None,
        orthographic_height: float | None = None,
        panorama: Panorama | None = None,
        aperture_radius: float = 0.0,
        focus_distance: float | None = None,
        size: tuple[int, int] | None = None,
    ) -> Camera:
        """A camera of a pose (4, 4) or (3, 4) and of intrinsics (3, 3).

        ``convention`` says where the camera's axes point: ``"opencv"`` x right, y down, z forward (COLMAP too);
        ``"opengl"`` x right, y up, z backward (Blender, nerfstudio and glTF too).

        ``K`` is ``[[fx, skew, cx], [0, fy, cy], [0, 0, 1]]`` in pixels of a picture of ``size``, which is (width,
        height), whatever the convention: u = fx x/z + skew y/z + cx to the right and v = fy y/z + cy down, with y down
        and z forward. ``pixel_origin`` says what (cx, cy) counts from: the outer ``"corner"`` of the top left pixel, so
        that the middle of the picture is (width / 2, height / 2), as COLMAP and nerfstudio have it; or the ``"center"``
        of that pixel, so that whole numbers are the middles of pixels and the middle of the picture is
        (width / 2 - 0.5, height / 2 - 0.5), as OpenCV and KITTI have it. A picture of another size has ``K`` in
        proportion to its height. Without ``K`` give ``vfov_degrees``, ``orthographic_height`` or ``panorama``.

        Raises :class:`ValueError` where the matrix is no rotation with a translation, and where ``K`` is of no camera.
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
        if sum(given is not None for given in (K, vfov_degrees, orthographic_height, panorama)) != 1:
            raise ValueError("give one of K, vfov_degrees, orthographic_height and panorama")
        calibration = None
        if K is not None:
            if size is None:
                raise ValueError("K is in pixels: give size=(width, height) too")
            calibration = Intrinsics.from_matrix(K, size, pixel_origin=pixel_origin)
        if aperture_radius > 0 and focus_distance is None:
            raise ValueError("a lens is in focus at one distance: give focus_distance")
        # Far enough for 32-bit floats to tell the direction.
        reach = max(1.0, float(np.abs(position).max()))
        return cls(
            position=vector("position", position),
            target=vector("target", position - reach * axes[:, 2]),
            up=vector("up", axes[:, 1]),
            vfov_degrees=vfov_degrees,
            calibration=calibration,
            orthographic_height=orthographic_height,
            panorama=panorama,
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

    def intrinsics(
        self, size: tuple[int, int] | None = None, *, pixel_origin: PixelOrigin = "corner"
    ) -> npt.NDArray[np.float64]:
        """The matrix ``K`` (3, 3) for a picture of ``size``, or of the camera's own size, in pixels.

        :meth:`from_matrix` says what ``pixel_origin`` is. Raises :class:`ValueError` where no size is known, and for
        parallel rays and panoramas, which have no such matrix.
        """
        size = size if size is not None else self.size
        if self.calibration is not None:
            calibration = self.calibration
            return (calibration if size is None else calibration.resized(*checked_size(size))).matrix(
                pixel_origin=pixel_origin
            )
        if size is None or self.vfov_degrees is None:
            raise ValueError("intrinsics are those of a pinhole, for a size=(width, height)")
        width, height = checked_size(size)
        focal = 0.5 * height / math.tan(0.5 * math.radians(self.vfov_degrees))
        middle = (0.5 * width, 0.5 * height)
        return Intrinsics(focal=(focal, focal), principal_point=middle, size=(width, height)).matrix(
            pixel_origin=pixel_origin
        )

    def with_size(self, width: int, height: int) -> Camera:
        """The camera with a picture of another size."""
        return replace(self, size=(width, height))

    def _table(self) -> dict[str, Any]:
        """The camera as the scene file has it."""
        return {
            "position": self.position,
            "look_at": self.target,
            "up": self.up,
            "vertical_fov_degrees": None if self.vfov_degrees is None else float(self.vfov_degrees),
            "intrinsics": None if self.calibration is None else self.calibration._table(),
            "orthographic_height": self.orthographic_height,
            "panorama": self.panorama,
            "aperture_radius": float(self.aperture_radius),
            "focus_distance": self.focus_distance,
        }

    @classmethod
    def _of_table(cls, table: Mapping[str, Any]) -> Camera:
        calibration = table.get("intrinsics")
        return cls(
            position=table["position"],
            target=table["look_at"],
            up=table.get("up", (0.0, 1.0, 0.0)),
            vfov_degrees=table.get("vertical_fov_degrees"),
            calibration=None if calibration is None else Intrinsics._of_table(calibration),
            orthographic_height=table.get("orthographic_height"),
            panorama=table.get("panorama"),
            aperture_radius=table.get("aperture_radius", 0.0),
            focus_distance=table.get("focus_distance"),
        )


#: Fields of a camera of which one is given.
_PROJECTIONS = ("vfov_degrees", "calibration", "orthographic_height", "panorama")


def checked_size(size: tuple[int, int]) -> tuple[int, int]:
    """Width and height in pixels."""
    try:
        width, height = (int(side) for side in size)
    except (TypeError, ValueError):
        raise ValueError(f"size is {size!r}: give (width, height) in pixels") from None
    if not (1 <= width <= 65536 and 1 <= height <= 65536):
        raise ValueError(f"size is {size!r}: give width and height in pixels, each 1 to 65536")
    return (width, height)
