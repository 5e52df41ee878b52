"""Clouds: what they consist of, checked (`CloudModel`), as shaders read it (`CloudBlock`), and the march's questions.

Names are imported on first use: scenes check their clouds with the model, and need no GPU package for that.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .block import CloudBlock, cloud_block
    from .model import CloudModel, LayerModel

__all__ = ["CloudBlock", "CloudModel", "LayerModel", "cloud_block"]

_LAZY = {
    "CloudBlock": ".block",
    "CloudModel": ".model",
    "LayerModel": ".model",
    "cloud_block": ".block",
}


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(importlib.import_module(_LAZY[name], __package__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
