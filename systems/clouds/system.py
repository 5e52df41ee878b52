"""CloudSystem: weather, noise, and the passes that march clouds and lay them over the picture."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np

from ...components import Clouds, Planet
from ...engine.contracts import bind_contracts, contract_reads, provide_contracts, withdraw_contracts
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from ...engine.settings import revision, with_overrides
from ...engine.space import frustum_planes, sphere_outside
from ...engine.system import Frame, Setup, System, ViewInfo
from .layers import BILLOWS, frames_at, kind_of, layers_of, write_filter, write_layers, write_noise
from .maps import BORDER, WeatherMaps
from .shadow import ShadowMaps
from .view_block import CLOUD_VIEW_BINDING, MOST_MAPS, CloudViewBlock
from .volumes import make_volume
from .weather import moment_of

__all__ = ["CloudSystem"]

_SHAPE, _RIMS = 0, 1
_COLOR, _DISTANCE, _SHADOW = "clouds.color", "clouds.distance", "clouds.shadow"
_SHADOW_UNIT = 15
_SHADOW_HEIGHT = 0.3
"""Share of the first layer's thickness at which maps of the shadow are drawn."""


class CloudSystem(System):
    """The clouds of one planet. Needs Planet and Clouds.

    Passes: ``clouds.march`` follows a ray for each block of pixels, ``clouds.composite`` lays the result over
    ``scene.radiance``. Neither runs while no ray can meet a layer.
    """

    name: ClassVar[str] = "clouds"
    needs: ClassVar[tuple[type, ...]] = (Planet, Clouds)

    def setup(self, setup: Setup) -> None:
        self._gpu, self._world = setup.gpu, setup.world
        settings = setup.settings
        self._stride = int(settings["clouds.stride"])
        self._steps = (float(settings["clouds.fine_steps"]), float(settings["clouds.step_growth"]))
        self._sun_steps = float(settings["clouds.sun_steps"])
        gpu = setup.gpu
        self._ubo = gpu.uniform_block(CloudViewBlock, CLOUD_VIEW_BINDING, "cloud_view")
        self._block = CloudViewBlock()
        self._shape = make_volume(gpu, _SHAPE, int(settings["clouds.shape_texels"]))
        self._rims = make_volume(gpu, _RIMS, int(settings["clouds.rim_texels"]))
        write_filter(self._block, self._shape, self._rims)
        self._maps = WeatherMaps(gpu, int(settings["clouds.map_texels"]), 1)
        defines = {"STRIDE": self._stride}
        self._march = gpu.compute("clouds/view_march.comp", defines)
        self._over = gpu.fullscreen("clouds/composite.frag", defines)
        self._cast = gpu.compute("clouds/shadow.comp")
        self._cast.set("u_steps", int(settings["clouds.shadow_steps"]))
        self._shadow_texels = int(settings["clouds.shadow_texels"])
        self._shadows: dict[int, ShadowMaps] = {}
        self._due: list[int] = []
        self._blend = gpu.gpu.state(blend="premultiplied")
        self._stamp: tuple[Any, ...] = ()
        self._layers: list[Any] = []
        self._seen = True
        self._textures: tuple[Any, Any] = (None, None)
        gpu.gpu.shaders.provide("cloud_shadow", "clouds/shadow.glsl", owner=self.name)
        provide_contracts(setup.world, self.name, self)

    def release(self) -> None:
        self._shadows.clear()
        self._gpu.gpu.shaders.withdraw(self.name)
        withdraw_contracts(self._world, self.name)

    # -- contracts ---------------------------------------------------------------------------------------------------

    def contract_reads(self) -> tuple[str, ...]:
        """See engine.contracts.ContractSource."""
        return (_SHADOW,)

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.contracts.ContractSource."""
        texture = io.texture(_SHADOW)

        def run() -> None:
            texture.use(_SHADOW_UNIT)
            self._ubo.bind()

        return run

    # -- frame -------------------------------------------------------------------------------------------------------

    def _refresh(self, frame: Frame) -> None:
        component = frame.world.get(frame.planet, Clouds)
        stamp = (id(component), revision(component), *(revision(layer) for layer in component.layers))
        if stamp == self._stamp:
            return
        self._stamp = stamp
        component = with_overrides(component, "clouds", frame.settings)
        self._layers = layers_of(component)
        billows = [layer for layer in self._layers if kind_of(layer) == BILLOWS]
        self._wind_m_s = float(component.wind_speed_m_s)
        first = billows[0] if billows else component
        self._thickness_m = float(first.top_m - first.base_m)
        coverage = float(first.coverage) or 0.6
        self._maps.balance(coverage)
        write_layers(self._block, self._layers, coverage)
        self._reference_m = float(first.base_m) + _SHADOW_HEIGHT * self._thickness_m

    def update(self, frame: Frame) -> None:
        self._refresh(frame)
        radius = frame.world.get(frame.planet, Planet).radius_m
        centre, reach = -frame.camera.position_m, radius + self._block.counts[2]
        self._seen = not bool(sphere_outside(frustum_planes(frame.camera), centre[None], [reach])[0])
        self._seen = self._seen and bool(self._layers)
        moment = moment_of(frame.time_s)
        self._textures = self._maps.want(moment)
        turn, tilt = frames_at(self._wind_m_s, radius, frame.time_s)
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        write_noise(
            self._block, turn, tilt, proxy.anchor_m, self._thickness_m,
            self._shape.texture.size[0], self._rims.texture.size[0],
        )  # fmt: skip
        texel_m = radius * np.sqrt(4.0 * np.pi) / self._maps.size
        self._block.weather = (moment.share, self._maps.size, BORDER, texel_m)
        self._place_shadows(frame, radius, proxy)
        self._ubo.write(self._block)
        self._ubo.bind()
        x, y = frame.jitter_px
        # A pattern of its own for each of the picture's samples, and the same whenever that sample is drawn.
        shift = (0.5 + 17.17 * x + 31.71 * y) % 1.0
        self._march.set("u_march", (*self._steps, shift, self._sun_steps))

    def _place_shadows(self, frame: Frame, radius: float, proxy: Any) -> None:
        maps = self._shadows.setdefault(frame.view_index, ShadowMaps(self._shadow_texels))
        maps.place(radius, self._thickness_m)
        foot = frame.camera.position_m / np.linalg.norm(frame.camera.position_m)
        if frame.cut:
            maps.forget()
            maps.place(radius, self._thickness_m)
        due = maps.due(foot, frame.sun.direction, frame.time_s, self._wind_m_s, self._stamp, radius)
        fresh = [number for number in due if maps.maps[number].stamp != self._stamp]
        # One a frame, the finest that is due; what has nothing to show yet, at once.
        self._due = due if frame.settling or frame.one_shot else sorted({*fresh, *due[:1]})
        for number in self._due:
            maps.move(number, foot, frame.sun.direction, frame.time_s, self._stamp, radius)
        rows = np.zeros((3, MOST_MAPS, 4))
        anchor_foot = proxy.lattice.direction * radius
        for number, held in enumerate(maps.maps):
            rows[0, number] = *(anchor_foot - held.middle), 1.0 / held.half_m
            rows[1, number, :3], rows[2, number, :3] = held.u, held.v
        block = self._block
        block.shadow = (self._reference_m, len(maps.maps) if self._layers else 0, 0.0, 0.0)
        block.shadow_from, block.shadow_u, block.shadow_v = rows
        self._middles = [
            (*(held.middle * (1.0 + self._reference_m / radius) - proxy.anchor_m), held.half_m) for held in maps.maps
        ]
        self._ups = [(*(held.middle / radius), 0.0) for held in maps.maps]

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        side = (self._shadow_texels, self._shadow_texels)
        builder.add_pass(
            "clouds.shadow",
            kind="compute",
            bind=lambda io: self._bind_shadow(io, view.index),
            system=self.name,
            creates=(
                TextureSpec(
                    _SHADOW, "rg16f", side, "persistent", layers=MOST_MAPS, filter="linear",
                    help="share of the sunlight that comes through the clouds: the beam, and all of it",
                ),
            ),
            when=lambda: bool(self._due) and bool(self._layers),
            help="the clouds' shadow around the camera",
        )  # fmt: skip
        reads = ("gbuffer.depth", *contract_reads(self._world))
        size = tuple(-(-n // self._stride) for n in view.size)
        builder.add_pass(
            "clouds.march",
            kind="compute",
            bind=self._bind_march,
            system=self.name,
            reads=reads,
            creates=(
                TextureSpec(_COLOR, "rgba32f", size, "persistent", help="light of clouds, and what they leave"),
                TextureSpec(_DISTANCE, "r32f", size, "persistent", help="mean distance of the clouds"),
            ),
            when=lambda: self._seen,
            help="clouds along one ray of each block of pixels",
        )
        builder.add_pass(
            "clouds.composite",
            bind=self._bind_composite,
            system=self.name,
            reads=("gbuffer.depth", _COLOR, _DISTANCE),
            writes=("scene.radiance",),
            after=("sky.shade",),
            after_optional=("terrain.shade", "ocean.shade", "props.shade", "stars.draw"),
            when=lambda: self._seen,
            help="clouds over the picture",
        )

    def _bind_shadow(self, io: PassIO, view: int) -> Callable[[], None]:
        texture = io.texture(_SHADOW)
        if view in self._shadows:
            self._shadows[view].forget()

        def run() -> None:
            self._ubo.bind()
            self._bind_noise()
            texture.bind_to_image(0, read=False, write=True)
            for number in self._due:
                self._cast.set("u_level", number)
                self._cast.set("u_middle", self._middles[number])
                self._cast.set("u_up", self._ups[number])
                self._cast.run_over(*texture.size[:2])

        return run

    def _bind_noise(self) -> None:
        self._shape.texture.use(0)
        self._rims.texture.use(1)
        self._textures[0].use(2)
        self._textures[1].use(3)

    def _bind_march(self, io: PassIO) -> Callable[[], None]:
        color, distance = io.texture(_COLOR), io.texture(_DISTANCE)
        depth = io.texture("gbuffer.depth")
        bind = bind_contracts(self._world, io)

        def run() -> None:
            bind()
            self._ubo.bind()
            depth.use(4)
            self._bind_noise()
            color.bind_to_image(0, read=False, write=True)
            distance.bind_to_image(1, read=False, write=True)
            self._march.set("u_place", (self._stride // 2, self._stride // 2))
            self._march.run_over(*color.size)

        return run

    def _bind_composite(self, io: PassIO) -> Callable[[], None]:
        target = io.framebuffer(colors=("scene.radiance",))
        color, distance, depth = (io.texture(name) for name in (_COLOR, _DISTANCE, "gbuffer.depth"))

        def run() -> None:
            target.use()
            self._blend.apply()
            color.use(0)
            depth.use(1)
            distance.use(2)
            self._over.set("u_place", (self._stride // 2, self._stride // 2))
            self._over.render()

        return run
