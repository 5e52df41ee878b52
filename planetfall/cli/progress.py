"""What the commands say: written files on stdout, a line each, for a pipe as well; all else on stderr, for people."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

console = Console(stderr=True)


def written(*files: Path | None) -> None:
    """Say which files there are now; None is one that was not asked for."""
    sys.stdout.writelines(f"{file}\n" for file in files if file is not None)


@contextmanager
def counted(what: str, total: int) -> Iterator[Callable[[int, int], None]]:
    """A bar that is told (done, total). On what is no terminal: nothing."""
    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task(what, total=total)
        yield lambda done, of: bar.update(task, completed=done, total=of)


@contextmanager
def settling(what: str = "settling") -> Iterator[Callable[[float], None]]:
    """A bar from 0 to 1, as for Renderer.settle; it vanishes when done."""
    columns = (TextColumn(what), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)
