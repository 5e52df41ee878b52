"""The list of the ground's materials: rules are made of known words, a game's own show, and mistakes are said early."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import planetfall as pf
from planetfall import extend
from planetfall.components._knob import knobs
from planetfall.engine.display import reflectance
from planetfall.engine.wavelengths import DISPLAY_NM
from planetfall.systems.terrain.material_list import MOST_ALBEDOS, MOST_OF_GAMES, albedos, listed, shaders
from planetfall.systems.terrain.materials import INPUTS, MATERIALS

TUTORIAL = Path(__file__).resolve().parents[2] / "docs" / "tutorials" / "a-material-of-your-own.md"
RED, RULE = (0.3, 0.04, 0.03), "ramp(0.5, 0.25, slope)"
MAIN = "generated/terrain_materials.glsl"


@pytest.fixture(autouse=True)
def the_librarys_own() -> Iterator[None]:
    yield
    for material in (m for m in listed() if m not in MATERIALS):
        extend.unregister_material(material.name)
    assert listed() == MATERIALS


def test_every_colour_of_the_terrain_is_some_materials() -> None:
    sources = [m.albedo for m in MATERIALS]
    colours = {name for name in knobs(pf.Terrain) if name.endswith("_albedo")}
    assert colours <= set(filter(lambda s: isinstance(s, str), sources))
    terrain = pf.Terrain(snow_albedo=(0.2, 0.2, 0.3))
    assert tuple(reflectance((0.2, 0.2, 0.3), DISPLAY_NM)) in [tuple(row) for row in albedos(terrain, DISPLAY_NM)]


def test_every_input_is_filled_and_used() -> None:
    """Or it is for games: then only the shader that fills it names it."""
    filled = (pf.ASSETS / "shaders" / "terrain" / "ground_at.glsl").read_text(encoding="utf-8")
    assert not [name for name in INPUTS if not re.search(rf"ground\.{name} =", filled)]
    assert set(re.findall(r"ground\.(\w+) =", filled)) == set(INPUTS)


def test_a_new_entry_is_in_the_shader_between_its_neighbours() -> None:
    extend.register_material("moss", RED, RULE, over="rock", roughness=0.5, stones=0.25, plants=0.0)
    extend.register_material("lichen", RED, "moss_share * 0.5", over="rock")
    text = shaders()[MAIN]
    order = [text.index(f"mix(bare_color, {name}_color,") for name in ("scree", "rock", "moss", "lichen", "beach")]
    assert order == sorted(order)
    assert "mix(mix(mix(1.0, 0.4, beach_share), 1.8, rock_share), 0.5, moss_share)" in text
    assert "mix(mix(1.0, 0.25, moss_share), 1.0, shingle_share) * (1.0 - snow_share)" in text
    assert "(1.0 - rock_share) * (1.0 - moss_share) * (1.0 - shingle_share) * (1.0 - snow_share)" in text
    assert "return ramp(0.5, 0.25, slope);" in shaders()["generated/materials/moss.glsl"]
    extend.unregister_material("moss")
    extend.unregister_material("moss")  # it is gone: nothing happens


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"name": "Red Moss"}, "name: expected"),
        ({"name": "snow"}, "there is a material of this name"),
        ({"name": "dry"}, "there is a material of this name"),
        ({"over": "rok"}, "over: 'rok'; did you mean 'rock'"),
        ({"over": "grass"}, "over: 'grass'; .*it may lie over"),
        ({"albedo": (0.3, 0.04)}, "albedo: expected 3 numbers from 0 to 1"),
        ({"albedo": (0.3, 0.04, 1.5)}, "albedo: expected 3 numbers from 0 to 1"),
        ({"albedo": "red"}, "albedo: expected 3 numbers from 0 to 1"),
        ({"rule": "  "}, "rule: expected GLSL"),
        ({"rule": "ramp(0.0, 1.0, slpoe)"}, "rule: there is no 'slpoe'; did you mean 'slope'"),
        ({"rule": "float a = snw_share; return a;"}, "there is no 'snw_share'"),
        ({"rule": "1.0 - red_share"}, "'red' would need itself: red_share -> red_share"),
        ({"rule": "1.0 - ash_share", "color": "albedo * ash_color"}, "there is no 'ash_share'"),
        ({"color": "albedo * strat_albedo"}, "color: there is no 'strat_albedo'"),
        ({"roughness": float("nan")}, "roughness: expected a number from 0 to 8"),
        ({"plants": 2.0}, "plants: expected a number from 0 to 1"),
        ({"ripples": extend.Ripples(0.0, 0.4, 0.2, 0.1)}, "wavelength_m: expected a number from 0.036"),
    ],
)
def test_what_cannot_be_changes_nothing(change: dict[str, Any], match: str) -> None:
    before = shaders()
    with pytest.raises(pf.SettingError, match=match):
        extend.register_material(**{"name": "red", "albedo": RED, "rule": RULE, **change})
    assert listed() == MATERIALS and shaders() == before


def test_names_are_given_once_and_only_so_many() -> None:
    for number in range(MOST_OF_GAMES):
        extend.register_material(f"red_{number}", RED, RULE)
    with pytest.raises(pf.SettingError, match="there is a material of this name"):
        extend.register_material("red_0", RED, RULE)
    with pytest.raises(pf.SettingError, match=f"{MOST_OF_GAMES} materials are the most"):
        extend.register_material("one_more", RED, RULE)
    assert len(albedos(pf.Terrain(), DISPLAY_NM)) == MOST_ALBEDOS
    extend.unregister_material("red_3")
    extend.register_material("again", RED, RULE)  # in the place that is free; the others keep theirs
    assert [tuple(row) for row in albedos(pf.Terrain(), DISPLAY_NM)].count(
        tuple(reflectance(RED, DISPLAY_NM))
    ) == MOST_OF_GAMES


def redness(picture: NDArray[np.uint8]) -> NDArray[np.float64]:
    colour = picture.astype(float)
    return colour[..., 0] / (colour.sum(axis=2) + 1.0)


@pytest.mark.gpu
def test_the_tutorials_material_shows_and_a_broken_one_leaves_the_last_good(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # it saves a picture
    (first, *_) = re.findall(r"^```python\n(.*?)^```", TUTORIAL.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    with pf.load_scene("earth") as scene, pf.Renderer(scene, (96, 54), "low") as renderer:

        def taken() -> NDArray[np.uint8]:
            renderer.settle(pf.view("near"))
            return renderer.render(pf.view("near"))["color"]

        plain = taken()
        exec(compile(first, str(TUTORIAL), "exec"), {})
        red = taken()
        assert (redness(red) > redness(plain) + 0.1).mean() > 0.1, "red moss covers some of the picture"
        assert (redness(red) > redness(plain) + 0.1).mean() < 0.9, "and not the sky"
        extend.register_material("broken", RED, "float a = ; return a;")
        np.testing.assert_array_equal(taken(), red)
        errors = [str(error) for error in renderer.shader_errors]
        assert errors and all("generated/materials/broken.glsl:3" in error for error in errors)
        extend.unregister_material("broken")
        np.testing.assert_array_equal(taken(), red)
        assert not renderer.shader_errors
        extend.unregister_material("red_moss")
        np.testing.assert_array_equal(taken(), plain)
