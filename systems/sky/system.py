"""SkySystem: what is behind all surfaces (air, the sun's disc). StarsSystem: stars and the Milky Way over it.

Both draw only where nothing was drawn before: at infinity, depth 0, with the depth test on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import moderngl
import numpy as np

from ...components import Atmosphere, Exposure, Planet, Stars
from ...engine.blocks.bindings import EXPOSURE_BEFORE_BUFFER
from ...engine.frame import Frame, View, ViewInfo
from ...engine.frame.backdrop import LIGHT, SOURCE, Backdrop
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.frame.published import AIR_TOP_M
from ...engine.gpu import gl as G
from ...engine.gpu.kept_maps import KeptMaps
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.settings import Settings, with_overrides
from ...engine.system import Setup, System
from ...engine.wavelengths import wavelengths_of
from .catalogue import GALACTIC_AXES, STARS_TO_6_5, make_stars

__all__ = ["SkySystem", "StarsSystem"]

_LIMITS = {"rgba16f": 6.0e4, "rgba32f": 1.0e28}
"""Largest value that is stored for each format of scene.radiance: a sun must not become infinite."""
_SHELL_CORNERS = 64
"""Of the polygon around the air as seen from space: 0.1 % wider than the disc."""
_STAR_POINT_PX = 7
_GALAXY_TEXELS = 1024
_PROGRAM_POINT_SIZE = 0x8642
BRIGHTEST_STAR = 3.0e-10
"""W m^-2 nm^-1: the star of rank 1 (magnitude -1.4), in its strongest wavelength, has at most this."""
STAR_FALL = 0.8
"""The star of rank k is at most k^-0.8 as bright: magnitudes go with 2 log10 of the rank (catalogue.py)."""
STAR_PEAK = 0.33
"""Share of a star's light that its middle pixel gets at most."""
BRIGHTEST_CLOUD = 5.5e-8
"""W m^-2 sr^-1 nm^-1: no part of the galaxy's map is brighter. Its units in sky/galaxy.frag are 7.14e-9; the map has at
most ((0.86 + 1) x 2.85 x 1.25 x 1.1 + 0.055) x 1.033 = 7.6 of them."""
_INVISIBLE = 0.25 / 255.0 / 12.92
"""Exposed value that is a quarter of a step of an 8-bit picture."""


def radiance_format(settings: Settings) -> str:
    """Format of scene.radiance: quality value "sky.radiance_format", rgba32f unless it says rgba16f."""
    return str(settings.get("sky.radiance_format", "rgba32f"))


class SkySystem(System):
    """Always active. Creates ``scene.radiance`` (radiance times frame.hdr_per_radiance), black where a surface is."""

    name: ClassVar[str] = "sky"

    def setup(self, setup: Setup) -> None:
        gpu = setup.gpu
        self._format = radiance_format(setup.settings)
        self._world = setup.world
        self._background = gpu.program(vertex="sky/background.vert", fragment="sky/background.frag")
        self._shell = gpu.vertex_array(self._background)
        self._gpu = gpu
        self._suns: dict[bool, Any] = {}
        self._planets: Any = None
        self._no_planet: Any = None
        self._far = gpu.state(depth_test=True, depth_func=">=", write_depth=False)
        self._far_add = gpu.state(depth_test=True, depth_func=">=", write_depth=False, blend="additive")

    def _corners(self, frame: Frame) -> int:
        """How much of the picture the air can fill: nothing without air; seen from space a disc, from inside all."""
        top_m = frame.world.try_resource(AIR_TOP_M)
        if top_m is None or not frame.view.seen.planet():
            return 0
        distance = frame.camera.distance_m
        reach = (frame.world.get(frame.planet, Planet).radius_m + top_m) / distance
        pixel = frame.pixel_rad
        if 2.0 * reach <= pixel:
            return 0  # smaller than a pixel
        # A polygon around a cone that is narrower than a right angle by a margin; else the whole picture.
        half_angle = math.asin(min(reach, 1.0))
        edge = math.tan(half_angle) / math.cos(math.pi / _SHELL_CORNERS) if half_angle < 1.4 else -1.0
        self._background.set("u_shell", (edge, 2.0 * math.pi / _SHELL_CORNERS))
        return _SHELL_CORNERS if edge > 0.0 else 1

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        builder.add_pass(
            "sky.shade",
            bind=lambda io: self._bind(io, view.view),
            system=self.name,
            reads=("gbuffer.depth", *contract_reads(self._world)),
            reads_optional=(LIGHT,),
            creates=(TextureSpec("scene.radiance", self._format, help="radiance times the frame's scale, linear"),),
            help="air and the sun's disc where no surface is, black elsewhere",
        )

    def _bind(self, io: PassIO, view: View) -> Callable[[], None]:
        target = io.framebuffer(colors=("scene.radiance",), depth="gbuffer.depth")
        colors = io.framebuffer(colors=("scene.radiance",))
        bind_air = bind_contracts(self._world, io)
        planets: Backdrop | None = None
        if io.has(LIGHT):
            planets = Backdrop(io, view, self._nothing())
        sun = self._sun(planets is not None)

        def run() -> None:
            bind_air()
            colors.use()
            colors.clear()
            target.use()
            corners = self._corners(view.frame)
            if corners:
                self._far.apply()
                self._shell.render(moderngl.TRIANGLE_FAN, corners + 2)
            self._far_add.apply()
            if planets is not None and planets.use(0) and planets.rect is not None:
                target.viewport = planets.rect
                self._planets.render()
                target.viewport = (0, 0, *target.size)
            if view.frame.backdrop:
                sun.render(moderngl.TRIANGLE_STRIP, 4)

        return run

    def _nothing(self) -> Any:
        """What is bound where no other planet is; with the first one comes its program."""
        if self._no_planet is None:
            self._no_planet = self._gpu.texture((1, 1), "rgba8", bytes(4))
            self._planets = self._gpu.fullscreen("sky/planets.frag")
            self._planets.set("u_limit", _LIMITS[self._format])
        return self._no_planet

    def _sun(self, behind_planets: bool) -> Any:
        """The sun's disc, with what hides it or without."""
        if behind_planets not in self._suns:
            defines = {"PLANETS": 0} if behind_planets else {}
            program = self._gpu.program(vertex="sky/sun.vert", fragment="sky/sun.frag", defines=defines)
            program.set("u_limit", _LIMITS[self._format])
            self._suns[behind_planets] = self._gpu.vertex_array(program)
        return self._suns[behind_planets]


@dataclass
class _Shown:
    """What one view shows, by its exposure and the air."""

    hidden: bool = False
    """Nothing: known before the frame, where the exposure is fixed."""
    all: bool = True
    """Whatever there is, or what a fixed exposure shows of it; else as many as sky/choose_stars.comp finds."""
    fixed_ev100: float | None = None
    star: float = 0.0
    """The brightest star's exposed light at EV100 0, over the least that shows; cloud: of the galaxy."""
    cloud: float = 0.0
    low_ev100: float = 0.0
    """The exposure goes no lower, and by no more than `share` of the way there in this frame."""
    share: float = 1.0
    clear: bool = False
    """No ray of it meets the air."""
    mapped: tuple[Any, int] = (None, -1)
    """The texture of the galaxy's map, and the seed that it shows."""


class StarsSystem(System):
    """Needs Stars. Adds the galaxy's light and single stars to ``scene.radiance``, fixed to the inertial frame.

    Stars stand as Frame.star_axes says; without it they are fixed to the planet.
    """

    name: ClassVar[str] = "stars"
    needs: ClassVar[tuple[type, ...]] = (Stars,)

    def __init__(self) -> None:
        self._catalogue: tuple[int, int] = (-1, -1)
        self._map_seed = -1
        self._axes: Any = None
        self._star_axes: tuple[float, ...] = ()
        self._galactic_axes: tuple[float, ...] = ()

    def setup(self, setup: Setup) -> None:
        self._gpu = gpu = setup.gpu
        self._world = setup.world
        self._limit = _LIMITS[radiance_format(setup.settings)]
        self._nm = wavelengths_of(setup.settings)
        # Behind other planets is nothing to be seen, where there are any.
        self._planets = setup.world.try_resource(SOURCE) is not None
        self._no_planet: Any = gpu.texture((1, 1), "rgba8", bytes(4)) if self._planets else None
        self._drawers: dict[bool, tuple[Any, Any]] = {}
        for clear in (False, True) if setup.world.query(Atmosphere) else (False,):
            self._drawer(clear)
        self._map = gpu.fullscreen("sky/galaxy_map.frag")
        self._kept = KeptMaps(gpu)
        self._choose = gpu.compute("sky/choose_stars.comp")
        self._choose.set("u_fall", STAR_FALL)
        self._plain = gpu.state()
        self._far_add = gpu.state(depth_test=True, depth_func=">=", write_depth=False, blend="additive")
        toggles = [gpu.gl.function(name, None, G.enum) for name in ("glEnable", "glDisable")]
        self._enable, self._disable = toggles
        self._points: dict[bool, Any] = {}
        self._buffer: Any = None
        self._catalogue, self._map_seed = (-1, -1), -1
        self._refresh(setup.world.query(Stars)[0][1][0])

    def release(self) -> None:
        self._points, self._buffer = {}, None

    def _drawer(self, clear: bool) -> tuple[Any, Any]:
        """Programs of stars and of the galaxy. clear: for views of which no ray meets the air, which is then not asked
        for: it costs ten times what the light does."""
        if clear not in self._drawers:
            defines: dict[str, Any] = {"STARS_CLEAR": 1} if clear else {}
            defines |= {"PLANETS": 1} if self._planets else {}
            points = {"STAR_POINT_PX": f"{_STAR_POINT_PX}.0", **defines}
            stars = self._gpu.program(vertex="sky/stars.vert", fragment="sky/stars.frag", defines=points)
            stars.set("u_limit", self._limit)
            self._drawers[clear] = stars, self._gpu.fullscreen("sky/galaxy.frag", defines=defines)
        return self._drawers[clear]

    def _points_of(self, clear: bool) -> Any:
        """The stars for a drawer; None without any."""
        if self._buffer is not None and clear not in self._points:
            content = [(self._buffer, "3f 3f", "in_direction", "in_irradiance")]
            self._points[clear] = self._gpu.vertex_array(self._drawer(clear)[0], content)
        return self._points.get(clear)

    def _refresh(self, stars: Stars) -> None:
        count = round(STARS_TO_6_5 * float(stars.density))
        key = (count, int(stars.seed))
        self._map_seed = int(stars.seed)
        if key == self._catalogue:
            return
        self._catalogue = key
        for old in (*self._points.values(), self._buffer):
            if old is not None:
                self._gpu.free(old)
        self._points, self._buffer = {}, None
        if count:
            field = make_stars(count, int(stars.seed), self._nm)
            packed = np.concatenate([field.directions, field.irradiance], axis=1).astype(np.float32)
            self._buffer = self._gpu.buffer(packed)

    def update(self, frame: Frame) -> None:
        stars: Stars = frame.world.query(Stars)[0][1][0]
        self._refresh(stars)
        shown = frame.view.state(self, _Shown)
        self.expose(frame, stars, shown)
        if not frame.backdrop:
            shown.hidden = True
        self._turn_stars(frame.star_axes)
        shown.clear = clear = bool(frame.world.query(Atmosphere)) and not frame.view.seen.planet()
        points, galaxy = self._drawer(clear)
        points.set("u_star_axes", self._star_axes)
        points.set("u_brightness", float(stars.brightness))
        galaxy.set("u_galactic_axes", self._galactic_axes)
        galaxy.set("u_brightness", float(stars.brightness) * min(float(stars.density), 1.0))
        self._map.set("u_seed", self._map_seed & 0xFFFF)

    def _turn_stars(self, found: Any) -> None:
        """The matrices of a moment, as GLSL reads them: column by column, the transpose of the row order of numpy."""
        axes = np.eye(3) if found is None else np.asarray(found)
        if self._axes is None or not np.array_equal(axes, self._axes):
            self._axes = np.array(axes)
            self._star_axes = tuple(axes.T.astype(np.float32).ravel().tolist())
            self._galactic_axes = tuple((GALACTIC_AXES @ axes.T).T.astype(np.float32).ravel().tolist())

    def expose(self, frame: Frame, stars: Stars, shown: _Shown) -> None:
        """What can show of stars and galaxy, as far as it is known before the frame's exposure is."""
        exposures = frame.world.query(Exposure)
        exposure = with_overrides(exposures[0][1][0] if exposures else Exposure(), "exposure", frame.settings)
        ev100 = frame.ev100 if frame.ev100 is not None else exposure.ev100 if exposure.mode == "fixed" else None
        # An exposure that jumps may come to anything.
        shown.hidden, shown.all, shown.fixed_ev100 = False, ev100 is not None or frame.cut, None
        if ev100 is None and frame.cut:
            return
        shown.fixed_ev100 = ev100
        shown.star, shown.cloud = (e / _INVISIBLE for e in _exposed_most(frame, float(stars.brightness)))
        shown.hidden = ev100 is not None and max(shown.star, shown.cloud) < 2.0**ev100
        shown.low_ev100 = float(exposure.min_ev100 - max(exposure.compensation_ev, 0.0))
        shown.share = 1.0
        if exposure.brighter_s > 0.0:
            shown.share = -math.expm1(-3.0 * max(frame.dt_s, 0.0) / exposure.brighter_s)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        side = (_GALAXY_TEXELS, _GALAXY_TEXELS)
        numbers = "scene.radiance" in view.outputs  # somebody wants them, not a picture
        metered = (
            bool({"composite.ldr", "target", "target_with_depth"} & view.outputs) and not numbers
        )  # then the exposure has history
        shown = view.view.state(self, _Shown)
        builder.add_pass(
            "stars.galaxy_map",
            bind=lambda io: self._bind_map(io, shown),
            system=self.name,
            when=lambda: shown.mapped[1] != self._map_seed and (numbers or not shown.hidden),
            creates=(
                TextureSpec("stars.galaxy", "rgba16f", side, "persistent", filter="linear", help="octahedral map"),
            ),
            help="light of the Milky Way over the whole sky, made once for a seed",
        )
        if metered:
            builder.add_pass(
                "stars.choose",
                bind=lambda io: self._bind_choose(io, shown),
                system=self.name,
                kind="compute",
                history=("composite.exposure",),
                creates=(BufferSpec("stars.draws", 40, "persistent", help="indirect draws: galaxy, stars"),),
                when=lambda: not shown.all,
                help="how many stars last frame's exposure lets show",
            )
        builder.add_pass(
            "stars.draw",
            bind=lambda io: self._bind_draw(io, view.view, shown, metered, numbers),
            system=self.name,
            reads_optional=(LIGHT,),
            reads=("stars.galaxy", "gbuffer.depth", *contract_reads(self._world), *(("stars.draws",) * metered)),
            writes=("scene.radiance",),
            stage="sky",
            when=lambda: numbers or not shown.hidden,
            help="the Milky Way and single stars where no surface is",
        )

    def _bind_map(self, io: PassIO, shown: _Shown) -> Callable[[], None]:
        target, texture = io.framebuffer(colors=("stars.galaxy",)), io.texture("stars.galaxy")
        # A graph that is compiled again may keep the texture, and what it holds.
        if shown.mapped[0] is not texture:
            shown.mapped = (texture, -1)

        def run() -> None:
            key = self._kept.key("galaxy", self._map.program.linked.key, self._map_seed & 0xFFFF, texture.size)
            if not self._kept.load(key, texture):
                target.use()
                self._plain.apply()
                self._map.render()
                self._kept.save(key, texture)
            shown.mapped = (texture, self._map_seed)

        return run

    def _bind_choose(self, io: PassIO, shown: _Shown) -> Callable[[], None]:
        before, valid, draws = io.history("composite.exposure"), io.history_valid, io.buffer("stars.draws")

        def run() -> None:
            if not valid.value:
                shown.all = True
                return
            self._choose.set("u_lowest_ev100", shown.low_ev100)
            self._choose.set("u_share", shown.share)
            self._choose.set("u_brightest_star", shown.star)
            self._choose.set("u_brightest_cloud", shown.cloud)
            self._choose.set("u_count", self._catalogue[0])
            before.bind_to_storage_buffer(EXPOSURE_BEFORE_BUFFER)
            draws.bind_to_storage_buffer(5)
            self._choose.run()

        return run

    def _bind_draw(self, io: PassIO, view: View, shown: _Shown, metered: bool, numbers: bool) -> Callable[[], None]:
        target = io.framebuffer(colors=("scene.radiance",), depth="gbuffer.depth")
        galaxy = io.texture("stars.galaxy")
        draws = io.buffer("stars.draws") if metered else None
        bind_air = bind_contracts(self._world, io)
        planets = Backdrop(io, view, self._no_planet) if self._planets else None

        def run() -> None:
            points, galaxy_light = self._points_of(shown.clear), self._drawer(shown.clear)[1]
            if points is None:
                return
            chosen = None if shown.all else draws
            bind_air()
            target.use()
            self._far_add.apply()
            galaxy.use(0)
            if planets is not None:
                planets.use(1)
            count, cloudy = (-1, True) if numbers else self._count(shown)
            if chosen is None and cloudy:
                galaxy_light.render()
            elif chosen is not None:
                galaxy_light.render_indirect(chosen, 0)
            self._enable(_PROGRAM_POINT_SIZE)
            if chosen is None:
                points.render(moderngl.POINTS, vertices=count)
            else:
                points.render_indirect(chosen, moderngl.POINTS, 1, 1)
            self._disable(_PROGRAM_POINT_SIZE)

        return run

    def _count(self, shown: _Shown) -> tuple[int, bool]:
        """How many stars, sorted by brightness, a fixed exposure lets show (-1: all), and whether the galaxy shows;
        sky/choose_stars.comp has the same for an exposure that is metered."""
        if shown.fixed_ev100 is None:
            return -1, True
        white = 2.0**shown.fixed_ev100
        count = (shown.star / white) ** (1.0 / STAR_FALL)
        return int(min(count, self._catalogue[0])), shown.cloud >= white


def _exposed_most(frame: Frame, brightness: float) -> tuple[float, float]:
    """The most that a pixel of the brightest star and of the galaxy's brightest clouds is exposed to at EV100 0."""
    camera, (width, height) = frame.camera, frame.size
    pixel = (camera.tan_right - camera.tan_left) * (camera.tan_top - camera.tan_bottom) / (width * height)
    # A pixel far off the axis is smaller, by the cube of the cosine; a point is held on the border from just outside.
    corner = max(abs(camera.tan_left), abs(camera.tan_right)), max(abs(camera.tan_bottom), abs(camera.tan_top))
    smaller = (1.0 + corner[0] ** 2 + corner[1] ** 2) ** 1.5 * 1.1
    # 1e5 cd m^-2 per W m^-2 sr^-1 nm^-1 and 1.2 x 2^EV: docs/exposure.md.
    exposed = brightness * 1e5 / 1.2
    return STAR_PEAK * BRIGHTEST_STAR * smaller / pixel * exposed, BRIGHTEST_CLOUD * exposed
