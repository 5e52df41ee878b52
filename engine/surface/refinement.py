"""How a forest is refined: the rules by which nodes are split and merged and morphs run. Pure functions of arrays.

`share` is a node's error as a multiple of the wanted one, `supports` (N, 3) the rows that it depends on (nodes.py); row
GIVEN is split for ever, row UNKNOWN never.
"""

import numpy as np
from numpy.typing import NDArray

from .nodes import GIVEN, UNKNOWN

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

BAND = 1.25
"""Children are themselves from this many times the wanted error of their parent on."""
HOLD = 1.1
"""A split node is merged when its error has fallen below the wanted one over this."""
STEP = BAND * HOLD
"""By how much a node's supports count for more than it: they are at rest when it may be split."""
HURRY = 4.0
"""Errors so many times too large, or small, are mended at once."""
MORPH_S = 0.1
"""A whole morph takes at least this long."""


def saturated(share: Floats, supports: Ints, split: Mask, hold: float) -> Floats:
    """Shares so that children count for less than their parents by STEP, and the supports of nodes that are to be split
    (share above 1, or above `hold` for split ones) for more than these by STEP.

    So what is to be split is closed: with a node all its supports are. It depends on the nodes themselves, never on
    what happens to be known below them.
    """
    share = share.copy()
    rows = np.flatnonzero(share > hold)
    above = supports[rows, 0]
    own = share[rows]
    own[0] = 0.0  # row GIVEN, which has no parent
    while True:
        limit = share[above] * (1.0 / STEP)
        np.minimum(own, limit, out=limit)
        if (limit == own).all():
            break
        own = limit
        share[rows[1:]] = own[1:]
    rows = rows[(share[rows] > 1.0) | split[rows]]
    while True:
        to = supports[rows]
        least = (share[rows] * STEP)[:, None]
        less = share[to] < least
        less &= to > UNKNOWN
        if not less.any():
            return share
        row, column = np.nonzero(less)
        to = to[row, column]
        np.maximum.at(share, to, least[row, 0])
        rows = to


def closed(split: Mask, supports: Ints) -> Mask:
    """The largest part of a set of nodes whose supports belong to it."""
    split = split.copy()
    split[GIVEN], split[UNKNOWN] = True, False
    while True:
        inside = np.flatnonzero(split)
        kept = split[supports[inside]].all(axis=1)
        if kept.all():
            return split
        split[inside[~kept]] = False


def wanted_split(share: Floats, split: Mask, can_split: Mask, supports: Ints, hold: float) -> Mask:
    """Which nodes are to be split, of those that can be."""
    return closed(((share > 1.0) | (split & (share > hold))) & can_split, supports)


def goals(share: Floats, want: Mask) -> Floats:
    """Where the morphs of the nodes' children go: 1 as the node looks, 0 as they do."""
    goal = np.minimum(np.maximum((BAND - share) / (BAND - 1.0), 0.0), 1.0)
    goal[~want] = 1.0
    goal[GIVEN] = 0.0
    return goal


def step(
    share: Floats, want: Mask, split: Mask, morph: Floats, supports: Ints, step_s: float
) -> tuple[Mask, Floats, bool]:
    """Which nodes are split, their children's morphs, and whether more is to come, `step_s` later.

    A node is split or merged while the edges around it are at rest: then what appears looks as what was there.
    """
    add = np.flatnonzero(want & ~split)
    if len(add):
        ready = split[supports[add]].all(axis=1) & (morph[supports[add]] == 0.0).all(axis=1)
        split = split.copy()
        split[add[ready | (share[add] > HURRY)]] = True
    inside = np.flatnonzero(split)
    goal = goals(share, want)
    goal[supports[inside]] = 0.0
    near = morph[inside] + np.clip(goal[inside] - morph[inside], -step_s / MORPH_S, step_s / MORPH_S)
    far = (share[inside] > HURRY) | (share[inside] < 1.0 / HURRY)
    morph = np.ones_like(morph)
    morph[inside] = np.where(far, goal[inside], near)
    going = inside[~want[inside]]
    going = going[(morph[going] == 1.0) | (share[going] < 1.0 / HURRY)]
    if len(going):
        split = split.copy()
        held = np.zeros(len(split), bool)
        while len(going):
            # Finer ones first: what still supports another one stays.
            held[:] = False
            held[supports[np.flatnonzero(split)]] = True
            free = ~held[going]
            if not free.any():
                break
            split[going[free]] = False
            going = going[~free]
        morph[~split] = 1.0
    moving = bool((split != want).any() or (morph != goal)[inside].any())
    return split, morph, moving
