"""What the packages hold."""

from __future__ import annotations

import re

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
