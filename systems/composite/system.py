"""CompositeSystem: exposure, anti-aliasing, glare, tone map and dither, from scene.radiance to composite.ldr."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, TypeVar

import moderngl
import numpy as np

from ...components import Composite, Exposure
from ...engine.blocks.bindings import EXPOSURE_BUFFER
from ...engine.frame import Frame, View, ViewInfo
from ...engine.gpu import Fullscreen
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.settings import Settings, with_overrides
from ...engine.system import Setup, System
from ...engine.world import World
from .finish import GLARE_FALL, GLARE_ROWS, glare_levels
from .resolve import Resolver
from .tone_maps import TONE_MAPS

__all__ = ["CompositeSystem", "ExposureReading", "adaptation_share", "read_exposure"]

T = TypeVar("T")

_BINS = 512
_GLARE = "rgba32f"
"""Not half floats: a sun would have to be clipped, and they are no faster here (llvmpipe)."""
_DARK_ADAPTATION = 1.0
_SETTLED_EV = 1e-3


class _PictureKey(NamedTuple):
    """The defines of composite/tonemap.frag."""

    tone_map: int
    dither: bool
    glare: bool
    resolved: bool


@dataclass(frozen=True)
class ExposureReading:
    """What the exposure of a frame came to. metered_cd_m2: mean luminance of what is lit (in auto mode only)."""

    ev100: float
    target_ev100: float
    metered_cd_m2: float


def read_exposure(buffer: moderngl.Buffer) -> ExposureReading:
    """Read the resource "composite.exposure" back; waits for the GPU."""
    ev100, target, metered, _ = np.frombuffer(buffer.read(16), np.float32)
    return ExposureReading(float(ev100), float(target), float(2.0 ** np.float64(metered)))


def adaptation_share(dt_s: float, time_s: float) -> float:
    """Share of the way to the target that dt_s brings when time_s is the time for 95 % of it; 1 for time_s = 0."""
    return 1.0 if time_s <= 0.0 else float(-np.expm1(-3.0 * max(dt_s, 0.0) / time_s))


@dataclass
class _Exposed:
    """One view's exposure. latest: of its last frame; None: that had none, or there was none. auto: it is measured.
    limits_ev: of its frame. go: shares of the way that it goes in it, to brighter and to darker pictures."""

    latest: moderngl.Buffer | None = None
    auto: bool = False
    limits_ev: tuple[float, float] = (0.0, 0.0)
    compensation_ev: float = 0.0
    go: tuple[float, float] = (1.0, 1.0)


class CompositeSystem(System):
    """Always active; the components Exposure and Composite say how, their defaults hold without them."""

    name: ClassVar[str] = "composite"
    _start: bytes | None = None
    """The exposure that the next frame without history begins with."""

    def setup(self, setup: Setup) -> None:
        self._gpu = gpu = setup.gpu
        self._reduce = gpu.fullscreen("composite/reduce.frag")
        self._meter = gpu.compute("composite/meter.comp")
        self._meter.set("u_dark_adaptation", _DARK_ADAPTATION)
        self._histogram = gpu.buffer(np.zeros(1 + _BINS, np.uint32))
        self._source = gpu.fullscreen("composite/glare_source.frag")
        self._down = gpu.fullscreen("composite/glare_down.frag")
        self._up = gpu.fullscreen("composite/glare_up.frag")
        self._sum = gpu.fullscreen("composite/glare_sum.frag")
        self._plain = gpu.state()
        self._add = gpu.state(blend="additive")
        self._pictures: dict[_PictureKey, Fullscreen] = {}
        self._views, self._resolver = setup.views, Resolver(gpu, setup.views)
        self._glares = False
        self._choose_picture(setup.world, setup.settings)

    def release(self) -> None:
        self._pictures.clear()
        self._views.forget(self, self._resolver)

    def settled(self, view: View) -> bool:
        """Whether every sample of a still picture is in it and the exposure has come to where it wants to go; waits for
        the GPU in automatic mode."""
        own = self._exposed(view)
        if own.latest is None:
            return True
        if not self._resolver.settled(view):
            return False
        if not own.auto:
            return True
        reading = self.reading(view)
        return abs(reading.ev100 - reading.target_ev100) < _SETTLED_EV

    def progress(self, view: View) -> float:
        """Share of the samples of a still picture."""
        return self._resolver.share(view) if self.exposed(view) else 1.0

    def refining(self, view: View) -> str:
        return self._resolver.refining(view) if self.exposed(view) else ""

    def _exposed(self, view: View) -> _Exposed:
        return view.state(self, _Exposed)

    def exposed(self, view: View) -> bool:
        """Whether that view's last frame was exposed; frames of which nobody wants colours are not."""
        return self._exposed(view).latest is not None

    def reading(self, view: View) -> ExposureReading:
        """The exposure of that view's last frame; waits for the GPU. RuntimeError where none was exposed."""
        return read_exposure(self._buffer(view))

    def reading_bytes(self, view: View) -> bytes:
        """As `reading`, for another system's `go_on_from`."""
        return self._buffer(view).read(16)

    def _buffer(self, view: View) -> moderngl.Buffer:
        latest = self._exposed(view).latest
        if latest is None:
            raise RuntimeError("the last frame was not exposed: render one with its colours first")
        return latest

    def go_on_from(self, exposure: bytes) -> None:
        """The next frame, a cut, adapts from another system's exposure instead of jumping."""
        self._start = exposure

    def begin(self, frame: Frame) -> None:
        composite = with_overrides(_first(frame.world, Composite), "composite", frame.settings)
        if self._resolver.use(composite.antialiasing):
            self.structure += 1
        self._resolver.begin(frame)

    def update(self, frame: Frame) -> None:
        self._resolver.update(frame)
        own, ev100 = self._exposed(frame.view), frame.ev100
        exposure = with_overrides(_first(frame.world, Exposure), "exposure", frame.settings)
        own.auto = exposure.mode == "auto" and ev100 is None
        stay = exposure.ev100 if ev100 is None else ev100
        low, high = (exposure.min_ev100, exposure.max_ev100) if own.auto else (stay, stay)
        own.limits_ev = float(low), max(float(low), float(high))
        own.compensation_ev = float(exposure.compensation_ev) if own.auto else 0.0
        own.go = adaptation_share(frame.dt_s, exposure.brighter_s), adaptation_share(frame.dt_s, exposure.darker_s)
        self._choose_picture(frame.world, frame.settings)

    def _choose_picture(self, world: World, settings: Settings) -> None:
        composite = with_overrides(_first(world, Composite), "composite", settings)
        self._share = float(composite.bloom)
        if (self._share > 0.0) != self._glares:
            self._glares = self._share > 0.0
            self.structure += 1
        tone_map = TONE_MAPS.index(composite.tone_map)
        key = _PictureKey(tone_map, bool(composite.dither), self._glares, self._resolver.active)
        if key not in self._pictures:
            defines = {name.upper(): int(value) for name, value in key._asdict().items()}
            self._pictures[key] = self._gpu.fullscreen("composite/tonemap.frag", defines=defines)
        self._picture = self._pictures[key]

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        own = self._exposed(view.view)
        own.latest = None  # belongs to the plan from before, and the new one may do without
        levels, glares = glare_levels(view.size[1]), self._glares
        builder.add_pass(
            "composite.reduce",
            bind=self._bind_reduce,
            system=self.name,
            reads=("scene.radiance",),
            when=lambda: own.auto or glares,
            creates=(TextureSpec("composite.quarter", "rgba32f", 0.25, "persistent", help="mean of 4 x 4 pixels"),),
            help="the scene at a quarter of its size, for metering and glare",
        )
        builder.add_pass(
            "composite.expose",
            bind=lambda io: self._bind_expose(io, view.view, own),
            system=self.name,
            kind="compute",
            reads=("composite.quarter",),
            history=("composite.exposure",),
            creates=(BufferSpec("composite.exposure", 16, "history", help="EV100, its target, log2 luminance, white"),),
            help="exposure of the frame: measured and followed slowly, or fixed",
        )
        picture = self._resolver.declare(builder, view)
        if glares:
            octaves = [f"composite.glare{k}" for k in range(levels + 1)]
            builder.add_pass(
                "composite.glare",
                bind=lambda io: self._bind_glare(io, octaves),
                system=self.name,
                reads=("composite.quarter", "composite.exposure"),
                creates=(
                    TextureSpec("composite.glare", _GLARE, 0.25, "persistent", filter="linear", help="exposed glare"),
                    *(
                        TextureSpec(name, _GLARE, 0.25 * 0.5**k, "persistent", filter="linear", help="octave of glare")
                        for k, name in enumerate(octaves)
                    ),
                ),
                help="light that a lens or an eye scatters, in octaves of equal energy",
            )
        builder.add_pass(
            "composite.tonemap",
            bind=lambda io: self._bind_tonemap(io, levels, picture, view.view),
            system=self.name,
            reads=(picture, "composite.exposure", *(("composite.glare",) if glares else ())),
            creates=(TextureSpec("composite.ldr", "rgba8", filter="linear", help="the picture, sRGB-encoded"),),
            help="exposed, tone-mapped and dithered picture",
        )

    def _bind_reduce(self, io: PassIO) -> Callable[[], None]:
        target = io.framebuffer(colors=("composite.quarter",))
        scene = io.texture("scene.radiance")

        def run() -> None:
            target.use()
            self._plain.apply()
            scene.use(0)
            self._reduce.render()

        return run

    def _bind_expose(self, io: PassIO, view: View, own: _Exposed) -> Callable[[], None]:
        quarter, now = io.texture("composite.quarter"), io.buffer("composite.exposure")
        before, valid = io.history("composite.exposure"), io.history_valid
        width, height = io.resource_size("composite.quarter")

        def run() -> None:
            own.latest = now
            quarter.use(0)
            self._histogram.bind_to_storage_buffer(5)
            now.bind_to_storage_buffer(6)
            before.bind_to_storage_buffer(7)
            has_history = valid.value and not view.frame.cut and own.auto
            if self._start is not None and own.auto:
                before.write(self._start)
                has_history, self._start = True, None
            self._meter.set("u_has_history", int(has_history))
            self._meter.set("u_go_brighter", own.go[0])
            self._meter.set("u_go_darker", own.go[1])
            self._meter.set("u_ev100", own.limits_ev)
            self._meter.set("u_compensation_ev", own.compensation_ev)
            if own.auto:
                self._meter.run_over(width, height)
            else:
                self._meter.run(1)  # the limits alone decide

        return run

    def _bind_glare(self, io: PassIO, names: list[str]) -> Callable[[], None]:
        targets = [io.framebuffer(colors=(name,)) for name in names]
        textures = [io.texture(name) for name in names]
        quarter, exposure = io.texture("composite.quarter"), io.buffer("composite.exposure")
        downs = list(zip(targets[1:], textures[:-1], strict=True))
        ups = list(zip(targets[:-1], textures[1:], strict=True))[::-1]
        coarse = ups[:-1]  # the source stays as it is: the sum blurs it on its own
        total = io.framebuffer(colors=("composite.glare",))
        self._up.set("u_share", GLARE_FALL)
        self._sum.set("u_share", GLARE_FALL)

        def run() -> None:
            exposure.bind_to_storage_buffer(EXPOSURE_BUFFER)
            quarter.use(0)
            targets[0].use()
            self._plain.apply()
            self._source.render()
            for target, texture in downs:
                target.use()
                texture.use(0)
                self._down.render()
            self._add.apply()
            for target, texture in coarse:
                target.use()
                texture.use(0)
                self._up.render()
            total.use()
            self._plain.apply()
            textures[0].use(0)
            textures[1].use(1)
            self._sum.render()

        return run

    def _bind_tonemap(self, io: PassIO, levels: int, picture: str, view: View) -> Callable[[], None]:
        target = io.framebuffer(colors=("composite.ldr",))
        scene, exposure = io.texture(picture), io.buffer("composite.exposure")
        glare = io.texture("composite.glare") if self._glares else None
        finest = (1.0 - GLARE_FALL) * io.size[1] / GLARE_ROWS
        total = finest * (1.0 - GLARE_FALL ** (levels + 1)) / (1.0 - GLARE_FALL)

        def run() -> None:
            target.use()
            self._plain.apply()
            scene.use(0)
            exposure.bind_to_storage_buffer(EXPOSURE_BUFFER)
            if glare is not None:
                glare.use(1)
                share = min(self._share, 0.5 / total)
                self._picture.set("u_glare_share", share * finest)
                self._picture.set("u_kept_share", 1.0 - share * total)
                self._picture.set("u_glare_from", self._resolver.shift(view))
            self._picture.render()

        return run


def _first(world: World, kind: type[T]) -> T:
    found = world.query(kind)
    return found[0][1][0] if found else kind()
