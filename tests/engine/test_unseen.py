"""Systems of a planet that is out of the view leave frames alone, and show the same as ever when it comes back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import planetfall as pf
from planetfall.engine.frame.unseen import Unseen

SIZE = (64, 36)
DOWN, AWAY = -70.0, 60.0
LOW = pf.Sun(elevation_deg=15.0, azimuth_deg=200.0, latitude_deg=20.0, longitude_deg=-30.0)


def flown(monkeypatch: Any, rests: bool, low: bool) -> tuple[list[NDArray[Any]], list[bool]]:
    """Pictures of a flight that looks at the planet, away from it, and back; and who rested."""
    scene = pf.load_scene("earth")
    scene.planet.add(pf.Clouds(coverage=0.6))
    pictures, rested = [], []
    asked = Unseen.rests

    def watched(self: Unseen, frame: Any) -> bool:
        found = rests and asked(self, frame)
        rested.append(found)
        return found

    monkeypatch.setattr(Unseen, "rests", watched)
    with pf.Renderer(scene, SIZE, "low") as renderer:
        target = renderer.ctx.simple_framebuffer(SIZE)
        for k in range(18):
            pitch = AWAY if 5 <= k < 12 else DOWN
            if k == 7:
                scene.planet[pf.Ocean].wind_speed_m_s = 14.0
                scene.planet[pf.Terrain].snow_line_m = 1500.0
            sun = LOW if low and k >= 8 else None
            camera = pf.Camera.at(20.0, -30.0 + 0.01 * k, 2e6, pitch_deg=pitch)
            renderer.render_to(target, camera, time_s=0.1 * k, sun=sun, dt_s=0.1)
            pictures.append(np.frombuffer(target.read(), np.uint8).copy())
        renderer.gpu.leave(target)
        target.release()
    monkeypatch.setattr(Unseen, "rests", asked)
    return pictures, rested


@pytest.mark.parametrize("low", [False, True], ids=["same sun", "another sun"])
def test_pictures_are_those_of_systems_that_never_rest(monkeypatch: Any, low: bool) -> None:
    ours, rested = flown(monkeypatch, True, low)
    always, _ = flown(monkeypatch, False, low)
    assert sum(rested) >= 5 * 4, "ground, shadows, sea, air and clouds, in most frames without the planet"
    assert not np.array_equal(ours[4], ours[6]), "the planet was there"
    for k, (one, other) in enumerate(zip(ours, always, strict=True)):
        np.testing.assert_array_equal(one, other, err_msg=f"frame {k}")
