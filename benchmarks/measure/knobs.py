"""What a knob costs and what it shows: the two pictures of its pair, frames of both timed against one another."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, DebugView, Renderer, view
from ..knobs import Pair, changed, component
from ..scenes import preset_scene
from ..timing import Timing, time_variants
from .flip import flip

TURN_DEG = 0.01
SIDES = ("off", "on")


@dataclass(frozen=True)
class KnobCost:
    """One knob: frames with both values, and how different the pictures look."""

    on_value: Any
    off_value: Any
    on: Timing
    off: Timing
    mean_flip: float | None
    """Mean over the picture; None where the package flip-evaluator is missing."""
    worst_flip: float | None

    @property
    def ratio(self) -> float:
        """Time with the knob on over time with it off."""
        return self.on.ms / self.off.ms

    @property
    def apart(self) -> bool:
        """Whether 80 % of the one's frames took longer than 80 % of the other's: a difference beyond the noise."""
        return self.on.low_ms > self.off.high_ms or self.off.low_ms > self.on.high_ms


class KnobMeter:
    """Two renderers for each set of planet and quality keys, one for each value; the last sets are kept.

    Use as a context manager. Each renderer has a scene of its own, so that a frame never pays for a change of the knob.
    """

    KEEP = 2

    def __init__(self, size: tuple[int, int], quality: str = "medium") -> None:
        self.size, self.quality = size, quality
        self.renderers: OrderedDict[tuple[Any, ...], Renderer] = OrderedDict()

    def knob(self, key: str, pair: Pair, runs: int) -> KnobCost:
        """Of a component's knob, in the view of its pair."""
        sides = {side: self._renderer(pair.planet, side, {}, pair.clouds) for side in SIDES}
        table, field = key.split(".")
        with ExitStack() as stack:
            values = []
            for side, value in zip(SIDES, (pair.off, pair.on), strict=True):
                stack.enter_context(changed(sides[side].scene, pair.changes(key, value)))
                values.append(getattr(component(sides[side].scene, table), field))
            return _compare(sides, values, pair.view, pair.free, runs)

    def quality_knob(self, key: str, values: tuple[Any, Any], place: tuple[str, str], runs: int) -> KnobCost:
        """Of a quality key with two values (off, on), at (planet, view)."""
        clouds = key.startswith("clouds.")
        sides = {side: self._renderer(place[0], side, {key: v}, clouds) for side, v in zip(SIDES, values, strict=True)}
        return _compare(sides, values, place[1], False, runs)

    def _renderer(self, planet: str, side: str, overrides: Mapping[str, Any], clouds: bool = False) -> Renderer:
        key = (planet, side, tuple(overrides.items()), clouds)
        if key not in self.renderers:
            while len(self.renderers) >= self.KEEP * 2:
                _release(self.renderers.popitem(last=False)[1])
            scene = preset_scene(planet, clouds)
            scene.environment.add(DebugView())
            self.renderers[key] = Renderer(scene, self.size, self.quality, overrides)
        self.renderers.move_to_end(key)
        return self.renderers[key]

    def __enter__(self) -> KnobMeter:
        return self

    def __exit__(self, *_: object) -> None:
        while self.renderers:
            _release(self.renderers.popitem()[1])


def _release(renderer: Renderer) -> None:
    scene = renderer.scene
    renderer.release()
    scene.release()


def _compare(sides: Mapping[str, Renderer], values: Sequence[Any], name: str, free: bool, runs: int) -> KnobCost:
    pictures: dict[str, NDArray[np.uint8]] = {}
    with ExitStack() as stack:
        frames: dict[str, Callable[[], None]] = {}
        for side, renderer in sides.items():
            seen = view(name, renderer.scene.planet)
            sun = seen.sun or renderer.scene.sun
            shot = Camera(seen.position_m, seen.forward, seen.up, seen.fov_y_deg) if free else seen
            renderer.settle(shot, seen.time_s, sun)
            pictures[side] = renderer.render(shot, seen.time_s, sun)["color"]
            frames[side] = stack.enter_context(_turning(renderer, seen, sun))
        times = time_variants(frames, runs, 2)
    try:
        error = flip(pictures["off"], pictures["on"])
    except ImportError:
        return KnobCost(values[1], values[0], times["on"], times["off"], None, None)
    return KnobCost(values[1], values[0], times["on"], times["off"], float(error.mean()), float(error.max()))


@contextmanager
def _turning(renderer: Renderer, seen: Any, sun: Any) -> Iterator[Callable[[], None]]:
    """A frame that ends with the GPU's work, its camera turned to and fro: what a flight's frame costs."""
    target = renderer.ctx.simple_framebuffer(renderer.size)
    aside = np.radians(TURN_DEG) * np.cross(seen.forward, seen.up)
    cameras = [Camera(seen.position_m, seen.forward + k * aside, seen.up, seen.fov_y_deg) for k in (0.0, 1.0)]

    def frame() -> None:
        cameras.reverse()
        renderer.render_to(target, cameras[0], seen.time_s, sun)
        renderer.ctx.finish()

    try:
        yield frame
    finally:
        renderer.gpu.leave(target)
        target.release()
