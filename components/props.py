"""Transform and Shape: a game's own objects, drawn among the planet's."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

from dataclasses import dataclass

from ._knob import Vec3, knob

__all__ = ["Shape", "Transform", "Vec4"]

Vec4 = tuple[float, float, float, float]


@dataclass
class Transform:
    """Where an object is and how it is turned, in double precision."""

    position_m: Vec3 = knob((0.0, 0.0, 0.0), unit="m", help="Of its origin, from the planet's centre, planet axes")
    orientation: Vec4 = knob(
        (0.0, 0.0, 0.0, 1.0),
        -1.0e3,
        1.0e3,
        "",
        "Quaternion (x, y, z, w) that turns the object's axes into the planet's; any length but zero",
        nonzero=True,
    )
    planet: str = knob("", help="Name of the planet that it belongs to; empty: the scene's first")


@dataclass
class Shape:
    """What an object looks like. `form`: "sphere" (of diameter 1 m), "box" (1 m a side) or the path of a mesh file."""

    form: str = knob("sphere", help="sphere, box, or the path of a mesh file (OBJ, STL, PLY, GLB ...; metres)")
    size_m: Vec3 = knob(
        (1.0, 1.0, 1.0), 1e-4, 1e7, "", "Along its own axes: diameters, lengths of a box, factors of a mesh"
    )
    color: Vec3 = knob(
        (0.5, 0.5, 0.5), 0.0, 1.0, "", "Share of light that it throws back: linear sRGB, as in sunlight", widget="color"
    )
    roughness: float = knob(0.8, 0.05, 1.0, "", "1: dull, towards 0: like polished stone")
