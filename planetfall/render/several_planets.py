"""Several planets in one picture: who draws which, from where, and what stands before what.

Each planet has a renderer of its own, on one context. The camera's planet is that which no other can hide
(`companions.nearest`); its renderer makes the picture. The others that are in sight are drawn by theirs, each into a
small picture of its disc with the pixels of the large one (`discs`), which the camera's planet shows behind its air.
So it makes no difference to the picture whose turn it is.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from ..camera.arguments import check_moment
from ..camera.camera import Camera
from ..camera.views import View
from ..components import Ocean, Sun, Terrain
from ..engine.backdrop import SOURCE
from ..engine.frame import Frame, SunState
from ..engine.settings import revision
from ..engine.space import CameraState
from ..errors import MissingError
from ..scene.companions import Body, bodies, nearest, own_revisions
from ..systems.companions import PICTURE, Picture
from ..systems.composite import CompositeSystem
from ..systems.light.sun import resolve_sky, resolve_sun
from .discs import Part, hidden_by, part_of

if TYPE_CHECKING:
    from ..engine.gpu import Gpu
    from ..scene.scene import Scene
    from .faults import Faults
    from .renderer import Renderer
    from .view import RenderView

__all__ = ["SeveralPlanets", "by_nearest"]

F = TypeVar("F", bound=Callable[..., Any])
Vector = NDArray[np.float64]

_LOOKED_AT_DEG = 0.2
"""A spot is drawn again when it is seen, or lit, from a direction that differs by so much."""


@dataclass(frozen=True, eq=False)
class Moment:
    """Planets, and sun and stars in the axes of the scene's own planet, at one time. key: equal for equal moments."""

    time_s: float
    bodies: dict[str, Body]
    sun: SunState
    star_axes: NDArray[np.float64]
    key: tuple[Any, ...]


def by_nearest(method: F) -> F:
    """Of a Renderer: in a scene of several planets the method of the renderer whose planet the camera is near."""
    signature = inspect.signature(method)
    names = list(signature.parameters)[1:]

    @functools.wraps(method)
    def call(self: Renderer, *args: Any, **kwargs: Any) -> Any:
        several = self._several
        if not several.there:
            return method(self, *args, **kwargs)
        given = {**dict(zip(names, args, strict=False)), **kwargs}
        signature.bind(self, *args, **kwargs)  # TypeError as the method itself
        return several.call(method, given, names)

    return cast(F, call)


class SeveralPlanets:
    """The planets of one renderer's scene. Costs nothing while there is only one."""

    def __init__(self, renderer: Renderer) -> None:
        self._own = renderer
        self._members: dict[str, Renderer] = {}
        self._sources: dict[str, _Source] = {}
        self._fronts: dict[int, str] = {}
        self._views: dict[tuple[str, int], RenderView] = {}
        self._suns: dict[tuple[str, int], tuple[tuple[Any, ...], Sun]] = {}
        self._stamp: tuple[Any, ...] = ()
        self._moment: Moment | None = None

    @property
    def there(self) -> bool:
        """Whether there are, or were a moment ago, other planets than the scene's own."""
        return bool(self._own.scene.companions) or bool(self._members)

    @property
    def front(self) -> Any:
        """Whose turn it was in the last frame: a renderer, or a view of one."""
        index = self._own._view_index
        name = self._fronts.get(index, "")
        return (
            self._own if name not in self._members else self._members[name] if not index else self._view_of(name, index)
        )

    @property
    def renderer(self) -> Renderer:
        """The renderer whose turn it was in the last frame."""
        return self._members.get(self._fronts.get(self._own._view_index, ""), self._own)

    @property
    def main(self) -> str:
        """The name of the planet that the last frame's camera was near."""
        return self._fronts.get(self._own._view_index, self._own.scene.planet.name)

    # -- whose turn it is ---------------------------------------------------------------------------------------------

    def call(self, method: Callable[..., Any], given: dict[str, Any], names: list[str]) -> Any:
        """A renderer's method with its arguments by name, for the planet that its camera is near. names: all that it
        takes."""
        own, index = self._own, self._own._view_index
        check_moment(given["camera"], given.get("time_s"), given.get("sun"))
        if self._is_behind():
            with own._guest():
                self._keep_up()
        home, main, changed = self._turn(given, names)
        before, self._fronts[index] = self._fronts.get(index, main.name), main.name
        if before != main.name:
            with own._guest():
                self._hand_over(before, main.name, index)
        if main.name == own.scene.planet.name:
            return self._answer(method.__name__, method(own, **changed), home, main)
        member = self._members[main.name]
        with own._guest(given.get("framebuffer")):
            front: Any = member if index == 0 else self._view_of(main.name, index)
            member.render_scale, member.tolerant = own.render_scale, own.tolerant
            if method.__name__ != "render_to":
                front.resize(own.size)
            result = getattr(front, method.__name__)(**changed)
            if method.__name__ == "render_to":
                own._resize(front.size)
            if method.__name__ in ("render", "render_to"):
                own.watch.after_frame(own.scene, member.running)
            own.python_ms = member.python_ms
        return self._answer(method.__name__, result, home, main)

    def _turn(self, given: dict[str, Any], names: list[str]) -> tuple[Body, Body, dict[str, Any]]:
        """The planet whose axes the camera is told in, the one that it is near, and the arguments in the latter's."""
        camera, scene = given["camera"], self._own.scene
        time_s, sun = given.get("time_s"), given.get("sun")
        view = camera if isinstance(camera, View) else None
        if time_s is None:
            time_s = view.time_s if view is not None else 0.0
        handle = camera._planet_in(scene)
        # Resolving the camera costs more than all of this; the renderer whose turn it is does it anyway.
        place = camera._pose[0] if camera._pose is not None else camera._requested().position_m(handle)
        sun = view.sun if sun is None and view is not None else sun
        moment = self.moment(time_s, sun, handle.name if handle is not None else "")
        home = moment.bodies[scene.planet.name if handle is None else handle.name]
        main = nearest(list(moment.bodies.values()), home.outside(place))
        own_name = scene.planet.name
        if main.name == home.name == own_name:
            return home, main, given
        changed = {**given, "camera": _moved(camera, scene, home, main)}
        if "time_s" in names:
            changed["time_s"] = time_s
        if "points_m" in given:
            points = np.atleast_2d(np.asarray(given["points_m"], dtype=np.float64))
            changed["points_m"] = np.array([main.inside(home.outside(point)) for point in points])
        if "sun" in names and (main.name != own_name or sun is not None):
            changed["sun"] = self._sun_for(main, moment, -1)
        return home, main, changed

    def moment(self, time_s: float, sun: Sun | None, over: str) -> Moment:
        """Where everything is. sun: in place of the scene's, in the axes of the planet `over`."""
        scene = self._own.scene
        key = (
            time_s, over if sun is not None else "", revision(scene.sun), id(scene.sun),
            None if sun is None else (id(sun), revision(sun)), self.stamp(),
        )  # fmt: skip
        if self._moment is not None and self._moment.key == key:
            return self._moment
        found = {body.name: body for body in bodies(scene, time_s, stars_stand=sun is not None)}
        if sun is None:
            sky = resolve_sky(scene.sun, scene.planet.planet, time_s)
            shining, stars = sky.sun, sky.star_axes
        else:
            home = found.get(over, found[scene.planet.name])
            told = resolve_sun(sun, home.scene.planet.planet, time_s)
            shining = SunState(home.axes @ told.direction, told.irradiance, told.angular_radius_rad)
            stars = np.eye(3)
        # `sun` is kept alive with the key that holds its id.
        self._moment = Moment(time_s, found, shining, stars, key)
        self._kept_sun = sun
        return self._moment

    def now(self, time_s: float) -> Moment:
        """The moment of a frame: that of the last call."""
        if self._moment is None or self._moment.time_s != time_s:
            return self.moment(time_s, None, "")
        return self._moment

    def _sun_for(self, body: Body, moment: Moment, view_index: int) -> Sun:
        """The sun in a planet's own axes; the same component while nothing changes."""
        shining = moment.sun
        direction = body.axes.T @ shining.direction
        (x, y, z), (red, green, blue) = direction.tolist(), shining.irradiance.tolist()
        key = (x, y, z, red, green, blue, shining.angular_radius_rad)
        held = self._suns.get((body.name, view_index))
        if held is None or held[0] != key:
            sun = Sun(direction=(x, y, z), irradiance=(red, green, blue), angular_radius_rad=key[6])
            held = self._suns[body.name, view_index] = (key, sun)
        return held[1]

    def _answer(self, method: str, result: Any, home: Body, main: Body) -> Any:
        """What a method returned, in the axes of the planet that its camera was told in."""
        if result is None or home.name == main.name:
            return result
        if method == "camera_state":
            place = home.inside(main.outside(result.position_m))
            turn = home.axes.T @ main.axes
            forward, up, right = (turn @ v for v in (result.forward, result.up, result.right))
            sides = (result.tan_left, result.tan_right, result.tan_bottom, result.tan_top)
            return CameraState(place, forward, up, right, *sides, near_m=result.near_m)
        if method == "pick":
            return home.inside(main.outside(result[0])), result[1]
        if method == "render":
            turn = (home.axes.T @ main.axes).T
            for name in ("position", "normal"):
                if name in result:
                    result[name] = (result[name].astype(np.float64) @ turn).astype(result[name].dtype)
        return result

    def _hand_over(self, before: str, after: str, index: int) -> None:
        """Go on with the exposure that another planet's renderer had come to."""
        old, new = self._member(before), self._member(after)
        if old is None or new is None or index:
            return
        new._cut = True
        was, now = (next(s for s in r.systems if isinstance(s, CompositeSystem)) for r in (old, new))
        if was.exposed:
            now.go_on_from(was.reading_bytes())

    # -- the renderers ------------------------------------------------------------------------------------------------

    def _member(self, name: str) -> Renderer | None:
        return self._own if name == self._own.scene.planet.name else self._members.get(name)

    def _is_behind(self) -> bool:
        """Whether companions have come or gone, or what belongs to the whole scene has."""
        scene = self._own.scene
        now = (scene.world.structure_revision, *((n, id(c.scene)) for n, c in scene.companions.items()))
        before, self._stamp = self._stamp, now
        return now != before

    def _keep_up(self) -> None:
        """Make renderers for planets that have come, release those of planets that have gone."""
        own = self._own
        scenes = {name: companion.scene for name, companion in own.scene.companions.items()}
        for name in [n for n, member in self._members.items() if scenes.get(n) is not member.scene]:
            self._let_go(name)
        for name, scene in scenes.items():
            if name not in self._members:
                self._members[name] = self._made(name, scene)
        own.scene.companions.share_environment()
        if scenes and own.scene.planet.name not in self._sources:
            self._join(own, own.scene.planet.name)
        elif not scenes and own.scene.planet.name in self._sources:
            self._part(own, own.scene.planet.name)

    def _made(self, name: str, scene: Any) -> Renderer:
        own = self._own
        quality, overrides, systems = own._made_with
        made = type(own)(scene, own.size, quality, overrides, ctx=own.ctx, systems=systems, guard=False)
        made.settings.update(own.settings)
        self._join(made, name)
        return made

    def _join(self, renderer: Renderer, name: str) -> None:
        source = self._sources[name] = _Source(self, name, renderer)
        renderer._resources[SOURCE] = source
        self._start_again(renderer)

    def _part(self, renderer: Renderer, name: str) -> None:
        self._sources.pop(name).release()
        renderer._resources.pop(SOURCE, None)
        self._start_again(renderer)

    @staticmethod
    def _start_again(renderer: Renderer) -> None:
        """Stars have other programs where planets can hide them."""
        for system in renderer.systems:
            if system.name == "stars":
                renderer._deactivate(system)
        renderer.gate_again()

    def _let_go(self, name: str) -> None:
        self._sources.pop(name).release()
        for source in self._sources.values():
            source.forget(name)
        for key in [key for key in self._views if key[0] == name]:
            del self._views[key]
        self._members.pop(name).release()
        self._fronts = {index: front for index, front in self._fronts.items() if front != name}

    def _view_of(self, name: str, index: int) -> RenderView:
        """A further view of the renderer's own, as a view of another planet's renderer."""
        if (name, index) not in self._views:
            self._views[name, index] = self._members[name].add_view(self._own.size)
        return self._views[name, index]

    def retune(self, changes: Mapping[str, Any]) -> None:
        """As Renderer.retune."""
        for member in self._members.values():
            member.retune(changes)

    def try_again(self) -> None:
        """As Renderer.try_again."""
        for member in self._members.values():
            member.try_again()

    def reload_shaders(self) -> list[str]:
        """As Renderer.reload_shaders."""
        return [name for member in self._members.values() for name in member.reload_shaders()]

    def faults(self) -> list[Faults]:
        """Systems of the other planets that are switched off."""
        return [member.faults for member in self._members.values()]

    def gpus(self) -> list[Gpu]:
        """What the other planets' renderers hold their objects by."""
        return [member.gpu for member in self._members.values()]

    def release(self) -> None:
        """Release all renderers but the one that this belongs to."""
        for name in list(self._members):
            self._let_go(name)

    # -- what sources ask ---------------------------------------------------------------------------------------------

    def stamp(self) -> tuple[Any, ...]:
        """Changes with everything that planets show or where they are."""
        scene = self._own.scene
        return (own_revisions(scene), *(own_revisions(c.scene) for c in scene.companions.values()))


class _Source:
    """What the companions' system of one planet's renderer asks for: pictures of the others (CompanionSource)."""

    def __init__(self, several: SeveralPlanets, name: str, renderer: Renderer) -> None:
        self._several, self._name, self._renderer = several, name, renderer
        self._parts: dict[int, tuple[float, float]] = {}
        self._drawn: dict[tuple[int, str], _Drawn] = {}
        self._waits: list[Renderer] = []

    def prepare(self, frame: Frame) -> bool:
        moment = self._several.now(frame.time_s)
        body = moment.bodies[self._name]
        own = self._several._own.scene.planet.name
        frame.star_axes = None if self._name == own else body.axes.T @ moment.star_axes
        jitter = self._parts.get(frame.view_index)
        if jitter is None:
            return False
        frame.jitter_px, frame.backdrop = jitter, False
        return True

    def stamp(self) -> Any:
        return self._several.stamp()

    def settled(self) -> bool:
        return all(system.settled() for renderer in self._waits for system in _drawing(renderer))

    def progress(self) -> float:
        return min((system.progress() for renderer in self._waits for system in _drawing(renderer)), default=1.0)

    def pictures(self, frame: Frame) -> list[Picture]:
        moment = self._several.now(frame.time_s)
        main = moment.bodies[self._name]
        self._waits = []
        found: list[tuple[float, Picture]] = []
        for body in moment.bodies.values():
            if body.name == self._name:
                continue
            seen = body.seen_from(main)
            drawn = self._drawn.get((frame.view_index, body.name))
            away = seen.centre_m - frame.camera.position_m
            if hidden_by(main, _lowest_m(main), frame.camera.position_m, seen.centre_m, seen.reach_m):
                continue
            part = part_of(frame.camera, frame.size, seen, None if drawn is None else drawn.view.size)
            if part is None:
                continue
            if drawn is None:
                renderer = self._several._member(body.name)
                if renderer is None:
                    raise MissingError(f"planet {body.name!r} has no renderer yet")
                drawn = self._drawn[frame.view_index, body.name] = _Drawn(renderer, part.size)
            texture = drawn.texture(self._several, body, part, frame, moment)
            self._waits.append(drawn.renderer)
            power = float(away @ away) - seen.reach_m**2
            found.append((power, Picture(texture, part.corner_px, part.texel_px, part.rect, part.spot_px)))
        return [picture for _, picture in sorted(found, key=lambda pair: -pair[0])]

    def part_jitter(self, view_index: int, jitter_px: tuple[float, float]) -> None:
        """This planet's view of that index is a picture for another one's camera."""
        self._parts[view_index] = jitter_px

    def forget(self, name: str) -> None:
        """A planet goes: one of the same name may come."""
        for key in [key for key in self._drawn if key[1] == name]:
            self._drawn.pop(key).view.release()

    def release(self) -> None:
        for drawn in self._drawn.values():
            drawn.view.release()
        self._drawn.clear()


class _Drawn:
    """A companion's view for one camera: its pictures, drawn when they have to be."""

    def __init__(self, renderer: Renderer, size: tuple[int, int]) -> None:
        from .view import RenderView

        self.renderer = renderer
        self.view = RenderView(renderer, size, inner=True)
        self._spot: tuple[Any, ...] = ()
        self._texture: Any = None

    def texture(self, several: SeveralPlanets, body: Body, part: Part, frame: Frame, moment: Moment) -> Any:
        """PICTURE of the part of a frame's picture that shows this planet."""
        renderer, view = self.renderer, self.view
        sun = several._sun_for(body, moment, view.index)
        key = self._spot_key(several, part, sun) if not part.texels and not frame.settling else ()
        if key and key == self._spot and self._texture is not None:
            return self._texture
        jitter = (frame.jitter_px[0] * part.texels, frame.jitter_px[1] * part.texels)
        several._sources[body.name].part_jitter(view.index, jitter)
        renderer.scene.world.resources = renderer._resources
        with view._drawing() as drawing:
            if drawing.size != part.size:
                drawing._resize(part.size)
            drawing._draw(
                _Fixed(part.camera), frame.time_s, sun, frozenset({PICTURE}), frame.dt_s, None,
                settling=frame.settling, one_shot=frame.one_shot, exact=frame.exact,
            )  # fmt: skip
            self._texture = drawing._require_plan().resource(PICTURE)
        self._spot = key if all(system.settled() for system in _drawing(renderer)) else ()
        return self._texture

    def _spot_key(self, several: SeveralPlanets, part: Part, sun: Sun) -> tuple[Any, ...]:
        """What a spot's picture depends on, as far as a few pixels can show."""
        step = np.radians(_LOOKED_AT_DEG)
        looks = np.round(np.array([*part.camera.forward, *(sun.direction or ())]) / step)
        return (*looks.tolist(), sun.irradiance, several.stamp())


def _drawing(renderer: Renderer) -> list[Any]:
    """The systems that a companion's picture waits for: exposure and anti-aliasing are the camera's planet's."""
    return [system for system in renderer.running if system.name not in ("composite", "companions")]


def _lowest_m(body: Body) -> float:
    """Radius of the lowest surface that hides what is behind."""
    handle = body.scene.planet
    sea, ground = handle.get(Ocean), handle.get(Terrain)
    if sea is None and ground is None:
        return 0.0
    lowest = [h for h in (sea and sea.sea_level_m, ground and ground.lowest_m) if h is not None]
    return body.radius_m + max(lowest)


class _Fixed(Camera):
    """A camera that is a CameraState already."""

    def __init__(self, state: CameraState) -> None:
        self._state = state
        self._place, self._pose = None, (state.position_m, state.forward, state.up)
        self._optics(60.0, None, None)

    def resolve(self, scene: Any, aspect: float = 16.0 / 9.0) -> CameraState:
        return self._state


def _moved(camera: Camera, scene: Scene, home: Body, main: Body) -> Camera:
    """The camera of one planet's axes in those of another."""
    made = Camera.__new__(Camera)
    if home.name == main.name:
        made._place, made._pose = camera._requested() if camera._pose is None else None, camera._pose
    else:
        state = camera.resolve(scene)
        turn = main.axes.T @ home.axes
        place = main.inside(home.outside(state.position_m))
        made._place, made._pose = None, (place, turn @ state.forward, turn @ state.up)
    made._optics(camera.fov_y_deg, camera.frustum_deg, None, camera.ev100)
    return made
