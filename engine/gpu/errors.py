"""Errors of the GPU layer: each says what was expected, what was found and what to do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..blocks.errors import FormatError, GpuError

__all__ = ["FormatError", "GLLimitError", "GLVersionError", "GpuError", "ShaderError", "ShaderMessage"]


class GLVersionError(GpuError):
    """The context is older than OpenGL 4.3 core. Attributes say what was found."""

    def __init__(self, required: int, found: int, version: str, renderer: str, vendor: str) -> None:
        self.required, self.found = required, found
        self.version, self.renderer, self.vendor = version, renderer, vendor
        need, have = f"{required // 100}.{required // 10 % 10}", f"{found // 100}.{found // 10 % 10}"
        super().__init__(
            f"OpenGL {need} core is needed, found {have} "
            f"(version {version!r}, renderer {renderer!r}, vendor {vendor!r}). "
            f"Update the graphics driver, ask the window for a {need} core context, or use Mesa's software renderer "
            "(LIBGL_ALWAYS_SOFTWARE=1). macOS stops at 4.1 and cannot run this."
        )


class GLLimitError(GpuError):
    """The driver allows shaders less than they need. missing: a phrase each."""

    def __init__(self, renderer: str, missing: Sequence[str]) -> None:
        self.renderer, self.missing = renderer, tuple(missing)
        super().__init__(
            f"{renderer!r} allows shaders too little: {'; '.join(missing)}. Update the graphics driver, choose another "
            "GPU, or use Mesa's software renderer (LIBGL_ALWAYS_SOFTWARE=1)."
        )


@dataclass(frozen=True)
class ShaderMessage:
    """One line of a driver's log, at the place in the source that it speaks of (file "" and line 0: unknown)."""

    file: str
    line: int
    text: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.text}" if self.file else self.text


class ShaderError(GpuError):
    """A shader could not be read, expanded, compiled or linked.

    messages: all parts of the log, mapped to files and lines. file, line, message: the first of them that has a place.
    program: the names of the program's files. log: the driver's own words.
    """

    def __init__(self, program: str, what: str, messages: Sequence[ShaderMessage] = (), log: str = "") -> None:
        self.program, self.what, self.log = program, what, log
        self.messages = tuple(messages)
        first = next((m for m in self.messages if m.file), self.messages[0] if self.messages else None)
        self.file = first.file if first else ""
        self.line = first.line if first else 0
        self.message = first.text if first else what
        super().__init__("\n  ".join([f"shader {program}: {what}", *map(str, self.messages)]))
