"""Lights that are no surfaces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from ._camera import VectorLike, vector
from ._materials import Color, _Table
from ._types import Vector


class _Light(_Table):
    """A light that is no surface."""

    _key: ClassVar[str]

    def __post_init__(self) -> None:
        for name in ("position", "direction"):
            if hasattr(self, name):
                object.__setattr__(self, name, vector(name, getattr(self, name)))


@dataclass(frozen=True, kw_only=True, eq=False)
class PointLight(_Light):
    """A light that shines from one point in all directions."""

    _key = "point"
    #: Position of the light.
    position: VectorLike | Vector
    #: Colour of the light, linear; white by default.
    color: Color | None = None
    #: Radiant intensity, which ``color`` multiplies; 1 by default. A surface at distance d that faces the light gets the
    #: irradiance intensity / d^2.
    intensity: float | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class SpotLight(_Light):
    """A light that shines from one point into a cone."""

    _key = "spot"
    #: Position of the light.
    position: VectorLike | Vector
    #: Direction of the cone's axis, of any length but 0.
    direction: VectorLike | Vector
    #: Angle from the axis within which all the light is seen; 0 by default.
    inner_degrees: float | None = None
    #: Angle from the axis beyond which none is; 45 by default.
    outer_degrees: float | None = None
    #: Colour of the light, linear; white by default.
    color: Color | None = None
    #: Radiant intensity within the inner angle, which ``color`` multiplies; 1 by default.
    intensity: float | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class DirectionalLight(_Light):
    """Parallel light from infinitely far away, or, with an angle, a sun."""

    _key = "directional"
    #: Direction in which the light shines, of any length but 0.
    direction: VectorLike | Vector
    #: Angle that the sun's disk is wide: 0, by default, or 0.01 to 180. The one over the earth is 0.53 wide.
    angle_degrees: float | None = None
    #: Colour of the light, linear; white by default.
    color: Color | None = None
    #: Irradiance of a surface that faces the light, which ``color`` multiplies, whatever the angle is; 1 by default.
    intensity: float | None = None


Light = PointLight | SpotLight | DirectionalLight
_KINDS: tuple[type[PointLight] | type[SpotLight] | type[DirectionalLight], ...] = (PointLight, SpotLight, DirectionalLight)


def table(light: Light) -> dict[str, Any]:
    """The light as a table of the scene file.

    Raises :class:`TypeError` where it is none.
    """
    if not isinstance(light, _Light):
        raise TypeError(f"a light is a PointLight, a SpotLight or a DirectionalLight, not {type(light).__name__}")
    return {light._key: light._table()}


def of_table(table: Mapping[str, Any]) -> Light:
    """The light of a table of the scene file."""
    kind = next(kind for kind in _KINDS if kind._key in table)
    return kind(**table[kind._key])
