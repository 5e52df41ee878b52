"""Materials of ground and sea in small pictures: knobs show, albedos are natural, colours do not hang on distance."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import planetfall as pf
from planetfall.components import Ocean, Terrain
from planetfall.components._knob import knobs
from planetfall.engine.surface.nested import NESTED_BASE_M, nested_anchor

SIZE = (64, 36)
NOON = pf.Sun(elevation_deg=60.0, azimuth_deg=150.0, latitude_deg=0.0, longitude_deg=0.0)


@pytest.fixture(scope="module")
def scene():
    return pf.load_scene("earth")


@pytest.fixture(scope="module")
def renderer(scene):
    # Each pixel: blocks of these are wider than anything that stands on the ground. Light as given: red by itself
    # counts for less where it is carried between red and green.
    overrides = {"terrain.shade_every": 1, "light.wavelengths": "given"}
    with pf.Renderer(scene, size=SIZE, quality="low", overrides=overrides) as made:
        made.settle(pf.view("coast"))  # the air's tables are final: equal scenes give equal pictures from here on
        yield made


def radiance(renderer, camera, **options):
    return renderer.render(camera, outputs=("radiance",), **options)["radiance"].astype(float)


# Broadband or visible albedos, the mean of the three wavelengths: snow Warren 1982 (fresh 0.8 and more), the others
# Oke 1987, table 1.1 (grass, forest, dry soil, sand in the visible), and Hapke 1993 for rock.
@pytest.mark.parametrize(
    ("field", "low", "high"),
    [
        ("snow_albedo", 0.8, 0.95),
        ("sand_albedo", 0.2, 0.45),
        ("dry_albedo", 0.15, 0.35),
        ("rock_albedo", 0.10, 0.25),
        ("strata_albedo", 0.10, 0.25),
        ("tundra_albedo", 0.08, 0.2),
        ("grass_albedo", 0.04, 0.15),
        ("forest_albedo", 0.02, 0.08),
    ],
)
def test_albedos_are_natural(field, low, high):
    assert low <= np.mean(getattr(Terrain(), field)) <= high


# Where each knob is to show, and a value that differs from the default.
TERRAIN = {
    "rock_albedo": ("high", (0.3, 0.05, 0.05)),
    "strata_albedo": ("high", (0.3, 0.05, 0.05)),
    "strata": ("near", 0.0),
    "strata_m": ("near", 900.0),
    "dry_albedo": ("space", (0.1, 0.1, 0.4)),
    "sand_albedo": ("beach", (0.1, 0.1, 0.4)),
    "snow_albedo": ("high", (0.4, 0.4, 0.4)),
    "grass_albedo": ("near", (0.1, 0.05, 0.1)),
    "forest_albedo": ("space", (0.1, 0.02, 0.1)),
    "tundra_albedo": ("space", (0.3, 0.1, 0.3)),
    "plants": ("near", 0.3),
    "humidity": ("near", 0.1),
    "rock_slope_deg": ("near", 8.0),
    "beach_height_m": ("coast", 30.0),
    "beach_share": ("coast", 0.0),
    "snow_line_m": ("high", 7500.0),
    "snow_line_pole_m": ("high", 2500.0),
    "snow_slope_deg": ("high", 8.0),
    "season": ("ground", 0.0),
    "variation": ("near", 0.0),
    "grain": ("beach", 4.0),
    "clutter": ("ground", 0.0),
    "dust_law": ("near", 1.0),
}
OCEAN = {
    "absorption_per_m": ("coast", (0.05, 0.3, 0.3)),
    "scattering_per_m": ("space", (0.02, 0.002, 0.002)),
    "bed_albedo": ("coast", (0.1, 0.1, 0.5)),
    "roughness": ("space", 0.4),
    "refractive_index": ("coast", 2.0),
    "foam_albedo": ("beach", (0.1, 0.1, 0.1)),
    "surf_m": ("beach", 1.0),
    "bed_detail": ("under", 0.0),
    "glow": ("coast", (0.1, 0.0, 0.0)),
    "ice_latitude_deg": ("pole", 89.5),
    "ice_albedo": ("pole", (0.2, 0.2, 0.2)),
}


SEEN_IN_PAIRS = {"foam", "crust", "caustics"}  # finer than these pixels, or nothing by itself: test_golden has them


def test_every_knob_of_the_ground_and_the_water_is_tried():
    shape = {"ground", "plants"}
    assert {n for n, k in knobs(Terrain).items() if k.group in shape} == set(TERRAIN)
    assert {n for n, k in knobs(Ocean).items() if k.group in {"water", "foam", "ice"}} == {*OCEAN, *SEEN_IN_PAIRS}


@pytest.mark.parametrize(
    ("kind", "field", "view", "value"),
    [(Terrain, f, v, x) for f, (v, x) in TERRAIN.items()] + [(Ocean, f, v, x) for f, (v, x) in OCEAN.items()],
)
def test_a_knob_changes_the_picture(scene, renderer, kind, field, view, value):
    component, camera, ground = scene.planet[kind], pf.view(view), scene.planet[Terrain]
    rock_slope_deg, default = ground.rock_slope_deg, getattr(component, field)
    if field.startswith("strata"):
        ground.rock_slope_deg = 1.0  # rock everywhere
    before = radiance(renderer, camera)
    try:
        setattr(component, field, value)
        after = radiance(renderer, camera)
        setattr(component, field, default)
        again = radiance(renderer, camera)
    finally:
        setattr(component, field, default)
        ground.rock_slope_deg = rock_slope_deg
    assert np.isfinite(after).all() and (after >= 0.0).all()
    assert np.abs(after - before).max() > 0.02 * before.max(), f"{field} = {value} cannot be seen in '{view}'"
    assert np.array_equal(again, before), "back to the default: the same picture"


@pytest.mark.parametrize("planet", ["mars", "moon", "asteroid", "small", "hazy"])
def test_planets_shade_without_nan_and_reflect_less_than_falls_on_them(planet):
    scene = pf.load_scene(planet)
    with pf.Renderer(scene, size=SIZE, quality="low") as renderer:
        for view in ("space", "near", "terminator"):
            seen = radiance(renderer, pf.view(view))
            assert np.isfinite(seen).all() and (seen >= 0.0).all()
        lit = radiance(renderer, pf.view("space"))
        reflected = lit.max(axis=(0, 1)) * np.pi / np.asarray(scene.sun.irradiance)
        assert (reflected < 1.0).all() and (reflected > 0.01).all()


def downward(latitude_deg, longitude_deg, altitude_m):
    return pf.Camera.at(latitude_deg, longitude_deg, altitude_m, pitch_deg=-90.0, fov_y_deg=30.0, above="ground")


def test_the_open_sea_is_dark_and_blue(scene, renderer):
    sun = dataclasses.replace(NOON, elevation_deg=35.0, latitude_deg=24.0, longitude_deg=-78.4)
    seen = radiance(renderer, downward(24.0, -78.4, 300.0), sun=sun)  # low: hardly any air between
    albedo = seen.mean(axis=(0, 1)) * np.pi / (np.asarray(scene.sun.irradiance) * np.sin(np.radians(35.0)))
    assert albedo[2] > 2.0 * albedo[1] > 2.0 * albedo[0]
    assert 0.01 < albedo[2] < 0.06, "blue light that comes back from deep water"


def test_glitter_is_wider_and_dimmer_over_a_rougher_sea(scene, renderer):
    ocean, camera = scene.planet[Ocean], downward(24.0, -78.4, 20000.0)
    sun = dataclasses.replace(NOON, elevation_deg=89.0, latitude_deg=24.0, longitude_deg=-78.4)
    before, peaks = (ocean.roughness, ocean.wind_speed_m_s, ocean.swell_height_m), []
    ocean.wind_speed_m_s, ocean.swell_height_m = 0.0, 0.0
    for ocean.roughness in (0.1, 0.2, 0.3):
        peaks.append(radiance(renderer, camera, sun=sun)[..., 0].max())
    ocean.roughness, ocean.wind_speed_m_s, ocean.swell_height_m = before
    # A Gaussian at its peak goes with one over its variance: roughness, and 0.003 without wind (Cox and Munk 1954).
    variance = np.array([0.1, 0.2, 0.3]) ** 2 + 0.003
    assert peaks[0] / peaks[1] == pytest.approx(variance[1] / variance[0], rel=0.2)
    assert peaks[1] / peaks[2] == pytest.approx(variance[2] / variance[1], rel=0.2)


@pytest.mark.parametrize(("latitude_deg", "longitude_deg"), [(2.0, 8.0), (20.5, 2.5), (-28.0, 78.0)])
def test_a_place_keeps_its_colour_from_near_to_far(scene, renderer, latitude_deg, longitude_deg):
    sun = dataclasses.replace(NOON, latitude_deg=latitude_deg, longitude_deg=longitude_deg)
    colours = []
    for altitude_m in (2e4, 6e4, 1.8e5):
        # The same 9 km in each.
        camera = pf.Camera.at(
            latitude_deg,
            longitude_deg,
            altitude_m,
            pitch_deg=-90.0,
            fov_y_deg=float(np.degrees(2 * np.arctan(4500 / altitude_m))),
        )
        colours.append(radiance(renderer, camera, sun=sun).mean(axis=(0, 1)))
    assert np.allclose(colours[1:], colours[0], rtol=0.25)


def test_a_full_moon_is_flat_and_a_matt_one_is_not():
    scene = pf.load_scene("moon")
    ground = scene.planet[Terrain]
    ground.color_map, ground.height_map, ground.craters = "", "", 0.0  # ground all alike
    ground.variation = 0.0
    ground.rock_albedo = ground.strata_albedo = ground.sand_albedo = ground.dry_albedo
    camera = pf.Camera.at(0.0, 0.0, 2.0e7, pitch_deg=-90.0, fov_y_deg=12.0)
    sun = pf.Sun(elevation_deg=89.9, azimuth_deg=0.0, latitude_deg=0.0, longitude_deg=0.0)
    shares = []
    with pf.Renderer(scene, size=SIZE, quality="low") as renderer:
        for ground.dust_law in (1.0, 0.0):
            disc = radiance(renderer, camera, sun=sun)[..., 1]
            row = disc[18][disc[18] > 1e-6]
            edge = len(row) // 10
            shares.append(np.mean(np.r_[row[1:edge], row[-edge:-1]]) / np.mean(row[len(row) // 3 : -len(row) // 3]))
    assert shares[0] > 0.75 and shares[1] < 0.65


@pytest.mark.parametrize("radius_m", [1000.0, 6.371e6, 7.0e7])
def test_nested_places_do_not_hang_on_the_anchor(radius_m):
    rng = np.random.default_rng(3)
    for k in (0, 5, 12, 22):
        wavelength = NESTED_BASE_M * 2.0**k
        first = rng.normal(size=3)
        first /= np.linalg.norm(first)
        second = first + rng.normal(size=3) * min(50.0 / radius_m, 0.01)
        second /= np.linalg.norm(second)
        places = []
        for anchor in (first, second):
            place = nested_anchor(anchor, radius_m)
            assert max(abs(c) for c in place.cell) < 2**31
            offset = (second - anchor) * radius_m + 1.25 * wavelength
            cells, rest = np.array(place.cell), np.array(place.fraction)
            inside = ((cells & ((1 << k) - 1)) + rest) / 2.0**k
            places.append((cells >> k) + inside + offset / wavelength)
        assert np.allclose(*places, atol=1e-6 * max(1.0, radius_m / 6e6))
