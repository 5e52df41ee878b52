"""Unseen: systems of a planet, or of its ground, that is not in the picture rest."""

from __future__ import annotations

from typing import NamedTuple

from ..settings import latest_revision
from .frame import Frame

__all__ = ["Unseen"]


class Unseen:
    """For a system of the planet: whether it may leave a frame alone, because nothing of the planet is in the view.

    kinds: components whose change it has to hear of all the same. ground: nothing of its ground and sea is enough.
    Systems ask in every update; the answer is no in the first frame without the planet, so that they can let go of what
    is meant for it, and in single pictures.
    """

    def __init__(self, *kinds: type, ground: bool = False) -> None:
        self._kinds, self._ground = kinds, ground

    def rests(self, frame: Frame) -> bool:
        """Whether the last frame of the view was told that the planet is not in it, and nothing else is new."""
        seen = frame.view.seen
        if (seen.ground() if self._ground else seen.planet()) or frame.at_once:
            frame.view.forget(self)
            return False
        inputs = _Inputs(latest_revision(*self._kinds), frame.world.structure_revision, frame.size)
        last = frame.view.state(self, _Told)
        rests, last.inputs = last.inputs == inputs, inputs
        return rests


class _Inputs(NamedTuple):
    """What a resting system has to hear of. parts: latest revision of its kinds; structure: the world's."""

    parts: int
    structure: int
    size: tuple[int, int]


class _Told:
    inputs: _Inputs | None = None
