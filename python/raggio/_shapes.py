"""Shapes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from ._camera import VectorLike, vector
from ._materials import Material, Principled
from ._types import Vector


class _Shape:
    """A shape without triangles."""

    _key: ClassVar[str]

    def __post_init__(self) -> None:
        for field in fields(self):  # type: ignore[arg-type]
            if "Vector" in str(field.type):
                object.__setattr__(self, field.name, vector(field.name, getattr(self, field.name)))

    def _table(self) -> dict[str, Any]:
        return {self._key: {field.name: getattr(self, field.name) for field in fields(self)}}  # type: ignore[arg-type]


@dataclass(frozen=True)
class Sphere(_Shape):
    """A sphere."""

    _key = "sphere"
    #: Centre of the sphere.
    center: VectorLike | Vector
    #: Radius of the sphere, greater than 0.
    radius: float


@dataclass(frozen=True)
class Plane(_Shape):
    """An endless plane."""

    _key = "plane"
    #: Any point of the plane.
    point: VectorLike | Vector
    #: Normal of the plane, of any length but 0.
    normal: VectorLike | Vector


@dataclass(frozen=True)
class Rectangle(_Shape):
    """A rectangle; both sides reflect and emit."""

    _key = "rectangle"
    #: One corner of the rectangle.
    corner: VectorLike | Vector
    #: Edge from that corner along one side.
    edge_u: VectorLike | Vector
    #: Edge from that corner along the other side, at a right angle to ``edge_u``.
    edge_v: VectorLike | Vector


@dataclass(frozen=True)
class Disk(_Shape):
    """A disk; both sides reflect and emit."""

    _key = "disk"
    #: Centre of the disk.
    center: VectorLike | Vector
    #: Normal of the disk, of any length but 0.
    normal: VectorLike | Vector
    #: Radius of the disk, greater than 0.
    radius: float


@dataclass(frozen=True)
class Cylinder(_Shape):
    """A cylinder; open, both its sides reflect and emit."""

    _key = "cylinder"
    #: Centre of one end.
    base: VectorLike | Vector
    #: Centre of the other end.
    top: VectorLike | Vector
    #: Radius of the cylinder, greater than 0.
    radius: float
    #: Whether disks close both ends.
    capped: bool = True


@dataclass(frozen=True)
class Cone(_Shape):
    """A cone, which may be cut off; open, both its sides reflect and emit."""

    _key = "cone"
    #: Centre of the wide end.
    base: VectorLike | Vector
    #: The apex, or the centre of the end where it is cut off.
    top: VectorLike | Vector
    #: Radius at ``base``, greater than 0.
    radius: float
    #: Radius at ``top``, where the cone is cut off; 0 for an apex.
    top_radius: float = 0.0
    #: Whether disks close both ends.
    capped: bool = True


@dataclass(frozen=True)
class Box(_Shape):
    """A box, which may be turned."""

    _key = "box"
    #: Centre of the box, about which it turns.
    center: VectorLike | Vector
    #: Lengths of the box's sides along x, y and z, before it is turned.
    size: VectorLike | Vector
    #: Angles by which the box is turned, about the fixed x axis first, then y, then z.
    rotation_degrees: VectorLike | Vector = (0.0, 0.0, 0.0)


ShapeLike = Sphere | Plane | Rectangle | Disk | Cylinder | Cone | Box
AnyMaterial = Material | Principled


class Group:
    """Shapes, each with its material, that are added to scenes together, as often as one likes.

    >>> import raggio as rg
    >>> brass = rg.Material(color="#c99a4b")
    >>> lamp = rg.Group([(rg.Cylinder((0, 0, 0), (0, 1, 0), 0.05), brass), (rg.Sphere((0, 1.1, 0), 0.1), brass)])
    >>> scene = rg.Scene()
    >>> scene.add(lamp), scene.add(lamp, transform=np.diag([2, 2, 2, 1]))
    (1, 2)

    Materials are as for :meth:`Scene.add`. A group never changes, and a scene has it once.
    """

    __slots__ = ("__weakref__", "shapes")

    #: The shapes and their materials.
    shapes: tuple[tuple[ShapeLike, AnyMaterial | str], ...]

    def __init__(self, shapes: Iterable[tuple[ShapeLike, AnyMaterial | str]]) -> None:
        self.shapes = tuple((shape, material) for shape, material in shapes)
        for shape, _ in self.shapes:
            if not isinstance(shape, _Shape):
                raise TypeError(f"a group is of shapes such as Sphere or Box, not of {type(shape).__name__}")
        if not self.shapes:
            raise ValueError("a group without shapes shows nothing")

    def __repr__(self) -> str:
        return f"<raggio.Group {len(self.shapes)} shapes>"


class Mesh:
    """Triangles over shared vertices.

    ``vertices`` are (V, 3), ``faces`` are indices (F, 3), counter-clockwise seen from outside. ``normals`` (V, 3) make
    the mesh smooth; without them it is flat. ``uvs`` (V, 2) are texture coordinates with (0, 0) at the image's bottom
    left, as OBJ and trimesh have them. ``colors`` (V, 3) or (V, 4) multiply the base colour of a :class:`Principled`
    material: linear floats, or sRGB bytes.

    A mesh copies its arrays and never changes. One that is added to a scene several times is held once.
    """

    __slots__ = ("__weakref__", "colors", "faces", "normals", "uvs", "vertices")

    vertices: npt.NDArray[np.float32]
    faces: npt.NDArray[np.uint32]
    normals: npt.NDArray[np.float32] | None
    uvs: npt.NDArray[np.float32] | None
    colors: npt.NDArray[np.float32] | None

    def __init__(
        self,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike,
        *,
        normals: npt.ArrayLike | None = None,
        uvs: npt.ArrayLike | None = None,
        colors: npt.ArrayLike | None = None,
    ) -> None:
        self.vertices = _floats("vertices", vertices, 3)
        self.faces = _indices(faces, len(self.vertices))
        self.normals = None if normals is None else self._each("normals", _floats("normals", normals, 3))
        self.uvs = None if uvs is None else self._each("uvs", _floats("uvs", uvs, 2))
        self.colors = None if colors is None else self._each("colors", _colors(colors))

    def _each(self, name: str, array: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        if len(array) != len(self.vertices):
            raise ValueError(f"{name} has {len(array)} rows: there are {len(self.vertices)} vertices")
        return array

    def smooth(self) -> Mesh:
        """The mesh with normals at its vertices: the means of those of the faces around, weighed by area."""
        corners = self.vertices.astype(np.float64)[self.faces]
        of_faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.zeros((len(self.vertices), 3))
        for corner in range(3):
            np.add.at(normals, self.faces[:, corner], of_faces)
        lengths = np.linalg.norm(normals, axis=1, keepdims=True)
        normals /= np.where(lengths > 0, lengths, 1)
        return Mesh(self.vertices, self.faces, normals=normals, uvs=self.uvs, colors=self.colors)

    def __repr__(self) -> str:
        return f"<raggio.Mesh {len(self.vertices)} vertices, {len(self.faces)} faces>"


def _floats(name: str, of: npt.ArrayLike, columns: int) -> npt.NDArray[np.float32]:
    array = np.array(of, dtype=np.float32, order="C")
    if array.ndim != 2 or array.shape[1] != columns:
        raise ValueError(f"{name} is of shape {array.shape}: give (n, {columns})")
    return array


def _indices(of: npt.ArrayLike, vertices: int) -> npt.NDArray[np.uint32]:
    array = np.asarray(of)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"faces is of shape {array.shape}: give (n, 3)")
    if array.dtype.kind not in "iu":
        raise ValueError(f"faces is of type {array.dtype}: give whole numbers, which count vertices from 0")
    if array.size and (array.min() < 0 or array.max() >= vertices):
        wrong = int(array.min()) if array.min() < 0 else int(array.max())
        raise ValueError(f"faces names vertex {wrong}: with {vertices} vertices indices are from 0 to {vertices - 1}")
    return np.array(array, dtype=np.uint32, order="C")


def _colors(of: npt.ArrayLike) -> npt.NDArray[np.float32]:
    array = np.asarray(of)
    if array.dtype == np.uint8:
        array = array.astype(np.float32) / 255
        color = array[..., :3]
        array[..., :3] = np.where(color <= 0.04045, color / 12.92, ((color + 0.055) / 1.055) ** 2.4)
    if array.ndim == 2 and array.shape[1] == 3:
        array = np.concatenate([array, np.ones((len(array), 1))], axis=1)
    return _floats("colors", array, 4)


_Rows = Sequence[Sequence[float]]
