"""From the frame graph's textures to the arrays that Renderer.render returns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..engine.graph import Plan
from ..engine.settings.suggest import did_you_mean
from ..engine.space import CameraState
from ..errors import SettingError
from .labels import depth_m, flow_px, slope_deg

OUTPUTS: dict[str, tuple[str, ...]] = {
    "color": ("composite.ldr",),
    "radiance": ("scene.radiance",),
    "distance": ("outputs.position",),
    "position": ("outputs.position",),
    "normal": ("outputs.normal",),
    "surface": ("outputs.normal",),
    "depth": ("outputs.position",),
    "slope_deg": ("outputs.position", "outputs.normal"),
    "flow": ("outputs.moved",),
    "sunlit": ("outputs.sunlit",),
    "albedo": ("outputs.albedo",),
    "material": ("outputs.albedo",),
    "instance": ("outputs.instance",),
}
"""Output -> the graph resources it is made from. Any other texture of the graph can be asked for by its own name."""

_DTYPES = {"f1": np.uint8, "f2": np.float16, "f4": np.float32, "u1": np.uint8, "u2": np.uint16, "u4": np.uint32,
           "ni1": np.int8, "ni2": np.int16, "nu2": np.uint16}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Shot:
    """What a picture was taken with. camera: in the axes of the planet that was drawn, metres from its centre. before:
    that of the frame before, in the same axes; None: there was none, or it was over another planet. size: (width,
    height) in pixels."""

    camera: CameraState
    before: CameraState | None
    size: tuple[int, int]


def exports_for(outputs: Sequence[str]) -> frozenset[str]:
    """The graph resources that must be exported for these outputs. SettingError when there are none."""
    if isinstance(outputs, str):
        raise SettingError(f"outputs must be a sequence of names: write ({outputs!r},) instead of {outputs!r}")
    if not outputs:
        raise SettingError(f"outputs must be a sequence of names such as ('color', 'distance'), found {outputs!r}")
    strange = [name for name in outputs if not isinstance(name, str)]
    if strange:
        raise SettingError(f"outputs must be names such as 'color', found {strange[0]!r}")
    unknown = [name for name in outputs if name not in OUTPUTS and "." not in name]
    if unknown:
        near = did_you_mean(unknown[0], OUTPUTS, "outputs")
        raise SettingError(f"unknown output {unknown[0]!r}; {near}, or a graph resource")
    return frozenset(resource for name in outputs for resource in OUTPUTS.get(name, (name,)))


def read_texture(texture: moderngl.Texture) -> NDArray[Any]:
    """A moderngl 2D texture as (H, W, C), row 0 on top."""
    width, height = texture.size
    dtype = _DTYPES[texture.dtype]
    data = np.frombuffer(texture.read(alignment=1), dtype).reshape(height, width, -1)
    return data[::-1]


def read_outputs(plan: Plan, names: Sequence[str], shot: Shot) -> dict[str, NDArray[Any]]:
    """Outputs of the frame just executed, as fresh arrays."""
    textures = {resource for name in names for resource in OUTPUTS.get(name, (name,))}
    raw = {name: read_texture(plan.resource(name)) for name in textures}
    return {name: _made(name, [raw[resource] for resource in OUTPUTS.get(name, (name,))], shot) for name in names}


def _made(name: str, raw: Sequence[NDArray[Any]], shot: Shot) -> NDArray[Any]:
    first = raw[0]
    if name in ("color", "position", "normal"):
        return np.ascontiguousarray(first[..., :3])
    if name in ("radiance", "albedo"):
        return first[..., :3].astype(np.float32)
    if name == "distance":
        return first[..., 3].copy()
    if name in ("surface", "material"):
        return first[..., 3].astype(np.uint8)
    if name == "sunlit":
        return first[..., 0].astype(np.float32)
    if name == "instance":
        return first[..., 0].copy()
    if name == "depth":
        return depth_m(first, shot.camera)
    if name == "slope_deg":
        return slope_deg(first, raw[1], shot.camera)
    if name == "flow":
        return flow_px(first, shot.camera, shot.before, shot.size)
    return np.ascontiguousarray(first)
