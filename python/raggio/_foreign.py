"""Meshes of other libraries, known by what they have and not by their types: none of them is imported."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from ._materials import Principled
from ._shapes import Mesh

#: A mesh, the material that came with it, and its place.
Found = tuple[Mesh, Principled | None, npt.NDArray[np.float64]]


def meshes(of: Any, *, smooth: bool) -> Iterator[Found]:
    """The meshes that an object holds.

    Raises :class:`TypeError` where it is nothing that has triangles.
    """
    if isinstance(of, Mesh):
        yield _smoothed(of, smooth), None, np.eye(4)
    elif isinstance(of, tuple) and len(of) == 2:
        yield _smoothed(Mesh(of[0], of[1]), smooth), None, np.eye(4)
    elif hasattr(of, "geometry") and hasattr(of, "graph"):
        yield from _trimesh_scene(of, smooth)
    elif hasattr(of, "vertices") and hasattr(of, "faces"):
        yield *_trimesh(of, smooth), np.eye(4)
    elif hasattr(of, "vertices") and hasattr(of, "triangles"):
        yield _open3d(of, smooth), None, np.eye(4)
    elif hasattr(of, "vertex") and hasattr(of, "triangle"):
        yield _open3d_tensors(of, smooth), None, np.eye(4)
    elif hasattr(of, "combine") and hasattr(of, "n_blocks"):
        yield _pyvista(of.combine(), smooth), None, np.eye(4)
    elif hasattr(of, "points") and (hasattr(of, "faces") or hasattr(of, "extract_surface")):
        yield _pyvista(of, smooth), None, np.eye(4)
    else:
        raise TypeError(
            f"{type(of).__name__} is no mesh: give (vertices, faces), an object of trimesh, open3d or pyvista, a shape "
            "such as raggio.Sphere, or the path of a model"
        )


def _smoothed(mesh: Mesh, smooth: bool) -> Mesh:
    return mesh.smooth() if smooth and mesh.normals is None else mesh


def _trimesh_scene(scene: Any, smooth: bool) -> Iterator[Found]:
    known: dict[str, tuple[Mesh, Principled | None]] = {}
    for node in scene.graph.nodes_geometry:
        transform, name = scene.graph[node]
        geometry = scene.geometry[name]
        if not hasattr(geometry, "faces"):
            continue
        if name not in known:
            known[name] = _trimesh(geometry, smooth)
        yield *known[name], np.asarray(transform, dtype=np.float64)


def _trimesh(mesh: Any, smooth: bool) -> tuple[Mesh, Principled | None]:
    visual: Any = getattr(mesh, "visual", None)
    kind = getattr(visual, "kind", None)
    uvs, colors, material = None, None, None
    if kind == "texture":
        uv = getattr(visual, "uv", None)
        uvs = None if uv is None or len(uv) != len(mesh.vertices) else np.asarray(uv)[:, :2]
        material = _trimesh_material(visual.material, uvs is not None)
    elif kind == "vertex":
        colors = np.asarray(visual.vertex_colors)
        material = Principled()
    elif kind == "face" and len(face_colors := np.asarray(visual.face_colors)) == len(mesh.faces):
        # Colours belong to vertices, so that faces cannot share any.
        vertices = np.asarray(mesh.vertices)[np.asarray(mesh.faces)].reshape(-1, 3)
        normals = np.asarray(mesh.vertex_normals)[np.asarray(mesh.faces)].reshape(-1, 3) if smooth else None
        faces = np.arange(len(vertices)).reshape(-1, 3)
        return Mesh(vertices, faces, normals=normals, colors=face_colors.repeat(3, axis=0)), Principled()
    normals = np.asarray(mesh.vertex_normals) if smooth else None
    return Mesh(mesh.vertices, mesh.faces, normals=normals, uvs=uvs, colors=colors), material


def _trimesh_material(material: Any, textured: bool) -> Principled | None:
    if hasattr(material, "to_pbr") and not hasattr(material, "baseColorFactor"):
        material = material.to_pbr()
    if not hasattr(material, "baseColorFactor"):
        return None
    factor = getattr(material, "baseColorFactor", None)
    base, alpha = (1.0, 1.0, 1.0), 1.0
    if factor is not None:
        numbers = np.asarray(factor, dtype=np.float64)
        numbers = numbers / 255 if np.asarray(factor).dtype == np.uint8 else numbers
        base = tuple(np.clip(numbers[:3], 0, 1).tolist())
        alpha = float(numbers[3]) if len(numbers) > 3 else 1.0
    metallic, roughness = getattr(material, "metallicFactor", None), getattr(material, "roughnessFactor", None)
    emissive = getattr(material, "emissiveFactor", None)
    return Principled(
        base_color=base,
        base_color_texture=_picture(getattr(material, "baseColorTexture", None) if textured else None),
        alpha=alpha if str(getattr(material, "alphaMode", None)) == "BLEND" else None,
        alpha_mode="blend" if str(getattr(material, "alphaMode", None)) == "BLEND" else None,
        # Absent is what glTF says of it.
        metallic=1.0 if metallic is None else float(metallic),
        roughness=roughness,
        metallic_roughness_texture=_picture(getattr(material, "metallicRoughnessTexture", None) if textured else None),
        normal_map=_picture(getattr(material, "normalTexture", None) if textured else None),
        emissive=None if emissive is None else np.asarray(emissive, dtype=np.float64).tolist(),
        emissive_texture=_picture(getattr(material, "emissiveTexture", None) if textured else None),
    )


def _picture(image: Any) -> npt.NDArray[np.uint8] | None:
    """Bytes of a picture of Pillow's."""
    return None if image is None else np.asarray(image.convert("RGBA"), dtype=np.uint8)


def _open3d(mesh: Any, smooth: bool) -> Mesh:
    def has(what: str) -> bool:
        return hasattr(mesh, f"has_{what}") and bool(getattr(mesh, f"has_{what}")())

    normals = np.asarray(mesh.vertex_normals) if has("vertex_normals") else None
    colors = _shown(np.asarray(mesh.vertex_colors)) if has("vertex_colors") else None
    return _smoothed(Mesh(np.asarray(mesh.vertices), np.asarray(mesh.triangles), normals=normals, colors=colors), smooth)


def _open3d_tensors(mesh: Any, smooth: bool) -> Mesh:
    """A mesh of ``open3d.t``, whose tensors may be on a GPU."""

    def array(tensors: Any, name: str) -> npt.NDArray[Any] | None:
        return tensors[name].cpu().numpy() if name in tensors else None

    vertices, faces = array(mesh.vertex, "positions"), array(mesh.triangle, "indices")
    if vertices is None or faces is None:
        raise TypeError("this mesh of open3d has no positions or no triangles")
    colors = array(mesh.vertex, "colors")
    normals, colors = array(mesh.vertex, "normals"), None if colors is None else _shown(colors)
    return _smoothed(Mesh(vertices, faces, normals=normals, colors=colors), smooth)


def _shown(colors: npt.NDArray[Any]) -> npt.NDArray[np.uint8]:
    """open3d's colours, which are what it shows, in bytes of sRGB; those that are none are from 0 to 1."""
    return colors if colors.dtype == np.uint8 else np.rint(255 * np.clip(colors, 0, 1)).astype(np.uint8)


#: Names under which pyvista's readers leave colours of points.
_COLORS = ("RGBA", "RGB", "rgba", "rgb")


def _pyvista(mesh: Any, smooth: bool) -> Mesh:
    if not hasattr(mesh, "faces"):
        mesh = _surface(mesh)
    if not getattr(mesh, "is_all_triangles", False):
        mesh = mesh.triangulate()
    faces = np.asarray(mesh.faces).reshape(-1, 4)[:, 1:]
    data = getattr(mesh, "point_data", {})
    # pyvista shows meshes flat unless it is told otherwise, and has normals of those, too: its box has eight.
    normals = np.asarray(data["Normals"]) if smooth and "Normals" in data else None
    uvs = getattr(mesh, "active_texture_coordinates", None)
    found = (np.asarray(data[name]) for name in _COLORS if name in data)
    colors = next((colors for colors in found if colors.dtype == np.uint8 and colors.ndim == 2), None)
    return _smoothed(Mesh(mesh.points, faces, normals=normals, uvs=uvs, colors=colors), smooth)


def _surface(mesh: Any) -> Any:
    try:
        # Newer versions warn of a default that will change.
        return mesh.extract_surface(algorithm="dataset_surface")
    except TypeError:
        return mesh.extract_surface()
