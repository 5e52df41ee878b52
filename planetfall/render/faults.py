"""Systems that raised: which one it was, and what has to change before it is tried again."""

from __future__ import annotations

import logging
import traceback
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

from ..engine.graph import GraphError
from ..engine.settings import latest_revision
from ..engine.world import MissingError

if TYPE_CHECKING:
    from ..engine.system import System
    from ..engine.world import World
    from ..scene.scene import Scene

__all__ = ["Fault", "Faults", "draw_without_faults"]

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Fault:
    """A system that is switched off. error: what it raised. report: the traceback as text, the newest call last.
    planet: whose picture it is missing in."""

    system: str
    error: Exception
    report: str
    planet: str = ""


class _Tried(NamedTuple):
    """What a system was tried with: the revision of what it needs, the world's structure, reloads of shaders."""

    parts: int
    structure: int
    shaders: int


class Faults:
    """The systems of one renderer that are switched off because they raised.

    planet: the renderer's. others: gives the faults of further planets' renderers; `list` has them too.

    One is tried again when a component that it needs changes, when the world's structure does, when a shader was
    reloaded, or after `forget`.
    """

    def __init__(self, planet: str = "", others: Callable[[], Iterable[Faults]] = tuple) -> None:
        self._planet, self._others = planet, others
        self._off: dict[str, tuple[Fault, _Tried]] = {}
        self._shaders = 0

    def __bool__(self) -> bool:
        return bool(self.list)

    def __contains__(self, system: str) -> bool:
        return system in self._off

    @property
    def list(self) -> tuple[Fault, ...]:
        """In the order in which they happened, planet by planet."""
        further = (fault for faults in self._others() for fault in faults.list)
        return (*(fault for fault, _ in self._off.values()), *further)

    def add(self, system: System, error: Exception, world: World) -> None:
        """Switch a system off."""
        report = "".join(traceback.format_exception(error))
        self._off[system.name] = (Fault(system.name, error, report, self._planet), self._tried(system, world))
        log.error("system %r raised %s and is switched off", system.name, type(error).__name__, exc_info=error)

    def take_back(self, system: System) -> None:
        """It was not to be switched off after all: nothing can be drawn without it."""
        self._off.pop(system.name, None)

    def forget(self) -> None:
        """Try all of them again."""
        self._off.clear()

    def shaders_reloaded(self) -> None:
        """A shader is another one now: what failed with the old one may work."""
        self._shaders += 1

    def retry(self, systems: Iterable[System], world: World) -> bool:
        """Let go of those for which something has changed since they failed; whether there are any."""
        before = len(self._off)
        for system in systems:
            if system.name in self._off and self._off[system.name][1] != self._tried(system, world):
                del self._off[system.name]
        return len(self._off) != before

    def _tried(self, system: System, world: World) -> _Tried:
        return _Tried(latest_revision(*system.needs), world.structure_revision, self._shaders)


class Drawing(Protocol):
    """What draws the pictures of one planet."""

    scene: Scene
    faults: Faults
    systems: tuple[System, ...]

    def gate_again(self) -> None: ...


def draw_without_faults(planet: Drawing, draw: Callable[[], None], failed_system: Callable[[], str]) -> None:
    """Draw a frame, again without each system that raises. failed_system: the one whose pass raised, or "".

    What cannot be drawn without it (the graph doesn't compile, something is missing) raises what the system raised.
    """
    faults, world = planet.faults, planet.scene.world
    if faults and faults.retry(planet.systems, world):
        planet.gate_again()
    first: Exception | None = None
    switched_off: list[System] = []
    while True:
        try:
            draw()
            return
        except Exception as error:
            on = (s for s in planet.systems if s.name not in faults)
            failed = raised_by(error, on, failed_system())
            if failed is None or failed.essential or (first is not None and follows_from_absence(error)):
                for system in switched_off:
                    faults.take_back(system)
                planet.gate_again()
                raise first or error from None
            first = first or error
            switched_off.append(failed)
            faults.add(failed, error, world)
            planet.gate_again()


def raised_by(error: BaseException, systems: Iterable[System], in_pass: str) -> System | None:
    """The system whose code raised, found on the traceback; in_pass: name of the system whose pass was running."""
    by_id = {id(system): system for system in systems}
    trace, found = error.__traceback__, None
    while trace is not None:
        owner = trace.tb_frame.f_locals.get("self")
        if id(owner) in by_id and found is None:
            found = by_id[id(owner)]
        trace = trace.tb_next
    return found or next((s for s in by_id.values() if s.name == in_pass), None)


def follows_from_absence(error: BaseException) -> bool:
    """Whether an error says that something isn't there that another system would have made."""
    return isinstance(error, GraphError | MissingError)
