"""A lost OpenGL context (GPU reset, driver update, laptop asleep): said clearly, with the scene kept in a file."""

from __future__ import annotations

import logging
import os
import re
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import platformdirs
from numpy.typing import NDArray

from ..engine.gpu import gl as G
from ..errors import ContextLostError

if TYPE_CHECKING:
    from ..engine.gpu.gl import GL
    from ..scene.scene import Scene

__all__ = ["ContextWatch", "Place", "lost_scenes"]

Place = NDArray[np.float64] | None
"""(3,) planet-centred metres, or nowhere yet."""

log = logging.getLogger(__name__)

_RESETS = {0x8253: "by our own commands", 0x8254: "by another program", 0x8255: "for an unknown reason"}
_STATUS = ("glGetGraphicsResetStatus", "glGetGraphicsResetStatusARB", "glGetGraphicsResetStatusEXT")
_KEPT = 10
"""So many files of lost scenes stay; older ones go."""


def lost_scenes() -> Path:
    """The folder of scenes that were kept: PLANETFALL_LOST, or the user's own for state."""
    chosen = os.environ.get("PLANETFALL_LOST")
    return Path(chosen) if chosen else platformdirs.user_state_path("planetfall") / "lost"


class ContextWatch:
    """Asks the driver, once a call, whether the context is still there (0.5 us)."""

    def __init__(self, scene: Scene, gl: GL, errors: Callable[[], Iterable[str]], place: Callable[[], Place]) -> None:
        """errors: GL's that were found around the last frame. place: where its camera was, in metres, or None."""
        self._scene, self._errors, self._place = scene, errors, place
        name = next((n for n in _STATUS if gl.has(n)), None)
        self.status: Callable[[], int] = (lambda: 0) if name is None else gl.function(name, G.enum)
        self._error: ContextLostError | None = None

    @property
    def lost(self) -> bool:
        """Whether it is known to be gone."""
        return self._error is not None

    def check(self) -> None:
        """Raises ContextLostError, from the first time on always."""
        if self._error is None:
            why = _RESETS.get(self.status(), "")
            if not why and "GL_CONTEXT_LOST" in self._errors():
                why = "as GL_CONTEXT_LOST says"
            if not why:
                return
            self._error = ContextLostError(*self._kept(why))
        raise self._error

    def _kept(self, why: str) -> tuple[str, Path | None]:
        """The message and where the scene is; keeping it must not hide what happened."""
        scene = self._scene
        saved: Path | None = None
        try:
            folder = lost_scenes()
            folder.mkdir(parents=True, exist_ok=True)
            name = re.sub(r"[^\w.-]", "_", scene.name) or "scene"
            saved = folder / f"{name}-{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}.toml"
            scene.save(saved)
            for old in sorted(folder.glob("*.toml"), key=lambda p: p.stat().st_mtime)[:-_KEPT]:
                old.unlink(missing_ok=True)
        except Exception:
            log.warning("the scene could not be kept", exc_info=True)
            saved = None
        kept = f"the scene is kept in {saved}" if saved is not None else "the scene could not be written to a file"
        place = self._place()
        at = "" if place is None else f", the camera was at {place.tolist()} m"
        return (
            f"the OpenGL context was lost {why}: nothing of it can be drawn or read any more. In memory the scene is as"
            f" it was, and {kept}{at}. Make a new context and a new pf.Renderer(scene, ...)"
        ), saved
