#!/usr/bin/env python3
"""Renders the pictures of the documentation into docs/images: `make gallery`, or some of them by name.

    python scripts/gallery.py [--program PATH] [NAME ...]

Without --program, cargo builds and runs raggio. A name selects all pictures whose file begins with it.
"""

import argparse
import struct
import subprocess
import sys
import time
import zlib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
IMAGES = ROOT / "docs" / "images"

SMALL = ["--size", "400x225"]
QUARTER = ["--size", "240x135"]
# Scene in scenes/, picture in docs/images/, further arguments.
PICTURES = [
    ("showcase", "showcase", ["--size", "864x486", "--samples", "128"]),
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


def chunks(png: bytes):
    """Type and content of each chunk of a PNG file."""
    place = 8
    while place < len(png):
        length, kind = struct.unpack_from(">I4s", png, place)
        yield kind, png[place + 8 : place + 8 + length]
        place += length + 12


def paeth(a: int, b: int, c: int) -> int:
    p = a + b - c
    pa, pb, pc = abs(p - a), abs(p - b), abs(p - c)
    return a if pa <= pb and pa <= pc else b if pb <= pc else c


def unfiltered(data: bytes, stride: int, pixel: int) -> list[bytearray]:
    """The rows of an image, from the decompressed content of its IDAT chunks."""
    rows, above = [], bytearray(stride)
    for start in range(0, len(data), stride + 1):
        kind, row = data[start], bytearray(data[start + 1 : start + 1 + stride])
        for i in range(stride if kind else 0):
            left, corner = (row[i - pixel], above[i - pixel]) if i >= pixel else (0, 0)
            guess = (left, above[i], (left + above[i]) // 2, paeth(left, above[i], corner))[kind - 1]
            row[i] = (row[i] + guess) & 255
        rows.append(row)
        above = row
    return rows


def filtered(row: bytes, above: bytes, pixel: int) -> bytes:
    """The row as the one of PNG's filters leaves it whose differences are smallest."""
    left = bytes(pixel) + row[:-pixel]
    corner = bytes(pixel) + above[:-pixel]
    guesses = [
        bytes(len(row)),
        left,
        above,
        bytes((a + b) // 2 for a, b in zip(left, above)),
        bytes(map(paeth, left, above, corner)),
    ]
    candidates = [bytes((x - g) & 255 for x, g in zip(row, guess)) for guess in guesses]
    costs = [sum(min(x, 256 - x) for x in candidate) for candidate in candidates]
    best = costs.index(min(costs))
    return bytes([best]) + candidates[best]


def shrink(path: Path) -> None:
    """Writes a smaller PNG of the same look: compressed harder, and without each channel's lowest bit.

    That bit is the samples' noise; noise does not compress, and no eye sees this much of it.
    """
    content: dict[bytes, bytes] = {}
    for kind, data in chunks(path.read_bytes()):
        content[kind] = content.get(kind, b"") + data
    header = content[b"IHDR"]
    width, _, depth, color, _, _, interlaced = struct.unpack(">IIBBBBB", header)
    if (depth, interlaced) != (8, 0) or color not in (2, 6):
        sys.exit(f"gallery: {path} is not a plain 8-bit RGB or RGBA image")
    pixel = 3 if color == 2 else 4

    coarse = bytes((v & 254) | (v >> 7) for v in range(256))
    rows = [bytes(row).translate(coarse) for row in unfiltered(zlib.decompress(content[b"IDAT"]), width * pixel, pixel)]
    above = [bytes(width * pixel), *rows[:-1]]
    data = zlib.compress(b"".join(filtered(row, up, pixel) for row, up in zip(rows, above)), 9)

    png = b"\x89PNG\r\n\x1a\n"
    for kind, body in ((b"IHDR", header), (b"IDAT", data), (b"IEND", b"")):
        png += struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    if len(png) < path.stat().st_size:
        path.write_bytes(png)


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
        command = [*raggio, "render", f"scenes/{scene}.toml", "-o", str(path), "--quiet", *extra]
        if status := subprocess.run(command, cwd=ROOT).returncode:
            sys.exit(f"gallery: {scene} failed with status {status}")
        rendered = time.monotonic()
        shrink(path)
        size = path.stat().st_size
        total += size
        print(f"{path.relative_to(ROOT)}: {rendered - began:.1f} s, {size / 1000:.0f} kB", flush=True)
    print(f"{len(chosen)} pictures in {time.monotonic() - start:.0f} s, {total / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
