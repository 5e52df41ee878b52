"""ShellProbe: the renderer's march, evaluated on the GPU for arrays of rays."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...components import MOST_CLOUD_LAYERS
from ...engine.blocks.bindings import CLOUD_BLOCK, CLOUD_SLAB_UNIT
from ...engine.gpu import GpuScope
from .block import CloudBlock, cloud_block
from .model import CloudModel
from .questions import Questions, ShellQuestion
from .slab import DEPTHS, LEAST_COSINE, LEAST_DEPTH, MOST_DEPTH, SHARES, SUNS, packed_tables, slab_table

__all__ = ["MarchRays", "ShellProbe", "march_defines", "slab_texture"]

Floats = NDArray[np.float64]
FINEST_STEPS = 300
"""Through a layer. From there on the weather is looked up at each, and steps through the clear are no longer."""
_BATCH = 4096
"""Questions in one dispatch: some tenths of a second without a GPU."""


def march_defines(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Defines of clouds/march.glsl at a quality."""
    return {
        "CLOUD_STEPS": int(settings["clouds.steps"]),
        "CLOUD_AIR_STEPS": int(settings["clouds.air_steps"]),
        "CLOUD_DEEPEST": float(settings["clouds.deepest"]),
        "AIR_DEGREE": int(settings["atmosphere.degree"]),
        "CLOUD_SLAB": f"vec3({DEPTHS}.0, {SUNS}.0, {SHARES}.0)",
        "CLOUD_SLAB_RANGE": f"vec3({LEAST_DEPTH!r}, {math.log(MOST_DEPTH / LEAST_DEPTH)!r}, {LEAST_COSINE!r})",
        "CLOUD_SLABS": MOST_CLOUD_LAYERS,
        **({"CLOUD_FINEST": 1} if settings["clouds.fine_steps"] >= FINEST_STEPS else {}),
    }


@dataclass(frozen=True)
class MarchRays:
    """Rays as the march takes them, (N,) f64 each, from where they enter the shell of what there is.

    height_m: of the start; along_m: its distance past the ray's nearest point to the planet's centre; perigee_m: the
    height of that point; rise_m: the start's coordinate along the sun's direction; nu: cosine between ray and sun;
    length_m: of the march, 0 for rays that meet nothing.
    """

    height_m: Floats
    along_m: Floats
    perigee_m: Floats
    rise_m: Floats
    nu: Floats
    length_m: Floats

    @staticmethod
    def of(
        radius_m: float, top_m: float, positions_m: Floats, directions: Floats, suns: Floats, most_m: Floats | None
    ) -> MarchRays:
        """positions_m (N, 3) planet-centred, directions and suns (N, 3) unit, most_m (N,) or None: as far as it goes.

        Rays end on the reference sphere; those that start below it start on it.
        """
        distance = np.linalg.norm(positions_m, axis=1)
        up = positions_m / np.maximum(distance, 1e-300)[:, None]
        h = np.maximum(distance - radius_m, 0.0)
        positions = up * (radius_m + h)[:, None]
        along = (positions * directions).sum(1)
        perigee = np.linalg.norm(np.cross(positions, directions), axis=1) - radius_m
        # Straight up and down, rounding must not lift the perigee above the start.
        perigee = np.minimum(perigee, h)
        rise, nu = (positions * suns).sum(1), np.clip((directions * suns).sum(1), -1.0, 1.0)

        def half_chord(height_m: float) -> Floats:
            return np.sqrt(np.maximum((height_m - perigee) * (2.0 * radius_m + height_m + perigee), 0.0))

        def level(a: Floats | float, b: Floats | float) -> Floats:
            return np.asarray((a - b) * (2.0 * radius_m + a + b))

        def ratio(a: Floats, b: Floats) -> Floats:
            # 0 / 0: a ray that touches the sphere where it starts.
            return np.divide(a, b, out=np.zeros_like(a), where=b > 0.0)

        out = half_chord(top_m)
        above = h > top_m
        meets = np.where(above, (along < 0.0) & (perigee < top_m), True)
        start = np.where(above & meets, ratio(level(h, top_m), out - along), 0.0)
        s0 = np.where(above, -out, along)
        end = np.where(s0 < 0.0, out - s0, ratio(level(top_m, np.minimum(h, top_m)), out + s0))
        floor = half_chord(0.0)
        lands = (perigee < 0.0) & (s0 < 0.0)
        entered = np.where(above, top_m, h)
        to_floor = ratio(level(entered, 0.0), floor - s0)
        end = np.where(lands, to_floor, end)
        if most_m is not None:
            end = np.minimum(end, np.maximum(most_m - start, 0.0))
        return MarchRays(entered, s0, perigee, rise + start * nu, nu, np.where(meets, end, 0.0))


def slab_texture(gpu: GpuScope, model: CloudModel) -> moderngl.Texture:
    """The table of light scattered more than once in each layer that is present, for unit CLOUD_SLAB_UNIT."""
    tables = [slab_table(layer.albedo, layer.asymmetry) for layer in model.present]
    size = (SHARES, SUNS, 3 * DEPTHS * MOST_CLOUD_LAYERS)
    return gpu.texture(size, "rgba32f", packed_tables(tables, MOST_CLOUD_LAYERS), filter="linear")


class ShellProbe:
    """One planet's clouds and the program that marches through them.

    gpu: owner of all GL objects; air_top_m: how high the air of the shader contract air_point reaches (0: none). What
    that contract reads is bound by whoever asks. Light comes back for a unit sun.
    """

    def __init__(self, gpu: GpuScope, model: CloudModel, settings: Mapping[str, Any], air_top_m: float) -> None:
        self._gpu, self._model = gpu, model
        self.top_m = max(air_top_m, model.highest_m)
        self._block = gpu.uniform_block(CloudBlock, CLOUD_BLOCK, "cloud_model")
        self._block.write(cloud_block(model))
        self._slabs = slab_texture(gpu, model)
        self._questions = Questions(gpu, ShellQuestion, "shell_question", _BATCH)
        defines = {**march_defines(settings), "CLOUD_PAPER": model.printed}
        self._program = gpu.compute("clouds/probe/shells.comp", defines)

    def march(
        self, positions_m: Floats, directions: Floats, suns: Floats, most_m: Floats | None, *,
        multiple: bool, sun_radius_rad: float,
    ) -> tuple[Floats, Floats]:  # fmt: skip
        """(radiance (N, 3), transmittance (N, 3)). sun_radius_rad 0: the sun is a point behind a hard horizon."""
        count = len(positions_m)
        if not count or self.top_m <= 0.0:
            return np.zeros((count, 3)), np.ones((count, 3))
        rays = MarchRays.of(self._model.radius_m, self.top_m, positions_m, directions, suns, most_m)
        records = np.zeros(count, self._questions.dtype)
        for item in fields(rays):
            records[item.name] = getattr(rays, item.name)
        records["sun_radius_rad"], records["multiple"] = sun_radius_rad, multiple
        self._block.bind()
        self._slabs.use(CLOUD_SLAB_UNIT)
        return self._questions.ask(self._program, records)
