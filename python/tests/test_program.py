"""The program that the wheel brings along."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import raggio as rg


def run(*arguments: str, **options) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "raggio", *arguments], text=True, capture_output=True, timeout=60, **options
    )


def test_it_is_the_program() -> None:
    done = run("--version")
    assert (done.returncode, done.stdout) == (0, f"raggio {rg.__version__}\n")
    script = os.path.join(os.path.dirname(sys.executable), "raggio")
    assert subprocess.run([script, "--version"], text=True, capture_output=True).stdout == done.stdout


def test_exit_statuses(file) -> None:
    assert run("check", str(file)).returncode == 0
    done = run("check", "nowhere.toml")
    assert done.returncode == 2 and done.stderr == "error: nowhere.toml: there is no such file\n"
    assert run("render").returncode == 2
    assert run("render", str(file), "--device", "vulkan:99", "-o", str(file.parent / "a.png")).returncode == 3


def test_interrupted(file) -> None:
    output = file.parent / "a.png"
    command = [
        sys.executable,
        "-m",
        "raggio",
        "render",
        str(file),
        "--device",
        "cpu",
        "--samples",
        "100000000",
        "-o",
        str(output),
    ]
    running = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    # The first line says that sampling begins.
    assert running.stderr is not None and "48x32" in running.stderr.readline()
    time.sleep(0.3)
    running.send_signal(signal.SIGINT)
    running.communicate(timeout=30)
    assert running.returncode == 130 and output.exists()
