"""Pages of the settings window that turn no knobs: what is looked at, and what a frame costs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .engine.graph import TextureSpec
from .flights import paths
from .systems.debug import NAMED_VIEWS
from .systems.tweak import PassTime, draw_passes
from .views import view, views

if TYPE_CHECKING:
    from .app import FlightApp
    from .scene import Scene

__all__ = ["PassesPage", "ViewPage", "combo"]

_LABEL_EM = 11.5
_FOV_DEG = (2.0, 120.0)


class ViewPage:
    """Debug views, places, flights, camera and time."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._names: tuple[int, list[str]] = (0, [])

    def draw(self, imgui: Any, app: FlightApp) -> None:
        """One frame of the page."""
        imgui.push_item_width(-_LABEL_EM * imgui.get_font_size())
        imgui.separator_text("debug view")
        chosen = combo(imgui, "shows", app.debug_view, ("off", *NAMED_VIEWS), self._resources(app))
        if chosen is not None:
            app.debug_view = chosen
        imgui.separator_text("places")
        chosen = combo(imgui, "go to", "", views(self._scene), tips=lambda name: view(name, self._scene.planet).about)
        if chosen is not None:
            app.go_to(chosen)
        chosen = combo(imgui, "play", app.playing.name if app.playing else "", paths())
        if chosen is not None:
            app.play(chosen)
        if app.playing is not None:
            imgui.same_line()
            if imgui.button("stop"):
                app.play(None)
        if app.playing is not None:
            moved, at = imgui.slider_float("s##played", app.played_s, 0.0, app.playing.duration_s, "%.1f")
            if moved:
                app.played_s = at
        imgui.separator_text("camera")
        low, high = _FOV_DEG
        app.fov_y_deg = imgui.slider_float("field of view [deg]", app.fov_y_deg, low, high, "%.1f")[1]
        throttle = app.ship.limits.wheel_range
        logarithmic = imgui.SliderFlags_.logarithmic
        app.ship.throttle = imgui.slider_float(
            "speed", app.ship.throttle, 1.0 / throttle, throttle, "%.2f x", logarithmic
        )[1]
        imgui.separator_text("time")
        app.time_runs = imgui.checkbox("runs", app.time_runs)[1]
        imgui.same_line()
        if imgui.button("to 0"):
            app.time_s = 0.0
        imgui.same_line()
        imgui.text(f"{app.time_s:.1f} s")
        app.time_speed = imgui.slider_float("pace", app.time_speed, 1.0 / 64.0, 1e6, "%.3g x", logarithmic)[1]
        if self._scene.sun.mode != "epoch":
            imgui.text_wrapped("The sun stands still: set Sun epoch_s, and it follows the time.")
        imgui.pop_item_width()

    def _resources(self, app: FlightApp) -> list[str]:
        """Textures of the frame that can be looked at; looked up again when the graph has been compiled anew."""
        try:
            plan = app.renderer.graph
        except Exception:  # nothing has been drawn yet
            return []
        if self._names[0] != id(plan):
            specs = plan.analysis.model.specs
            names = [n for n, s in specs.items() if isinstance(s, TextureSpec) and not n.startswith("debug.")]
            self._names = (id(plan), sorted(names))
        return self._names[1]


class PassesPage:
    """What the frame's passes cost."""

    def __init__(self) -> None:
        self._culled = False

    def draw(self, imgui: Any, app: FlightApp) -> None:
        """One frame of the page."""
        try:
            plan = app.renderer.graph
        except Exception:
            imgui.text("nothing has been drawn yet")
            return
        toggled, on = imgui.checkbox("GPU times", plan.gpu_timing)
        if toggled:
            plan.gpu_timing = on
        imgui.set_item_tooltip("time stamps around each pass; they cost some time themselves")
        imgui.same_line()
        self._culled = imgui.checkbox("unused passes too", self._culled)[1]
        imgui.text(f"{plan.memory_bytes() / 2**20:.1f} MiB in the frame's textures and buffers")
        helps = {declared.name: declared.help for declared in plan.analysis.model.passes}
        passes = [
            PassTime(
                report.name,
                report.cpu_ms or 0.0,
                report.gpu_ms,
                report.skipped_why or "",
                culled=(report.skipped_why or "").startswith("culled"),
                help=helps.get(report.name, ""),
            )
            for report in app.renderer.passes()
        ]
        draw_passes(passes, culled=self._culled)


def combo(
    imgui: Any, label: str, shown: str, names: Any, more: Any = (), tips: Any = None, heading: str = "resources"
) -> str | None:
    """A list to choose from; the choice of this frame, or None.

    names, more: texts, or a function that gives them, called while the list is open; `more` comes after a line with the
    heading. tips: name -> text.
    """
    found = None
    if imgui.begin_combo(label, shown, imgui.ComboFlags_.height_large):
        for group, listed in enumerate((names, more)):
            members: Any = listed() if callable(listed) else listed
            if group and members:
                imgui.separator_text(heading)
            for name in members:
                if imgui.selectable(name, name == shown)[0]:
                    found = name
                if tips is not None:
                    imgui.set_item_tooltip(tips(name))
        imgui.end_combo()
    return found
