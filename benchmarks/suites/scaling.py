"""Suite scaling: how a frame's time grows with pixels, vertices, layers of noise, waves, layers of cloud, views,
planets.

The error column of the last row of a bench is the exponent: 1 is proportional. Processor time of all cores is what is
fitted, less what a frame takes anyway; on a GPU, where it says nothing, the clock's time is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from typing import Any

from ... import Camera, CloudLayer, Clouds, Ocean, Orbit, Scene, Sun, Terrain, load_scene, view
from ..measure.scaling import FrameCost, beside_alone, fit_power_law, turning_frames, turning_in_turns, turning_views
from ..session import Bench, Session
from ..target import at_most

SIZE, QUICK_SIZE = (640, 360), (320, 180)
PIXELS = ((160, 90), (320, 180), (640, 360), (1280, 720), (1920, 1080), (3840, 2160))
OVERRIDES: Mapping[str, Any] = {"composite.antialiasing": "none"}
"""Its history would be another thing to measure."""
_WARM_UP = 12
"""Frames in which each planet compiles what later ones may need."""
_SHADOW_TURN = 14
"""Frames in which the map of the clouds' shadow is drawn once at `medium`, and two."""


def _series(
    session: Session,
    name: str,
    counts: Sequence[float],
    measure: Callable[[float], FrameCost],
    noun: str,
    size: tuple[int, int] | None,
    most: float,
    counted: Callable[[float], float] = float,
) -> None:
    """A row a count, then one with the exponent. counted: what really grew, when it is known only afterwards."""
    found: list[FrameCost] = []
    grown: list[float] = []
    for count in counts:
        found.append(measure(count))
        grown.append(counted(count))
        session.row(f"{grown[-1]:.0f} {noun}", name, size, found[-1].timing, cpu_ms=found[-1].cpu_ms)
    soft = session.machine().is_software
    times = [cost.cpu_ms if soft else cost.timing.ms for cost in found]
    law = fit_power_law(grown, times)
    session.row(
        f"exponent of {noun}", name, size, error=law.exponent, target=at_most(most), fixed_ms=law.fixed_ms,
        worst_ratio=law.worst,
    )  # fmt: skip


def _clear(name: str) -> Scene:
    """A scene without clouds, which have a bench of their own."""
    scene = load_scene(name)
    if Clouds in scene.planet:
        scene.planet.remove(Clouds)
    return scene


def _pixels(session: Session) -> None:
    """The same picture in more pixels: at most proportional."""
    for name in ("near",) if session.small else ("near", "high", "orbit"):
        sizes = PIXELS[:4] if session.small else PIXELS
        seen = view(name)

        def measure(count: float, seen: Any = seen, sizes: Any = sizes) -> FrameCost:
            size = next(s for s in sizes if s[0] * s[1] == count)
            with session.renderer(_clear("earth"), size, "medium", OVERRIDES) as renderer:
                return turning_frames(renderer, seen, session.runs(5, 3))

        _series(session, name, [w * h for w, h in sizes], measure, "pixels", None, 1.1)


def _vertices(session: Session) -> None:
    """Finer edges at the same size. Vertices are made on a snap; a frame culls and draws them."""
    size, seen = QUICK_SIZE if session.small else SIZE, view("near")
    triangles: dict[float, float] = {}

    def measure(edge_px: float) -> FrameCost:
        overrides = {**OVERRIDES, "terrain.backend": "quadtree", "terrain.error_px": edge_px}
        with session.renderer(_clear("earth"), size, "medium", overrides) as renderer:
            renderer.settle(seen)
            found = turning_frames(renderer, seen, session.runs(7, 3))
            triangles[edge_px] = renderer.stats["triangles"]
            return found

    errors_px = (8.0, 4.0, 2.0, 1.0) if session.small else (16.0, 8.0, 4.0, 2.0, 1.0, 0.5)
    _series(session, "near", errors_px, measure, "triangles", size, 1.1, triangles.__getitem__)


def _with(
    session: Session, name: str, counts: Sequence[int], change: Callable[[Scene, int], None], noun: str, most: float
) -> None:
    size, seen = QUICK_SIZE if session.small else SIZE, view(name)

    def measure(count: float) -> FrameCost:
        scene = _clear("earth")
        change(scene, int(count))
        with session.renderer(scene, size, "medium", OVERRIDES) as renderer:
            return turning_frames(renderer, seen, session.runs(7, 3))

    _series(session, name, counts, measure, noun, size, most)


def _layers(session: Session) -> None:
    """Layers of noise in the ground: what is finer than a pixel is not asked for, so less than proportional."""

    def change(scene: Scene, count: int) -> None:
        scene.planet[Terrain].layers = count

    _with(session, "near", (2, 4, 8, 16), change, "layers", 1.1)


def _waves(session: Session) -> None:
    """Waves of the sea: each sample sums those that it can show."""

    def change(scene: Scene, count: int) -> None:
        scene.planet[Ocean].wave_count = count

    # A hundred waves are a tenth of the frame: without the thousand an exponent would be one of noise.
    _with(session, "sea", (20, 50, 100, 1000), change, "waves", 1.1)


def _cloud_layers(session: Session) -> None:
    """Layers of thin cloud in the same kilometre: none hides another, and all are as far away.

    There are four layers at most, and the share of a frame that doesn't grow is found from the same four times: a
    fiftieth of a layer's time moves the exponent by a tenth. So ground and sea, which were two thirds of the frame, are
    left out, the renderers take turns, and each is measured after it has drawn every strip of the clouds' shadow.
    """
    size = QUICK_SIZE if session.small else SIZE
    shell: dict[str, Any] = {"base_m": 1000.0, "top_m": 2000.0, "extinction_per_m": 2e-4}
    counts = (1, 2, 3, 4)
    with ExitStack() as stack:
        renderers = []
        for count in counts:
            scene = _clear("earth")
            for kind in (Terrain, Ocean):
                scene.planet.remove(kind)
            scene.planet.add(Clouds(**shell, layers=(CloudLayer(**shell),) * (count - 1)))
            renderers.append(stack.enter_context(session.renderer(scene, size, "medium", OVERRIDES)))
        costs = turning_in_turns(renderers, view("high"), session.runs(96, 48), _SHADOW_TURN)
    found: dict[float, FrameCost] = dict(zip(counts, costs, strict=True))
    _series(session, "high", counts, found.__getitem__, "cloud layers", size, 1.1)


def _views(session: Session) -> None:
    """Views of one planet in one renderer: each draws a picture of its own, tiles and tables are shared.

    Held frames of views that have all settled, so the time is that of drawing alone, and each view adds its picture.
    """
    size, seen = (160, 90), view("near")

    def measure(count: float) -> FrameCost:
        with session.renderer(_clear("earth"), size, "medium", OVERRIDES) as renderer:
            return turning_views(renderer, seen, int(count), session.runs(7, 3))

    _series(session, "near", (1, 2, 4) if session.small else (1, 2, 4, 8), measure, "views", size, 1.1)


def _surface(session: Session) -> None:
    """A view 5 m above the sea beside one 3 m below it, clouds in the sky: a frame of both against each in a renderer
    of its own. What one view shows must not make the other's graph or clouds begin anew."""
    size = QUICK_SIZE if session.small else SIZE
    place: dict[str, Any] = {"heading_deg": 20.0, "pitch_deg": 8.0}
    cameras = [Camera.at(35.0, 170.0, altitude_m, **place) for altitude_m in (5.0, -3.0)]
    sun = Sun(elevation_deg=40.0, azimuth_deg=200.0, latitude_deg=35.0, longitude_deg=170.0)
    for moving in (False, True):
        with ExitStack() as stack:
            one, other, both = (stack.enter_context(session.renderer(load_scene("earth"), size, "low")) for _ in "123")
            pairs = [(one, cameras[0]), (other, cameras[1])]
            together = [(both, cameras[0]), (stack.enter_context(both.add_view(size)), cameras[1])]
            alone, beside = beside_alone(pairs, together, sun, moving, session.runs(40, 12))
        name = "time runs" if moving else "time stands"
        session.row(f"above and below, {name}", "sea", size, beside.timing, cpu_ms=beside.cpu_ms)
        share = beside.cpu_ms / alone.cpu_ms
        session.row(f"over the two alone, {name}", "sea", size, error=share, target=at_most(1.05), cpu_ms=alone.cpu_ms)


def _planets(session: Session) -> None:
    """Moons side by side, each as large in the picture as the others; one more is one more globe of ground.

    As for layers of cloud the renderers take turns: a machine that is slower for the first one alone by a fifth makes
    an exponent of 1.6 out of times that grow in proportion.
    """
    size = QUICK_SIZE if session.small else SIZE
    radius = load_scene("moon").planet.radius_m
    # Four of them fill the width of the picture, and fewer a part of it.
    seen = Camera((11.0 * radius, 3.6 * radius, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), fov_y_deg=35.0)
    sun = Sun(elevation_deg=50.0, azimuth_deg=180.0, latitude_deg=0.0, longitude_deg=0.0)

    counts = (1, 2, 3, 4)
    with ExitStack() as stack:
        renderers = []
        for count in counts:
            scene = load_scene("moon")
            for k in range(1, count):
                scene.companions.add("moon", Orbit(position_m=(0.0, 2.4 * radius * k, 0.0)), name=f"moon {k}")
            renderers.append(stack.enter_context(session.renderer(scene, size, "medium", OVERRIDES)))
            renderers[-1].settle(seen, sun=sun)
        costs = turning_in_turns(renderers, seen, session.runs(48, 24), _WARM_UP, sun)
    found: dict[float, FrameCost] = dict(zip(counts, costs, strict=True))
    _series(session, "space", counts, found.__getitem__, "planets", size, 1.1)


BENCHES: Mapping[str, Bench] = {
    "pixels": _pixels,
    "vertices": _vertices,
    "layers": _layers,
    "waves": _waves,
    "cloud_layers": _cloud_layers,
    "views": _views,
    "surface": _surface,
    "planets": _planets,
}
