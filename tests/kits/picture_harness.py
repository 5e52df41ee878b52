"""Runs single systems on a small frame graph, without terrain or a renderer: tests of sky, composite, debug views."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from planetfall.components import Planet
from planetfall.engine.blocks.bindings import FRAME_BLOCK, PLANET_BLOCK
from planetfall.engine.display import WAVELENGTHS_FILE, shader
from planetfall.engine.frame import Frame, SunState, ViewInfo, Views
from planetfall.engine.frame.block import FrameBlock, PlanetBlock, frame_of_anchor
from planetfall.engine.gpu.graph_backend import GLBackend
from planetfall.engine.graph import GraphBuilder, TextureSpec
from planetfall.engine.system import Setup, System
from planetfall.engine.wavelengths import GIVEN_NM, SUNLIGHT, wavelengths_of
from planetfall.engine.world import World

SUN = SUNLIGHT[GIVEN_NM]
"""W m^-2 nm^-1 at 680, 550, 440 nm at Earth."""


def look(
    forward: Sequence[float] = (1.0, 0.0, 0.0),
    up: Sequence[float] = (0.0, 0.0, 1.0),
    fov_y_deg: float = 60.0,
    size: tuple[int, int] = (64, 36),
    **changes: Any,
) -> FrameBlock:
    """A frame block for a camera 400 km above the pole of the sun's side, looking anywhere."""
    f = np.asarray(forward, float) / np.linalg.norm(forward)
    right = np.cross(f, up)
    right /= np.linalg.norm(right)
    tall = np.tan(np.radians(fov_y_deg) / 2)
    width, height = size
    made = replace(
        frame_of_anchor((0.0, 0.0, 1.0), 0.0),
        camera_right=right,
        camera_up=np.cross(right, f),
        camera_forward=f,
        projection_scale=(tall * width / height, tall),
        camera_offset_m=(0.0, 0.0, 4e5),
        camera_altitude_m=4e5,
        sun_irradiance=SUN,
        viewport_px=(width, height),
        texel_size=(1.0 / width, 1.0 / height),
        pixel_rad=2.0 * tall / height,
    )
    return replace(made, **changes)


class Scene(System):
    """Stands in for the surfaces: a G-buffer, empty or with surface 1 where depth is given, and its radiance.

    depth: (h, w) array of depth values or None. radiance: (h, w, 3) array for scene.radiance, or None if the sky is to
    create it.
    """

    name = "test.scene"

    def __init__(self, depth: Any = None, radiance: Any = None, format: str = "rgba32f", extra: Any = None) -> None:
        self.depth, self.radiance, self.format, self.extra = depth, radiance, format, extra or {}

    def setup(self, setup: Setup) -> None:
        self._gpu = setup.gpu
        setup.gpu.shaders.add_virtual(
            "test/depth.frag",
            "layout(binding = 0) uniform sampler2D u_from; layout(location = 0) out uint o_surface;\n"
            "void main() { float d = texelFetch(u_from, ivec2(gl_FragCoord.xy), 0).r; gl_FragDepth = d;"
            " o_surface = d > 0.0 ? 1u : 0u; }",
        )
        self._fill = setup.gpu.fullscreen("test/depth.frag")
        self._state = setup.gpu.state(depth_test=True, depth_func="always")

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        specs = (TextureSpec("gbuffer.depth", "depth32f"), TextureSpec("gbuffer.surface", "r8ui"))
        builder.add_pass("gbuffer.clear", bind=self._bind_depth, creates=specs)
        if self.radiance is not None:
            spec = TextureSpec("scene.radiance", self.format)
            builder.add_pass("sky.shade", bind=self._bind_radiance, creates=(spec,))
        for name, (format, data) in self.extra.items():
            bind = lambda io, n=name, d=data: self._bind_upload(io, n, d)  # noqa: E731
            builder.add_pass(f"make.{name}", bind=bind, creates=(TextureSpec(name, format),), side_effect=True)

    def _bind_upload(self, io: Any, name: str, data: Any) -> Callable[[], None]:
        texture = io.texture(name)
        return lambda: texture.write(np.ascontiguousarray(data[::-1]).tobytes())

    def _bind_depth(self, io: Any) -> Callable[[], None]:
        target = io.framebuffer(colors=("gbuffer.surface",), depth="gbuffer.depth")
        depth = np.zeros(io.size[::-1], np.float32) if self.depth is None else np.asarray(self.depth, np.float32)
        source = self._gpu.texture(io.size, "r32f", np.ascontiguousarray(depth[::-1]))

        def run() -> None:
            target.use()
            self._state.apply()
            source.use(0)
            self._fill.render()

        return run

    def _bind_radiance(self, io: Any) -> Callable[[], None]:
        texture = io.texture("scene.radiance")

        def run() -> None:
            image = np.asarray(self.radiance, np.float32)
            image = np.concatenate([image, np.ones((*image.shape[:2], 1), np.float32)], axis=2)[::-1]
            kind = np.float16 if self.format == "rgba16f" else np.float32
            texture.write(np.ascontiguousarray(image.astype(kind)).tobytes())

        return run


class Bench:
    """World, systems and plan of one small view. Use as a context manager; `render` runs one frame."""

    def __init__(
        self,
        gpu: Any,
        systems: Sequence[System],
        components: Sequence[Any] = (),
        size: tuple[int, int] = (64, 36),
        exports: Sequence[str] = ("scene.radiance",),
        settings: dict[str, Any] | None = None,
        outputs: frozenset[str] = frozenset({"scene.radiance"}),
    ) -> None:
        self.gpu, self.size, self.exports, self.outputs = gpu, size, exports, outputs
        self.world = World("bench")
        self.planet = self.world.create(Planet(), *components)
        self.systems = list(systems)
        self.settings = {"composite.antialiasing": "none", **(settings or {})}  # the sky's and tone map's very values
        self.shared = gpu.scope("bench")
        self.frame_block = self.shared.uniform_block(FrameBlock, FRAME_BLOCK, "frame")
        self.planet_block = self.shared.uniform_block(PlanetBlock, PLANET_BLOCK, "planet")
        self.planet_block.write(PlanetBlock(6.371e6, 9000.0, -11000.0, 0.0, 0.0, has_sea=False))
        gpu.shaders.add_virtual(WAVELENGTHS_FILE, shader(wavelengths_of(self.settings)))
        self.scopes = {s.name: gpu.scope(s.name) for s in systems}
        self.views = Views()
        for s in systems:
            s.setup(Setup(self.world, self.scopes[s.name], self.settings, self.planet, self.views))
        self.backend = GLBackend(self.shared)
        self.plan: Any = None
        sun = SunState(np.array([1.0, 0.0, 0.0]), np.array(SUN), 0.004675)
        self.frame = Frame(self.world, self.planet, size, None, sun, view=self.views[0])  # type: ignore[arg-type]
        self.compile()

    def compile(self) -> None:
        builder = GraphBuilder()
        for s in self.systems:
            s.declare(builder, ViewInfo(self.size, self.views[0], self.outputs))
        for name in self.exports:
            builder.export(name)
        self.plan = builder.compile(self.backend, self.size, self.plan)

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *exc: object) -> None:
        self.plan.release()
        for s in self.systems:
            s.release()
        for scope in self.scopes.values():
            scope.release()
        self.shared.release()
        self.gpu.shaders.add_virtual(WAVELENGTHS_FILE, shader(GIVEN_NM))
        self.world.close()

    def render(self, block: FrameBlock, time_s: float = 0.0, dt_s: float = 0.0, cut: bool = True) -> Bench:
        self.frame.time_s, self.frame.dt_s, self.frame.cut = time_s, dt_s, cut
        self.frame_block.write(block)
        self.frame_block.bind()
        self.planet_block.bind()
        for s in self.systems:
            s.update(self.frame)
        self.plan.execute()
        assert self.gpu.ctx.error == "GL_NO_ERROR"
        return self

    def read(self, name: str) -> np.ndarray:
        """A colour texture of the plan as (h, w, components), row 0 on top."""
        texture = self.plan.resource(name)
        kind = {"f1": np.uint8, "f2": np.float16, "f4": np.float32, "u1": np.uint8}[texture.dtype]
        data = np.frombuffer(texture.read(), kind).reshape(texture.height, texture.width, -1)
        return data[::-1].astype(np.uint8 if kind is np.uint8 else np.float64)
