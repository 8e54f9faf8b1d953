"""Jobs of render farms: what they make is what one machine makes."""

from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from conftest import FILE, ROOT

FARM = ROOT / "farm"
SAMPLES, PART = 10, 4

# The folder of the console scripts has raggio.
ENVIRONMENT = {**os.environ, "PATH": os.path.dirname(sys.executable) + os.pathsep + os.environ["PATH"]}


def run(*command: str | Path, **options) -> str:
    done = subprocess.run(
        [str(word) for word in command], env=ENVIRONMENT, text=True, capture_output=True, timeout=120, **options
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a scene whose name a shell would take apart, and the picture of it that one machine makes."""
    folder = tmp_path / "it's here"
    folder.mkdir()
    (folder / "scene.toml").write_text(FILE)
    run("raggio", "render", folder / "scene.toml", "--samples", str(SAMPLES), "-o", folder / "whole.exr")
    return folder


def openjd(*arguments: str | Path) -> str:
    if importlib.util.find_spec("openjd.cli") is None:
        pytest.skip("openjd-cli is not installed")
    return run(sys.executable, "-m", "openjd", *arguments)


@pytest.mark.parametrize("template", sorted((FARM / "openjd").glob("*.yaml")), ids=lambda path: path.name)
def test_openjd_templates_are_valid(template: Path) -> None:
    openjd("check", template, "--extensions", "TASK_CHUNKING")


def test_openjd_still(folder: Path) -> None:
    rules = {
        "version": "pathmapping-1.0",
        "path_mapping_rules": [
            {"source_path_format": "POSIX", "source_path": "/studio", "destination_path": str(folder)}
        ],
    }
    parameters = {
        "Scene": "/studio/scene.toml",
        "Output": "/studio/picture.exr",
        "Samples": SAMPLES,
        "SamplesPerTask": PART,
        "Device": "cpu",
    }
    told = openjd(
        "run",
        FARM / "openjd" / "still.yaml",
        "--step",
        "Merge",
        "--run-dependencies",
        "--path-mapping-rules",
        json.dumps(rules),
        "--job-param",
        json.dumps(parameters),
    )
    assert "openjd_progress: 100" in told
    assert sorted(path.name for path in folder.iterdir()) == ["picture.exr", "scene.toml", "whole.exr"]
    assert (folder / "picture.exr").read_bytes() == (folder / "whole.exr").read_bytes()


# As much of Flamenco as a job type sees: jobs are told as JSON.
FLAMENCO = """
const { readFileSync } = require("node:fs");
const [file, settings] = process.argv.slice(2);
const tasks = [];
globalThis.author = {
    Command: (name, parameters) => ({ name, parameters }),
    Task: (name, type) => ({
        name, type, commands: [], dependencies: [],
        addCommand(command) { this.commands.push(command); },
        addDependency(task) { this.dependencies.push(task.name); },
    }),
};
globalThis.frameChunker = (frames, size) => {
    const [first, last] = frames.split("-").map(Number);
    const chunks = [];
    for (let at = first; at <= last; at += size) chunks.push(at + "-" + Math.min(at + size - 1, last));
    return chunks;
};
const [type, compile] = new Function(readFileSync(file, "utf8") + "; return [JOB_TYPE, compileJob];")();
const defaults = Object.fromEntries(type.settings.map(({ key, default: value }) => [key, value]));
compile({ settings: { ...defaults, ...JSON.parse(settings) }, addTask: (task) => tasks.push(task) });
console.log(JSON.stringify({ type, tasks }));
"""


def flamenco(job_type: str, **settings) -> list[dict]:
    """Tasks of a job, each after those that it waits for."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("node is not installed")
    told = run(node, "-", FARM / "flamenco" / job_type, json.dumps(settings), input=FLAMENCO)
    job = json.loads(told)
    types = {setting["type"] for setting in job["type"]["settings"]}
    assert job["type"]["label"] and types <= {"string", "int32", "float", "bool"}
    done: set[str] = set()
    for task in job["tasks"]:
        assert done.issuperset(task["dependencies"]) and task["name"] not in done
        done.add(task["name"])
    return job["tasks"]


def work(tasks: list[dict]) -> None:
    for task in tasks:
        for command in task["commands"]:
            assert command["name"] == "exec"
            program = command["parameters"]["exe"].replace("{raggio}", "raggio")
            run(program, *command["parameters"]["args"])


def test_flamenco_still(folder: Path) -> None:
    tasks = flamenco(
        "raggio-still.js",
        scene=str(folder / "scene.toml"),
        output=str(folder / "picture.exr"),
        samples=SAMPLES,
        samples_per_task=PART,
        device="cpu",
    )
    assert [task["name"] for task in tasks] == ["prepare", "samples 0..4", "samples 4..8", "samples 8..10", "merge"]
    work(tasks)
    assert sorted(path.name for path in folder.iterdir()) == ["picture.exr", "scene.toml", "whole.exr"]
    assert (folder / "picture.exr").read_bytes() == (folder / "whole.exr").read_bytes()


ANIMATED = FILE.replace(
    "vertical_fov_degrees = 40\n",
    "vertical_fov_degrees = 40\nkeyframes = [{ time = 0, position = [0, 1, 4] }, { time = 1, position = [4, 1, 0] }]\n",
)


@pytest.fixture
def frames(folder: Path) -> list[bytes]:
    """Frames 1 to 3 that one machine makes."""
    (folder / "scene.toml").write_text(ANIMATED)
    run(
        *("raggio", "render", folder / "scene.toml", "--samples", "4", "--device", "cpu"),
        *("--frames", "1-3", "-o", folder / "whole-##.png"),
    )
    return [(folder / f"whole-{frame:02}.png").read_bytes() for frame in (1, 2, 3)]


def test_openjd_frames(folder: Path, frames: list[bytes]) -> None:
    openjd(
        *("run", FARM / "openjd" / "frames.yaml", "--extensions", "TASK_CHUNKING"),
        *("-p", f"Scene={folder / 'scene.toml'}", "-p", f"Output={folder / 'frame-##.png'}", "-p", "Frames=1-3"),
        *("-p", "FramesPerTask=2", "-p", "Samples=4", "-p", "Device=cpu"),
    )
    assert [(folder / f"frame-{frame:02}.png").read_bytes() for frame in (1, 2, 3)] == frames
    assert frames[0] != frames[2]


def test_flamenco_frames(folder: Path, frames: list[bytes]) -> None:
    tasks = flamenco(
        "raggio-frames.js",
        scene=str(folder / "scene.toml"),
        output=str(folder / "frame-##.png"),
        frames="1-3",
        chunk_size=2,
        samples=4,
        device="cpu",
    )
    assert [task["name"] for task in tasks] == ["frames 1-2", "frames 3-3"]
    work(tasks)
    assert [(folder / f"frame-{frame:02}.png").read_bytes() for frame in (1, 2, 3)] == frames
