"""A pygame-ce game with moderngl off a beach: boxes of its own float there, a pygame surface lies over the picture."""

import moderngl
import pygame

import planetfall as pf

VERTEX = """#version 330 core
uniform mat4 u_to_clip; uniform vec4 u_box; out vec3 v_place; void main() {  // a cube as a strip of 14 corners
    v_place = u_box.xyz + u_box.w * (vec3(ivec3(0x287a, 0x02af, 0x31e3) >> gl_VertexID & 1) * 2.0 - 1.0);
    gl_Position = u_to_clip * vec4(v_place, 1.0); }"""
FRAGMENT = """#version 330 core
in vec3 v_place; out vec4 color; void main() {
    color = vec4(vec3(0.7, 0.2, 0.5) * (0.65 + 0.35 * normalize(cross(dFdx(v_place), dFdy(v_place))).y), 1.0); }"""
FLAT = """#version 330 core
uniform vec2 u_size; out vec2 v_uv; void main() { v_uv = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = vec4(u_size * v_uv - 0.95, 0.0, 1.0); }"""
PAINT = """#version 330 core
uniform sampler2D u_text; in vec2 v_uv; out vec4 color; void main() { color = texture(u_text, v_uv); }"""


class Game:
    def __init__(self, width: int = 960, height: int = 540) -> None:
        pygame.init()
        for name, value in (("CONTEXT_MAJOR_VERSION", 4), ("CONTEXT_MINOR_VERSION", 3), ("DEPTH_SIZE", 24)):
            pygame.display.gl_set_attribute(getattr(pygame, f"GL_{name}"), value)  # before the window
        pygame.display.gl_set_attribute(pygame.GL_CONTEXT_PROFILE_MASK, pygame.GL_CONTEXT_PROFILE_CORE)
        pygame.display.set_mode((width, height), pygame.OPENGL | pygame.DOUBLEBUF)
        self.ctx, scene, self.time_s = moderngl.create_context(), pf.load_scene("earth"), 0.0
        scene.sun = pf.Sun(elevation_deg=40, azimuth_deg=330, latitude_deg=3.179, longitude_deg=143.615)
        self.renderer = pf.Renderer(scene, (width, height), "medium", ctx=self.ctx)
        self.boxes = self.ctx.vertex_array(self.ctx.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT), [])
        self.flat = self.ctx.vertex_array(self.ctx.program(vertex_shader=FLAT, fragment_shader=PAINT), [])
        text = pygame.font.Font(None, 32).render("Close to leave", True, "white", (20, 20, 60))
        self.ctx.texture(text.get_size(), 4, pygame.image.tobytes(text, "RGBA", True)).use()  # the planet leaves it so
        self.flat.program["u_size"] = 2.0 * text.width / width, 2.0 * text.height / height
        self.camera = pf.Camera.at(3.17913, 143.61471, 2.5, 240.0, above="ground")
        self.space = pf.HostSpace.at(3.17913, 143.61471, 0, 240, above="ground", planet=scene.planet)
        self.places = self.space.on_surface([(4 * x, 0, -12 - 9 * z) for z in range(4) for x in (-3, -1, 1, 3)], 0.7)

    def frame(self, dt: float) -> None:
        self.time_s, place = self.time_s + dt, (0, 0, *pygame.display.get_window_size())
        view, lens = self.space.matrices(self.renderer.camera_state(self.camera), near=0.1, far=5e3)
        self.ctx.clear(viewport=place)
        self.renderer.render_to(self.ctx.screen, self.camera, self.time_s, None, place, dt, self.space.depth(lens))
        self.ctx.enable_only(moderngl.DEPTH_TEST)
        self.boxes.program["u_to_clip"] = (lens @ view).T.ravel()
        for box in self.places:
            self.boxes.program["u_box"] = (*box, 1.2)
            self.boxes.render(moderngl.TRIANGLE_STRIP, 14)
        self.ctx.enable_only(moderngl.NOTHING)
        self.flat.render(moderngl.TRIANGLE_STRIP, 4)
        pygame.display.flip()


if __name__ == "__main__":
    game, clock = Game(), pygame.time.Clock()
    while not pygame.event.get(pygame.QUIT):
        game.frame(0.001 * clock.tick(60))
    game.renderer.release()
