"""Prepared render state: blend, depth, culling and polygon mode as one cheap apply().

State goes to GL directly, not through moderngl's context, whose own idea of the host's flags must stay true.
"""

from __future__ import annotations

from collections.abc import Callable

import moderngl

from . import gl as G

__all__ = ["State", "reset_baseline"]

_FUNCTIONS = {name: 0x200 + k for k, name in enumerate(("never", "<", "==", "<=", ">", "!=", ">=", "always"))}
_ZERO, _ONE, _SRC_ALPHA, _ONE_MINUS_SRC_ALPHA, _DST_COLOR, _FUNC_ADD = 0, 1, 0x0302, 0x0303, 0x0306, 0x8006
_BLENDS = {
    "alpha": (_SRC_ALPHA, _ONE_MINUS_SRC_ALPHA, _ONE, _ONE_MINUS_SRC_ALPHA),
    "premultiplied": (_ONE, _ONE_MINUS_SRC_ALPHA, _ONE, _ONE_MINUS_SRC_ALPHA),
    "additive": (_ONE, _ONE, _ONE, _ONE),
    "multiply": (_DST_COLOR, _ZERO, _DST_COLOR, _ZERO),
}
_CULLS = {"back": G.BACK, "front": G.FRONT}


class State:
    """Render state of a pass, made by Gpu.state(); applied after the framebuffer was bound, which resets the masks."""

    def __init__(
        self,
        gl: G.GL,
        depth_test: bool = False,
        depth_func: str = ">=",
        cull: str | None = None,
        blend: str | None = None,
        write_depth: bool = True,
        wireframe: bool = False,
        write_color: bool = True,
    ) -> None:
        choices = (("depth_func", depth_func, _FUNCTIONS), ("cull", cull, _CULLS), ("blend", blend, _BLENDS))
        for what, value, known in choices:
            if value not in known and (value is not None or what == "depth_func"):
                none = "" if what == "depth_func" else ", None"
                raise ValueError(f"unknown {what} {value!r}: expected one of {', '.join(known)}{none}")
        enable = gl.function("glEnable", None, G.enum)
        disable = gl.function("glDisable", None, G.enum)
        mask = gl.function("glColorMask", None, *[G.boolean] * 4)
        calls: list[tuple[Callable[..., object], tuple[int, ...]]] = [
            (enable if depth_test else disable, (G.DEPTH_TEST,)),
            (gl.function("glDepthMask", None, G.boolean), (int(write_depth),)),
            (mask, (int(write_color),) * 4),
            (enable if blend else disable, (G.BLEND,)),
            (enable if cull else disable, (G.CULL_FACE,)),
            (gl.function("glPolygonMode", None, G.enum, G.enum), (G.FRONT_AND_BACK, G.LINE if wireframe else G.FILL)),
        ]
        if depth_test:
            calls.append((gl.function("glDepthFunc", None, G.enum), (_FUNCTIONS[depth_func],)))
        if blend:
            calls.append((gl.function("glBlendFuncSeparate", None, *[G.enum] * 4), _BLENDS[blend]))
            calls.append((gl.function("glBlendEquation", None, G.enum), (_FUNC_ADD,)))
        if cull:
            calls.append((gl.function("glCullFace", None, G.enum), (_CULLS[cull],)))
        self._calls = tuple(calls)

    def apply(self) -> None:
        for function, arguments in self._calls:
            function(*arguments)


_OFF = (
    G.SCISSOR_TEST, G.STENCIL_TEST, G.FRAMEBUFFER_SRGB, G.DEPTH_CLAMP, G.RASTERIZER_DISCARD, G.POLYGON_OFFSET_FILL,
    G.SAMPLE_ALPHA_TO_COVERAGE, G.SAMPLE_MASK, G.COLOR_LOGIC_OP, G.PROGRAM_POINT_SIZE,
)  # fmt: skip


def reset_baseline(ctx: moderngl.Context, gl: G.GL, units: int = 18) -> Callable[[], None]:
    """A prepared call that puts what passes rely on but never set into a known state, whatever a host left behind."""
    disable = gl.function("glDisable", None, G.enum)
    front_face = gl.function("glFrontFace", None, G.enum)
    depth_range = gl.function("glDepthRangef", None, *[G.c.c_float] * 2)
    enable = gl.function("glEnable", None, G.enum)
    restart = gl.function("glPrimitiveRestartIndex", None, G.uint)

    def reset() -> None:
        for capability in _OFF:
            disable(capability)
        ctx.clear_samplers(0, units)  # a host's sampler object would override our textures' own filters
        front_face(G.CCW)
        depth_range(0.0, 1.0)
        enable(G.PRIMITIVE_RESTART)
        restart(0xFFFFFFFF)

    return reset
