"""Loops compiled to machine code where numba is installed (the extra `fast`); numpy does the same work without it.

Modules of such loops are imported through `Kernels` alone, which gives None where there is no compiler. Compiled code
is kept in the user's cache folder, in a folder named after all sources that it was made of.
"""

from __future__ import annotations

import hashlib
import logging
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

import platformdirs

__all__ = ["Kernels", "Library", "inlined", "switched", "wanted"]

log = logging.getLogger(__name__)

F = TypeVar("F", bound=Callable[..., Any])

OFF = "PLANETFALL_COMPILED"
"""Environment variable: 0 leaves all work to numpy."""

_KEPT = 4
"""Folders of compiled code: of so many versions of the sources."""

_state: dict[str, bool] = {}


def wanted() -> bool:
    """Whether the environment leaves loops to the compiler."""
    return os.environ.get(OFF, "").strip() != "0"


def _on() -> bool:
    if "on" not in _state:
        _state["on"] = wanted()
    return _state["on"]


@contextmanager
def switched(on: bool) -> Iterator[None]:
    """Compiled loops on or off meanwhile, for comparisons."""
    before = _on()
    _state["on"] = on
    try:
        yield
    finally:
        _state["on"] = before


class Kernels:
    """A module of compiled loops, `name` in `package`, imported when it is first asked for."""

    def __init__(self, package: str | None, name: str) -> None:
        self._module = f"{package}.{name}"
        self._found: Any = None
        self._tried = False

    def __call__(self) -> Any:
        """The module, or None: nothing is to be compiled, or nothing can be."""
        if not _on():
            return None
        if not self._tried:
            self._tried = True
            try:
                import_module("numba")
                _without_blas()
            except ImportError as error:
                log.debug("numpy does what numba would do faster: %s", error)
            else:
                self._found = import_module(self._module)
        return self._found


def _without_blas() -> None:
    """Import numba's functions of arrays, but not SciPy's linear algebra, which they look for at once.

    That takes longer than all of our loops, and is needed for matrix products alone; code that has some looks for it
    again when it is compiled. Another release of numba may be built otherwise: then all goes its usual way.
    """
    if "numba.np.arraymath" in sys.modules or "scipy.linalg" in sys.modules or find_spec("scipy") is None:
        return
    linalg: Any = import_module("numba.np.linalg")
    look = getattr(linalg, "ensure_blas", None)
    if look is None:
        return
    linalg.ensure_blas = lambda: None
    try:
        arraymath: Any = import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = look
    arraymath.ensure_blas = look


def inlined(function: F) -> F:
    """A function of numbers that becomes a part of each loop that calls it."""
    numba: Any = import_module("numba")
    return numba.njit(forceinline=True, error_model="numpy")(function)


class Library:
    """Loops that are made of the same sources, and so become invalid together.

    No fast mathematics: sums keep their order, and products and sums are rounded one by one, as numpy's are.
    """

    def __init__(self, part: str, sources: Iterable[str]) -> None:
        """part: a folder in the cache, "terrain". sources: texts of all that the loops are made of."""
        self._folder = _writable(part, hashlib.sha256("\0".join(sources).encode()).hexdigest()[:16])

    @staticmethod
    def part(function: F) -> F:
        """A loop that kernels call."""
        numba: Any = import_module("numba")
        return numba.njit(nogil=True, error_model="numpy")(function)

    def kernel(self, function: F) -> F:
        """The function, compiled when it is first called, or taken from the cache."""
        if self._folder is None:
            return self.part(function)
        numba: Any = import_module("numba")
        before = numba.config.CACHE_DIR  # read by the decorator, once
        numba.config.CACHE_DIR = str(self._folder)
        try:
            return numba.njit(nogil=True, error_model="numpy", cache=True)(function)
        finally:
            numba.config.CACHE_DIR = before


def _writable(part: str, key: str) -> Path | None:
    """The folder of that name in the cache, made and tried, or None."""
    chosen = os.environ.get("PLANETFALL_CACHE")
    root = str(platformdirs.user_cache_path("planetfall")) if chosen is None else chosen
    if not root.strip():
        return None
    folder = Path(root) / "compiled" / part / key
    if not folder.exists():
        log.info("loops of %s are compiled once, which takes some seconds; then they are kept in %s", part, folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        os.utime(folder)
        others = sorted(folder.parent.iterdir(), key=lambda path: path.stat().st_mtime, reverse=True)
        for late in others[_KEPT:]:
            shutil.rmtree(late, ignore_errors=True)
    except OSError as error:
        log.warning("compiled loops cannot be kept in %s, so each start compiles them again: %s", folder, error)
        return None
    return folder
