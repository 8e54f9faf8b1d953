#!/usr/bin/env python3
"""convergence.py [--device DEVICE] [--most SAMPLES] [--plots FOLDER]: how the error falls as samples are added.

Renders each reference scene twice at 1, 4, 16, ... samples of a pixel, with different seeds, and takes half the mean
square of the difference, relative to the square of the mean, for the error of one picture: no third picture's noise is in
it. Prints a Markdown table and draws convergence.png.

Pictures are kept in target/convergence and not rendered again by the program that made them. The bunny is left out where its
model is not in tests/data/models.
"""
import argparse
import os
import pathlib
import subprocess

import matplotlib
import numpy

from project import RAGGIO, RESULTS, ROOT, bunny, read_picture

PICTURES = ROOT / "target/convergence"
# Least brightness of a pixel; darker ones count as if they were this bright.
DARK = 1e-2


def scenes():
    found = {name: ROOT / f"scenes/reference/{name}.toml" for name in ["cornell", "lamp", "nested", "spheres", "weekend"]}
    if scene := bunny():
        found["bunny"] = scene
    return dict(sorted(found.items()))


def picture(name, scene, samples, seed, device):
    file = PICTURES / f"{name}-{samples}-{seed}.exr"
    if not file.exists() or file.stat().st_mtime < RAGGIO.stat().st_mtime:
        PICTURES.mkdir(parents=True, exist_ok=True)
        subprocess.run([RAGGIO, "render", scene, "--samples", str(samples), "--seed", str(seed), "--device", device,
                        "--quiet", "-o", file], check=True)
    return read_picture(file)


def error(name, scene, samples, device):
    a, b = (picture(name, scene, samples, seed, device) for seed in (1, 2))
    mean = numpy.maximum(0.5 * (a + b), DARK)
    return float(numpy.sqrt(numpy.mean(0.5 * (a - b) ** 2 / mean**2)))


def draw(counts, errors, plot):
    matplotlib.use("agg")
    matplotlib.rcParams.update({"font.size": 10})
    from matplotlib import pyplot, ticker

    figure, axes = pyplot.subplots(figsize=(7, 4.5))
    for name, values in errors.items():
        axes.loglog(counts, values, marker="o", markersize=3, label=name, base=2)
    top = max(values[0] for values in errors.values())
    axes.loglog(counts, [top * count**-0.5 for count in counts], color="gray", linestyle=":", label="$N^{-1/2}$", base=2)
    axes.set(xlabel="samples of each pixel, N", ylabel="relative RMS error", xticks=counts,
             xticklabels=[f"{count:,}" for count in counts])
    axes.set_yscale("log", base=10)
    axes.yaxis.set_major_formatter(ticker.FuncFormatter(lambda value, _: f"{100 * value:g} %"))
    axes.grid(alpha=0.3)
    axes.legend(frameon=False)
    figure.savefig(plot, bbox_inches="tight", dpi=110, metadata={"Software": None})


def measure(device, most, folder):
    """Errors at 1, 4, 16 ... samples of a pixel, as far as `most`: a table, and a plot in `folder`."""
    counts = [4**i for i in range(10) if 4**i <= most]
    tail = [i for i, count in enumerate(counts) if count >= 16]
    errors = {}
    print("| scene | " + " | ".join(f"{count:,}" for count in counts) + " | slope from 16 |")
    print("|---" * (len(counts) + 2) + "|")
    for name, scene in scenes().items():
        values = errors[name] = [error(name, scene, count, device) for count in counts]
        slope = numpy.polyfit(numpy.log(counts)[tail], numpy.log(values)[tail], 1)[0] if len(tail) > 1 else float("nan")
        print(f"| {name} | " + " | ".join(f"{100 * value:.3g} %" for value in values) + f" | {slope:.2f} |", flush=True)
    folder.mkdir(parents=True, exist_ok=True)
    plot = folder / "convergence.png"
    draw(counts, errors, plot)
    print(f"\n{os.path.relpath(plot, ROOT)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--device", default="auto", help="as for raggio render")
    parser.add_argument("--most", type=int, default=4096, help="samples of a pixel (65536 takes a GPU)")
    parser.add_argument("--plots", type=pathlib.Path, default=RESULTS, help="where the plot goes [default: bench/results]")
    arguments = parser.parse_args()
    measure(arguments.device, arguments.most, arguments.plots)


if __name__ == "__main__":
    main()
