"""`python -m planetfall.games.embed_arcade`; without a display, or without arcade, it says what to do."""

import runpy
import sys

import pyglet.display

try:
    pyglet.display.get_display()
except Exception as error:  # X11's alone, in a module of pyglet's that other systems cannot import
    sys.exit(
        f"embed_arcade: expected a display to open a window on, found none ({error}). Start it on a desktop, or under "
        "xvfb-run -s '-screen 0 1280x720x24'. The same guest without a window: "
        "python -m planetfall.games.embed_moderngl"
    )
try:
    runpy.run_module(f"{__package__}.main", run_name="__main__")
except ModuleNotFoundError as error:
    if error.name != "arcade":
        raise
    sys.exit(
        "embed_arcade: expected arcade 3, found none. It wants a Pillow of its own: python -m venv game, and there "
        "pip install arcade planetfall"
    )
