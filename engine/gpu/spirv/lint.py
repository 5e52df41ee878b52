"""Faults that compile here and fail, or mean something else, with other compilers."""

from __future__ import annotations

from .access import accesses
from .flow import divergent_barriers
from .module import Module
from .words import forbidden

__all__ = ["faults"]


def faults(stage: str, module: Module) -> list[str]:
    """Sentences, none where there is nothing to say: names that some GLSL version reserves or has built in, outputs
    that nothing writes, barriers that not all invocations of a work group may reach."""
    return [*_names(module), *_outputs(stage, module), *_barriers(module)]


def _names(module: Module) -> list[str]:
    declared = {name.partition("(")[0] for name in module.names.values()} | set(module.members.values())
    return [
        f"the name {name!r} is {why}; choose another"
        for name in sorted(declared)
        if not name.startswith("gl_") and (why := forbidden(name))
    ]


def _outputs(stage: str, module: Module) -> list[str]:
    if stage == "compute":
        return []
    written = {access.variable.id for access in accesses(module) if access.writes}
    return [
        f"the output {variable.name!r} is written nowhere: it would be undefined; write it or take it out"
        for variable in module.variables.values()
        if variable.kind == "output" and variable.built_in is None and variable.id not in written
    ]


def _barriers(module: Module) -> list[str]:
    return [
        f"a barrier in {name} may be reached by a part of the work group only, because {why}; move it to where all "
        "invocations come by, or make the condition one of uniforms and of the work group's number"
        for name, why in divergent_barriers(module)
    ]
