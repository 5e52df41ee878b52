"""What a pass did in the last frame, as data."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .checked import Checked


@dataclass(frozen=True, slots=True)
class PassReport:
    """What one pass did in the last frame.

    ran, skipped_why: None when it ran. cpu_ms: wall time of its closure and gate in Python. gpu_ms: None unless GPU
    timing is on, and a few frames late. reads: with history; writes: with what it creates. bytes: memory of what it
    creates (an object that transients share counts for each of them). view, planet: whose it is, None: shared; name,
    reads and writes have the indices in them that aren't 0.
    """

    name: str
    system: str
    ran: bool
    skipped_why: str | None
    cpu_ms: float
    gpu_ms: float | None
    reads: tuple[str, ...]
    writes: tuple[str, ...]
    bytes: int
    view: int | None = None
    planet: int | None = None


def make_report(
    analysis: Checked,
    i: int,
    bytes_of: Callable[[str], int],
    skipped_why: str | None,
    cpu_ms: float = 0.0,
    gpu_ms: float | None = None,
) -> PassReport:
    """The report of pass i."""
    decl = analysis.model.passes[i]
    ran = skipped_why is None
    return PassReport(
        name=decl.name,
        system=decl.system,
        ran=ran,
        skipped_why=skipped_why,
        cpu_ms=cpu_ms,
        gpu_ms=gpu_ms if ran else None,
        reads=tuple(dict.fromkeys((*analysis.model.reads[i], *decl.history))),
        writes=(*(spec.name for spec in decl.creates), *decl.writes),
        bytes=sum(bytes_of(spec.name) for spec in decl.creates),
        view=decl.scope.view,
        planet=decl.scope.planet,
    )
