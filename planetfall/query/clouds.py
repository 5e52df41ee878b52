"""CloudProbe: a march through clouds and air on the GPU, asked from Python."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..components import Atmosphere, Clouds, Planet, Wind
from ..components.wind import blown
from ..engine.blocks.bindings import AIR_BLOCK
from ..engine.gpu import UniformBlock
from ..engine.settings import with_overrides
from ..quality import resolve_quality
from ..systems.atmosphere.block import AirBlock, air_block
from ..systems.atmosphere.model import AirModel
from ..systems.atmosphere.sizes import table_sizes
from ..systems.atmosphere.tables import AirTables
from ..systems.clouds.imported import imported_cover
from ..systems.clouds.model import CloudModel
from ..systems.clouds.shell_probe import ShellProbe
from ..systems.clouds.weather_probe import WeatherProbe
from .probe import Probe
from .questions import question_distances, question_number, question_rows

if TYPE_CHECKING:
    from ..scene.scene import PlanetHandle, Scene

__all__ = ["CloudProbe"]

Floats = NDArray[np.float64]
_VISIBILITIES = ("disc", "point")


class CloudProbe(Probe):
    """Light that comes along rays through a scene's clouds and air, on arrays of f64 questions.

    It marches on the GPU at the step sizes of `quality`, errors of the march and all. Where every layer is
    density_model "uniform" that is a march of its own, whose optical depths are exact; clouds with weather are marched
    as pictures of them are, shafts of light included, by rays of no width at the middles of their steps. What pictures
    read from maps or tables around a camera (the way from clouds to the sun, the air in front of them) is marched, too.
    A snapshot of the scene when it was made, at the wavelengths of its numbers, as AtmosphereProbe.

        with pf.CloudProbe(scene, quality="reference") as clouds:
            radiance, transmittance = clouds.march(position, direction, sun)

    ctx: a host's current moderngl context; None makes a headless one. as_pictures: march through uniform layers as
    pictures do, too. ValueError for a planet without Clouds, for wrong shapes, NaN, zero directions and positions, an
    imported map that can't be read; SettingError for clouds or air that cannot be.
    """

    def __init__(
        self,
        scene: Scene,
        ctx: moderngl.Context | None = None,
        quality: str = "high",
        overrides: Mapping[str, Any] | None = None,
        planet: PlanetHandle | None = None,
        as_pictures: bool = False,
    ) -> None:
        handle = scene.planet if planet is None else planet
        self._settings = resolve_quality(quality, overrides)
        clouds = handle.get(Clouds)
        if clouds is None:
            raise ValueError(
                "CloudProbe: the planet has no Clouds component; add one with scene.planet.add(pf.Clouds())"
            )
        sun, air = scene.sun, handle.get(Atmosphere)
        self._irradiance = np.asarray(sun.irradiance, np.float64)
        self._sun_radius_rad = float(sun.angular_radius_rad)
        air = None if air is None else with_overrides(air, "atmosphere", self._settings)
        clouds = blown(with_overrides(clouds, "clouds", self._settings), handle.get(Wind))
        self._clouds = CloudModel.from_components(handle[Planet], clouds, air)
        self._weather = as_pictures or not self._clouds.uniform
        if self._weather and self._clouds.printed:
            raise ValueError(
                f"CloudProbe: Clouds.method {self._clouds.method!r} marches through layers of density_model 'uniform'"
                " only, and not as_pictures; set Clouds.method = 'ours', or make all layers uniform"
            )
        # A snapshot: components may change later. A map that can't be read is told of now.
        self._component = copy.deepcopy(clouds)
        if self._weather and clouds.weather_map:
            imported_cover(clouds.weather_map)
        self._air = None
        if air is not None:
            self._air = AirModel.from_components(handle[Planet], air, self._sun_radius_rad)
        super().__init__(ctx)
        self._air_block: UniformBlock | None = None
        self._asked: dict[bool, ShellProbe] = {}
        self._asked_weather: WeatherProbe | None = None
        self._tables: dict[int, AirTables] = {}

    def march(
        self,
        positions_m: ArrayLike,
        directions: ArrayLike,
        sun_directions: ArrayLike,
        max_distance_m: ArrayLike | None = None,
        orders: int | None = None,
        sun_visibility: str = "disc",
        air: bool = True,
        time_s: float = 0.0,
        pixel_rad: float = 0.0,
        ground_albedo: float = 0.12,
    ) -> tuple[Floats, Floats]:
        """(radiance (N, 3), transmittance (N, 3)) of clouds and air along rays.

        Positions are planet-centred metres in planet axes, (N, 3) or (3,); directions point away from them, sun
        directions to the sun; both need not be unit. Rays end on the reference sphere, or after max_distance_m (N,);
        the sun's disc and the light of ground that a ray ends on are not included. Radiance in the unit of
        Sun.irradiance per sr.

        orders: 1 is single scattering, None all. sun_visibility: "disc", the visible share of the sun's disc, or
        "point", a hard shadow of its centre. air: False leaves the air out, its light and its extinction.

        time_s: of the weather. pixel_rad: angle that a ray stands for, 0 to 1; what is too small to be told apart
        within it is averaged, as in pictures. ground_albedo: of the ground around, whose light clouds scatter. All
        three count for weather (and as_pictures) only.
        """
        if orders not in (None, 1) or isinstance(orders, bool):
            raise ValueError(f"orders: expected None (all) or 1, found {orders!r}")
        if sun_visibility not in _VISIBILITIES:
            raise ValueError(f"sun_visibility: expected one of {_VISIBILITIES}, found {sun_visibility!r}")
        positions, ways, suns = question_rows(
            positions_m=positions_m, directions=directions, sun_directions=sun_directions
        )
        when, wide = question_number(time_s, "time_s"), question_number(pixel_rad, "pixel_rad", 0.0, 1.0)
        ground = question_number(ground_albedo, "ground_albedo", 0.0, 1.0)
        most = None if max_distance_m is None else question_distances(max_distance_m, len(ways), "max_distance_m")
        radius = self._sun_radius_rad if sun_visibility == "disc" else 0.0
        with self._guest():
            multiple, in_air = orders is None, air and self._air is not None
            if self._weather:
                light, transmittance = self._weather_probe(multiple, in_air).march(
                    positions, ways, suns, most, multiple=multiple, sun_radius_rad=radius, in_air=in_air, time_s=when,
                    pixel_rad=wide, ground_albedo=ground,
                )  # fmt: skip
            else:
                light, transmittance = self._shell_probe(multiple, in_air).march(
                    positions, ways, suns, most, multiple=multiple, sun_radius_rad=radius
                )
        return light * self._irradiance, transmittance

    def _shell_probe(self, multiple: bool, in_air: bool) -> ShellProbe:
        # Programs look their contracts up again whenever they are used.
        shaders = self._gpu.shaders
        shaders.withdraw("probe")
        if in_air:
            shaders.provide("air_point", "atmosphere/air_point.glsl", owner="probe")
            self._bind_air(0 if multiple else 1)
        made = self._asked.get(in_air)
        if made is None:
            top = self._air.thickness_m if in_air and self._air is not None else 0.0
            made = self._asked[in_air] = ShellProbe(self._scope, self._clouds, self._settings, top)
        return made

    def _weather_probe(self, multiple: bool, in_air: bool) -> WeatherProbe:
        shaders = self._gpu.shaders
        shaders.withdraw("probe")
        if in_air:
            shaders.provide("air_point", "atmosphere/air_point.glsl", owner="probe")
            shaders.provide("air", "clouds/probe/air.glsl", owner="probe")
            shaders.provide("sky", "clouds/probe/sky.glsl", owner="probe")
            self._bind_air(0 if multiple else 1)
        if self._asked_weather is None:
            self._asked_weather = WeatherProbe(self._scope, self._component, self._clouds, self._settings)
        return self._asked_weather

    def _bind_air(self, orders: int) -> None:
        """Bind the air's tables of light scattered at most so many times, 0 for all; made when first asked for."""
        if self._air_block is None:
            assert self._air is not None
            self._air_block = self._scope.uniform_block(AirBlock, AIR_BLOCK, "air_model")
            self._air_block.write(air_block(self._air, _DARK))
        self._air_block.bind()
        tables = self._tables.get(orders)
        if tables is None:
            tables = self._tables[orders] = AirTables(self._scope, table_sizes(self._settings), orders)
            while not tables.done:
                tables.step(1 << 22)
        tables.bind()


class _Dark:
    night_light: float = 0.0


_DARK = _Dark()
