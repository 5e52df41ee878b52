"""Suite capture: what handing a frame to another process costs beside making it here."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path

from ...capture.farm import Farm, land
from ...errors import SettingError
from ..session import Bench, Session
from ..target import at_most

__all__ = ["BENCHES"]

_PAUSE_S = 0.05
"""In place of a frame: neither side has work for the cores meanwhile."""


def _paused(content: bytes, number: int) -> dict[str, bytes]:
    """A job of a worker: files by name."""
    time.sleep(_PAUSE_S)
    return {f"{number:05d}.bin": content}


def _farm(session: Session) -> None:
    """Milliseconds more a frame with one worker behind a Dask scheduler of this machine, by the size of its file: the
    least of three rounds."""
    try:
        from distributed import LocalCluster
    except ImportError as error:
        raise SettingError(f'{error}; pip install "planetfall[farm]"') from error
    frames = 10 if session.extent == "quick" else session.runs(100, 30)
    cluster = LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=":0")
    with cluster:
        for size in (1_000, 1_000_000, 4_000_000):
            content, more_ms = os.urandom(size), []
            for _ in range(3):
                with tempfile.TemporaryDirectory() as here, tempfile.TemporaryDirectory() as there:
                    start = time.perf_counter()
                    for number in range(frames):
                        land(Path(here), _paused(content, number))
                    own = time.perf_counter() - start
                    with Farm(cluster.scheduler_address) as farm:
                        list(farm.results(_paused, content, range(2)))  # it has the content from now on
                        start = time.perf_counter()
                        for files in farm.results(_paused, content, range(frames)):
                            land(Path(there), files)
                        more_ms.append(1e3 * (time.perf_counter() - start - own) / frames)
            session.row(
                f"a frame of {size / 1e6:g} MB", error=min(more_ms), error_unit="ms more",
                target=at_most(5.0, "ms more"), most_ms=max(more_ms), frames=frames,
            )  # fmt: skip


BENCHES: Mapping[str, Bench] = {"farm": _farm}
