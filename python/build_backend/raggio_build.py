"""Build backend: maturin, with slangc on its PATH.

slangc, the compiler of the kernels, comes in a wheel that names PyTorch among its requirements and needs none of it for
slangc. A build requirement would bring gigabytes along, so the wheel is installed alone, as scripts/setup.sh does.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import maturin

ROOT = Path(__file__).resolve().parents[2]
REQUIREMENTS = ROOT / "scripts" / "requirements-slangc.txt"


def _has_slangc() -> bool:
    """Whether the build finds a slangc by itself: see crates/kernels/src/compile/slangc.rs."""
    if os.environ.get("SLANGC") or (ROOT / ".venv/bin/slangc").is_file() or shutil.which("slangc"):
        return True
    sdk = os.environ.get("VULKAN_SDK")
    return sdk is not None and (Path(sdk) / "bin/slangc").is_file()


def _requires(requirements: list[str]) -> list[str]:
    return requirements if _has_slangc() else [*requirements, "pip"]


def _find_slangc() -> None:
    """Puts slangc on PATH, where the build looks for it; it is kept in the folder of what is built."""
    if _has_slangc():
        return
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    folder = target / ("slangc-" + REQUIREMENTS.read_text().split("==")[1].split()[0])
    slangc = folder / "slangtorch" / "bin" / "slangc"
    if not slangc.is_file():
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--only-binary", ":all:"]
        command += ["--require-hashes", "--requirement", str(REQUIREMENTS), "--upgrade", "--target", str(folder)]
        if subprocess.run(command, check=False).returncode != 0 or not slangc.is_file():
            sys.exit(
                "error: slangc, the compiler of the kernels, could not be installed: check the network, or unpack a "
                "release of https://github.com/shader-slang/slang and set SLANGC to its bin/slangc"
            )
    os.environ["PATH"] = os.pathsep.join([str(slangc.parent), os.environ.get("PATH", "")])


def get_requires_for_build_wheel(config_settings=None):
    return _requires(maturin.get_requires_for_build_wheel(config_settings))


def get_requires_for_build_editable(config_settings=None):
    return _requires(maturin.get_requires_for_build_editable(config_settings))


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    _find_slangc()
    return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    _find_slangc()
    return maturin.build_editable(wheel_directory, config_settings, metadata_directory)


get_requires_for_build_sdist = maturin.get_requires_for_build_sdist
build_sdist = maturin.build_sdist
# Asking maturin for metadata alone would compile nothing, but needs cargo all the same.
prepare_metadata_for_build_wheel = maturin.prepare_metadata_for_build_wheel
prepare_metadata_for_build_editable = maturin.prepare_metadata_for_build_editable
