"""An arcade 3 game off a beach: boxes of arcade.gl float there, sprites and a text lie over the picture."""

import arcade  # pyright: ignore[reportMissingImports]
import moderngl
from arcade.gl import geometry  # pyright: ignore[reportMissingImports]
from pyglet.math import Mat4, Vec3

import planetfall as pf

EYE, AHEAD, UP = Vec3(-6.0, 2.5, 6.0), Vec3(0.0, 0.5, -20.0), Vec3(0.0, 1.0, 0.0)
VERTEX = """#version 330 core
uniform mat4 u_to_clip; uniform vec3 u_place; in vec3 in_position; in vec3 in_normal; out vec3 v_normal;
void main() { v_normal = in_normal; gl_Position = u_to_clip * vec4(in_position + u_place, 1.0); }"""
FRAGMENT = """#version 330 core
uniform vec3 u_color, u_sun; in vec3 v_normal; out vec4 color;
void main() { color = vec4(u_color * (0.4 + 0.6 * max(dot(normalize(v_normal), u_sun), 0.0)), 1.0); }"""


class Game(arcade.Window):
    """`on_draw` is all that a frame needs."""

    def __init__(self, width: int = 960, height: int = 540) -> None:
        super().__init__(width, height, "A game on a planet", gl_version=(4, 3))
        scene = pf.load_scene("earth")
        scene.sun = pf.Sun(elevation_deg=40, azimuth_deg=330, latitude_deg=3.179, longitude_deg=143.615)
        # arcade.gl is no moderngl: this one is the library's own, on the same context.
        self.renderer = pf.Renderer(scene, (width, height), "medium", ctx=moderngl.create_context())
        self.space = pf.HostSpace.at(3.17913, 143.61471, 0, 240, above="ground", planet=scene.planet)
        self.places = self.space.on_surface([(4 * x, 0, -12 - 9 * z) for z in range(4) for x in (-3, -1, 1, 3)], 0.7)
        self.box = geometry.cube((2.4, 2.4, 2.4))
        self.program = self.ctx.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT)
        self.program["u_sun"] = tuple(self.space.direction_to_host(pf.sun_direction(scene)).tolist())
        self.coins, self.text = arcade.SpriteList(), arcade.Text("Close to leave", 56, 20)
        self.coins.append(arcade.SpriteSolidColor(32, 32, 28, 28, (255, 200, 40, 255)))
        self.time_s = self.dt_s = 0.0

    def on_update(self, delta_time: float) -> None:
        self.dt_s, self.time_s = delta_time, self.time_s + delta_time

    def on_draw(self) -> None:
        self.clear()
        view, lens = Mat4.look_at(EYE, AHEAD, UP), Mat4.perspective_projection(self.aspect_ratio, 0.1, 5000.0, 55.0)
        self.program["u_to_clip"] = lens @ view
        self.ctx.enable(self.ctx.DEPTH_TEST)
        for index, place in enumerate(self.places.tolist()):
            if index == len(self.places) // 2:  # half of the boxes are drawn before the planet, half after it
                camera, depth = self.space.camera(view, lens), self.space.depth(lens)
                target, all_of_it = self.renderer.ctx.screen, (0, 0, *self.get_framebuffer_size())
                self.renderer.render_to(target, camera, self.time_s, None, all_of_it, self.dt_s, depth)
            self.program["u_place"], self.program["u_color"] = place, (0.3 + 0.04 * index, 0.2, 0.7 - 0.04 * index)
            self.box.render(self.program)
        self.ctx.disable(self.ctx.DEPTH_TEST)
        self.coins.draw()
        self.text.draw()


if __name__ == "__main__":
    game = Game()
    game.run()
    game.renderer.release()
