"""From keys and mouse to the ship: the one place that knows which key does what."""

from __future__ import annotations

from ...engine.input import InputState
from .ship import FlightInput

LOOK_RAD_PER_PIXEL = 0.0022
"""At a vertical field of view of 60 degrees; narrower views turn more slowly."""

CONTROLS: tuple[tuple[str, str], ...] = (
    ("mouse", "look around"),
    ("click, Tab", "catch the mouse, let it go"),
    ("W A S D", "fly forward, left, back, right"),
    ("Space, Ctrl", "up, down"),
    ("Q, E", "roll left, right"),
    ("Shift", "faster while held"),
    ("wheel", "faster, slower"),
)
"""What the help shows: (keys, what they do)."""


def flight_input(state: InputState, *, looking: bool, fov_y_deg: float = 60.0) -> FlightInput:
    """This frame's wish of the player. ``looking``: the mouse steers (it is captured by the window)."""
    held = state.keys_held
    scale = LOOK_RAD_PER_PIXEL * fov_y_deg / 60.0 if looking else 0.0
    return FlightInput(
        forward=state.axis("s", "w"),
        right=state.axis("a", "d"),
        up=float("space" in held) - float("left_ctrl" in held or "right_ctrl" in held),
        roll=state.axis("q", "e"),
        look_yaw_rad=state.mouse_dx * scale,
        look_pitch_rad=-state.mouse_dy * scale,
        boost="left_shift" in held or "right_shift" in held,
        wheel_steps=state.wheel,
    )
