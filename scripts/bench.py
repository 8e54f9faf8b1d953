#!/usr/bin/env python3
"""bench.py [DEVICE ...]: raggio's speed on the project's scenes, as a Markdown table for docs/performance.md.

DEVICE is what `raggio render --device` takes; without any, the CPU and, if there is a GPU, vulkan. Each scene is rendered
three times and the fastest run counts: other programs only ever slow a render down.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
RAGGIO = ROOT / "target/release/raggio"
RUNS = 3

# Scene, size, samples on the CPU, samples on a GPU: a few seconds on each.
SCENES = [
    ("scenes/reference/weekend.toml", "640x360", 64, 4096),
    ("scenes/reference/weekend.toml", "2560x1440", 2, 8),
    ("scenes/reference/cornell.toml", "512x512", 32, 2048),
    ("scenes/reference/nested.toml", "640x360", 64, 4096),
    ("scenes/showcase.toml", "1280x720", 8, 512),
]


def measure(scene, size, samples, device):
    with tempfile.TemporaryDirectory() as folder:
        stats = pathlib.Path(folder) / "stats.json"
        command = [RAGGIO, "render", ROOT / scene, "--size", size, "--samples", str(samples), "--device", device,
                   "--quiet", "-o", pathlib.Path(folder) / "picture.exr", "--stats", stats]
        runs = []
        for _ in range(RUNS):
            subprocess.run(command, check=True)
            runs.append(json.loads(stats.read_text()))
    return min(runs, key=lambda run: run["render_seconds"])


def devices():
    if len(sys.argv) > 1:
        return sys.argv[1:]
    listed = subprocess.run([RAGGIO, "devices"], check=True, capture_output=True, text=True).stdout
    gpu = any(kind in listed for kind in ("  discrete", "  integrated"))
    return ["cpu", "vulkan"] if gpu else ["cpu"]


def main():
    subprocess.run(["cargo", "build", "--release", "--bin", "raggio"], check=True, cwd=ROOT)
    print("| scene | size | samples | seconds | Msamples/s | Mrays/s | device |")
    print("|---|---|---|---|---|---|---|")
    for device in devices():
        for scene, size, few, many in SCENES:
            run = measure(scene, size, few if device == "cpu" else many, device)
            name = pathlib.Path(scene).stem
            print(f"| {name} | {size} | {run['samples_per_pixel']} | {run['render_seconds']:.3f} | "
                  f"{run['samples_per_second'] / 1e6:.2f} | {run['rays_per_second'] / 1e6:.1f} | {run['device']} |", flush=True)


if __name__ == "__main__":
    main()
