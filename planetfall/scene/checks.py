"""What doesn't fit together in a planet: checks of single values are the knobs' own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from ..components import Atmosphere, Clouds, Ocean, Planet, Sun, Terrain, Wind
from ..components.wind import blown
from ..engine.settings import SettingError, with_overrides
from ..engine.wavelengths import carried_air, wavelengths_of
from ..engine.waves import WaveError, waves_of
from .handle import Parts

__all__ = ["cloud_problems", "planet_problems"]

C = TypeVar("C")


def planet_problems(name: str, parts: Parts, sun: Sun, settings: Mapping[str, Any]) -> list[str]:
    """All that doesn't fit in a planet. settings: {"terrain.highest_m": ...}, values that stand in for components'."""

    def found(kind: type[C], table: str) -> C | None:
        component = parts.get(kind)
        return None if component is None else with_overrides(component, table, settings)

    problems: list[str] = []
    planet = parts.get(Planet) or Planet()
    terrain, radius = found(Terrain, "terrain"), planet.radius_m
    where = f"planet {name!r}"
    if terrain is not None:
        if terrain.lowest_m >= terrain.highest_m:
            problems.append(
                f"{where}: Terrain.lowest_m ({terrain.lowest_m:g}) has to be below highest_m ({terrain.highest_m:g})"
            )
        for field, value in (("highest_m", terrain.highest_m), ("lowest_m", terrain.lowest_m)):
            if abs(value) > 0.25 * radius:
                problems.append(
                    f"{where}: Terrain.{field} ({value:g}) is more than a quarter of Planet.radius_m ({radius:g}); "
                    f"use at most {0.25 * radius:g}"
                )
        if terrain.lowest_m < terrain.highest_m and (
            terrain.height_map or terrain.color_map or terrain.vector_map or terrain.height_map_range_m is not None
        ):
            from ..systems.terrain.ground_params import dry_ground
            from ..systems.terrain.real_colors import check_pictures, ground_colors

            try:
                params = dry_ground(terrain, radius)
                if params.pictured and "light.wavelengths" not in settings:
                    check_pictures(terrain, params)  # a renderer's wavelengths say how they are read
                else:
                    ground_colors(terrain, params, wavelengths_of(settings))
            except ValueError as error:
                problems.append(f"{where}: {error}")
    sea = found(Ocean, "ocean")
    if sea is not None and abs(sea.sea_level_m) > 0.25 * radius:
        problems.append(
            f"{where}: Ocean.sea_level_m ({sea.sea_level_m:g}) is more than a quarter of Planet.radius_m ({radius:g})"
        )
    if sea is not None:
        try:
            waves_of(blown(sea, found(Wind, "wind")), radius)
        except WaveError as error:
            problems.append(f"{where}: Ocean: {error}")
    air = found(Atmosphere, "atmosphere")
    if air is not None:
        if sea is not None and sea.sea_level_m >= air.thickness_m:
            problems.append(
                f"{where}: Ocean.sea_level_m ({sea.sea_level_m:g}) is above the top of the air, Atmosphere.thickness_m "
                f"({air.thickness_m:g}); lower the sea or raise the air"
            )
        from ..systems.atmosphere.model import AirModel

        try:
            for numbers in (air, carried_air(air, wavelengths_of(settings))):
                AirModel.from_components(planet, numbers, sun.angular_radius_rad)
        except SettingError as error:
            problems.append(f"{where}: {error}")
    clouds = found(Clouds, "clouds")
    if clouds is not None:
        problems += [f"{where}: {problem}" for problem in cloud_problems(clouds, planet, air)]
    return problems


def cloud_problems(clouds: Clouds, planet: Planet, air: Atmosphere | None) -> list[str]:
    """Why these clouds can't be on a planet in this air."""
    from ..systems.clouds.model import CloudModel

    try:
        CloudModel.from_components(planet, clouds, air)
        if clouds.weather_map:
            from ..systems.clouds.imported import imported_cover

            imported_cover(clouds.weather_map)
    except ValueError as error:
        return [str(error)]
    return []
