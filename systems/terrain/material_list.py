"""The materials that there are: the library's, and those that a game has registered."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...components import Terrain
from ...engine.display import reflectance
from ...engine.frame.labels import FIRST_OF_GAMES, FIRST_OF_GROUND
from ...engine.settings import SettingError
from ...engine.settings.suggest import did_you_mean
from ...engine.wavelengths import Nanometres
from .material_glsl import albedo_name, albedo_names, constants_glsl, ids_glsl, materials_glsl, struct_glsl
from .materials import MATERIALS, Material, Ripples

__all__ = [
    "MOST_ALBEDOS", "albedos", "list_revision", "listed", "material_ids", "register_material", "shaders",
    "unregister_material",
]  # fmt: skip

MOST_OF_GAMES = 8
_OWN = albedo_names(MATERIALS)
MOST_ALBEDOS = len(_OWN) + MOST_OF_GAMES
"""Places for albedos in the uniform block."""

_listed = list(MATERIALS)
_slots = {name: slot for slot, name in enumerate(_OWN)}
_over: dict[str, str] = {}
"""What each material of a game's lies over."""
_revision = [0]


def list_revision() -> int:
    """A number that changes with the list."""
    return _revision[0]


def listed() -> tuple[Material, ...]:
    """All materials, those of games among them."""
    return tuple(_listed)


def material_ids() -> dict[str, int]:
    """Numbers of the ground's materials in the output `material`, by name; those of a game's while it is registered."""
    ids = {material.name: FIRST_OF_GROUND + place for place, material in enumerate(MATERIALS)}
    return ids | {name: FIRST_OF_GAMES + _slots[f"{name}_albedo"] - len(_OWN) for name in _over}


def shaders() -> dict[str, str]:
    """The generated shader files, by name."""
    return {
        "generated/terrain_ground.glsl": struct_glsl(),
        "generated/terrain_albedos.glsl": constants_glsl(_slots),
        "generated/terrain_material_ids.glsl": ids_glsl(_listed, _slots, material_ids()),
        **materials_glsl(_listed, _slots, frozenset(_over)),
    }


def albedos(terrain: Terrain, nm: Nanometres) -> NDArray[np.float64]:
    """(MOST_ALBEDOS, 3): of each place, as reflectance at the wavelengths `nm` of what are colours in the list."""
    found = np.zeros((MOST_ALBEDOS, 3))
    own = {albedo_name(m): m.albedo for m in _listed if m.albedo and not isinstance(m.albedo, str)}
    for name, slot in _slots.items():
        albedo = own.get(name, {name: 1.0})
        if isinstance(albedo, Mapping):
            found[slot] = sum(share * reflectance(getattr(terrain, field), nm) for field, share in albedo.items())
        else:
            found[slot] = reflectance(albedo, nm)
    return found


def register_material(
    name: str,
    albedo: tuple[float, float, float],
    rule: str,
    *,
    over: str = "beach",
    color: str = "albedo",
    roughness: float | None = None,
    ripples: Ripples | None = None,
    stones: float | None = None,
    plants: float | None = None,
    about: str = "",
) -> None:
    """Let the ground of all planets have a material of a game's own, where its rule says.

    albedo: share of light that it throws back, linear sRGB as it shows in sunlight. rule: the share of ground that it
    covers, 0..1: a GLSL expression, or statements that return one, of the words that docs/materials.md lists, as in
    "ramp(2000.0, 2500.0, height_m) * (1.0 - rock_share)". over: the material that it lies over; those that come later
    lie over it, so that snow covers it. color: GLSL, of which `albedo` is what that says, as in
    "albedo * (1.0 + 0.2 * grain)". roughness: height of its bumps, where soil has 1. ripples: a Ripples, for what the
    wind moves. stones, plants: share of the things that stand on soil and on it too. None: as on what lies below.
    about: a line for messages.

    Renderers that exist show it in their next frame; where its shader is broken, they go on with the last good one, and
    `Renderer.shader_errors` names it. Raises SettingError, before anything is changed, for a bad or taken name, an
    unknown name in `over` or in GLSL, values out of range, and when there are too many.
    """
    where = f"register_material({name!r})"
    if not re.fullmatch(r"[a-z][a-z0-9]*(_[a-z0-9]+)*", str(name)) or len(name) > 32:
        raise SettingError(f"{where}: name: expected up to 32 of a-z, 0-9 and single _, as in 'red_moss'")
    if any(m.name == name for m in _listed) or f"{name}_albedo" in _slots:
        raise SettingError(f"{where}: there is a material of this name; choose another, or unregister yours first")
    below = [m for m in _listed if m.within in ("bare", "ground") and m.name != "bare"]
    found = next((m for m in below if m.name == over), None)
    if found is None:
        raise SettingError(f"{where}: over: {over!r}; {did_you_mean(over, [m.name for m in below], 'it may lie over')}")
    if len(_over) == MOST_OF_GAMES:
        raise SettingError(f"{where}: {MOST_OF_GAMES} materials are the most: unregister one of {', '.join(_over)}")
    if not isinstance(rule, str) or not rule.strip():
        raise SettingError(f"{where}: rule: expected GLSL as in 'ramp(0.3, 0.6, slope)', found {rule!r}")
    colors = _numbers(where, "albedo", albedo, 3, 0.0, 1.0)
    for what, value, high in (("roughness", roughness, 8.0), ("stones", stones, 1.0), ("plants", plants, 1.0)):
        if value is not None:
            _numbers(where, what, (value,), 1, 0.0, high)
    if ripples is not None:
        _numbers(where, "ripples.wavelength_m", (ripples.wavelength_m,), 1, 0.036, 1e4)
        _numbers(where, "ripples.bend", (ripples.bend,), 1, 0.01, 10.0)
        _numbers(where, "ripples.slope, tint", (ripples.slope, ripples.tint), 2, 0.0, 1.0)
    material = Material(name, about, found.within, rule, colors, color, roughness, "", 0.0, ripples, stones, plants)
    place = _listed.index(found) + 1
    while place < len(_listed) and _over.get(_listed[place].name) == over:
        place += 1  # above those that were registered earlier
    slot = min(set(range(MOST_ALBEDOS)) - set(_slots.values()))
    wanted = [*_listed[:place], material, *_listed[place:]]
    materials_glsl(wanted, {**_slots, f"{name}_albedo": slot}, frozenset())  # mistakes in it, now
    _listed[:] = wanted
    _slots[f"{name}_albedo"] = slot
    _over[name] = over
    _revision[0] += 1


def unregister_material(name: str) -> None:
    """The opposite of register_material; nothing happens for a name that isn't registered."""
    if _over.pop(name, None) is not None:
        _listed[:] = [m for m in _listed if m.name != name]
        del _slots[f"{name}_albedo"]
        _revision[0] += 1


def _numbers(where: str, what: str, values: Any, count: int, low: float, high: float) -> tuple[float, ...]:
    try:
        found = tuple(float(v) for v in values)
    except (TypeError, ValueError):
        found = ()
    if len(found) != count or not all(math.isfinite(v) and low <= v <= high for v in found):
        many = f"{count} numbers" if count > 1 else "a number"
        raise SettingError(f"{where}: {what}: expected {many} from {low:g} to {high:g}, found {values!r}")
    return found
