"""The planets of a renderer's scene: who draws which, from where, and what stands before what.

Each planet has a renderer of its own, on one context. The camera's planet is that which no other can hide
(`companions.nearest`); its renderer makes the picture. The others that are in sight are drawn by theirs, each into a
small picture of its disc with the pixels of the large one (`others`), which the camera's planet shows behind its air.
So it makes no difference to the picture whose turn it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..camera.place import Pose, SceneCamera
from ..components import Sun
from ..engine.frame import SunState, View
from ..engine.frame.backdrop import SOURCE
from ..engine.settings import PartRevision
from ..engine.space import CameraState
from ..scene.companions import Body, SceneRevision, bodies, nearest, own_revisions
from ..scene.scene import Scene
from ..systems.composite import CompositeSystem
from ..systems.light.sun import resolve_sky, resolve_sun
from .others import Others
from .planet import PlanetRenderer

if TYPE_CHECKING:
    from .faults import Faults

__all__ = ["DrawRequest", "Planets"]


class _MomentKey(NamedTuple):
    """Equal for equal moments. sun: one in place of the scene's; over: the planet in whose axes it is."""

    time_s: float
    over: str
    scene_sun: PartRevision
    sun: PartRevision | None
    scenes: tuple[SceneRevision, ...]


class _Company(NamedTuple):
    """Which companions there are: their names, and ids of their scenes."""

    structure: int
    scenes: tuple[tuple[str, int], ...]


@dataclass(frozen=True, eq=False)
class Ephemeris:
    """Planets, and sun and stars in the axes of the scene's own planet, at one time."""

    time_s: float
    bodies: dict[str, Body]
    sun: SunState
    star_axes: NDArray[np.float64]
    key: _MomentKey


class _HeldSun:
    """A sun over one planet, as a component: the same one while nothing changes."""

    def __init__(self) -> None:
        self._key: tuple[float, ...] = ()
        self._sun = Sun()

    def over(self, body: Body, ephemeris: Ephemeris) -> Sun:
        """The sun of that moment in the planet's own axes."""
        shining = ephemeris.sun
        (x, y, z), (red, green, blue) = (body.axes.T @ shining.direction).tolist(), shining.irradiance.tolist()
        key = (x, y, z, red, green, blue, shining.angular_radius_rad)
        if key != self._key:
            self._key = key
            self._sun = Sun(direction=(x, y, z), irradiance=(red, green, blue), angular_radius_rad=key[6])
        return self._sun


@dataclass(frozen=True, eq=False)
class DrawRequest:
    """Which planet's renderer makes a picture, of what.

    planet: the renderer of the planet that the camera is near. camera: in that planet's axes. sun: over that
    planet. home, main: the planet in whose axes the camera was given, and the one that it is near; None where the scene
    has one planet.
    """

    planet: PlanetRenderer
    camera: SceneCamera
    sun: SunState
    time_s: float
    home: Body | None = None
    main: Body | None = None

    @property
    def moved(self) -> bool:
        """Whether answers have to be turned back into the axes that the camera was given in."""
        return self.home is not None and self.main is not None and self.home.name != self.main.name

    def camera_in_scene(self, state: CameraState) -> CameraState:
        """A camera over `planet` in the axes that it was given in."""
        if self.home is None or self.main is None or not self.moved:
            return state
        place = self.home.inside(self.main.outside(state.position_m))
        turn = self.home.axes.T @ self.main.axes
        forward, up, right = (turn @ v for v in (state.forward, state.up, state.right))
        sides = (state.tan_left, state.tan_right, state.tan_bottom, state.tan_top)
        return CameraState(place, forward, up, right, *sides, near_m=state.near_m)

    def arrays_in_scene(self, arrays: dict[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
        """Arrays of a picture with their directions in those axes."""
        if self.home is not None and self.main is not None and self.moved:
            turn = (self.home.axes.T @ self.main.axes).T
            for name in arrays.keys() & {"position", "normal"}:
                arrays[name] = (arrays[name].astype(np.float64) @ turn).astype(arrays[name].dtype)
        return arrays


class Planets(Mapping[str, PlanetRenderer]):
    """The renderers of a scene's planets by name. While there is only one this costs nothing.

    own: of the scene's own planet. make: a renderer for the scene of a companion, on the same context.
    """

    def __init__(self, own: PlanetRenderer, make: Callable[[Scene], PlanetRenderer]) -> None:
        self.own, self.own_name = own, own.scene.planet.name
        self._make = make
        self._members: dict[str, PlanetRenderer] = {}
        self._others: dict[str, Others] = {}
        self._suns: dict[str, _HeldSun] = {}
        """Over each planet, as the camera of the last request."""
        self._company: _Company | None = None
        self._ephemeris: Ephemeris | None = None
        self.gone: list[Callable[[str], None]] = []
        """Called with a planet's name when its renderer has been released."""

    def __getitem__(self, name: str) -> PlanetRenderer:
        return self.own if name == self.own_name else self._members[name]

    def __iter__(self) -> Iterator[str]:
        return iter((self.own_name, *self._members))

    def __len__(self) -> int:
        return 1 + len(self._members)

    @property
    def several(self) -> bool:
        """Whether there are, or were a moment ago, other planets than the scene's own."""
        return bool(self.own.scene.companions) or bool(self._members)

    # -- which planet is drawn -----------------------------------------------------------------------------------------

    def request(self, placed: SceneCamera, time_s: float | None, sun: Sun | None) -> DrawRequest:
        """For a camera in the scene. time_s, sun: as given with it; None: those of its view, or the scene's."""
        time_s = (placed.time_s or 0.0) if time_s is None else time_s
        own, scene = self.own, self.own.scene
        sun = placed.sun if sun is None else sun
        if not self.several:
            return DrawRequest(own, placed, own.sun_state(scene.sun if sun is None else sun, time_s), time_s)
        ephemeris = self._ephemeris_at(time_s, sun, placed.planet.name)
        home = ephemeris.bodies[placed.planet.name]
        main = nearest(list(ephemeris.bodies.values()), home.outside(placed.pose.position_m))
        planet = self[main.name]
        if home.name != main.name:
            pose, turned = placed.pose, main.axes.T @ home.axes
            place = main.inside(home.outside(pose.position_m))
            placed = SceneCamera(main.scene.planet, Pose(place, turned @ pose.forward, turned @ pose.up), placed.optics)
        elif planet is own:
            return DrawRequest(
                own, placed, own.sun_state(scene.sun if sun is None else sun, time_s), time_s, home, main
            )
        over = scene.sun
        if planet is not own or sun is not None:
            over = self._suns.setdefault(main.name, _HeldSun()).over(main, ephemeris)
        return DrawRequest(planet, placed, planet.sun_state(over, time_s), time_s, home, main)

    def _ephemeris_at(self, time_s: float, sun: Sun | None, over: str) -> Ephemeris:
        """Where everything is. sun: in place of the scene's, in the axes of the planet `over`."""
        scene = self.own.scene
        given = None if sun is None else PartRevision.of(sun)
        key = _MomentKey(time_s, over if sun is not None else "", PartRevision.of(scene.sun), given, self.stamp())
        if self._ephemeris is not None and self._ephemeris.key == key:
            return self._ephemeris
        found = {body.name: body for body in bodies(scene, time_s, stars_stand=sun is not None)}
        if sun is None:
            sky = resolve_sky(scene.sun, scene.planet.planet, time_s)
            shining, stars = sky.sun, sky.star_axes
        else:
            home = found.get(over, found[self.own_name])
            own_sun = resolve_sun(sun, home.scene.planet.planet, time_s)
            shining = SunState(home.axes @ own_sun.direction, own_sun.irradiance, own_sun.angular_radius_rad)
            stars = np.eye(3)
        self._ephemeris = Ephemeris(time_s, found, shining, stars, key)
        self._kept_sun = sun  # with the key that holds its id
        return self._ephemeris

    def now(self, time_s: float) -> Ephemeris:
        """The planets at the time of a frame: those of the last request."""
        if self._ephemeris is None or self._ephemeris.time_s != time_s:
            return self._ephemeris_at(time_s, None, "")
        return self._ephemeris

    def sun_over(self, body: Body, view: View) -> Sun:
        """The last request's sun in the axes of a planet that the view is of."""
        assert self._ephemeris is not None
        return view.state(self, _HeldSun).over(body, self._ephemeris)

    def hand_over(self, before: str, after: str) -> None:
        """Go on with the exposure that another planet's renderer had come to."""
        if before not in self or after not in self:
            return
        old, new = self[before], self[after]
        new.first_view.cut = True
        was, now = (next(s for s in planet.systems if isinstance(s, CompositeSystem)) for planet in (old, new))
        if was.exposed(old.first_view):
            now.go_on_from(was.reading_bytes(old.first_view))

    # -- the renderers ------------------------------------------------------------------------------------------------

    def take_company_change(self) -> bool:
        """True once after companions, or what belongs to the whole scene, have come or gone: then `keep_up` is due."""
        scene = self.own.scene
        scenes = tuple((name, id(companion.scene)) for name, companion in scene.companions.items())
        now = _Company(scene.world.structure_revision, scenes)
        before, self._company = self._company, now
        return now != before

    def keep_up(self) -> None:
        """Make renderers for planets that have come, release those of planets that have gone. Needs the context."""
        companions = self.own.scene.companions
        scenes = {name: companion.scene for name, companion in companions.items()}
        for name in [n for n, member in self._members.items() if scenes.get(n) is not member.scene]:
            self._let_go(name)
        for name, scene in scenes.items():
            if name not in self._members:
                self._members[name] = self._make(scene)
                self._join(name)
        companions.share_environment()
        if scenes and self.own_name not in self._others:
            self._join(self.own_name)
        elif not scenes and self.own_name in self._others:
            self._others.pop(self.own_name).release()
            self.own.world.remove_resource(SOURCE)
            self._stars_again(self.own)

    def _join(self, name: str) -> None:
        others = self._others[name] = Others(self, name, self[name].views)
        self[name].world.set_resource(SOURCE, others)
        self._stars_again(self[name])

    @staticmethod
    def _stars_again(planet: PlanetRenderer) -> None:
        """Stars have other programs where planets can hide them."""
        stars = planet.system("stars")
        if stars is not None:
            planet.switch_off(stars)
        planet.gate_again()

    def _let_go(self, name: str) -> None:
        self._others.pop(name).release()
        for others in self._others.values():
            others.forget(name)
        for callback in self.gone:
            callback(name)
        self._members.pop(name).release()

    def others_of(self, name: str) -> Others:
        """Who draws the others for that planet's views."""
        return self._others[name]

    def faults(self) -> list[Faults]:
        """Systems of the other planets that are switched off."""
        return [member.faults for member in self._members.values()]

    def stamp(self) -> tuple[SceneRevision, ...]:
        """Changes with everything that planets show or where they are."""
        scene = self.own.scene
        return (own_revisions(scene), *(own_revisions(c.scene) for c in scene.companions.values()))

    def release(self) -> None:
        """Release all renderers. Needs the context."""
        for name in list(self._members):
            self._let_go(name)
        self.own.release()
