"""Maps that a program draws in a tenth of a second or more, kept on disk with the bits that this driver gave them."""

from __future__ import annotations

import hashlib
from typing import cast

import moderngl
import numpy as np

from ..table_cache import TableCache
from .caps import Capabilities
from .textures import TextureInfo

__all__ = ["KeptMaps"]


class KeptMaps:
    """The first level of two-dimensional textures, by all that it was drawn from.

    Another driver draws other bits, so its name and version are part of each key: pictures are the same whether a map
    was just drawn or read. cache: where; None: the user's cache folder.
    """

    def __init__(self, caps: Capabilities, cache: TableCache | None = None) -> None:
        self._driver = caps.vendor, caps.renderer, caps.version
        self.cache = TableCache("maps") if cache is None else cache

    def key(self, *parts: object) -> str:
        """parts: the program's own key, and the values of its uniforms and blocks; of bytes their hash is taken."""
        said = (hashlib.sha256(part).hexdigest() if isinstance(part, bytes) else repr(part) for part in parts)
        return self.cache.key(*self._driver, *said)

    def load(self, key: str, texture: moderngl.Texture) -> bool:
        """Fill the first level, if there is a map of this key."""
        held = self.cache.load(key, {"texels": (_bytes(texture),)}, np.uint8)
        if held is not None:
            texture.write(held["texels"], alignment=1)
        return held is not None

    def save(self, key: str, texture: moderngl.Texture) -> None:
        """Keep the first level as it is now; what wrote it has to be over (barrier)."""
        self.cache.save(key, {"texels": np.frombuffer(texture.read(alignment=1), np.uint8)})


def _bytes(texture: moderngl.Texture) -> int:
    info = cast(TextureInfo, texture.extra)
    return info.size[0] * info.size[1] * info.format.texel_bytes
