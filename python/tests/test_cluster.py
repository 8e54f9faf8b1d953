"""Renders on several machines: whatever becomes of them, the picture is that of one."""

from __future__ import annotations

import json
import os
import secrets
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from conftest import FILE, FRONT, SQUARE, lit

import raggio as rg

# Ray reads it when it is imported. Nobody but these tests gets into their cluster.
os.environ.update(RAY_AUTH_MODE="token", RAY_AUTH_TOKEN=secrets.token_hex(16))
pytest.importorskip("ray", reason="Ray is not installed: pip install 'raggio[cluster]'")

import raggio.cluster
from raggio.cluster import _crew, _files, _jobs
from raggio.cluster._connect import ray_module
from raggio.cluster._jobs import Ledger
from raggio.cluster._program import Frames
from raggio.cluster._worker import Order, Worker

pytestmark = [
    # Ray's own: sockets and files of processes that were killed, and what it says of its future.
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::FutureWarning"),
    # Where others keep this machine busy.
    pytest.mark.filterwarnings("ignore:no machine of the cluster takes part:raggio.SceneWarning"),
]

SIZE = (96, 64)
ANIMATED = FILE.replace(
    "vertical_fov_degrees = 40\n",
    "vertical_fov_degrees = 40\nkeyframes = [{ time = 0, position = [0, 1, 4] }, { time = 1, position = [4, 1, 0] }]\n",
)


class Machines:
    """A cluster of processes on this machine, whose head does no work."""

    def __init__(self) -> None:
        self.ray = ray_module()
        from ray.cluster_utils import Cluster

        head = {"num_cpus": 0, "include_dashboard": False, "object_store_memory": 150 << 20}
        self.cluster = Cluster(initialize_head=True, head_node_args=head)
        self.nodes: list = []

    def add(self, **options) -> None:
        self.nodes.append(self.cluster.add_node(num_cpus=1, object_store_memory=100 << 20, **options))

    def kill(self) -> None:
        """Kills the machine that was added first."""
        self.cluster.remove_node(self.nodes.pop(0), allow_graceful=False)

    def at_least(self, count: int) -> None:
        while len(self.nodes) < count:
            self.add()

    def end(self) -> None:
        self.ray.shutdown()
        self.cluster.shutdown()


@pytest.fixture(scope="module")
def machines() -> Iterator[Machines]:
    machines = Machines()
    yield machines
    machines.end()


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> rg.Scene:
    path = tmp_path_factory.mktemp("scene") / "scene.toml"
    path.write_text(FILE)
    return rg.load(path)


@pytest.fixture
def short_tasks(monkeypatch) -> None:
    """Tasks of a second, so that a render of seconds has many."""
    monkeypatch.setattr(_jobs, "SHORTEST", 1.0)


def on(machines: Machines, scene: rg.Scene, samples: int, **options) -> rg.Image:
    options = {"size": SIZE, "device": "cpu", "address": machines.cluster.address, "progress": False, **options}
    return rg.cluster.render(scene, samples=samples, **options)


def alone(scene: rg.Scene, samples: int, **options) -> rg.Image:
    return rg.render(scene, samples=samples, **{"size": SIZE, "device": "cpu", **options})


def meanwhile(work: Callable[[], None]) -> threading.Thread:
    thread = threading.Thread(target=work)
    thread.start()
    return thread


def samples_for(seconds: float, scene: rg.Scene) -> int:
    """Samples that take two workers of one core about so long."""
    took = alone(scene, 500, threads=1).seconds
    return int(seconds * 2 * 500 / took)


# ---- Accounts


def test_ledger() -> None:
    ledger = Ledger((0, 10), [(3, 5), (8, 10)])
    assert ledger.left == 6
    assert ledger.take(2) == (0, 2)
    assert ledger.take(9) == (2, 3)
    ledger.give_back((0, 2))
    assert [ledger.take(9) for _ in range(2)] == [(0, 2), (5, 8)]
    assert ledger.left == 0


# ---- The picture of one machine


def test_local_without_a_cluster(tmp_path) -> None:
    """In a process of its own, which is connected to nothing before and after."""
    (tmp_path / "scene.toml").write_text(FILE)
    program = (
        "import raggio as rg, raggio.cluster, ray, numpy as np\n"
        "scene = rg.load('scene.toml')\n"
        "image = rg.cluster.render(scene, samples=64, device='cpu', address='local', progress=False)\n"
        "assert np.array_equal(image, rg.render(scene, samples=64, device='cpu')), 'another picture'\n"
        "assert image.finished and image.samples == 64 and not ray.is_initialized()\n"
        "image.save('cluster.exr')\n"
    )
    environment = {**os.environ, "HOME": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=180
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_one_picture(machines: Machines, scene: rg.Scene, tmp_path, short_tasks) -> None:
    machines.at_least(2)
    told: list[float] = []
    seen: list[rg.Image] = []

    def progress(fraction: float, samples: int, seconds: float) -> None:
        told.append(fraction)

    samples = samples_for(4, scene)
    image = on(machines, scene, samples, alpha=True, aovs=("depth",), progress=progress, preview=seen.append,
               preview_every=0.5)  # fmt: skip
    expected = alone(scene, samples, alpha=True, aovs=("depth",))
    assert np.array_equal(image, expected) and np.array_equal(image["depth"], expected["depth"])
    assert told == sorted(told) and told[-1] == 1 and len(told) > 4
    assert len(seen) > 2 and seen[0].samples < seen[-1].samples == samples
    image.save(tmp_path / "a.exr")
    expected.save(tmp_path / "b.exr")
    assert (tmp_path / "a.exr").read_bytes() == (tmp_path / "b.exr").read_bytes()


def test_scenes_in_memory(machines: Machines) -> None:
    machines.at_least(1)
    scene = lit()
    image = np.random.default_rng(0).random((8, 16, 3), dtype=np.float32)
    scene.add(SQUARE, material=rg.Principled(base_color_texture=(255 * image).astype(np.uint8)), transform=np.eye(4))
    scene.add(SQUARE, material=rg.Material(color=(1, 0, 0)), transform=np.diag([0.5, 0.5, 1, 1]) + 0, id=9)
    scene.environment = rg.Environment(image=image)
    scene.camera = FRONT
    assert np.array_equal(on(machines, scene, 16), alone(scene, 16))


def test_moments(machines: Machines, tmp_path) -> None:
    """The scene moves to the moment that is asked for, and stays as it is here."""
    machines.at_least(1)
    (tmp_path / "moving.toml").write_text(ANIMATED)
    scene = rg.load(tmp_path / "moving.toml")
    image = on(machines, scene, 4, time=0.5)
    assert np.array_equal(image, alone(scene, 4, time=0.5))
    assert not np.array_equal(image, alone(scene, 4)) and scene.time is None


def test_many_cameras(machines: Machines, scene: rg.Scene, tmp_path) -> None:
    machines.at_least(2)
    cameras = [rg.Camera.look_at((x, 1, 4), (0, 1, 0)) for x in range(7)]
    options = {"size": SIZE, "samples": 8, "aovs": ("object_id", "depth"), "device": "cpu"}
    found = dict(rg.cluster.render(scene, cameras, address=machines.cluster.address, progress=False, **options))
    assert sorted(found) == list(range(7))
    for place, expected in rg.render_many(scene, cameras, **options):
        assert np.array_equal(found[place], expected)
        assert np.array_equal(found[place]["object_id"], expected["object_id"])
        assert found[place].samples == 8
    found[0].save(tmp_path / "a.exr")
    next(iter(rg.render_many(scene, cameras, **options)))[1].save(tmp_path / "b.exr")
    assert (tmp_path / "a.exr").read_bytes() == (tmp_path / "b.exr").read_bytes()


def test_films_are_added_up_elsewhere(machines: Machines, scene: rg.Scene, monkeypatch) -> None:
    """As where one machine cannot add all that come."""
    machines.at_least(2)
    monkeypatch.setattr(_jobs, "SHORTEST", 0.02)
    monkeypatch.setattr(_jobs, "LAST", 0.01)
    monkeypatch.setattr(_jobs, "PORTION", 0.01)
    monkeypatch.setattr(_jobs, "FAN_IN", 2)
    monkeypatch.setattr(_jobs, "FETCHES", 1)
    sums: list[int] = []
    add = _jobs.Samples._sum
    monkeypatch.setattr(_jobs.Samples, "_sum", lambda job, parts: (sums.append(len(parts)), add(job, parts)))
    waiting: list[int] = []
    absorb = _jobs.Samples.absorb

    def absorb_late(job: _jobs.Samples) -> None:
        # However fast this machine is: it looks when more has come than it can add.
        if len(job._waiting) > 2 or job._crew.is_idle:
            absorb(job)
            waiting.append(len(job._waiting))

    monkeypatch.setattr(_jobs.Samples, "absorb", absorb_late)
    samples = samples_for(3, scene)
    assert np.array_equal(on(machines, scene, samples), alone(scene, samples))
    assert sums and max(waiting) < 2


def test_preview_in_a_notebook(machines: Machines, scene: rg.Scene, monkeypatch, short_tasks) -> None:
    display = pytest.importorskip("IPython.display", reason="IPython is not installed")
    machines.at_least(1)
    shown: list[bytes] = []

    class Handle:
        def update(self, image: rg.Image) -> None:
            shown.append(image._repr_png_())

    def show(image: rg.Image, *, display_id: bool) -> Handle:
        assert display_id and not shown
        shown.append(image._repr_png_())
        return Handle()

    monkeypatch.setattr(display, "display", show)
    samples = samples_for(2, scene)
    image = on(machines, scene, samples, preview=True, preview_every=0.3)
    assert len(shown) > 1 and shown[-1] == image._repr_png_() != shown[0]


def test_preview_in_a_file(machines: Machines, scene: rg.Scene, tmp_path) -> None:
    machines.at_least(1)
    image = on(machines, scene, 16, preview=tmp_path / "look.png")
    image.save(tmp_path / "image.png")
    assert (tmp_path / "look.png").read_bytes() == (tmp_path / "image.png").read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


# ---- Machines that come, go and hang


def test_ten_machines_are_killed(machines: Machines, scene: rg.Scene, short_tasks) -> None:
    """One after another in the middle of a render, while others join."""
    samples = samples_for(4, scene)
    expected = alone(scene, samples)
    for number in range(10):
        machines.at_least(2)

        def kill(seconds: float = 1.5 + 0.2 * number) -> None:
            time.sleep(seconds)
            machines.kill()

        begun = time.monotonic()
        killing = meanwhile(kill)
        image = on(machines, scene, samples)
        assert killing.is_alive() is False, f"the render took {time.monotonic() - begun:.1f} s, and nothing was killed"
        killing.join()
        assert image.samples == samples and np.array_equal(image, expected), f"kill {number}"


def test_a_machine_joins(machines: Machines, scene: rg.Scene, short_tasks) -> None:
    while len(machines.nodes) > 1:
        machines.kill()
    machines.at_least(1)
    samples = samples_for(8, scene)

    # Ray starts machines in the main thread alone, which the render is in as well.
    def join(fraction: float, taken: int, seconds: float) -> None:
        if taken and len(machines.nodes) == 1:
            machines.add()

    image = on(machines, scene, samples, progress=join)
    assert np.array_equal(image, alone(scene, samples))
    assert image.device.startswith("2 machines")


def test_all_machines_are_lost(machines: Machines, scene: rg.Scene, short_tasks) -> None:
    machines.at_least(1)

    replaced: list[int] = []

    def replace(fraction: float, samples: int, seconds: float) -> None:
        if samples and not replaced:
            replaced.append(samples)
            while machines.nodes:
                machines.kill()
            machines.add()

    samples = samples_for(4, scene)
    image = on(machines, scene, samples, progress=replace)
    assert replaced and replaced[0] < samples
    assert np.array_equal(image, alone(scene, samples))


def workers() -> list[int]:
    """Processes of this machine's workers."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and (entry / "cmdline").read_bytes().startswith(b"ray::Worker"):
                found.append(int(entry.name))
        except OSError:
            pass
    return found


@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked for in /proc")
def test_a_worker_hangs(machines: Machines, scene: rg.Scene, short_tasks) -> None:
    machines.at_least(2)
    stopped: list[int] = []

    def stop(fraction: float, samples: int, seconds: float) -> None:
        if samples and not stopped:
            stopped.append(workers()[0])
            os.kill(stopped[0], signal.SIGSTOP)

    samples = samples_for(5, scene)
    try:
        image = on(machines, scene, samples, progress=stop)
    finally:
        for process in stopped:
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
    assert stopped and np.array_equal(image, alone(scene, samples))


# ---- Breaks


DRIVER = """
import sys
import raggio as rg, raggio.cluster
from raggio.cluster import _jobs
_jobs.SHORTEST = 0.5
rg.cluster.render(
    rg.load("scene.toml"), samples=int(sys.argv[2]), size=(96, 64), device="cpu", address=sys.argv[1],
    progress=lambda fraction, samples, seconds: print(samples, flush=True), checkpoint="kept.film",
    checkpoint_every=0.5, resume=True,
)
"""


def test_the_driver_is_killed(machines: Machines, scene: rg.Scene, tmp_path) -> None:
    machines.at_least(2)
    (tmp_path / "scene.toml").write_text(FILE)
    samples = samples_for(8, scene)
    command = [sys.executable, "-c", DRIVER, machines.cluster.address, str(samples)]
    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as driver:
        while not (tmp_path / "kept.film").exists():
            assert driver.stdout is not None and driver.stdout.readline(), "it has ended"
        driver.kill()
    had = rg._raggio.Film.load(str(tmp_path / "kept.film")).ranges
    assert had and had != [(0, samples)]
    first: list[int] = []
    image = on(
        machines, scene, samples, checkpoint=tmp_path / "kept.film", resume=True, progress=lambda *at: first.append(at[1])
    )
    assert first[0] >= sum(end - begin for begin, end in had)
    assert np.array_equal(image, alone(scene, samples))
    # What is whole is not rendered again, and is compared with the scene.
    image = on(machines, scene, samples, checkpoint=tmp_path / "kept.film", resume=True)
    assert np.array_equal(image, alone(scene, samples))
    other = scene.copy()
    other.environment = rg.Environment(color=(1, 0, 0))
    with pytest.raises(rg.SceneError, match="another scene"):
        on(machines, other, samples, checkpoint=tmp_path / "kept.film", resume=True)
    with pytest.raises(rg.SceneError, match="cannot go on from .*different scenes"):
        on(machines, other, 2 * samples, checkpoint=tmp_path / "kept.film", resume=True)
    with pytest.raises(rg.SceneError, match=f"has samples 0..{samples}, and 0..5 are"):
        on(machines, scene, 5, checkpoint=tmp_path / "kept.film", resume=True)


def test_time_limit(machines: Machines, scene: rg.Scene, tmp_path) -> None:
    machines.at_least(1)
    image = on(machines, scene, 10**8, time_limit=3.0, checkpoint=tmp_path / "kept.film")
    assert 1 < image.samples < 10**8 and 2 < image.seconds < 10 and not image.finished
    ranges = rg._raggio.Film.load(str(tmp_path / "kept.film")).ranges
    assert sum(end - first for first, end in ranges) == image.samples


def test_interrupted(machines: Machines, scene: rg.Scene, tmp_path, short_tasks) -> None:
    machines.at_least(1)

    def interrupt(fraction: float, samples: int, seconds: float) -> None:
        if samples:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(rg.Interrupted) as stopped:
        on(machines, scene, 10**8, progress=interrupt, checkpoint=tmp_path / "kept.film")
    assert stopped.value.image.samples >= 1
    assert (tmp_path / "kept.film").exists()


# ---- Files


def test_files_travel(machines: Machines, tmp_path, monkeypatch) -> None:
    """To machines that have others under the names."""
    machines.at_least(1)
    (tmp_path / "textures").mkdir()
    image = rg.render(lit(), FRONT, size=(8, 4), samples=1, device="cpu")
    image.save(tmp_path / "textures" / "sky.exr")
    text = FILE.replace("color = [0.7, 0.8, 1.0]", 'image = "textures/sky.exr"')
    (tmp_path / "scene.toml").write_text(text)
    scene = rg.load(tmp_path / "scene.toml")

    # The worker is on this very machine: before it looks for the file, there is another in its place.
    sky = tmp_path / "textures" / "sky.exr"
    contents = np.fromfile(sky, dtype=np.uint8)
    manifest = _files.Manifest.of(scene._text, scene._folder)
    assert list(manifest.hashes) == [str(sky)] and not manifest.missing()
    samples = samples_for(3, scene)
    expected = alone(scene, samples)
    start = _crew.Crew._start

    def start_without(crew, job, node) -> None:
        sky.write_bytes(b"something else")
        start(crew, job, node)

    monkeypatch.setattr(_crew.Crew, "_start", start_without)
    with pytest.raises(rg.SceneError, match="sky.exr has changed since the render began"):
        on(machines, scene, 8)
    contents.tofile(sky)
    sent: list[str] = []

    def read(path: str, wanted: str) -> np.ndarray:
        sent.append(path)
        return contents

    monkeypatch.setattr(_crew, "read", read)
    machines.at_least(2)
    assert np.array_equal(on(machines, scene, samples), expected)
    assert sent == [str(sky)], "it is read once for all machines"


def test_frames_whose_files_travel(tmp_path) -> None:
    """The program on a machine that does not have the scene."""
    (tmp_path / "scene.toml").write_text(ANIMATED)
    path = str(tmp_path / "scene.toml")
    scene = rg.load(path)
    frames = Frames(path, True, ("--samples=2",), (("-o", "out/a-##.png"),), None)
    order = Order(_files.Manifest({path: _files.hash_of(path)}, {}), device="cpu", frames=frames)
    contents = np.fromfile(path, dtype=np.uint8)
    (tmp_path / "scene.toml").rename(tmp_path / "elsewhere.toml")
    worker = Worker(1)
    assert worker.open(scene, order, []) == {"missing": [path]}
    assert "device" in worker.open(scene, order, [path], contents)
    told, files = worker.frames([2, 3])
    assert sorted(files) == ["out/a-02.png", "out/a-03.png"] and told["seconds"] > 0
    command = [sys.executable, "-m", "raggio", "render", "elsewhere.toml", "--frames", "2,3", "--samples", "2"]
    subprocess.run([*command, "--device", "cpu", "-o", "b-##.png"], cwd=tmp_path, check=True, capture_output=True)
    assert files["out/a-03.png"] == (tmp_path / "b-03.png").read_bytes()
    # What is wrong with it there is told in the program's sentence alone.
    scene._text.set(["environment", "color"], '"blue"')
    worker._scene = scene
    told, files = worker.frames([2])
    worker.close()
    kind, sentence = told["error"]
    assert kind == "SceneError" and "color" in sentence and "\n" not in sentence and files is None


# ---- Errors


def test_no_cluster(scene: rg.Scene) -> None:
    """In a process that is connected to none."""
    program = "import sys, raggio as rg, raggio.cluster\nrg.cluster.render(rg.load(sys.argv[1]), address=sys.argv[2])"
    path = str(scene._folder / "scene.toml")
    for address, sentence in (
        ("127.0.0.1:1", "no cluster at 127.0.0.1:1: Connection refused"),
        ("auto", "this machine is not part of a cluster"),
        ("ray://head:10001", "give HOST:PORT of its head"),
        ("head", "give HOST:PORT of its head, auto or local"),
    ):
        begun = time.monotonic()
        environment = {name: value for name, value in os.environ.items() if not name.startswith("RAY_")}
        done = subprocess.run(
            [sys.executable, "-c", program, path, address], env=environment, capture_output=True, text=True, timeout=60
        )
        if address == "auto" and "is not part" not in done.stderr:
            # The cluster of these tests is this machine's.
            assert "does not let this process in" in done.stderr, done.stderr
            continue
        assert sentence in done.stderr.splitlines()[-1], done.stderr
        assert time.monotonic() - begun < 30


def test_mistakes_come_before_the_cluster(scene: rg.Scene) -> None:
    for mistake, options in (
        ("samples is 0", {"samples": 0}),
        ("time_limit is -1", {"time_limit": -1.0}),
        ("no layer 'dept'", {"aovs": "dept"}),
        ("give checkpoint=", {"resume": True}),
        ("preview is for one picture", {"camera": [FRONT], "preview": "a.png"}),
    ):
        with pytest.raises(ValueError, match=mistake):
            rg.cluster.render(scene, address="127.0.0.1:1", **options)


def test_a_sentence_in_place_of_a_traceback(machines: Machines, scene: rg.Scene) -> None:
    machines.at_least(1)
    with pytest.raises(rg.DeviceError) as refused:
        on(machines, scene, 4, device="vulkan:77")
    assert "77" in str(refused.value) and "Traceback" not in str(refused.value)


def test_machines_with_another_raggio(machines: Machines, scene: rg.Scene, tmp_path) -> None:
    """They take no part, and are told of; where there are no others, that is the error."""
    package = Path(rg.__file__).parent
    (tmp_path / "other" / "raggio").mkdir(parents=True)
    for path in package.iterdir():
        (tmp_path / "other" / "raggio" / path.name).symlink_to(path)
    start = tmp_path / "other" / "raggio" / "__init__.py"
    start.unlink()
    start.write_text((package / "__init__.py").read_text() + '\n__version__ = "0.0.9"\n')
    machines.at_least(1)
    machines.add(env_vars={"PYTHONPATH": str(tmp_path / "other")})
    with pytest.warns(rg.SceneWarning, match=r"takes no part: it has raggio 0\.0\.9, and this is"):
        image = on(machines, scene, samples_for(4, scene))
    assert image.finished
    while len(machines.nodes) > 1:
        machines.kill()
    with pytest.raises(rg.cluster.ClusterError, match=r"it has raggio 0\.0\.9, and this is"):
        on(machines, scene, 4)
    machines.kill()


def test_machines_without_raggio(machines: Machines, scene: rg.Scene, tmp_path) -> None:
    (tmp_path / "raggio").mkdir()
    (tmp_path / "raggio" / "__init__.py").write_text("raise ModuleNotFoundError(\"No module named 'raggio'\")")
    while machines.nodes:
        machines.kill()
    machines.add(env_vars={"PYTHONPATH": str(tmp_path)})
    with pytest.raises(rg.cluster.ClusterError, match="it lacks raggio, or has another than this one"):
        on(machines, scene, 4)
    machines.kill()


# ---- The program


def program(folder: Path, machines: Machines, *arguments: str, **options) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "raggio", "render", "scene.toml", "--cluster", machines.cluster.address, *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120, **options)


def test_the_program(machines: Machines, tmp_path) -> None:
    machines.at_least(2)
    (tmp_path / "scene.toml").write_text(FILE)
    arguments = ("--samples", "3..40", "--sampler", "pcg", "--filter", "mitchell", "--clamp", "0.7", "--alpha",
                 "--integrator", "reference", "--aov", "depth,normal", "--seed", "5")  # fmt: skip
    done = program(tmp_path, machines, *arguments, "-o", "a.exr", "-o", "a.png", "-o", "a.film", "--stats", "a.json")
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr and "Ray" not in done.stderr and done.stdout == ""
    command = [sys.executable, "-m", "raggio", "render", "scene.toml", *arguments, "--device", "cpu", "-o", "b.exr"]
    subprocess.run([*command, "-o", "b.png", "-o", "b.film"], cwd=tmp_path, check=True, capture_output=True)
    for ending in ("exr", "png"):
        assert (tmp_path / f"a.{ending}").read_bytes() == (tmp_path / f"b.{ending}").read_bytes()
    assert json.loads((tmp_path / "a.json").read_text())["samples_per_pixel"] == 37
    assert not list(tmp_path.glob("*.checkpoint"))


def test_the_program_is_stopped(machines: Machines, scene: rg.Scene, tmp_path) -> None:
    machines.at_least(2)
    (tmp_path / "scene.toml").write_text(FILE)
    command = [sys.executable, "-m", "raggio", "render", "scene.toml", "--cluster", machines.cluster.address]
    command += ["--progress", "json", "-o", "a.png"]
    endless = [*command, "--samples", "100000000"]
    with subprocess.Popen(endless, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as running:
        assert running.stderr is not None
        for line in running.stderr:
            if json.loads(line).get("samples", 0) > 0:
                break
        running.send_signal(signal.SIGINT)
        told = [json.loads(line) for line in running.stderr.read().splitlines()]
    assert running.returncode == 130, told
    saved = "stopped by SIGINT: what there is is saved in a.png.checkpoint: the same command with --resume goes on from it"
    assert saved in [line.get("message") for line in told]
    assert (tmp_path / "a.png").exists() and (tmp_path / "a.png.checkpoint").exists()
    had = rg._raggio.Film.load(str(tmp_path / "a.png.checkpoint")).ranges
    most = had[-1][1]
    done = subprocess.run([*command, "--samples", str(most + 5), "--resume"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and "going on from a.png.checkpoint" in done.stderr, done.stderr
    assert not (tmp_path / "a.png.checkpoint").exists()
    subprocess.run(
        [sys.executable, "-m", "raggio", "render", "scene.toml", "--samples", str(most + 5), "-o", "b.png"],
        cwd=tmp_path,
        check=True,
        capture_output=True,
    )
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_frames(machines: Machines, tmp_path) -> None:
    machines.at_least(2)
    (tmp_path / "scene.toml").write_text(ANIMATED)
    (tmp_path / "out").mkdir()
    arguments = ("--frames", "1-9", "--samples", "4", "--aov", "motion", "-o", "out/a-##.exr", "--stats", "a-##.json")
    done = program(tmp_path, machines, *arguments)
    assert done.returncode == 0, done.stderr
    command = [sys.executable, "-m", "raggio", "render", "scene.toml", "--frames", "1-9", "--samples", "4"]
    subprocess.run([*command, "--aov", "motion", "-o", "b-##.exr"], cwd=tmp_path, check=True, capture_output=True)
    for frame in range(1, 10):
        assert (tmp_path / f"out/a-{frame:02}.exr").read_bytes() == (tmp_path / f"b-{frame:02}.exr").read_bytes()
        assert (tmp_path / f"a-{frame:02}.json").exists()
    (tmp_path / "out/a-05.exr").unlink()
    done = program(tmp_path, machines, *arguments)
    assert "frame 4 is done" in done.stderr and "1 frame on the cluster" in done.stderr, done.stderr
    assert (tmp_path / "out/a-05.exr").read_bytes() == (tmp_path / "b-05.exr").read_bytes()


def test_refusals_of_the_program(tmp_path) -> None:
    (tmp_path / "scene.toml").write_text(FILE)
    command = [sys.executable, "-m", "raggio", "render", "scene.toml", "-o", "a.png"]
    for arguments, environment, sentence in (
        (["--cluster", "local", "--noise", "0.1"], {}, "--noise judges the whole picture"),
        (["--cluster", "127.0.0.1:1"], {}, "no cluster at 127.0.0.1:1"),
        (["--cluster", "local"], {"RAGGIO_PYTHON": "/bin/false"}, "/bin/false has no raggio: `pip install 'raggio[cluster]"),
        (["--cluster", "local"], {"RAGGIO_PYTHON": "./none"}, "there is no ./none"),
    ):
        done = subprocess.run(
            [*command, *arguments], cwd=tmp_path, env={**os.environ, **environment}, capture_output=True, text=True
        )
        assert done.returncode == 2 and sentence in done.stderr, done.stderr
        assert done.stderr.count("error: ") == 1
        assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]
