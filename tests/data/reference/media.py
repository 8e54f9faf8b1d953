#!/usr/bin/env python3
"""media.py MEDIA.TOML OUT.exr [SAMPLES]: renders a scene of spheres, a plane and media with Mitsuba 3 (`volpath`).

media.exr was made with `pip install mitsuba==3.9.1` in an environment of its own and
`python media.py ../../../scenes/reference/media.toml media.exr 4096`. Mitsuba follows the same conventions: `max_depth`
counts rays along a path, `color` multiplies what a dielectric reflects and transmits, and a medium is what it loses per unit of
length. Its phase function's `g` is our `anisotropy`.
"""

import glob
import os
import re
import sys
import tomllib


def newest_llvm() -> str | None:
    """Path of the newest LLVM library under /usr/lib, if there is one."""
    found = glob.glob("/usr/lib/*/libLLVM.so.*") + glob.glob("/usr/lib/llvm-*/lib/libLLVM*.so*")
    version = re.compile(r"llvm-(\d+)|libLLVM\.so\.(\d+)")
    return max(found, key=lambda path: int("".join(filter(None, version.search(path).groups()))), default=None)


if library := newest_llvm():
    os.environ.setdefault("DRJIT_LIBLLVM_PATH", library)
import mitsuba  # noqa: E402
import numpy  # noqa: E402

# Spectral tracking by colours, on all threads.
mitsuba.set_variant("llvm_ad_rgb" if library else "scalar_rgb")
from mitsuba import ScalarTransform4f as T  # noqa: E402

# Half the side of the square that an endless plane becomes.
FAR = 2000.0
# Most samples of one pass: films sum in single precision.
PASS = 256


def rgb(color):
    color = color if isinstance(color, list) else [color] * 3
    return {"type": "rgb", "value": [float(channel) for channel in color]}


def medium(table):
    absorption, scattering = (rgb(table.get(key, 0))["value"] for key in ("absorption", "scattering"))
    extinction = [a + s for a, s in zip(absorption, scattering)]
    albedo = [s / e if e > 0 else 0.0 for s, e in zip(scattering, extinction)]
    phase = {"type": "hg", "g": float(table.get("anisotropy", 0))}
    # Colours are to be at most 1; a factor of all of them may be larger.
    scale = max(extinction)
    extinction = [e / scale for e in extinction]
    return {"type": "homogeneous", "sigma_t": rgb(extinction), "scale": scale, "albedo": rgb(albedo), "phase": phase}


def surface(material):
    if "refractive_index" in material:
        color = rgb(material["color"])
        return {"type": "dielectric", "int_ior": float(material["refractive_index"]), "ext_ior": 1.0,
                "specular_reflectance": color, "specular_transmittance": color}
    if "medium" in material:
        return {"type": "null"}
    return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": rgb(material["color"])}}


def shape(table, material):
    if "sphere" in table:
        made = {"type": "sphere", "center": table["sphere"]["center"], "radius": table["sphere"]["radius"]}
    else:
        at = table["plane"]["point"]
        made = {"type": "rectangle", "to_world": T().translate(at).rotate([1, 0, 0], -90).scale(FAR)}
    made["bsdf"] = surface(material)
    if "medium" in material:
        made["interior"] = medium(material["medium"])
    if strength := material.get("emission_strength"):
        made["emitter"] = {"type": "area", "radiance": rgb([strength * c for c in material["emission_color"]])}
    return made


def scene(toml):
    camera, render = toml["camera"], toml["render"]
    made = {
        "type": "scene",
        "integrator": {"type": "volpath", "max_depth": render["max_depth"], "rr_depth": 1000},
        "sensor": {
            "type": "perspective",
            "fov": camera["vertical_fov_degrees"],
            "fov_axis": "y",
            "to_world": T().look_at(origin=camera["position"], target=camera["look_at"], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": render["width"], "height": render["height"], "rfilter": {"type": "box"},
                     "component_format": "float32", "pixel_format": "rgb"},
        },
        "sky": {"type": "constant", "radiance": rgb(toml["environment"]["color"])},
    }
    for number, table in enumerate(toml["shapes"]):
        made[f"shape{number}"] = shape(table, toml["materials"][table["material"]])
    return mitsuba.load_dict(made)


def main() -> None:
    path, out = sys.argv[1:3]
    samples = int(sys.argv[3]) if len(sys.argv) > 3 else 1024
    with open(path, "rb") as file:
        loaded = scene(tomllib.load(file))
    total = None
    passes = max(1, samples // PASS)
    for seed in range(passes):
        picture = numpy.array(mitsuba.render(loaded, spp=min(samples, PASS), seed=seed), dtype=numpy.float64)
        total = picture if total is None else total + picture
        print(f"\r{seed + 1} of {passes}", end="", file=sys.stderr)
    mitsuba.Bitmap((total / passes).astype("float32")).write(out)


if __name__ == "__main__":
    main()
