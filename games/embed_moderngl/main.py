"""A bare moderngl program on a plain: balls of its own drawn before and after the planet, into its own framebuffer."""

import argparse
import sys

import moderngl
from PIL import Image

import planetfall as pf

VERTEX = """#version 330 core
uniform mat4 u_view, u_lens; uniform vec4 u_ball; out vec2 v_place; out float v_lens;
void main() {  // a square that faces the camera
    v_place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    gl_Position = u_lens * (u_view * vec4(u_ball.xyz, 1.0) + vec4(v_place * u_ball.w, 0.0, 0.0));
}"""
FRAGMENT = """#version 330 core
uniform vec3 u_color, u_sun; in vec2 v_place; out vec4 color;
void main() {
    float rest = 1.0 - dot(v_place, v_place);
    if (rest < 0.0) discard;
    color = vec4(u_color * (0.3 + 0.7 * max(dot(vec3(v_place, sqrt(rest)), u_sun), 0.0)), 1.0);
}"""


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="embed_moderngl", description=__doc__)
    parser.add_argument("--size", type=int, nargs=2, default=(960, 540), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--output", "-o", default="embedded.png")
    options = parser.parse_args(arguments)
    if min(size := tuple(options.size)) < 1:
        parser.error(f"--size: expected at least 1 x 1, found {size[0]} x {size[1]}")
    ctx = moderngl.create_context(require=430, standalone=True, backend="egl")  # type: ignore[arg-type]
    target = ctx.framebuffer([ctx.texture(size, 4)], ctx.depth_renderbuffer(size))
    ball = ctx.vertex_array(program := ctx.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT), [])
    scene, shot = pf.load_scene("earth"), pf.view("ground")
    scene.planet.remove(pf.Cover)  # no trees between its balls
    renderer = pf.Renderer(scene, size, "medium", ctx=ctx)
    space = pf.HostSpace.at(46.75276, 144.6826, 0, 105, above="ground", planet=scene.planet)
    view, lens = space.matrices(renderer.camera_state(shot), near=0.1, far=2e4)  # here the planet's camera leads
    sun = view[:3, :3] @ space.direction_to_host(pf.sun_direction(scene, camera=shot))
    program["u_view"], program["u_lens"], program["u_sun"] = view.T.ravel(), lens.T.ravel(), sun
    places = space.on_surface([(1.5 * x, 0, -5 - 4 * z) for z in range(4) for x in (-2, -1, 0, 1, 2)], 0.3)
    target.clear()
    for index, place in enumerate(places):
        if index == len(places) // 2:  # half of the balls are drawn before the planet, half after it
            renderer.render_to(target, shot, depth=space.depth(lens))
        target.use()
        ctx.enable_only(moderngl.DEPTH_TEST)
        program["u_ball"], program["u_color"] = (*place, 0.5), (0.9 - 0.04 * index, 0.3, 0.1 + 0.04 * index)
        ball.render(moderngl.TRIANGLE_STRIP, 4)
    picture = Image.frombytes("RGB", size, target.read(components=3))
    picture.transpose(Image.Transpose.FLIP_TOP_BOTTOM).save(options.output)
    renderer.release()
    return 0


if __name__ == "__main__":
    sys.exit(main())
