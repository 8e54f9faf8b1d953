#!/usr/bin/env python3
"""Renders the pictures of the documentation into docs/images: `make gallery`, or some of them by name.

    python scripts/gallery.py [--program PATH] [NAME ...]

Without --program, cargo builds and runs raggio. A name selects all pictures whose file begins with it.
"""

import argparse
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"

SMALL = ["--size", "400x225"]
QUARTER = ["--size", "240x135"]
# Scene in scenes/, picture in docs/images/, further arguments.
PICTURES = [
    ("showcase", "showcase", ["--size", "864x486", "--samples", "128"]),
    ("materials", "materials", ["--size", "960x420", "--samples", "512"]),
    ("media", "media", []),
    ("guide/lights", "guide/lights", SMALL),
    ("guide/sky", "guide/sky", SMALL),
    ("guide/shapes", "guide/shapes", SMALL),
    ("guide/textures", "guide/textures", SMALL),
    ("notes/01-sky", "notes/01-sky", SMALL),
    ("notes/02-perspective", "notes/02-perspective", SMALL),
    ("notes/03-hit-or-miss", "notes/03-hit-or-miss", SMALL),
    ("notes/04-large-sphere", "notes/04-large-sphere", SMALL),
    ("notes/05-nearest", "notes/05-nearest", SMALL),
    ("notes/06-aliased", "notes/06-aliased", SMALL),
    ("notes/07-anti-aliased", "notes/07-anti-aliased", SMALL),
    ("notes/08-shapes", "notes/08-shapes", SMALL),
    ("notes/09-half", "notes/09-half", SMALL),
    ("notes/10-diffuse", "notes/10-diffuse", SMALL),
    ("notes/11-lamps", "notes/11-lamps", SMALL),
    ("notes/12-rings", "notes/12-rings", SMALL),
    ("notes/13-no-rings", "notes/13-no-rings", SMALL),
    ("notes/14-progressive", "notes/14-progressive-1", [*QUARTER, "--samples", "1"]),
    ("notes/14-progressive", "notes/14-progressive-10", [*QUARTER, "--samples", "10"]),
    ("notes/14-progressive", "notes/14-progressive-100", [*QUARTER, "--samples", "100"]),
    ("notes/14-progressive", "notes/14-progressive-1000", [*QUARTER, "--samples", "1000"]),
    ("notes/15-smoothness", "notes/15-smoothness", SMALL),
    ("notes/16-refraction", "notes/16-refraction", SMALL),
    ("notes/17-total-reflection", "notes/17-total-reflection", SMALL),
    ("notes/18-fresnel", "notes/18-fresnel", SMALL),
    ("notes/19-nested", "notes/19-nested", SMALL),
    ("notes/20-overlap", "notes/20-overlap", SMALL),
    ("notes/21-order", "notes/21-order", SMALL),
    ("notes/22-cornell", "notes/22-cornell", SMALL),
    ("notes/23-depth-of-field", "notes/23-depth-of-field", SMALL),
]


def render(scene: str, picture: str, extra: list[str]) -> list[str]:
    """Arguments of raggio that make a picture."""
    return ["render", f"scenes/{scene}.toml", "-o", picture, *extra]


def main() -> None:
    parser = argparse.ArgumentParser(description="Renders the pictures of the documentation into docs/images.")
    parser.add_argument("--program", metavar="PATH", help="a built raggio to use; default: cargo run")
    parser.add_argument("names", nargs="*", metavar="NAME", help="beginnings of file names; default: all pictures")
    arguments = parser.parse_args()
    raggio = [arguments.program] if arguments.program else ["cargo", "run", "--release", "--quiet", "--bin", "raggio", "--"]

    chosen = [p for p in PICTURES if not arguments.names or Path(p[1]).name.startswith(tuple(arguments.names))]
    if not chosen:
        sys.exit(f"gallery: no picture begins with {' or '.join(arguments.names)}")

    start, total = time.monotonic(), 0
    for scene, name, extra in chosen:
        path = IMAGES / f"{name}.png"
        path.parent.mkdir(parents=True, exist_ok=True)
        began = time.monotonic()
        if status := subprocess.run([*raggio, *render(scene, str(path), extra), "--quiet"], cwd=ROOT).returncode:
            sys.exit(f"gallery: {scene} failed with status {status}")
        size = path.stat().st_size
        total += size
        print(f"{path.relative_to(ROOT)}: {time.monotonic() - began:.1f} s, {size / 1000:.0f} kB", flush=True)
    print(f"{len(chosen)} pictures in {time.monotonic() - start:.0f} s, {total / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
