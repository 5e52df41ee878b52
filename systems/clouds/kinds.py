"""Kinds of cloud by name: how each differs from the clouds that the weather makes by itself."""

from __future__ import annotations

from dataclasses import dataclass

from ...components import CloudLayer

__all__ = ["KindShape", "finer_of", "shape_of"]


@dataclass(frozen=True)
class KindShape:
    """What density.glsl reads of a kind, as CloudViewLayer has it. The defaults are the weather's own mixture.

    period: of the shape's noise, in thicknesses of the layer; 0: that of the planet's first layer. relief: factor on
    the layer's own.
    """

    follows: float = 1.0
    towers: float = 0.0
    deep: float = 0.0
    least_tall: float = 0.30
    shallow: float = 0.12
    base: float = 0.10
    steep: float = 1.0 / 0.85
    anvil: float = 0.0
    rough: float = 1.0
    relief: float = 1.0
    period: float = 0.0


def _said(towers: float, deep: float, **more: float) -> KindShape:
    """A kind whose layer is as thick as its clouds are tall, and whose extinction is theirs."""
    return KindShape(0.0, towers, deep, 1.0, 1.0, **more)


_WEATHER = KindShape()
_SHAPES = {
    "humilis": _said(0.6, 0.1, base=0.05, period=8.0),
    "congestus": _said(0.9, 0.5, base=0.04, steep=1.05, period=2.5),
    "cumulonimbus": _said(1.0, 1.0, base=0.03, steep=1.6, anvil=1.5, relief=1.2, period=1.6),
    "stratocumulus": _said(0.1, 0.1, steep=3.0, relief=0.6, period=14.0),
    "stratus": _said(0.0, 0.0, base=0.2, steep=5.0, rough=0.25, relief=0.2),
    "altocumulus": _said(0.15, 0.0, base=0.3, steep=1.5, relief=0.5, period=8.0),
}


def shape_of(layer: CloudLayer) -> KindShape:
    """Of a layer's kind."""
    return _SHAPES.get(layer.kind, _WEATHER)


def finer_of(layer: CloudLayer, period_m: float) -> int:
    """How many times finer a layer's noise is than that of the planet, which repeats after period_m. A whole number:
    then it repeats where that does."""
    wanted_m = shape_of(layer).period * (layer.top_m - layer.base_m)
    return max(1, round(period_m / wanted_m)) if wanted_m > 0.0 else 1
