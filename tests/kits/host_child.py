"""The examples that embed a planet, a few frames each, in a process of its own: `python host_child.py NAME PICTURE`
prints JSON. It needs nothing but the library and the host, so that another environment's Python can run it."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

SIZE = (480, 270)
FRAMES = 3


def save(path: str, size: tuple[int, int], rgb: bytes) -> None:
    from PIL import Image

    Image.frombytes("RGB", size, rgb).transpose(Image.Transpose.FLIP_TOP_BOTTOM).save(path)


class Shown:
    """What was in the window before it was swapped, and the errors up to then."""

    def __init__(self) -> None:
        self.frames, self.errors, self.rgb = 0, set[str](), b""

    def take(self, ctx: Any) -> None:
        self.errors.add(ctx.error)
        self.frames += 1
        self.rgb = ctx.screen.read(viewport=(0, 0, *SIZE), components=3)
        _ = ctx.error  # moderngl reads a window's framebuffer by a name that only others have

    def answer(self, path: str, renderer: Any) -> dict[str, Any]:
        save(path, SIZE, self.rgb)
        renderer.release()
        return {"frames": self.frames, "errors": sorted(self.errors), "left": renderer.gpu.counts()}


def glfw(path: str) -> dict[str, Any]:
    import glfw

    from planetfall.games.embed_glfw.main import Game

    assert glfw.init()
    game, shown = Game(*SIZE), Shown()
    swap, glfw.swap_buffers = glfw.swap_buffers, lambda window: (shown.take(game.ctx), swap(window))
    for _ in range(FRAMES):
        glfw.poll_events()
        game.frame(0.05)
    answer = shown.answer(path, game.renderer)
    glfw.terminate()
    return answer


def pygame(path: str) -> dict[str, Any]:
    import pygame

    from planetfall.games.embed_pygame.main import Game

    game, shown = Game(*SIZE), Shown()
    flip, pygame.display.flip = pygame.display.flip, lambda: (shown.take(game.ctx), flip())
    for _ in range(FRAMES):
        pygame.event.pump()
        game.frame(0.05)
    answer = shown.answer(path, game.renderer)
    pygame.quit()
    return answer


def arcade(path: str) -> dict[str, Any]:
    import arcade
    from pyglet import gl

    from planetfall.games.embed_arcade.main import Game

    game = Game(*SIZE)
    for _ in range(FRAMES):
        game.dispatch_events()
        game.on_update(0.05)
        game.on_draw()
        arcade.get_image().convert("RGB").save(path)
        game.flip()
    error = gl.glGetError()
    game.renderer.release()
    left = game.renderer.gpu.counts()
    game.close()
    return {"frames": FRAMES, "errors": ["GL_NO_ERROR" if not error else str(error)], "left": left}


def scene(path: str) -> dict[str, Any]:
    import moderngl_window

    from planetfall.games.embed_scene.main import Game

    seen: dict[str, Any] = {"frames": 0}

    class Watched(Game):
        window_size = SIZE

        def on_render(self, time: float, frame_time: float) -> None:
            super().on_render(time, frame_time)
            seen["frames"] += 1
            if seen["frames"] == FRAMES:
                seen["errors"], seen["renderer"] = [self.ctx.error], self.renderer
                save(path, SIZE, self.wnd.fbo.read(viewport=(0, 0, *SIZE), components=3))
                self.wnd.close()

    moderngl_window.run_window_config(Watched, args=("--window", "glfw"))
    seen["left"] = seen.pop("renderer").gpu.counts()
    return seen


if __name__ == "__main__":
    answer = globals()[sys.argv[1]](*sys.argv[2:])
    sys.stdout.write(json.dumps(answer) + "\n")
    sys.stdout.flush()
