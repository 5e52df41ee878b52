"""How water throws light back and lets it through: shader functions against Monte-Carlo and quadrature in float64."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from conftest import RunCompute
from numpy.typing import NDArray

from planetfall.components import Ocean
from planetfall.engine.blocks.bindings import FRAME_BLOCK, OCEAN_BLOCK, PLANET_BLOCK
from planetfall.engine.frame.block import FrameBlock, PlanetBlock, frame_of_anchor
from planetfall.engine.gpu import Gpu
from planetfall.engine.wavelengths import GIVEN_NM
from planetfall.engine.waves import waves_of
from planetfall.systems.ocean.block import (
    OceanBlock,
    breaking,
    diffuse_mirrored,
    ocean_block,
    whitecaps,
)

pytestmark = pytest.mark.gpu

Floats = NDArray[np.float64]
LIGHT = '#include "ocean/look/glitter.glsl"'
WATER = 1.333


def fresnel(cosine: Floats, index: float) -> Floats:
    """Fresnel's equations from angles (Born and Wolf 1999, section 1.5.2), unpolarised."""
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    bent = np.arcsin(np.clip(np.sin(angle) / index, -1.0, 1.0))
    s, p = np.sin(angle - bent) / np.sin(angle + bent), np.tan(angle - bent) / np.tan(angle + bent)
    return 0.5 * (s**2 + p**2)


def facets(rng: np.random.Generator, count: int, mean: Floats, variance: Floats) -> Floats:
    """Slopes (count, 2) of a Gaussian surface; variance: of x, of y, covariance."""
    cov = [[variance[0], variance[2]], [variance[2], variance[1]]]
    return rng.multivariate_normal(mean, cov, count)


def direction(elevation_deg: float, azimuth_deg: float) -> Floats:
    e, a = np.radians(elevation_deg), np.radians(azimuth_deg)
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])


# mean slope, variances and covariance: calm, a breeze, a gale along one axis, a wave's flank, axes askew.
SURFACES = [
    ((0.0, 0.0), (2e-5, 2e-5, 0.0)),
    ((0.0, 0.0), (0.02, 0.02, 0.0)),
    ((0.0, 0.0), (0.06, 0.02, 0.0)),
    ((0.25, -0.1), (0.01, 0.01, 0.0)),
    ((-0.3, 0.2), (0.02, 0.04, 0.015)),
]
ELEVATIONS = (90.0, 60.0, 35.0, 20.0, 10.0, 4.0, 1.0)


def test_fresnel_from_both_sides(run_compute: RunCompute) -> None:
    cosine = np.cos(np.radians(np.linspace(0.5, 89.5, 90)))
    for index in (1.1, WATER, 2.4):
        out = run_compute(
            "outside = fresnel_outside(c, n); inside = fresnel_inside(c, n);",
            {"c": cosine, "n": index},
            {"outside": "float", "inside": "float"},
            header=LIGHT,
        )
        np.testing.assert_allclose(out["outside"], fresnel(cosine, index), atol=2e-6)
        critical = np.sqrt(1.0 - 1.0 / index**2)
        total = cosine < critical - 1e-3
        assert (out["inside"][total] == 1.0).all()
        # Next to the critical angle the slope of the curve is infinite.
        clear = cosine > critical + 0.02
        bent = np.cos(np.arcsin(index * np.sqrt(1.0 - cosine[clear] ** 2)))
        np.testing.assert_allclose(out["inside"][clear], fresnel(bent, index), atol=2e-5)


def test_light_from_all_of_the_sky() -> None:
    # Preisendorfer 1976: 0.066 for water.
    assert diffuse_mirrored(WATER) == pytest.approx(0.066, abs=0.001)
    assert diffuse_mirrored(1.0) == 0.0


@pytest.mark.parametrize(("mean", "variance"), SURFACES)
def test_what_a_direction_sees_of_a_rough_surface(run_compute: RunCompute, mean: Floats, variance: Floats) -> None:
    rng = np.random.default_rng(11)
    slopes = facets(rng, 400_000, np.array(mean), np.array(variance))
    views = np.array([direction(e, a) for e in ELEVATIONS for a in (0.0, 50.0, 210.0)])
    out = run_compute(
        "Slopes s = Slopes(mean, variance); SlopesSeen seen = slopes_seen(s, v); float facet;\n"
        "area = seen.area; along = seen.mean; spread = seen.spread;\n"
        "share = fresnel_mean(s, seen, v, 1.333, facet); mirror = facet;",
        {"v": views, "mean": mean, "variance": variance},
        {name: "float" for name in ("area", "along", "spread", "share", "mirror")},
        header=LIGHT,
    )
    for i, v in enumerate(views):
        level = v[:2] / max(np.hypot(*v[:2]), 1e-9)
        if np.hypot(*v[:2]) < 1e-6:
            level = np.array([1.0, 0.0])
        along = slopes @ level
        shown = np.maximum(v[2] - slopes @ v[:2], 0.0)
        area = shown.mean()
        sigma = np.sqrt(max(variance))
        if area < 0.05 * sigma * np.hypot(*v[:2]):
            continue  # a flank that is turned away, the last 2 % of its facets in sight
        # Monte-Carlo's own error is below 0.5 % of what is seen; the normal distribution's fit is good to 1.5e-4.
        assert out["area"][i] == pytest.approx(area, rel=0.01, abs=2e-4)
        seen_mean = np.average(along, weights=shown)
        spread = np.sqrt(np.average((along - seen_mean) ** 2, weights=shown))
        assert out["along"][i] == pytest.approx(seen_mean, abs=0.02 * sigma + 2e-4)
        assert out["spread"][i] == pytest.approx(spread, rel=0.02)
        cosine = shown / np.sqrt(1.0 + (slopes**2).sum(axis=1))
        thrown = fresnel(np.maximum(cosine, 1e-6), WATER)
        share = np.average(thrown, weights=shown)
        assert out["share"][i] == pytest.approx(share, rel=0.06, abs=0.004), (v, mean, variance)


def test_glitter_is_what_facets_mirror(run_compute: RunCompute) -> None:
    """Away from flat angles, where nothing is hidden: energy counted in a small cone around the view."""
    rng = np.random.default_rng(5)
    variance = np.array([0.02, 0.03, 0.0])
    slopes = facets(rng, 3_000_000, np.zeros(2), variance)
    normals = np.column_stack([-slopes, np.ones(len(slopes))])
    length = np.linalg.norm(normals, axis=1)
    sun = direction(60.0, 20.0)
    lit = normals @ sun / length
    thrown = 2.0 * lit[:, None] * normals / length[:, None] - sun
    energy = np.maximum(normals @ sun, 0.0) * fresnel(np.maximum(lit, 1e-6), WATER) / len(slopes)
    views = np.array([direction(60.0, 200.0), direction(75.0, 200.0), direction(50.0, 230.0), direction(80.0, 20.0)])
    out = run_compute(
        "Slopes s = Slopes(vec2(0.0), variance); y = glitter(s, slopes_seen(s, v), v, l, 0.0, 1.333);",
        {"v": views, "l": tuple(sun), "variance": tuple(variance)},
        {"y": "float"},
        header=LIGHT,
    )["y"]
    radius = 0.06
    for view, value in zip(views, out, strict=True):
        inside = np.linalg.norm(thrown - view, axis=1) < radius
        solid = np.pi * radius**2  # of a cone whose chord is the radius
        radiance = energy[inside].sum() / (solid * view[2])
        noise = 1.0 / np.sqrt(inside.sum())
        # The cone is wide: over it the glitter bends by its width over that of the glitter, squared, 2 %.
        assert value == pytest.approx(radiance, rel=0.02 + 3.0 * noise)


@pytest.mark.parametrize("elevation_deg", [75.0, 40.0, 15.0, 5.0])
@pytest.mark.parametrize("sigma", [0.03, 0.15, 0.3])
def test_a_mirror_of_facets_never_gives_more_than_it_gets(
    run_compute: RunCompute, sigma: float, elevation_deg: float
) -> None:
    """Facets that throw everything back: what leaves is what comes, less what other facets would have thrown on."""
    sun = direction(elevation_deg, 0.0)
    # Directions thrown by a grid of slopes: the integral over them instead of over the sky, whose glint may be narrow.
    side = np.linspace(-6.0, 6.0, 241) * sigma
    x, y = np.meshgrid(side, side)
    n = np.column_stack([-x.ravel(), -y.ravel(), np.ones(x.size)])
    length = np.linalg.norm(n, axis=1)
    h = n / length[:, None]
    l_h = h @ sun
    views = 2.0 * l_h[:, None] * h - sun
    keep = (l_h > 1e-3) & (views[:, 2] > 1e-3)
    out = run_compute(
        "Slopes s = Slopes(vec2(0.0), vec3(variance, variance, 0.0));\n"
        "y = glitter(s, slopes_seen(s, v), v, l, 0.0, 1e4);",
        {"v": views[keep], "l": tuple(sun), "variance": sigma**2},
        {"y": "float"},
        header=LIGHT,
    )["y"]
    # d(direction) = 4 l_h d(h), d(h) = h_z^3 d(slope).
    solid = 4.0 * l_h[keep] * h[keep, 2] ** 3 * (side[1] - side[0]) ** 2
    albedo = float(np.sum(out * views[keep, 2] * solid) / sun[2])
    assert albedo < 1.005
    if elevation_deg > 6.0 * np.degrees(sigma):
        assert albedo > 0.97, "a surface that hides nothing of itself keeps all light"


@pytest.fixture
def ask(gpu: Gpu, run_compute: RunCompute) -> Any:
    """run_compute with the blocks of a frame, a planet and a sea bound."""
    scope = gpu.scope("water_light")
    frame = scope.uniform_block(FrameBlock, FRAME_BLOCK, "frame")
    planet = scope.uniform_block(PlanetBlock, PLANET_BLOCK, "planet")
    water = scope.uniform_block(OceanBlock, OCEAN_BLOCK, "ocean")
    ocean = Ocean(absorption_per_m=(0.3, 0.06, 0.02), scattering_per_m=(0.002, 0.004, 0.006))
    frame.write(replace(frame_of_anchor((0.0, 0.0, 1.0), 0.0), sun_direction=direction(40.0, 0.0)))
    planet.write(PlanetBlock(6.371e6, 9000.0, -11000.0, 0.0, 0.0, has_sea=False))
    block = ocean_block(ocean, waves_of(ocean, 6.371e6), np.array([0.0, 0.0, 1.0]), 6.371e6, GIVEN_NM)
    water.write(block)

    def run(*given: Any, **more: Any) -> dict[str, Floats]:
        def bind(_: Any) -> None:
            for made in (frame, planet, water):
                made.bind()

        return run_compute(*given, setup=bind, **more)

    yield run, block
    scope.release()


def test_light_along_a_path_under_water(ask: Any) -> None:
    run, block = ask
    loss, thrown = np.array(block.loss_per_m), np.array(block.scattering_per_m)
    rng = np.random.default_rng(2)
    count = 60
    depth, rise = rng.uniform(0.0, 30.0, count), rng.uniform(-1.0, 1.0, count)
    path = np.where(rise > 0.0, np.minimum(depth / np.maximum(rise, 1e-3), 200.0), rng.uniform(0.1, 200.0, count))
    out = run(
        "WaterSun s = water_sun(vec3(0.0, 0.0, 1.0), vec3(1.0), vec3(0.2), 0.03); cosine = s.cosine;"
        " murk = water_murk(s, depth, rise, path, -1.0);",
        {"depth": depth, "rise": rise, "path": path},
        {"murk": "vec3", "cosine": "float"},
        header='#include "common/camera.glsl"\n#include "ocean/look/murk.glsl"',
    )
    below = np.sqrt(1.0 - (np.cos(np.radians(40.0)) / WATER) ** 2)
    np.testing.assert_allclose(out["cosine"], below, atol=1e-6)
    direct = (1.0 - 0.03) * np.sin(np.radians(40.0)) / below
    # Henyey and Greenstein 1941, straight back.
    phase = 1.0 / np.pi + 0.6 * (1.0 - 0.85**2) / (4.0 * np.pi * (1.0 + 0.85**2 + 1.7) ** 1.5)
    for i in range(count):
        t = (np.arange(4000) + 0.5) / 4000 * path[i]
        at = depth[i] - t * rise[i]
        sun = np.exp(-np.outer(at, loss) / below) * direct * phase
        sky = np.exp(-np.outer(at, loss) / 0.86) * 0.2 * (1.0 - block.diffuse_mirrored) / (0.86 * np.pi)
        light = np.sum((sun + sky) * np.exp(-np.outer(t, loss)), axis=0) * thrown * path[i] / 4000
        np.testing.assert_allclose(out["murk"][i], light, rtol=2e-3, atol=1e-9)


def test_light_that_comes_up_from_shallows(ask: Any) -> None:
    run, block = ask
    loss, thrown = np.array(block.loss_per_m), np.array(block.scattering_per_m)
    depth = np.array([0.0, 0.3, 3.0, 30.0, 3000.0])
    out = run(
        "up = water_upwelling(depth, 0.9, 0.8, vec3(0.4));",
        {"depth": depth},
        {"up": "vec3"},
        header='#include "common/camera.glsl"\n#include "ocean/look/column.glsl"',
    )["up"]
    for i, d in enumerate(depth):
        z = (np.arange(20000) + 0.5) / 20000 * min(d, 400.0)
        both = 1.0 / 0.9 + 1.0 / 0.8
        scattered = np.sum(np.exp(-np.outer(z, loss) * both), axis=0) * thrown * min(d, 400.0) / 20000 / (0.9 * 0.8)
        light = (scattered + 0.4 * np.exp(-loss * d * both)) / np.pi
        np.testing.assert_allclose(out[i], light, rtol=3e-3)


def test_whitecaps_cover_what_was_counted() -> None:
    # Monahan and O'Muircheartaigh 1980: 0.46 % at 8 m/s, 3.9 % at 15 m/s.
    assert whitecaps(8.0) == pytest.approx(0.0046, rel=0.02)
    assert whitecaps(15.0) == pytest.approx(0.039, rel=0.02)
    ocean = Ocean(wind_speed_m_s=12.0)
    waves = waves_of(ocean, 6.371e6)
    crests = breaking(ocean, waves)
    # Crests at random phases: the share of places squeezed beyond the limit.
    rng = np.random.default_rng(4)
    steep = waves.steepness * waves.amplitude_m * waves.wave_number_per_m
    squeeze = np.sin(rng.uniform(0.0, 2.0 * np.pi, (200_000, len(steep)))) @ steep
    assert squeeze.std() == pytest.approx(crests.deviation, rel=0.01)
    assert np.mean(squeeze > crests.squeeze) == pytest.approx(whitecaps(12.0), rel=0.35)
    assert breaking(Ocean(foam=0.0), waves).deviation == 0.0
