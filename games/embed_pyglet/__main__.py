"""`python -m planetfall.games.embed_pyglet`."""

import runpy

runpy.run_module(f"{__package__}.main", run_name="__main__")
