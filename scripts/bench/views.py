"""Measures many small pictures of one scene, as data sets are made: `make views`, or views.py --views 10000.

raggio, Mitsuba 3 and pyrender render a rock of 82,000 triangles from all sides, with depth, normals and numbers of objects as
NumPy arrays, each in a process of its own that keeps the scene; one after another. It says how many views a second each makes,
and by how much its memory grows: raggio's may not, so that 20 MB more than after the warm-up are a failure.
"""
import argparse
import json
import subprocess
import sys

import peers
import project
import rock

WORKER = peers.HERE / "workers" / "views_worker.py"
# Views that nobody counts: what is compiled and set aside once is there then.
WARM_UP = 50
# Level of the rock.
LEVEL = 6
GROWTH_MB = 20


def measure(python, name, mesh, views, options):
    command = [python, WORKER, name, mesh, views, WARM_UP, options.size, options.samples]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode:
        return None, peers.last_line(done.stderr)
    return json.loads(done.stdout.splitlines()[-1]), None


def main():
    parser = argparse.ArgumentParser(prog="views", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--views", type=int, default=1000)
    parser.add_argument("--peer-views", type=int, default=1000, help="views of the others, at most")
    parser.add_argument("--size", type=int, default=128, help="width and height in pixels")
    parser.add_argument("--samples", type=int, default=4, help="samples a pixel; pyrender has none")
    parser.add_argument("--only", nargs="+", choices=["raggio", "mitsuba", "pyrender"], default=["raggio", "mitsuba", "pyrender"])
    options = parser.parse_args()
    if options.only != ["raggio"]:
        peers.install()
    mesh = rock.write(project.CACHE, LEVEL).with_suffix(".ply")

    print(f"| {options.size}x{options.size} | views | views/s | ms of the processor for a view "
          f"| MB after {WARM_UP} views | MB more at the end |")
    print("|---|---|---|---|---|---|")
    failed = False
    for name in options.only:
        ours = name == "raggio"
        views = options.views if ours else min(options.views, options.peer_views)
        found, reason = measure(sys.executable if ours else peers.PYTHON, name, mesh, views, options)
        if found is None:
            print(f"| {name} is left out: {reason} | | | | | |", flush=True)
            failed |= ours
            continue
        rate, cost = views / found["seconds"], 1000 * found["processor_seconds"] / views
        before, more = found["memory_mb"], found["growth_mb"]
        print(f"| {found['name']} | {views} | {rate:.1f} | {cost:.0f} | {before:.0f} | {more:.1f} |", flush=True)
        failed |= ours and more > GROWTH_MB
    if failed:
        sys.exit(f"views: raggio failed, or took more than {GROWTH_MB} MB more")


if __name__ == "__main__":
    main()
