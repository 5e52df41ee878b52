"""A pyglet game on a beach: cubes and balls in the sand, a sprite and a label over them, all of it pyglet's own."""

import moderngl
import pyglet
from pyglet.gl import GL_DEPTH_TEST, Config, glDisable, glEnable
from pyglet.math import Mat4, Vec3

import planetfall as pf

EYE, AHEAD, UP = Vec3(-6.0, 2.5, 6.0), Vec3(0.0, 0.5, -20.0), Vec3(0.0, 1.0, 0.0)


class Game(pyglet.window.Window):
    """`on_refresh` (pyglet's `on_draw` with the seconds since the last one) is all that a frame needs."""

    def __init__(self, width: int = 960, height: int = 540) -> None:
        config = Config(major_version=4, minor_version=3, depth_size=24, double_buffer=True)
        super().__init__(width, height, caption="A game on a planet", config=config)
        scene = pf.load_scene("earth")
        scene.sun = pf.Sun(elevation_deg=40, azimuth_deg=330, latitude_deg=3.179, longitude_deg=143.615)
        self.renderer = pf.Renderer(scene, (width, height), "medium", ctx=moderngl.create_context())
        # The game's metres: x to the right, y up, -z towards the sea, 0 on the sand.
        self.space = pf.HostSpace.at(3.17913, 143.61471, 0, 240, above="ground", planet=scene.planet)
        self.before, self.after, self.models, self.time_s = pyglet.graphics.Batch(), pyglet.graphics.Batch(), [], 0.0
        places = [(4 * x, 0, -12 - 9 * z) for z in range(4) for x in (-3, -1, 1, 3)]
        for index, place in enumerate(self.space.on_surface(places, height_m=0.7).tolist()):
            batch, red = (self.before, self.after)[index // 2 % 2], 0.3 + 0.04 * index
            if index % 2:
                model = pyglet.model.Cube(2.0, 2.0, 2.0, (red, 0.3, 0.9 - red, 1.0), batch=batch)
            else:
                model = pyglet.model.Sphere(1.2, color=(red, 0.3, 0.9 - red, 1.0), batch=batch)
            model.matrix = Mat4.from_translation(Vec3(*place))
            self.models.append(model)
        coin = pyglet.image.SolidColorImagePattern((255, 200, 40, 255)).create_image(32, 32)
        self.sprite = pyglet.sprite.Sprite(coin, x=12, y=12)
        self.label = pyglet.text.Label("Escape leaves", x=56, y=20)

    def on_refresh(self, dt: float) -> None:
        self.clear()
        self.time_s += dt
        self.view, self.projection = Mat4.look_at(EYE, AHEAD, UP), Mat4.perspective_projection(
            self.aspect_ratio, 0.1, 5000.0, 55.0
        )  # fmt: skip
        glEnable(GL_DEPTH_TEST)
        self.before.draw()
        camera, depth = self.space.camera(self.view, self.projection), self.space.depth(self.projection)
        place = (0, 0, *self.get_framebuffer_size())
        self.renderer.render_to(self.renderer.ctx.screen, camera, self.time_s, None, place, dt, depth)
        self.after.draw()
        glDisable(GL_DEPTH_TEST)
        self.view, self.projection = Mat4(), Mat4.orthogonal_projection(0, self.width, 0, self.height, -1, 1)
        self.sprite.draw()
        self.label.draw()


if __name__ == "__main__":
    game = Game()
    pyglet.app.run()
    game.renderer.release()
