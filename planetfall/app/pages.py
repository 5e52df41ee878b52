"""Pages of the settings window that turn no knobs: what is looked at, and what a frame costs."""

from __future__ import annotations

from collections.abc import Callable, Collection
from typing import TYPE_CHECKING

from ..camera.flights import paths
from ..camera.views import view, views
from ..components import DebugView
from ..engine.gpu.imgui_type import ImGui
from ..engine.graph import BufferSpec, TextureSpec
from ..errors import SettingError
from ..systems.debug import NAMED_VIEWS
from ..systems.tweak import (
    FrameHistory,
    FrameProfile,
    PassTime,
    draw_budget,
    draw_memory,
    draw_passes,
    draw_percentiles,
    draw_stack,
)
from ..systems.tweak.style import QUIET

if TYPE_CHECKING:
    from ..engine.graph import Plan
    from ..scene.scene import Scene
    from .flight import Flight

__all__ = ["ProfilerPage", "ViewPage", "combo"]

_LABEL_EM = 11.5
_FOV_DEG = (2.0, 120.0)
_BUDGET_MS = 1000.0 / 60.0

Names = Collection[str] | Callable[[], Collection[str]]
"""What a list offers; a function is called while the list is open."""


class ViewPage:
    """Debug views, places, flights, camera and time."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._names: tuple[int, list[str]] = (0, [])

    def draw(self, imgui: ImGui, app: Flight) -> None:
        """One frame of the page."""
        imgui.push_item_width(-_LABEL_EM * imgui.get_font_size())
        imgui.separator_text("debug view")
        chosen = combo(imgui, "shows", app.debug_view, ("off", *NAMED_VIEWS), self._resources(app))
        if chosen is not None:
            app.debug_view = chosen
        if app.debug_view in NAMED_VIEWS:
            imgui.push_style_color(imgui.Col_.text, imgui.ImVec4(*QUIET))
            imgui.text_wrapped(NAMED_VIEWS[app.debug_view].help)
            imgui.pop_style_color()
        self._freeze(imgui, app)
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
        self._window(imgui, app)
        imgui.pop_item_width()

    @staticmethod
    def _window(imgui: ImGui, app: Flight) -> None:
        imgui.separator_text("window")
        toggled, on = imgui.checkbox("full screen", bool(app.window.fullscreen))
        if toggled:
            app.window.fullscreen = on
        there = getattr(app.window, "monitors", ())
        if there:
            now = app.window.monitor
            names = [f"{number}: {monitor}" for number, monitor in enumerate(there, 1)]
            chosen = combo(imgui, "monitor", names[now - 1], names)
            if chosen is not None:
                app.window.monitor = names.index(chosen) + 1
        if hasattr(app.window, "vsync"):
            toggled, on = imgui.checkbox("wait for the display", app.window.vsync)
            if toggled:
                app.window.vsync = on
        cap = round(app.pace.frame_cap)
        cap = imgui.slider_int("frames a second", cap, 0, 240, "%d" if cap else "as many as can be")[1]
        app.pace.frame_cap = float(cap)
        imgui.text_disabled(
            f"{' x '.join(map(str, app.renderer.size))} pixels drawn, {app.window.pixel_ratio:g} a unit"
        )

    def _freeze(self, imgui: ImGui, app: Flight) -> None:
        world = self._scene.world
        found = world.query(DebugView)
        frozen = any(shown.freeze for _, (shown,) in found)
        toggled, on = imgui.checkbox("freeze tiles and frustum", frozen)
        imgui.set_item_tooltip("keeps what is drawn of the ground and the sea, to fly around it and look")
        if not toggled:
            return
        if not found:
            self._scene.environment.add(DebugView(freeze=True))
            return
        for _, (shown,) in found:
            shown.freeze = on
        app.debug_view = app.debug_view  # without a view and without a freeze there is nothing to keep

    def _resources(self, app: Flight) -> list[str]:
        """Textures of the frame that can be looked at; looked up again when the graph has been compiled anew."""
        try:
            plan = app.renderer.graph
        except SettingError:  # nothing has been drawn yet
            return []
        if self._names[0] != id(plan):
            specs = plan.analysis.model.specs
            names = [n for n, s in specs.items() if isinstance(s, TextureSpec) and not n.startswith("debug.")]
            self._names = (id(plan), sorted(names))
        return self._names[1]


class ProfilerPage:
    """What the frame's passes cost, over time and now; what was skipped and why; memory; automatic quality."""

    def __init__(self, history: FrameHistory) -> None:
        self._history = history
        self._profile = FrameProfile()
        self._culled = False
        self._paused = False

    def draw(self, imgui: ImGui, app: Flight) -> None:
        """One frame of the page."""
        try:
            plan = app.renderer.graph
        except SettingError:
            imgui.text("nothing has been drawn yet")
            return
        draw_percentiles(imgui, self._history)
        self._budget(imgui, app)
        toggled, on = imgui.checkbox("GPU times", plan.gpu_timing)
        if toggled:
            plan.gpu_timing = on
            self._profile.clear()
        imgui.set_item_tooltip("time stamps around each pass; they cost some time themselves")
        imgui.same_line()
        self._paused = imgui.checkbox("paused", self._paused)[1]
        imgui.same_line()
        self._culled = imgui.checkbox("unused passes too", self._culled)[1]
        passes = _pass_times(app)
        if not self._paused:
            self._profile.add(passes, plan.gpu_timing)
        draw_stack(imgui, self._profile, app.pace.auto.budget_ms)
        memory = getattr(app.renderer, "memory", None)
        if memory is not None:
            budget_mib = memory.budget_mib * len(app.scene.planets)  # each planet's renderer has one of its own
            draw_budget(imgui, app.renderer.memory_bytes, budget_mib, memory.lowered)
        draw_memory(imgui, _resources_by_size(plan), _objects(app))
        draw_passes(passes, culled=self._culled)

    def _budget(self, imgui: ImGui, app: Flight) -> None:
        auto = app.pace.auto
        toggled, on = imgui.checkbox("hold a frame budget", auto.budget_ms is not None)
        imgui.set_item_tooltip(
            "Automatic quality: fewer rows, steps and triangles while frames are late, more while there is room; at"
            " most one change in 5 s. Frames that are early wait."
        )
        if toggled:
            auto.budget_ms = _BUDGET_MS if on else None
        if auto.budget_ms is None:
            return
        imgui.same_line()
        imgui.set_next_item_width(-1.0)
        moved, ms = imgui.slider_float(
            "##budget", auto.budget_ms, 4.0, 200.0, "%.1f ms", imgui.SliderFlags_.logarithmic
        )
        if moved:
            auto.budget_ms = ms
        imgui.text_disabled(str(auto.last) if auto.last is not None else f"quality {auto.dial:.2f}, no change yet")


def _pass_times(app: Flight) -> list[PassTime]:
    helps = {declared.name: declared.help for declared in app.renderer.graph.analysis.model.passes}
    return [
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


def _resources_by_size(plan: Plan) -> list[tuple[str, int, str]]:
    specs = plan.analysis.model.specs
    sizes = [(name, plan.bytes_of(name), _what(specs[name])) for name in plan.resources if name in specs]
    return sorted(sizes, key=lambda entry: -entry[1])


def _what(spec: BufferSpec | TextureSpec) -> str:
    return spec.format if isinstance(spec, TextureSpec) else "buffer"


def _objects(app: Flight) -> list[tuple[str, int]]:
    counts = app.renderer.gpu.counts()
    totals = [(owner, sum(kinds.values())) for owner, kinds in counts.items()]
    return sorted(totals, key=lambda entry: -entry[1])


def combo(
    imgui: ImGui,
    label: str,
    shown: str,
    names: Names,
    more: Names = (),
    tips: Callable[[str], str] | None = None,
    heading: str = "resources",
) -> str | None:
    """A list to choose from; the choice of this frame, or None.

    `more` comes after a line with the heading. tips: name -> text.
    """
    found = None
    if imgui.begin_combo(label, shown, imgui.ComboFlags_.height_large):
        for group, listed in enumerate((names, more)):
            members = listed() if callable(listed) else listed
            if group and members:
                imgui.separator_text(heading)
            for name in members:
                if imgui.selectable(name, name == shown)[0]:
                    found = name
                if tips is not None:
                    imgui.set_item_tooltip(tips(name))
        imgui.end_combo()
    return found
