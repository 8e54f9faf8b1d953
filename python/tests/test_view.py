"""The live view: what the mouse does to cameras, and all of it in JupyterLab under a browser without a screen."""

from __future__ import annotations

import dataclasses
import json
import os
import shutil
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request

import numpy as np
import pytest
from conftest import FRONT, lit

import raggio as rg

pytest.importorskip("anywidget", reason="views need anywidget: pip install 'raggio[notebook]'")

CELLS = [
    """
import raggio as rg
scene = rg.Scene()
scene.environment = rg.Environment(horizon=(1, 1, 1), zenith=(0.2, 0.4, 1))
scene.materials["clay"] = rg.Material(color=(0.8, 0.3, 0.2))
scene.add(rg.Sphere((0, 0, 0), 1), material="clay")
scene.add(rg.Box((1.5, 0, 0), (1, 1, 1)), material=rg.Material(color=(0.2, 0.6, 0.3)))
camera = rg.Camera.look_at((0, 1, 6), (0, 0, 0))
""",
    """
view = rg.view(scene, camera, size=(240, 160), samples=500, device="cpu")
view
""",
]


def at(camera: rg.Camera) -> np.ndarray:
    return np.array(camera.position)


def test_moves() -> None:
    from raggio._view import MOVES

    turned = MOVES["orbit"](FRONT, 0.5, 0)
    np.testing.assert_allclose(at(turned), (-4, 0, 0), atol=1e-12)
    above = MOVES["orbit"](FRONT, 0, 0.25)
    np.testing.assert_allclose(at(above), (0, 4 * np.sqrt(0.5), 4 * np.sqrt(0.5)), atol=1e-12)
    # No drag goes over the top.
    assert 3.99 < at(MOVES["orbit"](above, 0, 5))[1] < 4
    # What is at the target's distance stays under the mouse.
    shifted = MOVES["pan"](FRONT, 0.5, 0.5)
    half = 4 * np.tan(np.radians(FRONT.vfov_degrees / 2))
    np.testing.assert_allclose(at(shifted), (-half, half, 4))
    np.testing.assert_allclose(shifted.target, (-half, half, 0))
    np.testing.assert_allclose(at(MOVES["dolly"](FRONT, 0, -800)), (0, 0, 4 / np.e))
    # So it does where intrinsics say how much is seen; a panorama goes as far as a picture of 90 degrees.
    focal = 50 / np.tan(np.radians(FRONT.vfov_degrees / 2))
    K = [[focal, 0, 50], [0, focal, 50], [0, 0, 1]]
    pose = FRONT.world_from_camera(convention="opengl")
    measured = rg.Camera.from_matrix(pose, K=K, size=(100, 100), convention="opengl")
    measured = dataclasses.replace(measured, target=FRONT.target)
    np.testing.assert_allclose(at(MOVES["pan"](measured, 0.5, 0.5)), (-half, half, 4), rtol=1e-6)
    panorama = rg.Camera.look_at((0, 0, 4), (0, 0, 0), panorama="latitude-longitude")
    np.testing.assert_allclose(at(MOVES["pan"](panorama, 0, 0.5)), (0, 4, 4), rtol=1e-12)
    parallel = rg.Camera.look_at((0, 0, 4), (0, 0, 0), orthographic_height=2)
    assert MOVES["dolly"](parallel, 0, 800).orthographic_height == pytest.approx(2 * np.e)


def test_needs_samples() -> None:
    with pytest.raises(ValueError, match="samples is 0"):
        rg.view(lit(), FRONT, samples=0)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@pytest.fixture
def lab(tmp_path):
    """JupyterLab with a notebook of the cells above; its address."""
    pytest.importorskip("jupyterlab", reason="the view is tested in JupyterLab: pip install jupyterlab")
    cells = [
        {"cell_type": "code", "id": f"c{i}", "metadata": {}, "source": source, "outputs": [], "execution_count": None}
        for i, source in enumerate(CELLS)
    ]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    notebook = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    (tmp_path / "view.ipynb").write_text(json.dumps(notebook))
    port = free_port()
    # Settings are those of this test alone, and the kernel is that of this Python.
    homes = {f"JUPYTER_{name}_DIR": str(tmp_path / name) for name in ("CONFIG", "DATA", "RUNTIME")}
    path = os.pathsep.join([os.path.dirname(sys.executable), os.environ.get("PATH", "")])
    options = ["--no-browser", "--allow-root", "--expose-app-in-browser", f"--port={port}", "--IdentityProvider.token="]
    options += ["--LabApp.news_url=", "--LabApp.extension_manager=readonly", f"--ServerApp.root_dir={tmp_path}"]
    with open(tmp_path / "log", "w") as log:
        server = subprocess.Popen(
            [sys.executable, "-m", "jupyterlab", *options], stdout=log, stderr=log, env={**os.environ, **homes, "PATH": path}
        )
    address = f"http://127.0.0.1:{port}"
    for _ in range(240):
        try:
            urllib.request.urlopen(f"{address}/api", timeout=5).close()
            break
        except (urllib.error.URLError, OSError):
            assert server.poll() is None, (tmp_path / "log").read_text()
            time.sleep(0.25)
    yield f"{address}/lab/tree/view.ipynb"
    server.terminate()
    server.wait()


@pytest.fixture
def page(lab):
    """The notebook in a browser."""
    reason = "the view is tested in a browser by playwright: pip install playwright"
    api = pytest.importorskip("playwright.sync_api", reason=reason)
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if chromium is None:
        pytest.skip("the view is tested in a browser, and there is none: apt install chromium")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        page = browser.new_page(viewport={"width": 1000, "height": 900})
        page.set_default_timeout(30_000)
        page.goto(lab)
        page.wait_for_function(IDLE)
        yield page
        browser.close()


#: A kernel that waits for cells to run.
IDLE = "window.jupyterapp?.shell.currentWidget?.sessionContext?.session?.kernel?.status === 'idle'"


class Notebook:
    """What the test does in the page."""

    def __init__(self, page) -> None:
        self.page = page

    def command(self, name: str) -> None:
        # What it returns is not waited for: it ends with the cells.
        self.page.evaluate(f"void window.jupyterapp.commands.execute({name!r})")

    def ask(self, expression: str) -> str:
        """Value of an expression in the kernel, as a new last cell shows it."""
        before = self.page.locator(".jp-CodeCell").count()
        self.page.evaluate(
            """source => {
                const notebook = window.jupyterapp.shell.currentWidget.content;
                notebook.model.sharedModel.addCell({cell_type: "code", source});
                notebook.activeCellIndex = notebook.widgets.length - 1;
            }""",
            expression,
        )
        self.command("notebook:run-cell")
        output = self.page.locator(".jp-CodeCell").nth(before).locator(".jp-OutputArea-executeResult pre")
        output.wait_for()
        return output.inner_text()

    def data(self, name: str) -> int:
        return int(self.page.locator("img.raggio-view").last.get_attribute(f"data-{name}") or 0)

    def width(self) -> int:
        return self.page.locator("img.raggio-view").last.evaluate("image => image.naturalWidth")

    def wait(self, condition, seconds: float = 60.0) -> None:
        end = time.monotonic() + seconds
        while not condition():
            assert time.monotonic() < end, "nothing came of it"
            self.page.wait_for_timeout(20)

    def drag(self, box, *, by: tuple[int, int], steps: int) -> set[int]:
        """Drags the picture; the widths that it had meanwhile."""
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        widths = set()
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        for i in range(1, steps + 1):
            self.page.mouse.move(x + by[0] * i / steps, y + by[1] * i / steps)
            self.page.wait_for_timeout(30)
            widths.add(self.width())
        self.page.mouse.up()
        return widths


def test_in_jupyterlab(page) -> None:
    notebook = Notebook(page)
    notebook.command("notebook:run-all-cells")
    picture = page.locator("img.raggio-view")
    picture.wait_for()

    # Frames arrive, and the kernel answers meanwhile.
    notebook.wait(lambda: notebook.data("frame") > 1)
    assert notebook.data("samples") < 500
    began = time.monotonic()
    assert notebook.ask("view._thread.is_alive()") == "True"
    assert time.monotonic() - began < 10

    # It converges and then rests.
    notebook.wait(lambda: notebook.data("samples") == 500)
    assert notebook.width() == 240
    frame = notebook.data("frame")
    page.wait_for_timeout(1000)
    assert notebook.data("frame") == frame
    assert notebook.ask("view.image.samples, view._renderer.samples") == "(500, 500)"
    before = picture.screenshot(path=os.environ.get("RAGGIO_VIEW_PICTURE"))

    # A drag turns the camera, and the picture with it: pictures are whole at the end.
    notebook.ask("setattr(view, '_cost', 1.0) or 1")
    widths = notebook.drag(picture.bounding_box(), by=(60, 30), steps=30)
    notebook.wait(lambda: notebook.data("samples") == 500)
    assert min(widths) < 240 and notebook.width() == 240
    x, y, z = json.loads(notebook.ask("list(view.camera.position)"))
    assert x < -1 and y > 2 and x * x + y * y + z * z == pytest.approx(37, rel=1e-6)
    assert picture.screenshot() != before

    # So do the wheel and the right button; a double click goes back, to the same picture.
    page.mouse.wheel(0, -200)
    notebook.wait(lambda: notebook.ask("sum(x * x for x in view.camera.position) < 30") == "True")
    page.mouse.down(button="right")
    page.mouse.move(500, 300)
    page.mouse.up(button="right")
    notebook.wait(lambda: notebook.ask("view.camera.target != (0, 0, 0)") == "True")
    picture.dblclick()
    notebook.wait(lambda: notebook.ask("view.camera == camera") == "True")
    notebook.wait(lambda: notebook.data("samples") == 500)
    assert picture.screenshot() == before

    # An edit of the scene is seen.
    notebook.ask("scene.materials.update(clay=rg.Material(color=(0.1, 0.1, 0.9))) or 1")
    notebook.wait(lambda: picture.screenshot() != before)

    # A browser that takes half a second for a frame gets the newest, and none that waited in between.
    page.evaluate(
        """() => {
            window.seen = [];
            window.revoke = URL.revokeObjectURL;
            URL.revokeObjectURL = url => {
                for (const end = performance.now() + 500; performance.now() < end;);
                window.seen.push(Number(document.querySelector("img.raggio-view").dataset.samples));
                window.revoke.call(URL, url);
            };
        }"""
    )
    frame = notebook.data("frame")
    notebook.ask("setattr(view, 'samples', 4000) or 1")
    notebook.wait(lambda: notebook.data("samples") == 4000)
    frames = notebook.data("frame") - frame
    seen = page.evaluate("() => { URL.revokeObjectURL = window.revoke; return window.seen; }")
    assert seen[-1] == 4000 and len(seen) <= frames + 1
    # Each is of more samples than a step takes: there were pictures that nobody was sent.
    assert 3500 / frames > 1.5 * float(notebook.ask("0.15 / view._cost")), seen

    # A cell that runs again takes the first view off the page, which renders no more.
    notebook.ask("[first := view, setattr(first, 'samples', 10**6)][1] or 1")
    notebook.wait(lambda: notebook.data("samples") > 4000)
    page.evaluate("() => { window.jupyterapp.shell.currentWidget.content.activeCellIndex = 1; }")
    notebook.command("notebook:run-cell")
    notebook.wait(lambda: notebook.data("samples") == 500)
    assert notebook.ask("first._views, view._views") == "(0, 1)"
    before = notebook.ask("first._renderer.samples")
    page.wait_for_timeout(500)
    assert notebook.ask("first._renderer.samples") == before

    # A view that is closed has no thread.
    assert notebook.ask("view.close() or view._thread.is_alive()") == "False"
