"""A context without a window, through EGL."""

from __future__ import annotations

import ctypes.util
import logging
import sys
from typing import Any

import moderngl

from ..gpu.caps import REQUIRED_VERSION, check_version
from ..gpu.errors import GpuError
from ..gpu.stale_uniforms import keep_uniforms

__all__ = ["NoEGLError", "create_headless"]

log = logging.getLogger(__name__)


class NoEGLError(GpuError):
    """No context could be made without a window."""


def create_headless(require: int = REQUIRED_VERSION) -> moderngl.Context:
    """A standalone OpenGL context of at least version `require` (430 = 4.3), through EGL; no display is needed.

    The caller releases it. NoEGLError says what to install; GLVersionError names what was found if it is too old.
    """
    settings: dict[str, Any] = {"standalone": True, "backend": "egl"}
    # Without compiler tools and ldconfig (slim containers) find_library finds nothing although the files are there.
    for setting, library, file in (("libegl", "EGL", "libEGL.so.1"), ("libgl", "GL", "libGL.so.1")):
        if sys.platform.startswith("linux") and ctypes.util.find_library(library) is None:
            settings[setting] = file
    keep_uniforms()
    make: Any = moderngl.create_context
    ctx: moderngl.Context | None = None
    failure: Exception | None = None
    # An old driver refuses `require` without a word; asked for 3.3 it says what it has.
    for version in (require, min(require, 330)):
        try:
            ctx = make(require=version, **settings)
            break
        except Exception as error:
            failure = failure or error
    if ctx is None:
        raise NoEGLError(_explain(failure)) from failure
    try:
        check_version(ctx, require)
    except GpuError:
        ctx.release()
        raise
    log.debug("headless context: %s, %s", ctx.info["GL_RENDERER"], ctx.info["GL_VERSION"])
    return ctx


def _explain(error: Exception | None) -> str:
    found = f"no OpenGL context could be made through EGL ({type(error).__name__}: {error}). "
    if sys.platform.startswith("linux"):
        return found + (
            "Install the EGL and OpenGL libraries: on Debian and Ubuntu `apt-get install libegl1 libgl1`, on "
            "Fedora `dnf install mesa-libEGL mesa-libGL`, on Arch `pacman -S mesa`; NVIDIA's driver brings its own."
        )
    if sys.platform == "darwin":
        return found + "macOS has no EGL and stops at OpenGL 4.1; 4.3 is needed."
    return found + "This system has no EGL: open a window (planetfall fly), or pass an existing context as ctx=."
