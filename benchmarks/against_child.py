"""Draws frames on request and says what they took: one of the two processes of `planetfall bench --against`.

Runs as a script with PYTHONPATH on some checkout, which may be an older one: so it uses nothing but the public API. A
line of JSON in, a line of JSON out:

    {"open": {"quality": "low", "view": "near", "clouds": false, "size": [640, 360]}}  ->  {"from": folder}
    {"draw": 8}  ->  {"cpu_s": processor time of all threads, "wall_s": time by the clock}

What fails answers {"error": text} and ends it, as the end of its input does.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import time
from typing import Any

import numpy as np

import planetfall as pf

STEP_S, STEP_RAD = 1.0 / 60.0, np.radians(0.01)


class Frames:
    """A case: time runs and the camera turns, so that no frame is the one before again."""

    def __init__(self, quality: str, view: str, clouds: bool, size: list[int]) -> None:
        scene = pf.load_scene("earth")
        for planet in () if clouds else scene.planets.values():
            if planet.has(pf.Clouds):
                planet.remove(pf.Clouds)
        self._renderer = pf.Renderer(scene, (size[0], size[1]), quality)
        seen = pf.view(view)
        self._renderer.settle(seen)
        self._state, self._fov_y_deg = self._renderer.camera_state(seen), seen.fov_y_deg
        self._sun, self._start_s = seen.sun, seen.time_s or 0.0
        self._target = self._renderer.ctx.simple_framebuffer(self._renderer.size)
        self._drawn = 0

    def draw(self, count: int) -> dict[str, float]:
        """The next frames, waited for."""
        cameras = [self._camera(self._drawn + k) for k in range(count)]
        self._renderer.ctx.finish()
        began, began_used = time.perf_counter(), time.process_time()
        for camera in cameras:
            moment_s = self._start_s + self._drawn * STEP_S
            self._renderer.render_to(self._target, camera, time_s=moment_s, sun=self._sun, dt_s=STEP_S)
            self._drawn += 1
        self._renderer.ctx.finish()
        return {"cpu_s": time.process_time() - began_used, "wall_s": time.perf_counter() - began}

    def _camera(self, number: int) -> pf.Camera:
        """Turned about the vertical."""
        state, angle = self._state, number * STEP_RAD
        zenith = state.position_m / np.linalg.norm(state.position_m)
        forward, up = (
            v * np.cos(angle) + np.cross(zenith, v) * np.sin(angle) + zenith * float(zenith @ v) * (1.0 - np.cos(angle))
            for v in (state.forward, state.up)
        )
        return pf.Camera(state.position_m, forward, up, self._fov_y_deg)


def main() -> None:
    """Answers until its input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the parent's, which ends the input
    # Drivers and older versions may print: only answers go where the parent listens.
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    frames: Frames | None = None
    for line in sys.stdin:
        asked = json.loads(line)
        answer: dict[str, Any]
        try:
            if "open" in asked:
                frames = Frames(**asked["open"])
                answer = {"from": os.path.dirname(os.path.dirname(os.path.abspath(pf.__file__)))}
            elif frames is None:
                raise RuntimeError("frames were asked for before a case")
            else:
                answer = frames.draw(asked["draw"])
        except Exception as error:
            answer = {"error": f"{type(error).__name__}: {error}"}
        answers.write(json.dumps(answer) + "\n")
        answers.flush()
        if "error" in answer:
            return


if __name__ == "__main__":
    main()
