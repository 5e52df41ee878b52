"""Suite cover: trees: what a frame with them costs, how a forest's far colour compares with them, and the sampler."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack

import numpy as np

from ... import Atmosphere, Clouds, Cover, CoverSampler, Scene, TerrainSampler, load_scene, view
from ...engine.frame.gbuffer import Surface
from ..measure import forests
from ..measure.frames import RUN_UP, gpu_passes_ms, time_passes, turning
from ..session import Bench, Session
from ..target import at_most
from ..timing import Timing, time_variants

__all__ = ["BENCHES"]

UNDER_TREES = ("forest", "meadow")
VIEWS, QUICK_VIEWS = (
    (*UNDER_TREES, "canopy", "treeline", "grove", "near", "valley", "fair", "high"),
    ("forest", "canopy", "near"),
)
MOST: Mapping[str, tuple[float, float]] = {"low": (1.6, 1.25), "medium": (2.0, 1.4)}
"""By quality: of the views under trees, and of others, a frame with trees over the same without."""


def _woods(trees: bool) -> Scene:
    scene = load_scene("woods")
    if not trees:
        scene.planet.remove(Cover)
    return scene


def _cost(session: Session) -> None:
    """A turning camera's frames, with trees and without by turns."""
    size = (640, 360)
    for quality, (under, other) in MOST.items():
        with ExitStack() as stack:
            bare, wooded = (stack.enter_context(session.renderer(_woods(on), size, quality)) for on in (False, True))
            for name in QUICK_VIEWS if session.extent == "quick" else VIEWS:
                frames = {"bare": turning(bare, view(name)), "wooded": turning(wooded, view(name))}
                found = time_variants(frames, session.runs(30, 8), RUN_UP)
                session.row(
                    quality, name, size, found["wooded"], error=found["wooded"].ms / found["bare"].ms,
                    error_unit="times", target=at_most(under if name in UNDER_TREES else other, "times"),
                    bare_ms=found["bare"].ms, trees=wooded.stats.get("trees", 0),
                )  # fmt: skip


def _full_hd(session: Session) -> None:
    """What trees add to the passes of a frame of 1920 x 1080, by the GPU's own timers, where it is one."""
    size = (1920, 1080)
    for quality in (*MOST, "high"):
        clock: list[dict[str, Timing]] = [{}, {}]
        passes: list[dict[str, dict[str, float]]] = [{}, {}]
        for on in (0, 1):
            with session.renderer(_woods(bool(on)), size, quality) as renderer:
                for name in QUICK_VIEWS if session.small else VIEWS:
                    frame = turning(renderer, view(name))
                    clock[on][name] = time_variants({"": frame}, session.runs(30, 8), RUN_UP)[""]
                    passes[on][name] = gpu_passes_ms(renderer, view(name), session.runs(20, 8))
        for name, timing in clock[1].items():
            bare, wooded = passes[0][name], passes[1][name]
            session.row(
                quality, name, size, timing, error=sum(wooded.values()) - sum(bare.values()), error_unit="ms more",
                target=None if session.machine().is_software else at_most(2.0, "ms more"), bare_ms=clock[0][name].ms,
                passes_ms=sum(wooded.values()), drawn_ms=wooded.get("cover.gbuffer", 0.0),
            )  # fmt: skip


def _far(session: Session) -> None:
    """Mean radiance of forest as crowns in the ground's light, and as its colour alone, over that of trees as solids,
    for 20 pairs of sun and view."""
    scene = forests.forest()
    for kind, name in forests.PLACES.items():
        solids = forests.mean_light(scene, name, forests.SOLIDS)[:, 1]
        for what, own in {"crowns": forests.CROWNS, "colour alone": forests.FLAT}.items():
            ratio = forests.mean_light(scene, name, own)[:, 1] / solids
            session.row(
                f"{what} over trees, forest {kind}", name, error=float(np.sqrt(np.mean((ratio - 1.0) ** 2))),
                error_unit="rms of the ratio less 1", target=at_most(0.05), mean=float(ratio.mean()),
                least=float(ratio.min()), most=float(ratio.max()),
            )  # fmt: skip


def _ascent(session: Session) -> None:
    """Steps of a forest's mean radiance where each picture is seen from 3 % farther away, from 200 m to 6 km."""
    scene = forests.forest()
    scene.planet.remove(Atmosphere)
    away = np.geomspace(200.0, 6e3, 116)
    places = forests.PLACES if session.extent == "full" else dict(list(forests.PLACES.items())[:1])
    for kind, name in places.items():
        light = forests.up_light(scene, name, away)[:, 1]
        steps = np.abs(light[1:] / light[:-1] - 1.0)
        worst = int(np.argmax(steps))
        session.row(
            f"steps on the way up, forest {kind}", name, error=float(steps.max()), error_unit="of the light",
            target=at_most(0.03), at_m=float(away[worst]), median=float(np.median(steps)),
            over_all=float(light.max() / light.min()),
        )  # fmt: skip


def _light(session: Session) -> None:
    """The pass that lights trees by cover.light_every, and how many levels of 255 the picture is from each pixel's own
    light."""
    scene, size = _woods(True), (640, 360)
    for name in ("forest", "canopy"):
        camera = view(name, scene.planet)
        exact: np.ndarray | None = None
        for every in (1, 2, 4):
            with session.renderer(scene, size, "medium", {"cover.light_every": every}) as renderer:
                renderer.settle(camera)
                shown = renderer.render(camera)["color"].astype(float)
                timing = time_passes(renderer, camera, session.runs(20, 6))["cover.shade"]
            exact = shown if exact is None else exact
            off = np.abs(shown - exact).max(axis=-1)
            session.row(
                f"light_every {every}", name, size, timing, error=float(np.percentile(off, 99.0)), error_unit="levels",
                largest=float(off.max()),
            )  # fmt: skip


PARTS: Mapping[str, tuple[str, dict[str, float], dict[str, float]]] = {
    "grass and flowers": ("meadow", {"cover.grass": 0.0}, {}),
    "shrubs": ("forest", {"cover.shrubs": 0.0}, {}),
    "autumn": ("woodland", {}, {"cover.season": 0.8}),
    "winter": ("woodland", {}, {"cover.season": 0.0}),
}
"""View, and overrides without it and with it."""


def _parts(session: Session) -> None:
    """A turning camera's frames with and without grass, shrubs, seasons, by turns; and mean light of land and trees
    within 15 m with it over that without."""
    size = (640, 360)
    for quality in MOST:
        for part, (name, *both) in PARTS.items():
            with ExitStack() as stack:
                scene = _woods(True)
                renderers = [stack.enter_context(session.renderer(scene, size, quality, own)) for own in both]
                frames = {str(k): turning(renderer, view(name)) for k, renderer in enumerate(renderers)}
                found = time_variants(frames, session.runs(30, 8), RUN_UP)
                wanted = ("radiance", "surface", "distance")
                outs = [
                    {
                        key: value.copy()
                        for key, value in renderer.render(view(name, scene.planet), outputs=wanted).items()
                    }
                    for renderer in renderers
                ]
            near = np.logical_and.reduce(
                [np.isin(o["surface"], (Surface.TERRAIN, Surface.COVER)) & (o["distance"] < 15.0) for o in outs]
            )
            without, light = found["0"].ms, [float(o["radiance"][near].mean()) for o in outs]
            session.row(
                f"{quality}: {part}", name, size, found["1"], error=found["1"].ms / without, error_unit="times",
                without_ms=without, light=light[1] / light[0],
            )  # fmt: skip


def _games(session: Session) -> None:
    """What games ask of trees in a closed forest: contacts, bodies, and frames in which trees are felled."""
    scene = _woods(True)
    scene.planet.remove(Clouds)
    sampler, seen = CoverSampler(scene), view("forest", scene.planet)
    eye = view("canopy", scene.planet).camera.resolve(scene).position_m
    up = eye / np.linalg.norm(eye)
    foot = up * (scene.planet.radius_m + float(TerrainSampler(scene).height(up[None])[0]) + 1.0)
    random = np.random.default_rng(7)

    def spheres(count: int, within_m: float) -> np.ndarray:
        aside = random.uniform(-within_m, within_m, (count, 3))
        return foot + aside - (aside @ up)[:, None] * up

    near, wide = spheres(200, 30.0), spheres(200, 300.0)
    began = time.perf_counter()
    sampler.sphere_contact(near[:1], 0.5)
    session.row("contact of a sphere, the first near a place", "canopy", ms_once=1e3 * (time.perf_counter() - began))
    asked = {
        "contact of a sphere": lambda: sampler.sphere_contact(near[:1], 0.5),
        "contacts of 200 spheres within 30 m": lambda: sampler.sphere_contact(near, 0.5),
        "contacts of 200 spheres within 300 m": lambda: sampler.sphere_contact(wide, 0.5),
        "bodies within 150 m": lambda: sampler.bodies(up, 150.0),
    }
    for name, timing in time_variants(asked, session.runs(20, 5), 2).items():
        session.row(name, "canopy", timing=timing)
    many = sampler.within(seen.camera.resolve(scene).position_m, 3000.0).names
    trees = sampler.within(seen.camera.resolve(scene).position_m, 150.0).names
    for quality in MOST:
        for before in (0, 10_000):
            for felling in (False, True):
                scene.planet[Cover].felled = tuple(map(tuple, many[-before:].tolist())) if before else ()
                left = list(trees)
                with session.renderer(scene, (320, 180), quality) as renderer:
                    frame = turning(renderer, seen)

                    def felled(frame: Callable[[], None] = frame, left: list[np.ndarray] = left) -> None:
                        sampler.fell(left.pop())
                        frame()

                    timing = time_variants({"": felled if felling else frame}, session.runs(28, 8), RUN_UP)[""]
                each = ", a tree in each frame" if felling else ""
                session.row(f"{quality}: {before} felled before{each}", "forest", (320, 180), timing)


def _sampler(session: Session) -> None:
    """CoverSampler.within 300 m of a forest."""
    scene = _woods(True)
    sampler, place = CoverSampler(scene), view("canopy", scene.planet).camera.resolve(scene).position_m
    timing = time_variants({"within": lambda: sampler.within(place, 300.0)}, session.runs(10, 4), 1)["within"]
    session.row("within 300 m", "canopy", timing=timing, trees=len(sampler.within(place, 300.0)))


BENCHES: Mapping[str, Bench] = {
    "cost": _cost,
    "full_hd": _full_hd,
    "far": _far,
    "ascent": _ascent,
    "light": _light,
    "parts": _parts,
    "games": _games,
    "sampler": _sampler,
}
