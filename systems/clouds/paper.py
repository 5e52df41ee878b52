"""PaperClouds: clouds as the sources print them, in place of ours: one layer, one volume, one march for every pixel."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import ClassVar, NamedTuple

import numpy as np

from ...components import CloudLayer, Clouds, Planet, Wind
from ...components.wind import blown
from ...engine.blocks.bindings import CLOUD_TILE_UNIT, CLOUD_VIEW_BLOCK
from ...engine.blocks.layout import zeros
from ...engine.frame import Frame, View, ViewInfo, ViewParts
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.gpu import GpuScope
from ...engine.graph import GraphBuilder, PassIO
from ...engine.settings import with_overrides
from ...engine.system import Setup
from .layers import frames_at
from .method import CloudMethod, CloudsRevision, may_see
from .paper_volume import PaperVolume
from .view_block import CLOUD_VIEW, CloudViewBlock, CloudViewLayer, CloudVolume, cloud_view_uniforms

__all__ = ["LARGE_STEP", "STEPS", "PaperClouds", "PaperClouds2018"]

STEPS, LARGE_STEP = 40, 4.0
"""Small steps through the layer's thickness, and small steps in a large one. The source gives neither."""
SCATTERING, ASYMMETRY = 8.0, 0.35
"""The printed scattering factor S over what droplets scatter, and the printed phase function's asymmetry over theirs.
The source gives neither. With these an opaque layer under a sun 60 degrees high sends back 0.76 of its light, and they
come nearest to our reference on the same clouds from 100 m, 10 km and 2000 km. Even layers keep the droplets' own, as
pf.CloudProbe does."""
_BUDGET_S = 0.01
"""Of a frame, while the full volume is made."""


class _VolumeKey(NamedTuple):
    """What the volume is made for; with an even layer the extinction alone."""

    extinction_per_m: float
    coverage: float | None = None
    tile_m: float = 0.0
    thickness_m: float = 0.0


class _View(ViewParts):
    """One view's: its uniform block, and whether it may show any cloud."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.ubo = self.gpu.uniform_block(CloudViewBlock, CLOUD_VIEW_BLOCK)
        self.seen = True


class PaperClouds(CloudMethod):
    """The passes of Michelic et al. 2019: clouds and air put together as there."""

    contracts: ClassVar[Mapping[str, str]] = {"cloud_shadow": "clouds/paper/shadow.glsl"}
    reads: ClassVar[tuple[str, ...]] = (CLOUD_VIEW,)
    year: ClassVar[int] = 2019

    def __init__(self, gpu: GpuScope, setup: Setup) -> None:
        super().__init__(gpu, setup)
        cloud_view_uniforms(gpu)  # its text, for shaders; each view has a block of its own
        self._block = zeros(CloudViewBlock)
        self._stamp: CloudsRevision | None = None
        self._volume: PaperVolume | None = None
        self._volume_for: _VolumeKey | None = None
        self._volumes = gpu.beside(gpu.owner)
        self._layer: CloudLayer | None = None
        self._depth = float(setup.settings["clouds.paper_depth"])
        self._texels = int(setup.settings["clouds.shape_texels"])
        self._view = gpu.fullscreen("clouds/paper/view.frag", {"CLOUD_PAPER": self.year})
        self._blend = gpu.state(blend="premultiplied")

    def release(self) -> None:
        self._volumes.release()
        super().release()

    def _of(self, view: View) -> _View:
        return view.state(self, lambda: _View(self.gpu))

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        block = io.imported(CLOUD_VIEW)

        def run() -> None:
            if self._volume is not None:
                self._volume.texture.use(CLOUD_TILE_UNIT)
            block.value.bind_to_uniform_block(CLOUD_VIEW_BLOCK)

        return run

    def seen_in(self, view: View) -> bool:
        return self._of(view).seen

    def update(self, frame: Frame) -> None:
        component = frame.world.get(frame.planet, Clouds)
        radius = float(frame.world.get(frame.planet, Planet).radius_m)
        layer = self._layer
        own = self._of(frame.view)
        own.seen = layer is not None and may_see(frame, float(layer.top_m))
        if self._volume is not None and not self._volume.done:
            self._volume.step(1e9 if frame.settling else _BUDGET_S)
        turn, _ = frames_at(
            float(blown(component, frame.world.try_get(frame.planet, Wind)).wind_speed_m_s), radius, frame.time_s
        )
        proxy = frame.view.proxy
        block = self._block
        block.turn = turn.T
        if self._volume is not None:
            block.layers[0].extinction_per_m = self._volume.extinction_per_m
        block.broad = CloudVolume(np.mod(turn @ proxy.anchor_m / self._tile_m, 1.0), 1.0 / self._tile_m)
        own.ubo.write(block)

    def refresh(self, frame: Frame) -> None:
        component = frame.world.get(frame.planet, Clouds)
        stamp = CloudsRevision.of(component, frame.world.try_get(frame.planet, Wind))
        if stamp == self._stamp:
            return
        self._stamp = stamp
        component = with_overrides(component, "clouds", frame.settings)
        # The sources have one layer: the first that there is anything in.
        present = [one for one in (component, *component.layers) if one.coverage > 0.0 and one.extinction_per_m > 0.0]
        self._layer = layer = present[0] if present else None
        self._tile_m = float(component.tile_width_m)
        # Without clouds the block keeps a layer that takes nothing: the shadow's contract reads it all the same.
        base, top = (0.0, 1.0) if layer is None else (float(layer.base_m), float(layer.top_m))
        thickness, extinction = top - base, 0.0 if layer is None else float(layer.extinction_per_m)
        parabola = 0.0 if layer is None else float(layer.height_profile == "parabola")
        self._block.surface_shadows = float(component.shadows)
        small = thickness / STEPS
        self._view.set("u_small_step_m", small)
        self._view.set("u_large_step_m", LARGE_STEP * small)
        if self.year == 2019:
            self._view.set("u_shafts", int(component.shafts))
        coverage = float(layer.coverage) if layer is not None and layer.density_model == "weather" else None
        albedo, asymmetry = (0.0, 0.0) if layer is None else (layer.albedo, layer.asymmetry)
        tuned = (SCATTERING, ASYMMETRY) if coverage is not None else (1.0, 1.0)
        self._block.layers[0] = replace(
            zeros(CloudViewLayer), base_m=base, top_m=top, per_thickness=1.0 / thickness, extinction_per_m=extinction,
            albedo=tuned[0] * albedo, asymmetry=tuned[1] * asymmetry, parabola=parabola,
        )  # fmt: skip
        wanted = _VolumeKey(extinction)
        if coverage is not None:
            wanted = _VolumeKey(extinction, coverage, self._tile_m, thickness)
        if wanted != self._volume_for or self._volume is None:
            self._volume_for = wanted
            self._volumes.release()
            self._volumes = self.gpu.beside(self.gpu.owner)
            self._volume = PaperVolume(
                self._volumes, self._texels, coverage, self._tile_m, thickness, LARGE_STEP * small,
                extinction_per_m=extinction, depth=self._depth,
            )  # fmt: skip

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        own = self._of(view.view)
        builder.import_(CLOUD_VIEW, "buffer", help="the layer and its volume around the anchor", lent=own.ubo.buffer)
        if not own.seen:
            return
        builder.add_pass(
            "clouds.march",
            bind=self._bind_view,
            system=self.gpu.owner,
            reads=(CLOUD_VIEW, "gbuffer.depth", *contract_reads(self.world, but=self.gpu.owner)),
            writes=("scene.radiance",),
            stage="clouds",
            help="the printed march through clouds and air, for every pixel",
        )

    def _bind_view(self, io: PassIO) -> Callable[[], None]:
        target, depth = io.framebuffer(colors=("scene.radiance",)), io.texture("gbuffer.depth")
        bind, bind_own = bind_contracts(self.world, io, but=self.gpu.owner), self.bind_contract(io)

        def run() -> None:
            bind()
            bind_own()
            target.use()
            self._blend.apply()
            depth.use(0)
            self._view.render()

        return run

    def settled(self, view: View) -> bool:
        return self._volume is None or self._volume.done

    def refining(self, view: View) -> str:
        return "" if self.settled(view) else f"clouds' tables {100.0 * self.progress(view):.0f} %"

    def progress(self, view: View) -> float:
        return 1.0 if self._volume is None else self._volume.share


class PaperClouds2018(PaperClouds):
    """As Michelic 2018 puts them together."""

    year: ClassVar[int] = 2018
