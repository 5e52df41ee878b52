"""PLANETFALL_VALIDATE=1, for authors of shaders and passes: what other drivers would refuse is an error here, too."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from ..table_cache import TableCache
from .errors import ShaderError, ShaderMessage
from .limits import LIMITS
from .preprocess import Expanded
from .spirv import Module, ReferenceCompiler, faults, usage
from .watch import GLWatch

if TYPE_CHECKING:
    from .device import Device

__all__ = ["ShaderCheck", "validate"]

log = logging.getLogger(__name__)


class ShaderCheck:
    """All checks of a program's stages. folder: where what has passed is kept; None: nowhere."""

    def __init__(self, folder: Path | None = None) -> None:
        self._compiler = ReferenceCompiler(folder)

    def __call__(self, expanded: Mapping[str, Expanded]) -> dict[str, Module]:
        """SPIR-V by stage. ShaderError names the file and line that the reference compiler refuses, an implicit
        conversion, a fault that lint.py finds, or more than the limits that are promised."""
        modules = {}
        for stage, text in expanded.items():
            modules[stage] = module = self._compiler.compile(stage, text)
            said = [*faults(stage, module), *_beyond(stage, module)]
            found = [*(ShaderMessage("", 0, text) for text in said), *self._compiler.strict(stage, text)]
            if found:
                raise ShaderError(text.name, "other compilers may refuse it", found)
        return modules


def _beyond(stage: str, module: Module) -> list[str]:
    """Sentences about limits that a stage goes beyond."""
    taken = usage(stage, module)
    return [
        f"{limit.what}: {taken[limit.name]} of at most {limit.needed} (GL_MAX_{limit.name}); do with fewer"
        for limit in LIMITS
        if taken.get(limit.name, 0) > limit.needed
    ]


def validate(gpu: Device) -> None:
    """Check this GPU's programs from here on, and let frame graphs hear what their passes touch."""
    gpu.shaders.check = ShaderCheck(TableCache("spirv").folder)
    gpu.watch = GLWatch(gpu)
    log.info("validating shaders and passes: frames take many times as long")
