"""Trees as the GPU has them, and which of them a camera sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.layout import StructLayout, Vec3, Vec4
from ...engine.made_shaders import made_shader
from ...engine.space import CameraState
from .snow import SnowFall
from .species import Species, forms_of
from .stand import Plants

__all__ = ["TREE_DTYPE", "Close", "in_detail", "seen", "tree_records", "within"]

Floats = NDArray[np.float64]

_NEAREST = 0.72
"""Share of the reach within which all trees are drawn; each of the others has a distance of its own."""
_LOWEST_LEAF, _LEAF_M = 0.2, 0.2
"""Of a broadleaf's crown, as a share of its height; and how near to the eye its leaves may come."""
_FLAT_LEAF = 0.66
"""The same of an acacia's and a palm's."""
_CROWN = 0.6
"""Height of the crown's middle over the tree's."""
_TRUNK_M, _COLUMN = 0.6, 0.32
"""More than any trunk is wide, but for columns': over the radius of all of it."""
_WINDOWS = 1.0
"""Trees nearer than their size times this get windows: quads of farther ones hold them."""
_LOWEST_BRANCH = 0.05
"""Over a tree's height."""
_LOBE, _LOBE_WIDE = 0.40, 0.42
"""Over a broadleaf's height: no lobe is lower than this, less so much of the crown's radius (cover/gbuffer.vert)."""
_LEANS = 0.03 * 0.75 * 2.35
"""Over a tree's height: the farthest that the wind moves its top (TREE_SWAY of cover/gbuffer.vert, and sway.py)."""
_WINDOW_MARGIN = 0.01
"""More than antialiasing moves the picture."""
_AHEAD_M = 0.05
_LIMB_PIXEL = 0.6 * 0.009
"""Over a tree's height: what a pixel spans where its limbs have become too thin to be drawn."""
_ACACIA_LIMB = 5.0
"""How much farther an acacia's show, which are thicker and all that holds its crown."""
_SHRUB_SUNK, _ROSETTE_SUNK = 0.35, 0.80
"""A shrub is drawn as a broadleaf tree that is sunk by this share of its height, up to its crown; a rosette's
space is as much higher than it, so that its crown is as wide as a tree's."""
_SEEN_HEIGHTS = 150.0
"""A plant farther away than so many of its heights isn't drawn: a pixel of 1080 rows shows a seventh of it."""
_LEAF_PIXEL_M = 0.15 * 0.13
"""What a pixel spans where leaves have become too small to be drawn: LEAF_PIXEL and TUFT_M of cover/tree.glsl."""
_GROWS = 0.1
"""Share of the reach over which a tree grows from nothing."""


@dataclass
class CoverTree:
    """A tree, in planet axes. GLSL: ``generated/cover.glsl``."""

    foot_m: Annotated[Vec3, "from the camera, or from the middle of a map"]
    height_m: float
    radius_m: Annotated[float, "of the crown"]
    species: Annotated[float, "Species that it is shaped like, and 8 for each of the planet's own up to its one"]
    turn: Annotated[float, "0..1 of a whole one"]
    tint: Annotated[float, "0..1"]
    window: Annotated[Vec4, "of a tree that a quad facing the eye may not hold: of the picture, x and y from and to"]
    stem: Annotated[Vec4, "the same of what is below its crown"]
    hue: Annotated[float, "-1..1: of dark, bluish and of light, yellowish leaves"]
    snow: Annotated[float, "0..1: share of what faces up that it lies on"]


_LAYOUT = StructLayout(CoverTree, "std430")
TREE_DTYPE = _LAYOUT.dtype
made_shader("generated/cover.glsl", lambda: _LAYOUT.glsl)


def tree_records(plants: Plants, middle_m: Floats, grown: Floats | float = 1.0) -> NDArray[np.void]:
    """Records (N,) with places from middle_m (3,), planet-centred; grown: (N,) share of their full size."""
    out = np.zeros(len(plants), TREE_DTYPE)
    forms, height, foot = plants.forms, plants.heights_m * grown, plants.positions_m - middle_m
    shape = plants.species.copy()
    for form, sunk in ((Species.SHRUB, _SHRUB_SUNK), (Species.ROSETTE, _ROSETTE_SUNK)):
        low = np.flatnonzero(forms == form)
        height[low] /= 1.0 - sunk
        foot[low] -= (sunk * height[low])[:, None] * plants.up[low]
    shape[forms == Species.SHRUB] -= int(Species.SHRUB)
    out["foot_m"], out["height_m"], out["radius_m"] = foot, height, plants.radii_m * grown
    out["species"], out["turn"] = shape, plants.chance[:, 0]
    out["tint"], out["hue"] = plants.chance[:, 1], plants.hues
    return out


@dataclass(frozen=True)
class Close:
    """Plants that may be in a picture from around a place, and what stays the same from wherever it is taken there."""

    plants: Plants
    reach_m: Floats
    """(N,) from how near plants of that height may be drawn"""
    own_m: Floats
    """(N,) from how near each is: its share of that"""
    snow: Floats
    """(N,) as SnowFall.on has it"""


def within(plants: Plants, place_m: Floats, reach_m: float, margin_m: float, snow: SnowFall) -> Close:
    """Those that `seen` may find from up to margin_m around a place (3,), in the same order."""
    offset = plants.positions_m - place_m
    reach = np.minimum(reach_m, _SEEN_HEIGHTS * plants.heights_m)
    own = reach * (_NEAREST + (1.0 - _NEAREST) * np.modf(plants.chance[:, 1] * 13.0)[0])
    far = own + margin_m
    which = np.flatnonzero(np.einsum("ij,ij->i", offset, offset) < far * far)
    few = plants.only(which)
    return Close(few, reach[which], own[which], snow.on(few.positions_m))


def seen(close: Close, camera: CameraState) -> tuple[NDArray[np.void], Floats, Plants]:
    """Records (N,) of the trees in the picture, those that are drawn apart last, of either the nearest first: what lies
    behind is then rejected early; how near (N,) their crowns come, metres; and these trees. A tree in whose leaves the
    eye is isn't drawn, since they would be all that is seen."""
    plants = close.plants
    if not len(plants):
        return np.zeros(0, TREE_DTYPE), np.zeros(0), plants
    edges = np.concatenate([camera.forward[None], camera.planes])
    offset = plants.positions_m - camera.position_m
    low = edges @ offset.T
    high = low + _CROWN * plants.heights_m * (edges @ plants.up.T)
    # A ball around the crown, or the trunk below it: on the picture's side of all of its edges.
    wide = np.maximum(plants.radii_m, (1.0 - _CROWN) * plants.heights_m) + _LEAF_M
    stem = np.maximum(_TRUNK_M, _COLUMN * plants.radii_m)
    inside = (high > -wide).all(axis=0) | (np.maximum(high, low) > -stem).all(axis=0)
    which = np.flatnonzero(inside)
    offset, height = offset[which], plants.heights_m[which]
    away = np.sqrt(np.einsum("ij,ij->i", offset, offset))
    grown = np.clip((close.own_m[which] - away) / (_GROWS * close.reach_m[which]), 0.0, 1.0)
    drawn = grown > 0.0
    near = np.flatnonzero(away < height + plants.radii_m[which] + _LEAF_M)
    if len(near):
        around = plants.only(which[near])
        drawn[near] &= ~_holds(around, offset[near], around.up)
    order = np.argsort(away, kind="stable")
    order = order[drawn[order]]
    apart = plants.drawn_apart[which[order]]
    if apart.any():
        order = np.concatenate([order[~apart], order[apart]])
    which, offset, away, grown = which[order], offset[order], away[order], grown[order]
    few = plants.only(which)
    rows = tree_records(few, camera.position_m, grown)
    rows["snow"] = close.snow[which]
    near = np.flatnonzero(away < _WINDOWS * (few.heights_m + few.radii_m))
    if len(near):
        rows["window"][near], rows["stem"][near] = windows(rows[near], few.up[near], camera)
    return rows, _crown_m(few, offset, few.up), few


def windows(trees: NDArray[np.void], up: Floats, camera: CameraState) -> tuple[Floats, Floats]:
    """The parts of the picture (N, 4), in normalised device coordinates, that hold each tree's crown, and its stem
    below that; up: (N, 3), unit."""
    helper = np.where(np.abs(up[:, 2:]) < 0.7, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    east = _cross(helper, up)
    east /= np.linalg.norm(east, axis=1, keepdims=True)
    north = _cross(up, east)
    foot, height, radius = (trees[name].astype(np.float64) for name in ("foot_m", "height_m", "radius_m"))

    crown, trunk = 1.03 * radius + _LEANS * height, 0.03 * height + 0.5 * _LEANS * height
    forms = forms_of(trees["species"])
    leaves_from = np.clip(_LOBE - _LOBE_WIDE * radius / height, _LOWEST_BRANCH, 0.5)
    lowest = np.select(
        [forms == Species.COLUMN, forms == Species.CONIFER], [-_LOWEST_BRANCH, _LOWEST_BRANCH], leaves_from
    )
    # Of the boxes around crowns and around stems: (parts, ends, corners, N, 3).
    ends = np.array([[lowest * height, 1.03 * height], [-0.05 * height, lowest * height]])
    aside = np.array([east + north, east - north, -east - north, north - east])
    wide = np.array([crown, trunk])
    box = foot + wide[:, None, None, :, None] * aside + ends[:, :, None, :, None] * up
    corners = box.reshape(2, 8, -1, 3).swapaxes(0, 1).reshape(8, -1, 3)
    found = _around(corners, camera)
    found[:, :2] = np.maximum(found[:, :2] - _WINDOW_MARGIN, -1.0)
    found[:, 2:] = np.minimum(found[:, 2:] + _WINDOW_MARGIN, 1.0)
    return found[: len(trees)], found[len(trees) :]


_EDGES = np.array([(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)])
"""Of a box, whose corners go around below and then around above."""


def _around(corners: Floats, camera: CameraState) -> Floats:
    """Windows (N, 4) that hold boxes whose corners are (8, N, 3), from the eye, as far as they lie ahead of it."""
    start, end = (corners[np.concatenate(pair)] for pair in (_EDGES.T, _EDGES.T[::-1]))
    ahead = corners @ camera.forward
    here, there = (ahead[np.concatenate(pair)] for pair in (_EDGES.T, _EDGES.T[::-1]))
    behind = here < _AHEAD_M
    over = np.where(np.abs(there - here) > 1e-9, there - here, 1.0)
    share = np.where(behind & (over == there - here), (_AHEAD_M - here) / over, 0.0)
    point = start + share[..., None] * (end - start)
    shown = ~(behind & (there < _AHEAD_M))
    z = np.maximum(point @ camera.forward, 0.5 * _AHEAD_M)
    x = (point @ camera.right / z - camera.tan_left) / (camera.tan_right - camera.tan_left) * 2.0 - 1.0
    y = (point @ camera.up / z - camera.tan_bottom) / (camera.tan_top - camera.tan_bottom) * 2.0 - 1.0
    place = np.stack([x, y], axis=-1)
    least = np.where(shown[..., None], place, 1.0).min(axis=0, initial=1.0)
    most = np.where(shown[..., None], place, -1.0).max(axis=0, initial=-1.0)
    return np.concatenate([least, most], axis=1)


def _cross(a: Floats, b: Floats) -> Floats:
    """Of rows (N, 3): np.cross, which takes five times as long for a few."""
    return a[:, (1, 2, 0)] * b[:, (2, 0, 1)] - a[:, (2, 0, 1)] * b[:, (1, 2, 0)]


def in_detail(trees: NDArray[np.void], crown_m: Floats, pixel_rad: float) -> tuple[int, int]:
    """How many of them, the first ones, are so near that a pixel can show a leaf, and a limb (TREE_LEAVES and
    TREE_LIMBS of cover/tree.glsl). crown_m: (N,), as seen() has it."""
    pixel = crown_m * pixel_rad

    def first(shown: NDArray[np.bool_]) -> int:
        which = np.flatnonzero(shown)
        return int(which[-1]) + 1 if len(which) else 0

    leaves = first(pixel < _LEAF_PIXEL_M)
    thick = np.where(forms_of(trees["species"]) == Species.ACACIA, _ACACIA_LIMB, 1.0) * trees["height_m"]
    return leaves, max(first(pixel < _LIMB_PIXEL * thick), leaves)


def _crown_m(plants: Plants, offset_m: Floats, up: Floats) -> Floats:
    """How near the crown of each tree (N,) may come to the eye: from its axis, less its radius; as _holds()."""
    height = np.clip(-np.einsum("ij,ij->i", offset_m, up), _LOWEST_BRANCH * plants.heights_m, plants.heights_m)
    nearest = offset_m + height[:, None] * up
    return np.maximum(np.sqrt(np.einsum("ij,ij->i", nearest, nearest)) - plants.radii_m, 0.0)


def _holds(plants: Plants, offset_m: Floats, up: Floats) -> NDArray[np.bool_]:
    """Whether the crown of a tree (N,) holds the eye; offset_m (N, 3): of its foot from there; up: (N, 3), unit."""
    rise = -np.einsum("ij,ij->i", offset_m, up)
    aside = np.linalg.norm(offset_m + rise[:, None] * up, axis=1)
    share = rise / plants.heights_m
    # cover/lobes.glsl, and the cone of cover/tree.glsl.
    forms = plants.forms
    conifer = forms == Species.CONIFER
    wide = np.where(conifer, 1.0 - share, 1.0) * plants.radii_m + _LEAF_M
    flat = (forms == Species.ACACIA) | (forms == Species.PALM)
    whole = conifer | (forms == Species.COLUMN) | (forms == Species.ROSETTE)
    lowest = np.where(whole, 0.0, np.where(flat, _FLAT_LEAF, _LOWEST_LEAF))
    return (share > lowest) & (share < 1.0) & (aside < wide)
