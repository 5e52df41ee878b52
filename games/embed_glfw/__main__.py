"""`python -m planetfall.games.embed_glfw`; without a display it says what to do."""

import runpy
import sys
import warnings

import glfw

with warnings.catch_warnings(record=True) as said:  # glfw says there what it found
    warnings.simplefilter("always")
    if not glfw.init():
        found = str(said[-1].message) if said else "none"
        sys.exit(
            f"embed_glfw: expected a display to open a window on, found none ({found}). Start it on a desktop, or "
            "under xvfb-run -s '-screen 0 1280x720x24'. The same guest without a window: "
            "python -m planetfall.games.embed_moderngl"
        )
runpy.run_module(f"{__package__}.main", run_name="__main__")
