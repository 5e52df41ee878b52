"""The golden pictures: what each one shows, and the studio that takes them.

A picture is a named view of a planet at a small size and quality `medium` or `paper`, settled, at the view's fixed
exposure; a picture of a knob is one with some settings changed. `GOLDENS` lists those whose files lie in tests/golden/;
`golden_tool` refreshes the files, `test_golden` compares against them.
"""

from __future__ import annotations

import dataclasses
from collections import OrderedDict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from golden_compare import Limit
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.knobs import FEW_CELLS, HAZE, KNOB_SIZE, QUALITY_VIEW, SHADE_PAIRS, Pair, changed
from planetfall.benchmarks.scenes import preset_scene
from planetfall.components.clouds import KIND_LAYERS
from planetfall.systems.terrain.rivers.source import source

FOLDER = Path(__file__).resolve().parents[1] / "golden"
VIEW_SIZE = (320, 180)
QUALITY = "medium"
ANTIALIASING = "none"
"""One sample in the middle of each pixel: a hole or a crack of a pixel isn't averaged away. Pictures of anti-aliasing
itself say otherwise."""

SCENES = {name: str(FOLDER.parent / "data" / f"{name}.toml") for name in ("props", "pictures")}
"""Scene files of pictures that are not of a preset."""

Pixels = NDArray[np.uint8]


@dataclasses.dataclass(frozen=True)
class Picture:
    """One picture.

    name: also the file's, below tests/golden. changes: {"table.field": value}, undone afterwards. overrides: quality
    keys; each set of them needs a renderer of its own. free: as a plain camera with the view's sun, so that the scene's
    Exposure counts and not the view's fixed one; turned_deg then turns it to the right. sun_higher_deg: raises the sun.
    clouds: whether the planet keeps its own; without, ground and sea are seen as they are. later_s: than the view.
    quality: by name. allowed: limit of this picture in place of the common one.
    """

    name: str
    planet: str
    view: str
    size: tuple[int, int] = VIEW_SIZE
    changes: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    overrides: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    free: bool = False
    turned_deg: float = 0.0
    sun_higher_deg: float = 0.0
    clouds: bool = False
    later_s: float = 0.0
    quality: str = QUALITY
    allowed: Limit | None = None

    @property
    def path(self) -> Path:
        return FOLDER / f"{self.name}.png"

    def settings(self) -> dict[str, Any]:
        """What the PNG carries beside the pixels: enough to take the picture again."""
        return {
            "planet": self.planet,
            "view": self.view,
            "size": list(self.size),
            "quality": self.quality,
            "changes": dict(self.changes),
            "overrides": dict(self.overrides),
            "exposure": "scene" if self.free else "view",
            **({"clouds": True} if self.clouds else {}),
            **({"later_s": self.later_s} if self.later_s else {}),
        }


MACHINE_BOUND = {
    "wireframe": Limit(mean=0.3, p999=1.0),
    "snap_overlay": Limit(mean=0.3, p999=1.0),
    "error_px": Limit(mean=0.003, p999=0.03),
}
"""Debug views that show rounding itself. Lines of one pixel against the ground just below them: 0.16 was measured where
fragments write depth, and 0.8 is what other debug views differ by. Errors of a thousandth of a pixel: 0.001."""


CLOUD_VIEWS = ("clouds", "fair", "overcast", "cloud_sea", "shafts", "cloud_shadows", "day_edge")
"""Those that are named after clouds; all others are taken without."""
COVER_VIEWS = (
    "lakeside", "forest", "meadow", "savanna", "desert", "palms", "treeline", "canopy", "grove", "woodland",
    "mangroves",
)  # fmt: skip
SMALL_VIEWS = ("waterfall", "canyon")
"""Those that show enough at half the size."""


def cloud_picture(name: str, view: str, changes: Mapping[str, Any] | None = None, **parts: Any) -> Picture:
    """A view of earth with its clouds."""
    return Picture(f"clouds/{name}", "earth", view, changes=changes or {}, clouds=True, **parts)


def knob_picture(name: str, planet: str, view: str, changes: Mapping[str, Any], free: bool = False) -> Picture:
    """A small picture with settings changed."""
    return Picture(f"knobs/{name}", planet, view, KNOB_SIZE, changes, free=free)


def debug_picture(name: str) -> Picture:
    """A debug view. Those of triangles and of surfaces need pixels or water to show anything."""
    fine = name in ("wireframe", "snap_overlay")
    view = (
        "coast"
        if name in ("surface", "tiles")
        else "ground"
        if name == "lod"
        else "sea"
        if name.startswith("cloud_")
        else "near"
    )
    size = VIEW_SIZE if fine else KNOB_SIZE
    return Picture(
        f"knobs/debug_{name}", "earth", view, size, {"debug.view": name}, allowed=MACHINE_BOUND.get(name),
        clouds=name.startswith("cloud_"),
    )  # fmt: skip


ONE_WAVE = {
    "rings": {"origin": (37.664, 140.624), "amplitude_m": 3.0, "wavelength_m": 150.0, "steepness": 1.0},
    "straight": {"origin": (-52.316, 140.602), "amplitude_m": 3.0, "wavelength_m": 150.0, "steepness": 1.0},
}
"""A wave whose origin is in the picture of coast, and one that has come a quarter turn."""
CALM = {"ocean.wind_speed_m_s": 0.0, "ocean.swell_height_m": 0.0}

OTHER_PLANETS = ("moon", "mars", "asteroid", "small", "hazy")
AIRY_PLANETS = ("mars", "small", "hazy")
DEBUG_VIEWS = (
    "normals",
    "depth",
    "distance",
    "surface",
    "lod",
    "hdr",
    "wireframe",
    "error_px",
    "snap_overlay",
    "holes",
    "tiles",
    "cloud_tiles",
    "cloud_steps",
)

VIEW_PICTURES: tuple[Picture, ...] = (
    *(
        Picture(
            f"earth/{view}",
            "earth",
            view,
            KNOB_SIZE if view in SMALL_VIEWS else VIEW_SIZE,
            clouds=view in CLOUD_VIEWS,
        )
        for view in pf.views("earth")
        if view not in COVER_VIEWS
    ),
    *(Picture(f"{planet}/{view}", planet, view) for planet in OTHER_PLANETS for view in ("space", "near")),
    *(Picture(f"props/{view}", "props", view) for view in ("ground", "beach")),
    Picture("pictures/near", "pictures", "near", KNOB_SIZE),
    *(Picture(f"{planet}/{view}", planet, view) for planet in AIRY_PLANETS for view in ("sunset", "limb", "high")),
)

KNOB_PICTURES: tuple[Picture, ...] = (
    *(
        knob_picture(f"tone_map_{name}", "earth", "terminator", {"composite.tone_map": name})
        for name in ("agx", "aces", "hable", "reinhard", "neutral", "linear")
    ),
    knob_picture("bloom_off", "earth", "limb", {"composite.bloom": 0.0}),
    knob_picture("bloom_strong", "earth", "limb", {"composite.bloom": 0.1}),
    knob_picture("shadows_off", "earth", "sunset", {"terrain.shadows": False}),
    knob_picture("relief_strong", "earth", "dusk", {**FEW_CELLS, "terrain.roughness": 3.0}),
    knob_picture("occlusion_off", "earth", "dusk", {**FEW_CELLS, "terrain.roughness": 3.0, "terrain.occlusion": False}),
    knob_picture("stars_off", "earth", "night", {"stars.density": 0.0}),
    knob_picture("stars_dense", "earth", "night", {"stars.density": 10.0}),
    knob_picture("sun_disc_large", "earth", "limb", {"sun.angular_radius_rad": 0.03, "composite.bloom": 0.0}),
    knob_picture("layers_4", "earth", "terminator", {**FEW_CELLS, "terrain.layers": 4}),
    knob_picture("banks_off", "earth", "river", {"terrain.banks": 0.0}),
    knob_picture("spray_off", "earth", "waterfall", {"terrain.spray": 0.0}),
    knob_picture("rivers_off", "earth", "river", {"terrain.rivers": 0.0}),
    knob_picture("erosion_off", "earth", "ranges", {"terrain.erosion": 0.0}),
    knob_picture("paper_near", "earth", "near", {"terrain.method": "paper"}),
    knob_picture("paper_orbit", "earth", "orbit", {"terrain.method": "paper"}),
    knob_picture(
        "colours", "earth", "orbit",
        {"terrain.grass_albedo": (0.1, 0.03, 0.12), "terrain.dry_albedo": (0.3, 0.1, 0.05)},
    ),
    knob_picture("no_plants", "earth", "orbit", {"terrain.plants": 0.0}),
    knob_picture(
        "no_air", "earth", "high",
        {
            "atmosphere.rayleigh_scattering_per_m": (0.0, 0.0, 0.0),
            "atmosphere.mie_scattering_per_m": (0.0, 0.0, 0.0),
            "atmosphere.mie_extinction_per_m": (0.0, 0.0, 0.0),
            "atmosphere.absorption_per_m": (0.0, 0.0, 0.0),
        },
    ),
    knob_picture("no_ozone", "earth", "dusk", {"atmosphere.absorption_per_m": (0.0, 0.0, 0.0)}),
    knob_picture("haze", "earth", "sunset", HAZE),
    knob_picture("clear_water", "earth", "coast", {"ocean.absorption_per_m": (0.03, 0.01, 0.005)}),
    knob_picture("muddy_water", "earth", "coast", {"ocean.absorption_per_m": (2.0, 1.0, 1.5)}),
    knob_picture("sea_calm", "earth", "sea", CALM),
    *(
        knob_picture(f"wave_{name}_{method}", "earth", "coast", {"ocean.waves": (wave,), "ocean.method": method})
        for name, wave in ONE_WAVE.items()
        for method in ("ours", "paper_2018")
    ),
    knob_picture("sea_gale", "earth", "sea", {"ocean.wind_speed_m_s": 18.0}),
    knob_picture("mirror", "earth", "beach", CALM),
    Picture("knobs/mirror_sky_only", "earth", "beach", KNOB_SIZE, CALM, {"ocean.reflections": 0}),
    Picture("knobs/ripples_off", "earth", "glint", VIEW_SIZE, {}, {"ocean.ripples": False}),
    knob_picture("waterline_calm", "earth", "waterline", CALM),
    knob_picture("shore_still", "earth", "beach", {"ocean.surf_m": 0.0}),
    knob_picture(
        "lava", "earth", "coast",
        {**CALM, "ocean.glow": (0.9, 0.06, 0.004), "ocean.crust": 0.7, "ocean.absorption_per_m": (30.0, 30.0, 30.0)},
    ),
    knob_picture("exposure_auto", "earth", "terminator", {"exposure.mode": "auto"}, free=True),
    knob_picture(
        "exposure_fixed", "earth", "terminator", {"exposure.mode": "fixed", "exposure.ev100": 10.0}, free=True
    ),
    knob_picture("antialiasing_temporal", "moon", "high", {"composite.antialiasing": "temporal"}),
    knob_picture("antialiasing_edge", "moon", "high", {"composite.antialiasing": "edge"}),
    *(debug_picture(name) for name in DEBUG_VIEWS),
)  # fmt: skip

CLOUD_PICTURES: tuple[Picture, ...] = (
    cloud_picture("mirrored", "sea"),
    cloud_picture("relief_off", "cloud_sea", {"clouds.relief": 0.0}),
    cloud_picture("cirrus", "valley", size=KNOB_SIZE),
    cloud_picture("low_sun", "glint"),
    cloud_picture("dusk", "dusk"),
    cloud_picture("orbit", "orbit"),
    cloud_picture("limb", "limb"),
    cloud_picture("terminator", "terminator"),
    cloud_picture("disc", "space"),
    cloud_picture("disc_after_an_hour", "space", later_s=3600.0),
    cloud_picture("disc_after_ten_days", "space", later_s=864e3),
)
"""Clouds in the sea, low suns, day's edge from 2000 km, and the full disc. Views named after clouds (earth/fair and the
rest of CLOUD_VIEWS) show fair weather, a closed sky, a sea of clouds, shafts of light, shadows on land and sea, day's
edge from 400 km, and the inside."""

KIND_SIZE = (112, 63)
KIND_CHANGES: Mapping[str, Mapping[str, float]] = {
    "humilis": {"coverage": 0.5},
    "congestus": {"coverage": 0.5},
    "cumulonimbus": {"coverage": 0.7},
    "stratocumulus": {},
    "stratus": {"base_m": 600.0, "top_m": 1100.0},
    "altocumulus": {"coverage": 0.8},
}
"""Beside what each kind brings: cover enough to be in the picture of `fair`, and a sheet that lies above its ground."""


def kind_picture(kind: str) -> Picture:
    """Fair with one kind of cloud in place of the weather's own mixture."""
    fields = {"kind": kind, **KIND_LAYERS[kind], **KIND_CHANGES[kind]}
    changes = {f"clouds.{name}": value for name, value in fields.items()}
    return cloud_picture(f"kind_{kind}", "fair", changes, size=KIND_SIZE)


KIND_PICTURES = tuple(kind_picture(kind) for kind in KIND_LAYERS)

SEVERAL_PICTURES: tuple[Picture, ...] = (
    Picture("several/moonrise", "earth_moon", "moonrise"),
    Picture("several/earthrise", "earth_moon", "earthrise", clouds=True),
)
"""Of scenes with several planets."""

GRASS_SIZE = (240, 135)
"""In smaller ones a pixel is wider than blades and leaves."""
CROWN_SIZE = (192, 108)
"""The same of crowns."""
COVER_PICTURES: tuple[Picture, ...] = (
    Picture("cover/forest", "woods", "forest", GRASS_SIZE),
    Picture("cover/canopy", "woods", "canopy", CROWN_SIZE),
    Picture("cover/treeline", "woods", "treeline", KNOB_SIZE),
    Picture("cover/crowns", "woods", "near", CROWN_SIZE, overrides={"cover.reach_m": 100.0}),
    Picture("cover/without_crowns", "woods", "near", CROWN_SIZE, overrides={"cover.reach_m": 100.0, "cover.crowns": 0}),
    Picture("cover/forest_without", "woods", "forest", KNOB_SIZE, {"cover.density": 0.0}),
    Picture("cover/meadow", "woods", "meadow", GRASS_SIZE),
    Picture("cover/meadow_mown", "woods", "meadow", GRASS_SIZE, {"cover.grass": 0.0}),
    Picture("cover/desert", "woods", "desert", KNOB_SIZE),
    Picture("cover/desert_without", "woods", "desert", KNOB_SIZE, {"cover.species": ()}),
    Picture("cover/savanna", "woods", "savanna", KNOB_SIZE),
    Picture("cover/savanna_without", "woods", "savanna", KNOB_SIZE, {"cover.savanna": 0.0}),
    Picture("cover/palms", "woods", "palms", KNOB_SIZE),
    Picture("cover/palms_without", "woods", "palms", KNOB_SIZE, {"cover.palms": 0.0}),
    Picture("cover/mangroves", "woods", "mangroves", GRASS_SIZE),
    Picture("cover/mangroves_without", "woods", "mangroves", GRASS_SIZE, {"cover.species": ()}),
    Picture("cover/lakeside", "woods", "lakeside", KNOB_SIZE),
    Picture("cover/lakeside_sky_only", "woods", "lakeside", KNOB_SIZE, overrides={"ocean.reflections": 0}),
    Picture("cover/branch", "woods", "ground", GRASS_SIZE),
    Picture("cover/woodland", "woods", "woodland", KNOB_SIZE),
    Picture("cover/woodland_autumn", "woods", "woodland", KNOB_SIZE, {"cover.season": 0.79}),
    Picture("cover/woodland_winter", "woods", "woodland", KNOB_SIZE, {"cover.season": 0.0}),
    Picture("cover/treeline_winter", "woods", "treeline", KNOB_SIZE, {"terrain.season": 0.0}),
    Picture("cover/grove", "woods", "grove", KNOB_SIZE),
    Picture("cover/grove_unshaded", "woods", "grove", KNOB_SIZE, overrides={"cover.shadows": False}),
)
"""Trees: under them and over them, where they end, none, and without their shadows, on the sea as well."""


def shaded(key: str, view: str, value: int) -> Picture:
    """A quality knob of shading, at one of its values."""
    name, clouds = f"knobs/{key.replace('.', '_')}_{value}", key.startswith("clouds.")
    return Picture(name, "earth", view, KNOB_SIZE, {}, {key: value}, clouds=clouds)


PAPER = {"atmosphere.paper_scale": 0.5}
"""Of pictures of quality `paper`: tables of an eighth of the printed size are made in seconds and look alike."""


def paper_picture(name: str, view: str, overrides: Mapping[str, Any] | None = None, **parts: Any) -> Picture:
    """A view of earth as the sources draw it."""
    return Picture(f"paper/{name}", "earth", view, overrides={**PAPER, **(overrides or {})}, quality="paper", **parts)


PAPER_VIEWS = ("space", "orbit", "high", "coast", "near", "valley", "beach", "sea", "dusk", "clouds")
PAPER_PICTURES = (
    *(paper_picture(view, view, clouds=True) for view in PAPER_VIEWS),
    *(
        paper_picture(f"{backend}_{view}", view, {"terrain.backend": backend}, size=KNOB_SIZE)
        for backend in ("quadtree", "icosphere")
        for view in ("near", "orbit")
    ),
)
"""Whole pictures with clouds, of the projected grid; then the ground of each of the other sources."""

SHADED_PICTURES = tuple(shaded(key, view, coarse) for key, (view, _, coarse) in SHADE_PAIRS.items())
"""Beside those of the views themselves, whose pixels are all shaded."""

GOLDENS: tuple[Picture, ...] = (
    *VIEW_PICTURES, *KNOB_PICTURES, *SHADED_PICTURES, *CLOUD_PICTURES, *KIND_PICTURES, *SEVERAL_PICTURES,
    *COVER_PICTURES, *PAPER_PICTURES,
)  # fmt: skip


def pair_picture(key: str, pair: Pair, value: Any) -> Picture:
    """One picture of a knob's pair."""
    return Picture(
        f"pair/{key}", pair.planet, pair.view, pair.size, pair.changes(key, value), free=pair.free,
        clouds=pair.clouds,
    )  # fmt: skip


def wireframe(overrides: Mapping[str, Any]) -> Picture:
    """The triangles of a quality."""
    return Picture("pair/quality", *QUALITY_VIEW, VIEW_SIZE, {"debug.view": "wireframe"}, overrides)


def plain(view: str, planet: str, size: tuple[int, int] = KNOB_SIZE, clouds: bool = False) -> Picture:
    """The picture without any change, to hold a changed one against."""
    return Picture(f"plain/{planet}-{view}", planet, view, size, clouds=clouds)


def _solve(scene: pf.Scene) -> None:
    """Waits for rivers, or cameras would stand on the ground of the picture before."""
    scene.height_field()
    while source.pending():
        source.progress(10.0)
    scene.height_field()


class Studio:
    """Takes pictures, with one renderer for each planet, size and set of overrides; a few are kept.

    Use as a context manager. What it renders depends on the picture alone, not on what was taken before: settings are
    put back, and settling begins anew. The last picture of each plain view is remembered.
    """

    KEEP = 2

    def __init__(self) -> None:
        self._renderers: OrderedDict[tuple[Any, ...], tuple[pf.Scene, pf.Renderer]] = OrderedDict()
        self._plain: dict[tuple[str, str, tuple[int, int], bool], Pixels] = {}
        self.machine: dict[str, str] = {}

    def take(self, picture: Picture) -> Pixels:
        """u8 (H, W, 3), row 0 on top."""
        key = (picture.planet, picture.view, picture.size, picture.clouds)
        unchanged = not (
            picture.changes or picture.overrides or picture.free or picture.sun_higher_deg or picture.later_s
            or picture.quality != QUALITY
        )  # fmt: skip
        if unchanged and key in self._plain:
            return self._plain[key]
        scene, renderer = self._renderer(picture)
        _solve(scene)
        view = pf.view(picture.view, scene.planet)
        with changed(scene, picture.changes):
            _solve(scene)
            shot: Any = view
            sun = _sun_of(view, scene, picture.sun_higher_deg)
            if picture.free:
                aside = np.tan(np.radians(picture.turned_deg)) * np.cross(view.forward, view.up)
                shot = pf.Camera(view.position_m, view.forward + aside, view.up, view.fov_y_deg)
            time_s = view.time_s + picture.later_s
            renderer.settle(shot, time_s, sun)
            pixels = renderer.render(shot, time_s, sun)["color"]
        if unchanged:
            self._plain[key] = pixels
        return pixels

    def output(self, picture: Picture, name: str) -> NDArray[Any]:
        """Another output of the same frame, such as "radiance"."""
        scene, renderer = self._renderer(picture)
        _solve(scene)
        view = pf.view(picture.view, scene.planet)
        with changed(scene, picture.changes):
            _solve(scene)
            renderer.settle(view)
            return renderer.render(view, outputs=(name,))[name]

    def _renderer(self, picture: Picture) -> tuple[pf.Scene, pf.Renderer]:
        key = (picture.planet, picture.size, tuple(sorted(picture.overrides.items())), picture.clouds, picture.quality)
        if key not in self._renderers:
            scene = preset_scene(SCENES.get(picture.planet, picture.planet), picture.clouds)
            scene.environment.add(pf.DebugView())
            scene.environment[pf.Composite].antialiasing = ANTIALIASING
            renderer = pf.Renderer(scene, picture.size, picture.quality, picture.overrides)
            self._renderers[key] = (scene, renderer)
            caps = renderer.gpu.caps
            self.machine = {"renderer": caps.renderer, "gl": caps.version}
            while len(self._renderers) > self.KEEP:
                _release(*self._renderers.popitem(last=False)[1])
        self._renderers.move_to_end(key)
        return self._renderers[key]

    def release(self) -> None:
        while self._renderers:
            _release(*self._renderers.popitem()[1])

    def __enter__(self) -> Studio:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


def _sun_of(view: pf.View, scene: pf.Scene, higher_deg: float) -> pf.Sun:
    """The view's sun, with light and disc of the scene's as it is now."""
    sun = view.sun or scene.sun
    if higher_deg:
        sun = dataclasses.replace(sun, elevation_deg=sun.elevation_deg + higher_deg)
    return sun


def _release(scene: pf.Scene, renderer: pf.Renderer) -> None:
    renderer.release()
    scene.release()
