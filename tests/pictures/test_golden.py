"""Golden pictures: the named views look as they did, and every knob can be seen.

A failure writes golden | actual | difference to .diff/ and says how to refresh the files. docs/testing.md says how the
limits were found.
"""

from __future__ import annotations

import json
import shlex
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from golden_compare import (
    OTHER_DRIVER,
    SAME,
    difference_page,
    likeness,
    limit_for,
    read_picture,
    write_picture,
)
from golden_pictures import (
    COVER_PICTURES,
    COVER_VIEWS,
    FOLDER,
    GOLDENS,
    KIND_PICTURES,
    KNOB_PICTURES,
    VIEW_PICTURES,
    Picture,
    Studio,
    pair_picture,
    plain,
    shaded,
    wireframe,
)
from golden_tool import main, update
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.knobs import (
    COMPONENTS,
    KNOB_SIZE,
    NOT_IN_A_PICTURE,
    PAIRS,
    QUALITY_PAIRS,
    SHADE_PAIRS,
    TILE_PAIRS,
    VISIBLE,
    changed,
    component,
)
from planetfall.components import knobs
from planetfall.systems.capture.png import read_png_settings
from planetfall.systems.composite import TONE_MAPS
from planetfall.systems.debug import NAMED_VIEWS

DIFFERENCES = Path(__file__).resolve().parents[2] / ".diff"


@pytest.fixture(scope="module")
def studio(gpu) -> Iterator[Studio]:
    with Studio() as made:
        yield made
    gpu.ctx.__enter__()  # the tests' own context again: the studio's were current meanwhile


@pytest.mark.parametrize("picture", GOLDENS, ids=lambda p: p.name)
def test_picture_looks_as_it_did(studio, picture):
    refresh = f"python tests/kits/golden_tool.py --update {shlex.quote(picture.name)}"
    assert picture.path.is_file(), f"{picture.path} is missing; make it with: {refresh}"
    actual, expected = studio.take(picture), read_picture(picture.path)
    found, limit = likeness(expected, actual), picture.allowed or limit_for(studio.machine["renderer"])
    if not found.within(limit):
        page = DIFFERENCES / f"{picture.name.replace('/', '-')}.png"
        write_picture(page, difference_page(picture.name, expected, actual, found.error), picture.settings())
        pytest.fail(
            f"{picture.name} does not look as it did: {found}; allowed: {limit}.\n"
            f"golden, actual and difference side by side: {page}\n"
            f"If the change is meant, look at the picture and run: {refresh}"
        )


def test_every_golden_file_has_a_picture_and_its_settings():
    names = {p.name for p in GOLDENS}
    assert len(names) == len(GOLDENS)
    files = {path.relative_to(FOLDER).with_suffix("").as_posix() for path in FOLDER.rglob("*.png")}
    assert not files - names, "files without a picture: run python tests/kits/golden_tool.py --update"
    for picture in GOLDENS:
        inside = read_png_settings(picture.path)
        wanted = json.loads(json.dumps(dict(picture.changes)))
        assert (inside["planet"], inside["view"]) == (picture.planet, picture.view)
        assert inside["size"] == list(picture.size) and inside["changes"] == wanted and inside["renderer"]
    assert sum(path.stat().st_size for path in FOLDER.rglob("*.png")) < 6.2e6


def test_the_named_views_all_have_goldens():
    earth = {p.view for p in VIEW_PICTURES if p.planet == "earth"}
    assert earth | set(COVER_VIEWS) == set(pf.views("earth")) and not earth & set(COVER_VIEWS)
    assert {p.view for p in COVER_PICTURES} >= set(COVER_VIEWS)
    assert {p.planet for p in VIEW_PICTURES} - {"props", "pictures"} == set(pf.planets())
    debug = {p.changes["debug.view"] for p in KNOB_PICTURES if "debug.view" in p.changes}
    # A settled picture has no past but its own; test_debug_history looks at these while the camera turns.
    # Views of labels are held against the labels themselves (test_labels).
    labels = {"slope", "sunlit", "albedo", "material", "instance"}
    assert debug | labels | {"history", "cloud_history"} == set(NAMED_VIEWS)
    toned = {p.changes["composite.tone_map"] for p in KNOB_PICTURES if "composite.tone_map" in p.changes}
    assert toned | {pf.Composite().tone_map} == set(TONE_MAPS)


@pytest.mark.parametrize("picture", [*KNOB_PICTURES, *KIND_PICTURES], ids=lambda p: p.name)
def test_golden_of_a_knob_shows_the_knob(studio, picture):
    """Against the view as it is, and tone maps, debug views and kinds of cloud against each other: by far more than
    passes as equal."""
    shown = read_picture(picture.path)
    others = [
        p for p in (*KNOB_PICTURES, *KIND_PICTURES)
        if p is not picture and (p.view, p.size, p.clouds) == (picture.view, picture.size, picture.clouds)
    ]  # fmt: skip
    for other in [plain(picture.view, picture.planet, picture.size, picture.clouds), *others]:
        pixels = studio.take(other) if other.name.startswith("plain") else read_picture(other.path)
        found = likeness(pixels, shown)
        assert found.mean >= VISIBLE or found.worst >= 0.3, f"{picture.name} looks like {other.name}: {found}"


def test_every_knob_has_a_pair():
    known = {f"{table}.{name}" for table, kind in COMPONENTS.items() for name in knobs(kind)}
    listed = set(PAIRS) | set(NOT_IN_A_PICTURE)
    assert known - listed == set(), "knobs without a picture that shows them: add them to PAIRS in benchmarks/knobs.py"
    assert listed - known == set() and not set(PAIRS) & set(NOT_IN_A_PICTURE)


def slow_where(keys: Iterable[str], slow: Callable[[str], bool]) -> list[Any]:
    """Parameters of a test, some of them marked slow."""
    return [pytest.param(key, marks=pytest.mark.slow if slow(key) else ()) for key in keys]


@pytest.mark.parametrize("key", slow_where(PAIRS, lambda key: key.endswith("_albedo")))
def test_knob_can_be_seen(studio, key):
    pair = PAIRS[key]
    found = likeness(*(studio.take(pair_picture(key, pair, value)) for value in (pair.off, pair.on)))
    assert found.mean >= pair.least and found.worst >= pair.least_worst, f"{key} = {pair.on} is not seen: {found}"


@pytest.mark.parametrize("key", slow_where(QUALITY_PAIRS, lambda key: key != "terrain.edge_px"))
def test_quality_knob_changes_the_triangles(studio, key):
    first, second = (studio.take(wireframe({key: value})) for value in QUALITY_PAIRS[key])
    assert likeness(first, second).mean >= VISIBLE


@pytest.mark.parametrize("key", SHADE_PAIRS)
def test_quality_knob_of_shading_can_be_seen(studio, key):
    view, *values = SHADE_PAIRS[key]
    first, second = (studio.take(shaded(key, view, value)) for value in values)
    assert likeness(first, second).mean >= VISIBLE


@pytest.mark.parametrize("key", slow_where(TILE_PAIRS, lambda key: key != "terrain.error_px"))
def test_quality_knob_changes_the_tiles(studio, key):
    tiles = {"terrain.backend": "quadtree"}
    first, second = (studio.take(wireframe({**tiles, key: value})) for value in TILE_PAIRS[key])
    assert likeness(first, second).mean >= VISIBLE


def test_dither_breaks_bands_and_keeps_the_mean(studio):
    """On the smooth glare round the sun: less than a step of 8 bits, half the bands at most, the same brightness."""
    on, off = (
        studio.take(Picture("dither", "earth", "limb", KNOB_SIZE, {"composite.dither": dither})).astype(int)
        for dither in (True, False)
    )
    assert np.abs(on - off).max() <= 1
    assert np.abs((on - off).mean(axis=(0, 1))).max() < 0.05
    assert banded(off) > 0.1 and banded(on) < 0.5 * banded(off), (banded(off), banded(on))


def banded(pixels: NDArray[np.int_], longer_than: int = 11) -> float:
    """Share of the picture that lies in level stretches of a row, neither black nor white."""
    share = 0
    for row in pixels[..., 1]:
        ends = np.concatenate([[0], np.flatnonzero(np.diff(row)) + 1, [len(row)]])
        lengths, values = np.diff(ends), row[ends[:-1]]
        share += lengths[(lengths > longer_than) & (values > 0) & (values < 255)].sum()
    return share / pixels[..., 1].size


def test_the_order_of_pictures_does_not_matter(studio):
    """What a picture shows depends on its settings alone, not on what was rendered before."""
    first = Picture("order", "earth", "coast", KNOB_SIZE)
    studio.take(Picture("order", "earth", "near", KNOB_SIZE, {"terrain.layers": 4, "ocean.sea_level_m": 30.0}))
    again = Studio()
    try:
        np.testing.assert_array_equal(again.take(first), studio.take(first))
    finally:
        again.release()


def test_limits_notice_what_matters():
    rng = np.random.default_rng(5)
    base = rng.integers(60, 130, (180, 320, 3)).astype(np.uint8)
    assert likeness(base, base).mean == 0.0 and likeness(base, base).within(SAME)
    one_step = base + (rng.random(base.shape) < 3e-4).astype(np.uint8)  # as another CPU rounds
    assert likeness(base, one_step).within(SAME)
    hole = base.copy()
    hole[90:93, 160:163] = 0
    assert not likeness(base, hole).within(SAME)
    shifted = np.roll(base, 1, axis=1)
    assert not likeness(base, shifted).within(OTHER_DRIVER)
    with pytest.raises(ValueError, match="size"):
        likeness(base, base[:90])
    assert limit_for("llvmpipe (LLVM 15)") is SAME and limit_for("NVIDIA H100") is OTHER_DRIVER


def test_a_page_shows_all_three():
    a = np.zeros((90, 160, 3), np.uint8)
    b = np.full_like(a, 200)
    page = difference_page("name", a, b, likeness(a, b).error)
    assert page.shape[1] >= 3 * 320 and page.max() == 255


def test_unknown_names_are_refused():
    with pytest.raises(SystemExit, match=r"earth/nowhere.*earth/near"):
        update(["earth/nowhere"])
    with pytest.raises(SystemExit):
        main(["--no-such-option"])


def test_changes_are_put_back():
    scene = pf.load_scene("earth")
    with scene, pytest.raises(pf.SettingError):
        before = component(scene, "terrain").layers
        try:
            with changed(scene, {"terrain.layers": 4, "ocean.roughness": 99.0}):
                pass
        finally:
            assert component(scene, "terrain").layers == before
