"""The tables after Bruneton 2017: against the same method in float64, against independent truth, and at the edges."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from air_tables import Floats, table
from paper_air_twin import PaperTwin

from planetfall.engine.blocks.bindings import AIR_BLOCK
from planetfall.engine.gpu import Gpu, GpuScope
from planetfall.systems.atmosphere import AirBlock, PaperSizes, PaperTables

pytestmark = pytest.mark.gpu

EARTH = AirBlock(
    radius_m=6.36e6,
    top_radius_m=6.42e6,
    thickness_m=6.0e4,
    per_thickness=1.0 / 6.0e4,
    rayleigh_per_m=(5.802339381712381e-6, 1.355776244792022e-5, 3.3100005976367735e-5),
    rayleigh_height_m=8000.0,
    mie_scattering_per_m=(3.996e-6,) * 3,
    mie_height_m=1200.0,
    mie_extinction_per_m=(4.44e-6,) * 3,
    mie_asymmetry=0.8,
    absorption_per_m=(6.497166e-7, 1.8809e-6, 8.501668e-8),
    absorber_height_m=25.0e3,
    ground_albedo=(0.1, 0.1, 0.1),
    absorber_slope_per_m=1.0 / 15.0e3,
    night_radiance=(0.0, 0.0, 0.0),
    longest_path_m=8.8e5,
    mie_moments=(0.0, 0.0, 0.0, 0.0),
    sun_radius_rad=0.004675,
)
"""The air of tests/data/air_*.csv: 6360 km and 60 km."""

HEADER = '#include "atmosphere/paper/functions.glsl"'
SKY = """
vec3 rest, mie, through;
air_sky(h, mu, mu_s, nu, rest, mie, through);
rayleigh = rest / paper_rayleigh_phase(nu);
haze = mie;
radiance = air_sky_radiance(h, mu, mu_s, nu);
transmittance = through;
"""
SKY_OUTPUTS = {"rayleigh": "vec3", "haze": "vec3", "radiance": "vec3", "transmittance": "vec3"}
SEGMENT = """
vec3 through, light;
air_segment(h, mu, mu_s, nu, distance_m, through, light);
transmittance = through;
radiance = light;
"""
SEGMENT_OUTPUTS = {"transmittance": "vec3", "radiance": "vec3"}


class Air:
    """Tables of one air, and the functions that read them."""

    def __init__(self, scope: GpuScope, run: Callable[..., Any], block: AirBlock, sizes: PaperSizes) -> None:
        self.run, self.uniforms = run, scope.uniform_block(AirBlock, AIR_BLOCK, "air_model")
        self.uniforms.write(block)
        self.uniforms.bind()
        self.tables = PaperTables(scope, sizes)
        while not self.tables.done:
            self.tables.step(8_000_000)

    def ask(self, body: str, inputs: Mapping[str, Any], outputs: Mapping[str, str]) -> dict[str, Floats]:
        def setup(_: Any) -> None:
            self.uniforms.bind()
            self.tables.bind()

        found = self.run(body, inputs, outputs, HEADER, setup=setup)
        return {name: values.astype(float) for name, values in found.items()}

    def read(self, name: str) -> Floats:
        """A table as the twin has it: (r, mu, 3) or (r, mu, mu_s, nu, 3)."""
        texture, sizes = self.tables.textures[name], self.tables.sizes
        texels = np.frombuffer(texture.read(), {"f2": np.float16, "f4": np.float32}[texture.dtype]).astype(float)
        if name in ("transmittance", "irradiance"):
            return texels.reshape(*texture.size[::-1], 4)[..., :3]
        r, mu, mu_s, nu = sizes.scattering
        return texels.reshape(r, mu, nu, mu_s, 4)[..., :3].swapaxes(2, 3)


@pytest.fixture
def make_air(scope: GpuScope, run_compute: Callable[..., Any]) -> Callable[..., Air]:
    return lambda block, sizes: Air(scope, run_compute, block, sizes)


# -- the same method in float64 ---------------------------------------------------------------------------------------

TINY = PaperSizes(transmittance=(24, 8), scattering=(3, 8, 5, 4), irradiance=(6, 3), orders=3, storage="rgba32f")


def test_tables_are_what_the_printed_sums_give(make_air) -> None:
    twin, air = PaperTwin(EARTH, TINY), make_air(EARTH, TINY)
    expected = {
        "transmittance": twin.transmittance, "mie": twin.mie, "scattering": twin.scattering,
        "irradiance": twin.irradiance,
    }  # fmt: skip
    for name, right in expected.items():
        error = np.abs(air.read(name) - right)
        # A GPU's filter may weigh texels in steps of 1/256. Where the sun sets on a ray, 6e-8 in a cosine of which a
        # root is taken is 1e-3 of the light; elsewhere both agree to rounding, or to half of a filter's step.
        assert error.max() <= right.max() / 256.0, name
        assert np.median(error / np.maximum(right, 1e-4 * right.max())) <= 1.0 / 512.0, name


def test_half_floats_are_rounded_to_nearest(make_air) -> None:
    full = make_air(EARTH, TINY).read("mie")
    half = make_air(EARTH, PaperSizes(**{**vars(TINY), "storage": "rgba16f"})).read("mie")
    np.testing.assert_array_equal(half, full.astype(np.float16).astype(float))


# -- independent truth ------------------------------------------------------------------------------------------------


def _cosines(*degrees: Floats) -> list[Floats]:
    return [np.cos(np.radians(angle)) for angle in degrees]


def _errors(found: Floats, right: Floats, rows: Any, floor: float) -> Floats:
    found, right = found[rows], right[rows]
    counted = np.abs(right) > floor
    assert counted.sum() > 10
    return np.abs(found - right)[counted] / right[counted]


def _check_sky(air: Air, wider: float) -> None:
    """Single scattering; air was made with one order."""
    truth = table("air_single_scattering")
    mu, mu_s = _cosines(truth["view_zenith_deg"], truth["sun_zenith_deg"])
    found = air.ask(SKY, {"h": truth["altitude_m"], "mu": mu, "mu_s": mu_s, "nu": truth["nu"]}, SKY_OUTPUTS)
    suns = np.array([row["sun_class"] for row in truth.rows])
    sky = truth["ray_hits_ground"] == 0
    # Medians and 95th percentiles of float64 tables of Bruneton's sizes.
    for sun, stem, name, median, p95 in (
        ("day", "L1_disc", "radiance", 4.7e-3, 3.6e-2),
        ("day", "SM_disc", "haze", 6.1e-2, 0.27),
        ("low", "L1_disc", "radiance", 3.0e-3, 4.1e-2),
    ):
        error = _errors(found[name], truth.triple(stem), sky & (suns == sun), 1e-7)
        assert np.median(error) <= wider * median, (sun, stem)
        assert np.percentile(error, 95) <= wider * p95, (sun, stem)
    day_in_space = (suns == "space") & (truth["sun_zenith_deg"] <= 90.0)
    space = _errors(found["radiance"], truth.triple("L1_disc"), day_in_space, 1e-7)
    assert np.percentile(space, 95) <= wider * 1.6e-2


def _check_segments(air: Air, wider: float) -> None:
    truth = table("air_aerial_single")
    inputs = {
        "h": truth["camera_altitude_m"], "mu": truth["dir_z"], "mu_s": _cosines(truth["sun_zenith_at_camera_deg"])[0],
        "nu": truth["nu"], "distance_m": truth["distance_m"],
    }  # fmt: skip
    found = air.ask(SEGMENT, inputs, SEGMENT_OUTPUTS)
    day = truth["sun_zenith_at_camera_deg"] <= 85.0
    error = _errors(found["radiance"], truth.triple("L1_disc"), day, 1e-7)
    assert np.percentile(error, 95) <= wider * 3.5e-2
    assert np.isfinite(found["radiance"]).all()
    assert (found["transmittance"] >= 0.0).all() and (found["transmittance"] <= 1.0).all()


def _check_all_orders(air: Air, wider: float) -> None:
    truth = table("air_total_radiance")
    mu, mu_s, around = _cosines(truth["view_zenith_deg"], truth["sun_zenith_deg"], truth["azimuth_deg"])
    nu = mu * mu_s + np.sqrt((1.0 - mu**2) * (1.0 - mu_s**2)) * around
    found = air.ask(SKY, {"h": truth["altitude_m"], "mu": mu, "mu_s": mu_s, "nu": nu}, SKY_OUTPUTS)
    day = (truth["sun_zenith_deg"] <= 88.0) & (truth["altitude_m"] <= 60_000.0)
    error = _errors(found["radiance"], truth.triple("Ltot"), day, 1e-7)
    assert np.median(error) <= wider * 1.2e-2
    assert np.percentile(error, 95) <= wider * 4.5e-2
    lit = table("air_irradiance")
    found = air.ask(
        "e = air_sky_irradiance(h, mu_s, 1.0);",
        {"h": lit["altitude_m"], "mu_s": _cosines(lit["sun_zenith_deg"])[0]},
        {"e": "vec3"},
    )
    error = _errors(found["e"], lit.triple("Esky_total"), lit["sun_zenith_deg"] <= 88.0, 1e-7)
    assert np.percentile(error, 95) <= wider * 0.10


def test_transmittance_to_space(make_air) -> None:
    """The table of the printed size is quick to make: its printed error."""
    air = make_air(EARTH, PaperSizes(scattering=(2, 4, 2, 2), orders=1))
    truth = table("air_transmittance_top")
    inputs = {"h": truth["altitude_m"], "mu": _cosines(truth["view_zenith_deg"])[0]}
    found = air.ask("t = air_transmittance_to_space(h, mu);", inputs, {"t": "vec3"})["t"]
    right = truth.triple("T")
    error = _errors(found, right, truth["view_zenith_deg"] <= 80.0, 1e-6)
    assert np.median(error) <= 2.1e-5 and np.percentile(error, 95) <= 2.4e-4
    assert np.abs(found - right).max() <= 4.1e-4


HALF = {"scattering": (16, 64, 32, 8)}


def test_half_the_texels_of_altitude_and_view(make_air) -> None:
    """The error of linear interpolation grows with the square of the spacing: four times that of the printed sizes."""
    single = make_air(EARTH, PaperSizes(**HALF, orders=1))
    _check_sky(single, 4.0)
    _check_segments(single, 4.0)
    _check_all_orders(make_air(EARTH, PaperSizes(**HALF)), 4.0)


@pytest.mark.slow
@pytest.mark.parametrize("storage", ["rgba16f", "rgba32f"])
def test_printed_sizes(make_air, storage: str) -> None:
    """The printed errors were taken over many more rays: percentiles of ten to sixty rays scatter by a factor of two
    (resampling them gives medians from 0.7 to 1.7 times their own)."""
    single = make_air(EARTH, PaperSizes(orders=1, storage=storage))
    _check_sky(single, 2.0)
    _check_segments(single, 2.0)
    _check_all_orders(make_air(EARTH, PaperSizes(storage=storage)), 2.0)


# -- edges ------------------------------------------------------------------------------------------------------------

SMALL = PaperSizes(transmittance=(64, 16), scattering=(6, 16, 8, 4), irradiance=(16, 4), orders=2)


def test_space_floor_and_top(make_air) -> None:
    air = make_air(EARTH, SMALL)
    # Rays that miss; then a camera just above and just below the top, looking down, level and up.
    h = np.array([1e5, 1e5, 1e9, 60_001.0])
    mu = np.array([0.5, -0.1, -0.999, 0.0])
    found = air.ask(SKY, {"h": h, "mu": mu, "mu_s": 0.5, "nu": 0.1}, SKY_OUTPUTS)
    np.testing.assert_array_equal(found["radiance"], 0.0)
    np.testing.assert_array_equal(found["transmittance"], 1.0)
    looks = np.repeat([-1.0, -0.5, -0.2, -0.13, 0.0, 0.3], 2)
    at_top = np.tile([59_999.99, 60_000.01], 6)
    found = air.ask(SKY, {"h": at_top, "mu": looks, "mu_s": 0.3, "nu": 0.2}, SKY_OUTPUTS)
    for name in ("radiance", "transmittance"):
        inside, outside = found[name][::2], found[name][1::2]
        # A level ray along the last centimetre is 100 m of the thinnest air.
        np.testing.assert_allclose(inside, outside, rtol=1e-4, atol=1e-6)
    # From far away the same ray as from where it enters.
    r, top = 6.36e6 + 3.6e7, 6.42e6
    sine = 6.38e6 / r  # passes 20 km above the floor
    entry_mu, entry_sine = -np.sqrt(1.0 - (6.38e6 / top) ** 2), 6.38e6 / top
    turn = np.arccos(sine * entry_sine + np.sqrt(1.0 - sine**2) * -entry_mu)  # at the centre, camera to entry
    suns = np.array([0.3, 0.9, 1.4])  # zenith at the camera, beyond the planet's centre as the ray is
    view = np.pi - np.arcsin(sine)
    far = {"h": 3.6e7, "mu": np.cos(view), "mu_s": np.cos(suns), "nu": np.cos(view - suns)}
    near = {"h": 60_000.0, "mu": entry_mu, "mu_s": np.cos(suns - turn), "nu": np.cos(view - suns)}
    far, near = (air.ask(SKY, inputs, SKY_OUTPUTS)["radiance"] for inputs in (far, near))
    # Two metres in the height of the ray come from 6e-8 in the far camera's cosine.
    np.testing.assert_allclose(far, near, rtol=2e-3, atol=1e-6)
    # Below the floor as on it.
    floor = air.ask(SKY, {"h": np.array([-500.0, 0.0]), "mu": 0.1, "mu_s": 0.3, "nu": 0.2}, SKY_OUTPUTS)
    np.testing.assert_array_equal(floor["radiance"][0], floor["radiance"][1])


def test_a_segment_to_the_boundary_is_the_sky(make_air) -> None:
    """And one of no length, or one that ends before the air begins, is nothing."""
    air = make_air(EARTH, SMALL)
    rays = {"h": np.array([2.0, 2.0, 3e4, 3e4, 1e6]), "mu": np.array([0.4, -0.5, 0.2, -0.6, -0.9])}
    sun = {"mu_s": 0.6, "nu": np.array([0.7, 0.1, 0.6, -0.1, -0.5])}
    sky = air.ask(SKY, {**rays, **sun}, SKY_OUTPUTS)
    whole = air.ask(SEGMENT, {**rays, **sun, "distance_m": 1e8}, SEGMENT_OUTPUTS)
    np.testing.assert_allclose(whole["radiance"], sky["radiance"], rtol=2e-3, atol=1e-6)
    up = np.array([0, 2])
    np.testing.assert_allclose(whole["transmittance"][up], sky["transmittance"][up], rtol=1e-3)
    none = air.ask(SEGMENT, {**rays, **sun, "distance_m": 0.0}, SEGMENT_OUTPUTS)
    np.testing.assert_allclose(none["radiance"], 0.0, atol=1e-6)
    np.testing.assert_allclose(none["transmittance"], 1.0, rtol=1e-6)
    before = air.ask(SEGMENT, {**rays, **sun, "distance_m": 9e5}, SEGMENT_OUTPUTS)
    np.testing.assert_array_equal(before["radiance"][4], 0.0)


def test_sun_in_the_tables_convention(make_air) -> None:
    """The share of the disc that is up, times transmittance; in space past the limb all of it."""
    air = make_air(EARTH, PaperSizes(scattering=(2, 4, 2, 2), orders=1))
    h = np.array([0.0, 0.0, 0.0, 0.0, 5e4, 1e6, 1e6])
    a = EARTH.sun_radius_rad
    horizon = -np.sqrt(1.0 - (6.36e6 / (6.36e6 + h)) ** 2)
    offset = np.array([2 * a, 0.5 * a, -0.5 * a, -1.01 * a, 0.0, 0.0, 0.2])
    found = air.ask("t = air_sun_transmittance(h, mu_s);", {"h": h, "mu_s": horizon + offset}, {"t": "vec3"})["t"]
    x = np.clip(0.5 + 0.5 * offset / (a * 6.36e6 / (6.36e6 + h)), 0.0, 1.0)
    inputs = {"h": h, "mu": np.maximum(horizon + offset, horizon) + 1e-7}
    through = air.ask("t = air_transmittance_to_space(h, mu);", inputs, {"t": "vec3"})["t"]
    right = through * (x * x * (3.0 - 2.0 * x))[:, None]
    # A ten millionth beside the horizon is half a kilometre of the longest path's 1500.
    np.testing.assert_allclose(found, right, rtol=2e-3, atol=1e-7)
    np.testing.assert_array_equal(found[6], 1.0)


def _airs() -> Iterator[tuple[float, float, float, float]]:
    """Radius, thickness, vertical optical depth, asymmetry: the corners of what is allowed."""
    for radius in (1e3, 6.36e6, 7e7):
        for share in (1e-5, 1e-2, 1.0):
            for depth, g in ((1e-6, 0.99), (0.3, -0.99), (50.0, 0.8), (1e3, 0.0)):
                yield radius, share * radius, depth, g


@pytest.mark.parametrize("storage", ["rgba16f", "rgba32f"])
def test_every_number_is_finite(make_air, storage: str) -> None:
    rng = np.random.default_rng(5)
    sizes = PaperSizes((16, 4), (3, 4, 3, 3), (4, 3), 3, storage)
    n = 400
    for radius, thickness, depth, g in _airs():
        k = depth / thickness
        block = replace(
            EARTH,
            radius_m=radius,
            top_radius_m=radius + thickness,
            thickness_m=thickness,
            per_thickness=1.0 / thickness,
            rayleigh_per_m=(k, 0.3 * k, 0.0),
            rayleigh_height_m=0.1 * thickness,
            mie_scattering_per_m=(k, 0.0, k),
            mie_height_m=1e-6 * thickness,
            mie_extinction_per_m=(k, k, k),
            mie_asymmetry=g,
            absorption_per_m=(k, 0.0, k),
            absorber_height_m=0.5 * thickness,
            absorber_slope_per_m=1e3 / thickness,
            ground_albedo=(1.0, 0.0, 0.5),
        )
        air = make_air(block, sizes)
        for name in air.tables.textures:
            values = air.read(name)
            assert np.isfinite(values).all() and (values >= 0.0).all(), (name, block)
        edges = np.array([0.0, thickness, -thickness, 1e9, np.nextafter(np.float32(thickness), np.float32(0.0))])
        h = np.concatenate([edges, thickness * 10.0 ** rng.uniform(-6.0, 4.0, n - len(edges))])
        mu, mu_s, nu = rng.uniform(-1.0, 1.0, (3, n))
        for cosine in (mu, mu_s, nu):
            cosine[rng.integers(0, n, 90)] = rng.choice([-1.0, 0.0, 1.0], 90)
        mu[::3] = np.clip(-np.sqrt(np.maximum(1.0 - (radius / (radius + np.maximum(h[::3], 0.0))) ** 2, 0.0)), -1, 1)
        inputs = {"h": h, "mu": mu, "mu_s": mu_s, "nu": nu, "distance_m": thickness * 10.0 ** rng.uniform(-6.0, 4.0, n)}
        body = f"{SKY} air_segment(h, mu, mu_s, nu, distance_m, along, light); lit = air_sky_irradiance(h, mu_s, mu);"
        body += "sun = air_sun_transmittance(h, mu_s); space = air_transmittance_to_space(h, mu);"
        outputs = {**SKY_OUTPUTS, **dict.fromkeys(("along", "light", "lit", "sun", "space"), "vec3")}
        found = air.ask(body, inputs, outputs)
        for name, values in found.items():
            assert np.isfinite(values).all(), (name, block)
            if name != "light":  # subtracting two look-ups may give less than nothing
                assert (values >= 0.0).all(), (name, block)
        air.tables.release()


def test_where_formulas_would_divide_zero_by_zero(make_air) -> None:
    """The guards give the limit, where a NaN would be swallowed by the next min or clamp on some drivers only."""
    thick = replace(EARTH, rayleigh_per_m=(1.0, 1.0, 1.0))
    air = make_air(thick, PaperSizes((16, 4), (2, 4, 2, 2), (2, 2), 1))
    body = """
    lengths = vec4(
        paper_distance_to_top(top, 0.0), paper_distance_to_top(top, 1.0), paper_distance_to_floor(0.0, 0.0),
        paper_mu_to_top(top, 0.0)
    );
    view = paper_view_coordinates(0.0, -0.5, true, vec2(8.0));
    through = paper_transmittance(1e3, 0.0, 2e5, false) + paper_transmittance(1e3, -0.9, 1e3, true);
    """
    outputs = {"lengths": "vec4", "view": "vec2", "through": "vec3"}
    found = air.ask(body, {"top": 60_000.0}, outputs)
    np.testing.assert_array_equal(found["lengths"][0], [0.0, 0.0, 0.0, 1.0])
    np.testing.assert_allclose(found["view"][0], [3.5 / 8.0, 0.5 / 8.0])  # the row of the shortest rays, the floor
    np.testing.assert_array_equal(found["through"], 0.0)


# -- how they are made ------------------------------------------------------------------------------------------------


def test_steps_bound_the_work_and_say_how_far_they_are(scope: GpuScope, gpu: Gpu) -> None:
    uniforms = scope.uniform_block(AirBlock, AIR_BLOCK, "air_model")
    uniforms.write(EARTH)
    uniforms.bind()
    before = gpu.counts()["test"]
    sizes = PaperSizes((64, 64), (16, 32, 16, 8), (16, 8), 2)
    tables = PaperTables(scope, sizes)
    assert not tables.done and set(tables.textures) == {"transmittance", "scattering", "mie", "irradiance"}
    gpu.work.reset()
    shares = []
    while not tables.done:
        shares.append(tables.step())
        assert gpu.work.dispatches == len(shares)
    assert shares == sorted(shares) and 0.0 < shares[0] < 0.2 and shares[-1] == 1.0 and max(shares[:-1]) < 1.0
    assert len(shares) > 40
    first = {name: texture.read() for name, texture in tables.textures.items()}
    made = gpu.counts()["test"]["texture"] - before.get("texture", 0)
    assert made == 4, "what only the computation needs is freed"
    assert tables.step() == 1.0 and gpu.work.dispatches == len(shares)

    tables.restart()
    assert not tables.done and tables.step() < 0.2
    tables.restart()  # in the middle: from the start again
    while not tables.done:
        tables.step()
    assert {name: texture.read() for name, texture in tables.textures.items()} == first

    # Slices of another size make the same tables.
    coarse = PaperTables(scope, sizes)
    steps = 0
    while not coarse.done:
        assert coarse.step(13_700_000) == coarse.share
        steps += 1
    assert steps < len(shares) / 4
    assert {name: texture.read() for name, texture in coarse.textures.items()} == first
    coarse.release()
    tables.release()
    tables.release()
    assert gpu.counts()["test"] == before


def test_one_program_reads_tables_of_any_size(make_air, gpu: Gpu) -> None:
    """Nothing about sizes is compiled into the functions: a preview gives way to the final tables without a rebuild."""
    coarse = make_air(EARTH, PaperSizes((64, 16), (8, 32, 16, 4), (16, 4), 1))
    fine = make_air(EARTH, PaperSizes((128, 32), (8, 32, 16, 8), (16, 4), 1, "rgba32f", 120.0))
    ray = {"h": np.array([10.0, 5e3]), "mu": 0.5, "mu_s": 0.7, "nu": np.array([0.2, 0.9])}
    found = [air.ask(SKY, ray, SKY_OUTPUTS)["rayleigh"] for air in (coarse, fine)]
    np.testing.assert_allclose(found[0], found[1], rtol=0.05)


@pytest.mark.parametrize(
    ("sizes", "message"),
    [
        ({"scattering": (32, 127, 32, 8)}, "two halves of at least 2, found 127"),
        ({"scattering": (32, 128, 32)}, "scattering is 4 sizes"),
        ({"transmittance": (256, 1)}, "transmittance is 2 sizes of at least 2"),
        ({"orders": 0}, "orders is at least 1, found 0"),
        ({"storage": "rgba8"}, "rgba16f or rgba32f, found 'rgba8'"),
        ({"max_sun_zenith_deg": 80.0}, "90 to 180, found 80.0"),
    ],
)
def test_sizes_that_cannot_be_are_refused(sizes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        PaperSizes(**sizes)
