"""Materials, textures and light from outside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from datetime import datetime
from os import PathLike
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

#: Linear red, green and blue; or sRGB, as "#rrggbb" or as {"srgb": (red, green, blue)} with numbers from 0 to 1.
Color = Sequence[float] | npt.NDArray[Any] | str | Mapping[Literal["srgb"], Sequence[float]]
#: An image by its path, or as an array (height, width, 3 or 4): bytes are as image files store them, floats are
#: linear.
ImageLike = str | PathLike[str] | npt.NDArray[Any]
Wrap = Literal["repeat", "mirrored_repeat", "clamp_to_edge"]


class _Table:
    """Keys of a table of the scene file; those that are ``None`` are not written, and have the file's defaults."""

    def _table(self) -> dict[str, Any]:
        names = (field.name for field in fields(self))  # type: ignore[arg-type]
        return {name: value for name in names if (value := getattr(self, name)) is not None}

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, _Table) or type(self) is not type(other):
            return NotImplemented
        return _same(self._table(), other._table())

    __hash__ = None  # type: ignore[assignment]


def _same(one: Any, two: Any) -> bool:
    """Equality that compares arrays as a whole."""
    if isinstance(one, np.ndarray) or isinstance(two, np.ndarray):
        return one is two or (np.shape(one) == np.shape(two) and bool(np.array_equal(one, two)))
    if isinstance(one, Mapping) and isinstance(two, Mapping):
        return one.keys() == two.keys() and all(_same(one[key], two[key]) for key in one)
    if isinstance(one, (list, tuple)) and isinstance(two, (list, tuple)):
        return len(one) == len(two) and all(map(_same, one, two))
    return bool(one == two)


@dataclass(frozen=True, kw_only=True, eq=False)
class Texture(_Table):
    """An image or a checkerboard, and how it lies on a surface."""

    #: The image; or give ``checker``.
    image: ImageLike | None = None
    #: Two to sixteen colours that take turns along both sides of a checkerboard whose fields have the side 1 in texture
    #: coordinates. With 0 in ``scale`` fields become stripes.
    checker: Sequence[Color] | None = None
    #: Offset added to the texture coordinates, last.
    offset: Sequence[float] | None = None
    #: Angle by which texture coordinates are turned.
    rotation_degrees: float | None = None
    #: Factors that multiply the texture coordinates, first.
    scale: Sequence[float] | None = None
    #: Continuation beyond the image's edges, for both directions or for each.
    wrap: Wrap | tuple[Wrap, Wrap] | None = None
    #: Interpolation between the centres of texels.
    filter: Literal["linear", "nearest"] | None = None


TextureLike = ImageLike | Texture


@dataclass(frozen=True, kw_only=True, eq=False)
class Medium(_Table):
    """What a body, or the whole scene, is filled with: fog, smoke, milk, wax. It absorbs and scatters light.

    Coefficients are parts per unit of the scene's length, 0 or more: a number, or red, green and blue. After a distance d a part
    exp(-c d) of the light is left, c the sum of both.
    """

    #: Part of the light that is absorbed per unit of length; 0 by default.
    absorption: float | Color | None = None
    #: Part of the light that is scattered per unit of length; 0 by default.
    scattering: float | Color | None = None
    #: Mean cosine of the angle by which light is scattered, -0.999 to 0.999 (Henyey and Greenstein): 0, by default, to all
    #: sides alike, more goes forward, less goes back.
    anisotropy: float | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Material(_Table):
    """A diffuse or mirroring surface, glass, or a lamp. What is ``None`` has the default of the scene file.

    Colours are linear red, green and blue, 0 to 1, or sRGB: ``"#ff8800"``, or ``{"srgb": (1, 0.5, 0)}``.
    """

    #: Part of the light that is reflected, or transmitted; [0.8, 0.8, 0.8] by default, and 0 for lamps.
    color: Color | None = None
    #: Colour of the emitted light; white by default.
    emission_color: Color | None = None
    #: Strength of the emitted light: times ``emission_color`` it is the emitted radiance; 0 by default.
    emission_strength: float | None = None
    #: Smoothness from 0, diffuse, to 1, a mirror; 0 by default.
    smoothness: float | None = None
    #: Refractive index, which makes the material a dielectric such as glass (1.5); opaque by default.
    refractive_index: float | None = None
    #: Probability that a dielectric reflects: "fresnel", by default, or a number.
    reflection: Literal["fresnel"] | float | None = None
    #: Rank among overlapping dielectrics: the highest wins.
    priority: int | None = None
    #: Medium that fills bodies of the material. Without ``refractive_index`` these have no surface, as fog has none, and no
    #: other key but ``priority``.
    medium: Medium | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Principled(_Table):
    """A physically based material with glTF's names and meanings.

    What is ``None`` has glTF's default, but for ``metallic``, which is 0.
    """

    #: Reflected colour of the diffuse part, or of a metal seen from the front.
    base_color: Color | None = None
    #: Red, green and blue (sRGB) times ``base_color``, alpha times ``alpha``.
    base_color_texture: TextureLike | None = None
    #: Coverage, which ``alpha_mode`` puts to use.
    alpha: float | None = None
    #: Use of coverage: "opaque" ignores it, "mask" cuts away what is below ``alpha_cutoff``, "blend" lets part of the
    #: light pass.
    alpha_mode: Literal["opaque", "mask", "blend"] | None = None
    #: Coverage below which there is no surface; needs ``alpha_mode = "mask"``.
    alpha_cutoff: float | None = None
    #: Metalness from 0, a dielectric, to 1, a metal.
    metallic: float | None = None
    #: Roughness from 0, smooth, to 1.
    roughness: float | None = None
    #: Green times ``roughness``, blue times ``metallic``.
    metallic_roughness_texture: TextureLike | None = None
    #: Refractive index.
    ior: float | None = None
    #: Strength of a dielectric's specular reflection.
    specular: float | None = None
    #: Alpha times ``specular``.
    specular_texture: TextureLike | None = None
    #: Colour of a dielectric's specular reflection seen from the front.
    specular_color: Color | None = None
    #: Red, green and blue (sRGB) times ``specular_color``.
    specular_color_texture: TextureLike | None = None
    #: Part of the light that is refracted into the body instead of scattered diffusely.
    transmission: float | None = None
    #: Red times ``transmission``.
    transmission_texture: TextureLike | None = None
    #: Whether the surface is an infinitely thin sheet: what is transmitted is not bent, and there is no inside.
    thin_walled: bool | None = None
    #: Colour that is left of white light after ``attenuation_distance`` inside the body.
    attenuation_color: Color | None = None
    #: Distance after which ``attenuation_color`` is left; absent: nothing is absorbed.
    attenuation_distance: float | None = None
    #: Dispersion, which is 20 over the Abbe number; 0 bends all colours alike.
    dispersion: float | None = None
    #: Priority among overlapping dielectrics: the higher one wins, and of equal ones the one entered last.
    priority: int | None = None
    #: Part of the diffuse light that leaves on the other side.
    diffuse_transmission: float | None = None
    #: Alpha times ``diffuse_transmission``.
    diffuse_transmission_texture: TextureLike | None = None
    #: Colour of the diffusely transmitted light.
    diffuse_transmission_color: Color | None = None
    #: Red, green and blue (sRGB) times ``diffuse_transmission_color``.
    diffuse_transmission_color_texture: TextureLike | None = None
    #: Strength of the clear coat.
    clearcoat: float | None = None
    #: Red times ``clearcoat``.
    clearcoat_texture: TextureLike | None = None
    #: Roughness of the clear coat from 0, smooth, to 1.
    clearcoat_roughness: float | None = None
    #: Green times ``clearcoat_roughness``.
    clearcoat_roughness_texture: TextureLike | None = None
    #: Normals of the coat in tangent space; without it the coat is as smooth as the geometry.
    clearcoat_normal_map: TextureLike | None = None
    #: Factor that multiplies x and y of ``clearcoat_normal_map``.
    clearcoat_normal_scale: float | None = None
    #: Reflectance of the sheen at grazing angles; black is no sheen.
    sheen_color: Color | None = None
    #: Red, green and blue (sRGB) times ``sheen_color``.
    sheen_color_texture: TextureLike | None = None
    #: Roughness of the sheen from 0 to 1.
    sheen_roughness: float | None = None
    #: Alpha times ``sheen_roughness``.
    sheen_roughness_texture: TextureLike | None = None
    #: Strength with which highlights are stretched, from 0 to 1.
    anisotropy: float | None = None
    #: Degrees from the tangent to the direction in which highlights are stretched, counter-clockwise.
    anisotropy_rotation: float | None = None
    #: Red and green a direction that ``anisotropy_rotation`` turns, blue times ``anisotropy``.
    anisotropy_texture: TextureLike | None = None
    #: Strength of the thin film.
    iridescence: float | None = None
    #: Red times ``iridescence``.
    iridescence_texture: TextureLike | None = None
    #: Refractive index of the film.
    iridescence_ior: float | None = None
    #: Thickness of the film in nanometres where ``iridescence_thickness_texture`` is 0.
    iridescence_thickness_minimum: float | None = None
    #: Thickness of the film in nanometres where ``iridescence_thickness_texture`` is 1 or absent.
    iridescence_thickness_maximum: float | None = None
    #: Green chooses between the two thicknesses.
    iridescence_thickness_texture: TextureLike | None = None
    #: Colour of the emitted light. [1, 1, 1] by default when ``emissive_strength`` or ``emissive_texture`` is given.
    emissive: Color | None = None
    #: Red, green and blue (sRGB) times ``emissive``.
    emissive_texture: TextureLike | None = None
    #: Strength of the emitted light: multiplied by ``emissive`` it is the emitted radiance.
    emissive_strength: float | None = None
    #: Normals in the tangent space of its texture coordinates.
    normal_map: TextureLike | None = None
    #: Factor that multiplies x and y of ``normal_map``.
    normal_scale: float | None = None
    #: Medium that fills bodies of the material, into which light comes by ``transmission``: with it wax, skin and marble.
    medium: Medium | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Environment(_Table):
    """Light from outside.

    ``color``, or ``horizon`` and ``zenith``, or ``image``, or the sky by day: by ``sun_direction``, or by
    ``latitude_degrees``, ``longitude_degrees`` and ``time``.
    """

    #: Radiance that comes from everywhere alike.
    color: Color | None = None
    #: Radiance from straight below; a ray of unit direction D sees mix(horizon, zenith, 0.5 (D.y + 1)).
    horizon: Color | None = None
    #: Radiance from straight above.
    zenith: Color | None = None
    #: Latitude-longitude image, by its path or as an array (height, width, 3) of linear radiance; its centre is seen
    #: along -Z, its right along +X, its top along +Y.
    image: ImageLike | None = None
    #: Direction toward the sun, of any length but 0 and not below the horizon, which makes a sky by day: up is +Y.
    sun_direction: Sequence[float] | npt.NDArray[Any] | None = None
    #: Latitude of the place whose sky is seen, north of the equator positive; north is along -Z, east along +X.
    latitude_degrees: float | None = None
    #: Longitude of the place, east of Greenwich positive.
    longitude_degrees: float | None = None
    #: Date and time at which the sky is seen, with its offset from universal time; a text is as in RFC 3339.
    time: datetime | str | None = None
    #: Haziness of the air, from 1, pure, over 3, a clear day and the default, to 10, hazy.
    turbidity: float | None = None
    #: Part of the light that the ground reflects, 0.2 by default: it brightens the sky and is seen below the horizon.
    ground_albedo: Color | None = None
    #: Factor that multiplies the light straight from the sun; 1 by default, 0 for a sun that is hidden.
    sun_intensity: float | None = None
    #: Angle by which the image, or the sky with its sun, is turned about the y axis, counter-clockwise seen from above.
    rotation_degrees: float | None = None
    #: Factor that multiplies the image, or the light of sky and sun.
    intensity: float | None = None
