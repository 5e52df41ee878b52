"""Debug views: what each shows, that they cost nothing when off, and errors that name what there is."""

from __future__ import annotations

import numpy as np
import pytest
from picture_harness import Bench, Scene, look

from planetfall.components import Composite, Exposure
from planetfall.components.debug_view import DebugView
from planetfall.engine.graph import GraphError, TextureSpec
from planetfall.engine.system import System
from planetfall.systems.composite import CompositeSystem
from planetfall.systems.debug import NAMED_VIEWS, DebugSystem, show_debug_view
from planetfall.systems.debug.views import MODES, mode_for_format

SIZE = (64, 36)
DEPTH = np.zeros(SIZE[::-1])
DEPTH[:, 32:] = np.array(0.1) / 100.0  # 100 m away on the right, nothing on the left
RADIANCE = np.linspace(0.1, 0.5, SIZE[0])[None, :, None] * np.ones((SIZE[1], 1, 3))


class Stack(System):
    """A 3D texture with the slice number in red, and a storage buffer's worth of nothing."""

    name = "test.stack"

    def setup(self, setup):
        self._data = np.zeros((4, 8, 8, 4), np.float32)
        self._data[..., 0] = np.arange(4)[:, None, None]

    def declare(self, builder, view):
        def bind(io):
            texture = io.texture("test.volume")
            return lambda: texture.write(self._data.tobytes())

        builder.add_pass("make.volume", bind=bind, creates=(TextureSpec("test.volume", "rgba32f", (8, 8, 4)),))


@pytest.fixture
def bench(gpu):
    noise = np.random.default_rng(3).uniform(-1, 1, (36, 64)).astype(np.float32)
    noise[4, 4] = np.nan
    normals = np.zeros((36, 64, 2), np.int16)  # +z
    lod = np.zeros((36, 64, 4), np.uint8)
    lod[:, 48:, 3] = round(3 / 32 * 255)
    extra = {
        "test.heat": ("r32f", noise),
        "gbuffer.normal": ("rg16_snorm", normals),
        "gbuffer.attributes": ("rgba8", lod),
    }
    systems = [Scene(DEPTH, RADIANCE, extra=extra), Stack(), CompositeSystem(), DebugSystem()]
    components = [DebugView(), Exposure(mode="fixed", ev100=14.0), Composite(dither=False, bloom=0.0)]
    with Bench(gpu, systems, components, SIZE, ("composite.ldr",)) as made:
        made.block = look(size=SIZE)
        yield made


def picture(bench, name):
    show_debug_view(bench.world, name)
    bench.compile()
    return bench.render(bench.block).read("composite.ldr")[..., :3].astype(int)


def test_off_costs_nothing(bench, gpu):
    bench.render(bench.block)
    plain = bench.read("composite.ldr")
    assert not [p.name for p in bench.plan.passes if p.system == "debug"] and "debug" not in gpu.counts()
    assert not np.array_equal(picture(bench, "distance"), plain[..., :3])
    assert gpu.counts()["debug"]
    np.testing.assert_array_equal(picture(bench, "off"), plain[..., :3])
    assert not [p.name for p in bench.plan.passes if p.system == "debug"] and "debug" not in gpu.counts()


def test_depth_and_distance(bench):
    for name in ("depth", "distance"):
        image = picture(bench, name)
        assert not image[:, :30].any() and image[:, 34:].sum(axis=2).min() > 60
    bench.systems[0].depth = np.where(np.arange(SIZE[0]) > 48, DEPTH / 1e5, DEPTH)
    bench.plan.resize(SIZE)
    image = picture(bench, "distance")
    assert image[18, 60].sum() > image[18, 40].sum() + 100  # farther is hotter


def test_normals_surface_and_lod(bench):
    normals = picture(bench, "normals")
    assert not normals[:, :30].any()
    np.testing.assert_allclose(normals[10, 50], (128, 128, 255), atol=1)
    surface = picture(bench, "surface")
    assert np.ptp(surface[:, :30]) == 0 and np.abs(surface[5, 10] - surface[5, 50]).max() > 100
    lod = picture(bench, "lod")
    assert not lod[:, :30].any() and np.abs(lod[5, 40] - lod[5, 60]).max() > 60


def test_any_resource_by_name(bench):
    heat = picture(bench, "test.heat")
    assert np.all(heat[4, 4] == (255, 0, 255))  # not a number
    others = np.delete(heat.reshape(-1, 3), 4 * 64 + 4, axis=0)
    assert others.max() > 240 and others.min() == 0 and not np.any(np.all(others == (255, 0, 255), axis=1))
    assert np.array_equal(picture(bench, "gbuffer.surface"), picture(bench, "surface"))
    assert np.array_equal(picture(bench, "gbuffer.depth"), picture(bench, "depth"))


def test_hdr_as_heat(bench):
    image = picture(bench, "hdr")
    assert not image[:, 0].any() and np.all(image[:, -1] > 250)  # the range is that of the picture
    assert np.array_equal(image, picture(bench, "scene.radiance"))
    bench.block = look(size=SIZE, hdr_per_radiance=8.0, radiance_per_hdr=0.125)
    assert np.array_equal(image, picture(bench, "hdr"))


def test_volumes_are_shown_slice_by_slice(bench):
    image = picture(bench, "test.volume")
    levels = [image[y, x, 0] for y in (9, 27) for x in (16, 48)]
    np.testing.assert_allclose(levels, [0, 85, 170, 255], atol=1)


def test_showing_the_picture_itself_is_off(bench):
    assert np.array_equal(picture(bench, "composite.ldr"), picture(bench, "off"))


def test_a_changed_field_is_noticed(bench):
    bench.render(bench.block)
    view = bench.world.query(DebugView)[0][1][0]
    view.view = "depth"
    system = bench.systems[-1]
    before = system.structure
    bench.render(bench.block)
    assert system.structure == before + 1  # so that the renderer compiles again
    bench.compile()
    bench.render(bench.block)
    assert system.structure == before + 1


def test_unknown_resource_and_buffers(bench):
    show_debug_view(bench.world, "gbuffer.norml")
    with pytest.raises(GraphError, match=r"gbuffer\.norml.*gbuffer\.normal"):
        bench.compile()
    show_debug_view(bench.world, "composite.exposure")
    with pytest.raises(GraphError, match=r"composite\.exposure.*buffer"):
        bench.compile()
    show_debug_view(bench.world, "off")
    bench.compile()
    bench.render(bench.block)


def test_show_needs_somewhere_to_put_the_component(gpu):
    from planetfall.engine.world import World

    world = World("empty")
    with pytest.raises(LookupError, match="DebugView"):
        show_debug_view(world, "depth")
    entity = world.create(Exposure())
    show_debug_view(world, "depth", entity)
    assert world.get(entity, DebugView).view == "depth"
    world.close()


def test_names_and_modes():
    assert {v.mode for v in NAMED_VIEWS.values()} <= set(MODES)
    assert mode_for_format("x", "r16f", 1) == "heat" and mode_for_format("x", "rgba16f", 4) == "range"
    assert mode_for_format("x", "rgba8", 4) == "color" and mode_for_format("x", "r32ui", 1) == "ids"
