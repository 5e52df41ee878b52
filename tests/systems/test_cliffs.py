"""Colours of steep ground: as fine along a slope as across it."""

from __future__ import annotations

import numpy as np

import planetfall as pf

SIZE = (480, 270)
STEEP_DEG = 40.0


def test_colours_are_not_drawn_out_along_a_steep_slope() -> None:
    """Of albedo on the wall of a canyon, without its strata: mean squares of its change by the metre, up the slope and
    along the contour. Noise of the map alone, drawn out by the slope, has 0.62 times as much up the slope, this 1.25.
    """
    with pf.Renderer(pf.load_scene("earth"), SIZE, "medium", {"terrain.strata": 0.0}) as renderer:
        view = pf.view("canyon")
        renderer.settle(view)
        eye = renderer.camera_state(view).position_m
        out = renderer.render(view, outputs=("albedo", "position", "slope_deg"))
    albedo = out["albedo"].astype(np.float64).mean(axis=-1)
    place = out["position"].astype(np.float64)
    # Where the three pixels of each difference are on the wall.
    steep = out["slope_deg"] > STEEP_DEG
    wall = steep[:-1, :-1] & steep[1:, :-1] & steep[:-1, 1:]
    here = place[:-1, :-1][wall]
    along, down = place[:-1, 1:][wall] - here, place[1:, :-1][wall] - here
    changes = np.stack([(albedo[:-1, 1:] - albedo[:-1, :-1])[wall], (albedo[1:, :-1] - albedo[:-1, :-1])[wall]], axis=1)
    normal = np.cross(along, down)
    up = eye / np.linalg.norm(eye)
    contour = np.cross(up[None], normal)
    contour /= np.linalg.norm(contour, axis=1, keepdims=True)
    rise = np.cross(normal, contour)
    rise /= np.linalg.norm(rise, axis=1, keepdims=True)
    # The change by the metre along both axes of the surface from that along the picture's.
    axes = np.stack(
        [np.stack([np.einsum("ij,ij->i", step, axis) for axis in (contour, rise)], axis=1) for step in (along, down)],
        axis=1,
    )
    good = np.abs(np.linalg.det(axes)) > 0.05 * np.linalg.norm(axes, axis=2).prod(axis=1)
    by_metre = np.linalg.solve(axes[good], changes[good][..., None])[..., 0]
    # Without the outermost hundredth of each axis: where the pixels lie at a break of the slope.
    level, sloping = (np.sort(by_metre[:, k] ** 2)[: int(0.99 * len(by_metre))].mean() for k in (0, 1))
    assert len(by_metre) > 2000
    assert 0.8 < sloping / level < 1.6
