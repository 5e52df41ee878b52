"""A context without a window, through EGL."""

from __future__ import annotations

import ctypes.util
import logging
import sys

import moderngl

from ..gpu.caps import REQUIRED_VERSION, check_version
from ..gpu.errors import GpuError

__all__ = ["NoEGLError", "create_headless"]

log = logging.getLogger(__name__)


class NoEGLError(GpuError):
    """No context could be made without a window."""


def create_headless(require: int = REQUIRED_VERSION) -> moderngl.Context:
    """A standalone OpenGL context of at least version `require` (430 = 4.3), through EGL; no display is needed.

    The caller releases it. NoEGLError says what to install; GLVersionError names what was found if it is too old.
    """
    settings: dict[str, str] = {}
    # Without compiler tools and ldconfig (slim containers) find_library finds nothing although the files are there.
    for setting, library, file in (("libegl", "EGL", "libEGL.so.1"), ("libgl", "GL", "libGL.so.1")):
        if sys.platform.startswith("linux") and ctypes.util.find_library(library) is None:
            settings[setting] = file
    try:
        # Asked for 3.3 first where `require` is beyond the driver: only then can the error name what is there.
        try:
            ctx = moderngl.create_context(require=require, standalone=True, backend="egl", **settings)
        except ValueError:
            ctx = moderngl.create_context(require=330, standalone=True, backend="egl", **settings)
    except Exception as error:
        try:
            ctx = moderngl.create_context(require=330, standalone=True, backend="egl", **settings)
        except Exception:
            raise NoEGLError(_explain(error)) from error
    try:
        check_version(ctx, require)
    except GpuError:
        ctx.release()
        raise
    log.debug("headless context: %s, %s", ctx.info["GL_RENDERER"], ctx.info["GL_VERSION"])
    return ctx


def _explain(error: Exception) -> str:
    found = f"no OpenGL context could be made through EGL ({type(error).__name__}: {error}). "
    if sys.platform.startswith("linux"):
        return found + (
            "Install the EGL and OpenGL libraries: on Debian and Ubuntu `apt-get install libegl1 libgl1`, on Fedora "
            "`dnf install mesa-libEGL mesa-libGL`, on Arch `pacman -S mesa`; on NVIDIA the driver brings its own libEGL."
        )
    if sys.platform == "darwin":
        return found + "macOS has no EGL and stops at OpenGL 4.1; 4.3 is needed."
    return found + "This system has no EGL: open a window instead (planetfall fly), or pass an existing context as ctx=."
