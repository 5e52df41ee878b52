"""Gpu: one OpenGL context, and the owners of objects on it."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

import moderngl

from .device import Device
from .preprocess import Defines
from .scope import GpuScope

__all__ = ["VALIDATE", "Gpu"]

VALIDATE = "PLANETFALL_VALIDATE"
"""Environment variable: 1 checks shaders with a reference compiler and passes against what they declare."""


class Gpu(Device):
    """Takes a current moderngl context (its own or a host's) and adds what moderngl lacks.

    ctx: the context. gl: raw calls. caps: limits and names. shaders: the library over `shader_roots`. work: counters.
    GLVersionError below OpenGL 4.3. Without clip control (4.3 without ARB_clip_control) every shader gets the define
    PF_FRAG_DEPTH and writes the same depth values itself, at the price of early depth tests. compile_ahead: programs
    are linked at their first use, all of them where the driver has compiled them in its threads till then
    (compile_ahead.py), on other drivers those of files in the first root alone; without, when they are made.
    """

    def __init__(
        self,
        ctx: moderngl.Context,
        shader_roots: Iterable[Path | str],
        defines: Defines | None = None,
        compile_ahead: bool = False,
    ) -> None:
        super().__init__(ctx, shader_roots, defines, compile_ahead)
        if os.environ.get(VALIDATE, "").strip() not in ("", "0"):
            from .validate import validate  # authors' tools stay out of a game's process

            validate(self)

    def scope(self, owner: str) -> GpuScope:
        """A new scope whose objects are counted under `owner`."""
        return GpuScope(self, owner)
