"""The GPU's table of octaves around one anchor: its layout, which shaders read as `terrain_table`, and its values."""

from __future__ import annotations

from dataclasses import astuple, dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.bindings import TERRAIN_TABLE_BLOCK, TERRAIN_TABLE_BUFFER
from ...engine.blocks.layout import IVec2, IVec3, StructLayout, Vec2, Vec3, array
from ...engine.made_shaders import made_shader
from ...engine.surface.cube_map import face_planes
from ...engine.surface.noise import Lattice
from . import crater_form, gullies, height_steps
from .crater_form import CraterShape
from .craters import MOST_OCTAVES, Craters
from .height_added import MOST_ROUGH
from .height_map import LEVEL_SAMPLES
from .height_model import (
    FIELDS,
    GATING_LAYERS,
    SHAPE_LAYERS,
    WARPED_LAYERS,
    Model,
    TerrainConstants,
    continent_weights,
)
from .height_octaves import anchor_ground, heights, model_of
from .height_params import TerrainParams
from .height_surface import carve, shader
from .real_colors import write_anchor
from .real_texture import MOST_LEVELS, TerrainReal, TerrainRealLevel, fixed_unit_m, write_real
from .rivers.banks import bank_bits
from .rivers.table import BEND_CELLS, CELL_STEPS, RiverTable
from .rivers.texture import river_layout
from .rivers.valleys import valleys
from .woods_map import TerrainWoods, write_woods

__all__ = ["TerrainTable", "canonical_table", "octave_table"]

MOST_LAYERS = 16


@dataclass
class TerrainLattice:
    """An octave of noise around the anchor."""

    cell: Annotated[IVec3, "of the anchor"]
    frequency_per_m: float
    fraction: Annotated[Vec3, "the anchor's place in its cell; of 24 bits around the planet's centre, so exact"]
    wavelength_m: float
    value: Annotated[float, "at the anchor, of continents, belts and warped layers the noise, of wide craters metres"]


@dataclass
class TerrainWarp:
    lattice: TerrainLattice
    value: Annotated[Vec3, "the vector noise at the anchor"]
    amplitude_m: float
    factor: Annotated[int, "the amplitude in fixed units: factor 2^-shift is it times 4"]
    shift: int


@dataclass
class TerrainFieldOctave:
    lattice: TerrainLattice
    weights: Annotated[Vec2, "in continents c, in belts b"]


@dataclass
class TerrainLayer:
    lattice: TerrainLattice
    range_weight: Annotated[float, "in s"]
    amplitude_m: Annotated[float, "in z"]
    ridge: Annotated[float, "share of the ridge transform, negative for its mirror image"]


@dataclass
class CraterOctave:
    lattice: TerrainLattice
    shape: CraterShape


@dataclass
class TerrainMap:
    cells: Annotated[int, "a side of a face of the height map's cube; 0: no map"]
    levels: int
    sample_m: Annotated[float, "distance of the finest samples"]
    roughness_per_m: Annotated[float, "roughness of the relief by height differences of the finest scale"]


@dataclass
class TerrainMapFace:
    """The anchor on the plane of a face of the height map's cube."""

    place: Annotated[Vec2, "from the face's middle, -1..1 on the face itself"]
    fraction: Annotated[Vec2, "of its cell of samples"]
    cell: IVec2
    near: Annotated[int, "0: the anchor is to the side of the face or behind it"]


@dataclass
class TerrainColorMap:
    """Written by map_textures."""

    cells: Annotated[int, "a side of a face of the colour map's cube; 0: no map"]
    levels: Annotated[int, "of tiles the width of their texture, a power of two"]
    strength: Annotated[float, "0..1"]


@dataclass
class TerrainRivers:
    """Where rivers lie in their texture (rivers/texture.py), and what they make of the anchor's ground."""

    anchor: Annotated[IVec3, "in steps of nodes' places"]
    step_m: float
    rest: Annotated[Vec3, "of the anchor beyond it, steps"]
    bends: Annotated[Any, array(TerrainLattice, len(BEND_CELLS))]
    across: Annotated[int, "columns of cells along x and y; 0: no rivers"]
    first_cell: int
    first_line: int
    first_node: int
    first_block: int
    count_bits: Annotated[int, "of the number of lines in a cell"]
    bank_bits: Annotated[IVec3, "wavelengths of the noise of banks: logarithms, in steps"]
    uneven: Annotated[float, "how uneven banks are, 0..1"]
    given: Annotated[int, "1: lakes are where ground lies below their level (rivers/table.py)"]
    uncarved_m: Annotated[float, "the anchor's ground without them, above the reference sphere"]
    base_m: Annotated[float, "what they cut it to; 0 where no valley reaches"]
    open: Annotated[float, "share of its height above that"]
    raised: Annotated[float, "share of its depth below that which is filled"]
    wetter: Annotated[float, "Cover.riparian: how much of their moisture banks have"]


@dataclass
class TerrainAnchor:
    """What the anchor's ground is made of, from which the GPU's changes count."""

    fields: Annotated[Vec2, "continents and belts, c and b"]
    shapes: Annotated[Vec2, "both parts of s"]
    ranges_m: Annotated[float, "of z, what the layers of ranges make"]
    added_m: Annotated[float, "by wide craters and map"]
    map_m: Annotated[float, "by the map"]
    height_m: Annotated[float, "of a ground of just these, over the height that heights count from"]


@dataclass
class TerrainTable:
    up: Annotated[Vec3, "of the anchor"]
    radius_m: float
    fixed_unit_m: Annotated[float, "of places in fixed point; the radius is 2^22 to 2^23 of it"]
    layer_count: int
    anchor: Annotated[TerrainAnchor, "0 around the planet's centre"]
    warped_layers: int
    crater_octaves: int
    coarse_crater_octaves: Annotated[int, "evaluated as changes from the anchor, around the centre as pairs of floats"]
    crater_accept: Annotated[int, "of 256 cells, those with a crater"]
    map: TerrainMap
    map_faces: Annotated[Any, array(TerrainMapFace, 6)]
    color: TerrainColorMap
    rivers: TerrainRivers
    woods: TerrainWoods
    real: TerrainReal
    real_levels: Annotated[Any, array(TerrainRealLevel, MOST_LEVELS, flat=True)]
    erosion: Annotated[float, "share of relief that is gullies where it is steep"]
    constants: TerrainConstants
    wide_warp: Annotated[TerrainWarp, "w1"]
    narrow_warp: Annotated[TerrainWarp, "w2"]
    fields: Annotated[Any, array(TerrainFieldOctave, FIELDS)]
    layers: Annotated[Any, array(TerrainLayer, MOST_LAYERS)]
    craters: Annotated[Any, array(CraterOctave, MOST_OCTAVES, flat=True)]


_LAYOUT = StructLayout(TerrainTable)


def table_shader() -> str:
    """GLSL: the block `terrain_table` and the numbers that belong to it. With TERRAIN_TABLE_STORAGE it is a storage
    buffer: llvmpipe reads an array there lane by lane, 5 ns an octave more."""
    numbers = {
        "FIELDS": FIELDS, "GATING_LAYERS": GATING_LAYERS, "SHAPE_LAYERS": SHAPE_LAYERS, "WARPED_LAYERS": WARPED_LAYERS,
        "MOST_ROUGH": MOST_ROUGH, "LEVEL_SAMPLES": LEVEL_SAMPLES,
    }  # fmt: skip
    text = "".join(f"const {type(v).__name__} TERRAIN_{name} = {v};\n" for name, v in numbers.items())
    uniform = _LAYOUT.block(TERRAIN_TABLE_BLOCK, "terrain_table")
    storage = _LAYOUT.block(TERRAIN_TABLE_BUFFER, "terrain_table", storage=True)
    return f"{text}#ifndef TERRAIN_TABLE_STORAGE\n{uniform}#else\n{storage}#endif\n"


made_shader("generated/terrain_table.glsl", table_shader)
made_shader("generated/terrain_gully_numbers.glsl", gullies.shader)
made_shader("generated/terrain_steps.glsl", height_steps.shader)
made_shader("generated/terrain_surface.glsl", shader)
made_shader("generated/terrain_crater_form.glsl", crater_form.shader)


def octave_table(
    params: TerrainParams | Model, direction: NDArray[np.float64], height_m: float | None = None
) -> NDArray[Any]:
    """The table for an anchor on the reference sphere at unit `direction` (3,): one record, ready for the buffer.

    Cells and fractions are formed in float64, so what the GPU adds are offsets from the anchor only. Heights on the
    GPU count from `height_m`, by default the ground's height at the anchor.
    """
    model = params if isinstance(params, Model) else model_of(params)
    point = np.asarray(direction, dtype=np.float64).reshape(3) * model.params.radius_m
    if height_m is None:
        height_m = float(heights(point[:, None], model)[0])
    table = np.zeros((), dtype=_LAYOUT.dtype)
    table["up"] = point / model.params.radius_m
    table["radius_m"] = model.params.radius_m
    table["fixed_unit_m"] = unit_m = fixed_unit_m(model.params.radius_m)
    table["layer_count"], table["warped_layers"] = model.layers, model.warped_layers
    table["constants"] = astuple(model.constants)
    table["erosion"] = model.params.erosion

    values = np.zeros((2, 3))
    if point.any():  # else whole warps, not differences
        values = model.unwarped.cells(point[:, None]).part(slice(0, 2)).vector()[:, :, 0].T
    for k, name in enumerate(("wide_warp", "narrow_warp")):
        warp = table[name]
        _anchor(warp["lattice"], point, model.unwarped, slice(k, k + 1))
        warp["value"] = values[k]
        warp["amplitude_m"] = model.warp_m[k]
        warp["factor"], warp["shift"] = _fixed_factor(model.warp_m[k] / unit_m)
    near = point + model.warp_m[1] * values[1]
    far = near + model.warp_m[0] * values[0]
    fields, layers = table["fields"], table["layers"][: model.layers]
    if point.any():
        where = np.repeat(np.stack([far, near], axis=1), (FIELDS, model.warped_layers), axis=1)
        noise = model.warped.cells(where[:, :, None]).noise()[:, 0]
        fields["lattice"]["value"], layers["lattice"]["value"][: model.warped_layers] = noise[:FIELDS], noise[FIELDS:]
        *parts, craters_m, ground_m = anchor_ground(point, values[0], noise, model)
        table["anchor"] = (*parts, ground_m - height_m)
        table["craters"]["lattice"]["value"][: len(craters_m)] = craters_m
    _anchor(fields["lattice"], far, model.warped, slice(0, FIELDS))
    fields["weights"] = np.stack(continent_weights(), axis=1)
    _anchor(layers["lattice"][: model.warped_layers], near, model.warped, slice(FIELDS, None))
    _anchor(layers["lattice"][model.warped_layers :], point, model.unwarped, slice(2, None))
    layers["range_weight"], layers["amplitude_m"], layers["ridge"] = model.shape, model.amplitude_m, model.ridge

    found, craters = model.params.height_map, model.craters
    table["color"]["cells"] = int(model.params.colored)
    if found is not None:
        table["map"] = (found.cube.cells, len(found.cube.levels), model.map_sample_m, model.map_roughness)
        near, place = face_planes(point / model.params.radius_m)
        at = (place * 0.5 + 0.5) * found.cube.cells
        faces, cell = table["map_faces"], np.floor(at)
        faces["near"], faces["place"], faces["cell"], faces["fraction"] = near, place, cell, at - cell
    if model.params.real is not None:
        write_real(table, model.params.real, model.real_rough, point, height_m)
    elif model.params.pictured:
        write_anchor(table, point)
    if model.params.woods is not None:
        write_woods(table, model.params.woods, point, model.params.radius_m)
    if model.params.waters is not None:
        _write_rivers(table, model.params.waters, point, height_m)
    if craters:
        table["crater_octaves"], table["coarse_crater_octaves"] = len(craters), craters.coarse
        table["crater_accept"] = craters.accept
        octaves = table["craters"][: len(craters)]
        _anchor(octaves["lattice"], point, craters, slice(None))
        for name, values in zip(("wall", "bottom", "rim", "peak"), craters.shape.T, strict=True):
            octaves["shape"][name] = values
    return table


def _write_rivers(table: NDArray[Any], rivers: RiverTable, point: NDArray[np.float64], height_m: float) -> None:
    """What rivers are, and what they make of the anchor's ground, whose height without them the table has already."""
    part, layout = table["rivers"], river_layout(rivers)
    steps = point * (CELL_STEPS / rivers.cell_m)
    part["anchor"], part["rest"] = np.floor(steps), steps - np.floor(steps)
    _anchor(part["bends"], point, rivers.bends, slice(None))
    part["bends"]["value"] = rivers.bend_m
    part["step_m"] = rivers.cell_m / CELL_STEPS
    part["uneven"] = rivers.uneven
    part["bank_bits"] = bank_bits(rivers.cell_m / CELL_STEPS)
    for name in ("across", "first_cell", "first_line", "first_node", "first_block", "count_bits"):
        part[name] = getattr(layout, name)
    part["open"], part["given"] = 1.0, int(rivers.given)
    if not point.any():
        return
    if rivers.given:  # levels count from there
        part["base_m"] = float(np.float32(height_m))
        return
    cut = valleys(rivers, point[:, None])
    base, left, raised = (float(np.float32(v[0])) for v in (cut.base_m, cut.open, cut.raised))
    # Of the broad shapes alone: relief counts as a change.
    uncarved_m = float(np.float32(table["anchor"]["height_m"] + height_m))
    part["uncarved_m"], part["base_m"], part["open"], part["raised"] = uncarved_m, base, left, raised
    table["anchor"]["height_m"] = carve(uncarved_m, base, left, raised) - height_m


def _anchor(rows: NDArray[Any], point: NDArray[np.float64], lattices: Lattice | Craters, part: slice) -> None:
    """Write lattices around `point` (3,), in metres."""
    frequency = lattices.frequency[part]
    place = point * frequency[:, None] + lattices.offset[part]
    cell = np.floor(place)
    shape = (*rows.shape, 3)
    rows["cell"], rows["fraction"] = cell.astype(np.int32).reshape(shape), (place - cell).reshape(shape)
    rows["frequency_per_m"], rows["wavelength_m"] = frequency.reshape(rows.shape), (1.0 / frequency).reshape(rows.shape)


def canonical_table(params: TerrainParams | Model) -> NDArray[Any]:
    """The table around the planet's centre, for terrain/canonical_height.glsl: places there are P itself, in fixed
    point, and nothing is a difference from an anchor."""
    return octave_table(params, np.zeros(3), 0.0)


def _fixed_factor(amplitude: float) -> tuple[int, int]:
    """Of an amplitude, a float32 number of units, (factor, shift): what a noise of 2^-30 is multiplied with and shifted
    right by to be 2^-32 units."""
    share, exponent = np.frexp(amplitude)
    factor, shift = int(share * 2.0**24), 22 - int(exponent)
    return (0, 0) if shift > 31 else (factor << max(-shift, 0), max(shift, 0))
