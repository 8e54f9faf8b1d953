"""What users of renderers meet: leaks, threads, forks, signals, faults."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
from conftest import FRONT, SQUARE, lit, memory, render

import raggio as rg
from raggio import _raggio


def python(program: str, **environment: str) -> subprocess.CompletedProcess[str]:
    variables = {**os.environ, **environment}
    return subprocess.run([sys.executable, "-c", program], env=variables, text=True, capture_output=True, timeout=60)


def test_renders_do_not_leak() -> None:
    def once() -> None:
        scene = lit()
        scene.add(rg.Mesh(*SQUARE), material=rg.Principled(roughness=0.5))
        scene.environment = rg.Environment(image=np.ones((16, 32, 3), dtype=np.float32))
        image = render(scene, FRONT, size=(64, 64), samples=1, aovs=("depth", "normal", "object_id"))
        image.tonemap()

    for _ in range(30):
        once()
    gc.collect()
    before = memory()
    for _ in range(300):
        once()
    gc.collect()
    assert memory() - before < 8e6, "300 renders of 0.3 MB leave more than 8 MB"


def test_views_do_not_leak() -> None:
    scene = lit()
    scene.add(SQUARE)
    cameras = [rg.Camera.look_at((4 * np.sin(a), 1, 4 * np.cos(a)), (0, 0, 0)) for a in np.linspace(0, 6, 400)]
    for i, image in rg.render_many(
        scene, cameras, size=(64, 64), samples=4, device="cpu", aovs=("depth", "normal", "object_id")
    ):
        assert image.samples == 4
        if i == 50:
            before = memory()
    assert memory() - before < 8e6


def test_two_threads() -> None:
    scene = lit()
    scene.add(rg.Sphere((0, 0, 0), 1))
    seeds = (1, 2, 3, 4)
    alone = {seed: np.asarray(render(scene, FRONT, size=(48, 48), samples=16, seed=seed)) for seed in seeds}
    together: dict[int, np.ndarray] = {}

    def work(seed: int) -> None:
        own = lit()
        own.add(rg.Sphere((0, 0, 0), 1))
        # A scene of its own, and one that all share.
        for shown in (own, scene):
            together[seed] = np.asarray(render(shown, FRONT, size=(48, 48), samples=16, seed=seed))
            np.testing.assert_array_equal(together[seed], alone[seed])

    threads = [threading.Thread(target=work, args=(seed,)) for seed in seeds]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    for seed in seeds:
        np.testing.assert_array_equal(together[seed], alone[seed])


def test_one_renderer_in_two_threads() -> None:
    renderer = rg.Renderer(lit(), FRONT, size=(32, 32), device="cpu")
    failures: list[BaseException] = []

    def work() -> None:
        try:
            for _ in range(10):
                renderer.step(1)
                renderer.image
        except BaseException as failure:
            failures.append(failure)

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    assert not failures


def test_the_lock_is_released() -> None:
    """Another thread of Python runs while a picture is rendered."""
    ticks = 0
    done = threading.Event()

    def tick() -> None:
        nonlocal ticks
        while not done.wait(0.005):
            ticks += 1

    thread = threading.Thread(target=tick)
    thread.start()
    render(lit(), FRONT, size=(128, 128), time_limit=0.5)
    done.set()
    thread.join()
    assert ticks > 10


def child(work) -> int:
    """Exit status of a forked child that does `work`."""
    sys.stdout.flush()
    pid = os.fork()
    if pid == 0:
        status = 1
        try:
            work()
            status = 0
        finally:
            os._exit(status)
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        found, status = os.waitpid(pid, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.kill(pid, signal.SIGKILL)
    os.waitpid(pid, 0)
    raise AssertionError("the child hangs")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_forks() -> None:
    """Children render, whether their parent has rendered before or not, and cannot use its renderers."""
    program = (
        "import os, raggio as rg\npid = os.fork()\n"
        "s = rg.Scene(); s.environment = rg.Environment(color=(1, 1, 1))\n"
        "rg.render(s, rg.Camera.look_at((0, 0, 4), (0, 0, 0)), size=(8, 8), samples=1, device='cpu')\n"
        "if pid: raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))\n"
    )
    assert python(program).returncode == 0
    scene = lit()
    scene.add(SQUARE)
    expected = np.asarray(render(scene, FRONT, size=(16, 16), samples=2))
    renderer = rg.Renderer(scene, FRONT, size=(8, 8), device="cpu")

    def work() -> None:
        again = lit()
        again.add(SQUARE)
        np.testing.assert_array_equal(render(again, FRONT, size=(16, 16), samples=2), expected)
        with pytest.raises(RuntimeError, match="before the process was forked"):
            renderer.step()

    assert child(work) == 0
    # The parent goes on.
    renderer.step()
    np.testing.assert_array_equal(render(scene, FRONT, size=(16, 16), samples=2), expected)


def test_import_without_display_or_driver() -> None:
    program = (
        "import raggio as rg\n"
        "s = rg.Scene(); s.environment = rg.Environment(color=(1, 1, 1))\n"
        "i = rg.render(s, rg.Camera.look_at((0, 0, 4), (0, 0, 0)), size=(8, 8), samples=1)\n"
        "assert 'cpu' in i.device, i.device\n"
    )
    done = python(program, DISPLAY="", WAYLAND_DISPLAY="", VK_DRIVER_FILES="/none", VK_ICD_FILENAMES="/none")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""


def interrupt_after(seconds: float) -> None:
    threading.Timer(seconds, lambda: os.kill(os.getpid(), signal.SIGINT)).start()


def test_interrupts_keep_what_there_is() -> None:
    scene = lit()
    scene.add(rg.Sphere((0, 0, 0), 1))
    start = time.monotonic()
    interrupt_after(0.5)
    with pytest.raises(rg.Interrupted) as caught:
        render(scene, FRONT, size=(256, 256), samples=10**7, aovs="depth")
    assert isinstance(caught.value, KeyboardInterrupt) and time.monotonic() - start < 5
    image = caught.value.image
    assert not image.finished and image.shape == (256, 256, 3) and np.asarray(image).mean() > 0.5
    assert np.isfinite(image["depth"]).any()


def test_interrupted_steps_go_on() -> None:
    renderer = rg.Renderer(lit(), FRONT, size=(128, 128), device="cpu")
    interrupt_after(0.3)
    with pytest.raises(KeyboardInterrupt):
        renderer.step(10**7)
    assert np.asarray(renderer.image).mean() > 0.9


def test_other_signals_end_it_too() -> None:
    def late(number: int, frame: object) -> None:
        raise TimeoutError("too late")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        with pytest.raises(TimeoutError) as caught:
            render(lit(), FRONT, size=(128, 128), samples=10**7)
    finally:
        signal.signal(signal.SIGALRM, before)
    assert caught.value.image.shape == (128, 128, 3)  # type: ignore[attr-defined]


def test_faults_are_exceptions(capfd) -> None:
    with pytest.raises(rg.InternalError, match="please report it: .*a fault on purpose"):
        _raggio.panic_for_tests()
    assert issubclass(rg.InternalError, rg.Error) and issubclass(rg.Error, Exception)
    assert capfd.readouterr().err == ""
    assert render(lit(), FRONT, size=(4, 4), samples=1).finished


def test_crops_cost_no_more_than_themselves() -> None:
    """A small picture of a scene takes a small part of a large one's time."""
    scene = lit()
    scene.add(rg.Sphere((0, 0, 0), 1))
    large = render(scene, FRONT, size=(256, 256), samples=16).rays
    small = render(scene, FRONT, size=(16, 16), samples=16).rays
    assert small < large / 200
