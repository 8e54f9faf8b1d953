#!/usr/bin/env python3
"""How the cost of a picture grows: with triangles, pixels, samples, lights, materials, bounces and threads; and how its error
falls with samples (convergence.py).

    python scripts/bench/curves.py [--device DEVICE] [--only NAME ...] [--all] [--tiny] [--plots FOLDER]

Draws cost-NAME.svg for each and prints a Markdown table for docs/performance.md. On the CPU, cost is processor time, which
other programs disturb less than the clock, and for threads alone time by the clock. It is the difference of two renders with
the one scene and different numbers of samples, so that reading the scene and writing the picture are no part of it.

Ten to fifteen minutes on two cores. --all goes on to 21 million triangles and four times as many samples, and takes half an
hour and 8 GB. --tiny runs everything once at sizes that say nothing, to see that it works.
"""
import argparse
import json
import math
import os
import pathlib
import random
import statistics
import time

import matplotlib
import numpy

import convergence
import project
import rock

# Samples of the second render for each of the first.
FACTOR = 3


class Curve:
    """A series of renders: `places` says of each its place on the axis and how to render it, with how many samples in all."""

    def __init__(self, axis, cost, places, clock=False):
        self.axis, self.cost, self.places, self.clock = axis, cost, places, clock


def seconds(figures, clock):
    return figures["render_seconds" if clock else "processor_seconds"]


def sampling(place, options, clock):
    """Seconds that one sample of all pixels costs."""
    scene, size, total, *more = place
    samples = max(1, round(total / (size[0] * size[1])))
    few, many = (project.render(scene, size, count, device=options.device, more=more)
                 for count in (samples, FACTOR * samples))
    return (seconds(many, clock) - seconds(few, clock)) / ((FACTOR - 1) * samples)


def scene_of(name, header, shapes):
    """Path of a scene that is made of texts."""
    project.CACHE.mkdir(parents=True, exist_ok=True)
    path = project.CACHE / f"{name}.toml"
    path.write_text(header + "".join(shapes))
    return path


HEADER = """version = 1
[render]
max_depth = 8
[camera]
position = [0, 6, 14]
look_at = [0, 0, 0]
vertical_fov_degrees = 50
[environment]
color = [{sky}, {sky}, {sky}]
[materials.ground]
color = [0.6, 0.6, 0.6]
[[shapes]]
material = "ground"
plane = {{ point = [0, 0, 0], normal = [0, 1, 0] }}
"""


def balls(count, heights, radius):
    """Places of balls over the ground, and their radius: their area together is the same for all numbers."""
    chance = random.Random(1)
    radius = radius / math.sqrt(count)
    for _ in range(count):
        x, z = (chance.uniform(-8, 8) for _ in range(2))
        yield f"sphere = {{ center = [{x:.4f}, {chance.uniform(*heights):.4f}, {z:.4f}], radius = {radius:.6f} }}\n"


def lights(count):
    """A ground under `count` lamps that shine as much together as one."""
    lamp = "[materials.lamp]\ncolor = [0, 0, 0]\nemission_color = [1, 1, 1]\nemission_strength = 10.0\n"
    shapes = (f'[[shapes]]\nmaterial = "lamp"\n{ball}' for ball in balls(count, (1.5, 3), 1.0))
    return scene_of(f"lights-{count}", HEADER.format(sky=0.0) + lamp, shapes)


def materials(count, shapes):
    """A number of balls that does not change, of `count` materials."""
    chance = random.Random(2)
    listed = []
    for i in range(count):
        # So much alike that paths are as long with one as with many.
        color = ", ".join(f"{chance.uniform(0.5, 0.6):.4f}" for _ in range(3))
        listed.append(f"[materials.m{i}]\ncolor = [{color}]\n")
    header = HEADER.format(sky=1.0) + "".join(listed)
    placed = (f'[[shapes]]\nmaterial = "m{i % count}"\n{ball}' for i, ball in enumerate(balls(shapes, (0, 3), 12.0)))
    return scene_of(f"materials-{count}", header, placed)


def powers(base, most, least=1):
    return [base**i for i in range(64) if least <= base**i <= most]


def curves(options):
    """All curves, as functions: their scenes are made when they are needed."""
    tiny = options.tiny
    size = (64, 48) if tiny else (640, 480)
    pixels_of_size = size[0] * size[1]
    cornell = project.ROOT / "scenes/reference/cornell.toml"
    # Samples of the first render: some seconds of two cores together with those of the second.
    total = 4 * pixels_of_size if tiny else 2_000_000
    cores = project.machine()["cores"]

    def triangles():
        levels = [2, 3, 4] if tiny else [6, 7, 8, 9, 10] if options.all else [6, 7, 8, 9]
        square = (64, 64) if tiny else (1024, 1024)
        # Reading the mesh takes as long as these samples, and not the same time twice.
        return [(20 * 4**level + 2, (rock.write(project.CACHE, level), square, 4 * total)) for level in levels]

    def pixels():
        widths = [32, 64, 128] if tiny else [64, 128, 256, 512, 1024, 2048]
        return [(w * w * 3 // 4, (cornell, (w, w * 3 // 4), total)) for w in widths]

    def threads():
        counts = sorted({*powers(2, cores), cores})
        return [(count, (cornell, size, total, "--threads", str(count))) for count in counts]

    return {
        "triangles": Curve("triangles", "time of a sample", triangles),
        "pixels": Curve("pixels", "time of a sample of all pixels", pixels),
        "samples": Curve("samples of each pixel", "their time", lambda: [
            ((FACTOR - 1) * n, (cornell, size, n * pixels_of_size)) for n in powers(2, 4 if tiny else 128 if options.all else 32)]),
        "lights": Curve("lamps", "time of a sample", lambda: [
            (n, (lights(n), size, total)) for n in powers(10, 100 if tiny else 100_000)]),
        "materials": Curve("materials", "time of a sample", lambda: [
            (n, (materials(n, 100 if tiny else 10_000), size, total)) for n in powers(10, 100 if tiny else 10_000)]),
        "bounces": Curve("most rays of a path", "time of a sample", lambda: [
            (n, (cornell, size, total, "--max-depth", str(n))) for n in powers(2, 8 if tiny else 256, 2)]),
        "threads": Curve("threads", "time of a sample", threads, clock=True),
    }


def measure(name, curve, options):
    """Places and costs, the median of some rounds, in which all places take turns."""
    places = curve.places()
    rounds = [[sampling(place, options, curve.clock or options.device != "cpu") for _, place in places]
              for _ in range(options.rounds)]
    costs = [statistics.median(found) for found in zip(*rounds)]
    if name == "samples":
        # The difference of the two renders itself.
        costs = [cost * x for (x, _), cost in zip(places, costs)]
    return [x for x, _ in places], costs, rounds


def exponent(places, costs):
    """Slope on logarithmic axes, by least squares; nothing where a cost was lost in noise."""
    if len(places) < 2 or min(costs) <= 0:
        return math.nan
    # No slope is 0, and not -0.
    return round(float(numpy.polyfit(numpy.log(places), numpy.log(costs), 1)[0]), 2) + 0.0


def number(value):
    for unit, name in ((1e6, " M"), (1e3, " k")):
        if value >= 10 * unit or (value >= unit and unit > 1e3):
            return f"{value / unit:.4g}{name}"
    return f"{value:,.4g}"


def ticks(axis, values):
    """Numbers as people write them, at 1, 2 and 5 of each decade where there are few."""
    from matplotlib import ticker

    few = max(values) < 100 * min(values)
    axis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5) if few else (1,)))
    axis.set_major_formatter(ticker.FuncFormatter(lambda value, _: number(value)))
    axis.set_minor_formatter(ticker.NullFormatter())


def draw(name, curve, places, costs, slopes, folder):
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(4.5, 3))
    costs = [1e3 * cost for cost in costs]
    axes.loglog(places, costs, "o-", markersize=4)
    if math.isfinite(slopes[0]):
        middle = math.exp(numpy.mean(numpy.log(costs)) - slopes[0] * numpy.mean(numpy.log(places)))
        axes.loglog(places, [middle * x ** slopes[0] for x in places], ":", color="gray")
        # A decade at least, so that what is hardly a slope looks so.
        middle, half = math.sqrt(min(costs) * max(costs)), max(10, 1.5 * max(costs) / min(costs)) ** 0.5
        axes.set_ylim(middle / half, middle * half)
        ticks(axes.yaxis, axes.get_ylim())
    ticks(axes.xaxis, places)
    at_end = f", {slopes[1]:.2f} at the end" if len(places) > 3 else ""
    axes.set(xlabel=curve.axis, ylabel=f"{curve.cost}, ms", title=f"{curve.axis}: exponent {slopes[0]:.2f}{at_end}")
    axes.grid(alpha=0.3)
    file = folder / f"cost-{name}.svg"
    figure.savefig(file, bbox_inches="tight", metadata={"Date": None, "Creator": None})
    pyplot.close(figure)
    return file


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--device", default="cpu", help="as for raggio render")
    parser.add_argument("--only", nargs="+", help="curves to measure [default: all]")
    parser.add_argument("--rounds", type=int, help="renders of each, of which the median counts [default: 3]")
    parser.add_argument("--all", action="store_true", help="up to the largest sizes")
    parser.add_argument("--tiny", action="store_true", help="sizes that say nothing")
    parser.add_argument("--plots", type=pathlib.Path, default=project.RESULTS, help="where plots go [default: bench/results]")
    parser.add_argument("--no-build", action="store_true", help="take raggio as it was built last")
    options = parser.parse_args()
    options.rounds = options.rounds or (1 if options.tiny else 3)
    if not options.no_build:
        project.build()
    known = curves(options)
    wanted = options.only or [*known, "convergence"]
    if unknown := set(wanted) - {*known, "convergence"}:
        parser.error(f"no curve is called {', '.join(sorted(unknown))}: there are {', '.join(known)} and convergence")
    matplotlib.use("agg")
    matplotlib.rcParams.update({"font.size": 9, "svg.hashsalt": "raggio", "svg.fonttype": "none"})
    for folder in (project.RESULTS, options.plots):
        folder.mkdir(parents=True, exist_ok=True)
    report = {"machine": project.machine(), "options": vars(options), "curves": {}}
    print("| cost with | from | to | time from | to | exponent | of the last three | took |\n|---|---|---|---|---|---|---|---|")
    for name, curve in known.items():
        if name not in wanted:
            continue
        start = time.perf_counter()
        places, costs, rounds = measure(name, curve, options)
        took = time.perf_counter() - start
        # What is no power in the whole may be one in the end.
        slope, last = exponent(places, costs), exponent(places[-3:], costs[-3:])
        draw(name, curve, places, costs, (slope, last), options.plots)
        print(f"| {curve.axis} | {places[0]:,} | {places[-1]:,} | {1e3 * costs[0]:.3g} ms | {1e3 * costs[-1]:.3g} ms | "
              f"{slope:.2f} | {last:.2f} | {took:.0f} s |", flush=True)
        report["curves"][name] = {"places": places, "seconds": costs, "rounds": rounds, "exponent": slope,
                                  "exponent_of_last_three": last, "took": took}
        (project.RESULTS / "curves.json").write_text(json.dumps(report, indent=1, default=str) + "\n")
    plots = os.path.relpath(options.plots, project.ROOT)
    print(f"\n{plots}/cost-*.svg, bench/results/curves.json\n")
    if "convergence" in wanted:
        convergence.measure(options.device, 16 if options.tiny else 4096, options.plots)


if __name__ == "__main__":
    main()
