"""Pictures of other planets for the view of one: each is drawn small, by its own renderer, behind the air of the one
that the camera is near."""

from __future__ import annotations

from typing import NamedTuple, Protocol

import moderngl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..components import Ocean, Sun, Terrain
from ..engine.frame import Frame, View, Views
from ..engine.system import System
from ..errors import MissingError
from ..scene.companions import Body, SceneRevision
from ..systems.companions import PICTURE, Picture
from .discs import Part, hidden_by, part_of
from .planet import Moment, PlanetRenderer, Wanted

__all__ = ["Others", "PlanetSource", "Sky"]

_LOOKED_AT_DEG = 0.2
"""A spot is drawn again when it is seen, or lit, from a direction that differs by so much."""


class Sky(Protocol):
    """All planets at one time, in the axes of the scene's own."""

    @property
    def bodies(self) -> dict[str, Body]: ...
    @property
    def star_axes(self) -> NDArray[np.float64]: ...


class PlanetSource(Protocol):
    """What knows all planets of a scene, and who draws them."""

    own_name: str

    def now(self, time_s: float) -> Sky: ...
    def get(self, name: str, /) -> PlanetRenderer | None: ...
    def others_of(self, name: str) -> Others: ...
    def sun_over(self, body: Body, view: View) -> Sun: ...
    def stamp(self) -> tuple[SceneRevision, ...]: ...


class _SpotKey(NamedTuple):
    """What a spot's picture depends on, as far as a few pixels can show. forward, sun: directions in steps."""

    forward: tuple[float, ...]
    sun: tuple[float, ...]
    irradiance: tuple[float, float, float]
    scenes: tuple[SceneRevision, ...]


class _Around:
    """Of one view: the planets in its picture. jitter_px: of a view that is a picture for another planet's."""

    def __init__(self) -> None:
        self.jitter_px: tuple[float, float] | None = None
        self.drawn: dict[str, _Drawn] = {}
        self.shown: list[_Drawn] = []
        """In its last frame."""

    def release(self) -> None:
        for name in list(self.drawn):
            self.forget(name)

    def forget(self, name: str) -> None:
        gone = self.drawn.pop(name, None)
        if gone is not None:
            self.shown = [drawn for drawn in self.shown if drawn is not gone]
            gone.release()


class Others:
    """What the companions' system of one planet's renderer asks for: pictures of the others (CompanionSource). views:
    of that renderer."""

    def __init__(self, planets: PlanetSource, name: str, views: Views) -> None:
        self._planets, self._name, self._views = planets, name, views

    def _of(self, view: View) -> _Around:
        return view.state(self, _Around)

    def prepare(self, frame: Frame) -> bool:
        sky = self._planets.now(frame.time_s)
        frame.star_axes = (
            None if self._name == self._planets.own_name else sky.bodies[self._name].axes.T @ sky.star_axes
        )
        jitter = self._of(frame.view).jitter_px
        if jitter is None:
            return False
        frame.jitter_px, frame.backdrop = jitter, False
        return True

    def stamp(self) -> tuple[SceneRevision, ...]:
        return self._planets.stamp()

    def settled(self, view: View) -> bool:
        return all(drawn.settled() for drawn in self._of(view).shown)

    def progress(self, view: View) -> float:
        return min((drawn.progress() for drawn in self._of(view).shown), default=1.0)

    def pictures(self, frame: Frame) -> list[Picture]:
        bodies = self._planets.now(frame.time_s).bodies
        main = bodies[self._name]
        around = self._of(frame.view)
        around.shown = []
        found: list[tuple[float, Picture]] = []
        for body in bodies.values():
            if body.name == self._name:
                continue
            seen = body.seen_from(main)
            drawn = around.drawn.get(body.name)
            away = seen.centre_m - frame.camera.position_m
            if hidden_by(main, _lowest_m(main), frame.camera.position_m, seen.centre_m, seen.reach_m):
                continue
            part = part_of(frame.camera, frame.size, seen, None if drawn is None else drawn.view.size)
            if part is None:
                continue
            if drawn is None:
                planet = self._planets.get(body.name)
                if planet is None:
                    raise MissingError(f"planet {body.name!r} has no renderer yet")
                drawn = around.drawn[body.name] = _Drawn(planet, part.size)
            texture = drawn.texture(self._planets, body, part, frame)
            around.shown.append(drawn)
            power = float(away @ away) - seen.reach_m**2
            found.append((power, Picture(texture, part.corner_px, part.texel_px, part.rect, part.spot_px)))
        return [picture for _, picture in sorted(found, key=lambda pair: -pair[0])]

    def part_jitter(self, view: View, jitter_px: tuple[float, float]) -> None:
        """This view of the planet is a picture for another one's camera."""
        self._of(view).jitter_px = jitter_px

    def forget(self, name: str) -> None:
        """A planet goes: one of the same name may come."""
        for around in self._views.states(self, _Around):
            around.forget(name)

    def release(self) -> None:
        self._views.forget(self)


class _Drawn:
    """A companion's view for one camera: its pictures, drawn when they have to be."""

    def __init__(self, planet: PlanetRenderer, size: tuple[int, int]) -> None:
        self.planet, self.view = planet, planet.add_view(size)
        self._spot: _SpotKey | None = None
        self._texture: moderngl.Texture | None = None

    def texture(self, planets: PlanetSource, body: Body, part: Part, frame: Frame) -> moderngl.Texture:
        """PICTURE of the part of a frame's picture that shows this planet."""
        planet, view = self.planet, self.view
        sun = planets.sun_over(body, view)
        key = self._spot_key(planets, part, sun) if not part.texels and not frame.settling else None
        if key is not None and key == self._spot and self._texture is not None:
            return self._texture
        jitter = (frame.jitter_px[0] * part.texels, frame.jitter_px[1] * part.texels)
        planets.others_of(body.name).part_jitter(view, jitter)
        view.resize(part.size)
        moment = Moment(part.camera, planet.sun_state(sun, frame.time_s), frame.time_s)
        planet.draw(
            view,
            moment,
            Wanted(
                frozenset({PICTURE}), frame.dt_s, settling=frame.settling, one_shot=frame.one_shot, exact=frame.exact
            ),
        )
        self._texture = shown = view.compiled().resource(PICTURE)
        self._spot = key if self.settled() else None
        return shown

    def settled(self) -> bool:
        return all(system.settled(self.view) for system in _drawing(self.planet))

    def progress(self) -> float:
        return min((system.progress(self.view) for system in _drawing(self.planet)), default=1.0)

    def _spot_key(self, planets: PlanetSource, part: Part, sun: Sun) -> _SpotKey:
        step = np.radians(_LOOKED_AT_DEG)

        def steps(direction: ArrayLike) -> tuple[float, ...]:
            return tuple(np.round(np.asarray(direction) / step).tolist())

        return _SpotKey(steps(part.camera.forward), steps(sun.direction or ()), sun.irradiance, planets.stamp())

    def release(self) -> None:
        self.planet.release_view(self.view)


def _drawing(planet: PlanetRenderer) -> list[System]:
    """The systems that a companion's picture waits for: exposure and anti-aliasing are the camera's planet's."""
    return [system for system in planet.running if system.name not in ("composite", "companions")]


def _lowest_m(body: Body) -> float:
    """Radius of the lowest surface that hides what is behind."""
    handle = body.scene.planet
    sea, ground = handle.get(Ocean), handle.get(Terrain)
    if sea is None and ground is None:
        return 0.0
    lowest = [h for h in (sea and sea.sea_level_m, ground and ground.lowest_m) if h is not None]
    return body.radius_m + max(lowest)
