"""What is measured: each function returns rows of ratios, and every figure that they come from."""
import contextlib
import pathlib
import statistics
import subprocess
import tempfile

import numpy

import peers
import project
import rock
from peers import Peer, say

REFERENCES = project.ROOT / "tests/data/reference"
SCENES = project.ROOT / "scenes/reference"
# Samples a pixel of the reference pictures, which are Mitsuba's.
REFERENCE_SAMPLES = 16384
# Relative difference of means beyond which two programs do not render one scene.
SAME = 0.02

# Scene, size and samples of a few seconds each, and the peers beside raggio.
RATES = [
    ("rock", (1024, 1024), 4, ("mitsuba llvm", "mitsuba scalar", "cycles")),
    ("weekend", (640, 360), 8, ("mitsuba llvm", "mitsuba scalar", "cycles")),
    ("cornell", (512, 512), 8, ("mitsuba llvm", "mitsuba scalar")),
    ("spheres", (640, 360), 32, ("mitsuba llvm", "mitsuba scalar")),
]
EFFICIENCIES = ["cornell", "lamp", "weekend", "bunny"]


def scene_file(name, level=7):
    return rock.write(project.CACHE, level) if name == "rock" else SCENES / f"{name}.toml"


def interleaved(rounds, contestants):
    """Figures of each of `contestants`, which take turns; a round that nobody counts goes before."""
    figures = {name: [] for name in contestants}
    for i in range(-1, rounds):
        for name, measure in contestants.items():
            found = measure(i + 1)
            if i >= 0:
                figures[name].append(found)
    return figures


def row(label, ratios):
    return {"label": label, "median": statistics.median(ratios), "least": min(ratios), "most": max(ratios), "ratios": ratios}


def contestants(stack, file, size, samples, names):
    """raggio and the peers of these names, each with a function that renders picture number `i` of the scene."""
    def raggio(i, picture=None):
        return project.render(file, size, samples, i, picture)

    ready = {"raggio": raggio}
    for name in names:
        peer = Peer(name)
        stack.callback(peer.end)
        peer.load(file, size)
        ready[name] = lambda i, picture=None, peer=peer: peer.ask("render", samples=samples, seed=i, picture=picture)
    return ready


def check_same(name, ready, folder):
    """Renders the scene once with each; where the mean is another one, so is the scene, and nothing can be compared."""
    means = {}
    for who, draw in ready.items():
        picture = folder / ("picture.npy" if who.startswith("mitsuba") else "picture.exr")
        draw(0, picture)
        means[who] = float(project.read_picture(picture).mean())
    for who, mean in means.items():
        if abs(mean / means["raggio"] - 1) > SAME:
            raise AssertionError(f"{name}: the mean of {who} is {mean:.4f}, raggio's {means['raggio']:.4f}")
    return means


def rates(options, available):
    """Samples a second beside each peer."""
    rows, detail = [], {}
    for name, size, samples, beside in RATES:
        samples = max(1, samples // options.shrink)
        names = [peer for peer in beside if peer in available]
        say(f"samples/s: {name}, {size[0]}x{size[1]}, {samples} samples")
        with contextlib.ExitStack() as stack:
            folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
            ready = contestants(stack, scene_file(name), size, samples, names)
            means = check_same(name, ready, folder)
            figures = interleaved(options.rounds, ready)
        count = size[0] * size[1] * samples
        detail[name] = {"size": size, "samples": samples, "means": means, "figures": figures,
                        "msamples_per_second": {who: statistics.median(count / f["seconds"] / 1e6 for f in found)
                                                for who, found in figures.items()}}
        for peer in names:
            ratios = [b["seconds"] / a["seconds"] for a, b in zip(figures["raggio"], figures[peer])]
            rows.append(row(f"samples/s of {name} over {peer}", ratios))
    return rows, detail


def relative_error(picture, reference):
    """Mean square of the error over that of the reference, to which a hundredth of the picture's is added."""
    return float(numpy.mean((picture - reference) ** 2 / (reference**2 + 0.01 * numpy.mean(reference**2))))


def efficiencies(options, available):
    """1 / (relative MSE x seconds) beside Mitsuba, at the size of the reference pictures."""
    peer = "mitsuba llvm"
    rows, detail = [], {}
    if peer not in available:
        return rows, detail
    samples = 128 // options.shrink
    for name in EFFICIENCIES:
        file = project.bunny() if name == "bunny" else scene_file(name)
        if file is None:
            say("bunny is left out: tests/data/models has neither bunny.ply nor its sky")
            continue
        reference = project.read_picture(REFERENCES / f"{name}.exr")
        size = reference.shape[1::-1]
        say(f"efficiency: {name}, {size[0]}x{size[1]}, {samples} samples")
        with contextlib.ExitStack() as stack:
            folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
            ready = contestants(stack, file, size, samples, [peer])

            def with_error(draw, picture):
                def measure(i):
                    figures = draw(i, picture)
                    return figures | {"error": relative_error(project.read_picture(picture), reference)}
                return measure

            endings = {"raggio": "exr", peer: "npy"}
            figures = interleaved(options.rounds, {
                who: with_error(draw, folder / f"picture.{endings[who]}") for who, draw in ready.items()})
        # The reference is a picture of the same estimator as Mitsuba's, with more samples: its share of both errors.
        noise = statistics.median(f["error"] for f in figures[peer]) / (1 + REFERENCE_SAMPLES / samples)
        ratios = [(b["error"] - noise) * b["seconds"] / ((a["error"] - noise) * a["seconds"])
                  for a, b in zip(figures["raggio"], figures[peer])]
        rows.append(row(f"efficiency on {name} over {peer}", ratios))
        detail[name] = {"size": size, "samples": samples, "error_of_reference": noise, "figures": figures,
                        "error": {who: statistics.median(f["error"] - noise for f in found) for who, found in figures.items()}}
    return rows, detail


def traversal(options, available):
    """Rays a second of the walk alone: bounces in the mesh, one thread."""
    if "embree" not in available:
        return [], {}
    file = scene_file("rock")
    with contextlib.ExitStack() as stack:
        folder = pathlib.Path(stack.enter_context(tempfile.TemporaryDirectory()))
        embree = Peer("embree")
        stack.callback(embree.end)
        embree.ask("load", path=file)
        side = 1024 // options.shrink
        rays = embree.ask("make_rays", width=side, height=side, bounces=3, file=folder / "rays")["rays"]
        say(f"rays/s: rock, {rays} rays of bounces")
        embree.ask("trace", distances=folder / "theirs")
        raggio = subprocess.Popen([project.TRACE, file, folder / "rays", folder / "ours"], stdin=subprocess.PIPE,
                                  stdout=subprocess.PIPE, text=True)
        stack.callback(raggio.wait)
        stack.callback(raggio.stdin.close)
        device = raggio.stdout.readline().strip()

        def ours(_):
            raggio.stdin.write("\n")
            raggio.stdin.flush()
            return {"seconds": float(raggio.stdout.readline())}

        figures = interleaved(options.rounds, {"raggio": ours, "embree": lambda _: embree.ask("trace")})
        a, b = (numpy.fromfile(folder / name, "<f4") for name in ("ours", "theirs"))
    # Rays that graze edges may meet another triangle; many that differ would be other rays.
    agree = float(numpy.mean(numpy.isclose(a, b, rtol=1e-3, atol=1e-4)))
    if agree < 0.999:
        raise AssertionError(f"raggio and Embree agree about {100 * agree:.2f} % of the rays alone")
    ratios = [b["seconds"] / a["seconds"] for a, b in zip(figures["raggio"], figures["embree"])]
    rates = {who: statistics.median(rays / f["seconds"] / 1e6 for f in found) for who, found in figures.items()}
    return [row("rays/s of bounces in rock over Embree", ratios)], {
        "rays": rays, "agree": agree, "device": device, "mrays_per_second": rates, "figures": figures}


def start(options, available):
    """Seconds from the start of a process to its first picture, with what systems and drivers keep already there."""
    file, size = scene_file("rock"), (256, 256)
    say("seconds to the first picture: rock, 256x256, 1 sample")
    with tempfile.TemporaryDirectory() as folder:
        picture = pathlib.Path(folder) / "picture.exr"

        def run(command):
            picture.unlink(missing_ok=True)
            figures = project.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            assert picture.exists(), f"{command} wrote no picture"
            return figures

        ready = {"raggio": lambda _: run([project.RAGGIO, "render", file, "--size", "256x256", "--samples", "1", "--quiet",
                                          "--device", "cpu", "-o", picture])}
        for name in available:
            if name != "embree":
                ready[name] = lambda _, name=name: run(peers.command(name, file, *size, 1, picture))
        figures = interleaved(options.rounds, ready)
    rows = []
    for name in ready:
        if name != "raggio":
            ratios = [b["seconds"] / a["seconds"] for a, b in zip(figures["raggio"], figures[name])]
            rows.append(row(f"first picture sooner than {name}", ratios))
    return rows, {"seconds": {who: statistics.median(f["seconds"] for f in found) for who, found in figures.items()},
                  "figures": figures}


def growth(options, available):
    """Growth of the time of a sample from the mesh of level 7 to a finer one."""
    finer = options.level
    names = [name for name in ("mitsuba llvm", "cycles") if name in available]
    size, samples = (1024, 1024), max(1, 2 // options.shrink)
    say(f"growth from rock 7 to {finer}, {size[0]}x{size[1]}, {samples} samples")
    with contextlib.ExitStack() as stack:
        ready = {}
        for level in (7, finer):
            made = contestants(stack, scene_file("rock", level), size, samples, names)
            ready |= {f"{who}, level {level}": draw for who, draw in made.items()}
        figures = interleaved(options.rounds, ready)
    grown = {who: [b["seconds"] / a["seconds"] for a, b in
                   zip(figures[f"{who}, level 7"], figures[f"{who}, level {finer}"])] for who in ("raggio", *names)}
    rows = [row(f"time of a sample grows from rock 7 to {finer}: {who}", ratios) | {"plain": True}
            for who, ratios in grown.items()]
    return rows, {"levels": [7, finer], "figures": figures}


MEASURES = {"rates": rates, "efficiency": efficiencies, "traversal": traversal, "start": start, "growth": growth}
