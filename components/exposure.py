"""Exposure and Composite: from scene radiance to a picture."""

from __future__ import annotations

from dataclasses import dataclass

from ._knob import knob

__all__ = ["Composite", "Exposure"]


@dataclass
class Exposure:
    """How bright the picture is. EV 100 is that of a camera at ISO 100: one more halves the brightness."""

    mode: str = knob("auto", help="Adapt to the scene, or stay at ev100", choices=("auto", "fixed"))
    ev100: float = knob(14.0, -20.0, 30.0, "EV", "Exposure in fixed mode")
    min_ev100: float = knob(-4.0, -20.0, 30.0, "EV", "Automatic exposure never goes below: night stays dark")
    max_ev100: float = knob(17.0, -20.0, 30.0, "EV", "Automatic exposure never goes above")
    compensation_ev: float = knob(0.0, -10.0, 10.0, "EV", "Added brightness in auto mode; +1 is twice as bright")
    brighter_s: float = knob(1.0, 0.0, 60.0, "s", "Time to get used to a darker scene; 0 is at once")
    darker_s: float = knob(0.4, 0.0, 60.0, "s", "Time to get used to a brighter scene; 0 is at once")


@dataclass
class Composite:
    """How radiance becomes display colour once it is exposed."""

    antialiasing: str = knob(
        "temporal",
        help="Smooth edges and detail that doesn't shimmer: temporal gathers samples over frames, edge smooths the "
        "steps of outlines in a single frame",
        cost="temporal: two pictures of memory and one pass; edge: one of each; none: nothing",
        choices=("none", "edge", "temporal"),
    )
    tone_map: str = knob(
        "camera",
        help="Curve from light to the screen: camera has its white where a camera has; agx keeps four stops above it "
        "and calm hues, aces is punchy, hable soft, reinhard plain; neutral keeps colours, linear clips",
        choices=("camera", "agx", "aces", "hable", "reinhard", "neutral", "linear"),
    )
    dither: bool = knob(True, help="Noise of less than one step of an 8-bit picture, against banding in skies")
    bloom: float = knob(
        0.004,
        0.0,
        0.3,
        "",
        "Share of the light that glares around bright things, as in an eye or a lens",
        cost="above 0: some passes at a quarter of the size and below",
    )
