"""Frames on many machines: a Dask scheduler hands them to workers, processes that each have a GL context of their own.

What a frame is made of goes out, its files come back as bytes, and the one who asked writes them: no folder is shared.
What a lost worker was at, the scheduler gives to another one.
"""

from __future__ import annotations

import logging
import time
import uuid
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import ExitStack
from copy import copy
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

from .._version import __version__
from ..errors import SettingError
from ..systems.capture import CaptureError
from ..systems.capture.files import written_beside

__all__ = ["Farm", "kept", "land"]

log = logging.getLogger(__name__)

T = TypeVar("T")
Files = Mapping[str, bytes]
"""By their names in the folder; the one that says that the others are whole comes last."""
Work = Callable[[Any, Any], Files]

CONNECT_S = 5.0
_GO_ON = "What was made is kept: run the same command again to go on"
_ASK_AGAIN_S = 5.0  # how many workers there are
_LEAST_AHEAD = 16  # jobs with the scheduler: results wait in its workers' memory to be fetched, so not all at a time


class Farm:
    """The workers behind a scheduler's address, such as tcp://10.0.0.5:8786. SettingError, within seconds, when there
    is no such scheduler, or nothing to reach it with."""

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client
        except ImportError as error:
            told = f'scheduler: {error}; Dask distributed is an extra: pip install "planetfall[farm]"'
            raise SettingError(told) from error
        # One that never connected is told that it is closed: else the garbage collector closes it, in any thread, and
        # both wait for ever where that is within the start of another client.
        self._client = Client.__new__(Client)
        try:
            self._client.__init__(str(address), timeout=CONNECT_S, set_as_default=False, name="planetfall")
        except (OSError, ValueError, TypeError) as error:
            self._client.status = "closed"
            raise SettingError(
                f"scheduler: expected the address of a running Dask scheduler such as tcp://10.0.0.5:8786, found "
                f"{address!r}: {error}; start one with `dask scheduler` and workers with `dask worker {address}`"
            ) from error
        self._asked_s, self._threads = -_ASK_AGAIN_S, 0
        # Workers that can't import it would end at the first job, one by one.
        told: Any = self._client.run(eval, "__import__('planetfall').__version__", on_error="return")
        if wrong := {worker: found for worker, found in told.items() if found != __version__}:
            self._client.close()
            raise SettingError(f"scheduler: expected planetfall {__version__} in all workers, found {wrong!r}")

    def results(self, work: Work, common: object, jobs: Iterable[object]) -> Iterator[Files]:
        """What `work(common, job)` gives for each job, in the order of their ends, each once. work: a function at the
        top of a module. CaptureError for a job that no worker survives, and when the scheduler is gone."""
        from distributed import KilledWorker, as_completed

        mark, waiting = uuid.uuid4().hex, enumerate(jobs)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of maps that are large: they are sent once to each worker
            # Held by the scheduler as a task, it can be made again when the worker that held it is lost.
            shared = self._client.submit(copy, common, key=f"planetfall-common-{mark}")

        def submitted(count: int) -> list[Any]:
            some = list(islice(waiting, count))
            keys = [f"planetfall-{number}-{mark}" for number, _ in some]
            told = {"version": __version__, "work": work, "common": shared}
            return self._client.map(_called, [job for _, job in some], key=keys, retries=1, **told) if some else []

        ended = as_completed(submitted(self._ahead()), loop=self._client.loop, with_results=True)
        try:
            for future, files in ended:
                if future.cancelled():  # and so are all others
                    raise CancelledError(future.key)
                if ended.count() <= self._ahead() // 2:  # many at a time: a message for each costs more than most jobs
                    ended.update(submitted(self._ahead() - ended.count()))
                yield files
        except KilledWorker as error:
            what = f"a job ended each worker that it was given to ({error}); look at the workers' logs and memory"
            raise CaptureError(f"scheduler: {what}. {_GO_ON}") from error
        except CancelledError as error:
            raise CaptureError(f"scheduler: it is gone, or was restarted, and its jobs with it. {_GO_ON}") from error

    def _ahead(self) -> int:
        """How many jobs to have under way: four to a worker. Others may come at any time."""
        if time.monotonic() - self._asked_s >= _ASK_AGAIN_S:
            there: Any = self._client.nthreads()
            self._threads, self._asked_s = sum(there.values()), time.monotonic()
            if not self._threads:
                log.warning("the scheduler has no workers; start some: dask worker --nthreads 1 <its address>")
        return max(4 * self._threads, _LEAST_AHEAD)

    def __enter__(self) -> Farm:
        return self

    def __exit__(self, *_: object) -> None:
        self._client.close()


def land(root: Path, files: Files) -> None:
    """Write what came back; each is beside its place first, and the last one is written last."""
    for name, content in files.items():
        with written_beside(root / name) as beside:
            beside.write_bytes(content)


# in the workers
_own_thread = ThreadPoolExecutor(1, "planetfall")  # a GL context belongs to one thread, and Dask promises none
_kept: dict[object, tuple[Any, ExitStack]] = {}


def kept(key: object, make: Callable[[ExitStack], T]) -> T:
    """What this process has made for this key, such as a renderer; else a new one in place of that of another key.
    make: gives it, and the stack what is to be released with it."""
    if key not in _kept:
        _forget()
        stack = ExitStack()
        _kept[key] = make(stack), stack
    return _kept[key][0]


def _forget() -> None:
    while _kept:
        _kept.popitem()[1][1].close()


def _called(job: object, *, version: str, work: Work, common: object) -> Files:
    if version != __version__:  # of one that came later
        raise SettingError(f"scheduler: a worker has planetfall {__version__}, this is {version}; install the same one")
    return _own_thread.submit(_guarded, work, common, job).result()


def _guarded(work: Work, common: object, job: object) -> Files:
    try:
        return work(common, job)
    except BaseException:
        _forget()  # its context may be what is broken
        raise
