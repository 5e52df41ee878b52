"""`python -m planetfall.games.embed_scene`; without a display it says what to do."""

import runpy
import sys

import pyglet.display

try:
    pyglet.display.get_display()
except Exception as error:  # X11's alone, in a module of pyglet's that other systems cannot import
    sys.exit(
        f"embed_scene: expected a display to open a window on, found none ({error}). Start it on a "
        "desktop, or under xvfb-run -s '-screen 0 1280x720x24'. The same guest without a window: "
        "python -m planetfall.games.embed_moderngl"
    )
runpy.run_module(f"{__package__}.main", run_name="__main__")
