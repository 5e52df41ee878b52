"""Arrays of whole numbers in few bytes: their bytes sorted by weight, the high ones of all numbers first, and deflated.

Numbers that lie near one another share their high bytes, which then take next to nothing.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import DTypeLike, NDArray

__all__ = ["pack", "unpack"]


def pack(arrays: Sequence[NDArray[np.integer]]) -> NDArray[np.uint8]:
    """Equally long arrays (N,) as one of bytes."""
    planes = [np.ascontiguousarray(a.astype(a.dtype.newbyteorder("<"))).view(np.uint8) for a in arrays]
    sorted_ = [p.reshape(-1, a.dtype.itemsize).T[::-1].tobytes() for p, a in zip(planes, arrays, strict=True)]
    return np.frombuffer(zlib.compress(b"".join(sorted_), 9), dtype=np.uint8)


def unpack(packed: NDArray[np.uint8], kinds: Mapping[str, DTypeLike]) -> dict[str, NDArray[np.integer]]:
    """What `pack` was given, by name. ValueError for what it has not made."""
    try:
        whole = zlib.decompress(packed.tobytes())
    except zlib.error as error:
        raise ValueError(f"packed arrays cannot be read: {error}") from None
    sizes = {name: np.dtype(kind).itemsize for name, kind in kinds.items()}
    count, rest = divmod(len(whole), sum(sizes.values()))
    if rest:
        raise ValueError(f"packed arrays: {len(whole)} bytes are not {sum(sizes.values())} for each number")
    found, start = {}, 0
    for name, kind in kinds.items():
        size = sizes[name]
        planes = np.frombuffer(whole, dtype=np.uint8, count=count * size, offset=start).reshape(size, count)
        little = np.ascontiguousarray(planes[::-1].T).view(np.dtype(kind).newbyteorder("<"))
        found[name] = little[:, 0].astype(kind)
        start += count * size
    return found
