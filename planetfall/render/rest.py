"""Rest: a frame that would show what the last one showed is not made again."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from ..engine.frame import Frame
from ..engine.settings import revision
from ..scene.scene import Scene

__all__ = ["Rest"]


class _RestKey(NamedTuple):
    """parts: revisions of the environment; settings: their id."""

    exports: frozenset[str]
    parts: tuple[int, ...]
    size: tuple[int, int]
    ev100: float | None
    host_depth: tuple[float, float] | None
    settings: int


class Rest:
    """What the last frame was made of, as far as `Stillness` doesn't know, and whether it was complete.

    A paused scene under a still camera comes to rest once everything has streamed, refined, adapted and gathered its
    samples: from then on a frame is the copy of the finished picture to its target, and no system is updated. A game's
    own system ends it by saying that it moves, which it does unless it says otherwise (`System.moving`).
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._key: _RestKey | None = None
        self._complete = False

    def may_repeat(self, frame: Frame, settled: Callable[[], bool], exports: frozenset[str]) -> bool:
        """Whether the last picture is the one to show; asked once a frame, with `frame.still` known. settled: whether
        it was complete."""
        # Light, exposure and debug views change a picture without ending the gathering of samples.
        parts = tuple(revision(part) for part in self._scene.environment.components())
        key = _RestKey(exports, parts, frame.size, frame.ev100, frame.host_depth, id(frame.settings))
        alone = frame.cut or frame.settling or frame.one_shot or frame.exact
        same = frame.still and not alone and key == self._key
        self._key = key
        self._complete = same and (self._complete or settled())
        return self._complete

    def forget(self) -> None:
        """The next frame is made whatever was shown: a shader was reloaded, a size changed."""
        self._key = None
