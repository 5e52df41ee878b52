"""Maps that a program draws in a tenth of a second or more, kept on disk with the bits that this driver gave them."""

from __future__ import annotations

import hashlib
from typing import cast

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..table_cache import TableCache
from . import gl as G
from .scope import GpuScope
from .textures import AnyTexture, TextureInfo

__all__ = ["KeptMaps"]

_PACK_ALIGNMENT, _UNPACK_ALIGNMENT = 0x0D05, 0x0CF5


class KeptMaps:
    """Textures of two or three dimensions with all their levels, by all that they were drawn from.

    Another driver draws other bits, and filters others into the coarser levels, so its name and version are part of
    each key: pictures are the same whether a map was just drawn or read. cache: where; None: the user's cache folder.
    """

    def __init__(self, gpu: GpuScope, cache: TableCache | None = None) -> None:
        self._gpu = gpu
        self.cache = TableCache("maps") if cache is None else cache

    def key(self, *parts: object) -> str:
        """parts: the program's own key, and the values of its uniforms and blocks; of bytes their hash is taken."""
        caps = self._gpu.caps
        said = (hashlib.sha256(part).hexdigest() if isinstance(part, bytes) else repr(part) for part in parts)
        return self.cache.key(caps.vendor, caps.renderer, caps.version, *said)

    def load(self, key: str, texture: AnyTexture) -> bool:
        """Fill all levels, if there is a map of this key."""
        shapes = {f"level{k}": (_bytes(texture, k),) for k in range(_info(texture).levels)}
        held = self.cache.load(key, shapes, np.uint8)
        if held is None:
            return False
        for level in range(len(shapes)):
            self._write(texture, level, held[f"level{level}"])
        return True

    def save(self, key: str, texture: AnyTexture) -> None:
        """Keep all levels as they are now; what wrote them has to be over (barrier)."""
        self.cache.save(key, {f"level{k}": self._read(texture, k) for k in range(_info(texture).levels)})

    def _read(self, texture: AnyTexture, level: int) -> NDArray[np.uint8]:
        if isinstance(texture, moderngl.Texture):
            return np.frombuffer(texture.read(level=level, alignment=1), np.uint8)
        # moderngl reads and writes the first level alone of these.
        gl, kind, found = self._gpu.gl, _info(texture).format, np.empty(_bytes(texture, level), np.uint8)
        texture.use(self._gpu.ctx.default_texture_unit)
        gl.function("glPixelStorei", None, G.enum, G.int_)(_PACK_ALIGNMENT, 1)
        read = gl.function("glGetTexImage", None, G.enum, G.int_, G.enum, G.enum, G.c.c_void_p)
        read(G.TEXTURE_3D, level, kind.format, kind.type, found.ctypes.data)
        return found

    def _write(self, texture: AnyTexture, level: int, texels: NDArray[np.uint8]) -> None:
        if isinstance(texture, moderngl.Texture):
            texture.write(texels, level=level, alignment=1)
            return
        gl, kind, size = self._gpu.gl, _info(texture).format, _info(texture).level_size(level)
        texture.use(self._gpu.ctx.default_texture_unit)
        gl.function("glPixelStorei", None, G.enum, G.int_)(_UNPACK_ALIGNMENT, 1)
        write = gl.function(
            "glTexSubImage3D", None, G.enum, *[G.int_] * 4, *[G.sizei] * 3, G.enum, G.enum, G.c.c_void_p
        )
        write(G.TEXTURE_3D, level, 0, 0, 0, *size, kind.format, kind.type, texels.ctypes.data)


def _info(texture: AnyTexture) -> TextureInfo:
    return cast(TextureInfo, texture.extra)


def _bytes(texture: AnyTexture, level: int) -> int:
    return int(np.prod(_info(texture).level_size(level))) * _info(texture).format.texel_bytes
