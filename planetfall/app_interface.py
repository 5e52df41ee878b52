"""What the window shows over the picture: numbers, help, and a panel with every setting of the scene."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any

from .engine.gpu.imgui_backend import ImguiBackend
from .systems.tweak.hud import FrameHistory, HudData, PassTime, draw_hud
from .systems.tweak.panel import Panel

if TYPE_CHECKING:
    from .app import FlightApp
    from .engine.hosts.window import Window
    from .engine.input import InputState
    from .renderer import Renderer
    from .scene import Scene

__all__ = ["FlightInterface"]


class FlightInterface:
    """The app's `Interface` on ImGui. window: an open Window; the GL objects belong to the renderer's context."""

    def __init__(self, window: Window, renderer: Renderer, scene: Scene) -> None:
        self._window = window
        self._renderer = renderer
        self._scene = scene
        self._scope = renderer.gpu.scope("ui")

        def paste() -> str:
            return window.clipboard

        def copy(text: str) -> None:
            window.clipboard = text

        self._ui = ImguiBackend(self._scope, scale=window.ui_scale, clipboard=(paste, copy))
        self._history = FrameHistory()
        self._panel = Panel()
        # What "reset" goes back to: the scene as it was loaded.
        self._loaded = {name: dataclasses.replace(part) for name, part in self._parts().items()}

    def begin(self, state: InputState, app: FlightApp, dt_s: float) -> None:
        """Build the frame's interface, and hide from `state` what it used."""
        self._history.add(dt_s * 1e3)
        self._ui.scale = self._window.ui_scale
        frame = self._ui.frame(
            self._window.size, dt_s, self._window.pixel_ratio, events=state.events, mouse=not app.looking
        )
        with frame as imgui:
            draw_hud(self._hud(app), numbers=app.shown.numbers, help=app.shown.help and not app.shown.panels)
            if app.shown.panels:
                self._settings(imgui)
        # F1, F3 and the like go on working while a slider has the focus; only typing takes the keyboard.
        state.consume(keyboard=self._ui.wants_text, mouse=self._ui.wants_mouse and not app.looking)

    def draw(self, app: FlightApp) -> None:
        self._ui.render(self._window.framebuffer)

    def release(self) -> None:
        self._ui.release()
        self._scope.release()

    def _parts(self) -> dict[str, Any]:
        """The scene's components by the heading that the panel gives them."""
        handles = (self._scene.planet, self._scene.environment)
        return {
            type(part).__name__: part
            for handle in handles
            for part in handle.components()
            if dataclasses.is_dataclass(part)
        }

    def _settings(self, imgui: Any) -> None:
        em = imgui.get_font_size()
        imgui.set_next_window_pos(imgui.ImVec2(em, 16 * em), imgui.Cond_.first_use_ever)
        imgui.set_next_window_size(imgui.ImVec2(30 * em, 28 * em), imgui.Cond_.first_use_ever)
        imgui.begin("Settings")
        self._panel.draw_all(self._parts(), self._loaded)
        imgui.end()

    def _hud(self, app: FlightApp) -> HudData:
        from .app import KEYS

        ship, stats = app.ship, app.shown.stats
        passes = ()
        if app.shown.panels and app.shown.numbers and stats:  # stats: a frame has been drawn
            passes = tuple(
                PassTime(
                    report.name, report.cpu_ms or 0.0, report.gpu_ms, "" if report.ran else report.skipped_why or ""
                )
                for report in self._renderer.passes()
            )
        x, y, z = (float(value) for value in ship.position_m)
        latitude, longitude = math.degrees(math.atan2(z, math.hypot(x, y))), math.degrees(math.atan2(y, x))
        return HudData(
            fps=self._history.fps,
            frame_ms=self._history.mean_ms,
            history_ms=self._history.values_ms,
            cells=stats.get("cells"),
            vertices=stats.get("vertices"),
            triangles=stats.get("triangles"),
            passes=passes,
            lines=(
                f"{length(ship.clearance_m)} above ground",
                f"{length(ship.speed_m_s)}/s" + ("" if ship.throttle == 1.0 else f"   throttle {ship.throttle:.2g}"),
                f"{latitude:.4f} {longitude:.4f}",
            ),
            message=app.shown.message,
            controls=KEYS,
        )


def length(metres: float) -> str:
    """A length in the unit that suits it."""
    if abs(metres) >= 1e5:
        return f"{metres / 1e3:,.0f} km".replace(",", " ")
    if abs(metres) >= 1e4:
        return f"{metres / 1e3:.1f} km"
    return f"{metres:.0f} m" if abs(metres) >= 100.0 else f"{metres:.1f} m"
