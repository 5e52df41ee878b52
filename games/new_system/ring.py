"""A ring around a planet: component, system, registration. What it looks like is in shaders/ring/draw.frag."""

from dataclasses import dataclass
from pathlib import Path

from planetfall import extend as pfx


@dataclass
class Ring:
    """Dust and ice around a planet's equator."""

    inner_radii: float = pfx.knob(1.3, 1.0, 20.0, "radii", "Inner edge, from the planet's centre")
    outer_radii: float = pfx.knob(2.3, 1.0, 20.0, "radii", "Outer edge, from the planet's centre")
    depth: float = pfx.knob(0.9, 0.0, 10.0, "", "Optical depth straight through its densest bands", log=True)
    albedo: tuple[float, float, float] = pfx.knob((0.75, 0.68, 0.58), 0.0, 1.0, "", "Light scattered", widget="color")


class RingSystem(pfx.System):
    name, needs, moving = "ring", (pfx.Planet, Ring), False  # nothing in it moves by itself

    def setup(self, setup: pfx.Setup) -> None:
        gpu, self._world = setup.gpu, setup.world
        density = gpu.fullscreen("ring/draw.frag", {"DENSITY": 1})
        self._draws = (
            (gpu.fullscreen("ring/draw.frag"), gpu.state(blend="premultiplied")),
            (density, gpu.state()),
        )

    def update(self, frame: pfx.Frame) -> None:
        ring = pfx.with_overrides(frame.world.get(frame.planet, Ring), "ring", frame.settings)
        radius = frame.world.get(frame.planet, pfx.Planet).radius_m
        for draw, _ in self._draws:
            draw.set("u_camera", tuple(frame.camera.position_m / radius))
            draw.set("u_ring", (ring.inner_radii, ring.outer_radii, ring.depth, radius))
            draw.set("u_albedo", ring.albedo)

    def declare(self, builder: pfx.GraphBuilder, view: pfx.ViewInfo) -> None:
        reads, (light, density) = ("gbuffer.depth", *pfx.contract_reads(self._world)), self._draws
        builder.add_pass("ring.draw", bind=lambda io: pfx.fullscreen_pass(io, self._world, *light, "scene.radiance"),
                         system=self.name, reads=reads, writes=("scene.radiance",), stage="overlay",
                         help="the ring, over all that is behind it")  # fmt: skip
        builder.add_pass("ring.show", bind=lambda io: pfx.fullscreen_pass(io, self._world, *density, "ring.density"),
                         system=self.name, reads=reads, creates=(pfx.TextureSpec("ring.density", "r16f"),))  # fmt: skip


pfx.register(
    Ring, RingSystem, shaders=Path(__file__).parent / "shaders", debug_views={"ring": ("ring.density", "heat")}
)
