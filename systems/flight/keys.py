"""From the state of keys, mouse and gamepad to what the player asks of the flight."""

from __future__ import annotations

import math

from ...engine.input import InputState
from .controls import Controls, load_controls
from .orbit import OrbitInput
from .pilot import Steering
from .ship import FlightInput

_ZOOM_STEPS_PER_S = 8.0
"""Of a held key, in steps of the wheel."""

_DEFAULTS: list[Controls] = []


def steering(
    controls: Controls,
    state: InputState,
    *,
    looking: bool,
    dt_s: float,
    fov_y_deg: float = 60.0,
    size: tuple[float, float] = (16.0, 9.0),
) -> Steering:
    """This frame's wish. looking: the mouse steers (it is captured by the window). size: of the window, in the units of
    the mouse."""
    flight = flight_input(state, looking=looking, fov_y_deg=fov_y_deg, controls=controls, dt_s=dt_s)
    return Steering(flight, _orbit_input(controls, state, looking, fov_y_deg, size, dt_s, flight))


def flight_input(
    state: InputState,
    *,
    looking: bool,
    fov_y_deg: float = 60.0,
    controls: Controls | None = None,
    dt_s: float = 0.0,
) -> FlightInput:
    """What a ship or a walker is asked for. controls None: the default ones. dt_s: how long sticks have turned."""
    if controls is None:
        if not _DEFAULTS:
            _DEFAULTS.append(load_controls())
        controls = _DEFAULTS[0]
    zoom = fov_y_deg / 60.0
    pixels = controls.look_rad_per_pixel * zoom if looking else 0.0
    stick = controls.look_rad_per_s * zoom * dt_s
    yaw, pitch = controls.value("look_right", state), controls.value("look_up", state)
    turned = -1.0 if controls.invert_y else 1.0
    return FlightInput(
        forward=controls.value("forward", state),
        right=controls.value("right", state),
        up=controls.value("up", state),
        roll=controls.value("roll", state),
        # Squared, so that small ways of a stick aim and whole ones turn.
        look_yaw_rad=controls.moved("look_right", state) * pixels + math.copysign(yaw * yaw, yaw) * stick,
        look_pitch_rad=turned
        * (controls.moved("look_up", state) * pixels + math.copysign(pitch * pitch, pitch) * stick),
        boost=controls.held("boost", state),
        wheel_steps=controls.moved("speed", state),
    )


def _orbit_input(
    controls: Controls,
    state: InputState,
    looking: bool,
    fov_y_deg: float,
    size: tuple[float, float],
    dt_s: float,
    flight: FlightInput,
) -> OrbitInput:
    """flight: what the same controls ask of a ship."""
    width, height = max(size[0], 1.0), max(size[1], 1.0)

    def place(x: float, y: float) -> tuple[float, float]:
        return 2.0 * x / width - 1.0, 1.0 - 2.0 * y / height

    pointer = (0.0, 0.0) if looking else place(state.mouse_x, state.mouse_y)
    moved = (2.0 * state.mouse_dx / width, -2.0 * state.mouse_dy / height)
    return OrbitInput(
        pointer=pointer,
        pointer_before=(pointer[0] - moved[0], pointer[1] - moved[1]),
        drag=controls.held("grab", state),
        tilt=controls.held("tilt", state),
        zoom_steps=flight.wheel_steps - _ZOOM_STEPS_PER_S * dt_s * flight.up,
        forward=flight.forward,
        right=flight.right,
        turn=flight.roll + controls.value("look_right", state),
        lean=controls.value("look_up", state),
        fov_y_deg=fov_y_deg,
        aspect=width / height,
    )


__all__ = ["flight_input", "steering"]
