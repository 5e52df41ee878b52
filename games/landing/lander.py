"""A Gymnasium environment: a lander above the moon with a camera that looks down."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

import planetfall as pf

GRAVITY_M_S2, THRUST_M_S2, ASIDE_M_S2 = 1.62, 4.0, 1.0
STEP_S, STEPS, SOFT_M_S, FARTHEST_M = 0.5, 240, 3.0, 5000.0
SIZE = (64, 48)


class Lander(gymnasium.Env[dict[str, Any], NDArray[np.float32]]):
    """Observations: image (48, 64, 3) u8; depth (48, 64) f32, metres along the camera's axis, at most FARTHEST_M; state
    (4,) f32: height over the ground in metres, velocity east, north and up in m/s. Actions (3,) in -1 .. 1: thrust
    east and north, and up (-1: none, 1: THRUST_M_S2). Reward: 100 for a landing below SOFT_M_S, -100 for a crash,
    else minus a hundredth of the speed in each step. The same seed and actions give the same episode."""

    metadata = {"render_modes": []}  # noqa: RUF012 - as Gymnasium has it

    def __init__(self) -> None:
        box = gymnasium.spaces.Box
        self.observation_space = gymnasium.spaces.Dict(
            image=box(0, 255, (*SIZE[::-1], 3), np.uint8),
            depth=box(0.0, FARTHEST_M, SIZE[::-1], np.float32),
            state=box(-np.inf, np.inf, (4,), np.float32),
        )
        self.action_space = box(-1.0, 1.0, (3,), np.float32)
        self._scene = pf.load_scene("moon")
        self._ground = pf.TerrainSampler(self._scene)
        self._renderer = pf.Renderer(self._scene, SIZE, "low")

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """Some 300 m above a place of the moon by day."""
        super().reset(seed=seed)
        up = self.np_random.normal(size=3)
        self._up = up / np.linalg.norm(up)
        east = np.array([-self._up[1], self._up[0], 0.0]) / np.hypot(self._up[0], self._up[1])
        self._axes = np.stack([east, np.cross(self._up, east), self._up]).astype(np.float64)
        self._position = self._up * (self._radius_of(self._up) + self.np_random.uniform(200.0, 400.0))
        self._velocity = self.np_random.uniform((-5.0, -5.0, -10.0), (5.0, 5.0, 0.0))
        latitude, longitude = (float(v) for v in pf.latitude_longitude(self._up))
        self._sun = pf.Sun(elevation_deg=35.0, azimuth_deg=120.0, latitude_deg=latitude, longitude_deg=longitude)
        self._steps = 0
        return self._observe(), {}

    def step(self, action: NDArray[np.float32]) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Half a second."""
        east, north, up = np.clip(np.asarray(action, np.float64), -1.0, 1.0)
        push = np.array([ASIDE_M_S2 * east, ASIDE_M_S2 * north, 0.5 * THRUST_M_S2 * (up + 1.0) - GRAVITY_M_S2])
        self._velocity += push * STEP_S
        self._position = self._position + self._velocity @ self._axes * STEP_S
        self._steps += 1
        speed, down = float(np.linalg.norm(self._velocity)), self._height() <= 0.0
        soft = down and speed < SOFT_M_S
        reward = 100.0 if soft else -100.0 if down else -0.01 * speed
        return self._observe(), reward, down, self._steps >= STEPS, {"landed": soft, "speed_m_s": speed}

    def close(self) -> None:
        """Free the renderer."""
        self._renderer.release()
        self._scene.release()

    def _radius_of(self, direction: NDArray[np.float64]) -> float:
        return self._scene.planet.radius_m + float(self._ground.height(direction[None])[0])

    def _height(self) -> float:
        away = float(np.linalg.norm(self._position))
        return away - self._radius_of(self._position / away)

    def _observe(self) -> dict[str, Any]:
        height = self._height()
        state = np.array([height, *self._velocity], np.float32)
        eye = self._position + self._up * max(2.0 - height, 0.0)  # the camera stays above the ground
        camera = pf.Camera(eye, -self._up, self._axes[1], ev100=13.0)
        seen = self._renderer.render(camera, 0.0, self._sun, outputs=("color", "depth"))
        return {"image": seen["color"], "depth": np.clip(seen["depth"], 0.0, FARTHEST_M), "state": state}
