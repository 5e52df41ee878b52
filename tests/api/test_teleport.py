"""A camera that leaps half a planet each frame: ground at once, no hole once it settles, memory that stays."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure.holes import must_hit

SIZE = (64, 36)
SETTLE_EVERY = 10
WARM = 20
"""Leaps after which everything that is kept has its full size."""


def leaps(planet, count, rng):
    """Cameras above places half a planet from the last, less a few degrees, from 2 m to 1000 km above the ground."""
    axis = rng.normal(size=3)
    zenith = np.cross(axis, rng.normal(size=3))
    for _ in range(count):
        zenith = -zenith / np.linalg.norm(zenith) + 0.05 * rng.normal(size=3)
        zenith /= np.linalg.norm(zenith)
        above_m = 10.0 ** rng.uniform(0.3, 6.0)
        radius = planet.radius_m + float(planet.surface_height_m(zenith[None])[0]) + above_m
        side = np.cross(zenith, rng.normal(size=3))
        dip = np.arccos(np.clip(planet.radius_m / radius, 0.0, 1.0))
        down = dip + (np.pi / 2 - dip) * rng.random()
        forward = side / np.linalg.norm(side) * np.cos(down) - zenith * np.sin(down)
        yield pf.Camera(zenith * radius, forward, zenith)


def holes(renderer, camera):
    """Pixels without ground or sea that have to show some; and how many have to."""
    planet = renderer.scene.planet
    surface = renderer.render(camera, outputs=("surface",))["surface"]
    must = must_hit(renderer.camera_state(camera), SIZE, planet.radius_m, planet.height_field().lowest_m)
    return int((must & (surface == 0)).sum()), int(must.sum())


def resident_bytes():
    """Memory of this process, with a software renderer's textures; None where the system doesn't tell."""
    status = Path("/proc/self/status")
    if not sys.platform.startswith("linux") or not status.exists():
        return None
    lines = (line for line in status.read_text().splitlines() if line.startswith("VmRSS:"))
    return 1024 * int(next(lines).split()[1])


def without_programs(counts):
    """Live objects by owner and kind, without shaders."""
    return {owner: {kind: n for kind, n in kinds.items() if kind != "program"} for owner, kinds in counts.items()}


def programs(counts):
    """Live shaders."""
    return sum(kinds.get("program", 0) for kinds in counts.values())


def kept(renderer):
    """Live GL objects, the frame graph's bytes, and the tiles that are known (0: the grid has none)."""
    backend = renderer.system("terrain").backend
    tiles = [view.found(backend) for view in renderer.views]
    forests = [tile.forest for tile in tiles if getattr(tile, "forest", None)]
    return renderer.gpu.counts(), renderer.graph.memory_bytes(), sum(len(forest.table) for forest in forests)


def teleport(backend, count):
    with pf.Renderer(
        pf.load_scene("earth"), size=SIZE, quality="low", overrides={"terrain.backend": backend}
    ) as renderer:
        most_tiles = 0
        for k, camera in enumerate(leaps(renderer.scene.planet, count, np.random.default_rng(77))):
            missing, looked = holes(renderer, camera)
            assert missing == 0 and looked > 0, f"leap {k}: {missing} of {looked} pixels are empty at once"
            if k % SETTLE_EVERY == SETTLE_EVERY - 1:
                renderer.settle(camera)
                assert holes(renderer, camera)[0] == 0, f"leap {k}: holes once it has settled"
            if k == WARM - 1:  # settled; passes come and go with the camera's place
                first, before = camera, kept(renderer)
            if k == count // 2:
                half_way = resident_bytes()
            most_tiles = max(most_tiles, kept(renderer)[2])
        renderer.settle(first)
        holes(renderer, first)
        after = kept(renderer)
        assert without_programs(after[0]) == without_programs(before[0]), (
            "objects of the GPU, as there were the first time"
        )
        # Pictures without arrays have variants of their own (normals of the sea only where it is shaded).
        known = []
        for _ in range(2):
            for camera in leaps(renderer.scene.planet, count, np.random.default_rng(77)):
                renderer.render(camera)
            known.append(programs(renderer.gpu.counts()))
        assert known[0] == known[1], "variants of shaders are made when they are first needed, once"
        assert after[1] <= 2 * before[1], (
            "the grid's room for cells has doubled at most, for what is nearest to rough ground"
        )
        assert most_tiles <= int(renderer.settings["terrain.slots"]), "as many tiles as there are slots for"
        assert backend == "grid" or most_tiles > 100
        return half_way, resident_bytes()


BACKENDS = ["grid", "quadtree", "icosphere"]


@pytest.mark.parametrize(
    "backend", ["grid", *(pytest.param(tiles, marks=pytest.mark.slow) for tiles in ("quadtree", "icosphere"))]
)
def test_forty_leaps_of_half_a_planet(backend):
    teleport(backend, 40)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("backend", BACKENDS)
def test_a_thousand_leaps_of_half_a_planet(backend):
    half_way, after = teleport(backend, 1000)
    if half_way is not None:
        # A copy of one frame's arrays for each of 500 leaps would be more than this.
        assert after - half_way < 500 * SIZE[0] * SIZE[1] * 4 * 4, f"{(after - half_way) / 2**20:.1f} MiB more"
