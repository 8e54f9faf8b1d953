"""Examples of the documentation, which run as they stand."""

from __future__ import annotations

import doctest
import os
import re

import pytest
from conftest import ROOT

import raggio as rg


def blocks(page: str) -> list[str]:
    return re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(), flags=re.M | re.S)


@pytest.mark.parametrize("page", ["docs/python.md", "README.md"])
def test_examples(page: str, tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    found = blocks(page)
    assert found
    names: dict[str, object] = {}
    for number, block in enumerate(found, 1):
        exec(compile(block, f"{page}, example {number}", "exec"), names)
    assert os.listdir(tmp_path)


@pytest.mark.parametrize("module", [rg, rg.datasets])
def test_docstrings(module) -> None:
    result = doctest.testmod(module)
    assert result.attempted > 0 and result.failed == 0


def test_everything_has_a_docstring() -> None:
    for name in rg.__all__:
        thing = getattr(rg, name)
        if callable(thing):
            assert thing.__doc__, name
            for member, value in vars(thing).items() if isinstance(thing, type) else ():
                described = member.startswith("_") or not (callable(value) or isinstance(value, property))
                assert described or value.__doc__, f"{name}.{member}"
