"""SnappedMesh: cells around a view's held proxy, from their choice to the list of those that are seen.

What is chosen and made depends on the proxy alone: a frame in which it holds only culls and draws, and one in which the
camera holds too only draws. At a snap the cells are chosen anew, or taken over with their vertices where they were
prepared; the old surface may lead to the new one over a moment.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar, Generic, TypeVar

from ..frame import Frame, Proxy, ViewParts
from ..frame.snapping import HeldScale, Scale, SnapAhead
from ..gpu import GpuScope
from ..gpu.cell_mesh import CellMesh, CellPrograms
from ..graph import BufferSpec, GraphBuilder, PassIO
from ..surface.decimation import topology
from .ahead import MeshAhead
from .choice import CellChoice, DrawnCells, MeshKey, Shown
from .fade import FadePrograms, SnapFade

__all__ = ["SnappedMesh"]

C = TypeVar("C", bound=CellChoice)
_LEAP = 2.0  # snaps over more than this many heights above the ground don't fade


class SnappedMesh(ViewParts, Generic[C]):
    """One view's, of one kind of surface; a subclass says which cells there are and binds what their vertices read.

    of: scope of the owner. name: of buffers and passes. programs: shared by all views. prepares: whether the next snap
    is made ahead (proxy.ahead_frames). fading: None for a surface that jumps.
    """

    phases: ClassVar[tuple[str, ...]]
    """Those of a snap that is prepared (engine/frame/snapping.py): that of the vertices, and what comes later."""
    ahead_reads: ClassVar[tuple[str, ...]] = ()
    """Another maker's buffers that vertices for the next snap are made from, where there are any."""
    keep_dh_m: tuple[float, float] = (-3.0e38, 3.0e38)
    hides = True
    """As for CellMesh.cull."""

    def __init__(
        self, of: GpuScope, name: str, programs: CellPrograms, prepares: bool, fading: FadePrograms | None = None
    ) -> None:
        super().__init__(of)
        self._programs, self._prepares = programs, prepares
        self.mesh = CellMesh(self.gpu, name, programs.quads)
        ahead = CellMesh(self.gpu, f"{name}_ahead", programs.quads)
        self.ahead = MeshAhead(ahead, self.phases[0], self._make, programs.agree)
        self.fade = None if fading is None else SnapFade(self.gpu, self.mesh, fading)
        self.choice: C | None = None
        self.faded: C | None = None
        """The one before, which fades out."""
        self.key: MeshKey | None = None
        self.scale = Scale(0.0, 0.0)
        """What the cells were chosen for."""
        self.made: int | None = None
        """The selection whose vertices exist."""
        self._held = HeldScale()
        self._prepared = -1  # the selection that `ahead` has the vertices of in the frame of the snap
        self._wanted: Shown | None = None
        self.culled: Shown | None = None
        """What the visible list was made for."""
        self._snap: SnapAhead | None = None

    def release(self) -> None:
        if self._snap is not None:
            self._snap.take_part(False, *self.phases)
        super().release()

    # -- what differs ------------------------------------------------------------------------------------------------

    @abstractmethod
    def surface(self, frame: Frame) -> tuple[object, ...]:
        """What the cells depend on beside proxy and scale."""

    @abstractmethod
    def choose(self, frame: Frame, proxy: Proxy, scale: Scale) -> C:
        """The cells for a proxy: a function of it and of settings, whatever the camera does."""

    @abstractmethod
    def bind(self, choice: C, first: int, snap: SnapAhead | None) -> None:
        """Bind what the vertices from cell `first` on are made of. snap: it is prepared; None: it is the frame's."""

    @abstractmethod
    def most_skipped(self, choice: C) -> int:
        """Powers of two that a cell may skip."""

    # -- frame -------------------------------------------------------------------------------------------------------

    @property
    def drawn(self) -> CellMesh:
        """What is drawn: the overlay of two selections for a moment after a snap."""
        return self.fade.mesh if self.fade is not None and self.fade.running else self.mesh

    def follow(self, frame: Frame) -> tuple[bool, bool]:
        """CPU work of one frame. Whether other cells were chosen, and whether buffers of the graph grew."""
        proxy, surface = frame.view.proxy, self.surface(frame)
        now = Scale(float(frame.settings["terrain.edge_px"]), frame.pixel_rad)
        self._snap = snap = frame.view.snap
        snap.take_part(True, *self.phases)
        self._prepared = -1
        key, held = MeshKey(proxy.generation, surface), self._held
        if key == self.key:
            if not frame.frozen:
                held.follow(snap, *now)
        else:
            held.value = self.ahead.scale if self.ahead.complete(key) else now
        same = self.key is not None and key.surface == self.key.surface and held.value.edge_px == self.scale.edge_px
        fades = same and not frame.at_once
        if self.fade is not None:
            self.fade.advance(frame.dt_s)
            if not fades:
                self.fade.stop()
        snapped, grew = (key, held.value) != (self.key, self.scale), False
        if snapped:
            self.key, self.scale = key, held.value
            fades = fades and self.made == self.mesh.selection and self.mesh.count > 0
            # After a leap the old cells were not made for the place, and nobody sees a fade; what waited is no leap.
            leaps = proxy.cell.snap_distance_m > _LEAP * proxy.cell.altitude_above_ground_m
            grew = self._take(frame, proxy, fades and (self.ahead.complete(key) or not leaps))
        if frame.goes_on and snap.proxy is None and self._prepared < 0:
            grew |= self.ahead.mesh.reserve(self.mesh.capacity) | self._reserve_fade(self.mesh.capacity)
        if (there := snap.proxy) is not None:
            then = MeshKey(there.generation, surface)
            if "ground" in self.phases:
                snap.ground = self.ahead
            grew |= self.ahead.advance(snap, then, now, lambda: self.choose(frame, there, now))
            grew |= self._lay(snap, then) | self._reserve_fade(snap.room)
        return snapped, grew

    def rests(self, frame: Frame) -> bool:
        """Whether `follow` would do nothing: no other cells, nothing to prepare and no fade."""
        snap, fade = frame.view.snap, self.fade
        now = Scale(float(frame.settings["terrain.edge_px"]), frame.pixel_rad)
        return (
            snap.proxy is None
            and self._prepared < 0
            and self.made == self.mesh.selection
            and self.key == MeshKey(frame.view.proxy.generation, self.surface(frame))
            and (fade is None or not fade.running)
            and self._held.suits(snap, *now)
        )

    def _take(self, frame: Frame, proxy: Proxy, fades: bool) -> bool:
        """The cells of `key` and `scale`: those that were prepared, or new ones at once."""
        fade, ahead, old = self.fade, self.ahead, self.choice
        assert self.key is not None
        prepared = ahead.complete(self.key)
        laid = prepared and fade is not None and fade.laid
        if fade is not None and fades and old is not None and not laid:
            fade.keep(old)
        if prepared and ahead.choice is not None:
            new = ahead.choice
            grew = self.mesh.take(ahead.mesh)
            self.made = None if grew else self.mesh.selection
            self._prepared = self.mesh.selection
        else:
            new = self.choose(frame, proxy, self.scale)
            grew = self.mesh.upload(new.cells, topology(new.cells))
        self.choice, self.faded = new, old
        if fade is None:
            return grew
        if not fades:
            fade.stop()
        elif laid:
            fade.start()
        else:
            grew |= fade.begin(new)
        return grew

    def _reserve_fade(self, room: int) -> bool:
        return self.fade is not None and self.fade.reserve(room)

    def _lay(self, snap: SnapAhead, key: MeshKey) -> bool:
        """Prepare the overlay, if that is due. True where buffers of the graph grew."""
        fade, ahead = self.fade, self.ahead
        if snap.phase != "fade" or "fade" not in self.phases:
            return False
        # A setting changed after the vertices were made: they are made at once at the snap.
        if fade is None or self.choice is None or ahead.choice is None or not ahead.begun(snap, key):
            snap.finish("fade")
        elif not fade.running and not fade.laying:
            return fade.lay(self.choice, ahead.choice, ahead.mesh)
        return False

    def look(self, frame: Frame) -> None:
        """What of the cells may be seen in this frame; where it is frozen, what could be seen of the same cells."""
        mesh, culled = self.drawn, self.culled
        wanted = Shown(DrawnCells(mesh.name, mesh.selection), frame.camera.stamp, self.keep_dh_m)
        held = frame.frozen and culled is not None and culled == self._wanted and culled.cells == wanted.cells
        if frame.view.seen.ground() and not held:
            self._wanted = wanted

    # -- passes ------------------------------------------------------------------------------------------------------

    def declare(self, builder: GraphBuilder, system: str) -> None:
        """The passes up to the indirect draw."""
        name, mesh, fade = self.mesh.name, self.mesh, self.fade
        builder.add_pass(
            f"{name}.vertices",
            kind="compute",
            system=system,
            bind=self._bind_vertices,
            creates=mesh.vertex_buffers(),
            when=lambda: self.made != mesh.selection,
            help="vertices and bounds of all selected cells, on a snap of the proxy",
        )
        if self._prepares:
            builder.add_pass(
                f"{name}.ahead",
                kind="compute",
                system=system,
                bind=self.ahead.bind,
                reads_optional=self.ahead_reads,
                creates=self.ahead.mesh.vertex_buffers(),
                after=(f"{name}.vertices",),
                when=lambda: self.ahead.due,
                side_effect=True,
                help="a share of the vertices for the next snap of the proxy, before it comes",
            )
        if fade is not None:
            builder.add_pass(
                f"{name}.fade",
                kind="compute",
                system=system,
                bind=lambda io: self._bind_fade(io, fade),
                reads=(f"{name}.vertices", *((f"{name}_ahead.vertices",) if self._prepares else ())),
                creates=fade.buffers(),
                when=lambda: fade.pending or fade.laying,
                help="the overlay of the old and the new selection, at a snap or a share of it before",
            )
        meshes = self._meshes()
        builder.add_pass(
            f"{name}.cull",
            kind="compute",
            system=system,
            bind=self.bind_cull,
            reads=tuple(f"{each.name}.{part}" for each in meshes for part in ("bounds", "vertices")),
            creates=(*(buffer for each in meshes for buffer in each.cull_buffers()), *self.lists()),
            when=lambda: self.culled != self._wanted,
            help="cells inside the frustum and above the horizon, into an indirect draw",
        )

    def _meshes(self) -> tuple[CellMesh, ...]:
        return (self.mesh,) if self.fade is None else (self.mesh, self.fade.mesh)

    def lists(self) -> tuple[BufferSpec, ...]:
        """What culling makes beside the indirect draws."""
        return ()

    def draw_reads(self) -> tuple[str, ...]:
        """Resources of the graph that a draw reads."""
        names = tuple(f"{each.name}.{n}" for each in self._meshes() for n in ("vertices", "visible", "arguments"))
        return names if self.fade is None else (*names, f"{self.fade.mesh.name}.starts")

    def _make(self, mesh: CellMesh, choice: C, first: int, count: int, snap: SnapAhead | None) -> None:
        self.bind(choice, first, snap)
        mesh.make_part(
            self._programs, choice.eye_m, choice.edge_rad, choice.chord_m, self.most_skipped(choice), first, count
        )

    def _bind_vertices(self, io: PassIO) -> Callable[[], None]:
        if self.mesh.attach_vertices(io):  # else what is in them still holds
            self.made = None

        def run() -> None:
            mesh, choice = self.mesh, self.choice
            if self._prepared == mesh.selection:  # there was no room for them yet
                mesh.take_vertices(self.ahead.mesh)
            elif choice is not None and mesh.count:
                self._make(mesh, choice, 0, mesh.count, None)
                mesh.agree(self._programs.agree)
            self.made = mesh.selection

        return run

    def _bind_fade(self, io: PassIO, fade: SnapFade) -> Callable[[], None]:
        whole = fade.bind(io)

        def run() -> None:
            whole()
            snap = self._snap
            if snap is None or snap.phase != "fade" or not fade.laying:
                return
            if fade.lay_part(snap.part("fade", fade.mesh.count, fade.mesh.part_step)):
                snap.finish("fade")

        return run

    def bind_cull(self, io: PassIO) -> Callable[[], None]:
        """The pass that lists what is seen."""
        if any([mesh.attach_visible(io) for mesh in self._meshes()]):  # else what is in them still holds
            self.culled = None

        def run() -> None:
            self.drawn.cull(self._programs.cull, self.keep_dh_m, self.hides)
            self.culled = self._wanted

        return run
