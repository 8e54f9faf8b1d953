"""Scenes."""

from __future__ import annotations

import os
import warnings
import weakref
from collections.abc import Iterable, Iterator, Mapping, MutableMapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _foreign, _lights, _raggio, _toml, _transforms
from ._camera import Camera, checked_size
from ._errors import SceneError, SceneWarning
from ._lights import Light
from ._materials import Environment, Material, Medium, Principled, Texture
from ._shapes import AnyMaterial, Group, Mesh, _Shape


@dataclass(frozen=True)
class Object:
    """An object that was added to a scene: its number in ``image["object_id"]``, and its name."""

    id: int
    name: str | None


class Scene:
    """What there is to see: shapes with materials, light from outside, a camera.

    ``Scene()`` is empty and dark; :func:`load` reads one. A scene is the text of a scene file (``to_toml()``), whose
    meshes and images may be in memory.
    """

    def __init__(self) -> None:
        self._start(_raggio.SceneText.empty(), Path("scene"))

    def _start(self, text: _raggio.SceneText, path: Path) -> None:
        self._text = text
        self._name = path.name
        #: Folder to which paths of the text are relative.
        self._folder = path.absolute().parent
        self._objects: list[Object] = []
        #: What the text names in memory, in words.
        self._in_memory: dict[str, str] = {}
        self._meshes: weakref.WeakKeyDictionary[Mesh, str] = weakref.WeakKeyDictionary()
        self._groups: weakref.WeakKeyDictionary[Group, str] = weakref.WeakKeyDictionary()
        self._materials: dict[str, AnyMaterial] = {}
        self._environment: Environment | None = None

    # ---- Objects

    def add(
        self,
        shape: Any,
        *,
        material: AnyMaterial | str | None = None,
        transform: npt.ArrayLike | None = None,
        name: str | None = None,
        id: int | None = None,
        smooth: bool = False,
    ) -> int:
        """Adds an object, and returns its number in ``image["object_id"]``.

        ``shape`` is a mesh of trimesh, open3d or pyvista, a whole ``trimesh.Scene``, a :class:`Mesh`, a pair of
        vertices (V, 3) and faces (F, 3), a :class:`Sphere`, :class:`Plane`, :class:`Rectangle`, :class:`Disk`,
        :class:`Cylinder`, :class:`Cone` or :class:`Box`, a :class:`Group` of these, or the path of a
        model. ``material`` is one, or the name of one that the scene has; without it meshes and groups have their own, and
        other shapes are light grey. ``transform`` (4, 4) brings it into the world; shapes that are no meshes keep their form,
        so that it scales them by one factor. ``smooth`` gives a mesh without normals some at its vertices.

        ``id`` is from 1 on, and above the numbers of a loaded file's shapes; several objects may share one. By
        default it is the first above all others.

        Raises :class:`ValueError` or :class:`TypeError` where something does not fit, and leaves the scene as it was.
        """
        placement = _transforms.matrix(transform)
        added, materials = self._text.added, set(self._materials)
        try:
            number = self._add_any(shape, material, placement if transform is not None else None, name, id, smooth)
        except BaseException:
            while self._text.added > added:
                self._text.take_last()
            for new in set(self._materials) - materials:
                self._text.set(["materials", new], None)
                del self._materials[new]
            raise
        self._objects.append(Object(number, name))
        return number

    def _add_any(
        self,
        shape: Any,
        material: AnyMaterial | str | None,
        transform: npt.NDArray[np.float64] | None,
        name: str | None,
        id: int | None,
        smooth: bool,
    ) -> int:
        if isinstance(shape, (Group, _Shape)):
            place = {} if transform is None else {"transform": _transforms.similarity(transform)}
            if isinstance(shape, Group):
                return self._add({"group": self._group(shape), **place}, material, id, checked=True)
            return self._add({**shape._table(), **place}, material if material is not None else Material(), id)
        placement = transform if transform is not None else np.eye(4)
        if isinstance(shape, (str, os.PathLike)):
            file = {"file": os.path.abspath(shape), **_transforms.placement(placement)}
            return self._add({"mesh": file}, material, id, checked=True)
        for mesh, own, world_from_mesh in _foreign.meshes(shape, smooth=smooth):
            chosen = material if material is not None else own if own is not None else _plain(mesh)
            placed = self._text.place_mesh(self._held(mesh, name), _transforms.rows(placement @ world_from_mesh))
            id = self._add({"mesh": {"file": placed}}, chosen, id)
            self._in_memory[placed] = f"the mesh {name or placed}"
        if id is None:
            raise ValueError(f"{type(shape).__name__} has no triangles")
        return id

    def _add(
        self, table: dict[str, Any], material: AnyMaterial | str | None, id: int | None, *, checked: bool = False
    ) -> int:
        if isinstance(material, str) and material not in self.materials:
            raise ValueError(f"the scene has no material {material!r}: it has {', '.join(self.materials) or 'none'}")
        # Meshes in memory were checked when they were put there, and reading all of a large scene takes a while.
        if not {"mesh", "group"} & table.keys():
            _raggio.SceneText.check_shape(_toml.value({"material": "material", **table}), _toml.value({}))
        called = self._name_of(material)
        return self._text.add_shape(_toml.value({"material": called, **table}), id, checked=checked)

    def _group(self, group: Group) -> str:
        """Name of the group, which is put into the text where it is not yet."""
        if group in self._groups:
            return self._groups[group]
        tables = []
        for shape, material in group.shapes:
            if isinstance(material, str) and material not in self.materials:
                raise ValueError(f"the scene has no material {material!r}: it has {', '.join(self.materials) or 'none'}")
            tables.append({"material": self._name_of(material), **shape._table()})
        taken = self._text.get(["groups"]) or {}
        number = len(taken) + 1
        while (name := f"group-{number}") in taken:
            number += 1
        self._text.set(["groups", name], _toml.value(tables), checked=True)
        self._groups[group] = name
        return name

    def _held(self, mesh: Mesh, name: str | None) -> str:
        """Name of the mesh in memory."""
        if mesh in self._meshes:
            return self._meshes[mesh]
        # v runs downwards in scenes.
        uvs = None if mesh.uvs is None else np.ascontiguousarray(_turned_over(mesh.uvs))
        held, warning = self._text.give_mesh(name or "mesh", mesh.vertices, mesh.faces, mesh.normals, uvs, mesh.colors)
        if warning is not None:
            warnings.warn(warning, SceneWarning, stacklevel=4)
        self._meshes[mesh] = held
        return held

    @property
    def objects(self) -> tuple[Object, ...]:
        """The objects that were added, in their order; shapes of a loaded file are not among them."""
        return tuple(self._objects)

    # ---- Materials

    @property
    def materials(self) -> MutableMapping[str, AnyMaterial]:
        """The scene's materials by their names; those that came with models are not among them.

        ``scene.materials["clay"] = raggio.Material(color=(0.8, 0.4, 0.2))`` adds one or takes the place of one, which a
        :class:`Renderer` of the scene shows at its next step.
        """
        return _Materials(self)

    def _name_of(self, material: AnyMaterial | str | None) -> str | None:
        """Name under which the scene has the material, which is added where it has none yet."""
        if material is None or isinstance(material, str):
            return material
        for name, known in self._materials.items():
            if known is material or known == material:
                return name
        taken = self.materials
        number = len(self._materials) + 1
        while (name := f"material-{number}") in taken:
            number += 1
        self._set_material(name, material)
        return name

    def _set_material(self, name: str, material: AnyMaterial) -> None:
        table = {key: self._resolved(value, is_image=_is_image(key)) for key, value in material._table().items()}
        if isinstance(material, Principled):
            medium = table.pop("medium", None)
            table = {"principled": table} if medium is None else {"principled": table, "medium": medium}
        text = _toml.value(table)
        if '"memory:' not in text:
            _raggio.SceneText.check_shape(
                '{ material = "material", sphere = { center = [0, 0, 0], radius = 1 } }', text
            )
        self._text.set(["materials", name], text)
        self._materials[name] = material

    def _resolved(self, value: Any, *, is_image: bool) -> Any:
        """A value as the scene file has it: images by their paths, or by their names in memory."""
        if isinstance(value, Medium):
            return value._table()
        if isinstance(value, Texture):
            table = value._table()
            return {**table, "image": self._image(table["image"])} if "image" in table else table
        return self._image(value) if is_image else value

    def _image(self, image: Any) -> str:
        if isinstance(image, (str, os.PathLike)):
            return os.path.abspath(image)
        array = np.asarray(image)
        if array.ndim != 3 or array.shape[2] not in (3, 4):
            raise ValueError(f"the image is of shape {array.shape}: give (height, width, 3)")
        if array.dtype == np.uint8:
            if array.shape[2] == 3:
                array = np.concatenate([array, np.full((*array.shape[:2], 1), 255, np.uint8)], axis=2)
            name = self._text.give_bytes(np.ascontiguousarray(array))
        elif array.dtype.kind == "f" and array.shape[2] == 3:
            name = self._text.give_radiance(np.ascontiguousarray(array, dtype=np.float32))
        else:
            raise ValueError(f"the image is {array.dtype} {array.shape}: give bytes, or floats (height, width, 3)")
        self._in_memory[name] = f"the image {name}"
        return name

    def _absolute(self, table: Mapping[str, Any], images: Iterable[str]) -> dict[str, Any]:
        """A table of the text whose images have paths that are right anywhere."""
        paths = {key: str(self._folder / table[key]) for key in images if isinstance(table.get(key), str)}
        return {**table, **paths}

    # ---- Light, camera, size

    @property
    def environment(self) -> Environment | None:
        """Light from outside; ``None`` is none."""
        if self._environment is None:
            table = self._text.get(["environment"])
            return None if table is None else Environment(**self._absolute(table, ("image",)))
        return self._environment

    @environment.setter
    def environment(self, environment: Environment | None) -> None:
        if environment is None:
            self._text.set(["environment"], None)
        else:
            table = {key: self._resolved(value, is_image=key == "image") for key, value in environment._table().items()}
            self._text.set(["environment"], _toml.value(table), checked=True)
        self._environment = environment

    @property
    def air(self) -> Medium | None:
        """Medium that fills the scene around all bodies, such as fog; ``None`` is none."""
        table = self._text.get(["air"])
        return None if table is None else Medium(**table)

    @air.setter
    def air(self, air: Medium | None) -> None:
        self._text.set(["air"], None if air is None else _toml.value(air._table()), checked=air is not None)

    @property
    def lights(self) -> tuple[Light, ...]:
        """Lights that are no surfaces; those that came with models are not among them.

        ``scene.lights = [raggio.DirectionalLight(direction=(-1, -2, -1), angle_degrees=0.53, intensity=3)]`` sets them all,
        and ``scene.lights += (raggio.PointLight(position=(0, 2, 0)),)`` adds one.

        Raises :class:`SceneError` where one of them does not fit, and leaves the scene as it was.
        """
        return tuple(map(_lights.of_table, self._text.get(["lights"]) or ()))

    @lights.setter
    def lights(self, lights: Iterable[Light]) -> None:
        tables = [_lights.table(light) for light in lights]
        self._text.set(["lights"], _toml.value(tables) if tables else None, checked=True)

    @property
    def camera(self) -> Camera | None:
        """Camera of renders for which none is given; ``None`` where there is none yet."""
        table = self._text.get(["camera"])
        return None if table is None else Camera._of_table(table)

    @camera.setter
    def camera(self, camera: Camera) -> None:
        self._text.set(["camera"], _toml.value(camera._table()))
        if camera.size is not None:
            self.size = camera.size

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, in pixels, of renders for which none is given."""
        render = self._text.get(["render"]) or {}
        return (render.get("width", 1280), render.get("height", 720))

    @size.setter
    def size(self, size: tuple[int, int]) -> None:
        width, height = checked_size(size)
        self._text.set(["render", "width"], str(width))
        self._text.set(["render", "height"], str(height))

    @property
    def time(self) -> float | None:
        """Moment, in seconds, of animations and of the camera's keyframes, which renders without a camera of their own follow.

        ``None``: at the time that each model has in the scene's file, or at rest, and the camera at 0. Frame F is the moment
        ``(F - 1) / fps``. ``raggio.render(scene, time=...)`` is at another without changing this one.
        """
        return self._text.time

    @time.setter
    def time(self, time: float | None) -> None:
        self._text.time = checked_time(time)

    @property
    def animations(self) -> tuple[Animation, ...]:
        """Animations of the scene's models, and that of the camera if it has keyframes: all move together."""
        of_models = (Animation(name, start, end, Path(file)) for file, name, start, end in self._text.animations())
        times = [keyframe["time"] for keyframe in (self._text.get(["camera"]) or {}).get("keyframes", ())]
        of_camera = [Animation("camera", float(times[0]), float(times[-1]), None)] if len(times) > 1 else []
        return (*of_camera, *of_models)

    # ---- As a whole

    def to_toml(self) -> str:
        """The scene as the text of a scene file; paths in it are relative to the folder of the file it was loaded from.

        Raises :class:`SceneError` where meshes or images are in memory, which no text can name, and where there is no
        camera.
        """
        text = self._text.text()
        if what := [words for name, words in self._in_memory.items() if f'"{name}"' in text]:
            more = f" and {len(what) - 1} more" if len(what) > 1 else ""
            raise SceneError(
                f"{what[0]}{more} in this scene is in memory, and no text can name it: write it to a file, and add that"
            )
        if self.camera is None:
            raise SceneError("the scene has no camera, which a scene file needs: set scene.camera")
        self._text.check()
        return text

    def copy(self) -> Scene:
        """A copy, which shares meshes and images with this scene."""
        other = Scene.__new__(Scene)
        other._start(self._text.copy(), self._folder / self._name)
        other._objects = list(self._objects)
        other._in_memory = dict(self._in_memory)
        other._meshes = self._meshes.copy()
        other._groups = self._groups.copy()
        other._materials = dict(self._materials)
        other._environment = self._environment
        return other

    __copy__ = copy

    def __getstate__(self) -> dict[str, Any]:
        """All there is of the scene but files, for other processes: they have to find these where this one does."""
        kept = ("_name", "_folder", "_objects", "_in_memory", "_materials", "_environment")
        return {"_text": self._text.state(), **{name: getattr(self, name) for name in kept}}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._meshes = weakref.WeakKeyDictionary()
        self._groups = weakref.WeakKeyDictionary()
        self.__dict__.update(state, _text=_raggio.SceneText.restored(**state["_text"]))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        same = self._objects == other._objects and (self.camera is None) == (other.camera is None)
        return same and self._text.equals(other._text)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        shapes, plural = self._text.shapes, "" if self._text.shapes == 1 else "s"
        return f"<raggio.Scene {self._name!r}: {shapes} shape{plural}, {len(self.materials)} materials>"


@dataclass(frozen=True)
class Animation:
    """Something that moves in a scene."""

    #: Name that its file gives it; "camera" for the camera's keyframes.
    name: str
    #: Moment of the first keyframe in seconds; before it everything rests.
    start: float
    #: Moment of the last keyframe in seconds; after it everything rests.
    end: float
    #: Model that has it; ``None`` for the camera.
    file: Path | None


def checked_time(time: float | None) -> float | None:
    """A moment that is none of those that are no number, or before the beginning."""
    if time is not None and not 0 <= time < float("inf"):
        raise ValueError(f"time is {time}: give seconds, 0 or more")
    return None if time is None else float(time)


class _Materials(MutableMapping[str, AnyMaterial]):
    """Materials of a scene by their names."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene

    def _tables(self) -> Mapping[str, Any]:
        return self._scene._text.get(["materials"]) or {}

    def __getitem__(self, name: str) -> AnyMaterial:
        if name in self._scene._materials:
            return self._scene._materials[name]
        table = dict(self._tables()[name])
        if "medium" in table:
            table["medium"] = Medium(**table["medium"])
        if "principled" not in table:
            return Material(**table)
        keys = self._scene._absolute(table["principled"], [key for key in table["principled"] if _is_image(key)])
        for key, value in keys.items():
            if isinstance(value, dict):
                keys[key] = Texture(**self._scene._absolute(value, ("image",)))
        return Principled(**keys, medium=table.get("medium"))

    def __setitem__(self, name: str, material: AnyMaterial) -> None:
        self._scene._set_material(name, material)

    def __delitem__(self, name: str) -> None:
        raise TypeError("materials stay, for shapes may be made of them: set another in its place")

    def __iter__(self) -> Iterator[str]:
        return iter(self._tables())

    def __len__(self) -> int:
        return len(self._tables())

    def __repr__(self) -> str:
        return f"<materials {', '.join(self)}>"


def load(
    path: str | os.PathLike[str],
    *,
    camera: str | int | None = None,
    time: float | None = None,
    allow_outside: bool = False,
) -> Scene:
    """Reads a scene (``.toml``) or a model (glTF, GLB, PLY, OBJ, STL), which gets a camera, a ground and a sky.

    ``camera`` chooses one of a model's cameras by its name, or its number from 1 on. ``time`` is the scene's :attr:`~Scene.time`.
    ``allow_outside`` lets models name files outside their own folder.

    Raises :class:`SceneError` where the file cannot be read, with the place and all that is wrong.
    """
    chosen = None if camera is None else str(camera)
    text, told = _raggio.SceneText.load(
        os.fspath(path), allow_outside=allow_outside, time_seconds=checked_time(time), camera=chosen
    )
    for warning in told:
        warnings.warn(warning, SceneWarning, stacklevel=2)
    scene = Scene.__new__(Scene)
    scene._start(text, Path(path))
    return scene


def _is_image(key: str) -> bool:
    """Whether a key of a principled material names an image."""
    return key.endswith(("_texture", "_map"))


def _turned_over(uvs: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    turned = uvs.copy()
    turned[:, 1] = 1 - turned[:, 1]
    return turned


def _plain(mesh: Mesh) -> AnyMaterial:
    """Material of a mesh that has none: colours of vertices show on white."""
    return Principled() if mesh.colors is not None else Material()
