"""Clouds: layers of droplets between two heights, all over a planet."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Self

from ._knob import knob

__all__ = ["MOST_CLOUD_LAYERS", "CloudLayer", "Clouds"]

MOST_CLOUD_LAYERS = 4
"""Layers of one planet, the component's own among them: what the shaders' block has room for."""


KIND_LAYERS: dict[str, dict[str, float]] = {
    "humilis": {"base_m": 800.0, "top_m": 1500.0, "extinction_per_m": 0.05, "coverage": 0.35},
    "congestus": {"base_m": 800.0, "top_m": 5000.0, "extinction_per_m": 0.06, "coverage": 0.35},
    "cumulonimbus": {"base_m": 600.0, "top_m": 12000.0, "extinction_per_m": 0.03, "coverage": 0.25},
    "stratocumulus": {"base_m": 700.0, "top_m": 1200.0, "extinction_per_m": 0.04, "coverage": 0.8},
    "stratus": {"base_m": 200.0, "top_m": 700.0, "extinction_per_m": 0.03, "coverage": 0.9},
    "altocumulus": {"base_m": 4000.0, "top_m": 4400.0, "extinction_per_m": 0.02, "coverage": 0.5},
}
"""Heights (World Meteorological Organization 2017, middle latitudes), extinction and cover of each kind by name."""


@dataclass
class CloudLayer:
    """One shell of cloud from base_m to top_m above the reference sphere.

    Droplets take extinction_per_m of the light in a metre where the cloud is densest, and scatter the share `albedo` of
    that by Henyey and Greenstein's phase function; all wavelengths alike.
    """

    base_m: float = knob(1500.0, 0.0, 1e8, "m", "Height of the lower side above the reference sphere", log=True)
    top_m: float = knob(
        4000.0, 1e-3, 1e8, "m", "Height of the upper side; inside the air, if the planet has any", log=True
    )
    extinction_per_m: float = knob(
        0.02, 0.0, 10.0, "1/m", "Share of light that the densest cloud takes away in a metre", log=True, group="light"
    )
    albedo: float = knob(
        1.0,
        0.0,
        1.0,
        "",
        "Share of it that is scattered; the rest is swallowed. Water: above 0.9999",
        group="light",
    )
    asymmetry: float = knob(
        0.85,
        -0.99,
        0.99,
        "",
        "Where droplets scatter to (g of Henyey and Greenstein): 0 all around, towards 1 ahead, below 0 back",
        group="light",
    )
    density_model: str = knob(
        "weather",
        help="Where there is cloud: weather, or uniform, the whole shell alike: fog, and tests",
        choices=("weather", "uniform"),
        group="shape",
    )
    height_profile: str = knob(
        "parabola",
        help="How cloud thins out towards base and top: as a parabola, or none",
        choices=("parabola", "none"),
        group="shape",
    )
    coverage: float = knob(
        0.6, 0.0, 1.0, "", "Mean share of the sky under cloud; of a uniform layer only 0 counts: it isn't there",
        group="shape",
    )  # fmt: skip
    relief: float = knob(
        1.0, 0.0, 2.0, "", "Of cumulus: billows on its surface; 0 is smooth, 1 cauliflower", group="shape"
    )
    wind_speed_m_s: float = knob(
        12.0, 0.0, 500.0, "m/s", "Speed at which weather drifts eastwards at the equator", group="weather"
    )
    kind: str = knob(
        "auto",
        help="What the weather's clouds are: cumulus, billows and sheets of water as the weather has them; cirrus, "
        "fibres and veils of ice; auto: cirrus where the whole layer's optical depth is below 5; or one kind of water "
        "by its name (CloudLayer.of has heights for each)",
        choices=("auto", "cumulus", "cirrus", *KIND_LAYERS),
        aliases=("water", "ice"),
        group="shape",
    )
    hooks: float = knob(
        0.5, 0.0, 1.0, "", "Of cirrus: share of its ice in fibres that hang from tufts and curve (mares' tails); the "
        "rest is in straight ones", group="cirrus",
    )  # fmt: skip
    veil: float = knob(
        0.25, 0.0, 2.0, "", "Of cirrus: how much thin ice lies between and around its fibres", group="cirrus"
    )
    bend: float = knob(
        1.0, 0.0, 2.0, "", "Of cirrus: how far fibres bend over hundreds of kilometres; 1: by up to 33 degrees to "
        "either side", group="cirrus",
    )  # fmt: skip

    @classmethod
    def of(cls, kind: str, **fields: object) -> Self:
        """A layer of a kind, at the heights and of the extinction that such clouds have; fields: what is different."""
        return replace(cls(), **{**KIND_LAYERS.get(kind, {}), "kind": kind, **fields})


@dataclass
class Clouds(CloudLayer):
    """The clouds of a planet: its own fields are the first layer, `layers` has further ones.

    Layers may overlap; where they do, their droplets are in the same air. At most four layers in all.
    """

    layers: tuple[CloudLayer, ...] = knob((), help="Further layers, each with the fields of the first")
    weather_seed: int = knob(0, 0, 2**31 - 1, help="Which of the many weathers", group="weather")
    weather_map: str = knob(
        "",
        help="Cover all around, 0 clear to 1 covered, in place of the made weather: a PNG, EXR, TIFF or .npy, "
        "equirectangular, or a folder of six faces",
        group="weather",
        widget="path",
    )
    thickness_spread: float = knob(
        0.0, 0.0, 1.5, "", "How far optical thickness of the weather's clouds of water is spread over 10 km and more: "
        "about the standard deviation of its natural logarithm; 0: clouds of one weather are alike", group="weather",
    )  # fmt: skip
    aggregation: float = knob(
        0.0, 0.0, 1.0, "", "How far broken convection gathers into fields with clear sky between, as seen from "
        "orbit; 0: crumbs nearly everywhere. No matter for weather_map", group="weather",
    )  # fmt: skip
    shadows: bool = knob(
        True, help="Whether clouds keep the sun's beam from land, sea and objects below them", group="light"
    )
    skylight: bool = knob(
        True, help="Whether the sky's light on land and objects is that of a sky with its clouds", group="light"
    )
    mirrored: bool = knob(True, help="Whether the sea mirrors clouds", group="light")
    shafts: bool = knob(True, help="Whether clouds cast shadows into the air: shafts of light", group="light")
    method: str = knob(
        "ours",
        help="How clouds are made and marched through together with the air: ours, or as printed (Michelic 2018; with "
        "others 2019)",
        choices=("ours", "paper_2018", "paper_2019"),
    )
    tile_width_m: float = knob(
        16e3, 100.0, 1e7, "m", "Width of the volume that the printed methods repeat over the planet", log=True,
        group="shape",
    )  # fmt: skip
