"""Clouds while a camera turns: pictures with a ray for each block in every frame, and with one for every second block,
against those that a camera has gathered which stands still."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ... import Renderer
from ...quality import resolve_quality
from .air_speed import Cost, time_passes, total
from .antialiasing import display_light, rms
from .cloud_pictures import camera_at, scene_of_weather
from .motion import turned

__all__ = ["EVERY", "RAY_PASSES", "costs", "errors", "pixels_a_ray"]

EVERY = (1, 2)
"""Of clouds.march_every."""
RAY_PASSES = ("clouds.classify", "clouds.march", "clouds.shafts", "clouds.between")
"""What is done for each ray."""
_WARM_UP, _COUNTED = 16, 6
_QUALITY = "medium"


def _renderer(size: tuple[int, int], every: int) -> Renderer:
    return Renderer(scene_of_weather(), size, _QUALITY, {"clouds.march_every": every})


def errors(name: str, step_deg: float, size: tuple[int, int]) -> dict[int, float]:
    """Rms difference, in steps of 8 bits, by EVERY, over the last frames of a turn by step_deg a frame."""
    seen: dict[int, list[NDArray[np.uint8]]] = {}
    truth: list[NDArray[np.uint8]] = []
    for every in EVERY:
        with _renderer(size, every) as renderer:
            camera = camera_at(name)
            renderer.settle(camera)
            cameras = turned(renderer.camera_state(camera), step_deg, _WARM_UP + _COUNTED)
            shown = [renderer.render(each, dt_s=1.0 / 60.0)["color"] for each in cameras]
            seen[every] = [np.asarray(picture) for picture in shown[_WARM_UP:]]
            if every == EVERY[0]:
                for each in cameras[_WARM_UP:]:
                    renderer.settle(each)
                    truth.append(np.asarray(renderer.render(each)["color"]))
    return {
        every: float(
            np.sqrt(np.mean([rms(display_light(a), display_light(b)) ** 2 for a, b in zip(found, truth, strict=True)]))
        )
        for every, found in seen.items()
    }


def costs(names: Sequence[str], size: tuple[int, int], runs: int) -> dict[tuple[str, str], Cost]:
    """Of the passes of rays in a turn, by EVERY as text and camera."""
    renderers = {str(every): _renderer(size, every) for every in EVERY}
    try:
        states = {name: renderers[str(EVERY[0])].camera_state(camera_at(name)) for name in names}
        cameras = {name: turned(state, 0.1, 4) for name, state in states.items()}
        found = time_passes(renderers, cameras, runs)
    finally:
        for renderer in renderers.values():
            renderer.release()
    return {key: total(passes, RAY_PASSES) for key, passes in found.items()}


def pixels_a_ray(every: int) -> int:
    """Of the frame."""
    settings = resolve_quality(_QUALITY)
    return every * (int(settings["clouds.stride"]) * int(settings["clouds.picture_px"])) ** 2
