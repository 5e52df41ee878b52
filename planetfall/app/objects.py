"""The page of the settings window about objects, of the scene's planet and of its companions: add, remove, copy, place
and change them, all undoable."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..components import Shape, Transform
from ..engine.gpu.imgui_type import ImGui
from ..engine.space import direction, latitude_longitude
from ..errors import SceneError
from ..scene.companions import bodies
from ..systems.tweak import Edit, Panel, choose, icon
from .tweak_store import PropParts, SceneStore, copied

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..scene.scene import PropHandle, Scene
    from ..systems.tweak import Workbench
    from .flight import Flight

__all__ = ["ObjectsPage", "upright"]

_SEEN_SIZE = 0.12
"""Of its distance: what a new object is wide, so that it is seen at once."""
_AHEAD_M = 20.0
_NOTHING = "Objects of a game's own, or added here; scene files keep them. A form may be the path of a mesh file."
_FORMS = ("box", "sphere")


class ObjectsPage:
    """Lists the objects of each planet. bench: the window's memory. refused: shows what does not fit, and says whether
    it is anything.

    New objects are those of the planet that the flight is over. They stand on what the middle of the picture shows, or
    in the air ahead where that is the sky.
    """

    def __init__(
        self, scene: Scene, store: SceneStore, bench: Callable[[], Workbench], refused: Callable[[Flight, str], bool]
    ) -> None:
        self._scene, self._store, self._bench, self._refused = scene, store, bench, refused
        self._panel = Panel()
        self._planet = scene.planet.name
        """Whose object is selected; and which one of these."""
        self._selected = 0

    def draw(self, imgui: ImGui, app: Flight) -> None:
        """One frame of the page."""
        count = sum(len(props) for props in self._groups().values())
        imgui.align_text_to_frame_padding()
        imgui.text(f"{count or 'no'} object{'' if count == 1 else 's'}")
        for form in _FORMS:
            imgui.same_line()
            if imgui.button(icon("add", form) + f"###add {form}"):
                self.add(app, form)
            imgui.set_item_tooltip(f"a {form} on what the middle of the picture shows")
        prop = self._chosen()
        if prop is None:
            imgui.text_wrapped(_NOTHING)
            return
        imgui.same_line()
        if imgui.button(icon("copy", "copy") + "###copy object"):
            parts = PropParts(prop.name, tuple(copied(part) for part in prop.components()), self._planet)
            self._put(app, parts, f"copy {prop.name}")
        imgui.same_line()
        if imgui.button(icon("off", "remove") + "###remove object"):
            self.remove(app, prop)
            return
        self._lists(imgui, app)
        prop = self._chosen()
        assert prop is not None, "there was one"
        heading = self._store.object_heading(prop)
        imgui.push_id(heading)
        if prop.has(Transform):
            self._place(imgui, app, prop)
        for part in prop.components():
            if isinstance(part, Transform | Shape):
                imgui.separator_text(type(part).__name__)
                form = part.form if isinstance(part, Shape) else ""
                changes = self._panel.draw(part)
                if isinstance(part, Shape) and any(change.field == "form" for change in changes):
                    try:
                        prop.scene.check_prop((part,))
                    except SceneError as error:
                        part.form = form
                        self._refused(app, str(error))
                        continue
                if changes:
                    self._refused(app, self._bench().made(f"{heading}/{type(part).__name__}", changes))
        imgui.pop_id()

    # -- which there are ---------------------------------------------------------------------------------------------

    def _groups(self) -> dict[str, tuple[PropHandle, ...]]:
        """The objects of each planet that has any."""
        found = {name: planet.scene.props for name, planet in self._scene.planets.items()}
        return {name: props for name, props in found.items() if props}

    def _chosen(self) -> PropHandle | None:
        """The selected object, or another one where that is gone."""
        groups = self._groups()
        if not groups:
            return None
        if self._planet not in groups:
            self._planet, self._selected = next(iter(groups)), 0
        props = groups[self._planet]
        self._selected = min(self._selected, len(props) - 1)
        return props[self._selected]

    def _lists(self, imgui: ImGui, app: Flight) -> None:
        """A list for each planet, under its name where there are several."""
        for name, props in self._groups().items():
            if self._scene.companions:
                imgui.separator_text(name)
            eye_m = self._eye(app, name)

            def label(k: int, props: tuple[PropHandle, ...] = props, eye_m: Any = eye_m) -> tuple[str, str]:
                return props[k].name, _described(props[k], eye_m)

            selected = self._selected if name == self._planet else -1
            imgui.push_id(f"objects of {name}")
            now = choose(imgui, len(props), label, selected)
            imgui.pop_id()
            if now != selected:
                self._planet, self._selected = name, now

    @staticmethod
    def _eye(app: Flight, planet: str) -> NDArray[np.float64]:
        """The pilot's place in the axes of a planet."""
        if planet == app.planets.name:
            return app.pilot.position_m
        found = {body.name: body for body in bodies(app.scene, app.time_s)}
        return found[planet].inside(app.planets.body().outside(app.pilot.position_m))

    # -- what is done with them --------------------------------------------------------------------------------------

    def add(self, app: Flight, form: str) -> None:
        """A new object where the picture's middle is, large enough to be seen."""
        width, height = app.renderer.size
        found = app.renderer.pick(app.camera, 0.5 * width, 0.5 * height)
        eye = app.pilot.position_m
        place = eye + _AHEAD_M * app.pilot.pose.forward if found is None else app.planets.point(found[0])
        size = float(f"{max(_SEEN_SIZE * float(np.linalg.norm(place - eye)), 0.1):.1g}")
        if found is not None:
            place = place * (1.0 + 0.5 * size / float(np.linalg.norm(place)))
        transform = Transform((float(place[0]), float(place[1]), float(place[2])), upright(place))
        shape = Shape(form, (size, size, size), (0.5, 0.12, 0.05))
        planet = app.planets.handle
        name = _free_name(form, {prop.name for prop in planet.scene.props})
        self._put(app, PropParts(name, (transform, shape), app.planets.name), f"add {form}")

    def remove(self, app: Flight, prop: PropHandle) -> None:
        """Take an object off its planet."""
        parts = PropParts(prop.name, tuple(copied(part) for part in prop.components()), self._planet)
        edit = Edit(self._store.object_heading(prop), "", parts, None)
        self._refused(app, self._bench().do([edit], f"remove {prop.name}"))

    def _put(self, app: Flight, parts: PropParts, label: str) -> None:
        edit = Edit(self._store.new_object_heading(), "", None, parts)
        if not self._refused(app, self._bench().do([edit], label)):
            self._planet, self._selected = parts.planet, len(self._scene.planets[parts.planet].scene.props) - 1

    def _place(self, imgui: ImGui, app: Flight, prop: PropHandle) -> None:
        """Latitude, longitude and height: an object's position as people say it, to the millimetre."""
        transform, planet = prop[Transform], prop.scene.planet
        where = np.array(transform.position_m)
        radius = float(np.linalg.norm(where))
        latitude, longitude = (float(v) for v in latitude_longitude(where))
        height = radius - planet.radius_m
        wanted = []
        for label, value, step, shape in (
            ("latitude [deg]", latitude, math.degrees(1.0 / max(radius, 1.0)), "%.8f"),
            ("longitude [deg]", longitude, math.degrees(1.0 / max(radius, 1.0)), "%.8f"),
            ("height [m]", height, 0.5, "%.3f"),
        ):
            wanted.append(imgui.input_double(label, value, step, 10.0 * step, shape))
        turned = transform.orientation
        if any(changed for changed, _ in wanted):
            (_, latitude), (_, longitude), (_, height) = wanted
            where = direction(min(max(latitude, -90.0), 90.0), longitude) * (planet.radius_m + height)
        if imgui.button("to the ground"):
            up = where / max(float(np.linalg.norm(where)), 1e-9)
            half = 0.5 * prop[Shape].size_m[2] if prop.has(Shape) else 0.0
            where = up * (planet.radius_m + float(planet.surface_height_m(up)[0]) + half)
        imgui.same_line()
        if imgui.button("upright"):
            turned = upright(where)
        imgui.same_line()
        if imgui.button("fly there"):
            self._fly_to(app, prop, latitude, longitude)
        heading = f"{self._store.object_heading(prop)}/Transform"
        place = tuple(map(float, where))
        edits = [
            Edit(heading, name, getattr(transform, name), new)
            for name, new in (("position_m", place), ("orientation", turned))
            if getattr(transform, name) != new
        ]
        if edits:
            self._refused(app, self._bench().do(edits, f"move {prop.name}"))

    def _fly_to(self, app: Flight, prop: PropHandle, latitude_deg: float, longitude_deg: float) -> None:
        """To an object, or first of all to its planet."""
        if self._planet != app.planets.name:
            app.fly_to_planet(self._planet)
            return
        size_m = max(prop[Shape].size_m) if prop.has(Shape) else 0.0
        app.fly_to_place(latitude_deg, longitude_deg, max(10.0, 8.0 * size_m))


def _described(prop: PropHandle, eye_m: NDArray[np.float64]) -> str:
    transform, shape = prop.get(Transform), prop.get(Shape)
    if transform is None or shape is None:
        return "not drawn: it has no Transform or no Shape"
    away = float(np.linalg.norm(np.array(transform.position_m) - eye_m))
    return f"{shape.form}, {max(shape.size_m):.4g} m, {away:.4g} m away"


def upright(place: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """The quaternion (x, y, z, w) that turns an object's z axis to the vertical of a place, the shortest way."""
    x, y, z = place / max(float(np.linalg.norm(place)), 1e-9)
    if z < -0.999999:  # upside down: any half turn around a level axis
        return (1.0, 0.0, 0.0, 0.0)
    # The half-way quaternion between z and up: (cross, 1 + dot), normalised.
    turned = np.array([-y, x, 0.0, 1.0 + z])
    turned /= np.linalg.norm(turned)
    return (float(turned[0]), float(turned[1]), float(turned[2]), float(turned[3]))


def _free_name(form: str, taken: set[str]) -> str:
    return next(name for k in range(1, len(taken) + 2) if (name := f"{form} {k}") not in taken)
