"""For every knob of every component: a view and a value in which it is plain to see, or why there is none.

The golden tests take each picture with and without, and want them to differ: a knob that is missing here fails a test,
so that none can be added without a picture that shows it. `planetfall bench frame.knobs` says what each costs.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from .. import (
    Atmosphere,
    Clouds,
    Composite,
    Cover,
    DebugView,
    Exposure,
    Ocean,
    Orbit,
    Planet,
    Scene,
    Shape,
    Stars,
    Sun,
    Terrain,
    Transform,
    Wind,
)

KNOB_SIZE = (160, 90)
"""Of golden pictures of knobs."""
VISIBLE = 0.01
"""A knob that is meant to be seen changes the picture by at least this mean FLIP: twenty times what passes as equal."""

COMPONENTS: dict[str, type] = {
    "planet": Planet,
    "terrain": Terrain,
    "ocean": Ocean,
    "atmosphere": Atmosphere,
    "clouds": Clouds,
    "cover": Cover,
    "wind": Wind,
    "sun": Sun,
    "stars": Stars,
    "exposure": Exposure,
    "composite": Composite,
    "debug": DebugView,
    "transform": Transform,
    "shape": Shape,
    "orbit": Orbit,
}
"""Tables of a change's key: {"terrain.layers": 4}."""


FEW_CELLS = {"terrain.drainage_cells": 40_000}
"""Rivers that are solved in a moment."""
OF_RIVERS = frozenset(
    f"terrain.{name}"
    for name in (
        "seed", "highest_m", "lowest_m", "layers", "land_share", "continent_size", "plains", "mountains", "hills",
        "roughness", "warp", "humidity", "snow_line_m", "snow_line_pole_m",
    )
)  # fmt: skip
"""Knobs on which rivers hang."""


@dataclasses.dataclass(frozen=True)
class Pair:
    """Two pictures that differ in one knob.

    planet, view: where. off, on: the two values; off None: as the preset has it. both: settings that both pictures
    share. least: mean FLIP between them. least_worst: where a knob moves few pixels (stars, the sun's disc), the FLIP
    of the pixel that differs most, in place of the mean. free: as a plain camera with the view's sun, so that the
    scene's Exposure counts and not the view's fixed one. size: of the golden pictures. clouds: whether the preset
    keeps its own.
    """

    planet: str
    view: str
    on: Any
    off: Any = None
    both: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    least: float = VISIBLE
    least_worst: float = 0.0
    free: bool = False
    size: tuple[int, int] = KNOB_SIZE
    clouds: bool = False

    def changes(self, key: str, value: Any) -> dict[str, Any]:
        """Settings of one of the pictures of the knob `key`: {"table.field": value}."""
        few = FEW_CELLS if OF_RIVERS & {key, *self.both} else {}
        return {**few, **self.both} if value is None else {**few, **self.both, key: value}


def component(scene: Scene, table: str) -> Any:
    """The component that a change's table names, of the planet or of the scene."""
    kind = COMPONENTS[table]
    holder = scene.planet if scene.planet.has(kind) else scene.environment
    return holder[kind]


@contextmanager
def changed(scene: Scene, changes: Mapping[str, Any]) -> Iterator[None]:
    """The scene with these settings, put back afterwards."""
    before: list[tuple[Any, str, Any]] = []
    try:
        for key, value in changes.items():
            table, field = key.split(".")
            target = component(scene, table)
            before.append((target, field, getattr(target, field)))
            setattr(target, field, value)
        yield
    finally:
        for target, field, value in reversed(before):
            setattr(target, field, value)


NO_BLOOM = {"composite.bloom": 0.0}
HAZE = {
    "atmosphere.mie_extinction_per_m": (4.4e-5, 4.4e-5, 4.4e-5),
    "atmosphere.mie_scattering_per_m": (4.0e-5, 4.0e-5, 4.0e-5),
}
FOG = {"clouds.density_model": "uniform", "clouds.base_m": 1200.0, "clouds.extinction_per_m": 2e-3}
"""A layer that is alike all over."""
ICE = {
    "clouds.kind": "cirrus", "clouds.base_m": 8000.0, "clouds.top_m": 9500.0, "clouds.extinction_per_m": 1e-3,
    "clouds.coverage": 1.0, "clouds.layers": (),
}  # fmt: skip
"""Nothing but cirrus."""
OZONE = {"atmosphere.absorption_per_m": (3.0e-6, 1.0e-5, 4.0e-7)}

PAIRS: dict[str, Pair] = {
    "planet.radius_m": Pair("earth", "orbit", 5.8e6),
    "terrain.seed": Pair("earth", "orbit", 2),
    "terrain.highest_m": Pair("small", "terminator", 1200.0),
    "terrain.lowest_m": Pair("earth", "coast", -4000.0),
    "terrain.layers": Pair("earth", "terminator", 4),
    "terrain.land_share": Pair("earth", "orbit", 0.6),
    "terrain.continent_size": Pair("earth", "orbit", 2.0),
    "terrain.plains": Pair("earth", "orbit", 0.0),
    "terrain.mountains": Pair("earth", "terminator", 0.0),
    "terrain.hills": Pair("earth", "orbit", 1.0),
    "terrain.roughness": Pair("earth", "near", 3.0),
    "terrain.warp": Pair("earth", "orbit", 0.0),
    "terrain.craters": Pair("moon", "terminator", 1.0, off=0.0),
    "terrain.crater_largest_m": Pair("moon", "terminator", 5000.0, both={"terrain.craters": 0.8}),
    "terrain.height_map": Pair("moon", "terminator", ""),
    "terrain.height_map_range_m": Pair("moon", "terminator", (-21000.0, 24000.0)),
    "terrain.height_map_blend": Pair("moon", "terminator", 1.0),
    "terrain.height_map_detail": Pair("mars", "valley", 0.0),
    "terrain.color_map": Pair("moon", "space", ""),
    "terrain.color_map_strength": Pair("moon", "space", 0.0, off=1.0),
    "terrain.rivers": Pair("earth", "river", 0.0),
    "terrain.erosion": Pair("earth", "ranges", 0.0),
    "terrain.banks": Pair("earth", "river", 0.0),
    "terrain.spray": Pair("earth", "waterfall", 0.0),
    "terrain.drainage_cells": Pair("earth", "river", 40_000),
    "terrain.rock_albedo": Pair("earth", "high", (0.3, 0.1, 0.1)),
    "terrain.strata_albedo": Pair("small", "near", (0.5, 0.1, 0.1)),
    "terrain.strata": Pair("small", "near", 0.0),
    "terrain.strata_m": Pair("small", "near", 7.0),
    "terrain.dry_albedo": Pair("earth", "orbit", (0.3, 0.1, 0.05)),
    "terrain.sand_albedo": Pair("earth", "beach", (0.1, 0.1, 0.15)),
    "terrain.snow_albedo": Pair("earth", "ground", (0.3, 0.3, 0.6)),
    "terrain.grass_albedo": Pair("earth", "near", (0.12, 0.04, 0.1)),
    "terrain.forest_albedo": Pair("earth", "valley", (0.12, 0.04, 0.1)),
    "terrain.tundra_albedo": Pair("earth", "ground", (0.12, 0.04, 0.1)),
    "terrain.plants": Pair("earth", "orbit", 0.0),
    "terrain.humidity": Pair("earth", "orbit", 1.0),
    "terrain.rock_slope_deg": Pair("earth", "near", 5.0),
    "terrain.beach_height_m": Pair("earth", "coast", 40.0),
    "terrain.beach_share": Pair("earth", "delta", 0.0),
    "terrain.snow_line_m": Pair("earth", "orbit", 0.0),
    "terrain.snow_line_pole_m": Pair("earth", "space", -5000.0),
    "terrain.snow_slope_deg": Pair("earth", "high", 5.0),
    "terrain.season": Pair("woods", "treeline", 0.0),
    "terrain.variation": Pair("earth", "near", 0.0),
    "terrain.grain": Pair("earth", "ground", 4.0, off=0.0),
    "terrain.clutter": Pair("earth", "ground", 0.0, off=1.0),
    "terrain.dust_law": Pair("moon", "space", 0.0, off=1.0),
    "terrain.shadows": Pair("earth", "sunset", False),
    "terrain.occlusion": Pair("earth", "dusk", False, both={"terrain.roughness": 3.0}),
    "ocean.sea_level_m": Pair("earth", "coast", 20.0),
    "ocean.wind_speed_m_s": Pair("earth", "sea", 16.0),
    "ocean.wind_direction_deg": Pair("earth", "sea", 130.0),
    "ocean.wind_at": Pair("earth", "sea", (40.0, -10.0)),
    "ocean.fetch_m": Pair("earth", "sea", 2000.0),
    "ocean.wave_count": Pair("earth", "sea", 4),
    "ocean.wave_seed": Pair("earth", "sea", 2),
    "ocean.choppiness": Pair("earth", "sea", 2.0, off=0.0),
    "ocean.swell_height_m": Pair("earth", "sea", 6.0),
    "ocean.swell_period_s": Pair("earth", "sea", 20.0, both={"ocean.swell_height_m": 4.0}),
    "ocean.swell_direction_deg": Pair("earth", "sea", 155.0, both={"ocean.swell_height_m": 4.0}),
    "ocean.gravity_m_s2": Pair("earth", "sea", 1.6),
    "ocean.waves": Pair("earth", "sea", ({"amplitude_m": 1.2, "wavelength_m": 60.0, "steepness": 4.0},)),
    "ocean.absorption_per_m": Pair("earth", "coast", (0.03, 0.01, 0.005)),
    "ocean.scattering_per_m": Pair("earth", "coast", (0.01, 0.02, 0.01)),
    "cover.density": Pair("woods", "canopy", 0.0),
    "cover.spacing_m": Pair("woods", "canopy", 14.0),
    "cover.height_m": Pair("woods", "canopy", 30.0),
    "cover.steepest_deg": Pair("woods", "canopy", 2.0),
    "cover.savanna": Pair("woods", "savanna", 0.0),
    "cover.variety": Pair("woods", "canopy", 0.0),
    "cover.riparian": Pair("woods", "river", 0.0, off=1.0),
    "cover.palms": Pair("woods", "palms", 0.0),
    "cover.dead": Pair("woods", "forest", 0.5),
    "cover.shrubs": Pair("woods", "forest", 0.0, off=2.0),
    "cover.shrub_spacing_m": Pair("woods", "forest", 12.0, off=2.5),
    "cover.shrub_height_m": Pair("woods", "forest", 0.3, off=4.0),
    "cover.season": Pair("woods", "woodland", 0.79),
    "cover.snow": Pair("woods", "treeline", 0.0, off=1.0, both={"cover.season": 0.0}),
    "cover.grass": Pair("woods", "meadow", 0.0),
    "cover.grass_m": Pair("woods", "meadow", 1.0),
    "cover.flowers": Pair("woods", "meadow", 0.0, off=1.0, least=0.0, least_worst=0.25),
    "cover.broadleaf_albedo": Pair("woods", "canopy", (0.12, 0.04, 0.1)),
    "cover.conifer_albedo": Pair("woods", "treeline", (0.12, 0.04, 0.1)),
    "cover.species": Pair("earth", "desert", ()),
    "cover.bark_albedo": Pair("woods", "forest", (0.6, 0.5, 0.5)),
    "wind.speed_m_s": Pair("woods", "meadow", 0.0, off=25.0),
    "wind.direction_deg": Pair("woods", "meadow", 250.0, both={"wind.speed_m_s": 20.0}),
    "wind.at": Pair("woods", "meadow", (40.0, -60.0), both={"wind.speed_m_s": 20.0}),
    "wind.gusts": Pair("woods", "meadow", 0.0, off=1.0, both={"wind.speed_m_s": 20.0}),
    "ocean.bed_albedo": Pair("earth", "beach", (0.1, 0.05, 0.05)),
    "ocean.roughness": Pair("earth", "glitter", 0.3),
    "ocean.ice_latitude_deg": Pair("earth", "orbit", 20.0),
    "ocean.ice_albedo": Pair("earth", "orbit", (0.6, 0.3, 0.3), both={"ocean.ice_latitude_deg": 20.0}),
    "ocean.refractive_index": Pair("earth", "sea", 1.1, least=0.0, least_worst=0.1),
    "ocean.foam": Pair("earth", "sea", 0.0, off=1.0, both={"ocean.wind_speed_m_s": 18.0}),
    "ocean.foam_albedo": Pair("earth", "beach", (0.6, 0.2, 0.1), both={"ocean.surf_m": 0.6}),
    "ocean.surf_m": Pair("earth", "beach", 0.0, off=0.6),
    "ocean.caustics": Pair("earth", "shallows", 0.0, off=2.0, least=0.0, least_worst=0.05, size=(320, 180)),
    "ocean.bed_detail": Pair("earth", "shallows", 0.0, off=2.0),
    "ocean.glow": Pair("earth", "coast", (0.4, 0.05, 0.0)),
    "ocean.crust": Pair("earth", "coast", 0.7, off=0.0, both={"ocean.glow": (0.4, 0.05, 0.0)}),
    "atmosphere.thickness_m": Pair("earth", "limb", 15e3, both=NO_BLOOM),
    "atmosphere.rayleigh_scattering_per_m": Pair("earth", "high", (0.0, 0.0, 0.0)),
    "atmosphere.rayleigh_scale_height_m": Pair("earth", "high", 2000.0),
    "atmosphere.mie_scattering_per_m": Pair(
        "earth",
        "noon",
        (4.0e-5, 4.0e-5, 4.0e-5),
        off=(0.0, 0.0, 0.0),
        both={"atmosphere.mie_extinction_per_m": (4.4e-5, 4.4e-5, 4.4e-5)},
    ),
    "atmosphere.mie_extinction_per_m": Pair("earth", "noon", (8.0e-5, 8.0e-5, 8.0e-5)),
    "atmosphere.mie_scale_height_m": Pair("earth", "high", 8000.0, both=HAZE),
    "atmosphere.mie_asymmetry": Pair("earth", "sunset", 0.0, both=HAZE),
    "atmosphere.absorption_per_m": Pair("earth", "dusk", (0.0, 0.0, 0.0)),
    "atmosphere.absorption_center_m": Pair("earth", "dusk", 5000.0, both=OZONE),
    "atmosphere.absorption_half_width_m": Pair("earth", "dusk", 3000.0, both=OZONE),
    "atmosphere.ground_albedo": Pair("earth", "noon", (0.9, 0.9, 0.9)),
    "atmosphere.night_light": Pair("earth", "night", 100.0),
    "clouds.base_m": Pair("earth", "sea", 300.0, clouds=True),
    "clouds.top_m": Pair("earth", "sea", 2000.0, clouds=True),
    "clouds.extinction_per_m": Pair("earth", "fair", 0.001, clouds=True),
    "clouds.albedo": Pair("earth", "orbit", 0.9, clouds=True),
    "clouds.asymmetry": Pair("earth", "glint", 0.2, clouds=True),
    "clouds.density_model": Pair("earth", "coast", "uniform", both={"clouds.extinction_per_m": 1e-3}, clouds=True),
    "clouds.kind": Pair("earth", "fair", "cirrus", clouds=True),
    "clouds.relief": Pair("earth", "cloud_sea", 1.0, off=0.0, clouds=True),
    "clouds.hooks": Pair("earth", "ground", 1.0, off=0.0, both=ICE, clouds=True),
    "clouds.veil": Pair("earth", "ground", 2.0, off=0.0, both=ICE, clouds=True),
    "clouds.bend": Pair("earth", "ground", 2.0, off=0.0, both=ICE, clouds=True),
    "clouds.height_profile": Pair("earth", "sea", "none", both=FOG, clouds=True),
    "clouds.coverage": Pair("earth", "orbit", 0.0, clouds=True),
    "clouds.wind_speed_m_s": Pair("earth", "glint", 300.0, clouds=True),
    "clouds.shadows": Pair("earth", "cloud_shadows", False, clouds=True),
    "clouds.skylight": Pair("earth", "overcast", False, clouds=True),
    "clouds.mirrored": Pair("earth", "sea", False, clouds=True),
    "clouds.shafts": Pair("earth", "shafts", False, clouds=True),
    "clouds.tile_width_m": Pair("earth", "orbit", 2e5, both={"clouds.method": "paper_2018"}, clouds=True),
    "clouds.thickness_spread": Pair("earth", "orbit", 0.0, clouds=True),
    "clouds.aggregation": Pair("earth", "orbit", 0.0, clouds=True),
    "clouds.weather_seed": Pair("earth", "orbit", 5, clouds=True),
    "clouds.layers": Pair("earth", "near", (), clouds=True),
    "sun.irradiance": Pair("earth", "orbit", (1.5, 1.0, 0.6)),
    "sun.angular_radius_rad": Pair("earth", "limb", 0.03, both=NO_BLOOM, least=0.0, least_worst=0.3),
    "stars.density": Pair("earth", "night", 0.0, least=0.0, least_worst=0.3),
    "stars.brightness": Pair("earth", "night", 30.0, least=0.0, least_worst=0.3),
    "stars.seed": Pair("earth", "night", 2, least=0.0, least_worst=0.3),
    "exposure.mode": Pair("earth", "orbit", "auto", off="fixed", both={"exposure.ev100": 15.5}, free=True),
    "exposure.ev100": Pair("earth", "orbit", 12.0, off=14.0, both={"exposure.mode": "fixed"}, free=True),
    "exposure.min_ev100": Pair("earth", "orbit", 16.0, free=True),
    "exposure.max_ev100": Pair("earth", "orbit", 10.0, free=True),
    "exposure.compensation_ev": Pair("earth", "orbit", 1.0, free=True),
    "composite.antialiasing": Pair("earth", "valley", "temporal", off="none"),
    "composite.tone_map": Pair("earth", "orbit", "aces"),
    "composite.bloom": Pair("earth", "limb", 0.0),
    "debug.view": Pair("earth", "near", "normals"),
}

NOT_IN_A_PICTURE: dict[str, str] = {
    "cover.felled": "names of single trees; see test_felling",
    "cover.mask": "a function; see test_cover_mask",
    "terrain.height_map_most_mb": "of tiles of elevation, which no preset has; see test_real_terrain",
    "terrain.vector_map": "a file of water and forests, which no preset has; see test_vector_water",
    "terrain.color_map_most_mb": "of tiles of pictures, which no preset has; see test_real_colors",
    "terrain.color_map_unlit": "of tiles of pictures, which no preset has; see test_color_unlit",
    "terrain.backend": "the same ground cut differently, meant to look alike; see test_tiles",
    "terrain.method": "the source's ground beside ours; see test_paper_grid",
    "debug.freeze": "a still camera sees the same; see test_tiles",
    "atmosphere.method": "the same air by another method, meant to look alike; see test_air_paper",
    "atmosphere.wavelengths_nm": "says what the three numbers belong to; see test_wavelengths",
    "clouds.method": "the same clouds by another method; see test_cloud_paper",
    "clouds.weather_map": "needs a file; see test_weather_map",
    "composite.dither": "less than one step of 8 bits: has a test of its own",
    "ocean.method": "the same waves by another method; see test_waves",
    "ocean.printed_arcs": "waves where a driver's arccosine has them, up to a kilometre off; see test_printed_sea",
    "planet.position_m": "one planet is drawn around its own centre",
    "planet.rotation_period_s": "moves an epoch sun; see test_light",
    "planet.axial_tilt_deg": "moves an epoch sun; see test_light",
    "planet.orbital_period_s": "moves an epoch sun; see test_light",
    "sun.direction": "views bring their own place of the sun; see test_light",
    "sun.elevation_deg": "views bring their own place of the sun; see test_light",
    "sun.azimuth_deg": "views bring their own place of the sun; see test_light",
    "sun.latitude_deg": "views bring their own place of the sun; see test_light",
    "sun.longitude_deg": "views bring their own place of the sun; see test_light",
    "sun.epoch_s": "views bring their own place of the sun; see test_light",
    "sun.calendar": "moves an epoch sun; see test_light",
    "exposure.brighter_s": "a settled picture has no past; see test_composite",
    "exposure.darker_s": "a settled picture has no past; see test_composite",
    **{
        f"orbit.{name}": "a planet has no companion; golden pictures several/* and test_several_planets have"
        for name in (
            "distance_m",
            "period_s",
            "inclination_deg",
            "node_deg",
            "phase_deg",
            "position_m",
            "locked",
        )
    },
    "transform.position_m": "presets have no objects of a game's; see test_props",
    "transform.orientation": "presets have no objects of a game's; see test_props",
    "transform.planet": "presets have no objects of a game's; see test_props",
    "shape.form": "presets have no objects of a game's; see test_props",
    "shape.size_m": "presets have no objects of a game's; see test_props",
    "shape.color": "presets have no objects of a game's; see test_props",
    "shape.roughness": "presets have no objects of a game's; see test_props",
}

QUALITY_PAIRS: dict[str, tuple[Any, Any]] = {
    "terrain.edge_px": (15.0, 2.0),
    "terrain.quads": (16, 64),
    "terrain.decimation": (0, 3),
    "terrain.min_spacing_m": (0.12, 30.0),
}
"""Quality knobs whose two values give different triangles; seen in the wireframe of the view
QUALITY_VIEW."""

TILE_PAIRS: dict[str, tuple[Any, Any]] = {
    "terrain.error_px": (2.5, 0.25),
    "terrain.tile_quads": (16, 32),
    "terrain.edge_px": (15.0, 3.0),
}
"""Likewise, with backend quadtree. Slots and time for tiles change no settled picture: test_tiles has them."""

SHADE_PAIRS: dict[str, tuple[str, int, int]] = {
    "terrain.shade_every": ("valley", 1, 4),
    "ocean.shade_every": ("sea", 1, 4),
    "clouds.picture_px": ("clouds", 1, 2),
}
"""Quality knobs of shading: a view of Earth, and two values that give other pictures of the same triangles."""

QUALITY_VIEW = ("earth", "ground")
