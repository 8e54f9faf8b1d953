"""Measures how renders on a cluster scale: `make cluster`, or cluster.py --seconds 120. For a machine with two cores that has
nothing else to do, and the Python module with Ray (`make python`).

A picture is rendered by a cluster of one worker with one core, and by one of two. What a task, a film's way and its adding up
cost is measured then, and a simulation of events tells from it how a thousand workers would do: with all films added up by the
machine that keeps them, and as raggio does it, where what waits is added up on other machines.
"""
import argparse
import heapq
import os
import secrets
import subprocess
import sys
import time
from dataclasses import dataclass

os.environ.setdefault("RAY_AUTH_MODE", "token")
os.environ.setdefault("RAY_AUTH_TOKEN", secrets.token_hex(16))

import numpy as np
import raggio as rg
import raggio.cluster
from raggio.cluster import _jobs
from raggio.cluster._connect import ray_module
from raggio.cluster._worker import add_up

PIXEL_BYTES = 72
WORKERS = (1, 2, 10, 30, 100, 300, 1000)


def scene():
    """A few spheres in the open, of all materials that matter."""
    made = rg.Scene()
    made.environment = rg.Environment(color=(0.7, 0.8, 1.0))
    made.camera = rg.Camera.look_at((0, 2, 6), (0, 0.5, 0))
    for place, material in enumerate((rg.Material(color=(0.8, 0.4, 0.2)), rg.Principled(metallic=1.0, roughness=0.2))):
        made.add(rg.Sphere(center=(2 * place - 1, 0.5, 0), radius=1), material=material)
    return made


def cluster(workers):
    """A cluster on this machine of so many workers with one core each, beside a head that does nothing."""
    ray_module()
    from ray.cluster_utils import Cluster

    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, "include_dashboard": False})
    for _ in range(workers):
        made.add_node(num_cpus=1)
    return made


def render(workers, samples, size):
    """Renders in this process, and prints the seconds: all, and those from the first task on."""
    made = cluster(workers)
    begun = time.perf_counter()
    image = rg.cluster.render(scene(), samples=samples, size=size, device="cpu", address=made.address, progress=False)
    assert image.finished
    print(time.perf_counter() - begun, image.seconds)
    made.shutdown()


def measured(workers, samples, size):
    command = [sys.executable, __file__, "--render", workers, samples, *size]
    done = subprocess.run(list(map(str, command)), check=True, stdout=subprocess.PIPE, text=True)
    return [float(seconds) for seconds in done.stdout.split()[-2:]]


def scaling(seconds, size):
    """Seconds that one worker and two take for a render of about so many: all, and those from the first task on."""
    trial = rg.render(scene(), samples=64, size=size, device="cpu", threads=1, progress=False)
    samples = max(64, int(seconds * 64 / trial.seconds))
    one, two = (measured(workers, samples, size) for workers in (1, 2))
    return one, two


@dataclass
class Costs:
    """Costs in seconds."""

    #: Driver's work for each task.
    task: float
    #: Worker's work for each film: reading it from the device and packing it.
    pack: float
    #: Adding a film to another, once it is here.
    merge: float
    #: Bytes of a film, and bytes a second of each machine's network.
    film_bytes: float
    network: float

    @property
    def transfer(self):
        return self.film_bytes / self.network


def costs(size, network):
    """What is measured on this machine, for pictures of ``size``."""
    session = raggio.cluster._worker.Order(
        raggio.cluster._files.Manifest({}, {}), size=size, device="cpu", films=True
    ).session(scene(), None)
    films = []
    pack = np.inf
    for number in range(3):
        begun = time.perf_counter()
        film, seconds, _ = session.film(number, number + 1)
        films.append(film.to_bytes())
        pack = min(pack, time.perf_counter() - begun - seconds)
    begun = time.perf_counter()
    add_up(*films)
    merge = (time.perf_counter() - begun) / len(films)

    made = cluster(1)
    ray = ray_module()
    ray.init(address=made.address, log_to_driver=False, logging_level="ERROR")

    class Nobody:
        def work(self):
            return {}, None

    nobody = ray.remote(Nobody).remote()
    ray.get(nobody.work.remote())
    calls = 300
    begun = time.perf_counter()
    for _ in range(calls):
        told, _ = nobody.work.options(num_returns=2).remote()
        ray.get(told)
    task = (time.perf_counter() - begun) / calls
    ray.shutdown()
    made.shutdown()
    return Costs(task, pack, merge, PIXEL_BYTES * size[0] * size[1], network)


def simulate(workers, seconds, cost, tree):
    """Seconds that a cluster takes for a render that would take it ``seconds`` if nothing but sampling took time, and the
    most films that wait at a time; with a tree of sums or without."""
    total = left = float(workers * seconds)
    overhead = cost.pack
    longest = min(max(_jobs.SHORTEST, overhead / _jobs.OVERHEAD), _jobs.LONGEST)
    last = max(_jobs.LAST, 4 * overhead)
    events = [(0.0, place, "ready", 0.0) for place in range(workers)]
    count = workers
    waiting, coming, merged, most = [], 0, 0.0, 0
    # Moments at which the machine that keeps the film, and its network, are free again.
    driver = link = now = 0.0

    def later(moment, what, samples):
        nonlocal count
        count += 1
        heapq.heappush(events, (moment, count, what, samples))

    while merged < total * (1 - 1e-9):
        now, _, what, samples = heapq.heappop(events)
        if what in ("ready", "film") and left > 0:
            # The next task is there already while this answer is on its way, unless the driver cannot keep up.
            driver = max(driver, now) + cost.task
            part = min(left, longest, max(_jobs.PORTION * left / workers, last))
            left -= part
            later(max(now, driver - part) + part + cost.pack, "film", part)
        if what in ("film", "sum"):
            waiting.append(samples)
        if what == "merged":
            coming -= 1
            merged += samples
        while waiting and coming < _jobs.FETCHES:
            link = max(link, now) + cost.transfer
            driver = max(driver, link) + cost.merge
            coming += 1
            later(driver, "merged", waiting.pop(0))
        while tree and len(waiting) >= _jobs.FAN_IN:
            parts, waiting = waiting[: _jobs.FAN_IN], waiting[_jobs.FAN_IN :]
            later(now + cost.task + _jobs.FAN_IN * (cost.transfer + cost.merge) + cost.pack, "sum", sum(parts))
        most = max(most, len(waiting))
    return now, most


def main():
    parser = argparse.ArgumentParser(prog="cluster", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=120.0, help="of the render by one worker; 0 leaves it out")
    parser.add_argument("--size", type=int, nargs=2, default=(640, 360), help="of the picture that is rendered")
    parser.add_argument("--film", type=int, nargs=2, default=(1920, 1080), help="size of the picture of the simulation")
    parser.add_argument("--minutes", type=float, default=10.0, help="of the simulated render, on all workers together")
    parser.add_argument("--network", type=float, default=10.0, help="Gbit/s of each machine of the simulation")
    parser.add_argument("--render", type=int, nargs=4, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.render:
        workers, samples, *size = options.render
        return render(workers, samples, tuple(size))
    if options.seconds > 0:
        found = scaling(options.seconds, tuple(options.size))
        for part, one, two in zip(("with Ray's and the workers' start", "from the first task on"), *found):
            share = 100 * one / (2 * two)
            print(f"{part}: one worker {one:.1f} s, two {two:.1f} s, {share:.1f} % of perfect scaling", flush=True)
    cost = costs(tuple(options.film), options.network * 1e9 / 8)
    print(f"a task {1e3 * cost.task:.1f} ms; a film of {cost.film_bytes / 1e6:.0f} MB: packing {cost.pack:.2f} s, "
          f"network {cost.transfer:.2f} s, adding {cost.merge:.2f} s\n")
    print(f"Simulation of a render of {options.minutes:g} min at {options.film[0]}x{options.film[1]}:\n")
    print("| workers | all films added up by one machine | films that wait | a tree of sums | films that wait |")
    print("|---|---|---|---|---|")
    for workers in WORKERS:
        row = [str(workers)]
        for tree in (False, True):
            seconds, most = simulate(workers, 60 * options.minutes, cost, tree)
            row += [f"{100 * 60 * options.minutes / seconds:.1f} %", str(most)]
        print("| " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
