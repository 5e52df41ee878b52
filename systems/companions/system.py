"""CompanionsSystem: puts pictures of other planets together, and makes such a picture where it is asked for one.

Every planet is drawn by the systems of its own scene. In the view that its camera is on, this system asks a source for
pictures of the other planets that are in sight, before anything of the view is drawn, and lays them over one another,
the farthest first. In the view of such a picture it takes what was drawn off the scene's radiance, with how much of
what lies behind can be seen through it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

import moderngl

from ...engine.frame import Frame, View, ViewInfo
from ...engine.frame.backdrop import LIGHT, SOURCE
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from ...engine.system import Setup, System
from ...engine.world import World

__all__ = ["PICTURE", "CompanionSource", "CompanionsSystem", "Picture"]

PICTURE = "companions.picture"
"""What the view of a companion exports: rgb: radiance; a: the share that it hides of what is behind."""


@dataclass(frozen=True)
class Picture:
    """A companion, drawn. texture: PICTURE of its view. corner_px: (x, y) of its lower left corner in pixels of the
    view, from the lower left. texel_px: width of a texel in such pixels; whole texels make a pixel, but in a spot.
    rect: (x, y, width, height), the pixels that it touches. spot_px: standard deviation of the spot that each texel is
    seen as, for a planet of few pixels; 0 for none."""

    texture: moderngl.Texture
    corner_px: tuple[float, float]
    texel_px: float
    rect: tuple[int, int, int, int]
    spot_px: float = 0.0


class CompanionSource(Protocol):
    """The world resource SOURCE: draws companions for a planet's view, and knows which of its views are those."""

    def prepare(self, frame: Frame) -> bool:
        """Say in a frame what comes from outside (stars, jitter); whether it is a picture for others."""
        ...

    def pictures(self, frame: Frame) -> Sequence[Picture]:
        """The other planets that are in sight of a frame's camera, the farthest first."""
        ...

    def stamp(self) -> object:
        """Changes with everything that other planets show."""
        ...

    def settled(self, view: View) -> bool:
        """Whether the last pictures for that view show all that they will come to show."""
        ...

    def progress(self, view: View) -> float:
        """How much of that is done, 0..1."""
        ...


class _Shown:
    """Of one view: the pictures of other planets in its last frame."""

    def __init__(self) -> None:
        self.pictures: Sequence[Picture] = ()
        self.jitter_px = (0.0, 0.0)
        self.main = False
        """Whether it is a camera's own, and not a picture for others."""


class CompanionsSystem(System):
    """Active where there is a source. Creates companions.light for the view of a camera, companions.picture for a
    companion's."""

    name: ClassVar[str] = "companions"

    def active(self, world: World) -> bool:
        return world.try_resource(SOURCE) is not None

    def setup(self, setup: Setup) -> None:
        gpu = setup.gpu
        self._world, self._views = setup.world, setup.views
        self._format = str(setup.settings.get("sky.radiance_format", "rgba32f"))
        self._take = gpu.fullscreen("companions/take.frag")
        self._disc = gpu.fullscreen("companions/disc.frag")
        self._spot = gpu.fullscreen("companions/spot.frag")
        self._plain = gpu.state()
        self._over = gpu.state(blend="premultiplied")
        self._stamp: object = None

    def release(self) -> None:
        for view in self._views:
            view.planets_px = None

    @property
    def _source(self) -> CompanionSource:
        return self._world.resource(SOURCE)

    @property
    def moving(self) -> bool | None:  # type: ignore[override]
        """Whether another planet changed since the last frame."""
        return self._source.stamp() != self._stamp

    def settled(self, view: View) -> bool:
        return not view.state(self, _Shown).main or self._source.settled(view)

    def progress(self, view: View) -> float:
        return self._source.progress(view) if view.state(self, _Shown).main else 1.0

    def begin(self, frame: Frame) -> None:
        """Draw the other planets: nothing of this frame is bound or made yet."""
        source = self._source
        seen = frame.view.state(self, _Shown)
        seen.main = not source.prepare(frame)
        shown = source.pictures(frame) if seen.main else ()
        self._stamp = source.stamp()
        seen.pictures, seen.jitter_px = shown, frame.jitter_px
        frame.view.planets_px = _around([picture.rect for picture in shown]) if shown else None

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        if PICTURE in view.outputs:
            builder.add_pass(
                "companions.take",
                bind=self._bind_take,
                system=self.name,
                reads=("scene.radiance", "gbuffer.depth", *contract_reads(self._world)),
                creates=(TextureSpec(PICTURE, self._format, help="radiance, and what it hides of what is behind"),),
                help="this planet as another one's camera sees it",
            )
            return
        shown = view.view.state(self, _Shown)
        builder.add_pass(
            "companions.layer",
            bind=lambda io: self._bind_layer(io, shown),
            system=self.name,
            creates=(TextureSpec(LIGHT, self._format, lifetime="persistent", help="other planets, behind the air"),),
            when=lambda: bool(shown.pictures),
            help="pictures of other planets over one another, while any is in sight",
        )

    def _bind_take(self, io: PassIO) -> Callable[[], None]:
        target = io.framebuffer(colors=(PICTURE,))
        scene, depth = io.texture("scene.radiance"), io.texture("gbuffer.depth")
        bind_air = bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            target.use()
            self._plain.apply()
            scene.use(0)
            depth.use(1)
            self._take.render()

        return run

    def _bind_layer(self, io: PassIO, shown: _Shown) -> Callable[[], None]:
        target = io.framebuffer(colors=(LIGHT,))

        def run() -> None:
            target.use()
            self._plain.apply()
            target.clear()
            self._over.apply()
            for picture in shown.pictures:
                target.viewport = picture.rect
                picture.texture.use(0)
                if picture.spot_px > 0.0:
                    draw = self._spot
                    draw.set("u_corner_px", tuple(picture.corner_px))
                    draw.set("u_texel_px", picture.texel_px)
                    draw.set("u_spot_px", picture.spot_px)
                    draw.set("u_jitter", shown.jitter_px)
                else:
                    draw = self._disc
                    draw.set("u_corner", tuple(round(c) for c in picture.corner_px))
                    draw.set("u_texels", round(1.0 / picture.texel_px))
                draw.render()
            target.viewport = (0, 0, *target.size)

        return run


def _around(rects: Sequence[tuple[int, int, int, int]]) -> tuple[int, int, int, int]:
    left, low = min(r[0] for r in rects), min(r[1] for r in rects)
    right, high = max(r[0] + r[2] for r in rects), max(r[1] + r[3] for r in rects)
    return left, low, right - left, high - low
