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
"""A child counts for less than its parent by this: the parent's other children are at rest when it may be split."""
HURRY = 4.0
"""Errors so many times too large, or small, are mended at once."""
MORPH_S = 0.1
"""A whole morph takes at least this long."""


def capped(share: Floats, supports: Ints, hold: float) -> Floats:
    """Shares of which those above `hold` are less than their parent's by STEP.

    So a node that is to be split has parents that are, whatever happens to be known below them.
    """
    rows = np.flatnonzero(share > hold)
    above = supports[rows, 0]
    own = share[rows]
    own[0] = 0.0  # row GIVEN, which has no parent
    result = share
    while True:
        limit = share[above] * (1.0 / STEP)
        np.minimum(own, limit, out=limit)
        if (limit == own).all():
            return result
        if result is share:
            result = share = share.copy()
        own = limit
        share[rows[1:]] = own[1:]


def raised(split: Mask, supports: Ints) -> Mask:
    """The smallest set of nodes that holds these and, with each, its supports."""
    split = split.copy()
    rows = np.flatnonzero(split)
    while True:
        rows = supports.take(rows, axis=0).ravel()
        rows = rows[~split.take(rows)]
        if not len(rows):
            return split
        split[rows] = True


def _all_of(these: Mask, supports: Ints, rows: Ints) -> Mask:
    """Of which rows all supports are among these. (take and & take a third of the time of indexing and all(axis=1).)"""
    each = these.take(supports.take(rows, axis=0))
    return each[:, 0] & each[:, 1] & each[:, 2]


def closed(split: Mask, supports: Ints) -> Mask:
    """The largest part of a set of nodes whose supports belong to it."""
    split = split.copy()
    split[GIVEN], split[UNKNOWN] = True, False
    while True:
        inside = np.flatnonzero(split)
        kept = _all_of(split, supports, inside)
        if kept.all():
            return split
        split[inside[~kept]] = False


def wanted_split(share: Floats, split: Mask, can_split: Mask, supports: Ints, hold: float) -> tuple[Mask, Mask]:
    """Which nodes are to be split; and of these, which can be."""
    want = raised((share > 1.0) | (split & (share > hold)), supports)
    return want, closed(want & can_split, supports)


def goals(share: Floats, want: Mask, supports: Ints) -> Floats:
    """Where the morphs of the nodes' children go: 1 as the node looks, 0 as they do."""
    goal = np.minimum(np.maximum((BAND - share) * (1.0 / (BAND - 1.0)), 0.0), 1.0)
    goal[~want] = 1.0
    goal[supports[np.flatnonzero(want)]] = 0.0
    return goal


def step(
    share: Floats, want: Mask, split: Mask, morph: Floats, supports: Ints, step_s: float
) -> tuple[Mask, Floats, bool]:
    """Which nodes are split, their children's morphs, and whether more is to come, `step_s` later.

    A node is split or merged while the edges around it are at rest: then what appears looks as what was there.
    """
    add = np.flatnonzero(want & ~split)
    hurried = share > HURRY
    if len(add):
        ready = _all_of(split & (morph == 0.0), supports, add)
        if not ready.all() and hurried[add].any():
            hurried = raised(hurried & want, supports)
            ready |= hurried[add]
        split = split.copy()
        split[add[ready]] = True
    inside = np.flatnonzero(split)
    goal = goals(share, want, supports)
    goal[supports[inside]] = 0.0
    before, after, most = morph[inside], goal[inside], step_s / MORPH_S
    near = np.minimum(np.maximum(after, before - most), before + most)
    leaving = ~want[inside]
    far = hurried[inside] | ((share[inside] < 1.0 / HURRY) & leaving)
    morph = np.ones_like(morph)
    morph[inside] = np.where(far, after, near)
    going = inside[leaving]
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
