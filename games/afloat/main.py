"""A boat rounds buoys in the swell, or a raft drifts down a river: in a window, or as pictures with --frames."""

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

from . import raft, shapes
from .floating import STEP_S, Body, Flotilla, boat_hull, disc_hull
from .turning import axes_of, upright

Floats = NDArray[np.float64]

LATITUDE_DEG, LONGITUDE_DEG = 37.6337, 140.5655
"""Water 150 m deep, land a mile off."""
SUN_ELEVATION_DEG, SUN_AZIMUTH_DEG = 28.0, 250.0
RIVER = 9
"""That the raft drifts down."""
_MOST_STEPS = 8
"""A frame: slower machines see slower waves."""
_KNOTS = 0.514444
_ORANGE, _WHITE, _GREEN = (0.75, 0.16, 0.03), (0.7, 0.7, 0.68), (0.04, 0.3, 0.12)


def triple(vector: Sequence[float] | Floats) -> tuple[float, float, float]:
    x, y, z = vector
    return float(x), float(y), float(z)


class Game:
    """A scene with a boat and buoys. Each part of them is one object of the scene, moved once a frame."""

    def __init__(
        self,
        folder: Path,
        planet: str = "earth",
        quality: str = "medium",
        buoys: int = 5,
        wind_speed_m_s: float = 1.5,
        swell_height_m: float = 1.6,
    ) -> None:
        self.scene = pf.load_scene(planet)
        self.quality = quality
        ocean = self.scene.planet[pf.Ocean]
        ocean.wind_speed_m_s, ocean.swell_height_m = wind_speed_m_s, swell_height_m
        self.sun = pf.Sun(
            elevation_deg=SUN_ELEVATION_DEG,
            azimuth_deg=SUN_AZIMUTH_DEG,
            latitude_deg=LATITUDE_DEG,
            longitude_deg=LONGITUDE_DEG,
        )
        sampler = pf.OceanSampler(self.scene)
        self.centre = pf.direction(LATITUDE_DEG, LONGITUDE_DEG)
        self._east, self._north = east_north(self.centre)
        float_hull = disc_hull(shapes.BUOY_M, shapes.BUOY_DRAFT_M, shapes.BUOY_FREEBOARD_M)
        angles = 2.0 * np.pi * np.arange(buoys) / max(buoys, 1)
        self.marks = [self.place(32.0 * np.cos(a), 32.0 * np.sin(a)) for a in angles]
        bodies = [self._float(sampler, float_hull, mark, 0.0) for mark in self.marks]
        for body, mark in zip(bodies, self.marks, strict=True):
            body.anchored_at = mark
        self.boat = self._float(
            sampler, boat_hull(shapes.hull_sections(8, 7), shapes.DECK_M), self.place(44.0, -10.0), 0.0
        )
        self.sea = Flotilla(sampler, [*bodies, self.boat], ocean.gravity_m_s2)
        self._parts = self._build(shapes.write(folder))
        self._owed_s = 0.0
        self._show()

    def place(self, east_m: float, north_m: float) -> Floats:
        """The direction (3,) of a point of the course."""
        there = self.centre + (east_m * self._east + north_m * self._north) / self.scene.planet.radius_m
        return there / np.linalg.norm(there)

    @staticmethod
    def _float(sampler: pf.OceanSampler, hull: Any, where: Floats, heading_deg: float) -> Body:
        height = sampler.radius_m + float(sampler.height(where[None], 0.0)[0])
        return Body(hull, where * height, upright(where, heading_deg))

    def _build(self, files: dict[str, str]) -> list[tuple[Body, Floats, Any]]:
        """(body, offset in its axes, object) of every part."""
        found: list[tuple[Body, Floats, Any]] = []

        def part(body: Body, name: str, form: str, offset: Sequence[float], size: Sequence[float], color: Any) -> None:
            shape = pf.Shape(form, triple(size), color=color, roughness=0.5)
            prop = self.scene.add(pf.Transform(triple(body.position_m)), shape, name=name)
            found.append((body, np.array(offset, dtype=np.float64), prop))

        for number, body in enumerate(self.sea.bodies[:-1]):
            name = f"buoy {number}"
            color = _ORANGE if number % 2 == 0 else _GREEN
            part(body, name, files["drum"], (0, 0, 0), (1, 1, 1), color)
            part(body, f"{name} band", files["band"], (0, 0, 0), (1, 1, 1), _WHITE)
            part(body, f"{name} mast", "box", (0, 0, 1.2), (0.12, 0.12, 1.6), color)
            part(body, f"{name} top", "sphere", (0, 0, 2.1), (0.5, 0.5, 0.5), color)
        part(self.boat, "hull", files["hull"], (0, 0, 0), (1, 1, 1), (0.55, 0.56, 0.58))
        part(self.boat, "cabin", "box", (-0.6, 0, 1.45), (2.6, 1.9, 1.3), (0.62, 0.6, 0.55))
        part(self.boat, "roof", "box", (-0.6, 0, 2.15), (3.0, 2.2, 0.12), (0.5, 0.08, 0.05))
        part(self.boat, "mast", "box", (-1.2, 0, 3.0), (0.1, 0.1, 1.8), _WHITE)
        return found

    def advance(self, dt_s: float) -> None:
        """dt_s further, in whole steps, and into the scene."""
        self._owed_s = min(self._owed_s + dt_s, _MOST_STEPS * STEP_S)
        while self._owed_s >= STEP_S:
            self._steer()
            self.sea.step()
            self._owed_s -= STEP_S
        self._show()

    def _steer(self) -> None:
        """Around the buoys, 12 m outside of them, at six knots: thrust and rudder in proportion to what is missing."""
        boat = self.boat
        frame = axes_of(boat.quaternion)
        up = boat.position_m / np.linalg.norm(boat.position_m)
        east, north = east_north(up)
        off = up - self.centre
        x, y = off @ self._east * self.sea.sampler.radius_m, off @ self._north * self.sea.sampler.radius_m
        distance = max(float(np.hypot(x, y)), 1.0)
        # Along the circle, and towards it.
        along = np.array([-y, x]) / distance + 0.06 * (44.0 - distance) * np.array([x, y]) / distance
        wanted = along[0] * east + along[1] * north
        wanted /= np.linalg.norm(wanted)
        ahead = frame[:, 0] - up * (frame[:, 0] @ up)
        ahead /= np.linalg.norm(ahead)
        error = float(np.arctan2(np.cross(ahead, wanted) @ up, ahead @ wanted))
        boat.rudder = float(np.clip(1.2 * error, -0.8, 0.8))
        speed = float(boat.velocity_m_s @ ahead)
        boat.thrust_n = float(np.clip(2.0 * (6.0 * _KNOTS - speed), 0.0, 3.0)) * boat.hull.mass_kg

    def _show(self) -> None:
        turned = {id(body): axes_of(body.quaternion) for body in self.sea.bodies}
        places = [body.position_m + turned[id(body)] @ offset for body, offset, _ in self._parts]
        self.scene.move(
            [prop for *_, prop in self._parts],
            np.array(places),
            np.array([body.quaternion for body, *_ in self._parts]),
        )

    def camera(self) -> pf.Camera:
        """24 m outside of the boat, low over the water, looking at it and past it at the buoys."""
        target = self.boat.position_m
        up = target / np.linalg.norm(target)
        out = up - self.centre
        out /= np.linalg.norm(out)
        place = target + 24.0 * out - 8.0 * axes_of(self.boat.quaternion)[:, 0]
        place /= np.linalg.norm(place)
        sampler = self.sea.sampler
        crest = sampler.sea_level_m + float(np.sum(sampler.waves.amplitude_m))
        eye = place * (sampler.radius_m + crest + 1.5)
        return pf.Camera(
            position_m=triple(eye), forward=triple(target + 1.0 * up - eye), up=triple(place), fov_y_deg=40
        )

    def release(self) -> None:
        self.scene.release()


def east_north(up: Floats) -> tuple[Floats, Floats]:
    east = np.cross([0.0, 0.0, 1.0], up)
    east /= np.linalg.norm(east)
    return east, np.cross(up, east)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the game; returns the exit code: 2 for an error that the message explains."""
    options = parse(arguments)
    if options.raft is not None:
        return drift(options)
    try:
        game = Game(
            options.output,
            quality=options.quality,
            buoys=options.buoys,
            wind_speed_m_s=options.wind,
            swell_height_m=options.swell,
        )
    except pf.expected_errors() as error:
        sys.stderr.write(f"afloat: {error}\n")
        return 2
    try:
        if options.frames or not pf.has_display():
            return record(game, options)
        # The window's time and the boats' are one: both go by dt_s.
        pf.fly(
            game.scene, game.camera(), sun=game.sun, size=options.size, quality=options.quality,
            on_frame=lambda time_s, dt_s: follow(game, time_s, dt_s),
        )  # fmt: skip
        return 0
    finally:
        game.release()


def drift(options: Any) -> int:
    """A raft in place of the boat; returns the exit code."""
    try:
        game = raft.RaftGame(options.output, options.raft, quality=options.quality, hurry=options.hurry)
    except pf.expected_errors() as error:
        sys.stderr.write(f"afloat: {error}\n")
        return 2
    try:
        if options.frames or not pf.has_display():
            raft.record(game, options)
        else:
            pf.fly(
                game.scene, game.camera(), sun=game.sun, size=options.size, quality=options.quality,
                on_frame=lambda _, dt_s: game.follow(dt_s),
            )  # fmt: skip
        return 0
    finally:
        game.release()


def follow(game: Game, time_s: float, dt_s: float) -> None:
    """The boats up to the sea that is about to be drawn."""
    game.sea.time_s = time_s - dt_s if abs(game.sea.time_s - time_s) > 1.0 else game.sea.time_s
    game.advance(dt_s)


def record(game: Game, options: Any) -> int:
    """Numbered pictures, `fps` of them a second; prints how the buoys kept their waterline."""
    options.output.mkdir(parents=True, exist_ok=True)
    worst_m = 0.0
    with pf.Renderer(game.scene, options.size, options.quality) as renderer:
        for number in range(options.frames or 240):
            for _ in range(round((options.skip_s if number == 0 else 1.0 / options.fps) / STEP_S)):
                game.advance(STEP_S)
            if number or options.skip_s >= 2.0:
                worst_m = max(worst_m, *(abs(game.sea.waterline_m(b)) for b in game.sea.bodies))
            camera = game.camera()
            if number == 0:
                renderer.settle(camera, game.sea.time_s, sun=game.sun)
            picture = renderer.render(camera, game.sea.time_s, game.sun, dt_s=1.0 / options.fps)["color"]
            file = options.output / f"afloat_{number:04}.png"
            Image.fromarray(picture).save(file)
            sys.stdout.write(f"{file}\n")
    sys.stdout.write(
        f"{len(game.marks)} buoys and a boat, {game.sea.time_s:.1f} s: the sea was at most {100.0 * worst_m:.1f} cm "
        "from their waterlines\n"
    )
    return 0


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="afloat", description=__doc__)
    parser.add_argument("--buoys", type=int, default=5, help="number of buoys")
    parser.add_argument("--wind", type=float, default=1.5, help="wind in m/s")
    parser.add_argument("--swell", type=float, default=1.6, help="significant height of the swell in m")
    parser.add_argument(
        "--raft", type=int, nargs="?", const=RIVER, metavar="RIVER",
        help=f"drift down a river to the sea instead, {RIVER} of those that `planetfall rivers earth` lists or another",
    )  # fmt: skip
    parser.add_argument("--hurry", type=float, default=1.0, help="so many seconds of the raft's in one")
    parser.add_argument("--frames", type=int, default=0, help="render so many pictures instead of opening a window")
    parser.add_argument("--fps", type=float, default=30.0, help="pictures a second")
    parser.add_argument("--skip-s", type=float, default=2.0, help="let them float so long before the first picture")
    parser.add_argument("--size", type=int, nargs=2, default=(1280, 720), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--quality", default="medium", help="low, medium, high or ultra")
    parser.add_argument("--output", "-o", type=Path, default=Path("afloat"), help="folder of pictures and shapes")
    options = parser.parse_args(arguments)
    if options.buoys < 0 or options.frames < 0 or options.fps <= 0.0 or options.skip_s < 0.0:
        parser.error("--buoys, --frames and --skip-s from 0, --fps above 0")
    if (options.raft or 0) < 0 or not 0.0 < options.hurry < float("inf"):
        parser.error("--raft from 0, --hurry above 0")
    options.size = tuple(options.size)
    return options


if __name__ == "__main__":
    sys.exit(main())
