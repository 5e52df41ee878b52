"""Textures by format name, with float depth, mip levels and errors before the driver has a chance to misbehave."""

from __future__ import annotations

import difflib
from dataclasses import dataclass
from typing import Any, TypeAlias

import moderngl
import numpy as np
from numpy.typing import NDArray

from . import gl as G
from .caps import Capabilities
from .errors import FormatError, GpuError

__all__ = ["FORMATS", "Format", "TextureInfo", "check_texture", "create_texture", "format_of", "texture_bytes"]

AnyTexture: TypeAlias = moderngl.Texture | moderngl.TextureArray | moderngl.Texture3D
Data: TypeAlias = bytes | bytearray | memoryview | NDArray[np.generic]
"""What goes into a buffer or a texture."""


@dataclass(frozen=True)
class Format:
    """One texture format: moderngl's (components, dtype) and the three GL names."""

    name: str
    components: int
    dtype: str
    internal: int
    format: int
    type: int
    texel_bytes: int

    @property
    def is_depth(self) -> bool:
        return self.format == G.DEPTH_COMPONENT

    @property
    def is_integer(self) -> bool:
        return self.dtype.startswith("u")


_RED, _RG, _RGBA, _RED_I, _RG_I, _RGBA_I = 0x1903, 0x8227, 0x1908, 0x8D94, 0x8228, 0x8D99
_U8, _U16, _U32, _I16, _F16, _F32 = 0x1401, 0x1403, 0x1405, 0x1402, 0x140B, 0x1406

FORMATS: dict[str, Format] = {
    f.name: f
    for f in (
        Format("r8", 1, "f1", 0x8229, _RED, _U8, 1),
        Format("rg8", 2, "f1", 0x822B, _RG, _U8, 2),
        Format("rgba8", 4, "f1", 0x8058, _RGBA, _U8, 4),
        Format("r16f", 1, "f2", 0x822D, _RED, _F16, 2),
        Format("rg16f", 2, "f2", 0x822F, _RG, _F16, 4),
        Format("rgba16f", 4, "f2", 0x881A, _RGBA, _F16, 8),
        Format("r32f", 1, "f4", 0x822E, _RED, _F32, 4),
        Format("rg32f", 2, "f4", 0x8230, _RG, _F32, 8),
        Format("rgba32f", 4, "f4", 0x8814, _RGBA, _F32, 16),
        Format("r8ui", 1, "u1", 0x8232, _RED_I, _U8, 1),
        Format("r16ui", 1, "u2", 0x8234, _RED_I, _U16, 2),
        Format("r32ui", 1, "u4", 0x8236, _RED_I, _U32, 4),
        Format("rg32ui", 2, "u4", 0x823C, _RG_I, _U32, 8),
        Format("rgba32ui", 4, "u4", 0x8D70, _RGBA_I, _U32, 16),
        Format("rg16_snorm", 2, "ni2", 0x8F99, _RG, _I16, 4),
        Format("rgba16_snorm", 4, "ni2", 0x8F9B, _RGBA, _I16, 8),
        Format("depth32f", 1, "f4", G.DEPTH_COMPONENT32F, G.DEPTH_COMPONENT, G.FLOAT, 4),
    )
}

_FILTERS = {
    "nearest": (moderngl.NEAREST, moderngl.NEAREST_MIPMAP_NEAREST),
    "linear": (moderngl.LINEAR, moderngl.LINEAR_MIPMAP_NEAREST),
    "trilinear": (moderngl.LINEAR, moderngl.LINEAR_MIPMAP_LINEAR),
}
_WRAPS = ("clamp", "repeat")


@dataclass(frozen=True)
class TextureInfo:
    """What a texture was made as; kept in ``texture.extra``. size: (w, h) or (w, h, d); layers > 1: an array."""

    format: Format
    size: tuple[int, ...]
    levels: int
    layers: int

    @property
    def target(self) -> int:
        if len(self.size) == 3:
            return G.TEXTURE_3D
        return G.TEXTURE_2D_ARRAY if self.layers > 1 else G.TEXTURE_2D

    def level_size(self, level: int) -> tuple[int, ...]:
        """Size of a mip level; for an array (w, h, layers)."""
        size = tuple(max(1, n >> level) for n in self.size)
        return (*size, self.layers) if self.layers > 1 else size

    @property
    def bytes(self) -> int:
        return sum(int(np.prod(self.level_size(k))) for k in range(self.levels)) * self.format.texel_bytes


def format_of(name: str) -> Format:
    """The format of that name; FormatError with the nearest names otherwise."""
    found = FORMATS.get(name)
    if found is None:
        near = difflib.get_close_matches(str(name), FORMATS, 3)
        hint = f"did you mean {' or '.join(near)}? " if near else ""
        raise FormatError(f"unknown texture format {name!r}: {hint}known formats are {', '.join(FORMATS)}")
    return found


def check_texture(
    caps: Capabilities, size: tuple[int, ...], format: str, levels: int = 1, layers: int = 1
) -> TextureInfo:
    """Validate without making anything: FormatError says which limit is crossed and by what."""
    kind = format_of(format)
    if len(size) not in (2, 3) or any(int(n) != n for n in size):
        raise FormatError(
            f"texture size must be (width, height) or (width, height, depth) in whole texels, found {size}"
        )
    size = tuple(int(n) for n in size)
    if min(size) < 1 or layers < 1:
        raise FormatError(f"texture size {size} with {layers} layers: every side must be at least 1 texel")
    limit = caps.max_texture_3d_size if len(size) == 3 else caps.max_texture_size
    if max(size) > limit:
        raise FormatError(
            f"texture size {size} is beyond this GPU's limit of {limit} texels a side ({caps.renderer}); ask for less"
        )
    if layers > caps.max_texture_layers:
        raise FormatError(f"{layers} texture layers are beyond this GPU's limit of {caps.max_texture_layers}")
    if len(size) == 3 and layers > 1:
        raise FormatError("a texture is 3D or an array, not both: give a size of two for an array")
    if kind.is_depth and (len(size) == 3 or layers > 1 or levels > 1):
        raise FormatError(f"{format} textures are two-dimensional with one level; found {size}, {layers=}, {levels=}")
    most = max(size).bit_length()
    if not 1 <= levels <= most:
        raise FormatError(f"a texture of {size} has 1 to {most} levels, found levels={levels}")
    return TextureInfo(kind, size, levels, layers)


def _as_bytes(data: Data | None, info: TextureInfo) -> bytes | NDArray[np.uint8] | None:
    """Checked; arrays are not copied, unless they have to be."""
    if data is None:
        return None
    raw = np.ascontiguousarray(data).reshape(-1).view(np.uint8) if isinstance(data, np.ndarray) else bytes(data)
    expected = int(np.prod(info.level_size(0))) * info.format.texel_bytes
    if len(raw) != expected:
        found = f"{data.dtype} {data.shape}" if isinstance(data, np.ndarray) else "bytes"
        raise FormatError(
            f"{info.format.name} texture of {info.level_size(0)} needs {expected} bytes of data, "
            f"found {len(raw)} ({found})"
        )
    return raw


def create_texture(
    ctx: moderngl.Context,
    gl: G.GL,
    caps: Capabilities,
    size: tuple[int, ...],
    format: str,
    data: Data | None = None,
    levels: int = 1,
    layers: int = 1,
    filter: str = "nearest",
    wrap: str = "clamp",
) -> AnyTexture:
    """Make a 2D texture, an array (layers > 1) or a 3D one (size of three). See GpuScope.texture. Coarser levels are
    filled from data, if there is any."""
    info = check_texture(caps, size, format, levels, layers)
    kind = info.format
    shape_0: Any = info.level_size(0)
    if filter not in _FILTERS or wrap not in _WRAPS:
        known = f"filter is one of {', '.join(_FILTERS)} and wrap one of {', '.join(_WRAPS)}"
        raise FormatError(f"{known}; found {filter=}, {wrap=}")
    if kind.is_integer and filter != "nearest":
        raise FormatError(f"{format} holds integers: they cannot be filtered, use filter='nearest'")
    raw = _as_bytes(data, info)
    if kind.is_depth:
        if raw is not None:
            raise FormatError("depth32f textures take no data")
        texture: AnyTexture = ctx.depth_texture(shape_0)
    elif len(info.size) == 3:
        texture = ctx.texture3d(shape_0, kind.components, raw, dtype=kind.dtype)
    elif layers > 1:
        texture = ctx.texture_array(shape_0, kind.components, raw, dtype=kind.dtype)
    else:
        texture = ctx.texture(shape_0, kind.components, raw, dtype=kind.dtype)
    texture.extra = info
    texture.use(ctx.default_texture_unit)  # raw calls below speak to the bound texture
    # moderngl's depth textures are 24 bits fixed and its "ni2" is unsigned: specify the same GL name again, before
    # anything is attached. The other levels do not exist at all yet.
    respecified = kind.is_depth or kind.dtype.startswith("ni")

    def specify(level: int, shape: tuple[int, ...]) -> None:
        if info.target == G.TEXTURE_2D:
            gl.image_2d(info.target, level, kind.internal, (shape[0], shape[1]), kind.format, kind.type)
        else:
            gl.image_3d(info.target, level, kind.internal, shape, kind.format, kind.type)

    if levels > 1 and raw is None:
        # moderngl has to be told of the levels (below), which fills them: here from a single texel, which is no work.
        specify(0, (1,) * len(shape_0))
        texture.build_mipmaps(0, levels - 1)
        _ = ctx.error
        respecified = True
    for level in range(0 if respecified else 1, levels):
        specify(level, info.level_size(level))
    if isinstance(texture, moderngl.Texture) and kind.is_depth:
        texture.compare_func = ""  # sampled as plain values
    gl.texture_parameter(info.target, G.TEXTURE_MAX_LEVEL, levels - 1)
    error = ctx.error
    if error != "GL_NO_ERROR":
        texture.release()
        raise GpuError(f"{format} texture of {size}, {levels=}, {layers=} ({info.bytes / 2**20:.1f} MiB): {error}")
    if levels > 1 and raw is not None:
        # Only this tells moderngl that the levels are there to be read and written; for integers GL itself refuses.
        texture.build_mipmaps(0, levels - 1)
        _ = ctx.error
    if respecified and raw is not None:
        texture.write(raw, alignment=1)
    magnify, minify = _FILTERS[filter]
    texture.filter = (minify if levels > 1 else magnify, magnify)
    texture.repeat_x = texture.repeat_y = wrap == "repeat"
    if isinstance(texture, moderngl.Texture3D):
        texture.repeat_z = wrap == "repeat"
    return texture


def texture_bytes(texture: AnyTexture) -> int:
    """GPU memory of a texture in bytes, all levels and layers; for foreign textures a guess from size and dtype."""
    if isinstance(texture.extra, TextureInfo):
        return texture.extra.bytes
    return int(np.prod(texture.size)) * texture.components * int(texture.dtype[-1])
