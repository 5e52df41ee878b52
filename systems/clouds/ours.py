"""OurClouds: weather, noise, and the passes that march clouds and lay them over the picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...components import Atmosphere, Clouds, Planet, Wind
from ...components.wind import blown
from ...engine.blocks.bindings import CLOUD_SHADOW_UNIT, CLOUD_SKY_UNIT, CLOUD_SUN_UNIT, CLOUD_VIEW_BLOCK
from ...engine.frame import Frame, View, ViewInfo, ViewParts
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.frame.published import AIR_GENERATION
from ...engine.gpu import Compute, GpuScope
from ...engine.gpu import gl as G
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from ...engine.settings import SettingError, Settings, with_overrides
from ...engine.system import Setup
from .field import CloudField
from .history import NONE, STILL, History
from .method import CloudMethod, CloudsRevision, may_see
from .model import CloudModel
from .picture import SURFACE, CloudPicture, Surface
from .shadow_pass import SHADOW, SUN, ShadowPass
from .shafts import Shafts
from .shell_probe import march_defines
from .view_block import CLOUD_VIEW, CloudViewBlock, cloud_view_uniforms
from .view_march import DISTANCE, MAPPED, RAYS, UPSAMPLED, MarchSteps, ViewMarch

__all__ = ["OurClouds"]

_FULL = "clouds.full"
_SKY = "clouds.sky"
_SKY_TEXELS = 64
_SKY_FRAMES = 8
"""Over how many frames the map of the sky is drawn while something changes, every eighth row in each: what mirrors it
is rough, and one whole map would cost eight times as much in its frame and let the sea's light step. So would strips:
most of the sea mirrors one of them."""


class ShadowKey(NamedTuple):
    """Which clouds throw a shadow. cuts: of the maps of the weather."""

    clouds: CloudsRevision | None
    cuts: int


class WeatherKey(NamedTuple):
    """Which maps of the weather and of the clouds' shadow a picture was made with, and which air."""

    first: float | None
    second: float | None
    share: float
    air: object
    shadows: int
    drawn: tuple[bool, ...]


class SkyKey(NamedTuple):
    """What the map of clouds in a sky shows. position, sun: as bytes."""

    position: bytes
    sun: bytes
    time_s: float
    clouds: CloudsRevision | None
    steps: MarchSteps | None
    weather: WeatherKey
    mirrored: object


class SkyRows:
    """The map of clouds in one view's sky: what it shows, and which of its rows this frame draws."""

    def __init__(self) -> None:
        self.next, self.left = 0, _SKY_FRAMES
        self.rows = (0, 1)
        """The first, and from one to the next; (0, 0): none."""
        self.shows: SkyKey | None = None

    def begin(self, shows: SkyKey, at_once: bool) -> None:
        """shows: all that the map hangs on. After a change each row is due once."""
        if shows != self.shows:
            self.shows, self.left = shows, _SKY_FRAMES
        if at_once or not self.left:
            self.rows = (0, 1) if self.left else (0, 0)
            self.left = 0
            return
        self.rows = (self.next, _SKY_FRAMES)
        self.next, self.left = (self.next + 1) % _SKY_FRAMES, self.left - 1


class _CloudView(ViewParts):
    """What one view's clouds keep from frame to frame."""

    def __init__(self, of: GpuScope, history: History) -> None:
        super().__init__(of)
        self.ubo = self.gpu.uniform_block(CloudViewBlock, CLOUD_VIEW_BLOCK)
        self.placed = False
        """Whether its block has been written."""
        self.seen = True
        """Whether any of its rays may meet a layer: else none of the pictures' passes is in its graph."""
        self.history = history
        self.sky = SkyRows()
        self.steady = True
        """Whether the weather that its last frame showed was all there."""


class OurClouds(CloudMethod):
    """Clouds by our method.

    Passes: ``clouds.classify`` lists the tiles that may see cloud, ``clouds.march`` follows a ray for each block of
    their pixels, ``clouds.shafts`` takes the light that the air in the clouds' shadow doesn't scatter,
    ``clouds.between`` fills the blocks that had no ray, ``clouds.resolve`` mixes in the frame before, and
    ``clouds.composite`` lays the result over ``scene.radiance``. None runs while no ray can meet a layer.
    """

    contracts: ClassVar[Mapping[str, str]] = {
        "cloud_shadow": "clouds/shadow.glsl",
        "cloud_sky": "clouds/sky.glsl",
        "skylight": "clouds/skylight.glsl",
    }
    reads: ClassVar[tuple[str, ...]] = (CLOUD_VIEW, SHADOW, _SKY)

    def __init__(self, gpu: GpuScope, setup: Setup) -> None:
        super().__init__(gpu, setup)
        settings, self._views = setup.settings, setup.views
        self._samples = int(settings["clouds.samples"])
        # Where each pixel has a ray, nothing would smooth over the squares.
        self._every = int(settings["clouds.march_every"]) if int(settings["clouds.stride"]) > 1 else 1
        picture = self._picture = CloudPicture.of(settings)
        self._steps: MarchSteps | None = None
        cloud_view_uniforms(gpu)  # its text, for shaders; each view has a block of its own
        self.field = CloudField(gpu, settings)
        self._view = ViewMarch(gpu, setup.world, self.gpu.owner, picture)
        self._defines: Mapping[str, Any] = {}
        self._sky_march: Compute
        self._tune(settings)
        self._resolve = gpu.compute("clouds/resolve.comp", picture.defines)
        self._surface = Surface(gpu, picture)
        self._validity: Compute | None = None
        self._over = gpu.fullscreen("clouds/composite.frag", {"PICTURE_PX": picture.pixel_px})
        self._held_over = self._over
        if picture.pixel_px == 1:  # else it looks for what ends where its pixels do anyway
            self._held_over = gpu.fullscreen("clouds/composite.frag", {"PICTURE_PX": 1, "HELD": 1})
        # Of a coarser picture single texels are looked up, and resolve wants it linear.
        self._nearest = gpu.sampler(filter="nearest")
        self._plain = gpu.state()
        self._radius_m = float(setup.world.get(setup.planet, Planet).radius_m)
        texels, steps = int(settings["clouds.shadow_texels"]), int(settings["clouds.shadow_steps"])
        self.shadow = ShadowPass(gpu, texels, steps, int(settings["clouds.shadow_frames"]))
        self._shafts = Shafts(gpu, setup.world, picture.defines, settings, self.gpu.owner)
        self._with_shafts = True
        self._stamp: CloudsRevision | None = None

    def release(self) -> None:
        self._views.forget(self.shadow, self._shafts)
        super().release()

    def _tune(self, settings: Settings) -> None:
        """Knobs that may change while it runs."""
        steps = MarchSteps.of(settings)
        if steps != self._steps:
            self._steps = steps
            defines = march_defines(settings)
            self._view.tune(steps, defines)
            if defines != self._defines:  # how fine steps are is in part compiled in
                if self._defines:
                    self.gpu.free(self._sky_march)
                self._defines, self._sky_march = defines, self.gpu.compute("clouds/sky.comp", {**defines, **MAPPED})
            MarchSteps(0.5 * steps.layer, 3.0 * steps.growth, min(steps.sun, 3.0)).give(self._sky_march)

    def _of(self, view: View) -> _CloudView:
        return view.state(self, lambda: _CloudView(self.gpu, self._history()))

    def _history(self) -> History:
        return History(self._picture.stride, self._samples, self._radius_m, self._every)

    # -- contracts ---------------------------------------------------------------------------------------------------

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        texture, sky, block = io.texture(SHADOW), io.texture(_SKY), io.imported(CLOUD_VIEW)

        def run() -> None:
            texture.use(CLOUD_SHADOW_UNIT)
            sky.use(CLOUD_SKY_UNIT)
            block.value.bind_to_uniform_block(CLOUD_VIEW_BLOCK)

        return run

    # -- frame -------------------------------------------------------------------------------------------------------

    def refresh(self, frame: Frame) -> None:
        component = frame.world.get(frame.planet, Clouds)
        wind = frame.world.try_get(frame.planet, Wind)
        stamp = CloudsRevision.of(component, wind)
        if stamp == self._stamp:
            return
        self._stamp = stamp
        component = blown(with_overrides(component, "clouds", frame.settings), wind)
        try:
            self.field.take(component)
        except ValueError as error:
            # Once: the next frames go on with the weather as it was, until something is changed again.
            if not self.field.placed:
                self._stamp = None  # there is none
            raise SettingError(str(error)) from error
        air = frame.world.try_get(frame.planet, Atmosphere)
        self.field.light(CloudModel.from_components(frame.world.get(frame.planet, Planet), component, air))
        if self._with_shafts != bool(component.shafts):
            self._with_shafts = not self._with_shafts
            self.structure += 1
        self.shadow.take_layers(self.field.block, self.field.layers)

    def update(self, frame: Frame) -> None:
        self.moving = None
        self._tune(frame.settings)
        field = self.field
        radius = self._radius_m = frame.world.get(frame.planet, Planet).radius_m
        seen = bool(field.layers) and may_see(frame, field.block.highest_m) and frame.view.seen.planet()
        shown, shadow = self._of(frame.view), self.shadow.of(frame.view)
        if seen != shown.seen:
            shown.seen, shown.history = seen, self._history()
        if not frame.view.seen.planet() and shown.placed:
            return  # nothing of it is asked for
        charts = field.maps.charts
        if frame.settling or frame.one_shot:
            charts.exact(frame.time_s)
        else:
            charts.running(frame.time_s)
        shown.steady = charts.steady
        self.moving = not charts.steady
        proxy = frame.view.proxy
        field.place(proxy.anchor_m, radius, frame.time_s)
        present = bool(field.layers)
        stamp = ShadowKey(self._stamp, charts.cuts)
        self.shadow.place(frame, field.block, field.first, field.wind_m_s, stamp, radius, present, charts.steady)
        self._shafts.place(frame, field.block.highest_m, field.first[1], radius, shadow)
        shown.ubo.write(field.block)
        shown.placed = True
        # Rays that were followed through another air, such as that of its first small tables, are none of this picture.
        air = frame.world.try_resource(AIR_GENERATION)
        shares = charts.first.number, charts.second.number, charts.share
        weather = WeatherKey(*shares, air, shadow.maps.changes, tuple(shadow.drawn))
        shown.history.begin(frame, self._stamp, weather, weather.drawn)
        place = (frame.camera.position_m.tobytes(), frame.sun.direction.tobytes(), frame.time_s)
        shows = SkyKey(*place, self._stamp, self._steps, weather, self.field.mirrored)
        shown.sky.begin(shows, frame.cut or frame.one_shot or frame.settling)

    def seen_in(self, view: View) -> bool:
        return self._of(view).seen

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        own = self._of(view.view)
        builder.import_(CLOUD_VIEW, "buffer", help="layers, noise and weather around the anchor", lent=own.ubo.buffer)
        bind_clouds = partial(self.bind_density, view.view)
        self.shadow.declare(builder, view, self.gpu.owner, bind_clouds, view.view.seen.planet)
        air = contract_reads(self.world, but=self.gpu.owner)
        builder.add_pass(
            "clouds.sky",
            kind="compute",
            bind=lambda io: self._bind_sky(io, own, bind_clouds),
            system=self.gpu.owner,
            reads=(CLOUD_VIEW, SUN, *air),
            creates=(
                TextureSpec(
                    _SKY, "rgba32f", (_SKY_TEXELS, _SKY_TEXELS), "persistent", filter="linear",
                    help="clouds over the camera, for what mirrors the sky",
                ),
            ),
            when=lambda: own.sky.rows[1] > 0 and self.field.mirrored and bool(self.field.layers),
            only_while=view.view.seen.planet,
            help="a small map of the clouds in the sky, a few rows a frame",
        )  # fmt: skip
        if not own.seen:
            return

        def history() -> History:
            return own.history

        copied, depth = self._surface.declare(builder, view, self.gpu.owner), self._picture.depth
        self._view.declare(builder, view, history, bind_clouds)
        size = self._picture.size(view.size)
        if self._with_shafts:
            self._shafts.declare(builder, view.view, RAYS, self._picture.rays(view.size), DISTANCE, depth, history)
        upsampled = (UPSAMPLED,) if self._every == 2 else ()
        if upsampled:
            self._view.declare_between(builder, view, history)
        builder.add_pass(
            "clouds.resolve",
            kind="compute",
            bind=lambda io: self._bind_full(io, own),
            system=self.gpu.owner,
            reads=(depth, RAYS, DISTANCE, *upsampled),
            after=("clouds.march",),
            after_optional=("clouds.shafts", "clouds.between"),
            writes=() if copied else (SURFACE,),  # while the last frame's clouds go on being shown
            history=(_FULL, SURFACE),
            creates=(
                TextureSpec(_FULL, "rgba32f", size, "history", filter="linear", help="clouds of every pixel of theirs"),
                *copied,
            ),
            help="clouds of every pixel, from this frame's rays and the last frame",
        )
        builder.add_pass(
            "clouds.debug_history",
            kind="compute",
            bind=lambda io: self._bind_history(io, own),
            system=self.gpu.owner,
            reads=(depth, RAYS, DISTANCE, *upsampled),
            after=("clouds.resolve",),
            history=(_FULL, SURFACE),
            creates=(TextureSpec("debug.cloud_history", "rgba8", size, help="green: what the last frame showed"),),
            help="which pixels take their clouds over from the last frame",
        )
        builder.add_pass(
            "clouds.composite",
            bind=lambda io: self._bind_composite(io, own),
            system=self.gpu.owner,
            reads=(_FULL, "gbuffer.depth", SURFACE),
            writes=("scene.radiance",),
            stage="clouds",
            help="clouds over the picture",
        )

    def _bind_sky(self, io: PassIO, view: _CloudView, bind_clouds: Callable[[], None]) -> Callable[[], None]:
        texture, sun = io.texture(_SKY), io.texture(SUN)
        bind = bind_contracts(self.world, io, but=self.gpu.owner)
        view.sky = SkyRows()  # all of it, whatever this frame was to draw

        def run() -> None:
            bind()
            bind_clouds()
            sun.use(CLOUD_SUN_UNIT)
            texture.bind_to_image(0, read=False, write=True)
            first, step = view.sky.rows if view.sky.rows[1] else (0, 1)  # a reloaded shader runs whatever is due
            self._sky_march.set("u_first_row", first)
            self._sky_march.set("u_row_step", step)
            self._sky_march.run_over(_SKY_TEXELS, _SKY_TEXELS // step)

        return run

    def bind_density(self, view: View) -> None:
        """Bind what clouds/weather_march.glsl reads, for the clouds of that view's last frame."""
        self._of(view).ubo.bind()
        self.field.bind()

    def _bind_history(self, io: PassIO, own: _CloudView) -> Callable[[], None]:
        if self._validity is None:
            self._validity = self.gpu.compute("clouds/resolve.comp", {**self._picture.defines, "VALIDITY": 1})
        return self._bind_resolve(io, own, "debug.cloud_history", self._validity)

    def _bind_full(self, io: PassIO, own: _CloudView) -> Callable[[], None]:
        resolve, keep = self._bind_resolve(io, own, _FULL, self._resolve), self._surface.bind_copy(io)
        before, full, hold = io.history(_FULL), io.texture(_FULL), self._surface.bind_hold(io)
        gl, valid = self.gpu.gl, io.history_valid

        def run() -> None:
            if own.history.held and valid.value:
                gl.copy_layers(G.TEXTURE_2D, before.glo, 0, full.glo, 0, (*full.size, 1))
                hold()
            else:
                resolve()
                keep()

        return run

    def _bind_resolve(self, io: PassIO, own: _CloudView, into: str, shown: Compute) -> Callable[[], None]:
        made = io.texture(into)
        textures = [io.texture(name) for name in (RAYS, self._picture.depth, DISTANCE)]
        upsampled = io.texture(UPSAMPLED) if self._every == 2 else textures[0]
        before, surface, valid = io.history(_FULL), io.history(SURFACE), io.history_valid

        def run() -> None:
            history = own.history
            if not valid.value and history.mode != NONE:
                history.lost()
            made.bind_to_image(0, read=False, write=True)
            for unit, texture in enumerate(textures):
                texture.use(unit)
            before.use(3)
            before.use(6)
            self._nearest.use(6)
            surface.use(4)
            (textures[0] if history.checkerboard < 0 else upsampled).use(5)
            if shown is self._resolve:  # the picture of validity is none of light
                shown.set("u_weight", history.weight)
            shown.set("u_mode", history.mode)
            shown.set("u_place", (-1, -1) if history.skip else history.place)
            shown.set("u_checkerboard", history.checkerboard)
            # GLSL reads matrices column by column: the transpose of the row order of numpy.
            shown.set("u_to_previous", np.ascontiguousarray(history.turn.T, np.float32))
            shown.set("u_camera_shift_m", tuple(map(float, history.shift_m)))
            shown.set("u_previous_per_scale", history.projection[:2])
            shown.set("u_previous_offset", history.projection[2:])
            shown.set("u_offset", history.offset)
            shown.set("u_wider", history.wider)
            # Pixels before the first rays are another cell's.
            shown.run_over(textures[0].width + 1, textures[0].height + 1)
            self._nearest.clear(6)

        return run

    def _bind_composite(self, io: PassIO, own: _CloudView) -> Callable[[], None]:
        target = io.framebuffer(colors=("scene.radiance",))
        textures = [io.texture(name) for name in (_FULL, "scene.radiance", "gbuffer.depth", SURFACE)]
        gl, waits = self.gpu.gl, self.gpu.caps.has_texture_barrier

        def run() -> None:
            target.use()
            self._plain.apply()
            for unit, texture in enumerate(textures):
                texture.use(unit)
            # Drawn, not stored from compute: without a GPU a store takes several times as long. Each pixel reads what
            # it draws over, which OpenGL 4.5 allows behind this; older drivers wait where a framebuffer is bound.
            if waits:
                gl.texture_barrier()
            self._nearest.use(0)
            (self._held_over if own.history.held else self._over).render()
            self._nearest.clear(0)

        return run

    def settled(self, view: View) -> bool:
        """Whether every pixel of a still picture has had its own ray, and no map of shadow or weather is due."""
        own = self._of(view)
        return not own.seen or (own.history.complete and not self.shadow.of(view).busy and own.steady)

    def refining(self, view: View) -> str:
        own = self._of(view)
        if not own.seen:
            return ""
        if not own.steady:
            return "weather"
        if not self.shadow.of(view).complete:
            return "cloud shadows"
        history = own.history
        gathers = history.mode == STILL and not history.complete
        return f"clouds {100.0 * history.share:.0f} %" if gathers else ""

    def progress(self, view: View) -> float:
        """Share of the pixels of a still picture that have had their rays."""
        own = self._of(view)
        return own.history.share if own.seen else 1.0
