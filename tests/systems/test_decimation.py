"""Decimated cells: one rule on both sides of every edge, on the CPU and on the GPU, and a surface without cracks."""

from __future__ import annotations

import itertools
from collections import Counter

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.surface.decimation import MOST, VARIANTS, agree, decimated_indices, topology, variant_skips
from planetfall.engine.surface.lattice import canonical_lattice, direction_of
from planetfall.engine.surface.selection import select_rings

FULL_BITS = 30


def random_selection(seed, quads=8):
    rng = np.random.default_rng(seed)
    # Face middles, edges and corners of the cube among them.
    direction = rng.normal(size=3) if seed % 3 else np.sign(rng.normal(size=3)) * (1.0, 1.0 + 1e-6 * seed, 1.0)
    direction = direction / np.linalg.norm(direction)
    radius = float(10.0 ** rng.uniform(3.0, 7.8))
    altitude = float(radius * 10.0 ** rng.uniform(-6.0, 1.0))
    return select_rings(direction, altitude, 0.0, radius, 0.06, quads, min_spacing_m=1e-6 * radius)


def border_segments(cells, skip, mask):
    """Each cell's border as pairs of canonical lattice points, as the GPU masks them."""
    quads, bits = cells.quads, cells.quads.bit_length() - 1
    for row in range(len(cells)):
        face, level, i, j = (int(a[row]) for a in (cells.face, cells.level, cells.i, cells.j))
        step = 1 << (FULL_BITS - level - bits)
        for edge in range(4):
            indices = np.arange(0, quads + 1, 1 << int(skip[row, 1 if edge < 2 else 0]))
            used = np.unique((indices >> int(mask[row, edge])) << int(mask[row, edge]))
            fixed = np.full(len(used), 0 if edge in (0, 2) else quads)
            a, b = (fixed, used) if edge < 2 else (used, fixed)
            shift = FULL_BITS - level
            points = canonical_lattice(face, (i << shift) + a * step, (j << shift) + b * step)
            names = list(zip(*(np.broadcast_to(p, used.shape).tolist() for p in points), strict=True))
            yield from (frozenset(pair) for pair in itertools.pairwise(names))


@pytest.mark.parametrize("seed", range(6))
def test_whatever_the_cells_want_both_sides_of_an_edge_use_the_same_vertices(seed):
    cells = random_selection(seed)
    wanted = np.random.default_rng(seed).integers(0, MOST + 1, (len(cells), 2))
    skip, mask = agree(wanted, topology(cells))
    assert (skip <= wanted).all() and (mask >= skip[:, [1, 1, 0, 0]]).all() and mask.max() <= 3
    counts = Counter(border_segments(cells, skip, mask))
    assert set(counts.values()) == {2}, "a closed sphere: each piece of border belongs to two cells"


def variants(quads):
    """(variant, step along i, step along j, triangles (N, 3)) of all index lists."""
    indices, ranges = decimated_indices(quads)
    assert len(ranges) == VARIANTS
    for variant, (first, count) in enumerate(ranges):
        steps = [min(1 << int(skip), quads) for skip in variant_skips(variant)]
        yield variant, *steps, indices[first : first + count].reshape(-1, 3).astype(int)


def twice_areas(x, y, triangles):
    x, y = x[triangles], y[triangles]
    return (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])


@pytest.mark.parametrize("quads", [8, 16])
def test_index_lists_cover_the_patch(quads):
    y, x = np.divmod(np.arange((quads + 1) ** 2), quads + 1)
    for _, step_i, step_j, triangles in variants(quads):
        areas = twice_areas(x, y, triangles)
        assert (areas == step_i * step_j).all() and areas.sum() == 2 * quads * quads
        edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
        _, counts = np.unique(edges, axis=0, return_counts=True)
        assert (counts == 1).sum() == 2 * (quads // step_i + quads // step_j)


def test_a_cell_s_diagonals_run_the_same_way():
    quads = 16
    for variant, step_i, step_j, triangles in variants(quads):
        y, x = np.divmod(triangles, quads + 1)
        pairs = ((0, 1), (1, 2), (2, 0))
        slopes = np.concatenate([(x[:, b] - x[:, a]) * (y[:, b] - y[:, a]) for a, b in pairs])
        rising = (slopes > 0).sum() // 2
        assert rising == (1 if variant % 2 else (quads // step_i) * (quads // step_j)), "the last quad always rises"


def test_patches_face_outwards():
    quads = 16
    y, x = np.divmod(np.arange((quads + 1) ** 2), quads + 1)
    step = (1 << FULL_BITS) // quads
    for face in range(6):
        points = direction_of(face, x * step, y * step)
        for _, _, _, triangles in variants(quads):
            a, b, c = (points[triangles[:, n]] for n in range(3))
            assert ((np.cross(b - a, c - a) * a).sum(axis=1) > 0).all()


def test_masked_patches_do_not_fold():
    quads = 8
    y, x = np.divmod(np.arange((quads + 1) ** 2), quads + 1)
    for masks in itertools.product(range(4), repeat=4):
        across = np.select([x == 0, x == quads], masks[:2], 0)
        along = np.select([y == 0, y == quads], masks[2:], 0)
        moved_x, moved_y = (x >> along) << along, (y >> across) << across
        for variant, _, _, triangles in variants(quads):
            skip_i, skip_j = variant_skips(variant)
            if min(masks[:2]) < skip_j or min(masks[2:]) < skip_i:
                continue  # an edge never has more vertices than the cell itself
            areas = twice_areas(moved_x, moved_y, triangles)
            assert (areas >= 0).all() and areas.sum() == 2 * quads * quads


@pytest.fixture(scope="module")
def renderer():
    with pf.Renderer(pf.load_scene("earth"), size=(320, 180), quality="medium") as made:
        yield made


VIEWS = ("near", "valley", "orbit", "pole")


@pytest.mark.parametrize("view", VIEWS)
def test_the_gpu_agrees_as_the_oracle_does_and_leaves_no_crack(renderer, view):
    renderer.render(pf.view(view))
    mesh = renderer.system("terrain").drawn_mesh(renderer.views[0])
    record, positions = mesh.read_cells(), mesh.read_vertices()["position_m"]
    with renderer.current():
        packed = np.frombuffer(mesh.topology.read(32 * mesh.count), "u4").reshape(-1, 8)
    beside = np.where(packed[:, :4] == 0xFFFFFFFF, -1, packed[:, :4].astype(np.int64))
    delta = (packed[:, 4:] & 255).astype(int)
    axis = (packed[:, 4:] >> 8).astype(int)
    skip = np.stack(variant_skips(record["variant"]), axis=1)
    mask = np.stack([(record["edge_mask"] >> (8 * e)) & 255 for e in range(4)], axis=1).astype(int)
    known = np.maximum(beside, 0)
    allowed = np.where((beside >= 0) & (delta > 0), delta + skip[known, axis], 9)
    assert (skip[:, [1, 1, 0, 0]] <= allowed).all()
    beyond = np.where(beside >= 0, delta + skip[known, axis], 0)
    assert np.array_equal(mask, np.maximum(skip[:, [1, 1, 0, 0]], beyond))

    counts: Counter = Counter()
    for row in range(mesh.count):
        for edge in range(4):
            indices = np.arange(0, mesh.quads + 1, 1 << skip[row, 1 if edge < 2 else 0])
            used = np.unique((indices >> mask[row, edge]) << mask[row, edge])
            fixed = 0 if edge in (0, 2) else mesh.quads
            places = [k * (mesh.quads + 1) + fixed if edge < 2 else fixed * (mesh.quads + 1) + k for k in used]
            names = [positions[row, p].tobytes() for p in places]
            counts.update(frozenset(pair) for pair in itertools.pairwise(names))
    assert set(counts.values()) <= {1, 2}
    # Single ones lie along the rim of the covered cap only: cells without anybody beyond.
    rim = int((beside < 0).sum()) * mesh.quads
    assert sum(n == 1 for n in counts.values()) <= rim


def hidden_by_skyline(renderer, view):
    """Pictures with and without the skyline's culling: distances, and triangles drawn."""
    out = []
    text = (pf.ASSETS / "shaders/common/skyline.glsl").read_text()
    for reach in ("0.3", "0.0"):
        changed = text.replace("SKYLINE_REACH = 0.3", f"SKYLINE_REACH = {reach}")
        renderer.gpu.shaders.add_virtual("common/skyline.glsl", changed)
        renderer.system("terrain").backend.view(renderer.views[0]).culled = None
        out.append((renderer.render(view, outputs=("distance",))["distance"], renderer.stats["triangles"]))
    return out


def test_the_skyline_hides_nothing_that_can_be_seen(renderer):
    rng = np.random.default_rng(7)
    saved = 0
    for n in range(12):
        camera = pf.view(VIEWS[n]) if n < 2 else pf.Camera.at(
            float(np.degrees(np.arcsin(rng.uniform(-1, 1)))), float(rng.uniform(-180, 180)), float(10 **
            rng.uniform(0, 3.5)), heading_deg=float(rng.uniform(0, 360)), pitch_deg=float(rng.uniform(-25, 10)),
            above="ground",
        )  # fmt: skip
        (culled, few), (whole, many) = hidden_by_skyline(renderer, camera)
        assert np.array_equal(culled, whole)
        assert few <= many
        saved += many - few
    assert saved > 0
