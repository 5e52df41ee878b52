"""Free flight in a window: `pf.fly(scene)`. The loop and what can be done in it.

Keys live in keys.py, places, time and photos in journey.py, panels in panels.py; what they see of the flight is in
flight.py.
"""

from __future__ import annotations

import dataclasses
import logging
import time
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from ..camera.arguments import check_scene
from ..camera.camera import Camera, PosedCamera
from ..camera.flights import ScenePath, path
from ..camera.place import Optics
from ..camera.place import Pose as CameraPose
from ..camera.views import view
from ..capture.captures import check_arrays, outputs_for, save_capture
from ..capture.shot import shot_settings
from ..components import DebugView, Ocean, Sun
from ..engine.settings import SettingError
from ..engine.settings.user import user_folder
from ..engine.space import latitude_longitude
from ..errors import ContextLostError, GraphError, OutputError, SceneError
from ..quality import resolve_quality
from ..query.sea_surface import SeaSurface
from ..systems.capture import CaptureError, require_writable
from ..systems.flight import Controls, Ground, Mode, Pilot, Pose, controls_or_defaults, steering
from .flight import FlightWindow, Interface, RendererMaker
from .journey import Journey
from .keys import act
from .pace import Pace, check_frame_cap
from .planets import FlightPlanets, first_camera
from .shown import Shown
from .trunks import FlightTrunks

if TYPE_CHECKING:
    from ..engine.input import InputState
    from ..render.renderer import Renderer
    from ..scene.scene import Scene

__all__ = ["FlightApp", "Interface", "RendererMaker", "fly"]

log = logging.getLogger(__name__)

_STATS_EVERY_S = 0.25  # they are read back from the GPU
_RELOAD_EVERY_S = 1.0
_LONGEST_FRAME_S = 0.5
_MESSAGE_S = 6.0
_ERROR_COLOR = (0.12, 0.02, 0.03)
_LONGEST_PROBLEM = 500
_PHOTO_COLOR = (0.02, 0.03, 0.05)


OnFrame = Callable[[float, float], object]


class _PoseKey(NamedTuple):
    """Equal for equal cameras: place and axes as bytes."""

    position: bytes
    forward: bytes
    up: bytes
    fov_y_deg: float


class FlightApp:
    """One flight. `frame()` does one frame, `run()` loops until the window closes.

    window: an engine.hosts Window or anything like it. renderer: made on the window's context. camera: the start; None
    takes the planet's view from orbit, or looks down on it. sun, or the sun of a view: put into the scene, so that the
    panel turns the one that shines. make_renderer: for quality that is changed during the flight; the app then owns
    what it makes, and `app.renderer` is to be released at the end. controls: None takes the user's.

    With an interface, an error while drawing does not end the flight: it is shown and logged, and each frame tries
    anew, so that a mended shader or setting brings the picture back.
    """

    def __init__(
        self,
        window: FlightWindow,
        renderer: Renderer,
        scene: Scene,
        camera: Camera | None = None,
        *,
        sun: Sun | None = None,
        interface: Interface | None = None,
        make_renderer: RendererMaker | None = None,
        quality: str = "high",
        overrides: Mapping[str, Any] | None = None,
        on_frame: OnFrame | None = None,
        controls: Controls | None = None,
    ) -> None:
        self._on_frame = on_frame
        self.window, self.renderer, self.scene, self.interface = window, renderer, scene, interface
        self.quality, self.overrides = quality, dict(overrides or {})
        self._make_renderer = make_renderer
        self.shown = Shown()
        self.time_s = 0.0
        self.time_runs = True
        self.time_speed = 1.0
        self.dt_s = 1.0 / 60.0
        self.playing: ScenePath | None = None
        self.played_s = 0.0
        self.pace = Pace()
        self.clock = time.perf_counter
        self._next_stats_s = self._next_reload_s = self._message_ends_s = 0.0
        self._held_camera: tuple[_PoseKey, Camera] | None = None
        self._start = camera or first_camera(scene)
        start = self._start.in_scene(scene)
        if start.optics.intrinsics is not None:
            log.warning("a window has a lens of its own, from fov_y_deg: the camera's intrinsics are left out")
        self._start_sun = sun or start.sun
        self.sea = SeaSurface(scene)
        self.trunks = FlightTrunks()
        self.planets = FlightPlanets(self)
        pose = Pose(start.pose.position_m, start.pose.forward, start.pose.up, start.optics.fov_y_deg)
        self.pilot = Pilot(Ground(scene.planet.radius_m), pose, water=self.sea.height)
        self.ship = self.pilot.ship
        self.journey = Journey(self)
        self.controls, problem = (controls, "") if controls else controls_or_defaults(user_folder() / "controls.toml")
        self.to_start()
        if problem or self.journey.places.problem:
            # The log has all of it.
            self.say("\n".join(text[:_LONGEST_PROBLEM] for text in (problem, self.journey.places.problem) if text))

    @property
    def looking(self) -> bool:
        """Whether the mouse steers the ship (and not the pointer)."""
        return bool(self.window.mouse_exclusivity)

    @property
    def photographing(self) -> bool:
        """Whether a photo is being taken, a tile a frame."""
        return self.journey.photographing

    @property
    def can_change_quality(self) -> bool:
        """Whether the app can make renderers of its own."""
        return self._make_renderer is not None

    @property
    def fov_y_deg(self) -> float:
        """The whole vertical angle of view."""
        return self.pilot.fov_y_deg

    @fov_y_deg.setter
    def fov_y_deg(self, angle: float) -> None:
        self.pilot.fov_y_deg = angle

    @property
    def camera(self) -> Camera:
        """This frame's camera."""
        return self.camera_for(None)

    def camera_for(self, fov_y_deg: float | None) -> Camera:
        """This frame's camera, with a field of view of its own if given; in the axes of the scene's own planet."""
        pose = self.planets.outside(self.pilot.pose)
        fov_y_deg = pose.fov_y_deg if fov_y_deg is None else fov_y_deg
        # The same camera while nothing moves: a renderer that knows it doesn't resolve it again (a seventh of a frame).
        key = _PoseKey(pose.position_m.tobytes(), pose.forward.tobytes(), pose.up.tobytes(), fov_y_deg)
        if self._held_camera is None or self._held_camera[0] != key:
            # The axes are orthonormal already: checking them costs 0.1 ms a frame.
            posed = CameraPose(pose.position_m, pose.forward, pose.up)
            self._held_camera = (key, PosedCamera(posed, Optics(fov_y_deg)))
        return self._held_camera[1]

    @property
    def latitude_longitude_altitude(self) -> tuple[float, float, float]:
        """Degrees, and metres above ground or sea."""
        latitude, longitude = latitude_longitude(self.pilot.position_m)
        return float(latitude), float(longitude), self.pilot.clearance_m

    def run(self) -> None:
        """Fly until the window closes."""
        before = self.clock()
        while not self.window.should_close:
            now = self.clock()
            self.dt_s, before = max(now - before, 1e-4), now
            self.frame()

    def frame(self) -> None:
        """Input, flight, picture, interface, swap."""
        state = self.window.poll()
        if not self.photographing:
            self.pace.begin(self.renderer)
        dt_s = min(self.dt_s, _LONGEST_FRAME_S)
        if self.interface is not None:
            self.interface.begin(state, self, self.dt_s)
        act(self, state, dt_s)
        if self.photographing:
            self.photograph()
            return
        if self.time_runs:
            self.time_s += dt_s * self.time_speed
        width, height = self.window.framebuffer_size
        # (0, 0) while minimised, on some systems
        visible = width > 0 and height > 0 and not getattr(self.window, "minimised", False)
        try:
            held = None
            if self._on_frame is not None:
                held = self._on_frame(self.time_s, dt_s * self.time_speed if self.time_runs else 0.0)
            self._move(state, dt_s)
            if isinstance(held, Camera):
                self.pilot.place(self.planets.arrive(held, None)[0])
            if visible:
                self.renderer.render_to(
                    self.window.framebuffer, self.camera, self.time_s, viewport=(0, 0, width, height), dt_s=dt_s
                )
                self._watch()
            self.shown.error = ""
        except Exception as error:
            if self.interface is None or isinstance(error, ContextLostError):  # no F5 helps
                raise
            self._failed(error, visible)
        if visible and self.interface is not None:
            self.interface.draw(self)
        self._housekeeping()
        self.pace.end(self.renderer, visible)
        self.window.swap()

    # what happens in a frame

    def photograph(self) -> None:
        """A frame with a tile of a photo in place of the picture."""
        try:
            self.journey.step_photo()
        except Exception as error:
            if self.interface is None or isinstance(error, ContextLostError):
                raise
            log.error("the photo could not be taken: %s", error, exc_info=error)
            self.say(f"the photo could not be taken: {error}")
        width, height = self.window.framebuffer_size
        if width > 0 and height > 0 and self.interface is not None:
            self.window.framebuffer.use()
            self.window.framebuffer.viewport = (0, 0, width, height)
            self.window.framebuffer.clear(*_PHOTO_COLOR)
            self.interface.draw(self)
        self.window.swap()

    def _move(self, state: InputState, dt_s: float) -> None:
        self.planets.follow()
        self.meet_ground()
        self.sea.time_s = self.time_s
        size = getattr(self.window, "size", self.window.framebuffer_size)
        wish = steering(self.controls, state, looking=self.looking, dt_s=dt_s, fov_y_deg=self.fov_y_deg, size=size)
        if self.playing is None:
            self.planets.crossing = None if wish.moves else self.planets.crossing
            if not self.planets.cross(dt_s):
                self.pilot.update(wish, dt_s)
            return
        self.played_s += dt_s
        camera = self.playing.camera_at(self.played_s)
        self.pilot.place(self.planets.inside(Pose(camera.position_m, camera.forward, camera.up, camera.fov_y_deg)))
        if wish.moves or self.played_s >= self.playing.duration_s:
            self.play(None)

    def meet_ground(self) -> None:
        """The flight is over the planet as it is drawn now: panels may have changed it."""
        planet, ground = self.planets.handle, self.pilot.ground
        ocean = planet.get(Ocean)
        ground.radius_m = planet.radius_m
        ground.field = self.planets.height_field()
        ground.sea_level_m = None if ocean is None else ocean.sea_level_m
        on_foot = self.pilot.mode == "walk"
        self.pilot.walker.obstacles = self.trunks.on(planet, ground.field) if on_foot else None

    def _failed(self, error: Exception, visible: bool) -> None:
        """Keep the window: say what happened, and try again with the next frame."""
        text = "\n".join([f"{type(error).__name__}: {error}", *getattr(error, "__notes__", ())])
        if isinstance(error, GraphError) and self.debug_view != "off":
            log.warning("debug view %r: %s", self.debug_view, error)
            self.say(f"there is no {self.debug_view!r} to look at now: debug view off")
            self.debug_view = "off"
            return
        if not self.shown.error:  # what fails after that is often only a consequence
            self.shown.error = f"The frame could not be drawn. {text}\nF5 starts the renderer anew."
            log.error("the frame could not be drawn: %s", text, exc_info=error)
        if visible:
            framebuffer = self.window.framebuffer
            framebuffer.use()
            framebuffer.viewport = (0, 0, *self.window.framebuffer_size)
            framebuffer.clear(*_ERROR_COLOR)

    def _watch(self) -> None:
        now = self.clock()
        if now >= self._next_stats_s and (self.shown.numbers or self.shown.panels):
            self._next_stats_s = now + _STATS_EVERY_S
            self.shown.stats = self.renderer.stats

    def _housekeeping(self) -> None:
        now = self.clock()
        if now >= self._next_reload_s:
            self._next_reload_s = now + _RELOAD_EVERY_S
            self.reload_shaders()
        if self.shown.message and now >= self._message_ends_s:
            self.shown.message = ""

    # what keys and panels do

    def say(self, message: str) -> None:
        """Show a line for some seconds."""
        self.shown.message = message
        self._message_ends_s = self.clock() + _MESSAGE_S

    def place(self, camera: Camera, sun: Sun | None = None) -> None:
        """Put the ship where a camera is; a sun given, or that of a view, goes into the scene."""
        self.playing = None
        placed = camera.in_scene(self.scene)
        sun = placed.sun if sun is None else sun
        self.time_s = self.time_s if placed.time_s is None else placed.time_s
        pose, sun = self.planets.arrive(camera, sun)
        if sun is not None:
            self.scene.sun = dataclasses.replace(sun)
        self.meet_ground()
        self.pilot.place(pose)

    def to_start(self) -> None:
        """Back to where the flight began."""
        self.place(self._start, self._start_sun)

    def go_to(self, name: str) -> None:
        """To a named view of this planet."""
        self.place(view(name, self.scene.planet))

    def switch(self, mode: Mode) -> None:
        """Go on as a ship, on foot, or with the globe in the hand."""
        self.playing = self.planets.crossing = None
        self.meet_ground()
        self.pilot.switch(mode)
        if mode == "orbit":
            self.window.mouse_exclusivity = False
        self.say({"ship": "ship", "walk": "on foot", "orbit": "globe: drag, wheel, right button tilts"}[mode])

    def fly_to_place(self, latitude_deg: float, longitude_deg: float, altitude_m: float = 200.0) -> None:
        """Fly smoothly to a place. ValueError for one that can't be."""
        self.playing = self.planets.crossing = None
        self.meet_ground()
        self.pilot.fly_to_place(latitude_deg, longitude_deg, altitude_m)

    def fly_to_pixel(self, place: tuple[float, float] | None = None) -> None:
        """Fly smoothly to what the window shows at a place (window units); None: in its middle."""
        width, height = self.renderer.size
        x, y = 0.5 * width, 0.5 * height
        if place is not None:
            # Automatic quality draws fewer pixels than the window has.
            ratio = getattr(self.window, "pixel_ratio", 1.0) * getattr(self.renderer, "render_scale", 1.0)
            x, y = place[0] * ratio, place[1] * ratio
        if not (0.0 <= x < width and 0.0 <= y < height):
            return
        found = self.renderer.pick(self.camera, x, y)
        if found is None:
            there = self.planets.pointed_at(x, y)
            if there is None:
                self.say("there is nothing but sky")
            else:
                self.fly_to_planet(there)
            return
        self.playing = self.planets.crossing = None
        self.meet_ground()
        self.pilot.fly_to_point(self.planets.point(found[0]))

    def fly_to_planet(self, name: str) -> None:
        """Fly smoothly to another planet of the scene, until it fills the view. UnknownNameError for none of its."""
        self.playing = None
        self.planets.fly_to(name)

    def play(self, name: str | None) -> None:
        """Start a scripted flight from its beginning; None stops it and leaves the ship where it is."""
        self.playing, self.planets.crossing = None if name is None else path(name, self.scene), None
        self.played_s = 0.0
        if self.playing is not None and self.pilot.mode != "ship":
            self.pilot.switch("ship")
        if self.playing is not None and self.playing.sun is not None:
            light = {key: getattr(self.scene.sun, key) for key in ("irradiance", "angular_radius_rad")}
            self.scene.sun = dataclasses.replace(self.playing.sun, **light)

    @property
    def debug_view(self) -> str:
        """What stands in place of the picture: "off", a named view, or a resource of the frame graph."""
        found = self.scene.world.query(DebugView)
        return found[0][1][0].view if found else "off"

    @debug_view.setter
    def debug_view(self, name: str) -> None:
        found = self.scene.world.query(DebugView)
        if name == "off" and not any(shown.freeze for _, (shown,) in found):
            for entity, _ in list(found):
                self.scene.world.remove(entity, DebugView)
        elif found:
            found[0][1][0].view = name
        else:
            self.scene.environment.add(DebugView(name))

    def set_quality(self, quality: str, overrides: Mapping[str, Any] | None = None) -> None:
        """Render on with other quality knobs. What is wrong is shown, and nothing changes then."""
        overrides = dict(overrides or {})
        if self._make_renderer is None:
            self.say("this window's renderer was made by somebody else: its quality cannot be changed here")
            return
        try:
            resolve_quality(quality, overrides)
            renderer = self._make_renderer(quality, overrides)
        except (SettingError, RuntimeError) as error:
            log.warning("quality %s: %s", quality, error)
            self.say(str(error))
            return
        self.renderer.release()
        self.renderer, self.quality, self.overrides = renderer, quality, overrides

    def validate(self) -> bool:
        """Whether the scene's parts fit together after a change; if not, says why."""
        try:
            self.scene.validate()
        except SceneError as error:
            self.say(str(error))
            return False
        return True

    def reload_shaders(self) -> None:
        """Compile what changed on disk. A broken shader leaves the last good one; its error is shown until mended."""
        changed = self.renderer.reload_shaders()
        self.shown.shader_errors = tuple(str(error) for error in self.renderer.shader_errors)
        if changed:
            self.renderer.graph.invalidate_persistent()  # what the old shaders had made and kept
            self.say("loaded " + ", ".join(changed))

    def save_picture(self, folder: Path | str = ".", suffix: str = ".png") -> Path | None:
        """Write this view, without the interface, with its settings; says so in `shown.message`.

        suffix: .png, or .exr or .npz for all arrays.
        """
        target = Path(folder) / f"planetfall_{datetime.now():%Y%m%d_%H%M%S_%f}{suffix}"
        try:
            require_writable(target)
            check_arrays(target, self.renderer.size)
            # It goes on from what is on screen.
            found = self.renderer.render(self.camera, self.time_s, outputs=outputs_for(target), dt_s=0.0)
            save_capture(target, found, self._settings())
        except (CaptureError, OutputError) as error:
            log.warning("%s", error)
            self.say(str(error))
            return None
        self.say(f"saved {target.resolve()}")
        return target

    def _settings(self) -> dict[str, Any]:
        """All that is needed to make this picture again."""
        return shot_settings(
            self.scene, self.camera, self.time_s, self.renderer.size, quality=self.quality, overrides=self.overrides,
            ev100=self.renderer.exposure, mode=self.pilot.mode,
        )  # fmt: skip


def fly(
    scene: Scene,
    camera: Camera | None = None,
    *,
    sun: Sun | None = None,
    size: tuple[int, int] = (1280, 720),
    quality: str | None = None,
    overrides: Mapping[str, Any] | None = None,
    window: Literal["glfw", "pyglet"] = "glfw",
    fullscreen: bool = False,
    vsync: bool = True,
    monitor: int | None = None,
    frame_cap: float = 0.0,
    on_frame: OnFrame | None = None,
) -> None:
    """Open a window and fly until it closes. The panels, and `sun` or the sun of a view, change `scene`.

    quality: None is `high`, and without a GPU `low` at a quarter of the pixels.
    monitor: which one to open on, the first is 1; None: where the system puts windows. frame_cap: frames a second at
    most; 0: as many as there can be.
    on_frame(time_s, dt_s) is called before each picture: where a game moves its objects. dt_s is 0 while time stands.
    A Camera that it returns is where this picture is taken from, whatever the player steers.
    Raises NoDisplayError without a display, WindowVersionError below OpenGL 4.3, WindowError for a monitor that isn't
    there, SettingError for an unknown quality or override, or a frame cap below 0.
    """
    check_scene(scene, "fly")
    resolve_quality("low" if quality is None else quality, overrides)
    check_frame_cap(frame_cap)
    from ..engine.hosts.window import open_window
    from .interface import FlightInterface
    from .renderer import renderer_maker

    with open_window(
        size, f"Planetfall: {scene.name}", window, vsync=vsync, fullscreen=fullscreen, monitor=monitor
    ) as opened:
        chosen, make = renderer_maker(scene, opened, quality)
        interface = FlightInterface(opened, scene)
        app: FlightApp | None = None
        first = make(chosen, overrides or {})
        try:
            app = FlightApp(
                opened, first, scene, camera, sun=sun, interface=interface, make_renderer=make, quality=chosen,
                overrides=overrides, on_frame=on_frame,
            )  # fmt: skip
            app.pace.frame_cap = frame_cap
            app.run()
        finally:
            interface.release()
            if app is not None:
                app.pace.release()
            (first if app is None else app.renderer).release()
