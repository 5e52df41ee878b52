"""The page of the settings window about planets: every knob of the scene's own and of its companions, and which planets
and components there are. All of it can be undone."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..components import Orbit
from ..engine.gpu.imgui_type import ImGui
from ..scene.companions import bodies, centre_of, own_reach_m
from ..scene.file import describe, planets
from ..scene.kinds import KINDS, PLANET_KINDS
from ..scene.scene import scene_of
from ..systems.tweak import Edit, Panel, icon
from .pages import combo
from .tweak_store import OPTIONAL, SceneStore, of_companion

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from ..scene.scene import Scene
    from ..systems.tweak import Workbench
    from .flight import Flight

__all__ = ["PlanetPage", "free_orbit"]

_APART = 12.0
"""Distance of a new companion, in sums of both planets' reaches: a disc of some degrees, clear of the planet's air."""
_FARTHER = 8
"""So often it is tried twice as far out, where other companions leave no room."""
_TURN_DEG = 10
_AHEAD_AND_UP = 0.4
_SCENE_HEADINGS = frozenset(kind.__name__ for kind in KINDS.values())


class PlanetPage:
    """Draws the page. bench: the window's memory. refused: shows what does not fit, and says whether it is anything.

    chosen: the planet whose knobs are shown. While something is searched for, or only what was changed is shown, those
    of all planets are.
    """

    def __init__(
        self, scene: Scene, store: SceneStore, bench: Callable[[], Workbench], refused: Callable[[Flight, str], bool]
    ) -> None:
        self._scene, self._store, self._bench, self._refused = scene, store, bench, refused
        self._taken_off: dict[str, Any] = {}
        self.panel = Panel()
        self.chosen = scene.planet.name

    def draw(self, imgui: ImGui, app: Flight, preset: str) -> None:
        """One frame of the page. preset: what "reset" goes back to, by name."""
        if self.chosen not in self._scene.planets:
            self.chosen = self._scene.planet.name
        self._choice(imgui, app)
        self._switches(imgui, app)
        self.panel.draw_search()
        self._resets(imgui, app, preset)
        everywhere = bool(self.panel.search.strip()) or self.panel.only_changed
        for name in self._scene.planets if everywhere else (self.chosen,):
            self._knobs(imgui, app, name)

    @property
    def own(self) -> bool:
        """Whether the scene's own planet is chosen."""
        return self.chosen == self._scene.planet.name

    # -- which planets there are -------------------------------------------------------------------------------------

    def _choice(self, imgui: ImGui, app: Flight) -> None:
        imgui.set_next_item_width(9.0 * imgui.get_font_size())
        chosen = combo(imgui, "##planet", self.chosen, list(self._scene.planets))
        imgui.set_item_tooltip("The planet whose knobs are shown: the scene's own, or one that accompanies it")
        self.chosen = chosen or self.chosen
        imgui.same_line()
        if imgui.button(icon("add", "planet") + "###add planet"):
            imgui.open_popup("which planet")
        imgui.set_item_tooltip("One more planet, on an orbit around the scene's own")
        imgui.same_line()
        imgui.begin_disabled(self.own)
        gone = imgui.button(icon("off", "remove") + "###remove planet")
        imgui.end_disabled()
        imgui.set_item_tooltip("Takes this planet out of the scene; undo brings it back")
        imgui.same_line()
        imgui.begin_disabled(self.chosen == app.planets.name)
        if imgui.button("fly there###fly to planet"):
            app.fly_to_planet(self.chosen)
        imgui.end_disabled()
        if imgui.begin_popup("which planet"):
            for name in planets():
                if imgui.selectable(f"{name}###add {name}", False)[0]:
                    self.add(app, name)
            imgui.end_popup()
        if gone:
            self.remove(app)

    def add(self, app: Flight, preset: str) -> bool:
        """One more planet from a preset, where it is seen from here; whether it could be."""
        store, name = self._store, self._store.free_name(preset)
        own = scene_of(describe(preset))
        parts = store.expect(name, own, free_orbit(self._scene, own, app))
        edits = [Edit(heading, "", None, part) for heading, part in parts.items()]
        if self._refused(app, self._bench().do(edits, f"add {name}")):
            return False
        self.chosen = name
        self.panel.unfold.add(of_companion(name, Orbit))
        return True

    def remove(self, app: Flight) -> None:
        """Take the chosen companion out of the scene."""
        name, parts = self.chosen, self._store.companion_parts(self.chosen)
        state = {heading: part for heading, part in self._bench().copy().items() if heading not in parts}
        if not self._refused(app, self._bench().to(state, f"remove {name}", parts)):
            self.chosen = self._scene.planet.name

    # -- its components ----------------------------------------------------------------------------------------------

    def _switches(self, imgui: ImGui, app: Flight) -> None:
        right = imgui.get_cursor_screen_pos().x + imgui.get_content_region_avail().x
        imgui.push_id("parts")
        kinds = [kind for kind in OPTIONAL if self.own or kind in PLANET_KINDS.values()]
        for number, kind in enumerate(kinds):
            wide = imgui.calc_text_size(kind.__name__).x + 2.2 * imgui.get_frame_height()
            if number and imgui.get_item_rect_max().x + wide < right:
                imgui.same_line()
            self._switch(imgui, app, kind)
        imgui.pop_id()

    def _switch(self, imgui: ImGui, app: Flight, kind: type) -> None:
        ours = kind in PLANET_KINDS.values()
        handle = self._scene.planets[self.chosen] if ours else self._scene.environment
        heading = kind.__name__ if self.own else of_companion(self.chosen, kind)
        toggled, wanted = imgui.checkbox(kind.__name__, handle.has(kind))
        if not toggled:
            return
        if wanted:
            self._refused(app, self._bench().add(heading, self._taken_off.pop(heading, None) or kind()))
        else:
            self._taken_off[heading] = handle[kind]
            self._refused(app, self._bench().remove(heading))

    # -- its knobs ---------------------------------------------------------------------------------------------------

    def _resets(self, imgui: ImGui, app: Flight, preset: str) -> None:
        bench, several = self._bench(), bool(self._scene.companions)
        quality = self._store.quality
        if imgui.button(icon("reset", "reset all")):
            headings = {h for h in (*bench.base, *self._store.parts()) if h not in quality}
            if not self._refused(app, bench.to(bench.base, "reset all", headings)):
                app.say(f"as {preset}")
        if several:
            imgui.set_item_tooltip("All planets, and which there are")
            imgui.same_line()
            if imgui.button(icon("reset", self.chosen) + "###reset planet"):
                parts = self._parts(self.chosen)
                state = {**self._store.origins, **bench.base}
                gone = {h for h in state if h.startswith(f"{self.chosen}: ")} if not self.own else _SCENE_HEADINGS
                self._refused(app, bench.to(state, f"reset {self.chosen}", {*parts, *gone}))
            imgui.set_item_tooltip(f"{self.chosen} alone")
        imgui.same_line()
        count = sum(len(fields) for heading, fields in bench.differences().items() if heading not in quality)
        imgui.text_disabled(f"{count or 'no'} change{'' if count == 1 else 's'} against {preset}")

    def _parts(self, name: str) -> dict[str, Any]:
        own = name == self._scene.planet.name
        return self._store.scene_parts() if own else self._store.companion_parts(name)

    def _knobs(self, imgui: ImGui, app: Flight, name: str) -> None:
        bench, parts = self._bench(), self._parts(name)
        presets: Mapping[str, Any] = {h: bench.base.get(h) or self._store.origins.get(h) for h in parts}
        for heading, changes in self.panel.draw_all(parts, presets, search=False).items():
            self._refused(app, bench.made(heading, changes))


def free_orbit(scene: Scene, planet: Scene, app: Flight) -> Orbit:
    """An orbit for one more planet: in front of the flight, as far as the places of others allow."""
    pose = app.planets.outside(app.pilot.pose)
    ahead = pose.forward + _AHEAD_AND_UP * pose.up
    reach_m = own_reach_m(planet)
    others = bodies(scene, 0.0)  # the moment at which Scene.validate looks for planets inside each other
    distance_m = _APART * (others[0].reach_m + reach_m)
    for _ in range(_FARTHER):
        tried = [Orbit(distance_m, phase_deg=float(angle)) for angle in range(0, 360, _TURN_DEG)]
        for orbit in sorted(tried, key=lambda orbit: -float(ahead @ centre_of(scene, orbit, app.time_s))):
            centre = centre_of(scene, orbit, 0.0)
            if all(np.linalg.norm(centre - body.centre_m) > 2.0 * (reach_m + body.reach_m) for body in others):
                return orbit
        distance_m *= 2.0
    return Orbit(distance_m)
