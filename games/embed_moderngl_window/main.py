"""A moderngl-window game in a valley: its own cubes stand among the hills, its panel is drawn over the picture."""

from typing import Any

import moderngl
import numpy as np
from moderngl_window import geometry
from moderngl_window.context.base import WindowConfig
from moderngl_window.scene.camera import Camera

import planetfall as pf

VERTEX = """#version 330 core\nuniform mat4 u_to_clip; uniform vec3 u_place; in vec3 in_position; in vec3 in_normal;
out vec3 v_normal; void main() { v_normal = in_normal; gl_Position = u_to_clip * vec4(in_position + u_place, 1.0); }"""
FRAGMENT = """#version 330 core\nuniform vec3 u_sun; uniform vec4 u_color; in vec3 v_normal; out vec4 color;
void main() { color = vec4(u_color.rgb * (0.3 + 0.7 * max(dot(normalize(v_normal), u_sun), 0.0)), u_color.a); }"""


class Game(WindowConfig):
    """`on_render` is all that a frame needs; the planet is one call in it."""

    gl_version, title, window_size, aspect_ratio, resource_dir = (4, 3), "A game on a planet", (960, 540), None, None

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        scene = pf.load_scene("earth")
        scene.sun = pf.Sun(elevation_deg=25, azimuth_deg=160, latitude_deg=2.832, longitude_deg=146.012)
        self.renderer = pf.Renderer(scene, self.wnd.buffer_size, "medium", ctx=self.ctx)
        self.wnd.close_func = self.renderer.release
        # The game's metres: x to the right, y up, -z along the valley, 0 at its floor.
        self.space = pf.HostSpace.at(2.83187, 146.012, 0, 240, above="ground", planet=scene.planet)
        self.places = self.space.on_surface([(30 * x, 0, -90 - 60 * z) for z in range(4) for x in (-2, -1, 1, 2)], 5.0)
        self.program = self.ctx.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT)
        self.cube, self.panel = geometry.cube(size=(12, 12, 12)), geometry.quad_2d(size=(2.0, 0.2), pos=(0.0, -0.9))
        self.camera = Camera(55.0, self.wnd.aspect_ratio, near=0.1, far=20000.0)
        self.camera.set_position(0.0, 30.0, 0.0)
        self.program["u_sun"] = tuple(self.space.direction_to_host(pf.sun_direction(scene)))

    def draw(self, mesh: Any, to_clip: Any, place: Any, color: tuple[float, ...]) -> None:
        self.program["u_to_clip"] = tuple(np.asarray(to_clip, np.float32).T.ravel())
        self.program["u_place"], self.program["u_color"] = tuple(place), color
        mesh.render(self.program)

    def on_render(self, time: float, frame_time: float) -> None:
        self.ctx.enable_only(moderngl.DEPTH_TEST)
        self.camera.projection.update(aspect_ratio=self.wnd.aspect_ratio)  # windows change their shape
        view, lens = np.array(self.camera.matrix), np.array(self.camera.projection.matrix)
        for index, place in enumerate(self.places):
            if index == len(self.places) // 2:  # half of the cubes are drawn before the planet, half after it
                camera, depth = self.space.camera(view, lens), self.space.depth(lens)
                self.renderer.render_to(self.wnd.fbo, camera, time, None, self.wnd.fbo.viewport, frame_time, depth)
            self.draw(self.cube, lens @ view, place, (0.2 + 0.05 * index, 0.3, 0.8 - 0.05 * index, 1.0))
        self.ctx.enable_only(moderngl.BLEND)
        self.draw(self.panel, np.eye(4), (0.0, 0.0, 0.0), (1.0, 0.6, 0.1, 0.7))


if __name__ == "__main__":
    Game.run()
