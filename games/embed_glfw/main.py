"""A bare glfw program in a valley: arrow keys turn its camera, boxes of its own stand before and behind the hills."""

import glfw
import moderngl

import planetfall as pf

VERTEX = """#version 330 core
uniform mat4 u_to_clip; uniform vec4 u_box; out vec3 v_place;
void main() {  // a cube as a strip of 14 corners
    v_place = u_box.xyz + u_box.w * (vec3(ivec3(0x287a, 0x02af, 0x31e3) >> gl_VertexID & 1) * 2.0 - 1.0);
    gl_Position = u_to_clip * vec4(v_place, 1.0); }"""
FRAGMENT = """#version 330 core
uniform vec3 u_color, u_sun; in vec3 v_place; out vec4 color; void main() {
    vec3 normal = normalize(cross(dFdx(v_place), dFdy(v_place)));
    color = vec4(u_color * (0.3 + 0.7 * max(dot(normal, u_sun), 0.0)), 1.0); }"""


class Game:
    def __init__(self, width: int = 960, height: int = 540) -> None:
        hints = {glfw.CONTEXT_VERSION_MAJOR: 4, glfw.CONTEXT_VERSION_MINOR: 3, glfw.DEPTH_BITS: 24}
        for hint, value in (hints | {glfw.OPENGL_PROFILE: glfw.OPENGL_CORE_PROFILE}).items():
            glfw.window_hint(hint, value)
        self.window = glfw.create_window(width, height, "A game on a planet", None, None)
        glfw.make_context_current(self.window)
        self.ctx, scene = moderngl.create_context(), pf.load_scene("earth")
        scene.planet.remove(pf.Cover)  # no trees between its boxes
        scene.sun = pf.Sun(elevation_deg=25, azimuth_deg=160, latitude_deg=2.832, longitude_deg=146.012)
        self.renderer = pf.Renderer(scene, (width, height), "medium", ctx=self.ctx)
        self.program = self.ctx.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT)
        self.box, self.heading_deg, self.time_s = self.ctx.vertex_array(self.program, []), 240.0, 0.0
        self.space = pf.HostSpace.at(2.83187, 146.012, 0, 240, above="ground", planet=scene.planet)
        self.places = self.space.on_surface([(30 * x, 0, -90 - 60 * z) for z in range(4) for x in (-2, -1, 1, 2)], 5.0)
        self.program["u_sun"] = tuple(self.space.direction_to_host(pf.sun_direction(scene)))

    def frame(self, dt: float) -> None:
        turn = glfw.get_key(self.window, glfw.KEY_RIGHT) - glfw.get_key(self.window, glfw.KEY_LEFT)
        self.heading_deg, self.time_s = self.heading_deg + 30.0 * dt * turn, self.time_s + dt
        camera = pf.Camera.at(2.83187, 146.012, 30.0, self.heading_deg, above="ground")  # glfw has none: ours leads
        view, lens = self.space.matrices(self.renderer.camera_state(camera), near=0.1, far=2e4)
        self.program["u_to_clip"] = (lens @ view).T.ravel()
        self.ctx.screen.viewport = place = (0, 0, *glfw.get_framebuffer_size(self.window))
        self.ctx.screen.use()
        self.ctx.clear(viewport=place)
        for index, box in enumerate(self.places):
            if index == len(self.places) // 2:  # half of the boxes are drawn before the planet, half after it
                self.renderer.render_to(self.ctx.screen, camera, self.time_s, None, place, dt, self.space.depth(lens))
            self.ctx.enable_only(moderngl.DEPTH_TEST)
            self.program["u_box"], self.program["u_color"] = (*box, 6.0), (0.2 + 0.05 * index, 0.3, 0.8 - 0.05 * index)
            self.box.render(moderngl.TRIANGLE_STRIP, 14)
        glfw.swap_buffers(self.window)


if __name__ == "__main__":
    glfw.init()
    game = Game()
    while not glfw.window_should_close(game.window):
        glfw.poll_events()
        game.frame(1.0 / 60.0)
    game.renderer.release()
