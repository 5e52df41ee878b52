"""Whitecaps as they are drawn: how much of the sea they cover, and that they are patches."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import planetfall as pf
from planetfall.systems.ocean.block import whitecap_anchor, whitecaps

FOAM = 0.6


def drawn(wind_m_s: float, altitude_m: float) -> NDArray[np.float64]:
    """(rows, columns) share of each pixel under foam, from the albedo with foam and without it."""
    albedos = []
    for foam in (0.0, 1.0):
        with pf.load_scene("earth") as scene:
            ocean = scene.planet[pf.Ocean]
            ocean.foam, ocean.wind_speed_m_s, ocean.foam_albedo = foam, wind_m_s, (FOAM, FOAM, FOAM)
            place = pf.view("sea", scene.planet).camera.resolve(scene).position_m
            x, y, z = place / np.linalg.norm(place)
            camera = pf.Camera.at(
                float(np.degrees(np.arcsin(z))), float(np.degrees(np.arctan2(y, x))), altitude_m, pitch_deg=-60.0
            )
            with pf.Renderer(scene, (320, 180), "low") as renderer:
                renderer.settle(camera, 100.0)
                albedos.append(renderer.render(camera, 100.0, outputs=("albedo",))["albedo"][..., 1].astype(float))
    bare, white = albedos
    return (white - bare) / (0.9 * (FOAM - bare))


@pytest.mark.gpu
@pytest.mark.parametrize("wind_m_s", [8.0, 15.0])
def test_they_cover_what_was_counted_and_are_patches(wind_m_s: float) -> None:
    near, far = (drawn(wind_m_s, height) for height in (300.0, 4000.0))
    # A quarter either way: one moment of one sea; threads that stay behind crests are the most of what is too much.
    for share in (near, far):
        assert share.mean() == pytest.approx(whitecaps(wind_m_s), rel=0.35)
    # Pixels of 2 m show them; from 4 km each pixel has many.
    most = np.sort(near.ravel())[-near.size // 20 :]
    assert most.sum() > 0.7 * near.sum() and near.max() > 0.6
    assert far.max() < 0.3


def test_their_noise_drifts_downwind_and_stays_with_the_planet() -> None:
    wind, up = np.array([0.0, 1.0, 0.0]), np.array([0.6, 0.0, 0.8])
    at = whitecap_anchor(up, 6.4e6, wind, 8.0, 0.0)
    # 4 s later what was here is 24 m further downwind.
    moved = (up * 6.4e6 + 24.0 * wind) / np.linalg.norm(up * 6.4e6 + 24.0 * wind)
    later = whitecap_anchor(moved, float(np.linalg.norm(up * 6.4e6 + 24.0 * wind)), wind, 8.0, 4.0)
    here, there = (np.array(a.cell) + np.array(a.fraction) for a in (at, later))
    np.testing.assert_allclose(here, there, atol=1e-5)
    assert whitecap_anchor(up, 7e7, wind, 60.0, 1e9).cell != at.cell  # far beyond 2^32 cells: no overflow
