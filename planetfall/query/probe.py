"""Probe: what probes of air and clouds share: a context of their own or a host's, and everything freed once."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from typing import Self

import moderngl

from .. import ASSETS
from ..engine.gpu import Gpu
from ..engine.hosts.foreign import ForeignHost, attach


class Probe:
    """Base of probes. ctx: a host's current moderngl context; None makes a headless one."""

    def __init__(self, ctx: moderngl.Context | None) -> None:
        self._host: ForeignHost | None = None
        if ctx is None:
            from ..engine.hosts.headless import create_headless

            self._gpu = Gpu(create_headless(), [ASSETS / "shaders"])
        else:
            self._host = attach(ctx, [ASSETS / "shaders"])
            self._gpu = self._host.gpu
        self._released = False
        with self._guest():
            self._scope = self._gpu.scope("probe")

    def release(self) -> None:
        """Free every GL object; may be called twice."""
        if self._released:
            return
        with self._guest():
            self._released = True
            self._scope.release()
            self._gpu.release()
        if self._host is None:
            self._gpu.ctx.release()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()

    def _guest(self) -> AbstractContextManager[object]:
        if self._released:
            raise ValueError("this probe has been released: make a new one")
        if self._host is not None:
            return self._host.guest()
        self._gpu.ctx.__enter__()
        return nullcontext()
