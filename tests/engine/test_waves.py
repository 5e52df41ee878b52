"""Waves in float64: against tables, closed forms, published seas and differences of the displacement itself."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest

from planetfall.components import Ocean, Wave
from planetfall.engine.space import direction, local_axes
from planetfall.engine.waves import at_anchor, at_directions, displacement, make_waves, surface, waves_of
from planetfall.engine.waves.anchor import anchor_axes, local_wave
from planetfall.engine.waves.shoaling import footprint_weight, shoaling, shoaling_slope
from planetfall.engine.waves.spectrum import growth, jonswap, slope_variance

DATA = Path(__file__).parents[1] / "data"
EARTH_M = 6.371e6
NO_FADE = (0.0, 1e-9)
G = 9.81


def rows(name):
    with (DATA / name).open() as file:
        return list(csv.DictReader(file))


def sphere(count, seed=0):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


def one(wavelength=100.0, amplitude=0.5, steepness=0.8, speed=0.0, origin=(0.0, 0.0, 1.0), radius=EARTH_M, **more):
    return make_waves([origin], [amplitude], [wavelength], [steepness], [speed], radius, **more)


def away(origin, tangent, angle):
    """The direction at an angle from an origin, and the unit tangent away from it there."""
    return origin * np.cos(angle) + tangent * np.sin(angle), tangent * np.cos(angle) - origin * np.sin(angle)


def phase_of(waves, v, tangent, time_s):
    """The phase of a single wave, from its displacement: height A sin, sideways Q A cos."""
    moved = displacement(waves, v[None], time_s)[0]
    a, q = waves.amplitude_m[0], waves.steepness[0]
    return math.atan2(moved @ v / a, moved @ tangent / (q * a))


def turned(a, b):
    """Difference of two phases, rad, without whole turns."""
    return abs((a - b + math.pi) % (2.0 * math.pi) - math.pi)


# -- tables -----------------------------------------------------------------------------------------------------------


def test_ways_from_the_origin_against_the_table():
    """The phase of a wave of 1 km, as drawn, tells the way."""
    table = rows("ocean_distance.csv")
    assert len(table) >= 25
    origin, tangent = sphere(1, 3)[0], None
    tangent = anchor_axes(origin)[0]
    for row in table:
        radius, angle = float(row["radius_m"]), float(row["angle_rad"])
        waves = one(1000.0, 1.0, 1.0, origin=origin, radius=radius, fade=NO_FADE)
        v, d = away(origin, tangent, angle)
        k = 2.0 * math.pi / 1000.0
        found = phase_of(waves, v, d, 0.0)
        # Rounding of the direction's three numbers, of the way in waves (7e4 at most), and of the reference here.
        allowed = k * radius * 1e-15
        assert turned(found, k * radius * angle) <= max(allowed, 1e-12)
        assert turned(found, k * radius * angle) / k < 0.1 * float(row["err_total_m"]), row["formula"]


def test_phases_against_the_table():
    table = rows("ocean_phase.csv")
    assert len(table) >= 30
    origin = sphere(1, 5)[0]
    tangent = anchor_axes(origin)[0]
    for row in table:
        wavelength, omega, phi = (float(row[k]) for k in ("wavelength_m", "omega", "phi"))
        way, time_s, exact = float(row["l_m"]), float(row["t_s"]), float(row["phase_exact_mod_2pi"])
        waves = one(wavelength, 0.01, 1.0, phi, origin=origin, fade=NO_FADE)
        v, d = away(origin, tangent, way / EARTH_M)
        # A direction is known to 1.1e-16 of the radius in each of its numbers, the way to an ulp of its angle,
        # which is below 2, the turns of the phase to an ulp each.
        allowed = 4e-16 * (omega * (EARTH_M + 2.0 * way) + phi * time_s + 10.0)
        assert allowed < 3e-7
        assert turned(phase_of(waves, v, d, time_s), exact) <= allowed
        # For the shader: cycles between 0 and 1 in single precision.
        anchored = at_anchor(waves, v, time_s)
        assert 0.0 <= anchored.phase[0] < 1.0
        assert turned(2.0 * math.pi * float(anchored.phase[0]), exact) <= allowed + 2.0 * math.pi * 2.0**-25


# -- closed forms -----------------------------------------------------------------------------------------------------


def test_rings_around_an_origin():
    """Beyond 8 wavelengths from the origin: height A sin(k rho + phi t), outward Q A cos of it; nothing inside 1."""
    waves = one(20.0, 0.5, 0.9, speed=1.3)
    origin, tangent = waves.origins[0], np.array([1.0, 0.0, 0.0])
    for rho in (161.0, 500.0, 1234.5):
        for sign in (1.0, -1.0):  # at the antipode as well
            v, d = away(sign * origin, tangent, rho / EARTH_M)
            way = rho if sign > 0 else math.pi * EARTH_M - rho
            theta = 2.0 * math.pi / 20.0 * way + 1.3 * 7.0
            moved = displacement(waves, v[None], 7.0)[0]
            expected = 0.5 * math.sin(theta) * v + sign * 0.45 * math.cos(theta) * d
            # The direction's rounding moves the point by 1e-9 m, which turns the phase by 3e-10; pi r is known to 4e-9.
            np.testing.assert_allclose(moved, expected, atol=2e-9)
    still, _ = away(origin, tangent, np.array([0.0, 5.0, 19.9])[:, None] / EARTH_M)
    assert not displacement(waves, still, 7.0).any()


def test_a_quarter_turn_away_it_is_the_plane_wave():
    """Within 100 m, where the sphere is a plane to 0.8 mm: (x + Q A cos(k x + c), A sin(k x + c)) and its normal."""
    waves = one(40.0, 0.6, 0.7)
    v0 = np.array([1.0, 0.0, 0.0])
    d0 = np.array([0.0, 0.0, -1.0])
    k, a, q = 2.0 * math.pi / 40.0, 0.6, 0.7
    x = np.linspace(-100.0, 100.0, 81)
    across = np.array([0.0, 1.0, 0.0])
    place = v0 * EARTH_M + x[:, None] * d0 + 37.0 * across
    v = place / np.linalg.norm(place, axis=1)[:, None]
    found = surface(waves, v, 0.0)
    theta = k * (EARTH_M * math.pi / 2.0 + x)
    # The plane's normal leans by x / r, 1.6e-5, and crests bend by that as well.
    lean = 100.0 / EARTH_M
    np.testing.assert_allclose(found.displacement_m @ v0, a * np.sin(theta), atol=a * lean + 1e-6)
    np.testing.assert_allclose(found.displacement_m @ d0, q * a * np.cos(theta), atol=a * lean + 1e-6)
    slope = a * k * np.cos(theta) / (1.0 - q * a * k * np.sin(theta))
    normal = v0 - slope[:, None] * d0
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    np.testing.assert_allclose(found.normal, normal, atol=4.0 * lean)
    np.testing.assert_allclose(found.jacobian, 1.0 - q * a * k * np.sin(theta), atol=1e-6)


@pytest.mark.parametrize(("speed", "sign"), [(1.0, -1.0), (-1.0, 1.0)])
def test_crests_run_towards_the_origin_with_positive_speed(speed, sign):
    waves = one(100.0, 0.5, 0.0, speed=speed)
    origin, tangent = waves.origins[0], np.array([1.0, 0.0, 0.0])
    way = 20_000.0 + np.arange(0.0, 100.0, 0.01)
    v, _ = away(origin, tangent, way[:, None] / EARTH_M)
    crest = [way[np.argmax(np.linalg.norm(v * EARTH_M + displacement(waves, v, t), axis=1))] for t in (0.0, 1.0)]
    # phi / k metres a second; crests are found to a step of 1 cm.
    assert crest[1] - crest[0] == pytest.approx(sign * 100.0 / (2.0 * math.pi), abs=0.03)


def test_deep_water_dispersion():
    """A swell of 10 s is 156 m long and runs at 15.6 m/s (g T^2 / 2 pi and g T / 2 pi, as in any text-book)."""
    waves = waves_of(Ocean(waves=[Wave(wavelength_m=156.13)]), EARTH_M)
    period = 2.0 * math.pi / abs(waves.speed_rad_s[0])
    assert period == pytest.approx(10.0, rel=1e-4) and waves.speed_rad_s[0] < 0.0
    assert 156.13 / period == pytest.approx(15.61, rel=1e-3)
    sea = waves_of(Ocean(wave_count=200, gravity_m_s2=3.7), EARTH_M)
    np.testing.assert_allclose(sea.speed_rad_s**2, 3.7 * 2.0 * np.pi / sea.wavelength_m)


# -- differences ------------------------------------------------------------------------------------------------------


def differences(waves, v, axes, step_m, **more):
    """Derivatives of the displaced position along both axes, (M, 2, 3), by central differences of fourth order."""
    r = waves.radius_m
    found = []
    for j in range(2):
        ends = []
        for n in (-2.0, -1.0, 1.0, 2.0):
            angle = n * step_m / r
            there = v * math.cos(angle) + axes[:, j] * math.sin(angle)
            depth = more["depth"](there) if "depth" in more else None
            # Less the centre's position, so that metres and not megametres are subtracted.
            moved = displacement(waves, there, more.get("time_s", 0.0), depth)
            ends.append(moved + axes[:, j] * (r * math.sin(angle)) - v * (2.0 * r * math.sin(0.5 * angle) ** 2))
        found.append((ends[0] - 8.0 * ends[1] + 8.0 * ends[2] - ends[3]) / (12.0 * step_m))
    return np.stack(found, axis=1)


@pytest.mark.parametrize("radius", [6e4, EARTH_M, 7e7])
@pytest.mark.parametrize("time_s", [0.0, 1e5, 1e8])
@pytest.mark.parametrize("place", ["anywhere", "origins", "antipodes"])
def test_tangents_normals_and_jacobian_against_differences(radius, time_s, place):
    waves = waves_of(Ocean(wave_count=24, wind_speed_m_s=12.0, choppiness=2.0), radius)
    fade = waves.fade_rad[:, 1:]
    near = {"anywhere": 1e9, "origins": fade, "antipodes": fade}[place]
    start = np.resize(waves.origins, (24, 3)) * (-1.0 if place == "antipodes" else 1.0)
    v = start + np.minimum(near, 10.0) * 0.7 * sphere(24, 2)
    v /= np.linalg.norm(v, axis=1)[:, None]
    found = surface(waves, v, time_s)
    measured = differences(waves, v, found.axes, 0.02, time_s=time_s)
    # Phases are good to 1e-15 of the way in waves (3e8 m / 0.6 m) plus the turns since t = 0, times A k / step; the
    # fourth-order rule leaves (k step)^4 / 30 of a slope below 1.
    phase = 2.0 * math.pi * 1e-15 * (math.pi * radius / waves.wavelength_m[-1])
    phase += 1e-15 * float(np.max(np.abs(waves.speed_rad_s))) * time_s
    k = float(np.max(waves.wave_number_per_m))
    allowed = phase * waves.highest_m / 0.02 + (k * 0.02) ** 4 / 30.0 + 1e-8
    assert allowed < 2e-3
    assert np.abs(measured - found.tangents).max() < allowed
    normal = np.cross(measured[:, 0], measured[:, 1])
    area = (normal * v).sum(axis=1)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    assert np.abs(normal - found.normal).max() < 4.0 * allowed
    np.testing.assert_allclose(found.jacobian, area, atol=6.0 * allowed)
    assert found.jacobian.min() > 0.0


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_rings_next_to_their_origin_against_differences(sign):
    """Where a placed wave fades in, 1 to 8 wavelengths from its origin, rings are narrow and turn fast."""
    waves = make_waves([[0.6, 0.0, 0.8], [0.6, 3e-6, 0.8]], [0.3, 0.2], [12.0, 7.0], [0.9, 0.8], [2.0, -3.0], EARTH_M)
    origin = waves.origins[0]
    east, north = anchor_axes(origin)
    offsets = np.random.default_rng(2).uniform(-110.0, 110.0, (400, 2)) / EARTH_M
    v = sign * (origin + offsets[:, :1] * east + offsets[:, 1:] * north)
    v /= np.linalg.norm(v, axis=1)[:, None]
    found = surface(waves, v, 3.0)
    measured = differences(waves, v, found.axes, 0.02, time_s=3.0)
    # k step = 0.018: its fourth power over 30, and positions rounded to 1e-9 m over the step.
    assert np.abs(measured - found.tangents).max() < 1e-6
    assert found.jacobian.min() < 0.9


def test_a_sloping_bed_counts():
    """Depth as a linear function of the place: its slope reaches the tangents through the shallow water's factor."""
    waves = waves_of(Ocean(wave_count=16), EARTH_M)
    v0 = direction(20.0, 50.0)
    east, north = anchor_axes(v0)
    offsets = np.random.default_rng(0).uniform(-100.0, 100.0, (60, 2)) / EARTH_M
    v = v0 + offsets[:, :1] * east + offsets[:, 1:] * north
    v /= np.linalg.norm(v, axis=1)[:, None]
    grade = 0.03 * east + 0.01 * north

    def depth(there):
        return 3.0 + EARTH_M * (there - v0) @ grade

    slope = grade - v * (v @ grade)[:, None]
    found = surface(waves, v, 5.0, depth(v), depth_slope=slope)
    measured = differences(waves, v, found.axes, 0.02, time_s=5.0, depth=depth)
    assert (depth(v) < 0.0).any() and (depth(v) > 5.0).any()
    inside = np.abs(depth(v)) > 0.01  # the factor has a corner on the shore
    assert np.abs(measured - found.tangents)[inside].max() < 2e-6
    flat = surface(waves, v, 5.0, depth(v))
    assert np.abs(flat.normal - found.normal).max() > 1e-3, "without the slope it would be seen"


def test_shallow_water_and_footprints():
    k = 2.0 * math.pi / np.array([1.0, 30.0, 200.0])
    depth = np.linspace(0.0, 300.0, 50)[:, None]
    factor = shoaling(k, depth)
    assert (factor[0] == 0.0).all() and (np.diff(factor, axis=0) >= 0.0).all()
    assert (shoaling(k, np.pi / k) > 0.996).all(), "half a wavelength is deep"
    assert (shoaling(k, [-1.0, -20.0, -3.0]) == 0.0).all() and (shoaling_slope(k, -1.0) == 0.0).all()
    step = 1e-5
    measured = (shoaling(k, depth[1:] + step) - shoaling(k, depth[1:] - step)) / (2.0 * step)
    np.testing.assert_allclose(shoaling_slope(k, depth[1:]), measured, atol=1e-9)
    weight = footprint_weight([1.0, 2.0, 3.0, 4.0, 9.0], 1.0)
    assert weight[0] == weight[1] == 0.0 and 0.0 < weight[2] < 1.0 and (weight[3:] == 1.0).all()
    waves = waves_of(Ocean(), EARTH_M)
    v = sphere(5)
    coarse = displacement(waves, v, 0.0, spacing_m=waves.wavelength_m[7] / 4.0)
    some = make_waves(*(getattr(waves, n)[:8] for n in
                        ("origins", "amplitude_m", "wavelength_m", "steepness", "speed_rad_s")),
                      EARTH_M, fade=waves.fade)  # fmt: skip
    assert np.abs(coarse - displacement(some, v, 0.0)).max() <= waves.amplitude_m[8:].sum() * 1.7


def test_ice_stills_the_waves():
    """Open water before the latitude of ice, none 0.02 of its sine further; the same waves where there is no ice."""
    frozen, free = (waves_of(Ocean(ice_latitude_deg=lat), EARTH_M) for lat in (70.0, 90.0))
    edge = math.sin(math.radians(70.0))
    sines = np.array([-1.0, -(edge + 0.02), -edge + 1e-9, 0.0, 0.9, edge, edge + 0.021, 1.0])
    v = direction(np.degrees(np.arcsin(sines)), np.linspace(0.0, 300.0, len(sines)))
    still = np.abs(sines) >= edge + 0.0199
    moved = displacement(frozen, v, 4.0)
    assert not moved[still].any()
    np.testing.assert_array_equal(moved[~still], displacement(free, v, 4.0)[~still])
    between = direction(np.degrees(np.arcsin(np.linspace(edge, edge + 0.02, 4000))), 33.0)
    sizes = np.linalg.norm(displacement(frozen, between, 4.0), axis=1)
    assert sizes[:3000].max() > 0.5 and sizes[-20:].max() < 0.1 * sizes[:3000].max() and sizes[-1] == 0.0


# -- what a shader does with it ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius", [1e5, EARTH_M, 7e7])
@pytest.mark.parametrize("place", ["anywhere", "origin", "antipode"])
def test_ways_from_an_anchor_in_single_precision(radius, place):
    """Within 1 km of the anchor the way is right to 0.3 mm in float32, also where the anchor is next to an origin."""
    waves = waves_of(Ocean(wave_count=20), radius)
    anchor = {"anywhere": direction(12.0, 34.0), "origin": waves.origins[3], "antipode": -waves.origins[3]}[place]
    anchor = anchor + 300.0 / radius * anchor_axes(anchor)[0]
    anchor = anchor / np.linalg.norm(anchor)
    anchored = at_anchor(waves, anchor, 1e8)
    plane = np.random.default_rng(1).uniform(-700.0, 700.0, (400, 2))
    q2 = (plane**2).sum(axis=1)
    down = q2 / (radius * (1.0 + np.sqrt(1.0 - q2 / radius**2)))
    place_m = anchor * (radius - down[:, None]) + plane[:, :1] * anchored.east + plane[:, 1:] * anchored.north
    v = place_m / np.linalg.norm(place_m, axis=1)[:, None]

    def angle(to):
        sine = np.linalg.norm(np.cross(to[:, None, :], waves.origins[None]), axis=2)
        return np.arctan2(sine, to @ waves.origins.T)

    exact = angle(v) - angle(anchor[None])
    x, sine, cosine = local_wave(*(a.astype(np.float32) for a in (*plane.T, down)), anchored, radius)
    assert x.dtype == np.float32
    # Each of a dozen operations on offsets of up to 1 km rounds to 6e-8 of them.
    assert np.abs(x - exact).max() * radius < 3e-4
    np.testing.assert_allclose(np.hypot(sine, cosine), 1.0, atol=5e-7)


# -- seas -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fetch_km", "wind", "height"), [(10, 10.0, 0.515), (50, 10.0, 1.15), (50, 20.0, 2.31), (200, 25.0, 5.76)]
)
def test_height_grows_with_fetch_as_published(fetch_km, wind, height):
    """Carter 1982, from JONSWAP: 0.0163 sqrt(fetch / km) U; heights of the third column by that rule."""
    assert height == pytest.approx(0.0163 * math.sqrt(fetch_km) * wind, rel=0.005)
    _, variance = growth(wind, fetch_km * 1e3, G)
    assert 4.0 * math.sqrt(variance) == pytest.approx(height, rel=0.015)
    for count in (5, 50, 500):
        sea = waves_of(
            Ocean(wind_speed_m_s=wind, fetch_m=fetch_km * 1e3, wave_count=count, swell_height_m=0.0), EARTH_M
        )
        # The waves' band leaves out the shortest, which hold little of the height.
        assert sea.significant_height_m == pytest.approx(height, rel=0.06 if count == 5 else 0.02)


@pytest.mark.parametrize(("beaufort", "wind", "height"), [(4, 6.7, 1.0), (5, 9.4, 2.0), (6, 12.3, 3.0)])
def test_full_development_is_that_of_the_open_sea(beaufort, wind, height):
    """0.22 U^2 / g after Pierson and Moskowitz (Stewart 2008); "probable height" of the Beaufort scale on the open sea
    (WMO), which is given to half a metre at best."""
    sea = waves_of(Ocean(wind_speed_m_s=wind, fetch_m=1e7, swell_height_m=0.0), EARTH_M)
    assert sea.significant_height_m == pytest.approx(0.22 * wind**2 / G, rel=0.07)
    assert abs(sea.significant_height_m - height) < 0.5
    peak, _ = growth(wind, 1e7, G)
    # Their peak: 0.877 g over the wind at 19.5 m, which is 1.026 times that at 10 m.
    assert peak == pytest.approx(0.877 * G / (1.026 * wind), rel=0.005)


def test_the_spectrum_has_the_shape_of_jonswap():
    """DNV-RP-C205's fits: energy beside Pierson-Moskowitz' 1 / (1 - 0.287 ln gamma), mean zero-crossing period."""
    w = np.linspace(0.3, 60.0, 400_000)
    s = jonswap(w, 1.0)
    plain = w**-5.0 * np.exp(-1.25 * w**-4.0)
    m0, m2 = np.trapezoid(s, w), np.trapezoid(s * w**2, w)
    assert m0 / np.trapezoid(plain, w) == pytest.approx(1.0 / (1.0 - 0.287 * math.log(3.3)), rel=0.01)
    ratio = 0.6673 + 0.05037 * 3.3 - 0.006230 * 3.3**2 + 0.0003341 * 3.3**3
    assert math.sqrt(m0 / m2) == pytest.approx(ratio, rel=0.01)
    assert w[np.argmax(s)] == pytest.approx(1.0, abs=0.01)


def test_slopes_are_those_of_cox_and_munk():
    """Their clean sea at 10 m/s: a mean square slope of 0.054; what waves don't have is left as variance."""
    assert slope_variance(10.0) == pytest.approx(0.054, abs=0.001)
    for count in (1, 20, 1000):
        sea = waves_of(Ocean(wind_speed_m_s=10.0, wave_count=count, swell_height_m=0.0), EARTH_M)
        assert sea.slope_variance + sea.slope_variance_beyond == pytest.approx(0.0542, rel=1e-9)
        assert sea.slope_variance_beyond > 0.25 * 0.0542


@pytest.mark.parametrize("count", [1, 2, 7, 32, 300, 1000])
def test_a_spectrum_is_a_sea(count):
    ocean = Ocean(wave_count=count, wind_at=(30.0, 60.0), wind_direction_deg=50.0, swell_direction_deg=110.0)
    sea = waves_of(ocean, EARTH_M)
    assert len(sea) == count and (np.diff(sea.wavelength_m) <= 0.0).all()
    k, a = sea.wave_number_per_m, sea.amplitude_m
    assert float(np.sum(sea.steepness * a * k)) <= 0.95 + 1e-9
    np.testing.assert_allclose(np.linalg.norm(sea.origins, axis=1), 1.0)
    # No two of the same wavelength or from the same place: nothing repeats.
    assert len(np.unique(sea.wavelength_m)) == count
    if count >= 32:
        assert np.min(-np.diff(np.log(sea.wavelength_m))) > 0.0
        place = direction(30.0, 60.0)
        north, east = local_axes(place)
        ahead = -(sea.origins - (sea.origins @ place)[:, None] * place)
        heading = np.degrees(np.arctan2(ahead @ east, ahead @ north))
        swell = np.isclose(sea.amplitude_m, 1.2 / 4.0 * math.sqrt(2.0 / min(round(0.2 * count), 40)))
        assert abs(heading[swell].mean() - 110.0) < 3.0 and heading[swell].std() < 12.0
        mean = np.average(heading[~swell], weights=a[~swell] ** 2)
        assert abs(mean - 50.0) < 6.0
        # At the place of the wind every wave is there in full; a calm around an origin takes little of the sea away.
        weights = [float(np.sum((a * (np.arccos(np.clip(np.abs(sea.origins @ v), 0, 1)) > sea.fade_rad[:, 1])) ** 2))
                   for v in (place, *sphere(200))]  # fmt: skip
        assert weights[0] == pytest.approx(float(np.sum(a**2)))
        assert min(weights) > 0.5 * weights[0]
    again = waves_of(ocean, EARTH_M)
    np.testing.assert_array_equal(again.origins, sea.origins)
    ocean.wave_seed = 7
    assert not np.allclose(waves_of(ocean, EARTH_M).origins, sea.origins)


def test_calm_and_missing_parts():
    still = Ocean(wind_speed_m_s=0.0, swell_height_m=0.0)
    assert len(waves_of(still, EARTH_M)) == 0 and waves_of(still, EARTH_M).slope_variance_beyond == pytest.approx(0.003)
    v = sphere(7)
    smooth = surface(waves_of(still, EARTH_M), v, 3.0)
    assert not smooth.displacement_m.any()
    np.testing.assert_allclose(smooth.normal, v, atol=1e-15)
    only = waves_of(Ocean(wind_speed_m_s=0.0, swell_height_m=2.0, swell_period_s=12.0, wave_count=10), EARTH_M)
    assert len(only) == 10 and only.significant_height_m == pytest.approx(2.0)
    assert only.wavelength_m.min() > 100.0 and only.wavelength_m.max() < 400.0
    tiny = waves_of(Ocean(wind_speed_m_s=30.0, fetch_m=1e7), 1000.0)
    assert tiny.wavelength_m.max() <= 50.0 + 1e-9


# -- inversion --------------------------------------------------------------------------------------------------------


STEEP = [Wave(origin=(10.0, 20.0), amplitude_m=2.0, wavelength_m=12.7, steepness=1.0)]


@pytest.mark.parametrize(
    ("ocean", "radius"),
    [
        (Ocean(wave_count=20), EARTH_M),
        (Ocean(wave_count=300, wind_speed_m_s=20.0, choppiness=2.0, swell_height_m=6.0), 7e7),
        (Ocean(waves=STEEP), EARTH_M),
        (Ocean(wave_count=20, method="paper_2018"), EARTH_M),
        (Ocean(wave_count=20, method="paper_2019"), 6e4),
    ],
)
def test_what_is_found_in_a_direction_is_there(ocean, radius):
    waves = waves_of(ocean, radius)
    v = np.concatenate([sphere(60), waves.origins[:1] + 3e-4 * sphere(60, 4)])
    v /= np.linalg.norm(v, axis=1)[:, None]
    time_s = np.linspace(0.0, 1e6, len(v))
    calm, depth, moved = at_directions(waves, v, time_s, method=ocean.method)
    assert depth is None
    again = displacement(waves, calm, time_s, method=ocean.method)
    np.testing.assert_allclose(again, moved, atol=1e-9)
    position = calm * radius + moved
    assert np.linalg.norm(np.cross(position, v), axis=1).max() < 1e-3


# -- as printed -------------------------------------------------------------------------------------------------------


def test_printed_methods_agree_with_ours_a_quarter_turn_away():
    """Where |d| is 1 and nothing fades, they are the same waves, in float64; with one wave, the same normal."""
    waves = one(50.0, 0.8, 0.6, speed=-1.0)
    v = direction(0.0, np.linspace(0.0, 360.0, 40))
    ours = surface(waves, v, 12.0)
    for method in ("paper_2018", "paper_2019"):
        printed = surface(waves, v, 12.0, method=method)
        np.testing.assert_allclose(printed.displacement_m, ours.displacement_m, atol=1e-6)
        # Theirs leaves out the curve of the sphere: A / r, and the turn of the tangent plane under Q A of sideways way.
        np.testing.assert_allclose(printed.normal, ours.normal, atol=5e-7)
        np.testing.assert_allclose((printed.normal * printed.tangents[:, 0]).sum(axis=1), 0.0, atol=1e-9)


def test_printed_directions_are_as_long_as_the_sine():
    waves = one(50.0, 0.8, 0.6)
    v, d = away(waves.origins[0], np.array([1.0, 0.0, 0.0]), math.radians(30.0))
    ours = displacement(waves, v[None], 0.0)[0]
    printed = displacement(waves, v[None], 0.0, method="paper_2018")[0]
    assert printed @ d == pytest.approx(0.5 * (ours @ d), abs=1e-6)
    assert printed @ v == pytest.approx(ours @ v, abs=1e-6)


def test_the_printed_normal_is_of_one_wave_only():
    """Two steep waves at right angles: the printed normal is off by degrees, ours is that of the surface."""
    q = 0.5 / (2.0 * math.pi)
    waves = make_waves([[0, 0, 1], [0, 1, 0]], [1.0, 1.0], [1.0 * 10, 11.0], [q * 8, q * 8], [0.0, 0.0], EARTH_M)
    v = direction(np.linspace(-1e-4, 1e-4, 300), np.linspace(-1e-4, 1.3e-4, 300))
    ours, printed = surface(waves, v, 0.0), surface(waves, v, 0.0, method="paper_2018")
    measured = differences(waves, v, ours.axes, 0.02)
    true = np.cross(measured[:, 0], measured[:, 1])
    true /= np.linalg.norm(true, axis=1)[:, None]

    def degrees(normal):
        return np.degrees(np.arcsin(np.minimum(np.linalg.norm(np.cross(normal, true), axis=1), 1.0)))

    assert degrees(ours.normal).max() < 0.001
    assert np.percentile(degrees(printed.normal), 99) > 3.0
