"""Work that makes hundreds of thousands of objects which stay, without looks for garbage among them."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

__all__ = ["uncollected"]


@contextmanager
def uncollected(inner: AbstractContextManager[object] | None = None) -> Iterator[None]:
    """`inner`, with Python's collector of cycles at rest meanwhile; afterwards it is as it was.

    It goes through all objects again whenever there are a quarter more of them: a tenth of a second of a first picture.
    """
    on = gc.isenabled()
    gc.disable()
    try:
        with inner or nullcontext():
            yield
    finally:
        if on:
            gc.enable()
