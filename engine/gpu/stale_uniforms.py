"""Mesa's zink on a software Vulkan: it must not bake uniforms into its shaders.

There (and only there) zink compiles a variant of a shader for values of its uniforms. A dispatch now and then runs with
the variant of an earlier value: Mesa 25.0.7, tests/systems/test_air_slices.py and docs/drivers.md. Each variant also
takes a compilation.
"""

from __future__ import annotations

import logging
import os

from .caps import is_software

__all__ = ["SWITCH", "keep_uniforms", "warn_of_stale_uniforms"]

log = logging.getLogger(__name__)

SWITCH = "ZINK_INLINE_UNIFORMS"
"""Mesa's environment variable, read when a context is made."""


def keep_uniforms() -> None:
    """Before a context is made: uniforms stay uniforms, unless the environment says otherwise."""
    os.environ.setdefault(SWITCH, "0")


def warn_of_stale_uniforms(renderer: str) -> None:
    """Say what to do where a host's context was made without the switch."""
    if renderer.lower().startswith("zink") and is_software(renderer) and os.environ.get(SWITCH) != "0":
        log.warning("%s draws with stale uniforms now and then: set %s=0 before the context is made", renderer, SWITCH)
