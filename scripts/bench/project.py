"""The project's own side: folders, the built program, its runs."""
import json
import os
import pathlib
import platform
import resource
import subprocess
import tempfile
import time

import numpy
import OpenEXR

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
RESULTS = ROOT / "bench/results"
CACHE = RESULTS / "cache"
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
RAGGIO, TRACE = TARGET / "raggio", TARGET / "examples/trace"


def build():
    for what in (["--package", "raggio-cli", "--bin", "raggio"], ["--package", "raggio-render", "--example", "trace"]):
        subprocess.run(["cargo", "build", "--release", *what], check=True, cwd=ROOT)


def render(scene, size, samples, seed=0, picture=None, device="cpu", more=()):
    """Figures of a render: those of `--stats`, with the seconds from start to end and the processor's of the whole process."""
    with tempfile.TemporaryDirectory() as folder:
        stats = pathlib.Path(folder) / "stats.json"
        command = [RAGGIO, "render", scene, "--size", "{}x{}".format(*size), "--samples", str(samples), "--seed", str(seed),
                   "--device", device, "--quiet", "--stats", stats, "-o", picture or pathlib.Path(folder) / "picture.exr", *more]
        whole = run(command)
        figures = json.loads(stats.read_text())
    return figures | {"seconds": figures["render_seconds"], "process_seconds": whole["seconds"],
                      "processor_seconds": whole["processor_seconds"]}


def run(command, **options):
    """Seconds that a command takes from start to end, and those of processors."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, **options)
    seconds, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"seconds": seconds, "processor_seconds": used}


def read_picture(path):
    if str(path).endswith(".npy"):
        return numpy.load(path).astype(float)
    with OpenEXR.File(str(path)) as exr:
        channels = exr.channels()
        name = "RGB" if "RGB" in channels else "RGBA"
        return channels[name].pixels[..., :3].astype(float)


def bunny():
    """Scene of the bunny, where its model and sky are; others' files, and not in the project."""
    for folder in (ROOT / "tests/data", ROOT.parent / "shared"):
        scene = folder / "reference/bunny.toml"
        if (folder / "models/bunny.ply").exists() and scene.exists():
            return scene
    return None


def machine():
    def first(path, key):
        try:
            lines = pathlib.Path(path).read_text().splitlines()
        except OSError:
            return None
        return next((line.split(":", 1)[1].strip() for line in lines if line.startswith(key)), None)

    said = lambda *command: subprocess.run(command, capture_output=True, text=True, cwd=ROOT).stdout.strip() or None  # noqa: E731
    return {"processor": first("/proc/cpuinfo", "model name") or platform.processor(), "cores": len(os.sched_getaffinity(0))
            if hasattr(os, "sched_getaffinity") else os.cpu_count(), "memory": first("/proc/meminfo", "MemTotal"),
            "system": platform.platform(), "load_before": os.getloadavg()[0], "raggio": said(RAGGIO, "--version"),
            "devices": said(RAGGIO, "devices"), "commit": said("git", "describe", "--always", "--dirty"),
            "date": time.strftime("%Y-%m-%d %H:%M:%S")}
