"""The overlay of two selections, and the ground that goes from one to the other after a snap."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure import snaps
from planetfall.benchmarks.measure.drawn import DrawnMesh
from planetfall.engine.surface.lattice import FULL_BITS, canonical_lattice
from planetfall.engine.surface.lattice_anchor import LatticeAnchor
from planetfall.engine.surface.overlay import held_edges, overlay
from planetfall.engine.surface.selection import cell_keys, neighbours_of, select_rings

EARTH_M = 6.371e6


def selected(direction, above_m, coverage_rad=np.pi, angle=0.02):
    anchor = LatticeAnchor(direction, EARTH_M)
    return select_rings(anchor, above_m, 0.0, EARTH_M, angle, coverage_rad=coverage_rad, min_spacing_m=1.0)


def spans(cells):
    """Sorted ranges of the Z-curve that cells cover."""
    start = cell_keys(cells)
    end = start + (np.int64(1) << 2 * (FULL_BITS - cells.level.astype(np.int64)))
    order = np.argsort(start)
    return start[order], end[order]


def length(cells):
    start, end = spans(cells)
    assert (start[1:] >= end[:-1]).all(), "no cell contains another"
    return int((end - start).sum())


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (((0.3, 0.5, 0.8), 1000.0), ((0.30003, 0.5, 0.8), 1000.0)),
        (((0.3, 0.5, 0.8), 1000.0), ((0.3, 0.5, 0.8), 1250.0)),
        (((1.0, 1.0, 0.2), 5e5), ((1.0, 1.01, 0.2), 4e5)),
        (((1.0, 1.0, 1.0), 2.0), ((-1.0, 0.3, 1.0), 1e7)),
    ],
)
def test_is_the_finer_of_both_everywhere(before, after):
    old, new = selected(*before), selected(*after)
    both = overlay(old, new)
    cells = both.cells
    assert length(cells) == length(new), "covers what the new selection covers"
    assert (np.diff(cells.distance_m) >= 0).all()
    for source, row in ((old, both.old_row), (new, both.new_row)):
        assert (row >= 0).all(), "both cover the planet"
        level = source.level[row].astype(np.int64)
        finer = cells.level - level
        assert (finer >= 0).all()
        assert (cells.i >> finer == source.i[row]).all() and (cells.j >> finer == source.j[row]).all()
        assert (cells.face == source.face[row]).all()
    coarser = np.minimum(cells.level - old.level[both.old_row], cells.level - new.level[both.new_row])
    assert (coarser == 0).all(), "each cell belongs to one of them"
    delta, _ = neighbours_of(*(a.astype(np.int64) for a in (cells.face, cells.level, cells.i, cells.j)))
    assert delta.max() <= cells.quads.bit_length() - 1, "balanced as both are"


def test_the_border_of_the_old_selection():
    old, new = selected((0.3, 0.5, 0.8), 1000.0, 0.05), selected((0.31, 0.5, 0.8), 1400.0, 0.06)
    both = overlay(old, new)
    assert length(both.cells) == length(new)
    assert (both.old_row < 0).any() and (both.new_row >= 0).all()


def test_edges_to_cells_without_a_past_are_held():
    old, new = selected((0.3, 0.5, 0.8), 1000.0, 0.05), selected((0.31, 0.5, 0.8), 1400.0, 0.06)
    both = overlay(old, new)
    unknown = both.old_row < 0
    cells = [a.astype(np.int64) for a in (both.cells.face, both.cells.level, both.cells.i, both.cells.j)]
    delta, beside = neighbours_of(*cells)
    held = held_edges(both.cells, beside, unknown)
    assert held[unknown].all()
    assert 0.0 < held[~unknown].mean() < 0.5
    # Each held edge is held from both sides.
    for row, edge in zip(*np.nonzero((beside >= 0) & (delta == 0)), strict=True):
        other = beside[row, edge]
        back = int(np.flatnonzero(beside[other] == row)[0])
        assert held[row, edge] == held[other, back]


def test_of_a_selection_with_itself():
    cells = selected((0.3, 0.5, 0.8), 1000.0)
    both = overlay(cells, cells)
    assert (both.old_row == both.new_row).all() and len(both.cells) == len(cells)


# -- drawn -----------------------------------------------------------------------------------------------------------


def flown(fade_s, view, step_m, outputs, frames=1, steps=40):
    """The first camera after a snap, and its pictures from then on."""
    overrides = {"terrain.fade_s": fade_s, "proxy.ahead_frames": 0}  # prepared ones: test_snap_ahead.py
    with pf.Renderer(pf.load_scene("earth"), size=(160, 90), quality="medium", overrides=overrides) as renderer:
        state = renderer.camera_state(pf.view(view))
        generation = None
        for camera in snaps.forward_path(state, step_m, steps):
            shot = pf.Camera(camera.position_m, camera.forward, camera.up)
            out = renderer.render(shot, outputs=outputs, dt_s=1.0)
            now = renderer.views[0].proxy.generation
            if generation is not None and now != generation:
                pictures = [out] + [renderer.render(shot, outputs=outputs, dt_s=0.05) for _ in range(frames)]
                return pictures, renderer.camera_state(shot)
            generation = now
    raise AssertionError("no snap")


@pytest.mark.gpu
def test_after_the_fade_the_picture_is_that_of_the_new_grid():
    outputs = ("position", "normal", "surface")  # colours: exposure remembers the way
    (_, *_, faded), _ = flown(0.3, "near", 4.0, outputs, frames=7)
    (_, *_, direct), _ = flown(0.0, "near", 4.0, outputs, frames=7)
    for name in outputs:
        assert np.array_equal(faded[name], direct[name], equal_nan=True), name


@pytest.mark.gpu
@pytest.mark.parametrize(("view", "step_m"), [("near", 4.0), ("high", 400.0)])
def test_the_ground_moves_little_at_a_snap_and_comes_to_where_it_belongs(view, step_m):
    """Without trees: at their edges one pixel may show ground before them and then ground far behind."""
    results = {}
    for fade_s in (0.3, 0.0):
        overrides = {"terrain.fade_s": fade_s, "proxy.ahead_frames": 0, "cover.density": 0.0, "cover.shrubs": 0.0}
        with pf.Renderer(pf.load_scene("earth"), size=(192, 108), quality="medium", overrides=overrides) as renderer:
            state = renderer.camera_state(pf.view(view))
            results[fade_s] = snaps.pops(renderer, list(snaps.forward_path(state, step_m, 40)), 2)
    faded, plain = results[0.3], results[0.0]
    assert faded.snaps == plain.snaps == 2
    # What is left at once is where diagonals of the two grids cross.
    assert snaps.Pops.quantile(faded.at_once, 0.99) < 0.5 * snaps.Pops.quantile(plain.at_once, 0.99)
    assert max(faded.a_frame) <= 0.25
    assert snaps.Pops.quantile(faded.in_all, 0.999) <= 1.0
    assert snaps.Pops.quantile(faded.in_all, 0.999) == pytest.approx(snaps.Pops.quantile(plain.in_all, 0.999))


@pytest.mark.gpu
def test_no_cracks_while_it_moves():
    pictures, _ = flown(0.3, "near", 4.0, ("surface", "distance"), frames=5)
    last = pictures[-1]
    for picture in pictures:
        # The same ground, but for pixels of the outline, which are at most a pixel off.
        sky = picture["surface"] == 0
        assert (sky != (last["surface"] == 0)).mean() < 1e-3
        holes = sky[1:-1] & ~sky[2:] & ~sky[:-2]
        assert not holes.any()


@pytest.mark.gpu
def test_no_cracks_along_the_border_of_the_old_grid():
    """A leap of a planet's size: much of what is seen lay beyond the old horizon."""
    zenith = np.array([[1.0, 0.0, 1.0], [0.0, -1.0, 1.0]]) / np.sqrt(2.0)
    forward, up = [-0.4322992945646518, 0.3584876793482363, -0.8274079427189591], [-0.8709, 0.0719, 0.4862]
    first = pf.Camera(zenith[0] * 2194037.7, -zenith[0], [0.0, 1.0, 0.0], fov_y_deg=90.0)
    then = pf.Camera(zenith[1] * 3188506.9, forward, up, fov_y_deg=90.0)
    with pf.Renderer(pf.load_scene("moon"), (160, 90), "low", {"terrain.backend": "grid"}) as renderer:
        renderer.render(first, dt_s=0.1)
        renderer.render(then, dt_s=0.1)
        fade = renderer.system("terrain").backend.view(renderer.views[0]).fade
        assert fade.running
        changed, starts = fade.read_changed(), fade.read_starts()
        mesh = replace(DrawnMesh.of(renderer), record=fade.mesh.read_cells(), vertices=fade.mesh.read_vertices())
    place = np.where(changed[:, None, None], starts, mesh.vertices["position_m"])[mesh.used]
    _, which = np.unique(canonical_lattice(*(a[mesh.used] for a in mesh.lattice)), axis=1, return_inverse=True)
    order = np.argsort(which, kind="stable")
    drawn = place[order]
    same = np.diff(which[order]) == 0
    assert same.sum() > 1000
    assert (drawn[1:][same] == drawn[:-1][same]).all(), "a lattice point is drawn in one place, whichever cell draws it"


@pytest.mark.gpu
def test_a_picture_by_itself_does_not_fade():
    with pf.Renderer(pf.load_scene("earth"), (96, 54), "low") as renderer:
        state = renderer.camera_state(pf.view("near"))
        for camera in snaps.forward_path(state, 4.0, 30):
            renderer.render(pf.Camera(camera.position_m, camera.forward, camera.up))
            assert not renderer.system("terrain").backend.view(renderer.views[0]).fade.running


@pytest.mark.gpu
def test_leaps_and_settling_do_not_fade():
    with pf.Renderer(pf.load_scene("earth"), size=(96, 54), quality="low") as renderer:
        fade = None
        for name in ("near", "high", "near"):
            renderer.render(pf.view(name))
            fade = renderer.system("terrain").backend.view(renderer.views[0]).fade
            assert not fade.running
        renderer.settle(pf.view("near"))
        assert not fade.running


@pytest.mark.gpu
@pytest.mark.parametrize(
    ("method", "step_m", "kept"), [("ours", 6.0, True), ("paper", 6.0, True), ("paper", 7e4, False)]
)
def test_the_debug_view_shows_both_meshes(method, step_m, kept):
    """Ours keeps nearly all edges, and so does the source's grid while its middle stays; ten of its cells farther it is
    placed anew, and all of its edges are others."""
    overrides = {"terrain.method": method}
    with pf.Renderer(pf.load_scene("earth"), size=(320, 180), quality="medium", overrides=overrides) as renderer:
        renderer.scene.environment.add(pf.DebugView("snap_overlay"))
        state = renderer.camera_state(pf.view("near"))
        before, out = None, None
        for camera in snaps.forward_path(state, step_m, 20):
            out = renderer.render(pf.Camera(camera.position_m, camera.forward, camera.up))["color"].astype(int)
            own = renderer.system("terrain").backend.view(renderer.views[0])
            now = renderer.views[0].proxy.generation if kept else own.moves
            if before is not None and now != before:
                break
            before = now
        else:
            pytest.fail("no snap was seen")
        red, green = out[..., 0] > 128, out[..., 1] > 128
        assert red.any() and green.any()
        near = slice(0 if kept else 120, None)  # far edges are as dense as pixels
        only, both = np.mean((red ^ green)[near]), np.mean((red & green)[near])
        assert both > 4.0 * only if kept else both < 0.5 * only


@pytest.mark.gpu
@pytest.mark.parametrize("backend", ["grid", "quadtree"])
def test_two_debug_pictures_of_one_frame(backend):
    """Both are drawn by one program with one mesh."""
    both = ("debug.wireframe", "debug.snap_overlay")
    with pf.Renderer(pf.load_scene("earth"), (96, 54), "low", {"terrain.backend": backend}) as renderer:
        together = renderer.render(pf.view("near"), outputs=both)
        assert all(together[name].any() for name in both)
