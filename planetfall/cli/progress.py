"""Progress of long work on the terminal."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn


@contextmanager
def counted(console: Console, what: str, total: int) -> Iterator[Callable[[int, int], None]]:
    """A bar that is told (done, total). On a dumb terminal or a file: nothing but the end."""
    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=not console.is_terminal) as bar:
        task = bar.add_task(what, total=total)
        yield lambda done, of: bar.update(task, completed=done, total=of)


@contextmanager
def settling(console: Console) -> Iterator[Callable[[float], None]]:
    """A bar from 0 to 1 for Renderer.settle; it vanishes when done."""
    columns = (TextColumn("settling"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("settling", total=1.0)
        yield lambda share: bar.update(task, completed=share)
