"""Fine ground below a camera that has just leapt there."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.benchmarks.measure.selection import MadeGround
from planetfall.engine.surface.footing import footing
from planetfall.engine.surface.icosphere import TriangleScheme
from planetfall.engine.surface.keys import container_of, parent_of
from planetfall.engine.surface.scheme import QuadScheme, Scheme


@pytest.mark.parametrize("scheme", [QuadScheme(), TriangleScheme()], ids=lambda s: s.name)
def test_with_the_footing_alone_the_tile_is_drawn(scheme: Scheme):
    rng = np.random.default_rng(1)
    ground = MadeGround(scheme)
    places = [*np.eye(3), np.ones(3), *rng.normal(size=(6, 3))]
    for place in places:
        down = place / np.linalg.norm(place)
        for level in (0, 1, 3, 17):
            keys = footing(scheme, down, level)
            assert len(np.unique(keys)) == len(keys) <= scheme.roots + 40 * (level + 1)
            known = set(keys.tolist())
            assert all(int(parent_of(np.int64(k))) in known for k in keys[scheme.roots :])
            forest = ground.forest()
            facts = ground.facts(keys)
            forest.set_facts(keys, facts.low_m, facts.high_m, facts.error_m)
            eye = down * (ground.radius_m + float(ground.height(down[None])[0]) + 0.5)
            selection = forest.select(eye, 1e-3, 1.0, finest_spacing_m=1e-3)
            order = np.argsort(selection.keys)
            leaf = order[container_of(scheme.at(down[None], 27), selection.keys[order])[0]]
            assert selection.levels[leaf] == level
