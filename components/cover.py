"""Cover: trees on the ground, where the climate lets them grow."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ._knob import Vec3, knob
from .mask import mask_problem

__all__ = ["MOST_SPECIES", "Cover", "CoverSpecies"]

MOST_SPECIES = 12
"""Of a planet's own."""

FORMS = ("broadleaf", "conifer", "flat", "palm", "column", "shrub", "rosette")
"""Of the two last, plants have their own places, `Cover.shrub_spacing_m` apart; the others stand where trees do."""


@dataclass
class CoverSpecies:
    """A plant that a planet has besides those that Cover knows: how it looks, and in which climate it grows.

    Warmth is 0 at the snow line and 1 at the equator's sea, humidity 0.3 in a desert and 0.7 in a forest.
    """

    name: str = knob("", help="What a game calls it by")
    form: str = knob(
        "broadleaf",
        help="Its shape: a crown of lobes, a cone of whorls, a flat top, fronds on a stem, a ribbed column with arms; "
        "or near the ground a shrub, or a rosette of fronds",
        choices=FORMS,
    )
    share: float = knob(
        0.3, 0.0, 1.0, "", "Share of the places that have one where its climate is; 0: none", cost="plants to draw"
    )
    height_m: float = knob(10.0, 0.1, 100.0, "m", "Of a grown one", log=True)
    crown: float = knob(
        0.35, 0.05, 0.9, "", "Radius of the crown over the height; above 0.6 of shrubs and rosettes alone"
    )
    leaf_density: float = knob(1.0, 0.1, 1.5, "", "How closed the crown is; 1: as that of other trees")
    albedo: Vec3 = knob(
        (0.078, 0.138, 0.040), 0.0, 1.0, "", "Colour of its leaves, of a column's skin", group="colours", widget="color"
    )
    autumn_albedo: Vec3 = knob(
        (0.33, 0.17, 0.03), 0.0, 1.0, "", "Colour of leaves that have turned", group="colours", widget="color"
    )
    translucency: float = knob(
        0.45, 0.0, 0.9, "", "Light that comes through its leaves over what they throw back", group="colours"
    )
    sheds: bool = knob(False, help="Whether its leaves turn and fall outside the tropics")
    coldest: float = knob(0.0, 0.0, 2.0, "", "Warmth from which on it grows; 0: up to the snow line", group="climate")
    warmest: float = knob(2.0, 0.0, 2.0, "", "Warmth up to which it grows", group="climate")
    driest: float = knob(0.5, 0.0, 2.0, "", "Humidity from which on it grows; 0: any", group="climate")
    wettest: float = knob(2.0, 0.0, 2.0, "", "Humidity up to which it grows", group="climate")

    waterside_m: float = knob(
        0.0,
        0.0,
        100.0,
        "m",
        "Distance from rivers and lakes, along bends roughly, within which it grows, and in shallows; 0: anywhere",
        group="climate",
    )
    shore_m: float = knob(
        0.0,
        0.0,
        10.0,
        "m",
        "Depth of the sea down to which it stands, on flat shores alone, as mangroves do; 0: on land",
        group="climate",
    )

    @property
    def low(self) -> bool:
        """Whether it has the places of shrubs."""
        return self.form in FORMS[5:]


@dataclass
class Cover:
    """Trees that stand on the ground as solids, near the camera; farther away the ground's own colours go on.

    They grow where Terrain has forest: broadleaf trees where it is warm, conifers towards the tree line; a planet's own
    `species` where their climate is, also where Terrain has no forest. Albedos are colours of a leaf, linear sRGB as
    they show in sunlight; a crown is darker, because leaves shade one another.
    """

    density: float = knob(
        1.0, 0.0, 1.5, "", "Share of the places that may have a tree in a forest; 0: none", cost="trees to draw"
    )
    spacing_m: float = knob(
        7.0, 2.0, 100.0, "m", "Mean distance of the places that may have one", cost="trees, with its square", log=True
    )
    height_m: float = knob(15.0, 0.5, 100.0, "m", "Of a grown broadleaf tree; conifers grow a third higher", log=True)
    steepest_deg: float = knob(38.0, 0.0, 89.0, "deg", "Slope above which none stands")
    savanna: float = knob(
        0.12, 0.0, 1.0, "", "Share of the places that have a tree where it is warm and too dry for a forest; 0: none"
    )
    variety: float = knob(
        1.0, 0.0, 1.0, "", "How much trees of a forest differ in size and in their greens, one by one and in stands of "
        "some 100 m, with glades between; 0: not in stands, and few in size",
    )  # fmt: skip
    riparian: float = knob(
        0.8,
        0.0,
        1.0,
        "",
        "How much wetter the ground counts within 100 m of rivers and lakes, where gallery woods stand",
    )
    palms: float = knob(0.7, 0.0, 1.0, "", "Share of the trees along warm coasts that are palms")
    dead: float = knob(0.015, 0.0, 1.0, "", "Share of the trees that are dead and still stand")
    shrubs: float = knob(
        1.0, 0.0, 2.0, "", "Share of the places that may have a shrub where they grow well; 0: none", cost="to draw"
    )
    shrub_spacing_m: float = knob(4.0, 1.0, 100.0, "m", "Mean distance of the places that may have a shrub", log=True)
    shrub_height_m: float = knob(1.4, 0.1, 10.0, "m", "Of a grown shrub", log=True)
    season: float = knob(
        0.5, 0.0, 1.0, "", "Time of year of the trees alone, instead of Terrain.season: 0 and 1 midwinter of the "
        "northern half, 0.8 autumn; 0.5: as the ground's. Broadleaves keep their leaves in the tropics",
    )  # fmt: skip
    snow: float = knob(
        0.6, 0.0, 1.0, "", "Share of what faces up on trees that snow lies on, in winter where it is cold, all year "
        "near the snow line; 0: none",
    )  # fmt: skip
    grass: float = knob(1.0, 0.0, 1.0, "", "Share of the ground where grass grows that bears it; 0: none", cost="light")
    grass_m: float = knob(0.3, 0.05, 2.0, "m", "Height of the highest grass", log=True)
    flowers: float = knob(0.25, 0.0, 1.0, "", "How many flowers stand in grass; 0: none")
    broadleaf_albedo: Vec3 = knob(
        (0.078, 0.138, 0.040), 0.0, 1.0, "", "Colour of the leaves of broadleaf trees", group="colours", widget="color"
    )
    conifer_albedo: Vec3 = knob(
        (0.05, 0.091, 0.038), 0.0, 1.0, "", "The same of conifers' needles", group="colours", widget="color"
    )
    bark_albedo: Vec3 = knob((0.10, 0.075, 0.055), 0.0, 1.0, "", "Colour of trunks", group="colours", widget="color")
    species: tuple[CoverSpecies, ...] = knob((), 0, MOST_SPECIES, "", "Plants of the planet's own")
    felled: tuple[tuple[int, int, int, int, int], ...] = knob(
        (), 0, 2**31 - 1, "", "Trees that a game has cut down, by their names; CoverSampler.fell() adds to them"
    )
    mask: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = knob(
        None,
        help="A game's function: unit directions (N, 3) to the share (N,), 0 to 1, of the trees that may grow there",
        check=mask_problem,
    )
