"""Paths of light through clouds against independent tables and against what no path may get wrong."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import groupby
from typing import Any

import numpy as np
import pytest
from air_tables import over_the_pole, towards
from cloud_tables import Rows, clouds_of, column, even, radius_of, rows_of

import planetfall as pf
from planetfall.benchmarks.session import Session
from planetfall.components import Clouds
from planetfall.quality import resolve_quality
from planetfall.systems.clouds.model import CloudModel
from planetfall.systems.clouds.path_probe import LITTLE, PATHS, PathProbe, PathSums, PathView

FLAT_M = 1e8
SMALL = {"clouds.shape_texels": 32, "clouds.fibre_texels": 64, "clouds.rim_texels": 16, "clouds.map_texels": 256}
NO_WIDTH = np.zeros(3)


@contextmanager
def probe_of(clouds: Clouds, radius_m: float, **how: Any) -> Iterator[PathProbe]:
    with Session("paths") as session:
        scope = session.gpu.scope("paths")
        model = CloudModel.from_components(pf.Planet(radius_m=radius_m), clouds, None)
        yield PathProbe(scope, clouds, model, resolve_quality("low", SMALL), **how)
        scope.release()


def followed(probe: PathProbe, view: PathView, jobs: int, seed: int = 1) -> PathSums:
    probe.place(view)
    rays = len(view.ways)
    return probe.follow(PathSums.none(rays), np.full(rays, jobs), seed)


def slab_scores(rows: Rows, paths: int) -> list[float]:
    """Differences to the table in standard errors of both."""
    names = ("optical_depth", "albedo", "hg_g", "sun_zenith_deg")
    scores: list[float] = []

    def kind(row: dict[str, str]) -> list[float]:
        return [float(row[name]) for name in names] + [float(float(row["view_zenith_deg"]) > 90.0)]

    for (depth, albedo, g, sun, down), group in groupby(sorted(rows, key=kind), key=kind):
        own = list(group)
        with probe_of(even(1000.0, 2000.0, depth / 1000.0, albedo, g), FLAT_M) as probe:
            camera = over_the_pole([2001.0 if down else 999.0], FLAT_M)[0]
            ways = towards(column(own, "view_zenith_deg"), column(own, "azimuth_deg"))
            found = followed(probe, PathView(camera, ways, NO_WIDTH, NO_WIDTH, towards([sun])[0]), paths // PATHS)
        spread = np.hypot(found.error, column(own, "L_total_se"))
        scores += list((found.mean - column(own, "L_total")) / spread)
    return scores


@pytest.mark.parametrize("depth", ["0.5", "2.0", "8.0"])
def test_slabs_of_all_orders(depth: str) -> None:
    """Every third row of the table, 8192 paths each: within three standard errors."""
    assert np.abs(slab_scores(rows_of("clouds_slab_multiple", optical_depth=depth)[::3], 8192)).max() < 3.0


@pytest.mark.slow
def test_slabs_of_all_orders_with_many_paths() -> None:
    """All rows: within three standard errors, and as far off on the mean as chance has it."""
    scores = slab_scores(rows_of("clouds_slab_multiple"), 1 << 18)
    assert np.abs(scores).max() < 3.0
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 1.4  # of 21 rows: 1 +- 0.15


def shell_scores(rows: Rows, paths: int) -> tuple[list[float], list[float]]:
    """Differences to the table in standard errors, of light scattered once and of opacity."""
    light, opacity = [], []
    with probe_of(clouds_of(rows[0]), radius_of(rows)) as probe:
        for row in rows:
            camera = over_the_pole(column([row], "camera_altitude_m"), radius_of(rows))[0]
            way, sun = (
                towards(column([row], "view_zenith_deg"), column([row], "azimuth_deg")),
                column([row], "sun_zenith_deg"),
            )
            view = PathView(camera, way, NO_WIDTH, NO_WIDTH, towards(sun)[0], orders=1)
            found, left = followed(probe, view, paths // PATHS), float(row["transmittance"])
            # Where no path or a few had any light, the standard error is unknown; light so dim comes in portions of
            # up to twice LITTLE, in numbers by Poisson's law.
            spread = max(found.error[0], np.sqrt(2.0 * LITTLE * float(row["L1"]) / paths), 1e-9)
            light.append((found.mean[0] - float(row["L1"])) / spread)
            opacity.append((found.opacity[0] - 1.0 + left) / max(np.sqrt(left * (1.0 - left) / paths), 1.0 / paths))
    return light, opacity


@pytest.mark.parametrize("config", ["earth_cumulus", "small_planet"])
def test_shells_scatter_once(config: str) -> None:
    """Curved layers, cameras below, inside and above, the sun behind the planet or through the hollow."""
    light, opacity = shell_scores(rows_of("clouds_shell", config=config)[::4], 8192)
    assert np.abs(light).max() < 3.0
    assert np.abs(opacity).max() < 3.0


@pytest.mark.slow
@pytest.mark.parametrize("config", ["earth_cirrus", "earth_cumulus", "earth_thin", "isotropic", "small_planet"])
def test_shells_scatter_once_in_every_row(config: str) -> None:
    light, opacity = shell_scores(rows_of("clouds_shell", config=config), 1 << 16)
    assert np.abs(light).max() < 3.5  # of 300 numbers one is beyond 3 by chance
    assert np.abs(opacity).max() < 3.5


def test_over_white_ground_nothing_is_lost() -> None:
    """Droplets that swallow nothing over ground that swallows nothing send back all sunlight. What is seen through the
    slab, exp(-8) of the ground straight down, is not counted."""
    mu, weight = np.polynomial.legendre.leggauss(8)
    mu, weight = 0.5 * mu + 0.5, 0.5 * weight
    ways = towards(180.0 - np.degrees(np.arccos(mu)))
    with probe_of(even(1000.0, 2000.0, 8e-3), FLAT_M) as probe:
        view = PathView(
            over_the_pole([2001.0], FLAT_M)[0], ways, NO_WIDTH, NO_WIDTH, towards([60.0])[0], ground_albedo=1.0
        )
        found = followed(probe, view, 256)
    flux, error = 2.0 * np.pi * mu * weight @ found.mean, 2.0 * np.pi * np.hypot.reduce(mu * weight * found.error)
    assert abs(flux - 0.5) < 3.0 * error + 1e-3
    assert error < 0.01


def weather_view(at_m: float = 2500.0) -> PathView:
    """A fan of rays from a place among clouds, all of which meet some."""
    rng = np.random.default_rng(3)
    ways = rng.normal(size=(24, 3))
    position = pf.direction(55.0, -20.0) * (6.36e6 + at_m)
    sun = pf.direction(30.0, 0.0)
    return PathView(position, ways, NO_WIDTH, NO_WIDTH, sun, 0.005, 0.12)


def test_bounds_of_the_density_change_no_light() -> None:
    """Paths that skip what is surely clear and take the most that there may be around them, against paths that take the
    densest cloud for the most everywhere."""
    found = []
    for plain in (False, True):
        with probe_of(Clouds(base_m=1200.0, top_m=4200.0, coverage=0.55, extinction_per_m=0.02), 6.36e6,
                      plain=plain) as probe:  # fmt: skip
            found.append(followed(probe, weather_view(), 96, seed=1 + plain))
            assert probe.worst <= 1.0 + 1e-4
    clear = 1e-9  # rays without any cloud have no error
    light = (found[0].mean - found[1].mean) / np.maximum(np.hypot(found[0].error, found[1].error), clear)
    spread = np.sqrt(sum(f.opacity * (1.0 - f.opacity) / f.count for f in found))
    opacity = (found[0].opacity - found[1].opacity) / np.maximum(spread, 1e-3)
    assert 0.1 < found[0].opacity.mean() < 0.99
    assert np.abs(light).max() < 3.5  # 48 numbers
    assert np.abs(opacity).max() < 3.5
    assert np.sqrt((light**2).mean()) < 1.5  # 24 numbers: 1 +- 0.15


def test_they_are_the_same_to_the_bit_whatever_is_followed_beside_them() -> None:
    """Chance is a hash of ray, path and draw; a ray's first paths are those of a longer run."""
    with probe_of(Clouds(base_m=1200.0, top_m=4200.0, extinction_per_m=0.02), 6.36e6) as probe:
        probe.place(weather_view())
        some = np.arange(24) % 3
        first = probe.follow(PathSums.none(24), some)
        again = probe.follow(PathSums.none(24), 2 - some)
        both = probe.follow(probe.follow(PathSums.none(24), np.ones(24, int)), np.ones(24, int))
    two = some == 2
    np.testing.assert_array_equal(first.light[two], both.light[two])
    np.testing.assert_array_equal(again.light[some == 0], both.light[some == 0])


def test_ice_is_refused() -> None:
    cirrus = Clouds(base_m=9000.0, top_m=10000.0, extinction_per_m=6e-4)
    with pytest.raises(ValueError, match="sheets of no thickness"), probe_of(cirrus, 6.36e6):
        pass
