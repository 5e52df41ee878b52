"""The budget for GPU memory: estimates that hold, knobs that give way in order, errors below the minimum."""

from __future__ import annotations

import pytest

import planetfall as pf
from planetfall.quality import QUALITY, resolve_quality
from planetfall.render.memory_budget import MIB, TRADES, estimate_bytes, plan_memory

SIZE = (160, 90)


@pytest.fixture
def scene():
    with pf.load_scene("earth") as made:
        made.planet.add(pf.Clouds())
        yield made


def used(renderer: pf.Renderer) -> float:
    return sum(renderer.memory_bytes.values()) / MIB


def test_without_a_budget_nothing_gives_way(scene: pf.Scene) -> None:
    settings = resolve_quality("high")
    before = dict(settings)
    plan = plan_memory(settings, scene, (1920, 1080))
    assert settings == before and plan.budget_mib == 0 and plan.lowered == {} and plan.scale((9999, 9999)) == 1.0


def test_knobs_give_way_one_after_another_until_it_fits(scene: pf.Scene) -> None:
    whole = estimate_bytes(resolve_quality("high"), scene, (1280, 720)) / MIB
    lowered = []
    for share in (0.9, 0.75, 0.6):
        settings = resolve_quality("high", {"memory.budget_mib": round(share * whole)})
        plan = plan_memory(settings, scene, (1280, 720))
        assert plan.expected_bytes <= plan.budget_mib * MIB
        assert plan.expected_bytes == estimate_bytes(settings, scene, (1280, 720))
        assert set(plan.lowered) <= {trade.key for trade in TRADES}
        for key, (chosen, taken) in plan.lowered.items():
            assert settings[key] == taken != chosen == resolve_quality("high")[key]
        lowered.append(plan.lowered)
    assert list(lowered[0]) == ["clouds.map_texels"], "the largest that is seen least"
    assert len(lowered[0]) <= len(lowered[1]) <= len(lowered[2])


def test_every_lower_value_is_one_that_the_knob_can_have() -> None:
    for name in ("low", "medium", "high", "ultra", "reference"):
        settings = resolve_quality(name)
        for trade in TRADES:
            value = settings[trade.key]
            for _ in range(20):
                value = trade.next(value)
                if value is None:
                    break
                QUALITY.resolve(name, {trade.key: value})  # raises where it can't
            else:
                raise AssertionError(f"{trade.key} has no end")


def test_below_the_minimum_the_error_says_what_would_do(scene: pf.Scene) -> None:
    with pytest.raises(pf.SettingError, match=r"memory\.budget_mib: expected at least (\d+) MiB.*found 20") as caught:
        pf.Renderer(scene, (1920, 1080), "high", {"memory.budget_mib": 20})
    least = int(str(caught.value).split("at least ")[1].split(" ")[0])
    for budget, fits in ((least, True), (least - 1, False)):
        settings = resolve_quality("high", {"memory.budget_mib": budget})
        if fits:
            plan_memory(settings, scene, (1920, 1080))
        else:
            with pytest.raises(pf.SettingError, match="at least"):
                plan_memory(settings, scene, (1920, 1080))
    with pytest.raises(pf.SettingError, match="whole number from 0"):
        resolve_quality("low", {"memory.budget_mib": -1})


def test_a_window_that_grows_is_drawn_with_fewer_rows(scene: pf.Scene) -> None:
    budget = -(-estimate_bytes(resolve_quality("medium"), scene, (640, 360)) // MIB)
    settings = resolve_quality("medium", {"memory.budget_mib": budget})
    plan = plan_memory(settings, scene, (640, 360))
    assert plan.lowered == {} and plan.scale((640, 360)) == 1.0
    scale = plan.scale((2560, 1440))
    assert 0.25 <= scale < 0.6
    assert estimate_bytes(settings, scene, (round(2560 * scale), round(1440 * scale))) <= budget * MIB


@pytest.mark.gpu
@pytest.mark.parametrize(
    ("quality", "size", "overrides"),
    [
        ("low", SIZE, {}),
        pytest.param("medium", SIZE, {"terrain.backend": "quadtree"}, marks=pytest.mark.slow),
        pytest.param("medium", (640, 360), {}, marks=pytest.mark.slow),
        pytest.param("high", (320, 180), {"composite.antialiasing": "none"}, marks=pytest.mark.slow),
    ],
)
def test_estimates_are_what_is_then_there(scene: pf.Scene, quality: str, size: tuple[int, int], overrides) -> None:
    with pf.Renderer(scene, size, quality, overrides) as renderer:
        renderer.render(pf.view("near"))
        expected = renderer.memory.expected_bytes / MIB
        # Buffers of cells come in steps of 3.4 MiB, which in a small picture are a tenth of all.
        assert used(renderer) == pytest.approx(expected, rel=0.1, abs=7.0)


@pytest.mark.gpu
def test_a_renderer_keeps_to_its_budget(scene: pf.Scene) -> None:
    budget_mib = 102  # of which the table of rivers, which no knob makes smaller, takes 45
    with pf.Renderer(scene, SIZE, "medium", {"memory.budget_mib": budget_mib}) as renderer:
        assert renderer.memory.lowered and renderer.settings["clouds.map_texels"] < 1024
        target = renderer.ctx.simple_framebuffer(SIZE)
        renderer.render_to(target, pf.view("near"))
        # Without a GPU the clouds' volumes are r32f: twice what is planned for them.
        shape, rims = (int(renderer.settings[f"clouds.{name}_texels"]) for name in ("shape", "rim"))
        twice = sum(side**3 for side in (shape, shape // 2, rims)) * 2 * 8 / 7 / MIB
        assert used(renderer) <= budget_mib + (twice if renderer.gpu.caps.is_software else 0.0)
        renderer.gpu.leave(target)
        target.release()
