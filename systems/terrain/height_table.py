"""The GPU's table of octaves around one anchor: SSBO 4, std430, TerrainTable of terrain/height.glsl."""

from __future__ import annotations

from dataclasses import astuple, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.made_shaders import made_shader
from .craters import MOST_OCTAVES
from .height_model import FIELDS, Constants, Model, continent_weights
from .height_octaves import heights, model_of
from .height_params import TerrainParams
from .height_surface import shader

__all__ = ["canonical_table", "octave_table"]

made_shader("generated/terrain_surface.glsl", shader)
_CONSTANTS = len(fields(Constants))
_OCTAVE = np.dtype(
    [
        ("cell", np.int32, 4),  # the anchor's lattice cell
        ("fraction_hi", np.float32, 3),  # its place in the cell, hi + lo exact to 1e-15
        ("frequency", np.float32),  # 1/m
        ("fraction_lo", np.float32, 3),
        ("wavelength_m", np.float32),
        ("weights", np.float32, 4),  # fields: in c, in b; layers: in s, in z (metres), ridge
    ]
)


_TABLE = np.dtype(
    [
        ("warp_hi", np.float32, (2, 4)),  # the two vector noises at the anchor
        ("warp_lo", np.float32, (2, 4)),
        ("up", np.float32, 3),
        ("radius_m", np.float32),
        ("height_m", np.float32, 2),  # the anchor's height, hi + lo
        ("warp_m", np.float32, 2),
        ("layers", np.int32),
        ("warped_layers", np.int32),
        ("craters_count", np.int32),
        ("craters_coarse", np.int32),
        ("up_low", np.float32, 3),  # up = up + up_low to 48 bits
        ("crater_draws", np.float32),  # of 256
        ("map_cells", np.int32),  # a side of a face, 0: no map
        ("map_levels", np.int32),
        ("color_cells", np.int32),  # of the colour map (here: whether there is one); map_textures writes them
        ("color_levels", np.int32),
        ("map_sample_m", np.float32),
        ("map_roughness", np.float32),  # by height differences of the finest scale, 1/m
        ("color_strength", np.float32),
        ("map_pad", np.float32),
        ("constants", np.float32, _CONSTANTS + -_CONSTANTS % 4),
        ("octaves", _OCTAVE, 2 + FIELDS + 16),
        ("craters", _OCTAVE, MOST_OCTAVES),  # weights: wall, floor, rim, peak by radius
    ]
)
"""The same bytes under std430 and std140."""


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
    table = np.zeros((), dtype=_TABLE)
    warps = model.unwarped.cells(point[:, None]).part(slice(0, 2)).vector()[:, :, 0].T
    table["warp_hi"][:, :3], table["warp_lo"][:, :3] = _split(warps)
    table["up"], table["up_low"] = _split(point / model.params.radius_m)
    table["radius_m"] = model.params.radius_m
    table["height_m"] = np.stack(_split(np.float64(height_m)))
    table["warp_m"] = model.warp_m
    table["layers"], table["warped_layers"] = model.layers, model.warped_layers
    table["constants"][:_CONSTANTS] = astuple(model.constants)

    if not point.any():
        table["warp_hi"], table["warp_lo"], warps = 0.0, 0.0, np.zeros_like(warps)  # whole warps, not differences
    near = point + model.warp_m[1] * warps[1]
    far = near + model.warp_m[0] * warps[0]
    warped, last = model.warped_layers, 2 + FIELDS + model.layers
    place = np.empty((last, 3))
    place[:2] = point * model.unwarped.frequency[:2, None] + model.unwarped.offset[:2]
    split = 2 + FIELDS
    place[2:split] = far * model.warped.frequency[:FIELDS, None] + model.warped.offset[:FIELDS]
    layer = slice(split, split + warped)
    place[layer] = near * model.warped.frequency[FIELDS:, None] + model.warped.offset[FIELDS:]
    place[layer.stop :] = point * model.unwarped.frequency[2:, None] + model.unwarped.offset[2:]
    frequency = np.concatenate([model.unwarped.frequency[:2], model.warped.frequency, model.unwarped.frequency[2:]])

    cell = np.floor(place)
    octaves = table["octaves"][:last]
    octaves["cell"][:, :3] = cell.astype(np.int32)
    octaves["fraction_hi"], octaves["fraction_lo"] = _split(place - cell)
    octaves["frequency"], octaves["wavelength_m"] = frequency, 1.0 / frequency
    octaves["weights"][2:split, :2] = np.stack(continent_weights(), axis=1)
    octaves["weights"][split:, 0] = model.shape
    octaves["weights"][split:, 1] = model.amplitude_m
    octaves["weights"][split:, 2] = model.ridge
    found, craters = model.params.height_map, model.craters
    table["color_cells"] = int(model.params.colored)
    if found is not None:
        table["map_cells"], table["map_levels"] = found.cube.cells, len(found.cube.levels)
        table["map_sample_m"], table["map_roughness"] = model.map_sample_m, model.map_roughness
    if craters:
        table["craters_count"], table["craters_coarse"] = len(craters), craters.coarse
        table["crater_draws"] = craters.accept
        place = point * craters.frequency[:, None] + craters.offset
        cell = np.floor(place)
        rows = table["craters"][: len(craters)]
        rows["cell"][:, :3] = cell.astype(np.int32)
        rows["fraction_hi"], rows["fraction_lo"] = _split(place - cell)
        rows["frequency"], rows["wavelength_m"] = craters.frequency, 1.0 / craters.frequency
        rows["weights"] = craters.shape
    return table


def canonical_table(params: TerrainParams | Model) -> NDArray[Any]:
    """The table around the planet's centre, for terrain/canonical_height.glsl: places there are P itself, in double,
    and nothing is a difference from an anchor."""
    return octave_table(params, np.zeros(3), 0.0)


def _split(value: Any) -> tuple[Any, Any]:
    """Two float32 whose sum is the float64 value to 48 bits."""
    high = np.asarray(value).astype(np.float32)
    return high, (value - high.astype(np.float64)).astype(np.float32)
