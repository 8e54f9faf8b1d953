"""Values as TOML."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import PurePath
from typing import Any

import numpy as np


def value(of: Any) -> str:
    """The TOML of a number, a text, a truth, or a list or table of such."""
    if isinstance(of, (bool, np.bool_)):
        return "true" if of else "false"
    if isinstance(of, (int, np.integer)):
        return str(int(of))
    if isinstance(of, (float, np.floating)):
        return number(of)
    if isinstance(of, (str, PurePath)):
        return text(str(of))
    if isinstance(of, datetime):
        # A time without an offset is none of TOML's that a sky could be seen at: raggio says so.
        return of.isoformat()
    if isinstance(of, np.ndarray):
        return value(of.tolist())
    if isinstance(of, Mapping):
        entries = (f"{text(str(key))} = {value(item)}" for key, item in of.items() if item is not None)
        return "{ " + ", ".join(entries) + " }"
    if isinstance(of, Sequence):
        return "[" + ", ".join(map(value, of)) + "]"
    raise TypeError(f"a scene holds numbers, texts, lists and tables, and this is of type {type(of).__name__}: {of!r}")


def number(of: float | np.floating[Any]) -> str:
    """The shortest digits that say the number in its own precision."""
    if not math.isfinite(of):
        return "nan" if math.isnan(of) else ("inf" if of > 0 else "-inf")
    digits = str(of) if isinstance(of, np.floating) else repr(float(of))
    return digits if any(mark in digits for mark in ".e") else digits + ".0"


def text(of: str) -> str:
    """A basic string with its escapes."""
    escapes = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\t": "\\t", "\r": "\\r"}
    plain = (escapes.get(c, c if c >= " " and c != "\x7f" else f"\\u{ord(c):04x}") for c in of)
    return '"' + "".join(plain) + '"'
