"""A host with a moderngl context, a framebuffer and GL state of its own, and a planet rendered into it.

The host sets its state once, at the start, and not again: the renderer gives it back after every call.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import Any

import moderngl
import numpy as np
from PIL import Image

import planetfall as pf

VERTEX = """#version 330 core
in vec2 in_place;
void main() { gl_Position = vec4(in_place, 0.0, 1.0); }
"""
FRAGMENT = """#version 330 core
uniform vec3 u_color;
out vec4 color;
void main() { color = vec4(u_color, 0.7); }
"""
PANEL = np.array([-1.0, -1.0, 1.0, -1.0, -0.9, -0.75, 0.9, -0.75], np.float32)


class Host:
    """A very small game: an empty sky and a panel. `size` in pixels."""

    def __init__(self, ctx: moderngl.Context, size: tuple[int, int]) -> None:
        self.ctx = ctx
        self.framebuffer = ctx.framebuffer([ctx.texture(size, 4)], ctx.depth_renderbuffer(size))
        program = ctx.program(vertex_shader=VERTEX, fragment_shader=FRAGMENT)
        program["u_color"] = (1.0, 0.5, 0.1)
        self.panel: Any = ctx.vertex_array(program, [(ctx.buffer(PANEL), "2f", "in_place")])
        ctx.enable(moderngl.BLEND)  # once, for good
        self.framebuffer.use()

    def frame(self, renderer: pf.Renderer, camera: pf.Camera, time_s: float) -> None:
        self.framebuffer.clear(0.0, 0.0, 0.0)
        renderer.render_to(self.framebuffer, camera, time_s)
        self.panel.render(moderngl.TRIANGLE_STRIP)  # blended over the planet; the framebuffer is still bound

    def picture(self) -> np.ndarray[Any, Any]:
        width, height = self.framebuffer.size
        return np.frombuffer(self.framebuffer.read(components=3), np.uint8).reshape(height, width, 3)[::-1]


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="embed_moderngl", description=__doc__)
    parser.add_argument("--size", type=int, nargs=2, default=(640, 360), metavar=("WIDTH", "HEIGHT"))
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--output", "-o", default="embedded.png")
    options = parser.parse_args(arguments)
    # A game has a window's context here; this one does without a window.
    settings: dict[str, Any] = {"require": 430, "standalone": True}
    if sys.platform != "win32":
        settings["backend"] = "egl"
    ctx = moderngl.create_context(**settings)
    host = Host(ctx, tuple(options.size))
    scene = pf.load_scene("earth")
    with pf.Renderer(scene, tuple(options.size), quality="medium", ctx=ctx) as renderer:
        for index in range(options.frames):
            camera = pf.Camera.at(12.0, 22.0, 2.0e6, heading_deg=2.0 * index, pitch_deg=-38.0)
            host.frame(renderer, camera, index / 24.0)
    Image.fromarray(host.picture()).save(options.output)
    sys.stdout.write(f"{options.output}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
