"""What the packages hold."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tarfile

import pytest
from conftest import ROOT


def test_sources_hold_what_is_compiled_in() -> None:
    """Files outside the crates that are compiled in are listed for the source distribution, which has no others."""
    listed = (ROOT / "pyproject.toml").read_text()
    patterns = [ROOT.glob(pattern) for pattern in re.findall(r'path = "([^"]+)", format = "sdist"', listed)]
    included = {path.resolve() for pattern in patterns for path in pattern}
    assert included
    for source in ROOT.glob("crates/*/src/**/*.rs"):
        for name in re.findall(r'include_(?:str|bytes)!\("([^"]+)"\)', source.read_text()):
            path = (source.parent / name).resolve()
            assert path.is_file(), f"{source}: {name}"
            assert path.is_relative_to(ROOT / "crates") or path in included, f"{source}: {name} is not in the sdist"


def test_wheels_can_be_made_of_the_sources(tmp_path) -> None:
    """The source distribution is a workspace of its own, of which maturin can tell what the wheel will be."""
    maturin = shutil.which("maturin", path=f"{sys.prefix}/bin")
    if maturin is None or shutil.which("cargo") is None:
        pytest.skip("the source distribution is made by maturin and cargo: make setup-python")
    subprocess.run([maturin, "sdist", "--out", str(tmp_path)], cwd=ROOT, check=True, capture_output=True)
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as file:
        file.extractall(tmp_path, filter="data")
    folder = tmp_path / archive.name.removesuffix(".tar.gz")
    assert (folder / "python/raggio/view.js").is_file()
    command = [maturin, "pep517", "write-dist-info", "--metadata-directory", "info", "--interpreter", sys.executable]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert list((folder / "info").glob("raggio-*.dist-info/METADATA"))
