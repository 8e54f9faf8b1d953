"""Maps from a mesh into the world."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def matrix(transform: npt.ArrayLike | None) -> npt.NDArray[np.float64]:
    """A map (4, 4) that can be undone."""
    if transform is None:
        return np.eye(4)
    matrix = np.asarray(transform, dtype=np.float64)
    if matrix.shape not in ((4, 4), (3, 4)) or not np.isfinite(matrix).all():
        raise ValueError(f"transform is of shape {matrix.shape}: give (4, 4) finite numbers")
    matrix = np.vstack([matrix[:3], [0, 0, 0, 1]]) if matrix.shape == (3, 4) else matrix
    if not np.allclose(matrix[3], (0, 0, 0, 1)):
        raise ValueError(f"the last row of transform is {matrix[3].tolist()}: it should be [0, 0, 0, 1]")
    if np.linalg.det(matrix[:3, :3]) == 0:
        raise ValueError("transform leaves nothing of the mesh: its determinant is 0")
    return matrix


def rows(matrix: npt.NDArray[np.float64]) -> list[float]:
    """The first three rows, one behind the other."""
    numbers: list[float] = matrix[:3].reshape(-1).tolist()
    return numbers


def similarity(matrix: npt.NDArray[np.float64]) -> dict[str, Any]:
    """Transform of a scene file: translation, rotation and one factor."""
    table = placement(matrix)
    factor = float(np.mean(table["scale"]))
    if np.linalg.det(matrix[:3, :3]) < 0 or not np.allclose(table["scale"], factor, rtol=1e-6):
        raise ValueError("a shape that is no mesh keeps its form: transform may move, turn and scale it by one factor")
    return {**table, "scale": factor}


def placement(matrix: npt.NDArray[np.float64]) -> dict[str, Any]:
    """Translation, rotation and scale of a scene file's mesh."""
    linear = matrix[:3, :3].copy()
    scale = np.linalg.norm(linear, axis=0)
    if np.linalg.det(linear) < 0:
        scale[0] = -scale[0]
    turn = linear / scale
    if not np.allclose(turn.T @ turn, np.eye(3), atol=1e-6):
        raise ValueError("a model's file is moved, turned and stretched along its axes, and this transform shears it")
    y = np.arcsin(np.clip(-turn[2, 0], -1, 1))
    if abs(turn[2, 0]) < 1 - 1e-9:
        x, z = np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(turn[1, 0], turn[0, 0])
    else:
        x, z = np.arctan2(-turn[1, 2], turn[1, 1]), 0.0
    degrees = np.degrees([x, y, z])
    return {"translation": matrix[:3, 3].tolist(), "rotation_degrees": degrees.tolist(), "scale": scale.tolist()}
