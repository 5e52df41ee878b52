"""`planetfall share`: a scene with its maps in one file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from .options import Planet
from .progress import written

__all__ = ["share_command"]


def share_command(planet: Planet, *, output: Annotated[Path, Parameter(name=["--output", "-o"])]) -> None:
    """Pack a scene file, with the height and colour maps that it names, into one file that opens on any machine.

    Parameters
    ----------
    output
        The file, which ends in .planetfall. Every command takes it where it takes a planet.
    """
    from .. import load_scene

    with load_scene(planet) as scene:
        written(scene.share(output))
