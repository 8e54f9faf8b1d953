"""Files of data sets, made of pictures and cameras."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ._camera import Camera, checked_size

__all__ = ["CocoWriter", "run_length", "write_transforms"]


def run_length(mask: npt.ArrayLike) -> dict[str, Any]:
    """A mask (height, width) in COCO's run-length encoding, uncompressed: by columns, what is outside first."""
    array = np.asarray(mask, dtype=bool)
    if array.ndim != 2:
        raise ValueError(f"the mask is of shape {array.shape}: give (height, width)")
    flat = array.ravel(order="F")
    borders = np.flatnonzero(np.diff(flat)) + 1
    counts = np.diff(np.concatenate([[0], borders, [flat.size]])).tolist()
    if flat.size and flat[0]:
        counts.insert(0, 0)
    return {"size": [int(side) for side in array.shape], "counts": counts}


class CocoWriter:
    """Instance masks in COCO's format, gathered picture by picture.

    ``categories`` name the category of each object number; those that it leaves out, and 0, are background.

    >>> import numpy as np
    >>> coco = CocoWriter({7: "cup"})
    >>> coco.add("view-0.png", np.array([[0, 7], [7, 7]], dtype=np.int32))
    1
    >>> coco.data()["annotations"][0]["bbox"]
    [0, 0, 2, 2]
    """

    def __init__(self, categories: Mapping[int, str]) -> None:
        names = list(dict.fromkeys(categories.values()))
        numbers = {name: number for number, name in enumerate(names, 1)}
        self._category = {int(id): numbers[name] for id, name in categories.items()}
        self._categories = [{"id": number, "name": name} for name, number in numbers.items()]
        self._images: list[dict[str, Any]] = []
        self._annotations: list[dict[str, Any]] = []

    def add(self, file_name: str, object_ids: npt.ArrayLike) -> int:
        """Adds a picture by its file's name and ``image["object_id"]`` (height, width); returns its number."""
        ids = np.asarray(object_ids)
        if ids.ndim != 2 or ids.dtype.kind not in "iu":
            raise ValueError(f"object_ids is {ids.dtype} {ids.shape}: give whole numbers (height, width)")
        number = len(self._images) + 1
        height, width = ids.shape
        self._images.append({"id": number, "file_name": file_name, "width": int(width), "height": int(height)})
        for id in np.unique(ids).tolist():
            if id in self._category:
                self._annotations.append(self._annotation(number, id, ids == id))
        return number

    def _annotation(self, image: int, id: int, mask: npt.NDArray[np.bool_]) -> dict[str, Any]:
        rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        left, top = int(columns[0]), int(rows[0])
        return {
            "id": len(self._annotations) + 1,
            "image_id": image,
            "category_id": self._category[id],
            "object_id": id,
            "segmentation": run_length(mask),
            "area": int(mask.sum()),
            "bbox": [left, top, int(columns[-1]) + 1 - left, int(rows[-1]) + 1 - top],
            "iscrowd": 0,
        }

    def data(self) -> dict[str, Any]:
        """All that the file holds."""
        return {"images": self._images, "annotations": self._annotations, "categories": self._categories}

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the file, whole or not at all."""
        _write_json(path, self.data())


def write_transforms(
    path: str | os.PathLike[str],
    views: Iterable[tuple[str, Camera]],
    *,
    size: tuple[int, int] | None = None,
) -> None:
    """Writes nerfstudio's ``transforms.json`` of pictures, each by its file's name and its camera.

    ``size`` is that of all pictures whose camera has none, (width, height) in pixels.
    """
    frames: list[dict[str, Any]] = []
    for file_path, camera in views:
        width, height = checked_size(camera.size or size or (0, 0))
        K = camera.intrinsics((width, height))
        if K[0, 1] != 0:
            raise ValueError(f"the camera of {file_path} has a skew of {K[0, 1]}, which transforms.json cannot say")
        frames.append(
            {
                "file_path": file_path,
                "w": width,
                "h": height,
                "fl_x": float(K[0, 0]),
                "fl_y": float(K[1, 1]),
                "cx": float(K[0, 2]),
                "cy": float(K[1, 2]),
                "transform_matrix": camera.world_from_camera(convention="opengl").tolist(),
            }
        )
    keys = ("w", "h", "fl_x", "fl_y", "cx", "cy")
    shared = {key: frames[0][key] for key in keys if frames and all(frame[key] == frames[0][key] for frame in frames)}
    for frame in frames:
        for key in shared:
            del frame[key]
    _write_json(path, {"camera_model": "OPENCV", **shared, "frames": frames})


def _write_json(path: str | os.PathLike[str], data: Any) -> None:
    # A temporary name, then the right one: nobody meets half a file.
    whole = Path(path)
    part = whole.with_name(f".{whole.name}.{os.getpid()}.part")
    try:
        part.write_text(json.dumps(data), encoding="utf-8")
        os.replace(part, whole)
    finally:
        part.unlink(missing_ok=True)
