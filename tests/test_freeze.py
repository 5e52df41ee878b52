"""DebugView.freeze on the grid: what is drawn stays, whatever the camera does, and goes on when it is let go."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import planetfall as pf

pytestmark = pytest.mark.gpu

SIZE = (160, 90)


def test_the_grid_is_frozen_and_let_go(gpu: Any) -> None:
    with pf.load_scene("earth") as scene, pf.Renderer(scene, SIZE, "low", ctx=gpu.ctx) as renderer:
        here = pf.Camera.at(12.0, 20.0, 3000.0, 30.0, -25.0, planet=scene.planet)
        away = pf.Camera.at(12.0, 20.0, 60_000.0, 210.0, -80.0, planet=scene.planet)
        renderer.settle(here)
        renderer.render(here)
        proxy = scene.world.resource("proxy.0")
        drawn = renderer.stats
        scene.environment.add(pf.DebugView(freeze=True))
        renderer.render(here)
        for _ in range(3):
            outputs = renderer.render(away, dt_s=0.1, outputs=("surface",))
        assert renderer.stats == drawn and scene.world.resource("proxy.0").generation == proxy.generation
        ran = {report.name for report in renderer.passes() if report.ran}
        assert not ran & {"terrain.vertices", "terrain.cull", "ocean.vertices", "ocean.cull"}
        # From above only the wedge that `here` looked along is there.
        frozen_share = float((outputs["surface"] > 0).mean())
        scene.environment[pf.DebugView].view = "wireframe"  # the graph is compiled again
        renderer.render(away, dt_s=0.1)
        assert renderer.stats == drawn
        scene.environment[pf.DebugView].freeze = False
        free = renderer.render(away, dt_s=0.1, outputs=("surface",))["surface"]
        assert scene.world.resource("proxy.0").generation != proxy.generation
        assert 0.0 < frozen_share < 0.7 * float((free > 0).mean())
        assert np.isfinite(frozen_share)
