"""What ``raggio render --cluster`` runs: an order comes as a line of JSON, and lines of JSON tell how it goes.

The end of standard input is the wish to stop.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from pathlib import Path
from typing import Any

from .. import _raggio
from .._errors import Error, InternalError
from .._scene import Scene
from ._connect import connected
from ._crew import Crew
from ._files import Manifest, hash_of, write_whole
from ._jobs import Pictures
from ._program import Frames
from ._render import STORE, FilmRender, until_empty
from ._worker import Order


def main() -> int:
    """Does what the order on standard input says."""
    # What Ray says is not for the program.
    lines = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)

    def tell(**line: Any) -> None:
        print(json.dumps(line), file=lines, flush=True)

    order = json.loads(sys.stdin.buffer.readline())
    stops = threading.Event()

    def watch() -> None:
        # Not by Python's own reader, whose lock would be missed at the end.
        while os.read(0, 4096):
            pass
        stops.set()

    threading.Thread(target=watch, daemon=True).start()
    try:
        (_frames if "frames" in order else _film)(order, stops, tell)
    except Error as error:
        tell(error=[type(error).__name__, str(error)])
    except Exception as error:
        tell(error=[InternalError.__name__, f"raggio has a fault of its own, please report it: {error!r}"])
    return 0


def _scene(sent: dict[str, Any]) -> tuple[Scene, Manifest]:
    """The scene that the program has read, and the files that it is made of."""
    path = Path(sent["path"])
    # The program has its own numbers of shapes.
    many = 2**31
    text = _raggio.SceneText.restored(
        text=sent["text"],
        path=str(path),
        allow_outside=sent["allow_outside"],
        time_seconds=sent["time_seconds"],
        numbers=(0, many, many, []),
        placed={},
        meshes={},
        images={},
    )
    scene = Scene.__new__(Scene)
    scene._start(text, path)
    scene._name = sent["name"]
    return scene, Manifest.named_in(text, scene._folder, {file: hash_of(file) for file in sent["files"]})


def _film(order: dict[str, Any], stops: threading.Event, tell: Any) -> None:
    """Gathers the film of one picture."""
    scene, manifest = _scene(order["scene"])
    for key, value in order["render"].items():
        scene._text.set(["render", key], value)
    work = Order(
        manifest,
        device=order["device"],
        tracer=order["tracer"],
        threads=order["threads"],
        integrator=order["integrator"],
        films=True,
    )
    render = FilmRender(
        scene,
        work,
        tuple(order["samples"]),
        order["address"],
        order["time_limit"],
        warn=lambda sentence: tell(warning=sentence),
    )
    is_told = False

    def report(fraction: float, samples: int, seconds: float) -> None:
        nonlocal is_told
        if render.resumed and not is_told:
            is_told = True
            tell(resumed=render.resumed, samples=samples)
        if fraction > 0:
            tell(progress=[fraction, samples, seconds])

    try:
        render.run(order["film"], order["every"], order["resume"], None, 1.0, report, stops.is_set)
    finally:
        tell(done={"seconds": render.seconds, "devices": render.devices, "film": render.film is not None})


def _frames(order: dict[str, Any], stops: threading.Event, tell: Any) -> None:
    """Has frames rendered, and writes their files."""
    sent = order["scene"]
    scene, manifest = _scene(sent)
    frames = Frames(
        sent["path"], sent["is_text"], tuple(order["options"]), tuple(map(tuple, order["outputs"])), order["threads"]
    )
    # The program reads the file itself.
    hashes = {**manifest.hashes, sent["path"]: hash_of(sent["path"])}
    work = Order(Manifest(hashes, manifest.named), device=order["device"], threads=order["threads"], frames=frames)
    with connected(order["address"], logs=False, store_bytes=STORE) as ray:
        crew = Crew(ray, scene, work, lambda sentence: tell(warning=sentence))
        job = Pictures(crew, "frames", order["frames"], bundled=True)
        try:
            for _ in until_empty(crew, job):
                for places, _, made in job.take_made():
                    for path, contents in made.items():
                        write_whole(path, contents)
                        tell(say=f"wrote {path}")
                    for place in places:
                        tell(frame=order["frames"][place])
                if stops.is_set():
                    return
        finally:
            crew.close()


if __name__ == "__main__":
    sys.exit(main())
