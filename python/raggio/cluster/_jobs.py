"""Jobs for a crew: the samples of one picture, or many pictures."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, TypeVar

from .._errors import InternalError, SceneError
from .._raggio import Film
from ._crew import Crew, Task, error_of
from ._worker import add_up

#: Numbers of samples: the first, and the one after the last.
Range = tuple[int, int]

#: Seconds of a task at least, and at most, as long as enough is left for all.
SHORTEST, LONGEST = 10.0, 120.0
#: Part of a task's time that all else may take: sending it, packing its film, adding it up.
OVERHEAD = 0.02
#: Seconds of the tasks at the end, when each gets a small part of what is left so that all are done at about one time.
LAST = 0.5
#: Part of what is left that all workers together get at a time.
PORTION = 0.25
#: Films that are added up on some machine of the cluster as soon as so many more are waiting than this one can add.
FAN_IN = 8
#: Films that come to this machine at a time: one while another is added.
FETCHES = 2
#: Seconds in which a film has to come, and in which tasks have to end when the time is over.
TRANSFER, GRACE = 120.0, 5.0


class Ledger:
    """Samples that are still to be given out, in order."""

    def __init__(self, wanted: Range, have: Sequence[Range] = ()) -> None:
        self._ranges: list[Range] = []
        at = wanted[0]
        for first, end in sorted(have):
            self._add((at, min(first, wanted[1])))
            at = max(at, end)
        self._add((at, wanted[1]))

    def _add(self, part: Range) -> None:
        if part[0] < part[1]:
            self._ranges.append(part)

    @property
    def left(self) -> int:
        """Number of samples."""
        return sum(end - first for first, end in self._ranges)

    def take(self, most: int) -> Range:
        """The first samples, as many as follow each other and ``most`` at most."""
        first, end = self._ranges[0]
        taken = (first, min(end, first + most))
        self._ranges[:1] = [(taken[1], end)] if taken[1] < end else []
        return taken

    def give_back(self, part: Range) -> None:
        """Takes samples back."""
        self._ranges = sorted([*self._ranges, part])


@dataclass(eq=False)
class _Made:
    """A film somewhere in the cluster."""

    ranges: list[Range]
    film: Any
    since: float = 0.0

    @property
    def samples(self) -> int:
        return sum(end - first for first, end in self.ranges)


class Samples:
    """Job of taking the samples of one picture, whose film is added up here."""

    def __init__(
        self, ray: Any, crew: Crew, wanted: Range, film: Film | None, time_limit: float | None, name: str
    ) -> None:
        self._crew = crew
        self._add_up = ray.remote(add_up).options(num_cpus=0, num_returns=2, max_retries=0)
        self._wanted = wanted
        self._name = name
        self.film = film
        #: Number of films that have been added.
        self.revision = 0
        self._resumed = film is not None
        self._ledger = Ledger(wanted, film.ranges or () if film else ())
        self._waiting: deque[_Made] = deque()
        self._coming: list[_Made] = []
        self._summed: list[_Made] = []
        self._time_limit = math.inf if time_limit is None else time_limit
        #: Moment at which the first task was given out.
        self._begun: float | None = None
        self._overhead = 0.0

    @property
    def total(self) -> int:
        """Samples of each pixel that are wanted."""
        return self._wanted[1] - self._wanted[0]

    @property
    def seconds(self) -> float:
        """Seconds since the first task was given out."""
        return 0.0 if self._begun is None else time.monotonic() - self._begun

    @property
    def samples(self) -> int:
        """Samples of each pixel that the film has."""
        return sum(end - first for first, end in self.film.ranges or ()) if self.film else 0

    @property
    def done(self) -> bool:
        """Whether the film has all samples, or the time is over and nothing is under way any more."""
        if self.samples == self.total:
            return True
        late = self.seconds - self._time_limit
        is_at_rest = self._crew.is_idle and not (self._waiting or self._coming or self._summed)
        return late > 0 and (is_at_rest or late > GRACE) and self.film is not None

    def fraction(self) -> float:
        """Part of the whole that is probably done."""
        made = sum(made.samples for made in (*self._waiting, *self._coming, *self._summed))
        done = self.samples + made + self._crew.units_under_way()
        return min(max(done / self.total, self.seconds / self._time_limit), 1.0)

    def next(self, pace: float | None, workers: float) -> Task | None:
        """A task that takes long enough to be worth its way, and not so long that the others have to wait for it."""
        left = self._ledger.left
        seconds = min(max(SHORTEST, self._overhead / OVERHEAD), LONGEST, self._time_limit - self.seconds)
        # However short the time is, there is a picture at its end.
        if not left or (seconds <= 0 and self.film is not None):
            return None
        self._begun = self._begun or time.monotonic()
        units = 1
        if pace:
            share = max(PORTION * left / workers, max(LAST, 4 * self._overhead) / pace)
            units = max(1, int(min(share, seconds / pace)))
        part = self._ledger.take(units)
        return Task(part, part[1] - part[0], "film", part)

    def give_back(self, task: Task) -> None:
        """Takes samples back that nobody has taken."""
        first, end = task.arguments
        self._ledger.give_back((first, end))

    def take(self, task: Task, told: dict[str, Any], made: Any) -> None:
        """Takes a film that waits somewhere in the cluster."""
        spent = told["seconds"] - told["sampling"]
        self._overhead = max(0.5 * (self._overhead + spent), 0.0)
        first, end = task.arguments
        self._waiting.append(_Made([(first, end)], made))

    def absorb(self) -> None:
        """Adds up what waits: here one after the other, and elsewhere what has become too much."""
        now = time.monotonic()
        for made in [made for made in self._coming if now > made.since + TRANSFER]:
            self._crew.forget(made.film)
            self._lose(self._coming, made)
        while self._waiting and len(self._coming) < FETCHES:
            made = self._waiting.popleft()
            made.since = now
            self._coming.append(made)
            self._crew.when(made.film, partial(self._arrived, made))
        while len(self._waiting) >= FAN_IN:
            self._sum([self._waiting.popleft() for _ in range(FAN_IN)])

    def _arrived(self, made: _Made, film: Any, error: Exception | None) -> None:
        if error is not None:
            self._lose(self._coming, made)
            return
        self._coming.remove(made)
        added = Film.from_bytes(film)
        if self.film is None:
            self.film = added
        else:
            try:
                self.film.merge(added)
            except SceneError as difference:
                if self._resumed and not self.revision:
                    raise SceneError(f"cannot go on from {self._name}: {difference}") from None
                raise InternalError(f"films of one render do not fit together: {difference}") from None
        self.revision += 1

    def _sum(self, parts: list[_Made]) -> None:
        """Has films added up on some machine."""
        told, film = self._add_up.remote(*(part.film for part in parts))
        made = _Made([samples for part in parts for samples in part.ranges], film)
        self._summed.append(made)

        def answered(told: Any, error: Exception | None) -> None:
            if error is not None:
                self._lose(self._summed, made)
            elif "error" in told:
                raise error_of(told)
            else:
                self._summed.remove(made)
                self._waiting.append(made)

        self._crew.when(told, answered)

    def _lose(self, among: list[_Made], made: _Made) -> None:
        """Has samples taken anew whose film is gone with its machine."""
        among.remove(made)
        for part in made.ranges:
            self._ledger.give_back(part)


T = TypeVar("T")


class Pictures(Generic[T]):
    """Job of making many things, each whole: pictures of cameras, one a task, or frames, several a task."""

    def __init__(self, crew: Crew, method: str, items: Sequence[T], *, bundled: bool) -> None:
        self._crew = crew
        self._method = method
        self._items = items
        self._bundled = bundled
        self._todo = list(range(len(items)))
        self._missing = set(self._todo)
        self._made: deque[tuple[tuple[int, ...], dict[str, Any], Any]] = deque()
        self._coming: dict[Any, Task] = {}

    @property
    def done(self) -> bool:
        """Whether all are here."""
        return not self._missing

    @property
    def left(self) -> int:
        """Number of those that are not here yet."""
        return len(self._missing)

    def next(self, pace: float | None, workers: float) -> Task | None:
        """The next one; of frames as many as take a while."""
        # What is made and not fetched yet is in the machines' memory.
        if not self._todo or len(self._coming) + len(self._made) > 2 * workers:
            return None
        share = math.ceil(PORTION * len(self._todo) / workers)
        count = max(1, min(share, int(SHORTEST / pace))) if self._bundled and pace else 1
        places, self._todo = self._todo[:count], self._todo[count:]
        items = [self._items[place] for place in places]
        return Task(tuple(places), count, self._method, (items,) if self._bundled else (items[0],))

    def give_back(self, task: Task) -> None:
        """Takes back what nobody has made."""
        self._todo = sorted([*self._todo, *_places(task)])

    def take(self, task: Task, told: dict[str, Any], made: Any) -> None:
        """Takes what waits somewhere in the cluster, and fetches it."""
        self._coming[made] = task

        def arrived(value: Any, error: Exception | None) -> None:
            del self._coming[made]
            if error is not None:
                self.give_back(task)
            else:
                self._missing.difference_update(_places(task))
                self._made.append((_places(task), told, value))

        self._crew.when(made, arrived)

    def take_made(self) -> Iterator[tuple[tuple[int, ...], dict[str, Any], Any]]:
        """What has come since the last call: places, what the worker has told, and what it has made."""
        while self._made:
            yield self._made.popleft()


def _places(task: Task) -> tuple[int, ...]:
    key = task.key
    assert isinstance(key, tuple)
    return key


