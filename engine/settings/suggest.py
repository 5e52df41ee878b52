"""Did you mean: the nearest known name for a mistyped one."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = ["did_you_mean"]


def did_you_mean(name: object, known: Iterable[str], what: str = "known") -> str:
    """A sentence that helps with an unknown name: "did you mean 'earth'?" and what there is.

    what: how to call the list, e.g. "planets". The list is left out when it is long and a near name was found.
    """
    names = sorted(known)
    text = str(name)
    near = difflib.get_close_matches(text.lower(), [n.lower() for n in names], n=1, cutoff=0.6)
    close = next((n for n in names if near and n.lower() == near[0]), None)
    listing = f"{what}: {', '.join(names) or 'none'}"
    if close is None:
        return listing
    return f"did you mean {close!r}?" if len(names) > 24 else f"did you mean {close!r}? {listing}"
