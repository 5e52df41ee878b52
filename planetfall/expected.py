"""Which errors tell a user what to do. Programs show those as one line; anything else is a bug, with its traceback."""

from __future__ import annotations

import contextlib

from . import errors

__all__ = ["expected_errors"]


def expected_errors() -> tuple[type[Exception], ...]:
    """For `except pf.expected_errors() as error:` around a program."""
    from .engine.hosts.window import NoDisplayError, WindowError
    from .engine.space import SpaceError
    from .systems.capture import CaptureError

    found: list[type[Exception]] = [CaptureError, NoDisplayError, SpaceError, WindowError]
    for name in errors.__all__:
        # Some come with the GPU packages, which may be what is broken: that must not hide the error at hand.
        with contextlib.suppress(ImportError, AttributeError):
            found.append(getattr(errors, name))
    return tuple(found)
