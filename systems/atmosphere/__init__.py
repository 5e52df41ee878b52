"""The air: what it consists of, checked (`AirModel`), as shaders read it (`AirBlock`), and tables of its light.

Names are imported on first use: scenes check their air with the model, and need no GPU package for that.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .block import AirBlock, air_block
    from .model import AirModel
    from .paper import PaperSizes, PaperTables

__all__ = ["AirBlock", "AirModel", "PaperSizes", "PaperTables", "air_block"]

_LAZY = {
    "AirBlock": ".block",
    "AirModel": ".model",
    "PaperSizes": ".paper",
    "PaperTables": ".paper",
    "air_block": ".block",
}


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(importlib.import_module(_LAZY[name], __package__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
