"""Stones roll down a mountain side in the evening sun: in a window, or as pictures with --frames."""

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

from .stones import stone_files

Floats = NDArray[np.float64]

LATITUDE_DEG, LONGITUDE_DEG = 50.0399, 130.7471
"""A slope of 6 degrees, 1.6 km long, 555 m above the sea: 6371 km from the planet's centre."""
PUSH_M_S = 20.0
SUN_ELEVATION_DEG, SUN_AZIMUTH_DEG = 9.0, 290.0
_MOST_STEPS = 12
"""A frame: slower machines see the stones roll more slowly."""


def triple(vector: Sequence[float] | Floats) -> tuple[float, float, float]:
    x, y, z = vector
    return float(x), float(y), float(z)


class Game:
    """A scene with stones in it. Every stone is one object of the scene; the engine's places go to it once a frame."""

    def __init__(self, count: int, folder: Path, planet: str = "earth", quality: str = "medium", seed: int = 1) -> None:
        from .simulation import on_slope

        self.scene = pf.load_scene(planet)
        self.quality = quality
        self.sun = pf.Sun(
            elevation_deg=SUN_ELEVATION_DEG,
            azimuth_deg=SUN_AZIMUTH_DEG,
            latitude_deg=LATITUDE_DEG,
            longitude_deg=LONGITUDE_DEG,
        )
        sampler = pf.TerrainSampler(self.scene)
        self.stones = on_slope(sampler, pf.direction(LATITUDE_DEG, LONGITUDE_DEG), count, PUSH_M_S, seed)
        rng = np.random.default_rng(seed)
        files = stone_files(folder)
        grey = rng.uniform(0.09, 0.2, (count, 1)) * (1.0 + rng.uniform(0.0, 0.25, (count, 1)) * [1.0, 0.2, -1.0])
        self.props = [
            self.scene.add(
                pf.Transform(triple(place)),
                pf.Shape(files[k % len(files)], triple([radius] * 3), color=triple(grey[k]), roughness=0.85),
                name=f"stone {k}",
            )
            for k, (place, radius) in enumerate(zip(self.stones.positions_m, self.stones.radii_m, strict=True))
        ]
        self._owed_s = 0.0

    def advance(self, dt_s: float) -> None:
        """The stones dt_s further, in whole steps, and into the scene."""
        from .simulation import STEP_S

        self._owed_s = min(self._owed_s + dt_s, _MOST_STEPS * STEP_S)
        while self._owed_s >= STEP_S:
            self.stones.step()
            self._owed_s -= STEP_S
        self.scene.move(self.props, self.stones.positions_m, self.stones.orientations)

    def camera(self) -> pf.Camera:
        """Behind the stones and above them, looking down the slope after them; never below the ground."""
        positions, speeds = self.stones.positions_m, self.stones.velocities_m_s
        middle = np.median(positions, axis=0)
        up = middle / np.linalg.norm(middle)
        way = np.median(speeds, axis=0)
        way -= up * (way @ up)
        way /= np.linalg.norm(way)
        side = np.cross(way, up)
        back = np.ptp(positions @ way) * 0.5
        place = middle - way * (back + 14.0) + side * 9.0 + up * 9.0
        zenith = place / np.linalg.norm(place)
        sampler = self.stones.sampler
        ground = sampler.radius_m + float(sampler.height(zenith[None])[0])
        place = zenith * max(float(np.linalg.norm(place)), ground + 4.0)
        return pf.Camera(
            position_m=triple(place), forward=triple(middle + way * 8.0 - place), up=triple(zenith), fov_y_deg=50
        )

    def release(self) -> None:
        self.scene.release()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the game; returns the exit code: 2 for an error that the message explains."""
    options = parse(arguments)
    try:
        game = Game(options.count, options.output, quality=options.quality, seed=options.seed)
    except ImportError as error:
        sys.stderr.write(f"rolling_stones: {error}; install what it needs with pip install 'planetfall[games]'\n")
        return 2
    except pf.expected_errors() as error:
        sys.stderr.write(f"rolling_stones: {error}\n")
        return 2
    try:
        if options.frames or not pf.has_display():
            return record(game, options)
        pf.fly(
            game.scene, game.camera(), sun=game.sun, size=options.size, quality=options.quality,
            on_frame=lambda _, dt_s: game.advance(dt_s),
        )  # fmt: skip
        return 0
    finally:
        game.release()


def record(game: Game, options: Any) -> int:
    """Numbered pictures, `fps` of them a second of the stones' time; prints what the stones did."""
    options.output.mkdir(parents=True, exist_ok=True)
    deepest, path = -np.inf, np.zeros(len(game.props))
    with pf.Renderer(game.scene, options.size, options.quality) as renderer:
        for number in range(options.frames or 240):
            before = game.stones.positions_m
            for _ in range(round(options.skip_s * 60.0) if number == 0 else 0):
                game.advance(1.0 / 60.0)
            for _ in range(max(round(60.0 / options.fps), 1) if number else 0):
                game.advance(1.0 / 60.0)
            path += np.linalg.norm(game.stones.positions_m - before, axis=1)
            deepest = max(deepest, float(game.stones.depths_m.max()))
            camera = game.camera()
            if number == 0:
                renderer.settle(camera, sun=game.sun)
            picture = renderer.render(camera, game.stones.time_s, game.sun, dt_s=1.0 / options.fps)["color"]
            file = options.output / f"stones_{number:04}.png"
            Image.fromarray(picture).save(file)
            sys.stdout.write(f"{file}\n")
    sys.stdout.write(
        f"{len(game.props)} stones, {game.stones.time_s:.1f} s: rolled {path.min():.0f} to {path.max():.0f} m over "
        f"{game.stones.patches_made} patches of ground, at most {1e3 * deepest:.1f} mm deep in it\n"
    )
    return 0


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="rolling_stones", description=__doc__)
    parser.add_argument("--count", type=int, default=200, help="number of stones")
    parser.add_argument("--frames", type=int, default=0, help="render so many pictures instead of opening a window")
    parser.add_argument("--fps", type=float, default=30.0, help="pictures a second of the stones' time")
    parser.add_argument("--skip-s", type=float, default=0.0, help="let them roll so long before the first picture")
    parser.add_argument("--size", type=int, nargs=2, default=(1280, 720), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--quality", default="medium", help="low, medium, high or ultra")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--output", "-o", type=Path, default=Path("stones"), help="folder of pictures and stones' shapes"
    )
    options = parser.parse_args(arguments)
    if options.count < 1 or options.frames < 0 or options.fps <= 0.0 or options.skip_s < 0.0:
        parser.error("--count from 1, --frames and --skip-s from 0, --fps above 0")
    options.size = tuple(options.size)
    return options


if __name__ == "__main__":
    sys.exit(main())
