"""What a window draws at when nobody says."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

import planetfall as pf
from planetfall.app.renderer import SOFTWARE, USUAL, renderer_maker, usual_quality
from planetfall.engine.hosts.headless import create_headless


@pytest.mark.parametrize(
    ("driver", "expected"),
    [
        ("llvmpipe (LLVM 15.0.6, 256 bits)", SOFTWARE),
        ("Google SwiftShader", SOFTWARE),
        ("NVIDIA GeForce RTX 4070/PCIe/SSE2", USUAL),
        ("AMD Radeon 780M (radeonsi, gfx1103_r1)", USUAL),
    ],
)
def test_by_what_draws(driver: str, expected: tuple[str, float]) -> None:
    assert usual_quality(driver) == expected


def test_without_a_gpu_the_first_renderer_has_fewer_pixels_and_the_next_one_all() -> None:
    ctx = create_headless()
    window: Any = SimpleNamespace(ctx=ctx, framebuffer_size=(64, 36))
    named: Any = SimpleNamespace(ctx=SimpleNamespace(info={"GL_RENDERER": "softpipe"}))
    with pf.load_scene("moon") as scene:
        quality, _ = renderer_maker(scene, named, None)
        assert quality == "low"
        _, make = renderer_maker(scene, window, None)
        scale = usual_quality(ctx.info["GL_RENDERER"])[1]
        for expected in (scale, 1.0):
            with make("low", {}) as made:
                assert made.render_scale == expected and made.size == (round(64 * expected), round(36 * expected))
                assert made.tolerant and made.context.host is None  # nobody waits for this window's GL state
        chosen, make = renderer_maker(scene, window, "medium")
        with make(chosen, {}) as made:
            assert chosen == "medium" and made.render_scale == 1.0 and made.size == (64, 36)
    ctx.release()


def test_a_wrong_quality_is_told_before_a_window_opens() -> None:
    with pf.load_scene("moon") as scene, pytest.raises(pf.SettingError, match="quality"):
        pf.fly(scene, quality="")
