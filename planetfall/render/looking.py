"""Looking: questions to a renderer about what it drew, and what is inside."""

from __future__ import annotations

from collections import Counter
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..engine.space import CameraState, project
from ..query.terrain import checked_directions
from ..systems.composite import CompositeSystem
from . import queries
from .several_planets import SeveralPlanets, by_nearest

if TYPE_CHECKING:
    from ..camera.camera import Camera
    from ..camera.views import View
    from ..engine.gpu import Gpu, ShaderError
    from ..engine.graph import Plan
    from ..engine.surface.field import HeightField
    from ..engine.system import System
    from .drawn_ground import DrawnGround
    from .renderer import Renderer

__all__ = ["Looking"]


class Looking:
    """The part of a Renderer that only looks: it draws nothing but what a question needs."""

    size: tuple[int, int]
    systems: tuple[System, ...]
    _scopes: dict[str, Any]
    _ground: DrawnGround
    _several: SeveralPlanets

    if TYPE_CHECKING:

        def camera_state(self, camera: Camera | View) -> CameraState: ...
        @property
        def running(self) -> tuple[System, ...]: ...
        def _require_plan(self) -> Plan: ...
        def _guest(self) -> AbstractContextManager[Any]: ...

    # -- queries -----------------------------------------------------------------------------------------------------

    @by_nearest
    def project(self, camera: Camera | View, points_m: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Pixels (N, 2), row 0 on top, of points (N, 3) in planet axes, and which lie in front of the camera."""
        return project(self.camera_state(camera), np.atleast_2d(np.asarray(points_m, np.float64)), self.size)

    @by_nearest
    def pick(self, camera: Camera | View, x: float, y: float) -> tuple[NDArray[np.float64], str] | None:
        """What pixel (x, y) shows: position_m (3,) f64 in planet axes and "terrain", "sea" or "props"; None for the
        sky."""
        return queries.pick(cast("Renderer", self), camera, x, y)

    def planet_at(self, camera: Camera | View, x: float, y: float, time_s: float = 0.0) -> str | None:
        """The name of the planet whose sphere pixel (x, y) shows, or shows next behind hills; None for the sky."""
        return queries.planet_at(cast("Renderer", self), camera, x, y, time_s)

    def height_drawn(self, directions: ArrayLike) -> NDArray[np.float64]:
        """Heights (N,) in metres of the ground as the last frame's level of detail shows it; NaN where it drew none.

        ValueError for anything but directions (N, 3), finite and not zero.
        """
        front = self._several.front
        if front is not self:
            return front.height_drawn(directions)
        return queries.height_drawn(cast("Renderer", self), checked_directions("directions", directions))

    def height_field(self) -> HeightField | None:
        """The ground that is drawn, at full detail on the CPU; None without Terrain. See Scene.height_field.

        In a scene of several planets that of the planet which the last frame's camera was near, as for all below.
        """
        return self._several.renderer._ground.field()

    @property
    def main(self) -> str:
        """The name of the planet that the last frame's camera was near: the only one, or the one that no other planet
        can stand before."""
        return self._several.main

    # -- looking inside ----------------------------------------------------------------------------------------------

    def passes(self) -> list[Any]:
        """What ran in the last frame and what was skipped, and why: PassReport objects of the frame graph."""
        return list(self._require_plan().passes)

    @property
    def graph(self) -> Plan:
        """The compiled frame graph: explain(), to_mermaid(), memory_bytes(), resource()."""
        return self._require_plan()

    @property
    def stats(self) -> dict[str, int]:
        """Cells, vertices and triangles drawn in the last frame, ground and sea together. Reads back from the GPU."""
        with self._guest():
            return queries.statistics(self._several.renderer.running)

    @property
    def memory_bytes(self) -> dict[str, int]:
        """GPU memory of textures and buffers by owner: systems by name, "graph" for what frames share; in a scene of
        several planets the sum over all."""
        found: Counter[str] = Counter()
        for gpu in self._gpus:
            found.update(gpu.memory_bytes())
        return dict(found)

    @property
    def shader_errors(self) -> list[ShaderError]:
        """The current error of each program that could not be rebuilt after a change on disk, of all planets."""
        found = {str(error): error for gpu in self._gpus for error in gpu.shaders.errors}
        return list(found.values())

    @property
    def _gpus(self) -> list[Gpu]:
        return [cast("Renderer", self).gpu, *self._several.gpus()]

    @property
    def refining(self) -> tuple[str, ...]:
        """What is still being made of what the last frame showed, such as "ground 63 %"; empty when all is there."""
        return tuple(text for system in self._several.renderer.running if (text := system.refining()))

    @property
    def exposure(self) -> float | None:
        """EV100 of the last picture; None before the first and after one without colours. Reads back from the GPU."""
        if self._several.renderer is not self:
            return self._several.renderer.exposure
        composite = self.system("composite")
        if not isinstance(composite, CompositeSystem) or not composite.exposed:
            return None
        with self._guest():
            return composite.reading().ev100

    def system(self, name: str) -> System | None:
        """The active system of that name, or None."""
        if self._several.renderer is not self:
            return self._several.renderer.system(name)
        return next((s for s in self.systems if s.name == name and name in self._scopes), None)
