"""The program ``raggio`` on a machine of a cluster: frames of an animation, and what becomes of them."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .. import _errors, _raggio

#: Errors by the program's exit statuses.
ERRORS = {2: _errors.SceneError, 3: _errors.DeviceError}


@dataclass(frozen=True)
class Frames:
    """Frames that the program renders, and the files that it makes of each."""

    #: Canonical path of the scene or model.
    scene: str
    #: Whether the scene is a text, which names others, and not a model.
    is_text: bool
    #: Options of the program, but for frames, threads and files.
    options: tuple[str, ...]
    #: Options that name files, and the files' names with a row of ``#`` for the number.
    outputs: tuple[tuple[str, str], ...]
    threads: int | None


def run_frames(
    frames: Frames, scene: str, numbers: list[int], threads: int | None
) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Renders frames, and returns their files by the names that they are to have."""
    begun = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="raggio-") as folder:
        command = ["render", scene, "--frames", ",".join(map(str, numbers)), *frames.options]
        command += ["--no-checkpoint", "--quiet", *(["--threads", str(threads)] if threads else [])]
        for place, (option, name) in enumerate(frames.outputs):
            os.mkdir(os.path.join(folder, str(place)))
            command += [option, os.path.join(folder, str(place), os.path.basename(name))]
        _run(command)
        files = {}
        for place, (_, name) in enumerate(frames.outputs):
            for made in sorted(Path(folder, str(place)).iterdir()):
                files[os.path.join(os.path.dirname(name), made.name)] = made.read_bytes()
        return {"seconds": time.monotonic() - begun}, files


def _run(arguments: list[str]) -> None:
    """Runs the program, which ends with this process, however this one ends."""
    command = [sys.executable, "-m", __name__, *arguments]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        told = process.stderr.read().strip()
        status = process.wait()
    if status != 0:
        sentence = told.splitlines()[-1].removeprefix("error: ") if told else f"raggio has ended with status {status}"
        raise ERRORS.get(status, _errors.InternalError)(sentence)


def main() -> int:
    """Runs the program until it is done, or nobody waits for it any more."""

    def watch() -> None:
        # Not by Python's own reader, whose lock would be missed at the end.
        while os.read(0, 4096):
            pass
        os._exit(130)

    threading.Thread(target=watch, daemon=True).start()
    return _raggio.main(["raggio", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
