"""The map of the trees' shadows: how far towards the sun their highest leaves lie, seen from it.

It is drawn whole when the sun or the camera moves on, or plots come and go. Where single trees were felled, only the
parts of it that held them are drawn anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...components import CoverSpecies
from ...engine.blocks.bindings import COVER_BLOCK, TREE_BUFFER
from ...engine.blocks.layout import Vec2, Vec3, Vec4, array
from ...engine.gpu import GpuScope, Program, VertexArray
from ...engine.gpu.growing import GrowingBuffer
from ...engine.surface.crowns import crown_octave, mean_crown_m
from ...engine.wavelengths import Nanometres
from .own_colours import own_defines, packed
from .records import TREE_DTYPE, tree_records
from .stand import Plants
from .sway import GUSTS, Sway

__all__ = ["REACH_M", "CoverMapBlock", "ShadowMap"]

Floats = NDArray[np.float64]


@dataclass
class CoverMapBlock:
    """Where the map lies, and which way it faces. GLSL: ``generated/cover_map.glsl``, instance ``cover_map``."""

    x: Annotated[Vec3, "across it, planet axes"]
    y: Vec3
    middle_m: Annotated[Vec3, "from the camera"]
    per_m: Annotated[float, "1 / half its side"]
    per_depth_m: Annotated[float, "1 / metres of leaves that are dark"]
    broadleaf: Annotated[Vec3, "albedo of leaves, which the tropics keep"]
    conifer: Vec3
    north: Annotated[Vec4, "where they shed them: albedo, and share of crowns that hides"]
    south: Vec4
    crowns: Annotated[float, "area of all crowns of a deep forest of broadleaves over its ground's"]
    tall_m: Annotated[float, "of a grown broadleaf tree"]
    wide_m: Annotated[float, "its crown's mean radius"]
    octave: Annotated[float, "cells in which crowns far away stand: NESTED_BASE_M times 2 to this"]
    grass: Annotated[float, "share of what may grow that does"]
    grass_tall: Annotated[float, "height of grass over what it is by default"]
    flowers: Annotated[float, "share of cells with grass that have one"]
    savanna: Annotated[float, "share of places that have a tree where it is warm and dry"]
    variety: Annotated[float, "how much stands and trees differ, 0..1"]
    snow: Annotated[Vec4, "its albedo; share of what falls on trees that they carry"]
    winter: Annotated[Vec2, "0..1, of the northern and the southern half"]
    gusting: Annotated[float, "share by which one gust's crest strengthens the wind"]
    flutter: Annotated[float, "phase of the leaves' own motion, 0..1"]
    sway: Annotated[Vec3, "what the wind moves tips by, over their height; planet axes"]
    gusts: Annotated[Any, array(Vec4, GUSTS), "cycles per metre, planet axes; phase at the camera"]


class Forest(NamedTuple):
    """What distant forests and grass look like; as CoverMapBlock has them."""

    broadleaf: Floats
    conifer: Floats
    north: Floats
    south: Floats
    crowns: float
    tall_m: float = 15.0
    spacing_m: float = 7.0
    grass: float = 0.0
    grass_tall: float = 1.0
    flowers: float = 0.0
    savanna: float = 0.0
    variety: float = 0.0
    snow: Floats = np.zeros(4)
    winter: Floats = np.zeros(2)


REACH_M = 600.0
"""Shadows farther from the camera are left to the colour of forests."""
_STEP = 0.08
"""Share of its reach that the camera may move before the map follows."""
_NONE_M = -1e9
_FEW = 16
"""Trees that are cut out of the map one by one; of more the whole map is drawn anew."""


class ShadowMap:
    """One view's. What it holds follows from the trees, the sun and its middle; it is drawn when one changes."""

    def __init__(self, gpu: GpuScope, texels: int) -> None:
        self.texels = texels
        self.heights = gpu.texture((texels, texels), "r32f")
        self._depth = gpu.texture((texels, texels), "depth32f")
        self._framebuffer = gpu.framebuffer([self.heights], self._depth)
        self._state = gpu.state(depth_test=True, depth_func=">", cull=None)
        self._gpu, self._own = gpu, False
        self._changed = -1
        self._compile(())
        self._trees = GrowingBuffer(gpu, TREE_DTYPE.itemsize)
        self.block = gpu.uniform_block(CoverMapBlock, COVER_BLOCK)
        self._key: object = None
        self.revision: tuple[int, ...] = ()
        """Of the plants that it shows"""
        self._up: Floats = np.array([0.0, 0.0, 1.0])
        self.middle_m: Floats = np.zeros(3)
        self.axes: Floats = np.eye(3)
        """Rows: across the map, and to the sun"""
        self.half_m, self._bare = 1.0, 0.0

    def _compile(self, species: Sequence[CoverSpecies]) -> None:
        own = own_defines(species)
        self._programs = [
            self._gpu.program(vertex="cover/shadow.vert", fragment="cover/shadow.frag", defines={**own, **more})
            for more in ({}, *([{"COVER_FORMS": 1}] if own else []))
        ]
        self._quads = [self._gpu.vertex_array(program) for program in self._programs]

    def use(self, species: Sequence[CoverSpecies], nm: Nanometres, changed: int) -> None:
        """The planet's own species, whose shadows are drawn from now on; changed: another number for others."""
        if bool(species) != self._own:
            self._own = bool(species)
            for made in (*self._quads, *self._programs):
                made.release()
            self._compile(species)
        if changed != self._changed:
            self._changed, self._key = changed, None
            for program in self._programs if species else ():
                program.set("u_own", packed(species, nm))

    @property
    def texel_m(self) -> float:
        return 2.0 * self.half_m / self.texels

    def place(self, camera_m: Floats, forest: Forest, sway: Sway, on: bool) -> None:
        """Say where it lies for a camera. on: whether it is to darken anything."""
        self.block.write(
            CoverMapBlock(
                x=self.axes[0],
                y=self.axes[1],
                middle_m=self.middle_m - camera_m,
                per_m=1.0 / self.half_m if on else 1e9,
                per_depth_m=0.5 / self.texel_m,
                broadleaf=forest.broadleaf,
                conifer=forest.conifer,
                north=forest.north,
                south=forest.south,
                crowns=forest.crowns,
                tall_m=forest.tall_m,
                wide_m=mean_crown_m(forest.crowns, forest.spacing_m),
                octave=crown_octave(forest.spacing_m),
                grass=forest.grass,
                grass_tall=forest.grass_tall,
                flowers=forest.flowers,
                savanna=forest.savanna,
                variety=forest.variety,
                snow=forest.snow,
                winter=forest.winter,
                gusting=sway.gusting,
                flutter=sway.flutter,
                sway=sway.bend,
                gusts=sway.gusts,
            )
        )

    def draw(
        self,
        plants: Plants,
        revision: tuple[int, ...],
        camera_m: Floats,
        sun: Floats,
        reach_m: float,
        bare: float = 0.0,
        other: Plants | None = None,
    ) -> bool:
        """Bring the map up to date; whether it had to be drawn. camera_m: planet-centred; sun: unit, to it; bare: share
        of broadleaves' leaves that have fallen. other: what alone has been felled, or stands again, since the revision
        that the map shows; None for all kinds of changes."""
        half = min(reach_m, REACH_M)
        moved = np.linalg.norm(camera_m - self.middle_m) > _STEP * half
        key, self._bare = (tuple(np.round(sun, 5)), half, round(bare, 2)), bare
        if key == self._key and not moved:
            if revision == self.revision:
                return False
            if other is not None and len(other) <= _FEW:
                self.revision = revision
                self._draw_parts(plants, other)
                return True
        self._key, self.revision, self.half_m, self.middle_m = key, revision, half, camera_m.copy()
        self._up = up = camera_m / np.linalg.norm(camera_m)
        x = np.cross(up, sun)
        if float(x @ x) < 1e-8:
            x = np.cross(np.eye(3)[int(np.argmin(np.abs(up)))], sun)
        x /= np.linalg.norm(x)
        self.axes = np.stack([x, np.cross(sun, x), sun])
        self._framebuffer.use()
        self._draw(plants, (0, 0, self.texels, self.texels))
        return True

    def _draw_parts(self, plants: Plants, other: Plants) -> None:
        """Draw anew what held other trees."""
        target: Any = self._framebuffer  # its type does not know that None turns the scissor off
        target.use()
        place, size = self._places(other)
        low = np.clip(np.floor((place - size[:, None] + self.half_m) / self.texel_m), 0, self.texels).astype(int)
        high = np.clip(np.ceil((place + size[:, None] + self.half_m) / self.texel_m), 0, self.texels).astype(int)
        for (x, y), (width, height) in zip(low.tolist(), (high - low).tolist(), strict=True):
            if width > 0 and height > 0:
                target.scissor = (x, y, width, height)
                self._draw(plants, (x, y, width, height))
        target.scissor = None

    def _draw(self, plants: Plants, part: tuple[int, int, int, int]) -> None:
        """Draw the trees that reach into a part of the map: its corner, width and height, in texels."""
        place, size = self._places(plants)
        low = np.array(part[:2]) * self.texel_m - self.half_m - size[:, None]
        high = (np.array(part[:2]) + part[2:]) * self.texel_m - self.half_m + size[:, None]
        near = np.flatnonzero(((place > low) & (place < high)).all(axis=1))
        apart = plants.drawn_apart[near]
        near = np.concatenate([near[~apart], near[apart]])
        rows, trees = tree_records(plants.only(near), self.middle_m), len(near) - int(np.count_nonzero(apart))
        self._trees.write(rows)
        self._state.apply()
        self._framebuffer.clear(_NONE_M, 0.0, 0.0, 0.0, depth=0.0, viewport=part)
        if len(rows):
            self._trees.buffer.bind_to_storage_buffer(TREE_BUFFER)
            for program, quad, first, end in zip(
                self._programs, self._quads, (0, trees), (trees, len(rows)), strict=False
            ):
                if first < end:
                    self._draw_with(program, quad, first, end)

    def _draw_with(self, program: Program, quad: VertexArray, first: int, end: int) -> None:
        x, y, sun = self.axes
        for name, value in (("u_x", x), ("u_y", y), ("u_sun", sun), ("u_up", self._up)):
            program.set(name, tuple(value))
        program.set("u_first", first)
        program.set("u_per_m", 1.0 / self.half_m)
        program.set("u_bare", self._bare)
        program.set("u_texel_m", self.texel_m)
        program.set("u_deep_m", 8.0 * self.half_m)
        quad.render(vertices=6, instances=end - first)

    def _places(self, plants: Plants) -> tuple[Floats, Floats]:
        """Where the feet of trees (N, 2) are on the map, from its middle; and how far (N,) no tree reaches from it."""
        place = (plants.positions_m - self.middle_m) @ self.axes[:2].T
        return place, 1.1 * (plants.heights_m + plants.radii_m)
