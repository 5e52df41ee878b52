"""Writes docs/materials.md from the list of materials: `python docs/make_materials.py`. A test wants it current."""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TARGET = ROOT / "docs" / "materials.md"
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from planetfall.systems.terrain.materials import INPUTS, MATERIALS, Material  # noqa: E402

HEAD = """# Materials of the ground

What the ground is made of is a list, `systems/terrain/materials.py`; `python docs/make_materials.py` writes this page
from it. The shader that shades the ground, the uniform block with its colours and this table are made from the list: a
new material is one entry there. A game adds its own without touching the library
([a material of your own](tutorials/a-material-of-your-own.md)).

A material has a colour and a rule: which share of the ground it covers, 0 to 1. Rules hang on height, slope, climate
and noise, never on the camera but for what a pixel covers, so that a place keeps its colour from 2 m to 36 000 km.
Materials lie within mixtures, later ones over earlier ones; `ground` is all of it. All ground is matt: Lambert's law,
or that of airless dust (`Terrain.dust_law`), so what a material's roughness says is how high its bumps are. Albedos are
fields of [`Terrain`](api.md), in TOML as `grass_albedo = [0.069, 0.103, 0.03]`: colours, as they show in sunlight
([exposure.md](exposure.md#albedos-are-colours)).

| material | lies in | albedo | where | its rule hangs on | roughness | on it |
|---|---|---|---|---|---|---|
"""
MIDDLE = """
Colours vary with the very noise that makes the relief, which is noise of the map: the same all the way up a cliff. On
slopes from 14 to 33 degrees on they go over to noise of space, three octaves from 3 footprints on. So they change as
much by the metre up the wall of view `canyon` as along it (tests/systems/test_cliffs.py: mean squares within 0.8 to
1.6 of one another). Layers of rock also bend its normals: hard ones are steeper (`Terrain.strata`).

Roughness: height of its bumps, where soil has 1; `Terrain.grain` scales all. Ripples show where ground is loose
(`assets/shaders/terrain/ripples.glsl`), the strongest of a place; plants and stones stand on ground as the last column
says (`assets/shaders/terrain/clutter.glsl`, `Terrain.clutter`).

## What a rule may know

`assets/shaders/terrain/ground_at.glsl` works these out for a pixel. A rule is a GLSL expression of them, or statements
that return one; it may also use `NAME_share` and `NAME_color` of another material, all albedos by their names,
`ramp(from, to, x)`, which goes straight from 0 to 1, and `bell(x, center, 1 / width)`.

| word | |
|---|---|
"""


def text() -> str:
    """The page."""
    return (
        HEAD
        + "".join(map(_row, MATERIALS))
        + MIDDLE
        + "".join(f"| `{name}` | {about} |\n" for name, about in INPUTS.items())
    )


def _row(m: Material) -> str:
    known = {*INPUTS, *(f"{other.name}_share" for other in MATERIALS)}
    words = [w for w in dict.fromkeys(re.findall(r"[a-z]\w*", m.rule)) if w in known]
    rule = ", ".join(f"`{w}`" for w in words) or ("covers all" if m.within else "")
    bumps = "" if m.roughness is None else f"{m.roughness:g}"
    bumps += f"hides {m.buries:.0%} of those below" if m.buries else ""
    cells = (f"`{m.name}`", f"`{m.within}`" if m.within else "", _albedo(m), m.about, rule, bumps, _detail(m))
    return "| " + " | ".join(cells) + " |\n"


def _albedo(m: Material) -> str:
    if not m.albedo:
        return "mixture" if any(part.within == m.name for part in MATERIALS) else f"`{m.color}`"
    if isinstance(m.albedo, str):
        return f"`{m.albedo}`" + (f", `{m.color}`" if re.fullmatch(r"albedo \* [\w.(), ]+", m.color) else "")
    if isinstance(m.albedo, Mapping):
        return " + ".join(f"{share:g} `{name}`" for name, share in m.albedo.items())
    return ", ".join(f"{value:g}" for value in m.albedo)


def _detail(m: Material) -> str:
    parts = [f"ripples of {m.ripples.wavelength_m:g} m"] if m.ripples is not None else []
    for things, share in (("plants", m.plants), ("stones", m.stones)):
        if share is not None:
            parts.append(f"{share:.0%} of the {things}" if share else f"no {things}")
    return ", ".join(parts)


def main() -> int:
    TARGET.write_text(text(), encoding="utf-8")
    sys.stdout.write(f"{TARGET}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
