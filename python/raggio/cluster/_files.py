"""Files of a scene on their way to machines that may not have them."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from .._errors import OutputError, SceneError
from .._raggio import SceneText

Contents = npt.NDArray[np.uint8]


@dataclass(frozen=True)
class Manifest:
    """The files that a scene is made of, and how its text names them."""

    #: Hashes of the contents, by the files' canonical paths.
    hashes: dict[str, str]
    #: Canonical paths, by the strings that the text has for them.
    named: dict[str, str]

    @classmethod
    def of(cls, text: SceneText, folder: Path) -> Manifest:
        """The files of a scene whose paths are relative to ``folder``."""
        return cls.named_in(text, folder, {str(path): hash_of(str(path)) for path in text.files()})

    @classmethod
    def named_in(cls, text: SceneText, folder: Path, hashes: dict[str, str]) -> Manifest:
        """The files of these ``hashes``, and how the text names them."""
        named = {word: os.path.realpath(folder / word) for word in _strings(text.get([]))}
        return cls(hashes, {word: path for word, path in named.items() if path in hashes})

    def missing(self) -> list[str]:
        """Paths of those that this machine does not have, or has with other contents."""
        return [path for path, wanted in self.hashes.items() if not os.path.isfile(path) or hash_of(path) != wanted]

    def unpack(self, folder: Path, contents: dict[str, Contents]) -> None:
        """Puts all files into ``folder``, under the paths they have on their own machine: ``contents``, and this machine's."""
        for path in self.hashes:
            place = moved(folder, path)
            place.parent.mkdir(parents=True, exist_ok=True)
            if path in contents:
                contents[path].tofile(place)
            else:
                shutil.copyfile(path, place)

    def rewritten(self, text: str, folder: Path) -> str:
        """The text of the scene, whose files have been unpacked into ``folder``."""
        for word, path in self.named.items():
            place = str(moved(folder, path)).replace("\\", "\\\\").replace('"', '\\"')
            escaped = word.replace("\\", "\\\\").replace('"', '\\"')
            text = text.replace(f'"{escaped}"', f'"{place}"').replace(f"'{word}'", f'"{place}"')
        return text


def moved(folder: Path, path: str) -> Path:
    """Place of a file below ``folder`` that has ``path`` elsewhere."""
    return folder / Path(path).relative_to(Path(path).anchor)


def hash_of(path: str) -> str:
    """Hash of a file's contents."""
    hasher = hashlib.blake2b(digest_size=32)
    with open(path, "rb") as file:
        while part := file.read(1 << 20):
            hasher.update(part)
    return hasher.hexdigest()


def read(path: str, wanted: str) -> Contents:
    """Contents of a file, which must still be those of the hash ``wanted``."""
    contents = np.fromfile(path, dtype=np.uint8)
    if hashlib.blake2b(contents.data, digest_size=32).hexdigest() != wanted:
        raise SceneError(f"{path} has changed since the render began: render again")
    return contents


def write_whole(path: str, contents: bytes) -> None:
    """Writes a file, whole or not at all."""
    place = os.path.realpath(path)
    part = f"{place}.part"
    try:
        with open(part, "wb") as file:
            file.write(contents)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, place)
    except OSError as error:
        if os.path.exists(part):
            os.remove(part)
        raise OutputError(f"cannot write {path}: {error.strerror}") from None


def _strings(value: Any) -> Iterator[str]:
    """All strings in a value of a scene file."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for part in value.values():
            yield from _strings(part)
    elif isinstance(value, (list, tuple)):
        for part in value:
            yield from _strings(part)
