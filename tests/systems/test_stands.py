"""Stands of a forest are the same on the GPU, where woods are colour, as in float64, where they are trees."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import RunCompute

from planetfall.engine.surface.nested import nested_anchor
from planetfall.systems.cover.stands import glade, stands

RADIUS_M = 6.371e6
OUTSIDE = """
float ramp(float a, float b, float x) {{ return clamp((x - a) / (b - a), 0.0, 1.0); }}
#include "common/nested_noise.glsl"
struct Anchor {{ ivec3 cell; vec3 fraction; }};
struct Block {{ Anchor anchor; }};
struct Map {{ float variety; }};
const Block terrain_material_block = Block(Anchor(ivec3{cell}, vec3{fraction}));
const Map cover_map = Map(1.0);
#include "terrain/stands.glsl"
"""


@pytest.mark.gpu
@pytest.mark.parametrize("place", [(0.3, -0.5, 0.8), (0.0, 0.0, 1.0), (-1.0, 1e-9, 0.0)])
def test_stands_are_the_same_as_colour_and_as_trees(run_compute: RunCompute, place: tuple[float, float, float]) -> None:
    up = np.array(place) / np.linalg.norm(place)
    anchor = nested_anchor(up, RADIUS_M)
    rng = np.random.default_rng(3)
    offset = rng.uniform(-3000.0, 3000.0, (2000, 3)).astype(np.float32)
    point = RADIUS_M * up + offset.astype(np.float64)
    distance = np.linalg.norm(point, axis=1)
    # Noise fills space: each place as if the planet's surface went through it.
    expected = np.stack([stands((p / r)[None], r)[:, 0] for p, r in zip(point, distance, strict=True)], axis=1)
    out = run_compute(
        """float region = nested_noise(terrain_material_block.anchor.cell, terrain_material_block.anchor.fraction,
            offset, 14).w;
        Stand s = stand_at(offset, region, 0.1);
        found = vec3(s.age, s.hue, s.open);""",
        {"offset": offset},
        {"found": "vec3"},
        header=OUTSIDE.format(cell=tuple(anchor.cell), fraction=tuple(anchor.fraction)),
    )["found"]
    assert np.abs(out[:, :2].T - np.clip(expected[:2], -1.0, 1.0)).max() < 2e-3
    assert np.abs(out[:, 2] - glade(expected[2])).max() < 1e-2
    assert expected[:2].std() > 0.2 and 0.01 < (glade(expected[2]) > 0.5).mean() < 0.3
