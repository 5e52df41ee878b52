"""One run of a suite: what its benches share, and where their rows go."""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .. import __version__
from .machine import current_commit, describe_machine, now_utc
from .schema import Extent, Machine, Report, Row
from .target import Target
from .timing import Timing

if TYPE_CHECKING:
    from .. import Renderer, Scene
    from ..engine.gpu import Gpu
    from ..engine.gpu.caps import Capabilities

log = logging.getLogger(__name__)

Bench = Callable[["Session"], None]
Progress = Callable[[str, int, int], None]


class Session:
    """What a bench gets: a GPU, renderers, how thorough to be, and `row()` for its results.

    At most one context is alive at a time, and it is made when a bench asks for it, so that suites without GL run on
    machines without GL.
    """

    def __init__(self, suite: str, extent: Extent = "usual", peer_results: Path | None = None) -> None:
        self.suite = suite
        self.extent: Extent = extent
        self.peer_results = peer_results
        """Folder of what a peer took, for suite `peers`."""
        self.rows: list[Row] = []
        self.skipped: dict[str, str] = {}
        self.bench = ""
        self._gpu: Gpu | None = None
        self._caps: Capabilities | None = None

    # -- for benches --------------------------------------------------------------------------------------------------

    @property
    def small(self) -> bool:
        """Whether few runs and small samples do: in all but full runs."""
        return self.extent != "full"

    def runs(self, full: int, small: int) -> int:
        """How many runs."""
        return small if self.small else full

    @property
    def gpu(self) -> Gpu:
        """A Gpu with the library's shaders on a headless context, until the next renderer() or release()."""
        if self._gpu is None:
            from .. import ASSETS
            from ..engine.gpu import Gpu
            from ..engine.hosts.headless import create_headless

            self._gpu = Gpu(create_headless(), [ASSETS / "shaders"])
            self._caps = self._gpu.caps
        return self._gpu

    @contextlib.contextmanager
    def renderer(
        self,
        scene: Scene | str = "earth",
        size: tuple[int, int] = (640, 360),
        quality: str = "medium",
        overrides: Mapping[str, Any] | None = None,
        clouds: bool = False,
    ) -> Iterator[Renderer]:
        """A renderer on a context of its own, released afterwards. clouds: whether a preset keeps its own."""
        from .. import Renderer
        from .scenes import preset_scene

        self.release()
        made = Renderer(preset_scene(scene, clouds) if isinstance(scene, str) else scene, size, quality, overrides)
        self._caps = made.gpu.caps
        try:
            yield made
        finally:
            made.release()

    def row(
        self,
        variant: str = "",
        view: str = "",
        size: tuple[int, int] | None = None,
        timing: Timing | None = None,
        error: float | None = None,
        error_unit: str = "",
        target: Target | None = None,
        target_on: str = "error",
        **extra: Any,
    ) -> Row:
        """Add a result. target_on: "error", "ms", or the name of an extra that the target is about."""
        row = Row(
            suite=self.suite,
            bench=self.bench,
            variant=variant,
            view=view,
            size=size,
            error=None if error is None else float(error),
            error_unit=error_unit,
            extra={key: _plain(value) for key, value in extra.items()},
            **({} if timing is None else timing.columns()),
        )
        if target is not None:
            value = {"error": row.error, "ms": row.ms}.get(target_on, row.extra.get(target_on))
            found = float(value) if isinstance(value, int | float) else float("nan")
            row.target = str(target) if target_on in ("error", "ms") else f"{target_on} {target}"
            row.met = target.met(found)
        self.rows.append(row)
        return row

    # -- for the command ----------------------------------------------------------------------------------------------

    def run(
        self, benches: Mapping[str, Bench], progress: Progress | None = None, left_out: Iterable[str] = ()
    ) -> Report:
        """Run the benches one by one. One that raises is noted under `skipped`, and the others still run. left_out:
        names of the suite's benches that are not among them, for the record."""
        started, date = time.monotonic(), now_utc()
        seconds: dict[str, float] = {}
        for number, (name, bench) in enumerate(benches.items()):
            if progress is not None:
                progress(name, number, len(benches))
            self.bench, began = name, time.monotonic()
            try:
                bench(self)
            except Exception as error:
                log.warning("bench %s.%s failed", self.suite, name, exc_info=True)
                self.skipped[name] = f"{type(error).__name__}: {error}"
            seconds[name] = round(time.monotonic() - began, 1)
        if progress is not None:
            progress("", len(benches), len(benches))
        return Report(
            kind="bench",
            suite=self.suite,
            planetfall=__version__,
            commit=current_commit(),
            date=date,
            duration_s=round(time.monotonic() - started, 1),
            extent=self.extent,
            left_out=list(left_out),
            seconds=seconds,
            machine=self.machine(),
            rows=self.rows,
            skipped=self.skipped,
        )

    def machine(self) -> Machine:
        """The machine; without OpenGL its GL fields are empty."""
        if self._caps is None:
            with contextlib.suppress(Exception):
                self._caps = self.gpu.caps
        return describe_machine(self._caps)

    def release(self) -> None:
        """Free the context, if there is one."""
        if self._gpu is not None:
            self._gpu.release()
            self._gpu.ctx.release()
            self._gpu = None

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def _plain(value: Any) -> bool | int | float | str | None:
    """numpy scalars as Python's own."""
    return value.item() if hasattr(value, "item") else value
