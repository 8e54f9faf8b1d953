"""Ways into a cluster."""

from __future__ import annotations

import importlib
import logging
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .._errors import Error

#: Seconds in which the head of a cluster has to answer.
PATIENCE = 5.0

#: Bytes of the smallest object store that Ray takes.
LEAST_STORE = 80 << 20

#: Beginning of HTTP/2, which Ray speaks: the client's preface with its empty settings, and the kind of the frame that answers.
GREETING = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, 4, 0, 0, 0, 0, 0])
SETTINGS = b"\x04"

#: Settings of Ray's environment by which it keeps to its work: no telemetry, no advice.
QUIET = {
    "RAY_USAGE_STATS_ENABLED": "0",
    "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0",
    "RAY_DISABLE_IMPORT_WARNING": "1",
    "RAY_enable_metrics_collection": "0",
    # Seconds for which a head is asked that answers and does not let anybody in.
    "RAY_NUM_REDIS_GET_RETRIES": "5",
}


class ClusterError(Error, RuntimeError):
    """A cluster that is not there, does not answer, or has no machine that can render."""


def ray_module() -> Any:
    """Ray.

    Raises :class:`ClusterError` where it is not installed.
    """
    for name, value in QUIET.items():
        os.environ.setdefault(name, value)
    try:
        return importlib.import_module("ray")
    except ImportError as error:
        raise ClusterError("renders on several machines need Ray: pip install 'raggio[cluster]'") from error


@contextmanager
def connected(address: str | None, *, logs: bool, store_bytes: int) -> Iterator[Any]:
    """Ray, connected to a cluster.

    ``address`` is that of its head, "auto" for the one that this machine is part of, "local" for this machine alone, or
    ``None``: the one that the process is connected to, else ``RAY_ADDRESS``, else "local", whose object store gets
    ``store_bytes`` or half of the memory that is free.

    Raises :class:`ClusterError` where it does not answer.
    """
    ray = ray_module()
    if ray.is_initialized():
        known = ray.get_runtime_context().gcs_address
        if address not in (None, "auto", known):
            raise ClusterError(
                f"this process is connected to the cluster at {known}: call ray.shutdown() before a render at {address}"
            )
        yield ray
        return
    address = address or os.environ.get("RAY_ADDRESS") or "local"
    options: dict[str, Any] = {"address": address, "log_to_driver": logs, "logging_level": logging.ERROR}
    if address == "local":
        memory = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
        store = max(min(store_bytes, memory // 2), LEAST_STORE)
        options.update(num_cpus=_cores(), include_dashboard=False, object_store_memory=store)
    else:
        _check_answer(address)
    try:
        ray.init(**options, configure_logging=True)
    except KeyboardInterrupt:
        raise
    except Exception as error:
        raise ClusterError(_reason(address, error)) from None
    try:
        yield ray
    finally:
        ray.shutdown()


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _check_answer(address: str) -> None:
    """Finds out whether anybody listens there: Ray itself would wait for minutes."""
    if address == "auto":
        return
    if "://" in address:
        raise ClusterError(
            f"the cluster's address is {address}: give HOST:PORT of its head, and render on a machine of the cluster or by "
            "`ray job submit`, for films do not go through Ray's client"
        )
    host, _, port = address.rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise ClusterError(f"the cluster's address is {address!r}: give HOST:PORT of its head, auto or local")
    try:
        with socket.create_connection((host.strip("[]"), int(port)), timeout=PATIENCE) as to:
            to.sendall(GREETING)
            is_head = os.environ.get("RAY_USE_TLS") == "1" or to.recv(4, socket.MSG_WAITALL)[3:] == SETTINGS
    except OSError as error:
        reason = "it does not answer" if isinstance(error, TimeoutError) else str(error.strerror or error)
        hint = f"`ray start --head --port={port}` starts one there"
        raise ClusterError(f"no cluster at {address}: {reason}; {hint}") from None
    if not is_head:
        raise ClusterError(f"no cluster at {address}: what answers there is something else; 6379 is Ray's usual port")


def _reason(address: str, error: Exception) -> str:
    """Sentence for what Ray says in many."""
    text = str(error)
    if "Version mismatch" in text or "The cluster was started with" in text:
        facts = [line.strip() for line in text.splitlines() if line.strip().startswith(("Ray:", "Python:"))]
        if len(facts) >= 4:
            theirs, ours = " and ".join(facts[:2]), " and ".join(facts[2:4])
            theirs, ours = theirs.replace(": ", " "), ours.replace(": ", " ")
            return f"the cluster at {address} has {theirs}, and this is {ours}: all machines need the same, to the last number"
    if address == "auto":
        return "this machine is not part of a cluster: `ray start --address=HOST:PORT` joins one, and `local` needs none"
    if "Failed to connect to Ray cluster" in text:
        return f"the cluster at {address} does not let this process in: where it wants its token, set RAY_AUTH_MODE=token"
    return f"no cluster at {address}: {text.strip().splitlines()[0] if text.strip() else type(error).__name__}"
