"""Reports of progress."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

#: Takes the part that is done (0 to 1), the samples that every pixel has, and the seconds so far.
Report = Callable[[float, int, float], object]
#: ``True``: a bar; ``False``: nothing; a function; ``None``: a bar on terminals and in notebooks, where tqdm is
#: installed.
ProgressLike = bool | Report | None

#: Seconds after which a bar appears by itself.
DELAY = 1.0


@contextmanager
def reporter(progress: ProgressLike) -> Iterator[Report | None]:
    """What a render tells its progress to."""
    if callable(progress):
        yield progress
        return
    bar = _bar(wanted=progress is True) if progress is not False else None
    if bar is None:
        yield None
        return

    def report(fraction: float, samples: int, seconds: float) -> None:
        bar.n = round(1000 * fraction) / 10
        bar.set_postfix_str(f"{samples} samples", refresh=False)
        bar.update(0)

    try:
        yield report
    finally:
        bar.close()


def _bar(*, wanted: bool) -> Any:
    try:
        from tqdm.auto import tqdm  # type: ignore[import-untyped,unused-ignore]
    except ImportError:
        if wanted:
            raise ImportError("progress=True draws its bar by tqdm: pip install tqdm") from None
        return None
    if not wanted and "ipykernel" not in sys.modules and not sys.stderr.isatty():
        return None
    form = "{desc} {percentage:3.0f}% {bar} {postfix} [{elapsed}<{remaining}]"
    return tqdm(total=100.0, bar_format=form, delay=0.0 if wanted else DELAY, leave=wanted, desc="raggio")
