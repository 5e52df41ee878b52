"""The graph's one exception, and the "did you mean" that its messages share."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class GraphError(Exception):
    """A frame graph that cannot be built or used. The message names the pass, the resource and the remedy."""


def did_you_mean(name: str, known: Iterable[str], listing: bool = True) -> str:
    """` Did you mean 'x' or 'y'?` for near misses, else ` Known: ...` (nothing without listing); starts with a space,
    ready to append."""
    names = sorted(set(known))
    close = difflib.get_close_matches(name, names, n=3, cutoff=0.6)
    if close:
        return " Did you mean " + " or ".join(repr(c) for c in close) + "?"
    if not listing:
        return ""
    if not names:
        return " There are none yet."
    shown = ", ".join(repr(n) for n in names[:12])
    return f" Known: {shown}{', ...' if len(names) > 12 else ''}."
