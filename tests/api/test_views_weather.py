"""Named views under earth's own weather: what they are named after is seen."""

from __future__ import annotations

import numpy as np

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene

VIEWS = ("valley", "beach", "shallows")
ARRAYS = ("radiance", "surface")


def test_views_of_the_ground_are_not_lost_in_clouds():
    """The ground's contrast arrives: within a mist, or in one great shadow, less than a third of it does."""
    with preset_scene("earth", clouds=True) as scene:
        seen = {}
        for sky in ("cloudy", "clear"):
            if sky == "clear":
                scene.planet.remove(pf.Clouds)
            with pf.Renderer(scene, (96, 54), "low", {"composite.antialiasing": "none"}) as renderer:
                for name in VIEWS:
                    out = renderer.render(pf.view(name), outputs=ARRAYS)
                    seen[sky, name] = out["radiance"][..., 1].astype(float), out["surface"] == 1
    for name in VIEWS:
        (cloudy, _), (clear, ground) = seen["cloudy", name], seen["clear", name]
        both = np.cov(cloudy[ground], clear[ground])
        assert both[0, 1] > 0.6 * both[1, 1], name
