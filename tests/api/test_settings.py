"""Settings: checked assignment, presets and quality. Messages are read: they are what a user gets."""

import copy
import itertools
import math
import os
import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import planetfall as pf
from planetfall.components import TerrainQuality, knob, knobs
from planetfall.engine.settings import (
    PresetError,
    QualityKnobs,
    SettingError,
    UnknownSettingError,
    build_components,
    functions_of,
    install,
    plain_table,
    read_toml,
    revision,
    rules_of,
    with_overrides,
    write_toml,
)
from planetfall.quality import QUALITY, qualities, resolve_quality
from planetfall.scene.kinds import KINDS

# -- assignment -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("field", "value", "message"),
    [
        ("sea_level_m", 2e5, r"^Ocean\.sea_level_m: expected a number from -100000 to 100000 m, found 200000\.0\. "
         r"The nearest allowed value is 100000$"),
        ("sea_level_m", math.nan, r"^Ocean\.sea_level_m: .*found nan\. Give a finite number$"),
        ("sea_level_m", math.inf, r"found inf\. Give a finite number$"),
        ("sea_level_m", "high", r"^Ocean\.sea_level_m: expected .*, found 'high'\. Give a value such as 0\.0$"),
        ("sea_level_m", None, r"found None"),
        ("sea_level_m", True, r"found True"),
        ("absorption_per_m", (1, 2), r"expected 3 numbers from 0 to 100 1/m, found \(1, 2\)\. Give 3 numbers, such as"),
        ("absorption_per_m", (1, 2, -1), r"expected 3 numbers from 0 to 100 1/m, found \(1, 2, -1\)"),
        ("absorption_per_m", (1.0, 2.0, math.nan), r"Give finite numbers$"),
    ],
)  # fmt: skip
def test_bad_values_say_field_range_value_and_remedy(field, value, message):
    ocean = pf.Ocean()
    before = plain_table(ocean)
    with pytest.raises(SettingError, match=message):
        setattr(ocean, field, value)
    assert plain_table(ocean) == before


def test_other_kinds_of_bad_values():
    with pytest.raises(SettingError, match=r"Terrain\.layers: expected a whole .*, found 2\.5\. Give it without a dec"):
        pf.Terrain(layers=2.5)  # type: ignore[arg-type]
    with pytest.raises(SettingError, match=r"The nearest allowed value is 16"):
        pf.Terrain(layers=17)
    with pytest.raises(
        SettingError, match=r"Composite\.tone_map: expected one of 'camera', 'agx', .* found 'agxx'; did you mean 'agx'"
    ):
        pf.Composite(tone_map="agxx")
    with pytest.raises(SettingError, match=r"Composite\.dither: expected true or false, found 1"):
        pf.Composite(dither=1)  # type: ignore[arg-type]
    with pytest.raises(
        SettingError, match=r"Sun\.direction: expected 3 numbers, not all zero, or nothing, found \(0, 0, 0\)"
    ):
        pf.Sun(direction=(0, 0, 0))


def test_an_unknown_backend_is_refused_with_those_that_there_are():
    with pytest.raises(SettingError, match=r"expected one of 'grid', 'quadtree', 'icosphere', found 'cubes'"):
        pf.Terrain(backend="cubes")
    with pytest.raises(SettingError, match=r"^override 'terrain\.backend'"):
        resolve_quality("high", {"terrain.backend": "cubes"})


def test_a_name_that_is_no_field_raises():
    ocean = pf.Ocean()
    with pytest.raises(UnknownSettingError, match=r"Ocean has no setting 'sea_leve_m'; did you mean 'sea_level_m'\?"):
        ocean.sea_leve_m = 3.0  # type: ignore[attr-defined]
    with pytest.raises(AttributeError):
        ocean.zzz = 1  # type: ignore[attr-defined]
    ocean._cache = 1  # type: ignore[attr-defined]  # a system's own note
    with pytest.raises(UnknownSettingError, match=r"Ocean has no setting 'sea_leve_m'; did you mean 'sea_level_m'\?"):
        pf.Ocean(sea_leve_m=3.0)  # type: ignore[call-arg]
    with pytest.raises(UnknownSettingError, match=r"CloudLayer has no setting 'coverag'"):
        pf.CloudLayer(base_m=2000.0, coverag=0.5)  # type: ignore[call-arg]


def test_numpy_values_become_plain_ones():
    ocean = pf.Ocean(sea_level_m=np.float32(2.5), absorption_per_m=np.array([1, 2, 3]))  # type: ignore[arg-type]
    assert type(ocean.sea_level_m) is float and ocean.sea_level_m == 2.5
    assert ocean.absorption_per_m == (1.0, 2.0, 3.0)
    assert type(ocean.absorption_per_m) is tuple and type(ocean.absorption_per_m[0]) is float
    assert type(pf.Terrain(seed=np.int64(7)).seed) is int  # type: ignore[arg-type]


def test_the_way_that_was_set_last_places_the_sun():
    sun = pf.Sun()
    assert sun.mode == "direction"
    sun.elevation_deg = 20.0
    assert (sun.mode, sun.direction) == ("elevation", None)
    sun.direction = (0, 0, 2)
    assert (sun.mode, sun.elevation_deg) == ("direction", None)
    sun.epoch_s = 0.0
    assert (sun.mode, sun.direction) == ("epoch", None)
    with pytest.raises(SettingError, match="Sun: direction and elevation_deg exclude each other; give only one"):
        pf.Sun(direction=(1, 0, 0), elevation_deg=3.0)


def test_revision_marks_changes_only():
    ocean, other = pf.Ocean(), pf.Ocean()
    assert revision(ocean) != revision(other)  # a replaced component counts as changed
    first, colour = revision(ocean), revision(ocean, "absorption_per_m")
    ocean.sea_level_m = ocean.sea_level_m
    with pytest.raises(SettingError):
        ocean.sea_level_m = math.nan
    assert revision(ocean) == first
    ocean.sea_level_m = 12.0
    assert revision(ocean) > first
    assert revision(ocean, "absorption_per_m") == colour
    twin = copy.copy(ocean)
    twin.sea_level_m = 13.0
    assert revision(ocean) != revision(twin) and ocean.sea_level_m == 12.0
    with pytest.raises(UnknownSettingError, match="Ocean has no setting 'depth'"):
        revision(ocean, "depth")


def test_equality_ignores_the_history_of_changes():
    a, b = pf.Ocean(), pf.Ocean()
    a.sea_level_m = 5.0
    a.sea_level_m = 0.0
    assert a == b


def test_install_twice_is_once():
    before = pf.Ocean.__setattr__
    install(pf.Ocean)
    assert pf.Ocean.__setattr__ is before


def test_declarations_are_checked():
    @dataclass
    class Bad:
        depth: float | None = knob(3.0)

    with pytest.raises(TypeError, match=r"Bad\.depth: an optional knob is `X \| None` with default None"):
        install(Bad)

    @dataclass
    class Worse:
        table: dict = knob(None)  # noqa: RUF009

    with pytest.raises(TypeError, match=r"Worse\.table: knobs are float, int"):
        install(Worse)
    with pytest.raises(TypeError, match="int is no dataclass"):
        rules_of(int)


@dataclass
class Rows:
    """A component with the kinds of knobs that a game gives in Python."""

    cells: tuple[tuple[int, int], ...] = knob((), 0, 9, help="Rows")
    rule: Callable[[int], int] | None = knob(None, help="A function")  # noqa: RUF009


@pytest.mark.parametrize(
    "given", [[[1, 2], [3, 4]], ((1, 2), (3, 4)), np.array([[1, 2], [3, 4]]), [np.array([1, 2]), (np.int64(3), 4)]]
)
def test_rows_are_stored_as_tuples_of_ints(given):
    part = install(Rows)(cells=given)
    assert part.cells == ((1, 2), (3, 4)) and type(part.cells[1][0]) is int
    assert plain_table(part) == {"cells": [[1, 2], [3, 4]]} and plain_table(Rows()) == {}


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (3, r"Rows\.cells: expected rows of 2 whole numbers from 0 to 9, found 3. Give a list of rows"),
        ([[1, 2], [3]], r"Rows\.cells\[1\]: expected 2 whole numbers from 0 to 9, found \[3\]"),
        ([[1, 2], [3, 10]], r"Rows\.cells\[1\]: .* found \[3, 10\]"),
        (np.array([[1.5, 2.0]]), r"Rows\.cells\[0\]: .* found \[1\.5, 2\.0\]"),
        ([[1, 2], 7], r"Rows\.cells\[1\]: .* found 7"),
        (np.zeros((2, 3), int), r"Rows\.cells\[0\]: .* found \[0, 0, 0\]"),
    ],
)
def test_bad_rows_are_named_by_their_place(given, message):
    with pytest.raises(SettingError, match=message):
        install(Rows)(cells=given)


def test_functions_are_kept_and_no_file_has_them():
    part = install(Rows)()
    before = revision(part)
    part.rule = len
    assert part.rule is len and revision(part) > before and functions_of(part) == ["Rows.rule"]
    assert plain_table(part) == {} and rules_of(Rows)["rule"].expected == "a function, or nothing"
    with pytest.raises(
        SettingError, match=r"Rows\.rule: expected a function, or nothing, found 3. Assign one in Python"
    ):
        part.rule = 3
    part.rule = None
    assert functions_of(part) == []


@pytest.mark.parametrize("cls", list(KINDS.values()), ids=list(KINDS))
def test_every_component_field_is_a_knob_with_help_and_a_valid_default(cls):
    described = knobs(cls)
    assert set(described) == set(cls.__dataclass_fields__)
    assert all(k.help for k in described.values())
    cls()  # construction checks the defaults
    for name, rule in rules_of(cls).items():
        assert (
            rule.kind in ("bool", "str", "list", "function")
            or rule.knob.nonzero
            or rule.knob.low is not None
            or rule.knob.widget == "place"
        ), name


# -- presets ----------------------------------------------------------------------------------------------------------


def _problems(tmp_path, text):
    path = tmp_path / "my.toml"
    path.write_text(text)
    with pytest.raises(PresetError) as info:
        build_components(read_toml(path), KINDS, path)
    assert str(info.value).startswith(f"{path}: ")
    return str(info.value)


def test_unknown_keys_and_tables(tmp_path):
    message = _problems(tmp_path, "[ocean]\nsea_levle_m = 1.0\n")
    assert "ocean.sea_levle_m: unknown key; did you mean 'sea_level_m'?" in message
    assert "ozean: unknown table; did you mean 'ocean'?" in _problems(tmp_path, "[ozean]\n")
    assert "Write [ocean] on a line of its own" in _problems(tmp_path, "ocean = 3\n")
    assert "given twice" in _problems(tmp_path, "[ocean]\n[Ocean]\n")


def test_wrong_types_and_ranges_name_key_expected_found(tmp_path):
    message = _problems(tmp_path, '[ocean]\nsea_level_m = "deep"\n[terrain]\nlayers = 99\nhighest_m = nan\n')
    assert ": 3 problems:\n" in message
    assert "ocean.sea_level_m: expected a number from -100000 to 100000 m, found 'deep'" in message
    assert "terrain.layers: expected a whole number from 1 to 16, found 99. The nearest allowed value is 16" in message
    assert "terrain.highest_m: expected a number from -20000 to 100000 m, found nan" in message
    message = _problems(tmp_path, "[sun]\ndirection = [1, 0, 0]\nelevation_deg = 3\n")
    assert "sun.elevation_deg: excludes sun.direction; give only one of them" in message


def test_broken_and_missing_files(tmp_path):
    assert "not valid TOML" in _problems(tmp_path, "[ocean]\nsea_level_m = = 3\n")
    assert "line 2" in _problems(tmp_path, "[ocean]\nsea_level_m = = 3\n")
    with pytest.raises(PresetError, match=r"nix\.toml: no such file \(looked from"):
        read_toml(tmp_path / "nix.toml")
    with pytest.raises(PresetError, match="can't be read"):
        read_toml(tmp_path)
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(PresetError, match="not valid TOML"):
        read_toml(tmp_path / "binary.toml")


def test_class_names_are_tables_too(tmp_path):
    path = tmp_path / "a.toml"
    path.write_text("[Ocean]\nsea_level_m = 4\n")
    assert build_components(read_toml(path), KINDS, path) == {"ocean": pf.Ocean(sea_level_m=4.0)}


@given(
    st.floats(-1e5, 1e5),
    st.tuples(*[st.floats(0, 100)] * 3),
    st.one_of(st.none(), st.floats(-90, 90)),
    st.integers(0, 2**31 - 1),
)
def test_round_trip_is_exact(level, colour, elevation, seed):
    parts = {
        "ocean": pf.Ocean(sea_level_m=level, absorption_per_m=colour),
        "sun": pf.Sun(elevation_deg=elevation),
        "terrain": pf.Terrain(seed=seed),
        "composite": pf.Composite(dither=False, tone_map="linear"),
    }
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "x.toml"
        write_toml(path, {name: plain_table(c) for name, c in parts.items()})
        assert build_components(read_toml(path), KINDS, path) == parts


def test_writing_is_all_or_nothing(tmp_path, monkeypatch):
    path = tmp_path / "p.toml"
    write_toml(path, {"a": 1})

    def fails(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", fails)
    with pytest.raises(PresetError, match=r"p\.toml: can't be written: No space left on device"):
        write_toml(path, {"a": 2})
    monkeypatch.undo()
    assert read_toml(path) == {"a": 1}
    assert [p.name for p in tmp_path.iterdir()] == ["p.toml"]  # nothing half-written is left
    with pytest.raises(PresetError, match=r"the folder .*nowhere doesn't exist; make it first"):
        write_toml(tmp_path / "nowhere" / "p.toml", {})
    with pytest.raises(TypeError):
        write_toml(path, {"a": object()})
    assert [p.name for p in tmp_path.iterdir()] == ["p.toml"]


def test_a_reader_never_sees_half_a_file(tmp_path):
    path = tmp_path / "p.toml"
    full = {"values": list(range(2000))}
    write_toml(path, full)
    stop, seen = threading.Event(), []

    def read():
        while not stop.is_set():
            seen.append(read_toml(path) == full)

    reader = threading.Thread(target=read)
    reader.start()
    for _ in range(5):
        write_toml(path, full)
    stop.set()
    reader.join()
    assert all(seen)


# -- quality ----------------------------------------------------------------------------------------------------------


def test_quality_presets_are_whole_valid_and_explained():
    assert qualities() == ["low", "medium", "high", "ultra", "reference", "paper"]
    for name in qualities():
        path = QUALITY.folder / f"{name}.toml"
        values = resolve_quality(name)
        assert set(values) >= set(QUALITY.rules)
        assert set(values) <= set(QUALITY.rules) | set(QUALITY.component_rules)
        assert QUALITY.about(name)
        lines = path.read_text().splitlines()
        for before, line in itertools.pairwise(lines):
            if "=" in line and not line.startswith(("#", "about", "order")):
                assert before.startswith("#"), f"{path.name}: the reason for {line!r} is missing above it"


def test_better_quality_is_finer():
    edges = [resolve_quality(name)["terrain.edge_px"] for name in ("low", "medium", "high", "ultra", "reference")]
    assert edges == sorted(edges, reverse=True) and len(set(edges)) == 5


def test_overrides_are_checked():
    assert resolve_quality("low", {"terrain.edge_px": 5})["terrain.edge_px"] == 5.0
    assert resolve_quality("low", {"terrain.layers": 4})["terrain.layers"] == 4
    assert "terrain.layers" not in resolve_quality("low")
    with pytest.raises(
        UnknownSettingError, match=r"override 'terrain\.edge' names no knob; did you mean 'terrain\.edge_px'"
    ):
        resolve_quality("high", {"terrain.edge": 5})
    with pytest.raises(SettingError, match=r"override 'terrain\.edge_px': expected a number from 1 to 64 px, found 0"):
        resolve_quality("high", {"terrain.edge_px": 0})
    with pytest.raises(SettingError, match=r"a power of two, found 17\. The nearest allowed value below is 16"):
        resolve_quality("high", {"terrain.quads": 17})
    with pytest.raises(SettingError, match=r"no quality 'hihg'; did you mean 'high'\? qualities: high, low, medium"):
        resolve_quality("hihg")


def test_a_quality_file_with_mistakes_names_them(tmp_path):
    (tmp_path / "odd.toml").write_text("order = 1\n[terrain]\nedge_pxs = 3\nedge_px = -3\n")
    table = QualityKnobs(tmp_path, {"terrain": TerrainQuality}, {})
    told = r"odd\.toml: terrain\.edge_pxs: unknown key; did you mean 'terrain\.edge_px'"
    with pytest.raises(PresetError, match=told):
        table.resolve("odd")


def test_overrides_of_components_leave_the_scene_alone():
    terrain = pf.Terrain()
    settings = resolve_quality("high", {"terrain.layers": 4})
    changed = with_overrides(terrain, "terrain", settings)
    assert (changed.layers, terrain.layers) == (4, 16)
    assert with_overrides(terrain, "terrain", resolve_quality("high")) is terrain


def test_tone_maps_are_those_there_are():
    from planetfall.systems.composite.tone_maps import TONE_MAPS

    assert set(rules_of(pf.Composite)["tone_map"].knob.choices) == set(TONE_MAPS)


def test_terrain_knobs_are_those_of_the_height_function():
    from planetfall.systems.terrain.height_params import KNOBS, RANGES, TerrainParams

    rules = rules_of(pf.Terrain)
    defaults = TerrainParams.from_component(pf.Terrain(), pf.Planet().radius_m)
    assert defaults == TerrainParams()
    for name in (*KNOBS, "layers"):
        assert (rules[name].knob.low, rules[name].knob.high) == RANGES[name], name
