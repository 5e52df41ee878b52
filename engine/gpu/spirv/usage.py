"""How much of a driver's limits a stage takes."""

from __future__ import annotations

import math
from collections import Counter

from .access import accesses
from .module import Module

__all__ = ["usage"]

_BLOCKS = {"storage": "SHADER_STORAGE_BLOCKS", "uniform": "UNIFORM_BLOCKS"}
_PLACES = {
    "storage": "SHADER_STORAGE_BUFFER_BINDINGS", "uniform": "UNIFORM_BUFFER_BINDINGS", "image": "IMAGE_UNITS",
    "texture": "COMBINED_TEXTURE_IMAGE_UNITS",
}  # fmt: skip


def usage(stage: str, module: Module) -> dict[str, int]:
    """By name of the limit (engine.gpu.limits): objects of each kind, the places they are bound at, and for compute the
    size of a work group and what it shares in bytes."""
    touched = [access.variable for access in accesses(module)]
    kinds = Counter(variable.kind for variable in touched)
    upper = stage.upper()
    found = {f"{upper}_{name}": kinds[kind] for kind, name in _BLOCKS.items()}
    textures = "TEXTURE_IMAGE_UNITS"  # the fragment stage's has no prefix
    found[textures if stage == "fragment" else f"{upper}_{textures}"] = kinds["texture"]
    for kind, name in _PLACES.items():
        found[name] = 1 + max((v.binding for v in touched if v.kind == kind and v.binding is not None), default=-1)
    if stage == "compute":
        found["COMPUTE_IMAGE_UNIFORMS"] = kinds["image"]
        found["COMPUTE_WORK_GROUP_INVOCATIONS"] = math.prod(module.local_size)
        found["COMPUTE_SHARED_MEMORY_SIZE"] = module.shared_bytes
    return found
