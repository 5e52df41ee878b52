"""PropsSystem: a game's own objects, instanced, lit by sun and sky, in the air, with shadows.

Nothing of it exists while the world has no entity with both Transform and Shape.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...components import Shape, Transform
from ...engine.blocks.bindings import FLAG_BUFFER, RADIANCE_IMAGE, TILE_BUFFER
from ...engine.frame import Frame, View, ViewInfo, ViewParts
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.frame.gbuffer import GBUFFER, GBUFFER_UNITS, Surface, tiles_of
from ...engine.frame.instances import InstancePass
from ...engine.gpu import GpuScope, Program
from ...engine.gpu.growing import GrowingBuffer
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.settings import latest_revision
from ...engine.space.camera import CameraStamp
from ...engine.system import Setup, System
from ...engine.wavelengths import wavelengths_of
from .instances import INSTANCE_DTYPE, OCCLUDER_DTYPE, Props, Visible, read_props, seen_by
from .meshes import Mesh, box, is_file, load_mesh, sphere

__all__ = ["PropsSystem"]

_SHADOW_RADII = 90.0
"""PROP_SHADOW_RADII of props/shadow.glsl."""


class _SeenKey(NamedTuple):
    """What is seen follows from. structure, parts: revisions; moved: whether other props were there in the last frame;
    rows: of the picture."""

    structure: int
    parts: int
    moved: bool
    camera: CameraStamp
    rows: int


class _PropsView(ViewParts):
    """What one view sees, and where it is on the GPU."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.key: _SeenKey | None = None
        self.visible: Visible | None = None
        self.shown: Props | None = None
        """The props as its last frame had them."""
        self.instances = GrowingBuffer(self.gpu, INSTANCE_DTYPE.itemsize)
        self.occluders = GrowingBuffer(self.gpu, OCCLUDER_DTYPE.itemsize)


class PropsSystem(System):
    """Needs an entity with Transform and Shape."""

    name: ClassVar[str] = "props"
    needs: ClassVar[tuple[type, ...]] = (Transform, Shape)

    def setup(self, setup: Setup) -> None:
        self._gpu = gpu = setup.gpu
        self._world = setup.world
        self._nm = wavelengths_of(setup.settings)
        format = str(setup.settings.get("sky.radiance_format", "rgba32f"))
        self._surface = gpu.program(vertex="props/gbuffer.vert", fragment="props/gbuffer.frag")
        self._shadow = gpu.compute("props/shadow.comp")
        self._list = gpu.compute("props/list_tiles.comp")
        self._shade = gpu.compute("props/shade.comp", defines={"RADIANCE_FORMAT": format})
        # Meshes from files may be open or wound either way.
        self._draw_state = gpu.state(depth_test=True, depth_func=">", cull=None)
        self._meshes: dict[tuple[str, int], tuple[Mesh, Any, list[Any]]] = {}
        self._numbers = InstancePass(gpu, "props/instance.vert", Surface.PROPS)
        self._numbered: dict[tuple[str, int], tuple[Any, Any]] = {}
        self._props: Props | None = None
        self._read: tuple[int, int] | None = None
        self._views = setup.views

    def release(self) -> None:
        self._meshes.clear()
        self._numbered.clear()
        self._props = None

    # -- a frame -----------------------------------------------------------------------------------------------------

    def update(self, frame: Frame) -> None:
        revision = (frame.world.structure_revision, latest_revision(Transform, Shape))
        if revision != self._read or self._props is None:
            self._props = read_props(frame.world.query(Transform, Shape), load_mesh, self._nm)
            self._read = revision
        view = self._view(frame.view)
        camera, before = frame.camera, view.shown
        view.shown = self._props
        moved = before is not None and before is not self._props
        key = _SeenKey(*revision, moved, camera.stamp, frame.size[1])
        if key == view.key:
            return
        view.key = key
        view.visible = seen_by(self._props, camera, frame.size[1], _SHADOW_RADII, before)
        view.instances.write(view.visible.instances)
        view.occluders.write(view.visible.occluders)
        for form, level, _, _ in view.visible.draws:
            self._vertex_array(form, level)

    def _view(self, view: View) -> _PropsView:
        return view.state(self, lambda: _PropsView(self._gpu))

    def _vertex_array(self, form: str, level: int) -> Any:
        """Uploaded when first seen, and again when the file has changed."""
        mesh = load_mesh(form) if is_file(form) else sphere(level) if form == "sphere" else box()
        found = self._meshes.get((form, level))
        if found is None or found[0] is not mesh:
            for old in found[2] if found is not None else ():
                self._gpu.free(old)
            vertices, indices = self._gpu.buffer(mesh.vertices), self._gpu.buffer(mesh.indices)
            array = self._gpu.vertex_array(
                self._surface, [(vertices, "3f 3f", "in_position", "in_normal")], index=indices
            )
            found = self._meshes[form, level] = (mesh, array, [array, vertices, indices])
        return found[1]

    # -- passes ------------------------------------------------------------------------------------------------------

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        seen = self._view(view.view)
        name = self.name
        tiles = tiles_of(view.size)

        def lit() -> bool:
            """Whether there is anything in the picture that has light of props or their shadow on it."""
            return view.view.seen.ground() or (seen.visible is not None and bool(seen.visible.draws))

        builder.add_pass(
            "props.gbuffer",
            system=name,
            bind=lambda io: self._bind_gbuffer(io, seen),
            writes=("gbuffer.depth", *GBUFFER),
            creates=(
                TextureSpec(
                    "props.motion",
                    "rgba16f",
                    help="m, planet axes: to where the prop's surface was a frame ago; w: 1 where it was there",
                ),
            ),
            stage="objects",
            help="the visible props, instanced by mesh",
        )
        builder.add_pass(
            "props.shadow",
            system=name,
            kind="compute",
            bind=lambda io: self._bind_shadow(io, seen, tiles),
            reads=("gbuffer.depth", "gbuffer.normal", "gbuffer.surface"),
            creates=(
                TextureSpec("props.shadow", "rg8", help="share of sunlight and of skylight that props leave"),
                BufferSpec("props.touched", 4 * tiles[0] * tiles[1], help="tiles that a prop may reach"),
            ),
            only_while=lit,
            help="light that props take from the ground and from one another",
        )
        builder.add_pass(
            "props.tiles",
            system=name,
            kind="compute",
            bind=lambda io: self._bind_tiles(io, tiles),
            reads=("gbuffer.tile_flags", "props.touched"),
            creates=(BufferSpec("props.tile_list", 16 + 4 * tiles[0] * tiles[1], help="dispatch and tiles"),),
            only_while=lit,
            help="tiles with props or their shadows",
        )
        builder.add_pass(
            "props.shade",
            system=name,
            kind="compute",
            bind=self._bind_shade,
            reads=("gbuffer.depth", *GBUFFER, "props.shadow", "props.tile_list", *contract_reads(self._world)),
            writes=("scene.radiance",),
            stage="objects",
            only_while=lit,
            help="light of props; their shadows on the ground",
        )
        self._numbers.declare(
            builder, name, lambda: self._numbers_of(seen), lambda program: self._draw(program, seen), "objects"
        )

    def _bind_gbuffer(self, io: PassIO, view: _PropsView) -> Callable[[], None]:
        target = io.framebuffer(colors=(*GBUFFER, "props.motion"), depth="gbuffer.depth")
        motion = io.framebuffer(colors=("props.motion",))

        def run() -> None:
            motion.use()
            motion.clear()
            if view.visible is None or not view.visible.draws:
                return
            target.use()
            self._draw_state.apply()
            view.instances.buffer.bind_to_storage_buffer(0)
            for form, level, first, count in view.visible.draws:
                self._surface.set("u_first", first)
                self._meshes[form, level][1].render(moderngl.TRIANGLES, instances=count)

        return run

    @staticmethod
    def _numbers_of(view: _PropsView) -> NDArray[np.uint32]:
        entities = np.empty(0) if view.visible is None else view.visible.entities
        return entities.astype(np.uint32)

    def _draw(self, program: Program, view: _PropsView) -> None:
        """The visible props again, with another program."""
        assert view.visible is not None
        view.instances.buffer.bind_to_storage_buffer(0)
        for form, level, first, count in view.visible.draws:
            mesh, _, (_, vertices, indices) = self._meshes[form, level]
            held = self._numbered.get((form, level))
            if held is None or held[0] is not mesh:
                if held is not None:
                    self._gpu.free(held[1])
                array = self._gpu.vertex_array(program, [(vertices, "3f 12x", "in_position")], index=indices)
                held = self._numbered[form, level] = (mesh, array)
            program.set("u_first", first)
            held[1].render(moderngl.TRIANGLES, instances=count)

    def _bind_shadow(self, io: PassIO, view: _PropsView, tiles: tuple[int, int]) -> Callable[[], None]:
        left, touched = io.texture("props.shadow"), io.buffer("props.touched")
        textures = [io.texture(n) for n in ("gbuffer.depth", "gbuffer.normal", "gbuffer.surface")]

        def run() -> None:
            left.bind_to_image(0, read=False, write=True)
            view.occluders.buffer.bind_to_storage_buffer(0)
            touched.bind_to_storage_buffer(1)
            for unit, texture in enumerate(textures):
                texture.use(unit)
            self._shadow.set("u_count", 0 if view.visible is None else len(view.visible.occluders))
            self._shadow.run(*tiles)

        return run

    def _bind_tiles(self, io: PassIO, tiles: tuple[int, int]) -> Callable[[], None]:
        flags, listed = io.buffer("gbuffer.tile_flags"), io.buffer("props.tile_list")
        touched = io.buffer("props.touched")

        def run() -> None:
            flags.bind_to_storage_buffer(FLAG_BUFFER)
            listed.bind_to_storage_buffer(1)
            touched.bind_to_storage_buffer(2)
            self._list.set("u_tiles", tiles)
            self._list.run(1, 1, 1)

        return run

    def _bind_shade(self, io: PassIO) -> Callable[[], None]:
        radiance, tiles = io.texture("scene.radiance"), io.buffer("props.tile_list")
        textures = [(unit, io.texture(name)) for name, unit in (GBUFFER_UNITS | {"props.shadow": 4}).items()]
        bind_air = bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            radiance.bind_to_image(RADIANCE_IMAGE, read=True, write=True)
            tiles.bind_to_storage_buffer(TILE_BUFFER)
            for unit, texture in textures:
                texture.use(unit)
            self._shade.run_indirect(tiles)

        return run

    def statistics(self) -> dict[str, int]:
        view: _PropsView | None = self._views[0].found(self)
        if view is None or view.visible is None:
            return {}
        triangles = sum(len(self._meshes[form, level][0].indices) * n for form, level, _, n in view.visible.draws)
        return {"props": len(view.visible.instances), "triangles": triangles}
