"""GLSL of a list of materials: a function for each rule and colour, and what mixes them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from textwrap import dedent

from ...engine.settings import SettingError
from ...engine.settings.suggest import did_you_mean
from .materials import INPUTS, Material

__all__ = ["albedo_name", "albedo_names", "constants_glsl", "ids_glsl", "materials_glsl", "struct_glsl", "words_of"]

_SHORTEST_RIPPLE_M = 0.036
"""Wavelength of terrain/ripples.glsl at step 0."""

_GLSL = frozenset(
    re.findall(
        r"\w+",
        """abs acos all any asin atan bell bool bvec2 bvec3 bvec4 ceil clamp cos cross degrees distance dot else exp
        exp2 false float floor for fract greaterThan if int inversesqrt ivec2 ivec3 ivec4 length lessThan log log2 mat2
        mat3 mat4 max min mix mod normalize not pow radians ramp return round sign sin smoothstep sqrt step tan true
        trunc uint uvec2 uvec3 uvec4 vec2 vec3 vec4""",
    )
)
"""What rules may use of the language, and the two functions of terrain/ground_at.glsl that are meant for them."""


def words_of(text: str) -> list[str]:
    """Names in GLSL, each once, without members such as .xyz and without comments."""
    code = re.sub(r"//[^\n]*|/\*.*?\*/", "", text, flags=re.S)
    return list(dict.fromkeys(re.findall(r"(?<![\w.])[A-Za-z_]\w*", code)))


def constants_glsl(slots: Mapping[str, int]) -> str:
    """The albedos in the uniform block, by name: `generated/terrain_albedos.glsl`."""
    lines = [f"#define {name.upper()} terrain_material_block.albedos[{slot}]" for name, slot in slots.items()]
    return "\n".join(['#include "generated/terrain_material_block.glsl"', *lines, ""])


def struct_glsl() -> str:
    """What rules may know of a place: `generated/terrain_ground.glsl`."""
    return "struct Ground {\n" + "".join(f"    float {name};  // {about}\n" for name, about in INPUTS.items()) + "};\n"


class _Writer:
    """Writes what is asked for, each name once and after those that it needs."""

    def __init__(self, materials: Sequence[Material], slots: Mapping[str, int]) -> None:
        self.by_name = {m.name: m for m in materials}
        self.parts = {m.name: [part for part in materials if part.within == m.name] for m in materials}
        self.slots = slots
        self.functions: dict[str, str] = {}  # by material
        self.lines: list[str] = []
        self._done: set[str] = set()
        self._open: list[str] = []

    def known(self, word: str) -> bool:
        return word in INPUTS or word in self.slots or self._owner(word) is not None

    def _owner(self, word: str) -> Material | None:
        name, _, what = word.rpartition("_")
        return self.by_name.get(name) if what in ("share", "color") else None

    def value(self, word: str) -> str:
        """The GLSL of an input, an albedo, a share or a colour, which is worked out before it is used."""
        if word in INPUTS:
            return f"ground.{word}"
        if word in self.slots:
            return word.upper()
        owner = self._owner(word)
        assert owner is not None, word
        if word in self._open:
            circle = " -> ".join([*self._open[self._open.index(word) :], word])
            raise SettingError(f"material {owner.name!r} would need itself: {circle}")
        if word not in self._done:
            self._open.append(word)
            self._work_out(word, owner)
            self._open.pop()
            self._done.add(word)
        return word

    def _work_out(self, word: str, material: Material) -> None:
        if word.endswith("_share"):
            self.lines.append(f"float {word} = {self.call('float', word, material.rule)};")
            return
        albedo = ""
        if self.parts[material.name]:
            first, *others = self.parts[material.name]
            self.value(f"{first.name}_color")
            pairs = [(self.value(f"{part.name}_color"), self.value(f"{part.name}_share")) for part in others]
            self.lines.append(f"vec3 {word} = {first.name}_color;")
            self.lines += [f"{word} = mix({word}, {color}, {share});" for color, share in pairs]
            albedo, declared = word, ""
        else:
            declared = "vec3 "
            albedo = self.value(albedo_name(material)) if material.albedo else "vec3(0.0)"
        plain = material.color.strip() == "albedo"
        if not plain or declared:
            made = albedo if plain else self.call("vec3", word, material.color, albedo)
            self.lines.append(f"{declared}{word} = {made};")

    def call(self, kind: str, word: str, text: str, albedo: str = "") -> str:
        """A call of the function that this GLSL becomes: its parameters are the words that it uses."""
        words = [w for w in words_of(text) if (w == "albedo" and albedo) or self.known(w)]
        given = [albedo if w == "albedo" else self.value(w) for w in words]
        kinds = ["vec3" if re.search(r"(albedo|_color)$", w) else "float" for w in words]
        parameters = ", ".join(f"{k} {w}" for k, w in zip(kinds, words, strict=True))
        body = dedent(text).strip() if re.search(r"\breturn\b", text) else f"return {text.strip()};"
        owner = self.by_name[word.rpartition("_")[0]]
        about = " ".join(owner.about.encode("ascii", "replace").decode().split())
        lines = "\n".join(f"    {line}".rstrip() for line in body.splitlines())
        text = f"// {owner.name}: {about}\n{kind} {word}_of({parameters}) {{\n{lines}\n}}\n"
        self.functions[owner.name] = self.functions.get(owner.name, "") + text
        return f"{word}_of({', '.join(given)})"


def albedo_name(material: Material) -> str:
    """The name of a material's albedo: a field of Terrain, another material's, or its own."""
    return material.albedo if isinstance(material.albedo, str) else f"{material.name}_albedo"


def albedo_names(materials: Sequence[Material]) -> list[str]:
    """The albedos that materials have, in their order."""
    return list(dict.fromkeys(albedo_name(m) for m in materials if m.albedo))


def materials_glsl(materials: Sequence[Material], slots: Mapping[str, int], apart: frozenset[str]) -> dict[str, str]:
    """`generated/terrain_materials.glsl`: Material terrain_material(Ground), from a list whose first is all ground.
    apart: names of materials whose functions get files of their own, which a compiler's messages then name."""
    writer = _Writer(materials, slots)
    for material in materials:
        waves = material.ripples.share if material.ripples else ""
        for what, text in (("rule", material.rule), ("color", material.color), ("ripples.share", waves)):
            _check_words(writer, material, what, text)
    albedo = writer.value(f"{materials[0].name}_color")
    upper = [m for whole in (materials[0], *writer.parts[materials[0].name]) for m in writer.parts[whole.name]]
    upper = [m for m in materials if m in upper and m.rule]  # what lies on open ground, from below
    foot = [m for m in upper if m.at_foot]
    ripples = _ripples(writer, [m for m in materials if m.ripples is not None], upper)
    lines = [
        *writer.lines,
        "Material material;",
        f"material.albedo = clamp({albedo}, 0.0, 1.0);",
        f"material.grain = {_bumps(upper)} * terrain_material_block.grain;",
        "material.rock = rock_share;",
        "material.plant = plants_color;",
        f"material.ripples = {ripples};",
        f"stand_on(material, ground, {_left(upper, 'stones')}, {_left(upper, 'plants')}, {_left(upper, 'trees')});",
        "#ifdef GROUND_COVER",
        f"material.inland = {_left(foot, 'plants', at_foot=True)};",
        "#endif",
        "return material;",
    ]
    body = "\n".join(f"    {line}" for line in lines)
    taken = {m.name.upper(): [_number(1.0 - (1.0 if v is None else v)) for v in (m.stones, m.plants)] for m in foot}
    defines = [f"#define {name}_TAKES vec2({', '.join(both)})" for name, both in taken.items()]
    files = {f"generated/materials/{name}.glsl": writer.functions.pop(name) for name in sorted(apart)}
    parts = [
        "// Made from systems/terrain/materials.py.",
        *defines,
        *writer.functions.values(),
        *(f'#include "{file}"' for file in files),
        f"Material terrain_material(Ground ground) {{\n{body}\n}}\n",
    ]
    return {**files, "generated/terrain_materials.glsl": "\n".join(parts)}


def ids_glsl(materials: Sequence[Material], slots: Mapping[str, int], ids: Mapping[str, int]) -> str:
    """`generated/terrain_material_ids.glsl`: uint terrain_material_id(Ground), the number of the material that shows
    most of itself. ids: numbers of materials by name. It calls functions of the file that materials_glsl makes."""
    writer = _Writer(materials, slots)
    shown = list(_shown(writer, materials[0], ""))
    lines = [
        *writer.lines,
        f"uint number = {ids[materials[0].name]}u;",
        "float share = 0.0, most = 0.0;",
        *(
            f"share = {share or '1.0'}; number = share > most ? {ids[m.name]}u : number; most = max(most, share);"
            for m, share in shown
        ),
        "return number;",
    ]
    body = "\n".join(f"    {line}" for line in lines)
    return f"uint terrain_material_id(Ground ground) {{\n{body}\n}}\n"


def _shown(writer: _Writer, material: Material, share: str) -> Iterator[tuple[Material, str]]:
    """Materials that are no mixtures, and GLSL of the share of the ground that each shows: later ones hide earlier
    ones."""
    parts = writer.parts[material.name]
    if not parts:
        yield material, share
    values = [writer.value(f"{part.name}_share") for part in parts[1:]]
    for k, part in enumerate(parts):
        factors = [share] * bool(share) + values[k - 1 : k] * bool(k) + [f"(1.0 - {value})" for value in values[k:]]
        yield from _shown(writer, part, " * ".join(factors))


def _number(value: float) -> str:
    return f"{float(value)!r}"


def _bumps(upper: Sequence[Material]) -> str:
    """Height of the bumps: what lies higher replaces or hides those below."""
    order = [m for m in upper if not m.bumps_before]
    for material in (m for m in upper if m.bumps_before):
        order.insert([m.name for m in order].index(material.bumps_before), material)
    text = "1.0"
    for m in order:
        text = text if m.roughness is None else f"mix({text}, {_number(m.roughness)}, {m.name}_share)"
        text += f" * (1.0 - {_number(m.buries)} * {m.name}_share)" if m.buries else ""
    return text


def _left(upper: Sequence[Material], things: str, at_foot: bool = False) -> str:
    """Share of the things on soil that the materials on it leave."""
    text = ""
    for m in upper:
        share = (m.plants if m.hides_trees else None) if things == "trees" else getattr(m, things)
        if share is None or m.at_foot != at_foot:
            continue
        if share:
            text = f"mix({text or '1.0'}, {_number(share)}, {m.name}_share)"
        else:
            text += f"{' * ' if text else ''}(1.0 - {m.name}_share)"
    return text or "1.0"


def _ripples(writer: _Writer, loose: Sequence[Material], upper: Sequence[Material]) -> str:
    """The strongest of all; those of one shape show where any of them does."""
    shares: dict[str, str] = {}
    for m in loose:
        assert m.ripples is not None
        above = upper[upper.index(m) + 1 :] if m in upper else ()
        share = m.ripples.share or " * ".join([f"{m.name}_share", *(f"(1.0 - {other.name}_share)" for other in above)])
        name, step = f"{m.name}_ripples", round(math.log2(m.ripples.wavelength_m / _SHORTEST_RIPPLE_M))
        writer.lines.append(f"float {name} = {writer.call('float', name, share)};")
        shape = ", ".join([str(step), *map(_number, (m.ripples.bend, m.ripples.slope, m.ripples.tint))])
        shares[shape] = f"max({shares[shape]}, {name})" if shape in shares else name
    first, *others = (f"Ripples({share}, {shape})" for shape, share in shares.items())
    return reduce(lambda text, other: f"stronger({text}, {other})", others, first)


def _check_words(writer: _Writer, material: Material, what: str, text: str) -> None:
    """SettingError for a name that nothing has; what statements declare is left to the compiler."""
    declared = set(re.findall(r"\b(?:float|u?int|bool|[biu]?vec[234]|mat[234])\s+(\w+)|(\w+)\s*=(?!=)", text))
    names = {name for pair in declared for name in pair} if re.search(r"\breturn\b", text) else set()
    for word in words_of(text):
        if word in _GLSL or word in names or (word == "albedo" and what == "color") or writer.known(word):
            continue
        near = did_you_mean(word, [*INPUTS, *writer.slots, *(f"{n}_share" for n in writer.by_name)], "it may use")
        raise SettingError(f"material {material.name!r}: {what}: there is no {word!r}; {near}")
