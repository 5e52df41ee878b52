"""Which trees and shrubs stand in a plot: a function of the plot's integers, of the ground and of the component alone.

A plot is a cell of the lattice on the cube (engine/surface/lattice.py) of some 100 m. The places of a layer form a
square grid, each moved at random within its square; whether a place has a plant is drawn against how well they grow
there, in groups and with clearings.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ...components import Cover
from ...components.mask import mask_share
from ...engine.frame.labels import instances_of
from ...engine.surface.lattice import FULL_BITS, cell_edge_m, direction_of
from .chance import draws, patches
from .growth import Climate, Growing, GrowingGround, ramp, savanna
from .species import OwnSpecies, Species, forms_of
from .stands import STAND_CONIFERS, STAND_SIZES, glade, stands

__all__ = ["LAYERS", "NOTHING", "SHRUBS", "TREES", "Layer", "Plants", "Plot", "Species", "plants_in", "plot_level"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

PLOT_M = 100.0
"""About how long the side of a plot is."""
_COARSE = 4
"""Squares a side on which climate and slope are asked: both change little over 25 m."""
_SUNK_M = 0.1
"""How deep a trunk begins below the ground, so that no slope shows its end."""
_BANK_M = 0.4
"""Height above a river or a lake below which nothing stands."""
_ASIDE_M = 30.0
"""More than corners of squares are apart by: water is near to a place where it is to a corner of its square."""
_SHALLOW_M = 0.3
"""Depth of water up to which those stand that grow along it."""
_COAST_M, _PALM_WARM = (25.0, 6.0), (0.62, 0.75)
"""Height above the beach between which palms begin, downwards; and warmth."""
_ON_BEACH, _UP_BEACH = 0.3, 0.7
"""Share of palms that may stand on the beach, and of its height in which they do."""
_SHORE_UP = 0.05
"""Share of the beach's height up to which those stand that grow in the sea."""
_SHORE_FLAT = (0.10, 0.03)
"""Slopes between which they begin to stand; mud lies where shores are flat."""
_SHORE_NEAR_M = 8.0
"""Height above and below which no place between corners of squares is on the shore."""
_GROUP_M = (180.0, 45.0)
"""Sizes of woods and clearings, and of groups in them."""
_SEEDS = (11, 12)
_HIGH, _BROAD = (0.50, 0.52, 0.24), (0.50, 0.84, 0.50)
"""Heights of a forest's trees and widths of their crowns, over a grown one's: of small ones, what they grow by, and
what few giants have more; as assets/shaders/terrain/crowns.glsl has them."""
_HIGHEST = 1.26
_SPECIES_HUE = 0.5
"""How far few trees of a stand differ from it; as in assets/shaders/cover/hue.glsl."""
_GIANT, _OVERSHADOWED = 0.87, 0.45
"""Chance from which on a tree is one, and up to which none grows beside it."""


@dataclass(frozen=True)
class Layer:
    """Plants of about one height, which have their places of their own."""

    spacing: str
    """field of Cover"""
    density: str
    """field of Cover"""
    salt: int
    """what its chance differs by from that of others"""
    first: int
    """number of its first place in a plot: names differ"""


TREES = Layer("spacing_m", "density", 0, 0)
SHRUBS = Layer("shrub_spacing_m", "shrubs", 101, 1 << 20)
LAYERS = (TREES, SHRUBS)


@dataclass(frozen=True)
class Plot:
    """A cell of the lattice, as engine/surface/lattice.py names it."""

    face: int
    level: int
    i: int
    j: int


@dataclass(frozen=True)
class Plants:
    """N trees and shrubs. Planet axes, metres."""

    positions_m: Floats
    """(N, 3) where they stand, from the planet's centre"""
    heights_m: Floats
    """(N,)"""
    radii_m: Floats
    """(N,) of the crown"""
    species: Ints
    """(N,) values of Species; of a planet's own, the k-th of Cover.species, from 8 (k + 1) on"""
    names: Ints
    """(N, 5) face, level, i, j of the plot, and the number in it: the same tree has the same name always"""
    chance: Floats
    """(N, 3) of [0, 1): how it is turned, its tint, and how near it has to be to be drawn"""

    hues: Floats
    """(N,) -1..1: of dark, bluish and of light, yellowish leaves"""

    def __len__(self) -> int:
        return len(self.heights_m)

    @cached_property
    def up(self) -> Floats:
        """(N, 3), unit"""
        return self.positions_m / np.linalg.norm(self.positions_m, axis=1, keepdims=True)

    @property
    def forms(self) -> Ints:
        """(N,) values of Species that they are shaped like."""
        return forms_of(self.species)

    @property
    def drawn_apart(self) -> NDArray[np.bool_]:
        """(N,) which have a program of their own: columns and rosettes."""
        return self.forms >= Species.COLUMN

    @classmethod
    def of(cls, parts: list[Plants]) -> Plants:
        """All of them in one."""
        parts = [part for part in parts if len(part)]
        if len(parts) < 2:
            return parts[0] if parts else NOTHING
        return cls(*(np.concatenate([getattr(p, f) for p in parts]) for f in cls.__dataclass_fields__))

    @property
    def instances(self) -> NDArray[np.uint32]:
        """(N,) their values in the output `instance` of pictures."""
        return instances_of(self.names)

    def only(self, which: NDArray[np.bool_] | Ints) -> Plants:
        """Those of a mask or of indices."""
        few = Plants(*(getattr(self, f)[which] for f in self.__dataclass_fields__))
        if "up" in self.__dict__:
            few.__dict__["up"] = self.up[which]
        return few


NOTHING = Plants(
    np.zeros((0, 3)),
    np.zeros(0),
    np.zeros(0),
    np.zeros(0, np.int64),
    np.zeros((0, 5), np.int64),
    np.zeros((0, 3)),
    np.zeros(0),
)


@lru_cache(maxsize=16)
def plot_level(radius_m: float) -> int:
    """The level of the lattice whose cells are nearest to PLOT_M."""
    level = float(np.log2(cell_edge_m(0, radius_m) / PLOT_M))
    return min(max(round(level), 0), FULL_BITS - 8)


def plants_in(
    plots: Sequence[Plot], ground: GrowingGround, growing: Growing, cover: Cover, seed: int, layer: Layer = TREES
) -> list[Plants]:
    """A layer's plants in each plot, all of one level. seed: of the planet's ground. Many at once take a tenth of the
    time."""
    density, spacing_m = float(getattr(cover, layer.density)), float(getattr(cover, layer.spacing))
    own = OwnSpecies.of(cover.species, low=layer is SHRUBS)
    if not plots or density <= 0.0:
        return [NOTHING] * len(plots)
    cells = np.array([(p.face, p.i, p.j) for p in plots], dtype=np.int64)
    level, edge = plots[0].level, float(cell_edge_m(plots[0].level, ground.radius_m))
    coarse = _Coarse.of(cells, level, ground, growing, layer, own)
    woody = np.flatnonzero(coarse.share.any(axis=(1, 2)) | coarse.own.any(axis=(0, 2, 3)))
    count = max(round(edge / spacing_m), 1)
    a, b = (c.ravel() for c in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    which, face, i, j = (np.repeat(c, len(a)) for c in (woody, *cells[woody].T))
    number, a, b = (np.tile(c, len(woody)) for c in (np.arange(len(a)), a, b))
    chance = draws(seed + layer.salt, face, i * count + a, j * count + b, 7)
    u, v = (a + 0.1 + 0.8 * chance[0]) / count, (b + 0.1 + 0.8 * chance[1]) / count
    at = coarse.between(which, u, v)
    woods, slope = at(coarse.share), at(coarse.slope)
    steepest = np.tan(np.deg2rad(cover.steepest_deg))
    flat = density * ramp(steepest, 0.7 * steepest, slope)
    share = woods * flat * _groups(face, i + u, j + v, edge, woods)
    share *= 1.0 - cover.variety * glade(at(coarse.stands[2])) * (layer is TREES)
    first = share
    # A planet's own stand in place of others, and where none stand; so no other comes or moves.
    kinds = np.stack([at(each) for each in coarse.own]) if len(own) else np.zeros((0, len(u)))
    scale = 2.0 ** (FULL_BITS - level)
    if own.along_water:
        some = np.flatnonzero(kinds.any(axis=0) & (at(coarse.near_water) > 0.0))
        there = direction_of(face[some], (i + u)[some] * scale, (j + v)[some] * scale).reshape(-1, 3)
        away_m = np.full(len(u), np.inf)
        away_m[some] = ground.from_water_m(there)
        kinds *= own.reaches(away_m)
    if own.on_shores:
        above_m = at(coarse.height_m) - growing.sea_m
        some = np.flatnonzero(kinds.any(axis=0) & (np.abs(above_m) < _SHORE_NEAR_M))
        there = direction_of(face[some], (i + u)[some] * scale, (j + v)[some] * scale).reshape(-1, 3)
        above_m = np.full(len(u), np.inf)
        above_m[some] = ground.height(there) - growing.sea_m
        in_sea = own.in_sea(above_m, _SHORE_UP * growing.beach_m)
        kinds *= np.where(own.shore_m[:, None] > 0.0, in_sea * ramp(*_SHORE_FLAT, slope), 1.0)
        first = np.where(in_sea.any(axis=0), 0.0, share)  # so low none of the others stand
        share = first
    others = chance[2] < first
    of_own = np.minimum(kinds.sum(axis=0) * flat, 1.0)
    share = share + of_own * np.maximum(1.0 - share, 0.0) if len(own) else share
    stands_there = chance[2] < share
    if layer is TREES:
        # Giants of a planet's own shade none: others stand where they would without them.
        stands_there &= ~(others & _overshadowed(np.where(others, chance[4], 0.0), count, cover.variety))
    on = np.flatnonzero(stands_there)
    which, face, i, j, number = (c[on] for c in (which, face, i, j, number))
    u, v, woods = (c[on] for c in (u, v, woods))
    chance = chance[:, on]
    direction = direction_of(face, (i + u) * scale, (j + v) * scale).reshape(-1, 3)
    height = ground.height(direction)
    at = coarse.between(which, u, v)
    warmth = at(coarse.warmth)
    age, hue = (cover.variety * np.clip(at(each), -1.0, 1.0) for each in coarse.stands[:2])
    if layer is SHRUBS:
        species = np.full(len(u), Species.SHRUB, np.int64)
        tall = cover.shrub_height_m * (0.35 + 0.85 * chance[4] ** 2)
        radius = tall * (0.55 + 0.35 * chance[3])
    else:
        climate = Climate(warmth, at(coarse.humidity))
        species = _species(chance[3], chance[5], climate, height - growing.lowest_m, hue, cover)
        tall, radius = _size(species, chance[4], warmth, woods, age, cover)
    wet = ground.is_wet(direction, height - _BANK_M)
    on_shore = np.zeros(len(height), dtype=bool)
    if len(own):
        sums = np.cumsum(kinds[:, on], axis=0)
        drawn = np.modf(chance[5] * 61.0)[0] * sums[-1] / np.where(others[on], np.maximum(of_own[on], 1e-12), 1.0)
        kind = (drawn >= sums).sum(axis=0)
        rows = np.flatnonzero(kind < len(own))
        along = rows[own.aside_m[kind[rows]] > 0.0]
        wet[along] = ground.is_wet(direction[along], height[along] + _SHALLOW_M)
        shore = rows[own.shore_m[kind[rows]] > 0.0]
        wet[shore], on_shore[shore] = False, True
        species[rows] = own.codes[kind[rows]]
        tall[rows], radius[rows] = own.sizes(kind[rows], chance[4, rows])
    place = direction * (ground.radius_m + height - _SUNK_M)[:, None]
    names = np.stack([face, np.full_like(face, level), i, j, number + layer.first], axis=1)
    hues = np.clip(hue + _SPECIES_HUE * cover.variety * (2.0 * np.modf(chance[6] * 23.0)[0] - 1.0) ** 3, -1.0, 1.0)
    found = Plants(place, tall, radius, species, names, chance[[5, 6, 2]].T.copy(), hues)
    # On the beach a few palms.
    palms = (species == Species.PALM) & (np.modf(chance[5] * 53.0)[0] < _ON_BEACH)
    dry = (height > growing.lowest_m - np.where(palms, _UP_BEACH, 0.0) * growing.beach_m) | on_shore
    dry &= ~wet
    dry &= ground.wooded(direction)
    if cover.mask is not None and len(direction):
        left, before = mask_share(cover.mask, direction), np.where(others, 0.0, first)[on]
        dry &= chance[2] - before < (np.where(others, first, share - first)[on]) * left
    return [found.only(np.flatnonzero(dry & (which == k))) for k in range(len(plots))]


def _groups(face: Ints, x: Floats, y: Floats, edge_m: float, woods: Floats) -> Floats:
    """Share of the places (x, y), in plots, that have a tree for those that could: whole in deep forest, else in
    groups."""
    wide, narrow = (
        patches(seed, face, x * edge_m / size, y * edge_m / size) for seed, size in zip(_SEEDS, _GROUP_M, strict=True)
    )
    return ramp(0.2, 0.78, 0.65 * wide + 0.35 * narrow + 0.28 * woods)


def _overshadowed(grown: Floats, count: int, variety: float) -> NDArray[np.bool_]:
    """Which places (N,) have no tree because a giant of the same plot, right beside, takes the light of a small one.
    grown: (N,) chance of those that stand, 0 elsewhere; count: places along a plot's side."""
    giant = np.zeros((len(grown) // count**2, count + 2, count + 2), dtype=bool)
    giant[:, 1:-1, 1:-1] = grown.reshape(-1, count, count) > _GIANT
    giant = giant[:, :-2] | giant[:, 1:-1] | giant[:, 2:]
    giant = giant[:, :, :-2] | giant[:, :, 1:-1] | giant[:, :, 2:]
    return giant.ravel() & (grown < _OVERSHADOWED * variety)


def _species(chance: Floats, other: Floats, climate: Climate, above_sea_m: Floats, hue: Floats, cover: Cover) -> Ints:
    """Which tree stands at a place. chance, other: of [0, 1); hue: of the stand."""
    conifer = chance < ramp(0.62, 0.34, climate.warmth + STAND_CONIFERS * hue)
    dry = (chance < savanna(climate)) & (cover.savanna > 0.0)
    coast = ramp(*_COAST_M, above_sea_m) * ramp(*_PALM_WARM, climate.warmth)
    found = np.where(conifer, Species.CONIFER, np.where(dry, Species.ACACIA, Species.BROADLEAF))
    found = np.where(np.modf(other * 31.0)[0] < cover.palms * coast, Species.PALM, found)
    return np.where(np.modf(other * 17.0)[0] < cover.dead, Species.DEAD, found).astype(np.int64)


def _size(
    species: Ints, chance: Floats, warmth: Floats, woods: Floats, age: Floats, cover: Cover
) -> tuple[Floats, Floats]:
    """Heights and radii of crowns: few are grown, none is at the tree line; in the open they grow wider. age: of the
    stand, -1..1."""
    conifer, acacia, palm = (species == one for one in (Species.CONIFER, Species.ACACIA, Species.PALM))
    equal, giant = 0.45 + 0.65 * np.sqrt(chance), chance**6
    high, broad = (equal + cover.variety * (a + b * chance + c * giant - equal) for a, b, c in (_HIGH, _BROAD))
    broad, high = ((1.0 + by * age) * of for by, of in zip(STAND_SIZES, (broad, high), strict=True))
    grown = np.sqrt(ramp(0.10, 0.34, warmth))
    most = cover.height_m * np.select([conifer, acacia, palm], [1.3, 0.68, 0.75], 1.0)
    tall = most * np.maximum(np.minimum(high, _HIGHEST) * grown, 0.12)
    wide = np.select([conifer, acacia, palm], [0.19, 0.50, 0.26], 0.42 - 0.12 * woods)
    wide = wide * (0.85 + 0.3 * np.modf(chance * 7.0)[0])
    widest = np.select([conifer, acacia, palm], [0.25, 0.58, 0.30], 0.49)
    return tall, np.minimum(most * np.maximum(broad * grown, 0.12) * wide, widest * tall)


@dataclass(frozen=True)
class _Coarse:
    """Climate and slope at the corners of the plots' squares: (plots, _COARSE + 1, _COARSE + 1)."""

    warmth: Floats
    humidity: Floats
    share: Floats
    """of places that have a plant of the layer"""
    slope: Floats
    own: Floats
    """(species, plots, ...) the same as `share` of a planet's own"""
    height_m: Floats
    stands: Floats
    """(3, plots, ...) as stands() has them"""
    near_water: Floats
    """1 where water is so near that some of a planet's own may stand along it, else 0"""

    @classmethod
    def of(
        cls, cells: Ints, level: int, ground: GrowingGround, growing: Growing, layer: Layer, own: OwnSpecies
    ) -> _Coarse:
        """cells: rows (face, i, j)."""
        step = np.arange(_COARSE + 1) / _COARSE
        scale = 2.0 ** (FULL_BITS - level)
        face, i, j = (c[:, None, None] for c in cells.T)
        direction = direction_of(face, (i + step[:, None]) * scale, (j + step) * scale)
        shape, direction = direction.shape[:3], direction.reshape(-1, 3)
        height = ground.height(direction)
        side = float(cell_edge_m(level, ground.radius_m)) / _COARSE
        rise = np.gradient(height.reshape(shape), side, axis=(1, 2))
        climate = growing.climate(ground, direction, height)
        near_water = np.zeros(len(direction))
        if own.along_water:
            near_water[ground.from_water_m(direction) < own.aside_m.max() + _ASIDE_M] = 1.0
        share = growing.shrubs(climate) if layer is SHRUBS else growing.woods(climate)
        return cls(
            climate.warmth.reshape(shape),
            climate.humidity.reshape(shape),
            share.reshape(shape),
            np.hypot(*rise),
            (growing.plants * own.shares(climate)).reshape(len(own), *shape),
            height.reshape(shape),
            stands(direction, ground.radius_m).reshape(3, *shape),
            near_water.reshape(shape),
        )

    @staticmethod
    def between(plot: Ints, u: Floats, v: Floats) -> Callable[[Floats], Floats]:
        """What takes values at the corners to those at places in plots; u, v: 0..1 along them."""
        x, y = u * _COARSE, v * _COARSE
        i, j = np.minimum(x.astype(np.int64), _COARSE - 1), np.minimum(y.astype(np.int64), _COARSE - 1)
        s, t = x - i, y - j
        corner = (plot * (_COARSE + 1) + i) * (_COARSE + 1) + j

        def at(values: Floats) -> Floats:
            flat = values.ravel()
            near, far = flat[corner], flat[corner + (_COARSE + 1)]
            low = near + t * (flat[corner + 1] - near)
            high = far + t * (flat[corner + (_COARSE + 2)] - far)
            return low + s * (high - low)

        return at
