"""TiledBackend: tiles of a tree of cells, chosen by their measured error, made once and kept.

Heights lie in slots, whole tiles at a time, made within a time a frame; a tile's parent is drawn until all four
children are there. Vertices are assembled from heights when a tile's edges or morph or the anchor change.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ....components import Ocean, Planet
from ....engine.frame import Frame, View, ViewInfo, Views
from ....engine.gpu import GpuScope
from ....engine.graph import GraphBuilder, PassIO, TextureSpec
from ....engine.settings import Settings
from ....engine.space.frustum import frustum_planes
from ....engine.surface.footing import footing
from ....engine.surface.forest import Forest, Selection
from ....engine.surface.selection import LARGEST_SHARE
from ..tiles.maker import BATCH, Made, TileMaker
from ..tiles.pool import SlotPool
from ..tiles.queries import heights_on_tiles
from ..tiles.shape import TileShape
from .base import Backend, Ground, heights_seen
from .tile_view import Asked, ForestKey, SplitBy, TileInputs, TilesShown, TileView

__all__ = ["TiledBackend"]

Ints = NDArray[np.int64]

_AT_ONCE_S = 0.25
"""Time a frame for new tiles while nobody looks."""
_FLAT = 2.0
"""Vertices of flat ground lie no farther apart than this many times terrain.edge_px on the screen."""
_CHORD_M = 2.0
"""Where the sphere bulges this far above their triangles, no farther than terrain.edge_px."""
_WIDE_PX = 3.0
"""Nor, where they are farther apart than mountain belts are wide, than this: from space a planet is a few tiles."""
_SLOT_COLUMNS = 64  # of the picture of all slots
_STEEPEST = 0.5
"""Of the camera's height above the ground: so far apart may vertices be below it in the first frame after a leap. A
triangle misses slopes of one by half of its edge at most."""
_MOST_SHOWN = 0.7
"""Of all slots: the rest is for parents, and for what is seen next."""


class TiledBackend(Backend):
    """What quadtree and icosphere share; they say which shape their tiles have."""

    assemble_file: ClassVar[str] = "terrain/tiles/assemble.comp"
    morphs: ClassVar[bool] = True
    """Whether tiles change gradually into their parents and children."""

    def __init__(self, gpu: GpuScope, settings: Settings, views: Views) -> None:
        super().__init__(gpu, settings, views)
        self.shape = self.make_shape(int(settings["terrain.tile_quads"]))
        self._slots = int(settings["terrain.slots"])
        self.pool = SlotPool(self._slots)
        self.maker = TileMaker(gpu, self.shape, self._slots)
        defines = self.shape.defines
        self._assemble = gpu.compute(self.assemble_file, defines=defines)
        self._cull = gpu.compute("common/cull_cells.comp", defines=defines)
        self._facts: dict[int, tuple[float, float, float]] = {}
        self._under_way: set[int] = set()  # tiles that are being made
        self._ground: Ground | None = None
        self._budget_s = 1e-3 * float(settings["terrain.budget_ms"])
        self._asked_px = self._asked(settings)
        self._radius_m = 1.0
        self.made = 0
        """Counts the tiles made so far."""
        self.assembled = 0
        """Counts the tiles assembled so far."""

    @abstractmethod
    def make_shape(self, segments: int) -> TileShape:
        """The tiles' shape."""

    def view(self, view: View) -> TileView:
        """One view's tiles."""
        return view.state(self, lambda: TileView(self.gpu, self.shape, self._slots, view))

    # -- frame -------------------------------------------------------------------------------------------------------

    def update(self, frame: Frame) -> None:
        ground = self.ground
        self._radius_m = ground.params.radius_m
        if self._ground is None or ground.revision != self._ground.revision:
            self._restart(ground)
        view = self.view(frame.view)
        view.inputs, view.at_once = self._inputs(frame), frame.settling
        self._retune(frame.settings)
        forest = self._forest(view, frame, ground)
        view.frozen = frame.frozen and view.whole  # tiles of another backend or ground come first
        self._collect(wait=frame.settling)
        self._make_roots(view)
        selection = self._select(view, forest, frame)
        if len(view.queue) and not view.frozen and self._stand(view, forest, frame, ground):
            selection = self._select(view, forest, frame)
        view.under_way &= self._under_way
        view.whole = view.whole or not (len(view.queue) or selection.moving)
        if selection.revision != view.revision:
            view.revision = selection.revision
            view.mesh.take(selection, self.pool.slots(selection.keys), self._radius_m, self.morphs)
        proxy = frame.view.proxy
        view.anchor_height_m = proxy.anchor_height_m
        view.mesh.around(proxy.generation)
        view.keep_dh_m = heights_seen(frame, proxy.anchor_height_m)
        if not view.frozen and frame.view.seen.ground():
            view.wanted = TilesShown(view.revision, proxy.generation, frame.camera.stamp, view.keep_dh_m)

    def rests(self, frame: Frame) -> bool:
        if super().rests(frame):
            return True
        view: TileView | None = frame.view.found(self)
        if view is None or view.forest is None or view.inputs != self._inputs(frame):
            return False
        return view.forest.at_rest(frame.camera.position_m) and self.settled(frame.view)

    def _inputs(self, frame: Frame) -> TileInputs:
        proxy, settings = frame.view.proxy.generation, frame.settings
        finest_m = float(settings["terrain.min_spacing_m"])
        return TileInputs(self.ground.revision, proxy, frame.pixel_rad, self._asked(settings), finest_m)

    @staticmethod
    def _asked(settings: Settings) -> Asked:
        return Asked(float(settings["terrain.error_px"]), float(settings["terrain.edge_px"]))

    def _retune(self, settings: Settings) -> None:
        """Forests hear of all tiles again where what they are told depends on knobs that have changed."""
        asked = self._asked(settings)
        if asked == self._asked_px:
            return
        self._asked_px = asked
        for view in self.views.states(self, TileView):
            if view.forest is not None:
                self._tell_all(view)

    def _restart(self, ground: Ground) -> None:
        """Other ground: nothing that was made is of use."""
        self._ground = ground
        self.maker.use(ground.params, ground.complete_table)
        self.pool.clear()
        self._facts.clear()
        self._under_way.clear()
        for view in self.views.states(self, TileView):
            view.forest, view.queue = None, np.zeros(0, np.int64)

    def _forest(self, view: TileView, frame: Frame, ground: Ground) -> Forest:
        params = ground.params
        sea = frame.world.try_get(frame.planet, Ocean)
        radius = frame.world.get(frame.planet, Planet).radius_m
        above = sea is not None and frame.camera.altitude_m(radius) >= sea.sea_level_m
        level = sea.sea_level_m if sea is not None and above else -np.inf
        key, old = ForestKey(ground.revision, level, self.split_by(frame)), view.key
        # Whatever lens or depth of the camera.
        held = frame.frozen and view.whole and old is not None and key.ground == old.ground
        if view.forest is None or (key != old and not held):
            view.key, view.hidden_below_m = key, level
            view.forest = self.make_forest(ground, max(params.lowest_m, level), frame)
            view.revision, view.selection, view.whole = -1, None, False
            self._tell_all(view)
        return view.forest

    def split_by(self, frame: Frame) -> SplitBy | None:
        """What its forests split by, if that is distance."""
        return None

    def make_forest(self, ground: Ground, occluder_m: float, frame: Frame) -> Forest:
        """The forest that selects. occluder_m: height of the sphere that hides what is behind it."""
        params = ground.params
        return Forest(
            self.shape.scheme,
            params.radius_m,
            params.lowest_m,
            params.highest_m,
            self.shape.segments,
            occluder_m=occluder_m,
        )

    def _tell_all(self, view: TileView) -> None:
        """A forest hears of all tiles that there are."""
        if self._facts:
            keys = np.array(list(self._facts), np.int64)
            facts = np.array(list(self._facts.values()))
            self._tell(view, Made(keys, facts[:, 0], facts[:, 1], facts[:, 2]))

    def _tell(self, view: TileView, made: Made) -> None:
        """A forest hears of tiles; below an opaque sea no error counts."""
        assert view.forest is not None
        scheme = self.shape.scheme
        spacing_m = self._radius_m * scheme.spacing_rad(scheme.level(made.keys), self.shape.segments)
        # Colours and normals come from the vertices, too: flat ground also has them no farther apart than this. Where
        # chords lie metres below the sphere, shading takes heights from the vertices as well.
        error_px, edge_px = self._asked_px
        longest_px = np.where(spacing_m**2 > 8.0 * _CHORD_M * self._radius_m, edge_px, _FLAT * edge_px)
        longest_px[spacing_m > LARGEST_SHARE * self._radius_m] = _WIDE_PX
        error = np.maximum(made.error_m, spacing_m * error_px / longest_px)
        error[made.high_m < view.hidden_below_m] = 0.0
        view.forest.set_facts(made.keys, made.low_m, made.high_m, error)

    def _collect(self, wait: bool) -> None:
        """Facts of tiles that have been made: from now on they can be drawn."""
        for found in self.maker.collect(wait):
            there = self.pool.slots(found.keys) >= 0
            made = Made(found.keys[there], found.low_m[there], found.high_m[there], found.error_m[there])
            facts = zip(made.low_m.tolist(), made.high_m.tolist(), made.error_m.tolist(), strict=True)
            self._under_way.difference_update(found.keys.tolist())
            self._facts.update(zip(made.keys.tolist(), facts, strict=True))
            for view in self.views.states(self, TileView):
                if view.forest is not None:
                    self._tell(view, made)

    def _make_roots(self, view: TileView) -> None:
        """Coarse ground is there at once, whatever it costs: everything else has it to fall back on."""
        roots = self.shape.scheme.root_keys()
        if self.pool.slots(roots).min() >= 0:
            return
        keys = np.concatenate([roots, self.shape.scheme.children(roots).ravel()])
        while len(keys):
            self._collect(wait=True)  # so that there is room for results
            part, keys = keys[:BATCH], keys[BATCH:]
            self._start(view, part)
            self._collect(wait=True)

    def _stand(self, view: TileView, forest: Forest, frame: Frame, ground: Ground) -> bool:
        """Ground below the camera as fine as the camera is near to it, at once: after a leap what is there may reach
        above the camera, which would look through it. Whether anything was made."""
        scheme, position = self.shape.scheme, frame.camera.position_m
        distance = float(np.linalg.norm(position))
        down = position / distance
        above_m = distance - self._radius_m - float(ground.field.height(down[None])[0])
        finest_m = float(frame.settings["terrain.min_spacing_m"])
        spacing_m = self._radius_m * scheme.spacing_rad(np.arange(scheme.finest_level), self.shape.segments)
        level = int((spacing_m > max(_STEEPEST * above_m, finest_m)).sum())
        keys = footing(scheme, down, min(level, scheme.finest_level - 6))
        forest.touch(keys)
        keys = keys[self.pool.slots(keys) < 0]
        keys = keys[: self._vacate(len(keys))]  # at once: what is new counts as of no use until it is drawn
        for first in range(0, len(keys), BATCH):
            if not self._start(view, keys[first : first + BATCH]):
                break
            self._collect(wait=True)
        return len(keys) > 0

    def _select(self, view: TileView, forest: Forest, frame: Frame) -> Selection:
        camera, settings = frame.camera, frame.settings
        if view.frozen and view.selection is not None:
            return view.selection
        pixel = frame.pixel_rad
        velocity = None
        if view.eye_m is not None and frame.dt_s > 0.0 and not (frame.cut or frame.settling):
            velocity = (camera.position_m - view.eye_m) / frame.dt_s
        view.eye_m = camera.position_m.copy()
        view.clock_s += frame.dt_s
        selection = forest.select(
            camera.position_m,
            pixel,
            float(settings["terrain.error_px"]),
            None if frame.settling or frame.cut or not self.morphs else view.clock_s,
            velocity_m_s=velocity,
            finest_spacing_m=float(settings["terrain.min_spacing_m"]),
            max_tiles=int(_MOST_SHOWN * self._slots),
            planes=frustum_planes(camera),
        )
        view.selection = selection
        wanted = selection.wanted
        missing = self.pool.slots(wanted) < 0
        view.queue = wanted[missing]
        # Others may have begun them.
        view.under_way |= self._under_way.intersection(wanted[~missing].tolist())
        return selection

    # -- making ------------------------------------------------------------------------------------------------------

    def _work(self, view: TileView) -> None:
        """As many of the wanted tiles as fit into this frame's time."""
        room = self.maker.room(_AT_ONCE_S if view.at_once else self._budget_s)
        while room > 0 and len(view.queue):
            part, view.queue = view.queue[: min(room, BATCH)], view.queue[min(room, BATCH) :]
            room -= len(part)
            if not self._start(view, part):
                break

    def _start(self, view: TileView, keys: Ints) -> bool:
        keys = keys[: self._vacate(len(keys))]
        if not len(keys):
            view.queue = keys  # no room: what there is has to do
            return False
        slots = self.pool.take(keys)
        self.bind_octaves(view.of)  # with the maps; the maker then binds its own table
        if not self.maker.make(keys, slots, self._radius_m):
            self.pool.drop(keys)
            return False
        for each in self.views.states(self, TileView):
            each.mesh.forget(slots)
        self._under_way.update(keys.tolist())
        view.under_way.update(keys.tolist())
        view.made += len(keys)
        self.made += len(keys)
        return True

    def _vacate(self, count: int) -> int:
        """Free slots for that many tiles; how many there are."""
        short = count - self.pool.free
        if short > 0:
            forests = [v.forest for v in self.views.states(self, TileView) if v.forest is not None]
            spare: Ints | None = None
            for forest in forests:
                droppable = forest.droppable(short if len(forests) == 1 else self._slots)
                spare = droppable if spare is None else spare[np.isin(spare, droppable)]
            if spare is not None and len(spare):
                spare = spare[:short]
                for forest in forests:
                    forest.forget(spare)
                self.pool.drop(spare)
                for key in spare.tolist():
                    self._facts.pop(key, None)
        return min(count, self.pool.free)

    # -- passes ------------------------------------------------------------------------------------------------------

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        tiles = self.view(view.view)
        builder.add_pass(
            "terrain.tiles",
            kind="compute",
            system="terrain",
            bind=lambda io: lambda: self._work(tiles),
            side_effect=True,
            when=lambda: len(tiles.queue) > 0,
            help="heights of tiles that are wanted and not there, within terrain.budget_ms",
        )
        builder.add_pass(
            "terrain.vertices",
            kind="compute",
            system="terrain",
            bind=lambda io: self._bind_assemble(io, tiles),
            creates=tiles.mesh.vertex_buffers(),
            after=("terrain.tiles",),
            when=lambda: tiles.mesh.stale,
            help="vertices of tiles that are new, morph, or have another anchor, from their heights",
        )
        builder.add_pass(
            "terrain.cull",
            kind="compute",
            system="terrain",
            bind=lambda io: self._bind_cull(io, tiles),
            reads=("terrain.bounds", "terrain.vertices"),
            creates=tiles.mesh.cull_buffers(),
            when=lambda: tiles.culled != tiles.wanted,
            help="tiles inside the frustum and above the horizon, into an indirect draw",
        )
        builder.add_pass(
            "terrain.morph",
            system="terrain",
            bind=lambda io: self._bind_morph(io, view.view),
            reads=self.draw_reads(view.view),
            creates=(TextureSpec("debug.morph", "rgba8"), TextureSpec("debug.morph_depth", "depth32f")),
            help="how far each tile has become its parent: blue as itself, yellow as its parent",
        )
        rows = -(-self._slots // _SLOT_COLUMNS)
        builder.add_pass(
            "terrain.slots",
            system="terrain",
            bind=lambda io: self._bind_slots(io, tiles),
            creates=(TextureSpec("debug.slots", "rgba8", (_SLOT_COLUMNS, rows)),),
            help="what is in each slot: nothing dark, a tile of a level that is not drawn dim, one that is bright",
        )

    def _bind_assemble(self, io: PassIO, view: TileView) -> Callable[[], None]:
        view.mesh.attach_vertices(io)

        def run() -> None:
            steps = self.maker.steps_per_m
            anchor = round(view.anchor_height_m * steps)
            self.assembled += view.mesh.assemble(self._assemble, self.maker.slots, anchor, 1.0 / steps)

        return run

    def _bind_cull(self, io: PassIO, view: TileView) -> Callable[[], None]:
        if view.mesh.attach_visible(io):
            view.culled = None

        def run() -> None:
            view.mesh.cull(self._cull, view.keep_dh_m)
            view.culled = view.wanted

        return run

    def _bind_morph(self, io: PassIO, view: View) -> Callable[[], None]:
        target = io.framebuffer(colors=("debug.morph",), depth="debug.morph_depth")
        state = self.gpu.state(depth_test=True, depth_func=">=", cull="back")
        draw = self.bind_draw(io, view, "terrain/tiles/morph.frag")
        mesh = self.view(view).mesh

        def run() -> None:
            target.use()
            target.clear(0.0, 0.0, 0.0, 0.0, depth=0.0)
            state.apply()
            mesh.bind_morphs()
            draw()

        return run

    def _bind_slots(self, io: PassIO, view: TileView) -> Callable[[], None]:
        picture = io.texture("debug.slots")
        levels = np.arange(32)[:, None] * 0.381966 + np.array([0.0, 2.0 / 3.0, 1.0 / 3.0])
        hues = np.clip(np.abs(levels % 1.0 * 6.0 - 3.0) - 1.0, 0.0, 1.0)  # as in terrain/wireframe.frag

        def run() -> None:
            colors = np.zeros((picture.size[0] * picture.size[1], 4), np.uint8)
            used = np.flatnonzero(self.pool.keys)
            bright = np.where(np.isin(used, view.mesh.rows["slot"]), 255, 90)[:, None]
            colors[used, :3] = hues[self.shape.scheme.level(self.pool.keys[used])] * bright
            colors[:, 3] = 255
            picture.write(colors.tobytes())

        return run

    def draw_reads(self, view: View) -> tuple[str, ...]:
        return ("terrain.vertices", "terrain.visible", "terrain.arguments")

    def bind_draw(self, io: PassIO, view: View, fragment: str) -> Callable[[], None]:
        program = self.draw_program(fragment, "terrain/tiles/gbuffer.vert", self.shape.defines)
        mesh = self.view(view).mesh
        tiles = mesh.vertex_array(program)
        return lambda: mesh.draw(tiles)

    # -- questions ---------------------------------------------------------------------------------------------------

    def settled(self, view: View) -> bool:
        own: TileView | None = view.found(self)
        if own is None:
            return True
        moving = own.selection is not None and own.selection.moving
        done = not (moving or len(own.queue) or own.under_way)
        if done:
            own.settled_at = own.made
        return done

    def progress(self, view: View) -> float:
        """Of the tiles known to be wanted (they name others); stands still where there is no room for all of them."""
        own: TileView | None = view.found(self)
        if own is None or self.settled(view):
            return 1.0
        made = min(own.made - own.settled_at, self._slots)
        return made / (made + max(len(own.queue), 1))

    def statistics(self) -> dict[str, int]:
        view: TileView | None = self.views[0].found(self)
        return {} if view is None else view.mesh.statistics()

    def height_drawn(self, directions: NDArray[np.float64], view: View) -> NDArray[np.float64]:
        own: TileView | None = view.found(self)
        if own is None or not own.mesh.count:
            return super().height_drawn(directions, view)
        return heights_on_tiles(own.mesh, directions, view.proxy)

    def release(self) -> None:
        self.maker.release()
        super().release()
