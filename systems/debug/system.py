"""DebugSystem: shows one resource of the frame graph in place of the picture."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

from ...components.debug_view import DebugView
from ...engine.blocks.bindings import DEBUG_SOURCE_UNIT
from ...engine.frame import Frame, ViewInfo
from ...engine.graph import BufferSpec, GraphBuilder, GraphError, PassIO
from ...engine.system import Setup, System
from ...engine.world import World
from .views import MEASURES, MODES, NAMED_VIEWS, View, mode_for_format

__all__ = ["DebugSystem", "show_debug_view"]

_PICTURE = "composite.ldr"
_KINDS = {"Texture3D": 2, "TextureArray": 3}
_OFF = ("", "off", _PICTURE)


def show_debug_view(world: World, name: str, entity: int | None = None) -> None:
    """Choose a view: "off", a name of NAMED_VIEWS, or a resource of the frame graph.

    entity: where to put the component if the world has none yet. LookupError if there is none and no entity is given.
    """
    found = world.query(DebugView)
    if found:
        found[0][1][0].view = name
    elif entity is None:
        raise LookupError("the world has no DebugView component: give the entity that is to carry it")
    else:
        world.add(entity, DebugView(name))


class _ShaderKey(NamedTuple):
    kind: str
    file: str
    defines: tuple[tuple[str, int], ...]


class DebugSystem(System):
    """Needs DebugView. Without a view it declares no pass and owns no GL object.

    A change of the component's view raises `structure`: the frame graph is compiled again for the same frame. A name
    that the graph doesn't have is a GraphError from there, which names what is near.
    """

    name: ClassVar[str] = "debug"
    needs: ClassVar[tuple[type, ...]] = (DebugView,)

    def __init__(self) -> None:
        self._shown = "off"
        self._world: World

    def setup(self, setup: Setup) -> None:
        self._gpu, self._world = setup.gpu, setup.world
        self._objects: dict[_ShaderKey, Any] = {}

    def release(self) -> None:
        self._objects.clear()

    def update(self, frame: Frame) -> None:
        wanted = frame.world.query(DebugView)[0][1][0].view
        if wanted != self._shown:
            self._shown = wanted
            self.structure += 1

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        self._shown = self._world.query(DebugView)[0][1][0].view
        if self._shown in _OFF:
            for made in self._objects.values():
                made.release()
            self._objects.clear()
            return
        shown = NAMED_VIEWS.get(self._shown, View(self._shown))
        depth = ("gbuffer.depth",) if shown.resource != "gbuffer.depth" else ()
        builder.add_pass(
            "debug.range",
            bind=lambda io: self._bind_range(io, shown),
            system=self.name,
            kind="compute",
            reads=(shown.resource,),
            creates=(BufferSpec("debug.limits", 16, help="smallest and largest value"),),
            help=f"range of {shown.resource}",
        )
        builder.add_pass(
            "debug.view",
            bind=lambda io: self._bind_view(io, shown),
            system=self.name,
            reads=(shown.resource, "debug.limits"),
            reads_optional=depth,
            writes=(_PICTURE,),
            stage="debug",
            help=f"{shown.resource} in place of the picture",
        )

    def _made(self, kind: str, file: str, defines: dict[str, int]) -> Any:
        key = _ShaderKey(kind, file, tuple(sorted(defines.items())))
        if key not in self._objects:
            make = self._gpu.compute if kind == "compute" else self._gpu.fullscreen
            self._objects[key] = make(file, defines=defines)
        return self._objects[key]

    @staticmethod
    def _look_at(io: PassIO, shown: View) -> tuple[Any, View, dict[str, int]]:
        """The texture, the view with its mode settled, and the defines of its kind."""
        texture = io.texture(shown.resource)
        format = texture.extra.format
        mode = shown.mode or mode_for_format(shown.resource, format.name, format.components)
        kind = 1 if format.is_integer else _KINDS.get(type(texture).__name__, 0)
        if kind > 1 and mode in {"normal", "depth", "distance", "lod"}:
            raise GraphError(f"debug view of {shown.resource!r}: {mode} needs a 2D texture, found {texture.size}")
        return texture, View(shown.resource, mode), {"SOURCE": kind}

    def _bind_range(self, io: PassIO, shown: View) -> Callable[[], None]:
        texture, view, defines = self._look_at(io, shown)
        limits = io.buffer("debug.limits")
        if not view.needs_range:
            return lambda: None
        components = min(texture.extra.format.components, 3)
        measure = self._made(
            "compute", "debug/range.comp", {**defines, "MEASURE": MEASURES[view.mode], "COMPONENTS": components}
        )

        def run() -> None:
            texture.use(DEBUG_SOURCE_UNIT)
            limits.bind_to_storage_buffer(5)
            measure.run(1)

        return run

    def _bind_view(self, io: PassIO, shown: View) -> Callable[[], None]:
        texture, view, defines = self._look_at(io, shown)
        target = io.framebuffer(colors=(_PICTURE,))
        limits = io.buffer("debug.limits")
        depth = io.texture("gbuffer.depth") if io.has("gbuffer.depth") else texture
        draw = self._made("fullscreen", "debug/view.frag", {**defines, "MODE": MODES.index(view.mode)})
        plain = self._gpu.state()

        def run() -> None:
            target.use()
            plain.apply()
            texture.use(DEBUG_SOURCE_UNIT)
            depth.use(1)
            limits.bind_to_storage_buffer(5)
            draw.render()

        return run
