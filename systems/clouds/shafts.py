"""Light shafts: the passes that take the clouds' shadow out of the air's light, where any of it is in view."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...engine.blocks.bindings import CLOUD_DEPTH_UNIT, CLOUD_SHADED_BUFFER, CLOUD_SUN_UNIT, CLOUD_VIEW_BLOCK
from ...engine.frame import Frame, View
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.gpu import GpuScope
from ...engine.graph import BufferSpec, GraphBuilder, PassIO
from ...engine.settings import Settings
from ...engine.world import World
from .history import History
from .shadow_pass import SHADED, SUN, ViewShadow
from .view_block import CLOUD_VIEW

__all__ = ["Shafts"]

_GROUPS = "clouds.shaft_groups"
_NARROW, _WIDE = 2.0, 8.0
"""Thicknesses of the first layer that a pixel is wide where shafts begin to fade and where they are gone: from there
on a pixel has lit and shaded air in it, and what is shaded lies below clouds that hide it."""
_LOCAL = (8, 4)


def reach_rad(height_m: float, radius_m: float) -> float:
    """Angle at the planet's centre from below a point to its horizon."""
    return math.acos(min(radius_m / (radius_m + max(height_m, 0.0)), 1.0))


class _ViewShafts:
    """Of one view's frame."""

    share = 0.0
    """How much of them is drawn; with 0 no pass runs."""
    map = 0
    """Of the clouds' shadow, the finest that holds all that the shafts lie in."""


class Shafts:
    """Of one planet's clouds.

    Pass ``clouds.shafts`` marches through the air below the clouds' tops, one ray for each of the clouds' own, and
    takes what isn't lit off their light. It doesn't run by night, from so far away that no shaft is wider than a pixel,
    or while nothing is due at all; and ``clouds.shafts_begin`` gives it no work where no map has any shadow.
    """

    def __init__(self, gpu: GpuScope, world: World, block: Mapping[str, Any], settings: Settings, owner: str) -> None:
        """block: defines of clouds/view_ray.glsl."""
        self._begin = gpu.compute("clouds/shafts_begin.comp")
        # The contract of the air at a point has light that was scattered before, which is not asked for.
        defines = {**block, "AIR_DEGREE": int(settings["atmosphere.degree"])}
        self._march = gpu.compute("clouds/shafts.comp", defines)
        self._world, self._owner = world, owner
        self._steps = int(settings["clouds.shaft_steps"])
        self._first_m = 1.0

    def place(self, frame: Frame, top_m: float, thickness_m: float, radius_m: float, shadow: ViewShadow) -> None:
        """Whether shadowed air is in view, as far as can be told from where things are. top_m: of the highest
        cloud."""
        own = frame.view.state(self, _ViewShafts)
        distance = float(np.linalg.norm(frame.camera.position_m))
        height, foot = distance - radius_m, frame.camera.position_m / distance
        rise = float(foot @ frame.sun.direction)
        far, dip = reach_rad(height, radius_m), reach_rad(top_m, radius_m)
        # The sun as high as it is over the farthest cloud that is seen, against where the highest still see it.
        day = math.asin(max(-1.0, min(1.0, rise))) + far + 2.0 * dip + frame.sun.angular_radius_rad > 0.0
        wide = frame.pixel_rad * max(height - top_m, 0.0) / max(thickness_m, 1e-3)
        x = min(max((wide - _NARROW) / (_WIDE - _NARROW), 0.0), 1.0)
        own.share = (1.0 - x * x * (3.0 - 2.0 * x)) if day and self._steps > 0 else 0.0
        self._first_m = thickness_m
        # Shadows lie beside what casts them, the farther the lower the sun, and no farther than a level ray leaves the
        # clouds.
        aside = min(top_m / max(rise, 1e-3), radius_m * 2.0 * dip)
        reach = radius_m * (far + dip) + aside
        maps = shadow.maps.maps
        reaching = (k for k, held in enumerate(maps) if shadow.drawn[k] and 0.8 * held.half_m >= reach)
        own.map = next(reaching, len(maps) - 1)

    def declare(
        self,
        builder: GraphBuilder,
        view: View,
        rays: str,
        size: tuple[int, int],
        distance: str,
        depth: str,
        history: Callable[[], History],
    ) -> None:
        """rays, distance: what the clouds' march makes; size: in texels. depth: where its rays end. history: of the
        frame at hand."""

        own = view.state(self, _ViewShafts)

        def due() -> bool:
            return own.share > 0.0 and not history().skip

        builder.add_pass(
            "clouds.shafts_begin",
            kind="compute",
            bind=lambda io: self._bind_begin(io, size, own, history),
            system=self._owner,
            reads=(SHADED,),
            creates=(BufferSpec(_GROUPS, 12, "persistent", "dispatch of the march through shadowed air"),),
            after=("clouds.march",),
            when=due,
            help="whether any cloud in reach has a shadow",
        )
        builder.add_pass(
            "clouds.shafts",
            kind="compute",
            bind=lambda io: self._bind_march(io, rays, distance, depth, own, history),
            system=self._owner,
            reads=(CLOUD_VIEW, depth, SUN, _GROUPS, *contract_reads(self._world, but=self._owner)),
            writes=(rays, distance),
            after=("clouds.shafts_begin",),
            when=due,
            help="sunlight that the air in the clouds' shadow does not scatter",
        )

    def _bind_begin(
        self, io: PassIO, size: tuple[int, int], own: _ViewShafts, history: Callable[[], History]
    ) -> Callable[[], None]:
        (width, height), shaded, groups = size, io.buffer(SHADED), io.buffer(_GROUPS)

        def run() -> None:
            shaded.bind_to_storage_buffer(CLOUD_SHADED_BUFFER)
            groups.bind_to_storage_buffer(1)
            rows = height if history().checkerboard < 0 else -(-height // 2)
            self._begin.set("u_groups", (-(-width // _LOCAL[0]), -(-rows // _LOCAL[1])))
            self._begin.set("u_map", max(own.map, 0))
            self._begin.run()

        return run

    def _bind_march(
        self, io: PassIO, rays: str, distance: str, surface: str, own: _ViewShafts, history: Callable[[], History]
    ) -> Callable[[], None]:
        light, far, depth = io.texture(rays), io.texture(distance), io.texture(surface)
        sun, groups, block = io.texture(SUN), io.buffer(_GROUPS), io.imported(CLOUD_VIEW)
        bind = bind_contracts(self._world, io, but=self._owner)

        def run() -> None:
            bind()
            block.value.bind_to_uniform_block(CLOUD_VIEW_BLOCK)
            depth.use(CLOUD_DEPTH_UNIT)
            sun.use(CLOUD_SUN_UNIT)
            light.bind_to_image(0, read=True, write=True)
            far.bind_to_image(1, read=True, write=True)
            self._march.set("u_shaft_steps", self._steps)
            self._march.set("u_shaft_share", own.share)
            self._march.set("u_first_shaft_step", self._first_m)
            history().give(self._march)
            self._march.run_indirect(groups)

        return run
