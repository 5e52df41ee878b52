"""Every error the library raises on purpose, in one place to catch from."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .engine.settings import PresetError, SettingError, UnknownSettingError
from .engine.world import MissingError

if TYPE_CHECKING:
    from .engine.gpu import GLLimitError, GLVersionError, ShaderError
    from .engine.graph import GraphError
    from .engine.hosts.headless import NoEGLError

__all__ = [
    "CameraError",
    "ContextLostError",
    "GLLimitError",
    "GLVersionError",
    "GraphError",
    "MissingError",
    "NoEGLError",
    "NotSettled",
    "OutputError",
    "PresetError",
    "SceneError",
    "SettingError",
    "ShaderError",
    "SizeError",
    "UnknownNameError",
    "UnknownSettingError",
]


class SceneError(SettingError):
    """A scene whose parts don't fit together, e.g. a lowest ground above the highest. Lists all that is wrong."""


class UnknownNameError(SettingError, KeyError):
    """No planet or view of that name; the message names the nearest one."""

    def __str__(self) -> str:  # KeyError would show the message in quotes
        return str(self.args[0])


class CameraError(ValueError):
    """A camera that can't be: NaN, a zero vector, an angle out of range, ground without a scene."""


class SizeError(ValueError):
    """A picture size that can't be rendered: 0, or more than the GPU can do."""


class OutputError(OSError):
    """A file that can't be written where it was asked for; said before anything is rendered."""


class NotSettled(RuntimeError):
    """Renderer.settle ran out of time; the message names what had not settled."""


class ContextLostError(RuntimeError):
    """The OpenGL context is gone (GPU reset). saved: the file that the scene was written to, or None."""

    def __init__(self, message: str, saved: Path | None = None) -> None:
        super().__init__(message)
        self.saved = saved


# These need the GPU packages, which a program that only reads presets or heights shouldn't pay for.
_LAZY = {
    "GLLimitError": ".engine.gpu",
    "GLVersionError": ".engine.gpu",
    "ShaderError": ".engine.gpu",
    "GraphError": ".engine.graph",
    "NoEGLError": ".engine.hosts.headless",
}


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(importlib.import_module(_LAZY[name], __package__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
