"""Kinds of stress suite terrain without a picture: culling of cells, and the selection of tiles while they stream."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...engine.surface.forest import Forest, Selection
from ...engine.surface.icosphere import TriangleScheme
from ...engine.surface.keys import container_of, first_inside, last_inside, level_of
from ...engine.surface.scheme import QuadScheme, Scheme
from ..measure.culling import random_pairs
from ..measure.selection import PIXEL_RAD, MadeGround, above, make_tiles
from ..session import Session
from .draw import log_uniform, unit
from .runner import Case, Found, Kind

SCHEMES: Mapping[str, type[Scheme]] = {"quadtree": QuadScheme, "icosphere": TriangleScheme}
PAIRS = 50
FRAMES = 30


def _draw(rng: np.random.Generator) -> Case:
    radius = log_uniform(rng, 1e3, 7e7)
    return {
        "scheme": str(rng.choice(list(SCHEMES))),
        "radius_m": radius,
        "relief_m": radius * log_uniform(rng, 1e-4, 0.2),
        "seed": int(rng.integers(2**31)),
    }


def _ground(case: Case) -> MadeGround:
    return MadeGround(SCHEMES[case["scheme"]](), case["radius_m"], case["relief_m"])


def _check_culling(case: Case, session: Session) -> Found:
    """Cells and cameras against dense samples: nothing visible is dropped."""
    found = Found()
    culled = random_pairs(_ground(case), np.random.default_rng(case["seed"]), PAIRS)
    found.expect(culled.dropped == 0, f"{culled.dropped} of {culled.visible} visible cells were culled")
    found.note("invisible cells that were kept", 100.0 * (1.0 - culled.share), "%")
    return found


def _check_selection(case: Case, session: Session) -> Found:
    """A flight with jumps while tiles arrive late and are lost: no hole, no overlap, edges alike, limits kept."""
    found = Found()
    ground, rng = _ground(case), np.random.default_rng(case["seed"])
    forest = ground.forest()
    make_tiles(forest, ground, ground.scheme.root_keys(), 1 << 20)
    up, altitude = unit(rng), log_uniform(rng, 1e-6, 10.0) * ground.radius_m
    most = int(rng.integers(40, 500))
    slots = 2 * most + 50
    points = ground.scheme.at(np.stack([unit(rng) for _ in range(200)]), 24)
    for frame in range(FRAMES):
        if rng.random() < 0.2:
            up, altitude = unit(rng), log_uniform(rng, 1e-6, 10.0) * ground.radius_m
        up = up + 1e-3 * altitude / ground.radius_m * rng.normal(size=3)
        eye = above(ground, altitude, up)
        selection = forest.select(eye, PIXEL_RAD, 1.0, frame / 60.0, max_tiles=most)
        check_leaves(found, forest, selection, points, most)
        make_tiles(forest, ground, selection.wanted[rng.random(len(selection.wanted)) < 0.7], slots)
        found.expect(len(forest.table) <= slots, f"{len(forest.table)} nodes are known, {slots} have room")
    return found


def check_leaves(found: Found, forest: Forest, selection: Selection, points: np.ndarray, most: int) -> None:
    """Every point in one leaf, neighbours within a level, an edge the same from both sides."""
    scheme, leaves = forest.scheme, forest.leaves()
    found.expect(bool((last_inside(leaves)[:-1] < first_inside(leaves)[1:]).all()), "leaves overlap")
    area = float((4.0 ** -level_of(leaves).astype(np.float64)).sum())
    found.expect(area == scheme.roots, f"leaves cover {area} of {scheme.roots} roots")
    found.expect(bool((container_of(points, leaves) >= 0).all()), "a direction is in no leaf")
    found.expect(len(leaves) <= most, f"{len(leaves)} leaves, {most} are allowed")
    beside = scheme.neighbour(selection.keys[:, None], np.arange(scheme.edges))
    at = container_of(beside, leaves)
    skip = np.where(at >= 0, selection.levels[:, None] - level_of(leaves)[at], 0)
    found.expect(bool((skip == selection.edge_skip).all()), "an edge says another level than its neighbour has")
    found.expect(int(skip.max(initial=0)) <= 1, "neighbours differ by more than a level")
    edges = {}
    for key, row, morphs in zip(selection.keys.tolist(), beside.tolist(), selection.edge_morph.tolist(), strict=True):
        for other, morph in zip(row, morphs, strict=True):
            edges[key, other] = morph
    both = all(edges.get((b, a), morph) == morph for (a, b), morph in edges.items())
    found.expect(both, "an edge's morph differs between its sides")


CELL_KINDS: Mapping[str, Kind] = {
    "culling": Kind(_draw, _check_culling, weight=0.25),
    "selection": Kind(_draw, _check_selection, weight=0.25),
}
