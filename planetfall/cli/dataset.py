"""`planetfall dataset`: many pictures with labels and poses, from a plan."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from .progress import counted, written

__all__ = ["dataset_command"]


def dataset_command(
    plan: Path,
    *,
    frames: str = ":",
    scheduler: str | None = None,
    output: Annotated[Path, Parameter(name=["--output", "-o"])] = Path("dataset"),
) -> None:
    """Render pictures of seeded cameras, suns and planets, with labels and poses; goes on where it was interrupted.

    Parameters
    ----------
    plan
        A TOML file: see docs/data-sets.md.
    frames
        A:B, those from A up to, not with, B alone: for several machines, whose folders are then put together.
    scheduler
        Address of a Dask scheduler, such as tcp://10.0.0.5:8786, whose workers make the frames (extra 'farm').
    output
        The folder; made when missing.
    """
    from ..capture.dataset import dataset
    from ..capture.dataset_plan import parse_range, read_plan

    read = read_plan(plan)
    wanted = parse_range(frames, read.count)
    with counted("frames", len(wanted)) as progress:
        root = dataset(read, output, frames=wanted, scheduler=scheduler, progress=progress)
    written(root / "frames.jsonl", root / "manifest.json")
