"""ImGui: the type of the module `imgui_bundle.imgui`, which is imported only once something is drawn with it."""

from __future__ import annotations

from types import ModuleType
from typing import TypeAlias

__all__ = ["ImGui"]

ImGui: TypeAlias = ModuleType
