"""AtmosphereProbe: the air as the renderer computes it, asked from Python."""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Integral
from typing import TYPE_CHECKING, Any

import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..components import Atmosphere, Planet
from ..engine.settings import with_overrides
from ..quality import resolve_quality
from ..systems.atmosphere.model import AirModel
from ..systems.atmosphere.probe import AirQuestions, Rays
from ..systems.atmosphere.sizes import method_sizes, view_sizes
from .probe import Probe
from .questions import question_distances, question_rows

if TYPE_CHECKING:
    from ..scene.scene import PlanetHandle, Scene

__all__ = ["AtmosphereProbe"]

Floats = NDArray[np.float64]
_PARTS = (None, "rayleigh", "mie")


class AtmosphereProbe(Probe):
    """Transmittance, sky radiance, aerial perspective and irradiance of a scene's air, on arrays of f64 questions.

    It runs the renderer's shaders on the GPU, with the tables of `quality`: what it says is what is drawn, table errors
    and all, but always at the wavelengths of the numbers of Atmosphere and Sun, as a renderer with `light.wavelengths`
    "given" draws. A snapshot of the scene when it was made.

        with pf.AtmosphereProbe(scene) as air:
            air.sky_radiance(position, direction, sun)

    Positions are planet-centred metres in planet axes, (N, 3) or (3,); directions point away from the query, sun
    directions to the sun; both need not be unit. One row goes with many: shapes are broadcast. Rays end on the
    reference sphere; the sun's disc and the light of the ground that a ray ends on are not included. Radiance in the
    unit of Sun.irradiance per sr (a unit sun gives relative values). Answers are (N, 3), one column a wavelength.

    ctx: a host's current moderngl context; None makes a headless one. ValueError for a planet without Atmosphere, for
    wrong shapes, NaN, zero directions and positions; SettingError for air that cannot be.
    """

    def __init__(
        self,
        scene: Scene,
        ctx: moderngl.Context | None = None,
        quality: str = "high",
        overrides: Mapping[str, Any] | None = None,
        planet: PlanetHandle | None = None,
    ) -> None:
        handle = scene.planet if planet is None else planet
        settings = resolve_quality(quality, overrides)
        try:
            air = handle[Atmosphere]
        except LookupError:
            raise ValueError(
                "AtmosphereProbe: the planet has no Atmosphere component; add one with"
                " scene.planet.add(pf.Atmosphere())"
            ) from None
        sun = scene.sun
        self._irradiance = np.asarray(sun.irradiance, np.float64)
        air = with_overrides(air, "atmosphere", settings)
        self._model = AirModel.from_components(handle[Planet], air, sun.angular_radius_rad)
        super().__init__(ctx)
        with self._guest():
            sizes = method_sizes(air.method, settings)
            self._questions = AirQuestions(self._scope, self._model, sizes, view_sizes(settings))

    def transmittance(
        self, positions_m: ArrayLike, directions: ArrayLike, distance_m: ArrayLike | None = None
    ) -> Floats:
        """Transmittance over distances (N,) in metres, or to space (0 where a ray ends on the planet)."""
        positions, ways = question_rows(positions_m=positions_m, directions=directions)
        rays = self._rays(positions, ways, ways)
        with self._guest():
            if distance_m is None:
                return self._questions.to_space(rays)
            return self._questions.light(rays, question_distances(distance_m, len(ways)), 1, None)[1]

    def sky_radiance(
        self,
        positions_m: ArrayLike,
        directions: ArrayLike,
        sun_directions: ArrayLike,
        orders: int | None = None,
        part: str | None = None,
    ) -> Floats:
        """Radiance that the air sends towards positions from directions.

        orders: 1 is single scattering, n light scattered n times at most, None all. part: "rayleigh" or "mie" gives
        that integral of single scattering without its phase function.
        """
        _check_orders(orders, part)
        positions, ways, suns = question_rows(
            positions_m=positions_m, directions=directions, sun_directions=sun_directions
        )
        rays = self._rays(positions, ways, suns)
        with self._guest():
            return self._questions.light(rays, None, orders, part)[0] * self._irradiance

    def in_scattering(
        self, positions_m: ArrayLike, points_m: ArrayLike, sun_directions: ArrayLike, orders: int | None = None
    ) -> tuple[Floats, Floats]:
        """(radiance, transmittance) of the air between positions and points."""
        _check_orders(orders, None)
        positions, points, suns = question_rows(
            _free=("points_m",), positions_m=positions_m, points_m=points_m, sun_directions=sun_directions
        )
        way = points - positions
        distance = np.linalg.norm(way, axis=1)
        # From a point to itself there is no air: any direction will do.
        way = np.where(distance[:, None] > 0.0, way / np.maximum(distance, 1e-300)[:, None], suns)
        rays = self._rays(positions, way, suns)
        with self._guest():
            light, transmittance = self._questions.light(rays, distance, orders, None)
        return light * self._irradiance, transmittance

    def irradiance(
        self, positions_m: ArrayLike, normals: ArrayLike, sun_directions: ArrayLike
    ) -> tuple[Floats, Floats]:
        """(direct, sky) irradiance of surfaces: the sun's, cosine included, and that of all sky that isn't ground."""
        positions, ups, suns = question_rows(positions_m=positions_m, normals=normals, sun_directions=sun_directions)
        rays = self._rays(positions, ups, suns)
        with self._guest():
            direct, sky = self._questions.irradiance(rays, rays.mu, rays.sine * rays.azimuth, rays.nu)
        return direct * self._irradiance, sky * self._irradiance

    def _rays(self, positions: Floats, directions: Floats, suns: Floats) -> Rays:
        return Rays.of(self._model.radius_m, positions, directions, suns)


def _check_orders(orders: int | None, part: str | None) -> None:
    if orders is not None and (not isinstance(orders, Integral) or isinstance(orders, bool) or not 1 <= orders <= 32):
        raise ValueError(f"orders: expected None (all) or a whole number from 1 to 32, found {orders!r}")
    if part not in _PARTS:
        raise ValueError(f"part: expected None, 'rayleigh' or 'mie', found {part!r}")
