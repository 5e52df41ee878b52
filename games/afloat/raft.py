"""A raft of logs on a river, from its upper reaches down to the sea, and a camera that follows it."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

import planetfall as pf

from .drifting import BEAM_M, DRAFT_M, LENGTH_M, Rafts
from .shapes import raft_files
from .turning import quaternion_of

Floats = NDArray[np.float64]
Triple = tuple[float, float, float]

SUN_ELEVATION_DEG, SUN_AZIMUTH_DEG = 32.0, 130.0
LEAST_DEPTH_M = 0.8
"""Of water that a journey starts on: four drafts."""
_AROUND_M, _APART_M = 3500.0, 50.0
"""Rivers bend: how far from its cell's place one is looked for, and between which places."""
_MOST_STEPS = 8
"""A frame: slower machines see slower rivers."""
_LOGS = 8


def launch(sampler: pf.TerrainSampler, path: Floats, sea_level_m: float = 0.0) -> Floats:
    """The direction (3,) of the fastest deep water about the first of a river's places (K, 3) that has any.

    Its bed lies above the sea's level, so that there is a way to go. ValueError for a river that is too shallow all the
    way to the sea.
    """
    steps = np.arange(-_AROUND_M, _AROUND_M + 1.0, _APART_M) / sampler.radius_m
    x, y = (grid.ravel()[:, None] for grid in np.meshgrid(steps, steps))
    for place in path:
        east = np.cross([0.0, 0.0, 1.0], place)
        east /= np.linalg.norm(east)
        places = place + x * east + y * np.cross(place, east)
        places /= np.linalg.norm(places, axis=1)[:, None]
        water = sampler.water(places)
        deep = (water.depth_m >= LEAST_DEPTH_M) & (water.level_m - water.depth_m > sea_level_m)
        if deep.any():
            speed = np.linalg.norm(water.current_m_s, axis=1)
            return places[int(np.argmax(np.where(deep, speed, -1.0)))]
    raise ValueError(f"this river is nowhere {LEAST_DEPTH_M} m deep above the sea; choose one with more water")


class RaftGame:
    """A scene with a raft on one of its rivers. river: its number in scene.rivers. hurry: seconds of its a second."""

    def __init__(
        self, folder: Path, river: int, planet: str = "earth", quality: str = "medium", hurry: float = 1.0
    ) -> None:
        self.scene = pf.load_scene(planet)
        self.quality, self.hurry = quality, hurry
        rivers = self.scene.rivers(river + 1)
        if len(rivers) <= river:
            raise ValueError(f"river {river}: this planet has {len(rivers)}; see planetfall rivers {planet}")
        self.river = rivers[river]
        sampler = pf.TerrainSampler(self.scene)
        sea_level_m = self.scene.planet[pf.Ocean].sea_level_m
        self.rafts = Rafts(sampler, launch(sampler, self.river.path, sea_level_m), sea_level_m)
        latitude, longitude = pf.latitude_longitude(self.rafts.up[0])
        self.sun = pf.Sun(
            elevation_deg=SUN_ELEVATION_DEG,
            azimuth_deg=SUN_AZIMUTH_DEG,
            latitude_deg=float(latitude),
            longitude_deg=float(longitude),
        )
        self.gone_m = 0.0
        self._behind = self.rafts.ahead[0]
        self._parts = self._build(raft_files(folder))
        self._show()

    @property
    def time_s(self) -> float:
        """Of the raft's journey."""
        return float(self.rafts.time_s[0])

    def _build(self, files: dict[str, str]) -> list[tuple[Floats, Any]]:
        """(offset ahead, to port and up; object) of every part."""
        found: list[tuple[Floats, Any]] = []
        log_m = BEAM_M / _LOGS

        def part(form: str, offset: Sequence[float], size: Triple, color: Triple) -> None:
            shape = pf.Shape(form, size, color=color, roughness=0.85)
            prop = self.scene.add(pf.Transform(tuple(self.rafts.positions_m[0])), shape, name=f"raft {len(found)}")
            found.append((np.array(offset, dtype=np.float64), prop))

        for k in range(_LOGS):
            shade = 0.8 + 0.4 * ((k * 5) % _LOGS) / _LOGS
            length = LENGTH_M * (0.93 + 0.07 * ((k * 3) % _LOGS) / _LOGS)
            tint = (0.2 * shade, 0.12 * shade, 0.06 * shade)
            # Logs lie DRAFT_M deep.
            part(
                files["log"],
                (0.0, (k - 0.5 * (_LOGS - 1)) * log_m, 0.5 * log_m - DRAFT_M),
                (length, log_m, log_m),
                tint,
            )
        for x in (-0.36, 0.36):
            part("box", (x * LENGTH_M, 0.0, log_m - DRAFT_M + 0.05), (0.16, BEAM_M, 0.1), (0.1, 0.06, 0.03))
        deck = log_m - DRAFT_M + 0.1
        part("box", (-0.9, 0.0, deck + 0.45), (1.3, 1.5, 0.9), (0.45, 0.36, 0.2))
        part("box", (-0.9, 0.0, deck + 0.95), (1.6, 1.8, 0.1), (0.5, 0.09, 0.04))
        part("box", (1.2, 0.0, deck + 1.1), (0.09, 0.09, 2.2), (0.16, 0.1, 0.05))
        part("box", (0.97, 0.0, deck + 1.95), (0.4, 0.03, 0.3), (0.6, 0.5, 0.05))
        return found

    def advance(self, dt_s: float) -> None:
        """dt_s of the player's time further, and into the scene."""
        left_s = dt_s * self.hurry
        for _ in range(_MOST_STEPS):
            step_s = min(left_s, float(self.rafts.longest_step_s()[0]))
            if step_s <= 0.0:
                break
            before = self.rafts.up[0]
            self.rafts.step(step_s)
            self.gone_m += float(np.linalg.norm(self.rafts.up[0] - before)) * self.rafts.sampler.radius_m
            left_s -= step_s
        # The camera swings round behind the raft within seconds.
        way = self._behind + (self.rafts.ahead[0] - self._behind) * -np.expm1(-dt_s / 3.0)
        self._behind = way / np.linalg.norm(way)
        self._show()

    def _show(self) -> None:
        middle, up, ahead = self.rafts.positions_m[0], self.rafts.up[0], self.rafts.ahead[0]
        frame = np.stack([ahead, np.cross(up, ahead), up], axis=1)
        turn = quaternion_of(frame)
        places = np.array([middle + frame @ offset for offset, _ in self._parts])
        self.scene.move([prop for _, prop in self._parts], places, np.tile(turn, (len(places), 1)))

    def camera(self) -> pf.Camera:
        """16 m behind the raft and 5 m over it, looking past it down the river; never in the ground or the water."""
        middle, up = self.rafts.positions_m[0], self.rafts.up[0]
        back = self._behind - up * (self._behind @ up)
        back /= np.linalg.norm(back)
        eye = middle - 16.0 * back + 4.0 * np.cross(up, back) + 5.0 * up
        zenith = eye / np.linalg.norm(eye)
        sampler = self.rafts.sampler
        ground = float(sampler.height(zenith[None])[0])
        lowest = sampler.radius_m + max(ground + 2.0, float(self.rafts.height_m[0]) + 2.0)
        eye = zenith * max(float(np.linalg.norm(eye)), lowest)
        ahead = middle + 10.0 * back + 1.0 * up - eye
        return pf.Camera(position_m=_triple(eye), forward=_triple(ahead), up=_triple(zenith), fov_y_deg=50.0)

    def follow(self, dt_s: float) -> pf.Camera:
        """A frame of a window: the raft moves, and where it is seen from."""
        self.advance(dt_s)
        return self.camera()

    def release(self) -> None:
        self.scene.release()


def record(game: RaftGame, options: argparse.Namespace) -> None:
    """Numbered pictures, `fps` of them a second; prints how far the raft has come."""
    options.output.mkdir(parents=True, exist_ok=True)
    with pf.Renderer(game.scene, options.size, options.quality) as renderer:
        for number in range(options.frames or 240):
            dt_s = options.skip_s if number == 0 else 1.0 / options.fps
            for _ in range(max(round(60.0 * dt_s), 1)):
                game.advance(1.0 / 60.0)
            camera = game.camera()
            if number == 0:
                renderer.settle(camera, game.time_s, sun=game.sun)
            picture = renderer.render(camera, game.time_s, game.sun, dt_s=1.0 / options.fps)["color"]
            file = options.output / f"raft_{number:04}.png"
            Image.fromarray(picture).save(file)
            sys.stdout.write(f"{file}\n")
    sys.stdout.write(
        f"river {game.river.number}: {game.gone_m / 1e3:.2f} km in {game.time_s / 3600.0:.2f} h, now "
        f"{game.rafts.height_m[0]:.0f} m above the sphere{', at sea' if game.rafts.at_sea[0] else ''}\n"
    )


def _triple(vector: Floats) -> Triple:
    x, y, z = vector
    return float(x), float(y), float(z)
