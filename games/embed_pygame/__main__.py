"""`python -m planetfall.games.embed_pygame`; without a display it says what to do."""

import runpy
import sys

try:
    import pygame
except ImportError:
    sys.exit("embed_pygame: expected pygame-ce, found none. Install it: pip install pygame-ce")
try:
    pygame.display.init()
    if pygame.display.get_driver() in ("dummy", "offscreen"):
        raise pygame.error(f"only the driver {pygame.display.get_driver()!r}, which has no OpenGL")
except pygame.error as error:
    sys.exit(
        f"embed_pygame: expected a display to open a window on, found none ({error}). Start it on a desktop, or under "
        "xvfb-run -s '-screen 0 1280x720x24'. The same guest without a window: "
        "python -m planetfall.games.embed_moderngl"
    )
runpy.run_module(f"{__package__}.main", run_name="__main__")
