"""Shader functions of the air against float64, and mappings against their inverses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import RunCompute
from numpy.typing import NDArray

from planetfall.components import Atmosphere, Planet
from planetfall.engine.blocks.bindings import AIR_BLOCK, AIR_VIEW_BLOCK
from planetfall.engine.gpu import Gpu
from planetfall.systems.atmosphere import AirBlock, AirModel, air_block
from planetfall.systems.atmosphere.block import cornette_shanks_moments
from planetfall.systems.atmosphere.views import AirViewBlock, focus_of, rows_at

pytestmark = pytest.mark.gpu

Floats = NDArray[np.float64]
MEDIUM, SLICES, TABLE = (f'#include "atmosphere/{name}.glsl"' for name in ("medium", "slices", "table"))
VIEW = """#include "atmosphere/view.glsl"
void air_light_at(AirView v, AirCell cell, int layer, out vec3 first, out vec3 second) { first = second = vec3(0.0); }
vec3 air_mean_extinction(ivec2 texel) { return vec3(0.0); }
"""
PLANETS = {"earth": (6.36e6, 60e3), "small": (6e4, 2e3), "asteroid": (1e3, 10.0), "giant": (7e7, 3e5)}


def model_of(planet: str = "earth", asymmetry: float = 0.8) -> AirModel:
    radius, top = PLANETS[planet]
    share = top / 60e3
    air = Atmosphere(
        thickness_m=top,
        rayleigh_scale_height_m=8e3 * share,
        mie_scale_height_m=1.2e3 * share,
        absorption_center_m=25e3 * share,
        absorption_half_width_m=15e3 * share,
        mie_asymmetry=asymmetry,
    )
    return AirModel.from_components(Planet(radius_m=radius), air, 0.004675)


@pytest.fixture
def ask(gpu: Gpu, run_compute: RunCompute) -> Any:
    """run_compute with the block of a model bound."""
    scope = gpu.scope("air_model")
    block = scope.uniform_block(AirBlock, AIR_BLOCK, "air_model")
    scope.uniform_block(AirViewBlock, AIR_VIEW_BLOCK, "air_view")

    def run(model: AirModel, *given: Any, **more: Any) -> dict[str, Floats]:
        block.write(air_block(model, Atmosphere()))
        found = run_compute(*given, setup=lambda _: block.bind(), **more)
        return {name: values.astype(np.float64) for name, values in found.items()}

    yield run
    scope.release()


def f32(values: Any) -> Floats:
    """What the shader gets, in float64."""
    return np.asarray(values, np.float32).astype(np.float64)


def heights_and_cosines(model: AirModel, seed: int = 3) -> tuple[Floats, Floats]:
    """From the floor to the top; directions all around, level, up, down, and crowded at the horizon."""
    rng = np.random.default_rng(seed)
    top, radius = model.thickness_m, model.radius_m
    h = np.concatenate([[0.0, 1e-7 * top, 1e-3 * top, 0.5 * top, top], top * rng.random(40) ** 3])
    h = np.repeat(f32(h), 40)
    horizon = -np.sqrt(h * (2.0 * radius + h)) / (radius + h)
    mu = rng.uniform(-1.0, 1.0, len(h))
    kind = np.arange(len(h)) % 40
    near = horizon + rng.choice([-1.0, 1.0], len(h)) * 10.0 ** rng.uniform(-6.0, -1.0, len(h))
    mu = np.where(kind < 20, np.clip(near, -1.0, 1.0), mu)
    mu = np.select([kind == 20, kind == 21, kind == 22], [0.0, 1.0, -1.0], mu)
    return h, f32(mu)


@pytest.mark.parametrize("planet", PLANETS)
def test_altitude_along_a_ray(ask: Any, planet: str) -> None:
    model = model_of(planet)
    h, mu = heights_and_cosines(model)
    t = f32(model.longest_path_m * np.random.default_rng(1).random(len(h)) ** 4)
    found = ask(model, "y = air_height_along(h, mu, t);", {"h": h, "mu": mu, "t": t}, {"y": "float"}, header=MEDIUM)[
        "y"
    ]
    r = np.longdouble(model.radius_m) + h
    wanted = (np.sqrt(r * r + t * (2.0 * r * mu + t)) - model.radius_m).astype(np.float64)
    # Altitude is h plus the rise; either may cancel the other, so the error is measured by both. The sine of mu's own
    # rounding is no error of the function.
    scale = np.abs(h) + np.abs(wanted - h) + t * t / model.radius_m
    assert (np.abs(found - wanted) <= 1e-6 * scale + 1e-30).all()


@pytest.mark.parametrize("planet", PLANETS)
def test_distances_to_top_and_floor(ask: Any, planet: str) -> None:
    model = model_of(planet)
    h, mu = heights_and_cosines(model)
    found = ask(
        model,
        "top = air_to_top(h, mu); ground = air_to_floor(h, mu); horizon = air_horizon_cos(h);",
        {"h": h, "mu": mu},
        {"top": "float", "ground": "float", "horizon": "float"},
        header=MEDIUM,
    )
    radius, top = np.longdouble(model.radius_m), np.longdouble(model.thickness_m)
    r = radius + h
    b = r * mu
    root = np.sqrt(b * b + (top - h) * (radius + top + r))
    wanted = np.where(b < 0.0, root - b, (top - h) * (radius + top + r) / np.maximum(root + b, 1e-30))
    assert (np.abs(found["top"] - wanted) <= 2e-6 * wanted).all()
    assert (found["top"] >= 0.0).all()

    inside = h * (2.0 * radius + h)
    discriminant = b * b - inside
    # Float32 decides within its rounding of b b; farther from grazing both agree.
    sure = np.abs(discriminant) > 4e-7 * b * b
    hits = (mu < 0.0) & (discriminant >= 0.0)
    assert ((found["ground"] >= 0.0) == hits)[sure].all()
    assert sure.mean() > 0.7
    distance = inside / np.maximum(np.sqrt(np.maximum(discriminant, 0.0)) - b, 1e-30)
    # Near grazing the distance changes with the root of what rounding does to the discriminant.
    loss = 4e-7 * b * b / np.maximum(np.abs(discriminant), 1e-30)
    at = sure & hits
    assert (np.abs(found["ground"] - distance)[at] <= ((2e-6 + loss) * distance)[at]).all()
    wanted = -np.sqrt(inside) / r
    assert np.abs(found["horizon"] - wanted.astype(np.float64)).max() < 2e-7


def test_from_the_floor_itself(ask: Any) -> None:
    """h = 0, where the text-book form loses the ground to rounding: level and upwards it is missed, downwards met."""
    mu = f32([1.0, 1e-6, 0.0, -1e-6, -0.5, -1.0])
    found = ask(model_of(), "y = air_to_floor(0.0, mu);", {"mu": mu}, {"y": "float"}, header=MEDIUM)["y"]
    np.testing.assert_array_equal(found[:3], -1.0)
    np.testing.assert_array_equal(found[3:], 0.0)


def test_rows_of_paths_and_back(ask: Any) -> None:
    x = np.concatenate([[0.0, 1.0], np.random.default_rng(2).random(500), 10.0 ** np.linspace(-7.0, 0.0, 50)])
    for kappa in (0.4, 1.0, 3.0):
        body = "row = air_path_row(x, k); y = air_path_share(row, k);"
        found = ask(model_of(), body, {"x": x, "k": kappa}, {"row": "float", "y": "float"}, header=MEDIUM)
        wanted = kappa * np.sqrt(f32(x)) / (kappa * np.sqrt(f32(x)) + np.sqrt(1.0 - f32(x)))
        np.testing.assert_allclose(found["row"], wanted, rtol=2e-6, atol=1e-7)
        np.testing.assert_allclose(found["y"], x, rtol=3e-6, atol=1e-7)


def test_slices_and_back(ask: Any) -> None:
    rng = np.random.default_rng(4)
    n = 2000
    path = f32(10.0 ** rng.uniform(-2.0, 6.3, n))
    lowest = f32(path * np.select([rng.random(n) < 0.3, rng.random(n) < 0.3], [0.0, 1.0], rng.random(n)))
    t = f32(path * np.where(rng.random(n) < 0.1, np.round(rng.random(n)), rng.random(n)))
    body = "float s = air_split(l, p); w = air_slice_of(t, p, l, s); y = air_slice_distance(w, p, l, s); split = s;"
    found = ask(
        model_of(), body, {"p": path, "l": lowest, "t": t}, {"w": "float", "y": "float", "split": "float"},
        header=SLICES,
    )  # fmt: skip
    assert ((found["w"] >= 0.0) & (found["w"] <= 1.0)).all()
    assert ((found["split"] >= 0.0) & (found["split"] <= 1.0 + 1e-6)).all()
    # The share is a float32 near 1 at most, and changes by at least path / 4 of distance in all.
    assert (np.abs(found["y"] - t) <= 2e-6 * path).all()
    ends = ask(
        model_of(),
        "float s = air_split(l, p); a = air_slice_distance(0.0, p, l, s); b = air_slice_distance(1.0, p, l, s);",
        {"p": path, "l": lowest}, {"a": "float", "b": "float"}, header=SLICES,
    )  # fmt: skip
    assert (ends["a"] <= 2e-6 * path).all()
    np.testing.assert_allclose(ends["b"], path, rtol=2e-6)


def test_heights_of_the_sun_and_back(ask: Any) -> None:
    mu = np.concatenate([[-1.0, 0.0, 1.0], np.linspace(-1.0, 1.0, 500), 1e-4 * np.linspace(-1.0, 1.0, 50)])
    body = "row = air_sun_row(mu); y = air_sun_of_row(row);"
    found = ask(model_of(), body, {"mu": mu}, {"row": "float", "y": "float"}, header=TABLE)
    np.testing.assert_allclose(found["row"][:3], [0.0, 0.5, 1.0], atol=1e-7)
    assert np.abs(found["y"] - f32(mu)).max() < 2e-6
    assert (np.diff(found["row"][3:503]) > 0.0).all()


@pytest.mark.parametrize("sun_mu", [1.0, 0.5, 0.05, 0.0, -0.1, -0.6, -1.0])
def test_columns_of_azimuth_and_back(ask: Any, sun_mu: float) -> None:
    """For rays that graze, go up and go down, whether the terminator crosses their azimuths or not."""
    rng = np.random.default_rng(5)
    model, n = model_of(), 3000
    altitude = f32(np.where(rng.random(n) < 0.2, 3e5, 6e4 * rng.random(n) ** 2))
    down, up = (np.stack([r.least_m, r.range_m, r.kappa], 1) for r in rows_at(model, altitude))
    mu = f32(rng.uniform(-1.0, 1.0, n))
    azimuth = f32(np.where(rng.random(n) < 0.1, np.sign(rng.random(n) - 0.5), rng.uniform(-1.0, 1.0, n)))
    # column * columns' width back to a cosine is asked for 24 columns, as at quality high
    body = """
    AirView v = AirView(h, sun_mu, sqrt(max(1.0 - sun_mu * sun_mu, 0.0)), AirRows(down.x, down.y, down.z),
        AirRows(up.x, up.y, up.z), focus, 24, 48, 16);
    float sine = sin_from_cos(mu);
    AirPath p = air_path(v, mu, sine);
    vec2 crowd = air_focus(v, p, mu, sine);
    column = air_column_of(v, crowd, azimuth);
    back = air_azimuth_of(v, crowd, column);
    reach = crowd.y;
    """
    found = ask(
        model, body,
        {"h": altitude, "mu": mu, "azimuth": azimuth, "down": down, "up": up, "sun_mu": np.full(n, sun_mu),
         "focus": np.full(n, focus_of(model))},
        {"column": "float", "back": "float", "reach": "float"}, header=VIEW,
    )  # fmt: skip
    assert ((found["column"] >= 0.0) & (found["column"] <= 23.0)).all()
    # Where the sun's height at the lowest point is the same all around, every azimuth is equally good.
    matters = found["reach"] > 1e-3
    assert np.abs(found["back"] - azimuth)[matters].max(initial=0.0) < 2e-3
    assert np.abs(found["back"] - azimuth).mean() < 1e-3


@pytest.mark.parametrize("asymmetry", [-0.9, -0.3, 0.0, 0.5, 0.8, 0.95])
def test_phase_functions(ask: Any, asymmetry: float) -> None:
    """Their integral over all directions is 1, and their Legendre moments are those of the uniform block."""
    nodes, weights = np.polynomial.legendre.leggauss(400)
    found = ask(
        model_of(asymmetry=asymmetry), "gas = air_rayleigh_phase(nu); haze = air_mie_phase(nu);",
        {"nu": nodes}, {"gas": "float", "haze": "float"}, header=MEDIUM,
    )  # fmt: skip
    for phase in found.values():
        assert (phase >= 0.0).all()
        assert abs(2.0 * np.pi * (weights * phase).sum() - 1.0) < 5e-6
    for order, moment in enumerate(cornette_shanks_moments(asymmetry), 1):
        polynomial = np.polynomial.legendre.Legendre.basis(order)(nodes)
        assert abs(2.0 * np.pi * (weights * found["haze"] * polynomial).sum() - moment) < 5e-6
    second = np.polynomial.legendre.Legendre.basis(2)(nodes)
    assert abs(2.0 * np.pi * (weights * found["gas"] * second).sum() - 0.1) < 1e-6


def test_packing(ask: Any) -> None:
    value = np.concatenate([[0.0, -1.0], 10.0 ** np.linspace(-30.0, 30.0, 200)])
    found = ask(model_of(), "y = air_unpack(air_pack(vec3(v))).x;", {"v": value}, {"y": "float"}, header=MEDIUM)["y"]
    np.testing.assert_array_equal(found[:2], 0.0)
    np.testing.assert_allclose(found[2:], value[2:], rtol=2e-6)


@pytest.mark.parametrize("planet", PLANETS)
def test_density_and_extinction(ask: Any, planet: str) -> None:
    model = model_of(planet)
    h = f32(model.thickness_m * np.concatenate([[-0.1, 0.0], np.linspace(0.0, 1.0, 200)]))
    body = "density = air_density(h); extinction = air_extinction(density);"
    found = ask(model, body, {"h": h}, {"density": "vec3", "extinction": "vec3"}, header=MEDIUM)
    wanted = model.density(h)
    np.testing.assert_allclose(found["density"], wanted, rtol=5e-6, atol=1e-6)
    parts = np.stack([model.rayleigh_scattering, model.mie_extinction, model.absorption])
    np.testing.assert_allclose(found["extinction"], wanted @ parts, rtol=1e-5, atol=1e-6 * parts.sum())
