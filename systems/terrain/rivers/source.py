"""The rivers of a ground, made once for all who ask: the renderer, samplers, cameras that stand on the ground.

While somebody tunes a planet, grounds change with each frame: `soon` keeps the rivers there were until those of the new
ground are solved in the background, and `finished` counts up when they are.
"""

from __future__ import annotations

import logging
import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent import futures
from concurrent.futures import Future, ThreadPoolExecutor

from .river_key import RiverKey
from .table import RiverTable, river_table

__all__ = ["RiverKey", "RiverSource", "source"]

log = logging.getLogger(__name__)

_KEPT = 3
"""Tables, of 30 MB on Earth."""


class RiverSource:
    """Tables by what they depend on; the last few are kept. Safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = threading.RLock()
        self._held: OrderedDict[RiverKey, RiverTable | None] = OrderedDict()
        self._jobs: dict[RiverKey, Future[RiverTable | None]] = {}
        self._wanted: RiverKey | None = None
        self._worker: ThreadPoolExecutor | None = None
        self._share = 0.0
        self.finished = 0
        """how many were solved in the background"""

    def now(self, key: RiverKey, progress: Callable[[float], None] | None = None) -> RiverTable | None:
        """The rivers, solved if need be. None where there is no land, or nothing else: water has nowhere to go."""
        with self._lock:
            if key in self._held:
                return self._used(key)
            job = self._jobs.get(key)
        if job is not None:
            return job.result()
        made = _made(key, progress)
        with self._lock:
            return self._keep(key, made)

    def soon(self, key: RiverKey, before: RiverTable | None) -> RiverTable | None:
        """As `now` where they are known; else those before, while a thread solves them."""
        with self._lock:
            if key not in self._held:
                self._begin(key)
                return before
        return self.now(key)

    def pending(self) -> bool:
        """Whether a thread still solves."""
        with self._lock:
            return bool(self._jobs)

    def progress(self, wait_s: float = 0.0) -> float:
        """Of what a thread solves, 0..1, once it is done or after some seconds."""
        with self._lock:
            jobs = list(self._jobs.values())
        if not jobs:
            return 1.0
        futures.wait(jobs, wait_s)
        return self._share if self.pending() else 1.0

    def _told(self, share: float) -> None:
        self._share = share

    def _used(self, key: RiverKey) -> RiverTable | None:
        self._held.move_to_end(key)
        return self._held[key]

    def _keep(self, key: RiverKey, made: RiverTable | None) -> RiverTable | None:
        self._held[key] = made
        while len(self._held) > _KEPT:
            self._held.popitem(last=False)
        return self._used(key)

    def _begin(self, key: RiverKey) -> None:
        """Solve in the background: of many values that a slider went through, the one at hand and the last."""
        self._wanted = key
        if self._jobs:
            return
        if self._worker is None:
            self._worker = ThreadPoolExecutor(1, "rivers")
        self._jobs[key] = self._worker.submit(self._solve, key)

    def _solve(self, key: RiverKey) -> RiverTable | None:
        made: RiverTable | None = None
        try:
            made = _made(key, self._told)
        finally:
            with self._lock:
                self._keep(key, made)
                del self._jobs[key]
                self.finished += 1
                if self._wanted is not None and self._wanted not in self._held:
                    self._begin(self._wanted)
        return made


def _made(key: RiverKey, progress: Callable[[float], None] | None) -> RiverTable | None:
    from .kept import keep_table, kept_table

    kept = kept_table(key)
    if kept is not None:
        if progress is not None:
            progress(1.0)
        return kept
    from .nodes import rivers_of_ground

    try:
        nodes = rivers_of_ground(key.params, key.climate, key.cells, key.strength, progress)
    except ValueError as error:
        log.warning("a ground without rivers: %s", error)
        return None
    if nodes is None:
        return None
    made = river_table(nodes, key.params.radius_m, key.params.seed, banks=key.banks)
    keep_table(key, made)
    return made


source = RiverSource()
"""The one of this process."""
