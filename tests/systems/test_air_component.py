"""The air as data: the component, what it refuses and how it says so, the checked model, the uniform block, presets."""

import math

import numpy as np
import pytest

import planetfall as pf
from planetfall.components import knobs
from planetfall.engine.blocks.bindings import AIR_BLOCK
from planetfall.engine.blocks.layout import StructLayout
from planetfall.engine.settings import plain_table
from planetfall.systems.atmosphere import AirBlock, AirModel, air_block

SUN = 0.00935 / 2
SPHERE = pf.Planet(radius_m=6.36e6)
WITH_AIR, WITHOUT_AIR = ("earth", "hazy", "mars", "small"), ("asteroid", "moon")


def model(planet=SPHERE, sun=SUN, **fields):
    return AirModel.from_components(planet, pf.Atmosphere(**fields), sun)


def preset(name):
    with pf.load_scene(name) as scene:
        return AirModel.from_components(
            scene.planet.planet, scene.planet[pf.Atmosphere], scene.sun.angular_radius_rad
        ), scene.planet[pf.Atmosphere]


# -- what one field refuses -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("thickness_m", 0.0, r"^Atmosphere\.thickness_m: expected a number from 0\.01 to .* m, found 0\.0\. The"),
        ("thickness_m", -5e4, r"found -50000\.0\. The nearest allowed value is 0\.01$"),
        ("thickness_m", math.nan, r"found nan\. Give a finite number$"),
        ("mie_asymmetry", 1.0, r"^Atmosphere\.mie_asymmetry: expected a number from -0\.99 to 0\.99, found 1\.0"),
        ("mie_asymmetry", -1.0, r"The nearest allowed value is -0\.99$"),
        ("rayleigh_scale_height_m", 0.0, r"rayleigh_scale_height_m: expected a number from 0\.001 to .* m, found 0\.0"),
        ("mie_scale_height_m", -1.0, r"mie_scale_height_m: .*found -1\.0"),
        ("absorption_half_width_m", 0.0, r"absorption_half_width_m: .*found 0\.0"),
        ("absorption_center_m", math.inf, r"absorption_center_m: .*found inf\. Give a finite number"),
        ("rayleigh_scattering_per_m", (1e-6, -1e-6, 1e-6), r"expected 3 numbers from 0 to 10000 1/m, found \(1e-06, -"),
        ("mie_scattering_per_m", (1e-6, math.nan, 1e-6), r"mie_scattering_per_m: .*Give finite numbers$"),
        ("mie_extinction_per_m", (math.inf, 0.0, 0.0), r"mie_extinction_per_m: .*found \(inf, 0\.0, 0\.0\)"),
        ("absorption_per_m", (1e9, 0.0, 0.0), r"absorption_per_m: .*found \(1000000000\.0, 0\.0, 0\.0\)"),
        ("absorption_per_m", 1e-6, r"absorption_per_m: .*found 1e-06\. Give 3 numbers, such as"),
        ("ground_albedo", (0.1, 1.1, 0.1), r"albedo: expected 3 numbers from 0 to 1, found \(0\.1, 1\.1, 0\.1\)"),
        ("night_light", -1.0, r"night_light: .*found -1\.0\. The nearest allowed value is 0$"),
        ("method", "papper", r"method: expected one of 'ours', 'paper', found 'papper'; did you mean 'paper'"),
    ],
)  # fmt: skip
def test_bad_values_are_refused_where_they_are_assigned(field, value, message):
    air = pf.Atmosphere()
    before = plain_table(air)
    with pytest.raises(pf.SettingError, match=message):
        setattr(air, field, value)
    assert plain_table(air) == before


def test_a_mistyped_name_is_told():
    with pytest.raises(pf.UnknownSettingError, match=r"has no setting 'mie_assymetry'; did you mean 'mie_asymmetry'"):
        pf.Atmosphere().mie_assymetry = 0.5


def test_defaults_are_the_demo_of_2017():
    """Rayleigh's law with 1.24062e-6 / lambda^4 (um), haze of 5.328e-3 with albedo 0.9 over 1200 m, as published."""
    air = pf.Atmosphere()
    assert air.rayleigh_scattering_per_m == pytest.approx([1.24062e-6 / x**4 for x in (0.68, 0.55, 0.44)])
    assert air.mie_extinction_per_m == pytest.approx([5.328e-3 / 1200.0] * 3)
    assert air.mie_scattering_per_m == pytest.approx([0.9 * 5.328e-3 / 1200.0] * 3)
    assert air.wavelengths_nm == (680.0, 550.0, 440.0) and air.method == "ours"


def test_every_knob_says_what_it_is():
    assert all(described.help for described in knobs(pf.Atmosphere).values())
    for name, described in knobs(pf.Atmosphere).items():
        for suffix, unit in (("_per_m", "1/m"), ("_m", "m"), ("_nm", "nm")):
            if name.endswith(suffix):
                assert described.unit == unit
                break


# -- what only values together show -----------------------------------------------------------------------------------


def test_extinction_below_scattering():
    with pytest.raises(pf.SettingError) as info:
        model(mie_extinction_per_m=(4.44e-6, 3e-6, 4.44e-6))
    assert str(info.value) == (
        "Atmosphere.mie_extinction_per_m[1]: expected at least mie_scattering_per_m[1] (3.996e-06 1/m), found 3e-06 "
        "1/m. Extinction is scattering plus absorption: raise it, or lower the scattering"
    )


def test_extinction_from_float32_may_be_a_rounding_low():
    scattering = (3.1e-6, 3.2e-6, 3.3e-6)
    rounded = tuple(float(np.float32(s)) * (1.0 - 2e-7) for s in scattering)
    made = model(mie_scattering_per_m=scattering, mie_extinction_per_m=rounded)
    assert (made.mie_extinction >= made.mie_scattering).all()  # else haze would shine


def test_more_air_than_planet_and_too_thin_a_film():
    with pytest.raises(pf.SettingError, match=r"thickness_m: expected 1e-05 to 1 of Planet\.radius_m \(1000 m\), found "
                       r"2000 m; use at most 1000 m"):  # fmt: skip
        model(pf.Planet(radius_m=1000.0), thickness_m=2000.0)
    with pytest.raises(pf.SettingError, match=r"found 1 m; use at least 63\.6 m"):
        model(thickness_m=1.0)
    for radius in (1e3, 6.36e6, 7e7):  # what the air is stable for, ends included
        for share in (1e-4, 1.0):
            thickness = radius * share
            air = model(
                pf.Planet(radius_m=radius), thickness_m=thickness, rayleigh_scale_height_m=thickness / 8,
                mie_scale_height_m=thickness / 8, absorption_per_m=(0, 0, 0),
                rayleigh_scattering_per_m=(0, 0, 0), mie_scattering_per_m=(50 * 8 / thickness,) * 3,
                mie_extinction_per_m=(50 * 8 / thickness,) * 3,
            )  # fmt: skip
            assert air.vertical_optical_depth() == pytest.approx([50 * (1 - math.exp(-8))] * 3)


def test_absurd_optical_depth_names_the_part():
    with pytest.raises(pf.SettingError, match=r"Atmosphere\.rayleigh_scattering_per_m: expected a vertical "
                       r"optical depth of at most 1000 .*, found 7996 .*the unit is 1/m, not 1/km"):  # fmt: skip
        model(rayleigh_scattering_per_m=(1.0, 0.1, 0.1))
    with pytest.raises(pf.SettingError, match=r"Atmosphere\.mie_extinction_per_m: expected a vertical"):
        model(mie_extinction_per_m=(1.0, 1.0, 1.0))


def test_all_problems_at_once_and_with_the_scene(tmp_path):
    path = tmp_path / "odd.toml"
    path.write_text(
        "[planet]\nradius_m = 1000\n[atmosphere]\nthickness_m = 4000\nmie_scattering_per_m = [1, 1, 1]\n"
        "mie_extinction_per_m = [0, 1, 1]\n"
    )
    with pytest.raises(pf.SceneError) as info:
        pf.load_scene(path)
    text = str(info.value)
    assert text.startswith(f"{path}: scene 'odd': planet 'odd': Atmosphere.thickness_m: expected")
    assert "use at most 1000 m" in text and "mie_extinction_per_m[0]: expected at least" in text
    assert "mie_extinction_per_m: expected a vertical optical depth" in text
    with pf.load_scene("earth") as scene:
        scene.planet[pf.Atmosphere].mie_extinction_per_m = (0.0, 0.0, 0.0)
        with pytest.raises(pf.SceneError, match=r"planet 'earth': Atmosphere\.mie_extinction_per_m\[0\]"):
            scene.validate()


def test_a_model_made_by_hand_is_checked_too():
    good = {name: getattr(model(), name) for name in AirModel.__dataclass_fields__}
    for name, value, message in [
        ("asymmetry", 1.0, r"Atmosphere\.mie_asymmetry: expected a number from -0\.99 to 0\.99, found 1\. "),
        ("asymmetry", math.nan, r"mie_asymmetry: expected finite"),
        ("thickness_m", -1.0, r"Atmosphere\.thickness_m: expected more than 0, found -1\. Give a positive"),
        ("radius_m", 0.0, r"Planet\.radius_m: expected more than 0"),
        ("ground_albedo", (0.0, 2.0, 0.0), r"_albedo: expected 3 numbers from 0 to 1, found \(0\.0, 2\.0, 0\.0\)"),
        ("absorption", (0.0, -1.0, 0.0), r"absorption_per_m: expected 3 numbers, at least 0"),
        ("mie_scattering", (1.0, 2.0), r"mie_scattering_per_m: expected 3 numbers, found \(1\.0, 2\.0\)"),
        ("sun_angular_radius_rad", math.inf, r"Sun\.angular_radius_rad: expected finite"),
    ]:  # fmt: skip
        with pytest.raises(pf.SettingError, match=message):
            AirModel(**(good | {name: value}))


# -- the model --------------------------------------------------------------------------------------------------------


def test_density_gives_transmittances_from_independent_tables():
    """Straight up from 10 m, 50 km and 59.9 km, computed elsewhere with 25 digits for this very air."""
    air = model()
    for low, expected in [
        (10.0, (0.9404802895, 0.8678261239, 0.7627066182)),
        (50000.0, (0.9999360663, 0.9998506187, 0.9996353389)),
        (59900.0, (0.9999996771, 0.9999992454, 0.9999981578)),
    ]:
        h = np.linspace(low, air.thickness_m, 200001)
        column = np.trapezoid(air.density(h), h, axis=0)
        depth = np.array([air.rayleigh_scattering, air.mie_extinction, air.absorption]).T @ column
        assert np.exp(-depth) == pytest.approx(expected, rel=1e-8)


def test_density_is_held_below_the_floor_and_none_above_the_top():
    air = model()
    assert (air.density([-5000.0, -1.0]) == air.density([0.0, 0.0])).all()
    assert air.density(0.0).tolist() == [1.0, 1.0, 0.0]
    assert (air.density([60000.1, 1e9]) == 0.0).all() and (air.density(60000.0)[:2] > 0.0).all()
    assert air.density(17500.0)[2] == pytest.approx(0.5) and air.density(np.zeros((2, 5))).shape == (2, 5, 3)


@pytest.mark.parametrize("center", [-4000.0, 0.0, 9000.0, 25000.0, 55000.0, 61000.0, 90000.0])
def test_vertical_optical_depth_is_the_integral_of_density(center):
    air = model(absorption_center_m=center, absorption_half_width_m=12000.0)
    h = np.linspace(0.0, air.thickness_m, 400001)
    column = np.trapezoid(air.density(h), h, axis=0)
    parts = np.array([air.rayleigh_scattering, air.mie_extinction, air.absorption])
    assert air.vertical_optical_depth() == pytest.approx(column @ parts, rel=1e-8)


def test_key_tells_equal_from_different():
    key = model().key()
    assert len(key) == 64 and int(key, 16) and key == model(night_light=0.0, method="paper").key()
    changes = {
        "thickness_m": 59e3, "rayleigh_scattering_per_m": (5.8e-6, 1.3e-5, 3.3e-5), "rayleigh_scale_height_m": 8001.0,
        "mie_scattering_per_m": (3.9e-6,) * 3, "mie_extinction_per_m": (4.5e-6,) * 3, "mie_scale_height_m": 1201.0,
        "mie_asymmetry": 0.81, "absorption_per_m": (0, 0, 0), "absorption_center_m": 26e3,
        "absorption_half_width_m": 14e3, "ground_albedo": (0.1, 0.1, 0.2),
    }  # fmt: skip
    keys = {model(**{name: value}).key() for name, value in changes.items()}
    keys |= {model(pf.Planet(radius_m=6.361e6)).key(), model(sun=0.005).key(), key}
    assert len(keys) == len(changes) + 3
    assert model(absorption_center_m=-0.0).key() == model(absorption_center_m=0.0).key()


def test_a_model_cannot_be_changed():
    air = model()
    with pytest.raises(AttributeError):
        air.thickness_m = 1.0
    with pytest.raises(ValueError, match="read-only"):
        air.mie_extinction[0] = 0.0


# -- the block --------------------------------------------------------------------------------------------------------


def test_block_holds_the_model():
    air = model()
    packed = StructLayout(AirBlock)
    block = air_block(air, pf.Atmosphere(night_light=2.0), sun_irradiance=(1.0, 2.0, 3.0))
    assert AIR_BLOCK == 5 and packed.size == 9 * 16
    assert (block.radius_m, block.top_radius_m, block.thickness_m, block.per_thickness) == (
        6.36e6,
        6.42e6,
        6e4,
        1 / 6e4,
    )
    assert block.rayleigh_per_m == tuple(air.rayleigh_scattering) and block.rayleigh_height_m == 8000.0
    assert block.mie_scattering_per_m == tuple(air.mie_scattering) and block.mie_height_m == 1200.0
    assert block.mie_extinction_per_m == tuple(air.mie_extinction) and block.mie_asymmetry == 0.8
    assert block.absorption_per_m == tuple(air.absorption)
    assert (block.absorber_height_m, block.absorber_slope_per_m) == (25e3, 1 / 15e3)
    assert block.ground_albedo == (0.1, 0.1, 0.1) and block.sun_radius_rad == SUN
    assert block.longest_path_m == pytest.approx(math.sqrt(6.42e6**2 - 6.36e6**2))
    nu, weights = np.polynomial.legendre.leggauss(200)
    phase = 3 / (8 * np.pi) * (1 - 0.64) / (2 + 0.64) * (1 + nu**2) / (1 + 0.64 - 1.6 * nu) ** 1.5
    moments = [2 * np.pi * np.sum(weights * phase * np.polynomial.legendre.Legendre.basis(n)(nu)) for n in range(1, 5)]
    assert block.mie_moments == pytest.approx(moments, rel=1e-9)
    assert block.night_radiance == pytest.approx((2e-9, 4e-9, 6e-9))
    assert air_block(air, pf.Atmosphere(night_light=0.0)).night_radiance == (0.0, 0.0, 0.0)


# -- presets ----------------------------------------------------------------------------------------------------------


def test_which_presets_have_air(tmp_path):
    for name in pf.planets():
        with pf.load_scene(name) as scene:
            assert scene.planet.has(pf.Atmosphere) == (name in WITH_AIR) == (name not in WITHOUT_AIR)
    with pf.load_scene("mars") as scene:
        scene.planet[pf.Atmosphere].night_light = 0.25
        scene.save(tmp_path / "mine.toml")
        with pf.load_scene(tmp_path / "mine.toml") as again:
            assert again.planet[pf.Atmosphere] == scene.planet[pf.Atmosphere]


def test_earth_is_the_default_but_for_its_haze_and_the_small_world_looks_up_through_as_much_air():
    _, component = preset("earth")
    small, _ = preset("small")
    default = pf.Atmosphere()
    for name in ("mie_scattering_per_m", "mie_extinction_per_m"):
        np.testing.assert_allclose(getattr(component, name), np.multiply(5.0, getattr(default, name)), rtol=2e-3)
        setattr(component, name, getattr(default, name))
    assert component == default
    assert small.radius_m == 6e4 and small.thickness_m == 2e3
    clear = AirModel.from_components(pf.Planet(), default, 0.00465)
    assert small.vertical_optical_depth() == pytest.approx(clear.vertical_optical_depth(), rel=1e-9)


def test_ground_of_the_hazy_world_can_be_seen_nearby_but_not_from_space():
    hazy, _ = preset("hazy")
    at_the_ground = np.exp(-1e3 * (hazy.rayleigh_scattering + hazy.mie_extinction))
    assert (at_the_ground > 0.75).all()
    assert (np.exp(-hazy.vertical_optical_depth()) < 0.05).all()


def sky_once(air, elevation_deg, azimuth_deg, sun_elevation_deg, height_m=2.0, steps=400):
    """(3,): light scattered once, per unit of the sun's; a midpoint sum with steps that grow along the ray."""
    toward = lambda e, a: np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])  # noqa: E731
    view = toward(np.radians(elevation_deg), np.radians(azimuth_deg))
    sun = toward(np.radians(sun_elevation_deg), 0.0)
    coefficients = np.array([air.rayleigh_scattering, air.mie_extinction, air.absorption])

    def sections(start, direction, n):
        """Middles (..., n, 3) and lengths (..., n) of the ray's sections up to the top."""
        b, c = start @ direction, np.sum(start**2, axis=-1)
        length = -b + np.sqrt(b**2 - c + air.top_radius_m**2)
        ends = (np.arange(n + 1) / n) ** 2
        middle = length[..., None] * (ends[1:] + ends[:-1]) / 2
        return start[..., None, :] + middle[..., None] * direction, length[..., None] * np.diff(ends)

    def density(points):
        return air.density(np.linalg.norm(points, axis=-1) - air.radius_m)

    points, lengths = sections(np.array([0.0, 0.0, air.radius_m + height_m]), view, steps)
    there = density(points)
    seen = (there @ coefficients) * lengths[:, None]
    before = np.cumsum(seen, axis=0) - seen / 2
    to_sun, pieces = sections(points, sun, steps)
    sunward = np.einsum("ijk,ij->ik", density(to_sun), pieces) @ coefficients
    nu, g = view @ sun, air.asymmetry
    gas = 3 / (16 * np.pi) * (1 + nu**2)
    haze = 3 / (8 * np.pi) * (1 - g**2) * (1 + nu**2) / ((2 + g**2) * (1 + g**2 - 2 * g * nu) ** 1.5)
    scattered = there[:, :1] * air.rayleigh_scattering * gas + there[:, 1:2] * air.mie_scattering * haze
    return np.sum(scattered * np.exp(-before - sunward) * lengths[:, None], axis=0)


def blue_over_red(air, *where):
    radiance = sky_once(air, *where)
    return radiance[2] / radiance[0]


def test_mars_has_a_red_day_and_a_blue_sunset():
    """Seen from where the sun is high: red sky. Low sun: blue around it, red on the other side of the sky."""
    mars, _ = preset("mars")
    assert blue_over_red(mars, 30, 120, 55) < 0.6
    assert blue_over_red(mars, 4, 3, 2) > 1.5
    assert blue_over_red(mars, 20, 180, 2) < 0.6
    earth, _ = preset("earth")  # the other way round
    assert blue_over_red(earth, 60, 120, 55) > 2.5
    assert blue_over_red(earth, 4, 3, 2) < 0.7
