"""From the frame graph's textures to the arrays that Renderer.render returns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..engine.graph import Plan
from ..errors import SettingError

OUTPUTS: dict[str, str] = {
    "color": "composite.ldr",
    "radiance": "scene.radiance",
    "distance": "outputs.position",
    "position": "outputs.position",
    "normal": "outputs.normal",
    "surface": "outputs.normal",
}
"""Output -> the graph resource it is made from. Any other texture of the graph can be asked for by its own name."""

_DTYPES = {"f1": np.uint8, "f2": np.float16, "f4": np.float32, "u1": np.uint8, "u2": np.uint16, "u4": np.uint32,
           "ni1": np.int8, "ni2": np.int16, "nu2": np.uint16}  # fmt: skip


def exports_for(outputs: Sequence[str]) -> frozenset[str]:
    """The graph resources that must be exported for these outputs. SettingError when there are none."""
    if isinstance(outputs, str):
        raise SettingError(f"outputs must be a sequence of names: write ({outputs!r},) instead of {outputs!r}")
    if not outputs:
        raise SettingError(f"outputs must be a sequence of names such as ('color', 'distance'), found {outputs!r}")
    known = {OUTPUTS.get(name, name) for name in outputs}
    unknown = [n for n in known if "." not in n]
    if unknown:
        raise SettingError(f"unknown output {unknown[0]!r}; expected one of {', '.join(OUTPUTS)}, or a graph resource")
    return frozenset(known)


def read_texture(texture: moderngl.Texture) -> NDArray[Any]:
    """A moderngl 2D texture as (H, W, C), row 0 on top."""
    width, height = texture.size
    dtype = _DTYPES[texture.dtype]
    data = np.frombuffer(texture.read(alignment=1), dtype).reshape(height, width, -1)
    return data[::-1]


def read_output(plan: Plan, name: str, size: tuple[int, int]) -> NDArray[Any]:
    """One output of the frame just executed, as a fresh array."""
    raw = read_texture(plan.resource(OUTPUTS.get(name, name)))
    if name == "color":
        return np.ascontiguousarray(raw[..., :3])
    if name == "radiance":
        return raw[..., :3].astype(np.float32)
    if name == "distance":
        return raw[..., 3].copy()
    if name in ("position", "normal"):
        return np.ascontiguousarray(raw[..., :3])
    if name == "surface":
        return raw[..., 3].astype(np.uint8)
    return np.ascontiguousarray(raw)
