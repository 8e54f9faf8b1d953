"""The crew of a render: a worker on each machine of the cluster, while machines come, go, hang and fail."""

from __future__ import annotations

import platform
import statistics
import time
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass, field
from typing import Any, Protocol

import raggio

from .. import _errors
from .._errors import Error
from .._scene import Scene
from ._connect import ClusterError
from ._files import read
from ._worker import Order, Worker

#: Seconds from one look at the cluster's machines to the next, and the longest that nothing is looked at.
LOOK, TICK = 1.0, 0.1
#: Tasks that a worker has at a time: one waits while another is under way, so that no answer is waited for.
DEPTH = 2
#: Times that a worker is started on a machine on which it dies.
STARTS = 3
#: Multiple of its time, and seconds beside, after which a task is given to a second worker that has nothing to do.
LATE, LATE_SECONDS = 1.5, 1.0
#: Seconds after which it is told that no machine takes part.
LONELY = 20.0

#: Errors that every machine would meet, so that it is of no use to try others.
HOPELESS = (_errors.SceneError, _errors.DenoiseError)

#: Takes what has been waited for, or why there is none.
Then = Callable[[Any, "Exception | None"], None]


@dataclass(frozen=True)
class Task:
    """Call of a worker's method."""

    key: Hashable
    #: Samples, pictures or frames.
    units: int
    method: str
    arguments: tuple[Any, ...]


class Job(Protocol):
    """Work to be done in tasks, any of which may come back undone."""

    @property
    def done(self) -> bool:
        """Whether nothing more is needed."""

    def next(self, pace: float | None, workers: float) -> Task | None:
        """A task for a worker whose ``pace`` is in seconds a unit, where all together do what so many ``workers`` of its kind
        would; ``None`` where all are given out."""

    def give_back(self, task: Task) -> None:
        """Takes a task back that nobody has done."""

    def take(self, task: Task, told: dict[str, Any], made: Any) -> None:
        """Takes what a worker tells of a task that it has done, and the reference to what it has made."""


@dataclass(eq=False)
class _Turn:
    """A task in the hands of a worker."""

    task: Task
    member: _Member
    made: Any
    #: Moment at which the worker has come to it; ``None`` while it waits there.
    begun: float | None = None

    def is_late(self, now: float, pace: float | None) -> bool:
        if self.begun is None or pace is None:
            return False
        return now - self.begun > LATE * pace * self.task.units + LATE_SECONDS

    def share_done(self, now: float, pace: float | None) -> float:
        """Part of the task that is probably done."""
        if self.begun is None or not pace:
            return 0.0
        return min((now - self.begun) / (pace * self.task.units), 0.95)


@dataclass(eq=False)
class _Member:
    """A worker, and the machine that it works on."""

    node: str
    name: str
    actor: Any
    has_answered: bool = False
    is_ready: bool = False
    device: str = ""
    has_files: bool = False
    pace: float | None = None
    turns: list[_Turn] = field(default_factory=list)


class Crew:
    """Workers that are given tasks, and those who wait for what comes of them."""

    def __init__(self, ray: Any, scene: Scene, order: Order, warn: Callable[[str], None]) -> None:
        self._ray = ray
        self._order = order
        self._warn = warn
        self._scene = ray.put(scene)
        self._contents: dict[str, Any] = {}
        self._members: dict[str, _Member] = {}
        #: Starts on each machine; more than ``STARTS`` where there will be no other.
        self._starts: dict[str, int] = {}
        self._failure: Error | None = None
        #: What is to be told of machines that are left out, once there are others.
        self._left_out: list[str] = []
        self._waiting: dict[Any, Then] = {}
        self._turns: dict[Hashable, list[_Turn]] = {}
        self._next_look = 0.0
        self._lonely_since: float | None = time.monotonic()

    @property
    def devices(self) -> list[str]:
        """Names of the devices at work."""
        return [member.device for member in self._members.values() if member.is_ready]

    def run(self, job: Job) -> Iterator[None]:
        """Does a job; returns in between to whoever has something else to do."""
        while not job.done:
            self._look(job)
            self._hand_out(job)
            yield
            self._receive()

    def when(self, reference: Any, then: Then) -> None:
        """Calls ``then`` with what ``reference`` stands for, once it is on this machine."""
        self._waiting[reference] = then

    def forget(self, reference: Any) -> None:
        """Waits for it no longer."""
        self._waiting.pop(reference, None)

    def units_under_way(self) -> float:
        """Units that are probably done of what is in the hands of workers."""
        now = time.monotonic()
        shares = (
            max(turn.share_done(now, turn.member.pace) * turn.task.units for turn in turns)
            for turns in self._turns.values()
        )
        return sum(shares)

    @property
    def is_idle(self) -> bool:
        """Whether no worker has anything to do."""
        return not self._turns

    def close(self) -> None:
        """Ends all workers."""
        closing = [member.actor.close.remote() for member in self._members.values() if member.has_files]
        if closing:
            self._ray.wait(closing, num_returns=len(closing), timeout=2)
        for member in self._members.values():
            self._ray.kill(member.actor)
        # What they refer to leaves the object stores.
        self._waiting.clear()
        self._turns.clear()
        self._contents.clear()

    # ---- Machines

    def _look(self, job: Job) -> None:
        """Starts a worker on each machine that has none."""
        now = time.monotonic()
        if now < self._next_look:
            return
        self._next_look = now + LOOK
        for node in self._ray.nodes():
            if node["Alive"] and node["NodeID"] not in self._members:
                self._start(job, node)
        if not self._members and self._failure is not None:
            raise self._failure
        if any(member.has_answered for member in self._members.values()):
            self._lonely_since = None
        elif self._lonely_since is None:
            self._lonely_since = now
        if self._lonely_since is not None and now > self._lonely_since + LONELY:
            self._warn("no machine of the cluster takes part: waiting for one whose processors are free")
            self._lonely_since = float("inf")

    def _start(self, job: Job, node: dict[str, Any]) -> None:
        from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy  # type: ignore[import-not-found,unused-ignore]

        identity, resources = node["NodeID"], node["Resources"]
        cores = int(resources.get("CPU", 0))
        gpus = 0 if self._order.device == "cpu" else int(resources.get("GPU", 0))
        if not cores and not gpus or self._starts.get(identity, 0) >= STARTS:
            return
        self._starts[identity] = self._starts.get(identity, 0) + 1
        options = {
            "num_cpus": min(self._order.threads or cores, cores),
            "num_gpus": gpus,
            "scheduling_strategy": NodeAffinitySchedulingStrategy(identity, soft=False),
        }
        actor = self._ray.remote(Worker).options(**options).remote(cores or None)
        member = _Member(identity, f"{node['NodeManagerHostname']} ({node['NodeManagerAddress']})", actor)
        self._members[identity] = member
        self.when(actor.hello.remote(), lambda told, error: self._greeted(job, member, told, error))

    def _greeted(self, job: Job, member: _Member, told: Any, error: Exception | None) -> None:
        if error is not None:
            if "failed to import" in str(error) or "No module named" in str(error):
                hint = f"pip install 'raggio[cluster]=={raggio.__version__}'"
                reason = f"it lacks raggio, or has another than this one, {raggio.__version__} ({hint})"
                self._exclude(job, member, ClusterError(reason))
            else:
                self._died(job, member)
            return
        for what, ours in (("raggio", raggio.__version__), ("Python", platform.python_version())):
            if told[what] != ours:
                reason = f"it has {what} {told[what]}, and this is {ours}: all machines need the same"
                self._exclude(job, member, ClusterError(reason))
                return
        member.has_answered = True
        self._open(job, member, [])

    def _open(self, job: Job, member: _Member, names: list[str]) -> None:
        opened = member.actor.open.remote(self._scene, self._order, names, *map(self._sent, names))
        self.when(opened, lambda told, error: self._opened(job, member, told, error))

    def _opened(self, job: Job, member: _Member, told: Any, error: Exception | None) -> None:
        if error is not None:
            self._died(job, member)
        elif "error" in told:
            self._exclude(job, member, error_of(told))
        elif "missing" in told:
            member.has_files = True
            self._open(job, member, told["missing"])
        else:
            member.is_ready, member.device = True, told["device"]

    def _sent(self, path: str) -> Any:
        """Reference to the contents of a file, from which each machine gets them once."""
        if path not in self._contents:
            self._contents[path] = self._ray.put(read(path, self._order.manifest.hashes[path]))
        return self._contents[path]

    def _exclude(self, job: Job, member: _Member, error: Error) -> None:
        """Does without a machine, for good."""
        self._starts[member.node] = STARTS
        self._ray.kill(member.actor)
        self._lose(job, member)
        self._failure = type(error)(f"{member.name}: {error}") if isinstance(error, ClusterError) else error
        self._left_out.append(f"{member.name} takes no part: {error}")

    def _died(self, job: Job, member: _Member) -> None:
        """Does without a worker that is gone, and without its machine where that has happened too often."""
        self._lose(job, member)
        if self._starts[member.node] >= STARTS:
            reason = f"its worker has died {STARTS} times, perhaps for want of memory"
            self._failure = ClusterError(f"{member.name}: {reason}")
            self._left_out.append(f"{member.name} takes no part any more: {reason}")

    def _lose(self, job: Job, member: _Member) -> None:
        """Does without a worker, whose tasks are for others."""
        if self._members.get(member.node) is member:
            del self._members[member.node]
        turns, member.turns = member.turns, []
        for turn in turns:
            self._drop(job, turn)

    def _drop(self, job: Job, turn: _Turn) -> None:
        others = self._turns.get(turn.task.key, [])
        if turn in others:
            others.remove(turn)
            if not others:
                del self._turns[turn.task.key]
                job.give_back(turn.task)

    # ---- Tasks

    def _pace(self, member: _Member) -> float | None:
        """Seconds that a unit takes a worker; of one that has done none yet, as the others have it."""
        known = [other.pace for other in self._members.values() if other.pace is not None]
        return member.pace if member.pace is not None else statistics.median(known) if known else None

    def _hand_out(self, job: Job) -> None:
        ready = [member for member in self._members.values() if member.is_ready]
        while ready and self._left_out:
            self._warn(self._left_out.pop(0))
        for depth in range(DEPTH):
            for member in ready:
                if len(member.turns) == depth:
                    pace = self._pace(member)
                    paces = [self._pace(other) or pace for other in ready]
                    alike = sum(pace / other for other in paces if other) if pace else len(ready)
                    task = job.next(pace, alike)
                    if task is None and depth == 0:
                        task = self._late_task()
                    if task is not None:
                        self._give(job, member, task)

    def _late_task(self) -> Task | None:
        """The task that is most in need of a second worker."""
        now = time.monotonic()
        late = []
        for turns in self._turns.values():
            paces = [self._pace(turn.member) for turn in turns]
            # What waits behind a late task is as late.
            heads = [turn.member.turns[0] for turn in turns]
            if all(head.is_late(now, pace) for head, pace in zip(heads, paces)):
                late.append((min(head.begun or now for head in heads), turns[0].task))
        return min(late, key=lambda pair: pair[0])[1] if late else None

    def _give(self, job: Job, member: _Member, task: Task) -> None:
        told, made = getattr(member.actor, task.method).options(num_returns=2).remote(*task.arguments)
        turn = _Turn(task, member, made, None if member.turns else time.monotonic())
        member.turns.append(turn)
        self._turns.setdefault(task.key, []).append(turn)
        self.when(told, lambda told, error: self._answered(job, turn, told, error))

    def _answered(self, job: Job, turn: _Turn, told: Any, error: Exception | None) -> None:
        member, task = turn.member, turn.task
        if turn not in member.turns:
            return
        if error is not None:
            self._died(job, member)
            return
        member.turns.remove(turn)
        if member.turns:
            member.turns[0].begun = time.monotonic()
        if "error" in told:
            self._drop(job, turn)
            failure = error_of(told)
            if isinstance(failure, HOPELESS):
                raise failure
            self._exclude(job, member, failure)
            return
        pace = told["seconds"] / task.units
        member.pace = pace if member.pace is None else (member.pace + pace) / 2
        if turn in self._turns.get(task.key, []):
            del self._turns[task.key]
            job.take(task, told, turn.made)

    # ---- What is waited for

    def _receive(self) -> None:
        if not self._waiting:
            time.sleep(TICK)
            return
        references = list(self._waiting)
        ready, _ = self._ray.wait(references, num_returns=1, timeout=TICK)
        if len(references) > 1 and ready:
            ready, _ = self._ray.wait(references, num_returns=len(references), timeout=0)
        for reference in ready:
            then = self._waiting.pop(reference, None)
            if then is None:
                continue
            try:
                value, error = self._ray.get(reference), None
            except self._ray.exceptions.RayError as failure:
                value, error = None, failure
            then(value, error)


def error_of(told: dict[str, Any]) -> Error:
    """The error that a worker tells of."""
    name, sentence = told["error"]
    found: type[Error] = getattr(_errors, name, _errors.InternalError)
    return found(sentence)
