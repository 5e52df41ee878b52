"""`python -m planetfall.games.embed_moderngl_window`."""

import runpy

runpy.run_module(f"{__package__}.main", run_name="__main__")
