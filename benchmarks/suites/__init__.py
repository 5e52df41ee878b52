"""The suites of `planetfall bench`. A suite is a module with BENCHES: name -> bench(session)."""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Mapping

from ...engine.settings.suggest import did_you_mean
from ...errors import UnknownNameError
from ..session import Bench

SUITES: Mapping[str, str] = {
    "graph": "The frame graph, the state guard and the Python around a frame, in ms",
    "terrain": "Accuracy of the ground: positions, heights, normals, coverage, jitter, triangles, error on screen",
    "land": "Rivers and gullies: the network's shape, where drops end that run down the ground, what both cost",
    "maps": "Elevation from tiles: index, tiles a second, error at samples, overshoot between, what a height costs",
    "cover": "Trees: what a frame with them costs, how a forest's far colour compares with them",
    "ocean": "The sea: waves against float64, seams, time by number of waves, flicker; OceanSampler's time and error",
    "atmosphere": "Air: errors against the float64 reference, run time, what is skipped",
    "clouds": "Clouds: errors of the march against float64 references; pictures by quality: error against time",
    "papers": "Every printed technique beside ours: ms, error, and how much faster ours is at no larger error",
    "frame": "Whole frames at 640 x 360: ms in all, by pass and by knob, what is skipped, memory",
    "capture": "What handing frames to workers costs beside making them here",
    "whole": "Every planet with all it has at every quality: time against the error to `reference`, by pass, memory",
    "scaling": "How time grows with pixels, triangles, layers of noise, waves, clouds, views, planets: exponents",
    "startup": "Import and first picture, warm and cold; memory of the process",
    "peers": "Frames beside those of a browser's sky and clouds, measured on the same machine: ours over theirs",
}

LONG: Mapping[str, tuple[str, ...]] = {
    "terrain": (
        "jitter", "proxy", "height sources", "queries", "grid_methods", "grid_snaps", "grid_descent", "backends",
        "popping", "holes", "icosphere", "icosphere_vertices", "shadows", "shadows in flight", "shadows cost",
    ),
    "land": ("network", "descent"),
    "maps": ("reading", "frame"),
    "cover": ("cost", "full_hd", "far", "light"),
    "papers": ("ground", "air", "clouds", "pictures"),
    "frame": ("full_hd", "skipping", "knobs", "budget", "antialiasing"),
    "whole": ("asteroid", "earth", "hazy", "mars", "small", "passes"),
    "startup": ("window",),
    "peers": ("clouds", "whole", "start"),
    "atmosphere": ("curve", "shading", "tables", "thick"),
    "ocean": ("footprint",),
    "clouds": (
        "accuracy", "speed", "flown", "slab", "paper", "repeats", "cover", "sunlight", "opacity", "memory",
        "pathtraced",
    ),
}  # fmt: skip
"""What a quick run leaves out, so that all suites together take less than five minutes on two cores with llvmpipe."""


def benches_of(suite: str) -> Mapping[str, Bench]:
    """The benches of a suite by name. UnknownNameError names the nearest suite."""
    if suite not in SUITES:
        raise UnknownNameError(f"no bench suite {suite!r}; {did_you_mean(suite, SUITES, 'suites')}")
    return importlib.import_module(f".{suite}", __name__).BENCHES


def choose(suites: Iterable[str], quick: bool = False) -> dict[str, Mapping[str, Bench]]:
    """Benches by suite, from names such as "terrain" and "terrain.normals"; no names: everything. quick: of whole
    suites what is not LONG."""
    chosen: dict[str, dict[str, Bench]] = {}
    for name in list(suites) or list(SUITES):
        suite, _, bench = name.partition(".")
        benches = benches_of(suite)
        if bench and bench not in benches:
            raise UnknownNameError(f"no bench {bench!r} in {suite}; {did_you_mean(bench, benches, 'benches')}")
        left_out = () if bench or not quick else LONG.get(suite, ())
        wanted = (bench,) if bench else [name for name in benches if name not in left_out]
        chosen.setdefault(suite, {}).update({name: benches[name] for name in wanted})
    return dict(chosen)
