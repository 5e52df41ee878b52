"""Exposure, tone maps, dither and glare: against float64 twins, and every knob on and off with pixels compared."""

from __future__ import annotations

import numpy as np
import pytest
from picture_harness import SUN, Bench, Scene, look

from planetfall.components import Composite, Exposure
from planetfall.engine.display import light_of_color
from planetfall.engine.srgb import srgb_encode
from planetfall.engine.wavelengths import DISPLAY_NM, GIVEN_NM, SUNLIGHT
from planetfall.systems.composite import TONE_MAPS, CompositeSystem, read_exposure, tone_map
from planetfall.systems.composite.metering import target_ev100, white_luminance
from planetfall.systems.composite.photometry import (
    SATURATION,
    ev100_for_saturation,
    expose,
    luminance,
    luminance_per_radiance,
)
from planetfall.systems.composite.system import adaptation_share
from planetfall.systems.composite.tone_maps import CAMERA_POINTS

SIZE = (64, 36)
WHITE = np.array(SUN) / np.pi
"""Radiance of a white Lambert surface that faces the sun, outside the air."""
HIGH_SUN = (0.5, 0.0, np.sqrt(0.75))


CARRIED = pytest.mark.parametrize("nm", [GIVEN_NM, DISPLAY_NM], ids=["given", "display"])


class Rig:
    """A scene of given radiance through the composite; knobs are the components' fields."""

    def __init__(self, gpu, radiance, size=SIZE, bloom=0.0, format="rgba32f", exports=("composite.ldr",), nm=GIVEN_NM):
        self.exposure, self.composite = Exposure(), Composite(bloom=bloom)
        self.scene = Scene(radiance=radiance, format=format)
        systems = [self.scene, CompositeSystem()]
        settings = {"light.wavelengths": "given" if nm == GIVEN_NM else "display"}
        self.bench = Bench(gpu, systems, [self.exposure, self.composite], size, exports, settings)
        self.size = size

    def __enter__(self):
        return self

    def __exit__(self, *exc):
        self.bench.__exit__(*exc)

    def picture(self, **frame):
        scale = frame.pop("scale", 1.0)
        state = look(size=self.size, hdr_per_radiance=scale, radiance_per_hdr=1 / scale, sun_direction=HIGH_SUN)
        self.bench.render(state, **frame)
        return self.bench.read("composite.ldr")[..., :3]

    @property
    def reading(self):
        return read_exposure(self.bench.plan.resource("composite.exposure"))


def plain(color, size=SIZE):
    return np.broadcast_to(np.asarray(color, float), (size[1], size[0], 3)).copy()


def from_exposed(exposed, ev100=0.0, nm=GIVEN_NM):
    """Radiance that exposes to this at an EV100."""
    return light_of_color(exposed, nm) * SATURATION * 2.0**ev100 / luminance_per_radiance(nm)


def fixed(rig, ev100, tone="linear", dither=False):
    rig.exposure.mode, rig.exposure.ev100 = "fixed", ev100
    rig.composite.tone_map, rig.composite.dither = tone, dither


# -- conventions -----


@CARRIED
def test_photometric_convention(nm):
    sun = np.array(SUNLIGHT[nm])
    assert luminance(sun, nm) == pytest.approx(133.1e3)
    # "sunny 16": white at the edge of saturation
    np.testing.assert_allclose(expose(sun / np.pi, 15.0, nm), 1.077, atol=2e-3)
    assert ev100_for_saturation(SATURATION * 2.0**7) == pytest.approx(7.0)
    np.testing.assert_allclose(srgb_encode([0.0, 1.0, 2.0]), [0.0, 1.0, 1.0], atol=1e-12)
    assert srgb_encode(0.18) == pytest.approx(0.4613, abs=1e-3)


def test_sunlit_white_is_bright_but_not_burnt_and_grey_is_grey():
    for name in TONE_MAPS:
        white = tone_map(name, expose(WHITE * 0.8, 15.0, GIVEN_NM))
        assert np.all(white < 0.97) and np.all(white > 0.65), name
        grey = tone_map(name, expose(WHITE * 0.18, 15.0, GIVEN_NM))
        np.testing.assert_allclose(grey, srgb_encode(0.18 * 1.077), atol=0.025, err_msg=name)


def test_the_camera_has_its_white_where_a_camera_has():
    for exposed, shown in CAMERA_POINTS.items():
        assert tone_map("camera", np.full(3, exposed)) * 255 == pytest.approx(np.full(3, shown), abs=0.5), exposed
    # The roll-off and the shoulder join without a corner: the curve is smooth where it is bent most.
    ramp = tone_map("camera", np.linspace(0.9, 1.4, 2001)[:, None] * np.ones(3))[:, 0]
    assert np.abs(np.diff(ramp, 2)).max() < 1e-4 * np.ptp(ramp)


@pytest.mark.parametrize("color", [(1.0, 0.45, 0.15), (0.25, 0.5, 1.0), (0.4, 1.0, 0.3)])
def test_the_cameras_highlights_keep_their_hue_and_end_in_white(color):
    def hue(shown):
        linear = np.where(shown > 0.04045, ((shown + 0.055) / 1.055) ** 2.4, shown / 12.92)
        chroma = linear - linear.mean(axis=-1, keepdims=True)
        return chroma / np.linalg.norm(chroma, axis=-1, keepdims=True)

    levels = 2.0 ** np.linspace(-8, 6, 60)[:, None]
    shown = tone_map("camera", levels * np.array(color))
    np.testing.assert_allclose(hue(shown), np.broadcast_to(hue(shown[:1]), shown.shape), atol=1e-6)
    assert np.ptp(tone_map("camera", 1e5 * np.array(color))) < 0.01


@pytest.mark.parametrize("name", TONE_MAPS)
def test_tone_maps_keep_grey_rise_and_end_in_white(name):
    brighter = 0.018 if name == "camera" else 0.0  # 122 of 255 and not 117.6
    assert tone_map(name, np.full(3, 0.18)) == pytest.approx(np.full(3, srgb_encode(0.18) + brighter), abs=2e-3)
    ramp = tone_map(name, 2.0 ** np.linspace(-14, 12, 500)[:, None] * np.ones(3))
    assert np.all(np.diff(ramp[:, 0]) >= -1e-3) and ramp[0, 0] < 0.02 and ramp[-1, 0] > 0.99
    assert np.ptp(ramp, axis=1).max() < 3e-3  # grey stays grey
    hot = tone_map(name, np.array([1e6, 1e5, 1e4]))
    assert np.all(np.isfinite(hot)) and np.all((hot >= 0) & (hot <= 1))


def test_unknown_tone_map():
    with pytest.raises(KeyError, match="agx, aces"):
        tone_map("sepia", np.ones(3))


# -- the shader against its twin -----


@CARRIED
@pytest.mark.parametrize("name", TONE_MAPS)
def test_shader_against_twin(gpu, name, nm):
    rng = np.random.default_rng(5)
    exposed = 2.0 ** rng.uniform(-12, 10, (SIZE[1], SIZE[0], 1)) * rng.uniform(0.02, 1, (SIZE[1], SIZE[0], 3))
    radiance = np.maximum(from_exposed(exposed, nm=nm), 0.0)
    with Rig(gpu, radiance, nm=nm) as rig:
        fixed(rig, 0.0, name)
        out = rig.picture() / 255.0
    np.testing.assert_allclose(out, tone_map(name, expose(radiance, 0.0, nm)), atol=0.6 / 255)


def test_neutral_shader_in_float(run_compute):
    rng = np.random.default_rng(6)
    exposed = 2.0 ** rng.uniform(-12, 10, (500, 1)) * rng.uniform(0.02, 1, (500, 3))
    header, index = '#include "common/tonemap.glsl"', TONE_MAPS.index("neutral")
    out = run_compute("y = tone_map(x);", {"x": exposed}, {"y": "vec3"}, header=header, defines={"TONE_MAP": index})
    np.testing.assert_allclose(out["y"], tone_map("neutral", exposed), atol=1e-4)


def test_bad_numbers_do_not_spread(gpu):
    image = plain(from_exposed([0.18] * 3))
    image[0, 0], image[5, 5], image[9, 9] = np.nan, np.inf, -5.0
    with Rig(gpu, image, bloom=0.02) as rig:
        rig.composite.tone_map = "linear"
        rig.exposure.mode, rig.exposure.ev100 = "fixed", 0.0
        out = rig.picture()
        assert out[0, 0].max() <= 3 and out[9, 9].max() <= 3 and np.all(out[5, 5] == 255)  # 3: glare from beside
        assert np.all(np.abs(out[20:, 40:].astype(int) - 118) < 12)
        rig.exposure.mode = "auto"
        assert np.isfinite(rig.picture().mean()) and np.isfinite(rig.reading.ev100)


# -- knobs, one by one -----


def test_fixed_exposure_in_stops(gpu):
    with Rig(gpu, plain(from_exposed([0.2, 0.15, 0.05]))) as rig:
        for ev in (-1.0, 0.0, 1.5):
            fixed(rig, ev)
            expected = srgb_encode(np.array([0.2, 0.15, 0.05]) * 2.0**-ev) * 255
            np.testing.assert_allclose(rig.picture()[3, 3], expected, atol=0.6)
            assert rig.reading.ev100 == ev


def test_radiance_scale_is_taken_off(gpu):
    with Rig(gpu, plain(from_exposed([0.2, 0.15, 0.05]) * 64.0)) as rig:
        fixed(rig, 0.0)
        np.testing.assert_allclose(rig.picture(scale=64.0)[3, 3], srgb_encode([0.2, 0.15, 0.05]) * 255, atol=0.6)
        rig.exposure.mode = "auto"
        scaled = rig.picture(scale=64.0)
    with Rig(gpu, plain(from_exposed([0.2, 0.15, 0.05]))) as rig:
        rig.composite.tone_map, rig.composite.dither = "linear", False
        np.testing.assert_array_equal(scaled, rig.picture())


def test_dither_on_and_off(gpu):
    """A slow ramp: bands without dither; with it the mean follows the ramp, and no pixel moves by more than a step."""
    size = (256, 64)
    ramp = np.linspace(0.010, 0.012, size[0])[None, :, None] * np.ones((size[1], 1, 3))
    with Rig(gpu, from_exposed(ramp), size) as rig:
        fixed(rig, 0.0)
        off = rig.picture().astype(float)
        rig.composite.dither = True
        on = rig.picture().astype(float)
        again = rig.picture().astype(float)
    true = srgb_encode(ramp) * 255
    assert np.array_equal(on, again)  # the same noise in each frame
    assert not np.array_equal(on, off)
    # Half a step, and what a driver's rounding to 8 bits is off: 0.0164 of a step on NVIDIA's, nothing on Mesa's.
    assert np.abs(on - true).max() <= 1.02 and np.abs(off - true).max() <= 0.52
    columns = lambda image: np.abs((image - true).mean(axis=0).reshape(-1, 8, 3).mean(axis=1)).max()  # noqa: E731
    assert columns(on) < 0.2 < columns(off)


def test_dither_noise(run_compute):
    """Triangular, at most half a step, the colours independent, and neighbours rather of opposite sign."""
    y, x = np.mgrid[:128, :128]
    pixels = np.stack([x.ravel(), y.ravel()], axis=1).astype(np.int32)
    out = run_compute("v = dither_noise(p);", {"p": pixels}, {"v": "vec3"}, header='#include "common/dither.glsl"')["v"]
    assert np.abs(out).max() <= 0.5 and abs(out.mean()) < 5e-3
    assert out.std() == pytest.approx(1 / np.sqrt(24), rel=0.02)  # of a triangle of half-width 0.5
    assert abs(np.corrcoef(out.T)[np.triu_indices(3, 1)]).max() < 0.03
    image = out[:, 0].reshape(128, 128)
    for a, b in ((image[:, :-1], image[:, 1:]), (image[:-1], image[1:])):
        assert -0.35 < np.corrcoef(a.ravel(), b.ravel())[0, 1] < -0.15


def test_dither_leaves_exact_values_alone(gpu):
    with Rig(gpu, plain([0.0, 0.0, 0.0])) as rig:
        fixed(rig, 0.0, dither=True)
        assert not rig.picture().any()


def test_tone_map_knob_changes_the_picture(gpu):
    ramp = 2.0 ** np.linspace(-6, 4, SIZE[0])[None, :, None] * np.array([1.0, 0.4, 0.1]) * np.ones((SIZE[1], 1, 3))
    with Rig(gpu, from_exposed(ramp)) as rig:
        fixed(rig, 0.0)
        seen = {}
        for name in TONE_MAPS:
            rig.composite.tone_map = name
            seen[name] = rig.picture()
        assert len({image.tobytes() for image in seen.values()}) == len(TONE_MAPS)


def sun_spot(size=SIZE):
    image = np.zeros((size[1], size[0], 3))
    image[size[1] // 2, size[0] // 2] = from_exposed([4000.0] * 3)
    return image


def test_bloom_on_and_off(gpu):
    with Rig(gpu, sun_spot(), bloom=0.0) as rig:
        fixed(rig, 0.0)
        off = rig.picture()
        assert np.count_nonzero(off.any(axis=2)) == 1
        rig.picture()  # new persistent resources make every pass run once
        assert not {p.name for p in rig.bench.plan.passes if p.ran} & {"composite.glare", "composite.reduce"}
    with Rig(gpu, sun_spot(), bloom=0.02) as rig:
        fixed(rig, 0.0)
        on = rig.picture()
        assert np.count_nonzero(on.any(axis=2)) > 50
        row = on[SIZE[1] // 2, SIZE[0] // 2 :, 0].astype(int)
        assert row[0] == 255 and np.all(np.diff(row) <= 1)  # falls from the middle
        assert np.ptp(np.r_[on[SIZE[1] // 2 - 8, SIZE[0] // 2], on[SIZE[1] // 2 + 8, SIZE[0] // 2]].astype(int)) < 25


def test_bloom_keeps_the_light_of_an_even_picture(gpu):
    with Rig(gpu, plain(from_exposed([0.3, 0.2, 0.1])), bloom=0.05) as rig:
        fixed(rig, 0.0)
        expected = 255 * plain(srgb_encode([0.3, 0.2, 0.1]))
        np.testing.assert_allclose(rig.picture()[10:-10, 10:-10], expected[10:-10, 10:-10], atol=1.1)


# -- automatic exposure -----


FACING = luminance(SUN, GIVEN_NM) / np.pi
"""cd m^-2 of white ground that faces the sun."""


def asked_ev100(image, sun_sine):
    """What the twin says of radiance (h, w, 3)."""
    return target_ev100(luminance(image, GIVEN_NM), white_luminance(SUN, sun_sine, GIVEN_NM), FACING)


def test_the_meter_against_its_twin(gpu):
    """What the shader counts in bins of 0.1 EV is within one of them."""
    rng = np.random.default_rng(3)
    size = (128, 72)
    cases = ((0.5, -3.0, 0.9), (2.0, -4.0, 0.5), (4.0, -6.0, 0.2), (1.0, -1.0, 0.9), (1.0, -16.0, -0.2))
    for spread, middle, sine in cases:
        blocks = 2.0 ** (middle + rng.normal(0, spread, (size[1] // 4, size[0] // 4, 1)))
        image = (WHITE * blocks).repeat(4, axis=0).repeat(4, axis=1)
        sun = (np.sqrt(1 - sine * sine), 0.0, sine)
        with Rig(gpu, image, size) as rig:
            rig.bench.render(look(size=size, sun_direction=sun))
            assert rig.reading.target_ev100 == pytest.approx(asked_ev100(image, sine), abs=0.1), (spread, middle)


def test_highlights_are_white_and_dark_scenes_are_lifted_by_a_stop_at_most(gpu):
    """Clouds in the sun over dark ground: white where little of it is dark, clipped by a stop where most is."""
    size = (128, 72)

    def shown(cloudy, dark):
        image = plain(WHITE * dark, size)
        image[: int(size[1] * cloudy)] = WHITE * 0.55
        with Rig(gpu, image, size) as rig:
            out = rig.picture().astype(float)
        return out[4].mean(), out[-4].mean()

    white, _ = shown(0.4, 0.2)
    assert 232 <= white <= 246  # 242, and a bin
    white, grey = shown(0.3, 0.15)
    assert white > 230 and grey == pytest.approx(122, abs=30)
    white, grey = shown(0.3, 0.03)
    assert white == pytest.approx(255 * tone_map("camera", np.full(3, 1.9))[0], abs=2) and grey < 100


def test_an_even_picture_is_as_bright_as_what_it_shows(gpu):
    """Nothing to compare with but the sun: dark sea is a dark grey, sand a pale one, snow white."""
    shown = []
    for albedo in (0.03, 0.1, 0.3, 0.8):
        with Rig(gpu, plain(WHITE * albedo * HIGH_SUN[2])) as rig:
            shown.append(rig.picture().mean())
            wanted = luminance(WHITE * albedo * HIGH_SUN[2], GIVEN_NM)
            assert rig.reading.metered_cd_m2 == pytest.approx(wanted, rel=0.15)
    assert shown == sorted(shown) and 110 < shown[0] < 145 and 165 < shown[2] < 200 and shown[3] > 212


def test_night_looks_darker_than_day(gpu):
    with Rig(gpu, plain(WHITE * 0.2)) as rig:
        day = rig.picture().mean()
    with Rig(gpu, plain(WHITE * 0.2 / 4e5)) as rig:  # full moon
        night = rig.picture().mean()
        assert rig.reading.ev100 < 1.5
    assert 0.1 * day < night < 0.75 * day


def test_limits_and_compensation(gpu):
    with Rig(gpu, plain(WHITE * 0.2)) as rig:
        middle = rig.picture().mean()
        base = rig.reading.ev100
        rig.exposure.compensation_ev = 1.0
        assert rig.picture().mean() > middle and rig.reading.ev100 == pytest.approx(base - 1.0, abs=1e-4)
        rig.exposure.compensation_ev = 0.0
        rig.exposure.max_ev100 = base - 2.0
        assert rig.picture().mean() > middle and rig.reading.ev100 == pytest.approx(base - 2.0, abs=1e-4)
        rig.exposure.max_ev100 = 20.0
        rig.exposure.min_ev100 = base + 2.0
        assert rig.picture().mean() < middle and rig.reading.ev100 == pytest.approx(base + 2.0, abs=1e-4)


def test_black_opens_to_the_lowest_ev(gpu):
    with Rig(gpu, plain([0.0] * 3)) as rig:
        assert not rig.picture().any()
        assert rig.reading.ev100 == rig.exposure.min_ev100


@pytest.mark.parametrize("share", [0.7, 0.1, 0.01])
def test_a_bright_body_in_black_space_is_exposed_for_itself(gpu, share):
    size = (160, 90)
    image = np.zeros((size[1], size[0], 3))
    y, x = np.mgrid[: size[1], : size[0]]
    body = np.hypot(x - 90, y - 40) < np.sqrt(share * x.size / np.pi)
    image[body] = WHITE * 0.3
    with Rig(gpu, image, size) as rig:
        out = rig.picture()
    assert 80 < np.median(out[body]) < 230


def test_the_suns_disc_does_not_black_out_a_landscape_but_rules_alone(gpu):
    size = (160, 90)
    ground = plain(WHITE * 0.25, size)
    with Rig(gpu, ground, size) as rig:
        rig.picture()
        without = rig.reading.ev100
    ground[20:22, 30:32] = np.array(SUN) / 6.87e-5
    with Rig(gpu, ground, size) as rig:
        rig.picture()
        assert 0 <= rig.reading.ev100 - without < 1.5
    alone = np.zeros_like(ground)
    alone[20:22, 30:32] = np.array(SUN) / 6.87e-5
    alone[50, 50] = 1e-6  # and a star
    with Rig(gpu, alone, size) as rig:
        rig.picture()
        assert rig.reading.ev100 > 12.0


def test_glints_do_not_darken_the_sea(gpu):
    """What is brighter than white that faces the sun counts for nothing, though it is a fiftieth of the picture."""
    size = (160, 90)
    sea = plain(WHITE * 0.05, size)
    with Rig(gpu, sea, size) as rig:
        rig.picture()
        without = rig.reading.ev100
    sea[38:46, 40:80] = WHITE * 1.5
    with Rig(gpu, sea, size) as rig:
        rig.picture()
        assert rig.reading.ev100 == pytest.approx(without, abs=0.1)


def test_adaptation(gpu):
    """At once after a cut; slowly otherwise, faster towards darker pictures; time steps don't change where it goes."""
    assert adaptation_share(1.0, 1.0) == pytest.approx(0.95, abs=1e-3)
    assert adaptation_share(0.1, 0.0) == 1.0 and adaptation_share(0.0, 1.0) == 0.0
    with Rig(gpu, plain(WHITE * 0.2)) as rig:
        rig.exposure.brighter_s, rig.exposure.darker_s = 1.0, 0.5
        rig.picture(cut=True)
        start = rig.reading.ev100
        rig.scene.radiance = plain(WHITE * 0.2 / 64)
        rig.picture(cut=False, dt_s=0.1)
        goal = rig.reading.target_ev100
        once = rig.reading.ev100
        assert once == pytest.approx(start + (goal - start) * adaptation_share(0.1, 1.0), abs=1e-3)
        rig.picture(cut=False, dt_s=0.0)
        assert rig.reading.ev100 == pytest.approx(once, abs=1e-4)
        for _ in range(100):
            rig.picture(cut=False, dt_s=0.1)
        assert rig.reading.ev100 == pytest.approx(goal, abs=1e-3)
        slow = rig.picture(cut=False, dt_s=0.1)
        np.testing.assert_array_equal(slow, rig.picture(cut=True))  # settled is the same either way
        rig.scene.radiance = plain(WHITE * 0.2)
        rig.picture(cut=False, dt_s=0.1)
        back = rig.reading.ev100
        assert back == pytest.approx(goal + (start - goal) * adaptation_share(0.1, 0.5), abs=1e-2)
        rig.exposure.brighter_s = rig.exposure.darker_s = 0.0
        rig.picture(cut=False, dt_s=0.01)
        assert rig.reading.ev100 == rig.reading.target_ev100


def test_pictures_repeat_exactly(gpu):
    rng = np.random.default_rng(8)
    image = WHITE * 2.0 ** rng.uniform(-8, 2, (90, 160, 1))
    pictures = []
    for _ in range(2):
        with Rig(gpu, image, (160, 90), bloom=0.01) as rig:
            pictures += [rig.picture(), rig.picture()]
    assert all(np.array_equal(pictures[0], p) for p in pictures[1:])


def test_resize_keeps_the_exposure(gpu):
    with Rig(gpu, plain(WHITE * 0.2)) as rig:
        rig.picture()
        before = rig.reading.ev100
        rig.scene.radiance = plain(WHITE * 0.2, (48, 27))
        rig.bench.plan.resize((48, 27))
        rig.bench.render(look(size=(48, 27)), cut=False, dt_s=1e-3)
        assert rig.reading.ev100 == pytest.approx(before, abs=0.2)


def test_without_components_the_defaults_hold(gpu):
    before = gpu.counts()
    systems = [Scene(radiance=plain(WHITE * 0.2)), CompositeSystem()]
    with Bench(gpu, systems, [], SIZE, ("composite.ldr",)) as bench:
        state = look(size=SIZE, sun_direction=HIGH_SUN)
        assert 80 < bench.render(state).read("composite.ldr")[..., :3].mean() < 170
    assert gpu.counts() == before


def test_luminance_weights_in_the_shader(run_compute):
    rng = np.random.default_rng(9)
    radiance = rng.uniform(0, 1, (100, 3))
    out = run_compute(
        "y = luminance_of_radiance(x); z = srgb_encode(x);",
        {"x": radiance},
        {"y": "float", "z": "vec3"},
        header='#include "common/color.glsl"',
    )
    np.testing.assert_allclose(out["y"], luminance(radiance, GIVEN_NM), rtol=1e-5)
    np.testing.assert_allclose(out["z"], srgb_encode(radiance), atol=2e-5)


def test_a_views_own_exposure_goes_first_and_settled_is_told(gpu):
    with Rig(gpu, plain(WHITE * 0.2)) as rig:
        system, view = rig.bench.systems[1], rig.bench.frame.view
        assert system.settled(view)
        rig.picture()
        assert system.settled(view) and system.reading(view) == rig.reading
        rig.scene.radiance = plain(WHITE * 0.002)
        rig.picture(cut=False, dt_s=0.01)
        assert not system.settled(view)
        rig.bench.frame.ev100 = 9.5
        rig.picture(cut=False, dt_s=0.01)
        assert rig.reading.ev100 == 9.5 and system.settled(view)
