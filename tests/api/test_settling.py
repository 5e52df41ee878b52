"""Renderer.settle: it goes on while anything gets further, and says what does not."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

import pytest

import planetfall as pf
from planetfall.engine.frame import View
from planetfall.render.settling import settle


class Worker:
    """Gets there in so many frames; `stays`: content with that share."""

    def __init__(self, name: str, frames: float, stays: float | None = None) -> None:
        self.name, self.frames, self.stays, self.drawn = name, frames, stays, 0

    def settled(self, view: View) -> bool:
        return self.stays is not None or self.drawn >= self.frames

    def progress(self, view: View) -> float:
        return self.stays if self.stays is not None else min(self.drawn / self.frames, 1.0)


def settled_in(*workers: Worker) -> int:
    """Frames that it took: one more than the slowest needs, which is drawn with all that is done by then."""

    @contextlib.contextmanager
    def current() -> Iterator[None]:
        yield

    def frame() -> None:
        for worker in workers:
            worker.drawn += 1

    systems: Any = list(workers)
    settle(frame, View(), lambda: systems, current, None, None)
    return workers[0].drawn


def test_it_waits_for_whoever_gets_further_however_many_frames_that_takes() -> None:
    assert settled_in(Worker("clouds", 300)) == 301


def test_who_is_content_with_less_than_all_holds_nobody_up() -> None:
    """Shadows whose finest levels a view doesn't ask for, beside clouds with many rays a pixel."""
    assert settled_in(Worker("clouds", 300), Worker("shadows", 0, stays=0.8)) == 301


def test_two_of_a_name_are_told_apart() -> None:
    assert settled_in(Worker("terrain", 200), Worker("terrain", 5)) == 201


def test_who_gets_nowhere_is_named() -> None:
    with pytest.raises(pf.NotSettled, match="clouds"):
        settled_in(Worker("terrain", 3), Worker("clouds", float("inf")))


@pytest.mark.gpu
def test_light_is_measured_with_the_finished_air(tmp_path, monkeypatch):
    """The first picture of a machine, whose air has to be made, and the next, which finds it in the cache."""
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path))
    found = []
    for _ in range(2):
        with pf.load_scene("mars") as scene, pf.Renderer(scene, (64, 36), "low") as renderer:
            camera = pf.Camera.at(10.0, 20.0, 500.0, pitch_deg=-20.0, above="ground")
            renderer.settle(camera, 0.0)
            found.append((renderer.render(camera, 0.0)["color"].tobytes(), renderer.exposure))
    assert found[0][1] == found[1][1] and found[0] == found[1]
