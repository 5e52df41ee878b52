"""A moderngl-window game in a valley: a glTF file as moderngl-window's own Scene, at many places of the ground."""

from pathlib import Path
from typing import Any

import glm
import moderngl
import numpy as np
from moderngl_window.context.base import WindowConfig
from moderngl_window.scene.camera import Camera

import planetfall as pf

PLACES = [(13.0 * x, 0.0, -40.0 - 30.0 * z) for z in range(3) for x in (-2, -1, 0, 1, 2)]


class Game(WindowConfig):
    """The planet is one call in `on_render`; before and after it the game draws as ever."""

    gl_version, title, window_size, aspect_ratio = (4, 3), "Huts on a planet", (960, 540), None
    resource_dir = Path(__file__).parent

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        world = pf.load_scene("earth")
        world.planet.remove(pf.Cover)  # no trees between its huts
        world.sun = pf.Sun(elevation_deg=25, azimuth_deg=160, latitude_deg=2.832, longitude_deg=146.012)
        self.renderer = pf.Renderer(world, self.wnd.buffer_size, "medium", ctx=self.ctx)
        self.wnd.close_func = self.renderer.release
        # The scenes' metres: x to the right, y up, -z along the valley, 0 at its floor.
        self.space = pf.HostSpace.at(2.83187, 146.012, 0, 240, above="ground", planet=world.planet)
        self.hut, self.models = self.load_scene("hut.glb"), []
        for foot in self.space.on_surface(PLACES):
            # Up is another direction at each place, by a second of arc for every 31 m.
            up = self.space.direction_to_host(self.space.to_planet(foot))
            side = np.cross(up, (0.0, 0.0, 1.0))
            axes = [v / np.linalg.norm(v) for v in (side, up, np.cross(side, up))]
            columns = np.concatenate([np.stack([*axes, foot]), np.eye(4)[:, 3:]], axis=1)
            self.models.append(glm.mat4(*columns.ravel().tolist()))
        self.camera = Camera(55.0, self.wnd.aspect_ratio, near=0.1, far=20000.0)
        self.camera.set_position(0.0, 13.0, 0.0)

    def draw(self, models: list[Any]) -> None:  # one scene at many places: its matrix moves all its nodes
        self.ctx.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        for model in models:
            self.hut.matrix = model
            self.hut.draw(self.camera.projection.matrix, self.camera.matrix)

    def on_render(self, time: float, frame_time: float) -> None:
        self.camera.projection.update(aspect_ratio=self.wnd.aspect_ratio)  # windows change their shape
        view, lens = np.array(self.camera.matrix), np.array(self.camera.projection.matrix)
        half = len(self.models) // 2
        self.draw(self.models[:half])
        camera, depth = self.space.camera(view, lens), self.space.depth(lens)
        self.renderer.render_to(self.wnd.fbo, camera, time, None, self.wnd.fbo.viewport, frame_time, depth)
        self.draw(self.models[half:])


if __name__ == "__main__":
    Game.run()
