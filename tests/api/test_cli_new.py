"""`planetfall new`: the scene file it writes equals its base, and every line of it can be used; no GPU needed."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import planetfall as pf
from planetfall.cli.main import main
from planetfall.scene.file import describe


def fails(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(arguments) == 2
    return capsys.readouterr().err


@pytest.mark.parametrize("base", [*pf.planets(), "earth_moon"])
def test_a_new_file_equals_its_base(base: str, tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    assert main(["new", str(file), "--base", base]) == 0
    mine, its = describe(file), describe(base)
    assert (mine.components, mine.about, mine.preset) == (its.components, its.about, its.preset)
    assert [(told.name, told.components, orbit) for told, orbit in mine.companions] == [
        (told.name, told.components, orbit) for told, orbit in its.companions
    ]
    assert mine.name == "mine"


def test_every_setting_of_it_can_be_used(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    assert main(["new", str(file), "--base", "moon"]) == 0
    text = file.read_text(encoding="utf-8")
    assert "\n#seed = " in text and "#[ocean]" in text
    # Every setting at once, in the tables the base has: nothing changes. The others are filled with their defaults.
    file.write_text(re.sub(r"^#(?! )", "", text, flags=re.MULTILINE), encoding="utf-8")
    mine, moon = describe(file).components, describe("moon").components
    assert {table: mine[table] for table in moon} == moon
    assert {"ocean", "atmosphere", "clouds"} <= set(mine) - set(moon) and mine["ocean"] == pf.Ocean()


def test_a_changed_value_counts_and_the_rest_follows_the_base(tmp_path: Path) -> None:
    file, further = tmp_path / "mine.toml", tmp_path / "deeper" / "further.toml"
    further.parent.mkdir()
    assert main(["new", str(file), "--base", "mars"]) == 0
    text = file.read_text(encoding="utf-8")
    changed = re.sub(r"^#radius_m = .*$", "radius_m = 2.0e6", text, flags=re.MULTILINE)
    file.write_text(changed, encoding="utf-8")
    assert main(["new", str(further), "--base", str(file)]) == 0  # a file is named from where the new one lies
    for found in describe(file).components, describe(further).components:
        assert found["planet"].radius_m == 2.0e6
        assert found["terrain"] == describe("mars").components["terrain"]


def test_files_are_named_from_where_the_new_one_lies(tmp_path: Path) -> None:
    base, file = tmp_path / "planets" / "mapped.toml", tmp_path / "mine" / "own.toml"
    for folder in (base.parent, file.parent):
        folder.mkdir()
    base.write_text('base = "moon"\n[terrain]\nheight_map = "maps/moon.png"\nheight_map_range_m = [-9000.0, 9000.0]\n')
    assert main(["new", str(file), "--base", str(base)]) == 0
    text = file.read_text(encoding="utf-8")
    assert '\n#height_map = "../planets/maps/moon.png"\n' in text and str(tmp_path) not in text
    file.write_text(re.sub(r"^#(height_map = )", r"\1", text, flags=re.MULTILINE), encoding="utf-8")
    assert describe(file).components["terrain"] == describe(base).components["terrain"]


def test_what_can_t_be_written_is_told_and_leaves_what_is_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("[planet]\n")
    assert "is there already" in fails(["new", str(file)], capsys)
    assert "its own base" in fails(["new", str(file), "--base", str(file), "--force"], capsys)
    assert "did you mean 'earth'" in fails(["new", str(tmp_path / "a.toml"), "--base", "erth"], capsys)
    assert "mine.toml" in fails(["new", str(tmp_path / "mine")], capsys)
    assert "does not exist" in fails(["new", str(tmp_path / "none" / "a.toml")], capsys)
    assert file.read_text() == "[planet]\n" and [path.name for path in tmp_path.iterdir()] == ["mine.toml"]
    assert main(["new", str(file), "--force"]) == 0 and 'base = "earth"' in file.read_text()


def test_a_knob_outside_its_table_is_told_where_it_belongs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("base = 'earth'\nradius_m = 5e5\n")
    assert "radius_m: unknown key; put it below a line [planet]" in fails(["views", str(file)], capsys)
    file.write_text("base = 'earth'\n[terrain]\ngrass_albedo = 'green'\n")
    assert "Give 3 numbers, such as [" in fails(["views", str(file)], capsys)
