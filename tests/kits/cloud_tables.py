"""The tables of homogeneous clouds in tests/data, and planets of nothing but such a cloud."""

from __future__ import annotations

import csv
from typing import Any

import numpy as np
from air_tables import DATA, over_the_pole, towards

import planetfall as pf

Rows = list[dict[str, str]]


def rows_of(name: str, **where: str) -> Rows:
    with (DATA / f"{name}.csv").open(newline="") as file:
        found = [row for row in csv.DictReader(file) if all(row[k] == v for k, v in where.items())]
    assert found, f"{name}.csv has no row of {where}"
    return found


def configs(name: str) -> list[str]:
    return sorted({row["config"] for row in rows_of(name)})


def column(rows: Rows, name: str) -> Any:
    return np.array([float(row[name]) for row in rows])


def triple(rows: Rows, stem: str) -> Any:
    return np.stack([column(rows, f"{stem}_{nm}") for nm in ("680", "550", "440")], axis=1)


def geometry(rows: Rows, radius_m: float) -> tuple[Any, Any, Any]:
    """Positions, directions and suns of rows that share a planet."""
    return (
        over_the_pole(column(rows, "camera_altitude_m"), radius_m),
        towards(column(rows, "view_zenith_deg"), column(rows, "azimuth_deg")),
        towards(column(rows, "sun_zenith_deg")),
    )


def radius_of(rows: Rows) -> float:
    return float(rows[0].get("R_m", 6.36e6))


def clouds_of(row: dict[str, str]) -> pf.Clouds:
    return even(
        float(row["base_m"]), float(row["top_m"]), float(row["extinction_per_m"]), float(row["albedo"]),
        float(row["hg_g"]),
    )  # fmt: skip


def even(
    base_m: float, top_m: float, extinction_per_m: float, albedo: float = 1.0, asymmetry: float = 0.0
) -> pf.Clouds:
    return pf.Clouds(
        base_m=base_m, top_m=top_m, extinction_per_m=extinction_per_m, albedo=albedo, asymmetry=asymmetry,
        density_model="uniform", height_profile="none", coverage=1.0,
    )  # fmt: skip


def planet_of(clouds: pf.Clouds, radius_m: float = 6.36e6, air: pf.Atmosphere | None = None) -> pf.Scene:
    parts: dict[str, Any] = {"planet": pf.Planet(radius_m=radius_m), "clouds": clouds}
    if air is not None:
        parts["atmosphere"] = air
    scene = pf.Scene("clouds alone", parts)
    scene.sun = pf.Sun(direction=(0.0, 0.0, 1.0), irradiance=(1.0, 1.0, 1.0), angular_radius_rad=0.00935 / 2.0)
    return scene
