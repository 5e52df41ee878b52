"""WeatherProbe: the march that pictures are made with, evaluated on the GPU for arrays of rays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...components import Clouds
from ...engine.blocks.bindings import PLANET_BLOCK
from ...engine.frame.block import FrameBlock, PlanetBlock
from ...engine.gpu import Compute, GpuScope, StructLayout
from .field import CloudField
from .model import CloudModel
from .questions import NoiseOrigins, Questions, WeatherQuestion
from .shell_probe import march_defines
from .view_block import cloud_view_uniforms
from .view_march import MarchSteps

__all__ = ["WeatherProbe"]

Floats = NDArray[np.float64]
_BATCH = 2048
"""Questions in one dispatch: less than a second without a GPU at most qualities."""
_UNBOUNDED = 1e9
"""As in clouds/intervals.glsl: m of a ray that ends on nothing."""
_MOST_SLICES = 16
"""Of the air up to each segment's end, two points in each. Software rasterisers end loops after 65536 turns in all."""
_SUN_STEPS = 12
"""Towards the sun through each layer, at least: maps of the shadow, which spare pictures such steps, are not drawn."""


class WeatherProbe:
    """One planet's clouds at moments of their weather, and the programs that march through them.

    gpu: owner of all GL objects. component: the Clouds with the quality's overrides. Whoever asks provides the
    contracts air, sky and air_point, and binds what they read. Light comes back for a unit sun.
    """

    def __init__(self, gpu: GpuScope, component: Clouds, model: CloudModel, settings: Mapping[str, Any]) -> None:
        self._gpu, self._model, self._settings = gpu, model, settings
        # Every question is a camera of its own, and its anchor.
        gpu.shaders.add_virtual("generated/frame.glsl", f"{StructLayout(FrameBlock).glsl}FrameBlock frame;\n")
        self._planet = gpu.uniform_block(PlanetBlock, PLANET_BLOCK, "planet")
        self._planet.write(PlanetBlock(model.radius_m, 0.0, 0.0, 0.0, 0.0, has_sea=False))
        self._block = cloud_view_uniforms(gpu)
        self._field = CloudField(gpu, settings)
        self._field.filter_between_levels()
        self._field.take(component)
        self._field.light(model)
        self._shafts = bool(component.shafts)
        self._questions = Questions(gpu, WeatherQuestion, "weather_question", _BATCH)
        self._programs: dict[tuple[bool, int], Compute] = {}

    def march(
        self, positions_m: Floats, directions: Floats, suns: Floats, most_m: Floats | None, *,
        multiple: bool, sun_radius_rad: float, in_air: bool, time_s: float, pixel_rad: float,
        ground_albedo: float,
    ) -> tuple[Floats, Floats]:  # fmt: skip
        """(radiance (N, 3), transmittance (N, 3)). positions_m (N, 3) planet-centred; directions, suns (N, 3) unit;
        most_m (N,) or None: as far as rays go. They end on the reference sphere, and start no lower than it."""
        if not len(positions_m):
            return np.zeros((0, 3)), np.ones((0, 3))
        self._field.maps.charts.exact(time_s)
        self._field.place(np.zeros(3), self._model.radius_m, time_s)
        self._block.write(self._field.block)
        top_m = self._model.air_thickness_m if in_air else self._model.highest_m
        records = self._pack(positions_m, directions, suns, most_m, sun_radius_rad, pixel_rad, max(top_m, 0.0))
        program = self._program(multiple, in_air)
        program.set("u_ground", ground_albedo)
        self._planet.bind()
        self._block.bind()
        self._field.bind()
        return self._questions.ask(program, records)

    def _program(self, multiple: bool, in_air: bool) -> Compute:
        key = multiple, int(in_air)
        program = self._programs.get(key)
        if program is None:
            defines = {
                **march_defines(self._settings), "PROBE_ORDERS": "1.0" if multiple else "0.0",
                "PROBE_SLICES": min(max(int(self._settings["clouds.air_steps"]), 8), _MOST_SLICES),
                **({} if multiple else {"CLOUD_ONCE": 1}),
            }  # fmt: skip
            program = self._programs[key] = self._gpu.compute("clouds/probe/weather.comp", defines)
        steps = MarchSteps.of(self._settings)
        replace(steps, sun=max(steps.sun, float(_SUN_STEPS))).give(program)
        program.set("u_shaft_steps", int(self._settings["clouds.shaft_steps"]) if self._shafts and in_air else 0)
        program.set("u_first_shaft_step", self._field.first[1])
        return program

    def _pack(
        self, positions_m: Floats, directions: Floats, suns: Floats, most_m: Floats | None, sun_radius_rad: float,
        pixel_rad: float, top_m: float,
    ) -> NDArray[Any]:  # fmt: skip
        radius, top = self._model.radius_m, self._model.radius_m + top_m
        distance = np.linalg.norm(positions_m, axis=1)
        up = positions_m / np.maximum(distance, 1e-300)[:, None]
        # From above all there is, a ray starts where it enters that: from far away f32 knows places to metres only.
        along = (positions_m * directions).sum(1)
        miss = np.linalg.norm(np.cross(positions_m, directions), axis=1)
        away = distance > top
        meets = ~away | ((along < 0.0) & (miss < top))
        half_chord = np.sqrt(np.maximum((top - miss) * (top + miss), 0.0))
        skipped = np.where(away & meets, -along - half_chord, 0.0)
        moved = positions_m + directions * skipped[:, None]
        reach = np.linalg.norm(moved, axis=1)
        up = np.where((away & meets)[:, None], moved / np.maximum(reach, 1e-300)[:, None], up)
        # Those that miss all have nowhere to go, and no place whose square f32 could not hold.
        reach = np.where(meets, reach, top)
        h = np.maximum(np.where(away, reach, distance) - radius, 0.0)
        mu = np.clip((up * directions).sum(1), -1.0, 1.0)
        end = np.full(len(h), _UNBOUNDED)
        # The reference sphere. Products, so that nothing is lost beside it.
        b, c = (radius + h) * mu, h * (2.0 * radius + h)
        lands = (mu < 0.0) & (b * b >= c)
        root = np.sqrt(np.maximum(b * b - c, 0.0))
        end = np.where(lands, c / np.where(lands, root - b, 1.0), end)
        if most_m is not None:
            end = np.minimum(end, np.maximum(most_m - skipped, 0.0))
        end = np.where(meets, end, 0.0)
        records = np.zeros(len(h), self._questions.dtype)
        records["up"], records["height_m"] = up, h
        records["ray"], records["mu"] = directions, mu
        records["sun"], records["sun_radius_rad"] = suns, sun_radius_rad
        records["end_m"], records["pixel_rad"] = end, pixel_rad
        records["sine2"], records["skipped_m"] = (np.cross(up, directions) ** 2).sum(1), skipped
        NoiseOrigins.fill(records["origins"], self._field.places(up * (radius + h)[:, None]))
        return records
