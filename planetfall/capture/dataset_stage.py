"""A scene as each frame of a plan has it: with the knobs that the frame draws, and its camera, sun and time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from ..camera.camera import Camera
from ..camera.flights import ScenePath, over_scene
from ..camera.light import light_of
from ..components import Sun
from ..engine.settings import PresetError
from ..engine.space import latitude_longitude
from ..errors import SceneError
from ..quality import QUALITY, resolve_quality
from ..scene.kinds import KINDS, PLANET_KINDS
from ..scene.scene import Scene
from .dataset_plan import DatasetPlan, Drawn

__all__ = ["Stage", "Staged"]


@dataclass(frozen=True)
class Staged:
    """What a frame is rendered with. sun: None is the scene's."""

    camera: Camera
    sun: Sun | None
    time_s: float


class Stage:
    """A scene of a plan. PresetError, before any GPU work, for knobs of what it hasn't, and for frames whose knobs
    don't fit together."""

    def __init__(self, plan: DatasetPlan, scene: Scene) -> None:
        self.scene = scene
        self._plan = plan
        self._settings = resolve_quality(plan.quality, plan.overrides)
        self._flight: ScenePath | None = None
        for key in plan.varied:
            self._component(key)
        # Overrides of sun, planet and wind mean nothing to a renderer; here they are those of the scene.
        known = {key: value for key, value in plan.overrides.items() if key in QUALITY.component_rules}
        for key, value in known.items():
            if (found := self._found(key)) is not None:
                setattr(found, key.partition(".")[2], value)

    def check(self, numbers: Iterable[int]) -> None:
        """Whether the knobs of these frames fit together."""
        if not self._plan.varied:
            return self.scene.validate(self._settings)
        for number in numbers:
            drawn = self._plan.frame(number)
            self._assign(drawn)
            try:
                self.scene.validate(self._settings)
            except SceneError as error:
                raise PresetError(f"{self._plan.path}: frame {number} draws {dict(drawn.knobs)!r}: {error}") from error

    def frame(self, drawn: Drawn) -> Staged:
        """Gives the scene the frame's knobs."""
        self._assign(drawn)
        if drawn.camera is not None:
            assert drawn.sun is not None
            return Staged(drawn.camera, replace(drawn.sun, **light_of(self.scene)), drawn.time_s or 0.0)
        assert self._plan.flight is not None
        if self._flight is None:  # its ground takes a second to look up
            self._flight = over_scene(self._plan.flight, self.scene)
        at_s = self._flight.times_s(self._plan.count)[drawn.number]
        camera, sun = self._flight.camera_at(at_s), drawn.sun or self._flight.sun
        if drawn.sun is not None:
            latitude, longitude = map(float, latitude_longitude(camera.position_m))
            sun = replace(drawn.sun, latitude_deg=latitude, longitude_deg=longitude, **light_of(self.scene))
        lens = self._plan.intrinsics
        return Staged(camera if lens is None else camera.with_intrinsics(lens), sun,
                      at_s if drawn.time_s is None else drawn.time_s)  # fmt: skip

    def _assign(self, drawn: Drawn) -> None:
        for key, value in drawn.knobs.items():
            component, name = self._component(key), key.partition(".")[2]
            if getattr(component, name) != value:
                setattr(component, name, value)

    def _component(self, key: str) -> Any:
        found = self._found(key)
        if found is None:
            table = key.partition(".")[0]
            raise PresetError(
                f"{self._plan.path}: overrides: {key}: scene {self.scene.name!r} has no {KINDS[table].__name__}; leave "
                "the knob or the scene out"
            )
        return found

    def _found(self, key: str) -> Any:
        """The component of a knob; None where the scene has none."""
        table = key.partition(".")[0]
        handle = self.scene.planet if table in PLANET_KINDS else self.scene.environment
        return handle.get(KINDS[table])
