"""Suite frame, bench skipping: what scenes that lack something still pay, beside the full scene."""

from __future__ import annotations

from typing import Any

from ... import view
from ..measure import frames, skipping
from ..measure.skipping import (
    BARE,
    FULL,
    LIGHT_SYSTEMS,
    SKY_STAGES,
    STAGES,
    counts,
    pass_times,
    running_case,
    timed_together,
    update_times,
)
from ..session import Session
from ..target import at_most

__all__ = ["bench"]

SIZE, QUICK_SIZE = (640, 360), (192, 108)
QUICK_STAGES = ("airless moon", "paused, still camera", "planet behind the camera")
"""Each stage settles with its clouds, which takes its time."""
VIEWS = ("near", "high", "orbit")
MOST_PAUSED, MOST_MOON, MOST_UNSEEN_MS = 0.05, 1.1, 0.2
_FOREIGN = ("imgui_bundle", "glfw", "pyglet", "moderngl_window", "scipy", "matplotlib")
"""Packages that a picture without a window and a user interface has no use for."""


def bench(session: Session) -> None:
    """What runs again although nothing has changed, and what scenes and views that need less still pay."""
    _unchanged(session)
    _stages(session)
    _skies(session)
    _imports(session)


def _unchanged(session: Session) -> None:
    with session.renderer("earth", SIZE, "medium") as renderer:
        for name in VIEWS:
            found = frames.skipping(renderer, view(name))
            session.row(
                "selected or made again", name, error=len(found.ran_again), target=at_most(0),
                which=", ".join(found.ran_again), passes=found.passes, skipped=found.skipped,
            )  # fmt: skip
            session.row("uploads of an unchanged frame", name, error=found.uploads, target=at_most(0))
            session.row("triangles drawn out of view", name, error=found.drawn_out_of_view, target=at_most(0))


def _stages(session: Session) -> None:
    """One row a stage; all but the first are timed in turns with the full scene."""
    session.release()
    size, runs = QUICK_SIZE if session.small else SIZE, session.runs(9, 4)
    with running_case(FULL, size) as full:
        light_ms = sum(pass_times(full, runs, LIGHT_SYSTEMS).values())
        found = counts(full)
        both = timed_together({"full": full.frame}, runs)["full"]
        session.row(FULL.name, FULL.view, size, both.timing, cpu_ms=both.cpu_ms, **_columns(found))
        for stage in STAGES:
            if session.small and stage.name not in QUICK_STAGES:
                continue
            with running_case(stage, size) as shown:
                found = counts(shown)
                both = timed_together({"full": full.frame, "stage": shown.frame}, runs)
                ratio = both["stage"].cpu_ms / both["full"].cpu_ms
                row: dict[str, Any] = {"cpu_ms": both["stage"].cpu_ms, "of_full": ratio, **_columns(found)}
                where = f"{stage.planet}: {stage.view}" if stage.planet != "earth" else stage.view
                if stage.paused:
                    session.row(stage.name, where, size, both["stage"].timing, target=at_most(MOST_PAUSED),
                                target_on="of_full", **row)  # fmt: skip
                elif stage.planet == "moon":
                    ours_ms = sum(pass_times(shown, runs, LIGHT_SYSTEMS).values())
                    session.row(stage.name, where, size, both["stage"].timing, target=at_most(MOST_MOON),
                                target_on="of_light", of_light=ours_ms / light_ms, **row)  # fmt: skip
                else:
                    session.row(stage.name, where, size, both["stage"].timing, **row)
                if stage.name == "planet behind the camera":
                    _unseen(session, shown, size, runs)


def _unseen(session: Session, shown: skipping.RunningCase, size: tuple[int, int], runs: int) -> None:
    """What a planet costs that nobody sees: beside one that has neither ground nor sea, air and clouds."""
    with running_case(BARE, size) as bare:
        # Many: what is looked for is a hundredth of a frame.
        both = timed_together({"unseen": shown.frame, "bare": bare.frame}, 60 * runs)
        more_ms = both["unseen"].cpu_ms - both["bare"].cpu_ms
        session.row("bare planet behind the camera", "orbit", size, both["bare"].timing, cpu_ms=both["bare"].cpu_ms,
                    **_columns(counts(bare)))  # fmt: skip
        session.row("what a planet out of view adds", "orbit", size, target=at_most(MOST_UNSEEN_MS, "ms"),
                    target_on="added_ms", added_ms=more_ms)  # fmt: skip


def _skies(session: Session) -> None:
    """What ground and sea cost while only air is in the picture: their updates and whatever passes of theirs run."""
    session.release()
    size, runs, systems = QUICK_SIZE if session.small else SIZE, session.runs(120, 40), ("terrain", "ocean")
    for stage in SKY_STAGES[: 1 if session.small else None]:
        with running_case(stage, size, "low" if session.small else "medium") as shown:
            updates = update_times(shown, runs, systems)
            passes_ms = sum(pass_times(shown, 5, systems).values())
            row: dict[str, Any] = {f"{name}_ms": ms for name, ms in updates.items()}
            session.row(stage.name, stage.view, size, target=at_most(MOST_UNSEEN_MS, "ms"), target_on="ground_ms",
                        ground_ms=sum(updates.values()) + passes_ms, passes_ms=passes_ms, **row)  # fmt: skip


def _columns(found: skipping.Counts) -> dict[str, Any]:
    return {
        "passes": len(found.ran), "draws": found.draws, "dispatches": found.dispatches, "uploads": found.uploads,
        "gl_objects": found.gl_objects, "programs": found.programs, "systems": len(found.systems),
    }  # fmt: skip


def _imports(session: Session) -> None:
    """Modules of a process that has rendered a picture, and what a bare world does without."""
    whole, bare = skipping.imports_of("earth"), skipping.imports_of("moon", bare=True)
    foreign = sorted({name.partition(".")[0] for name in whole} & set(_FOREIGN))
    session.row("packages of windows and user interfaces imported", error=len(foreign), target=at_most(0),
                which=", ".join(foreign))  # fmt: skip
    kept = [name for name in bare if ".systems." in name and name.split(".systems.")[1].split(".")[0] in _ABSENT]
    session.row("modules of absent features imported", "moon: near", error=len(kept), target=at_most(0),
                modules=len(bare), modules_of_earth=len(whole))  # fmt: skip


_ABSENT = ("atmosphere", "clouds", "ocean", "props")
"""Folders of systems that the moon has no use for. Of `debug` the names of its views are always known."""
