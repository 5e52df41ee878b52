"""A planet's own species: where they grow, what they leave as it was, their contacts, what is drawn of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.wavelengths import wavelengths_of
from planetfall.systems.cover.own_colours import own_defines, packed
from planetfall.systems.cover.species import Species, of_own
from planetfall.systems.cover.trunks import COLUMN_TRUNK, TREE_TRUNK, Trunks
from planetfall.systems.terrain.ground_params import ground_params
from planetfall.systems.terrain.height import TerrainField

SIZE = (160, 90)
WAVELENGTHS = wavelengths_of({})
TREE = pf.CoverSpecies(name="tree", share=0.5, height_m=20.0, driest=0.0)


@pytest.fixture(scope="module")
def scene():
    with pf.load_scene("earth") as found:
        yield found


def around(scene, view, species, radius_m=120.0, **changes):
    """All plants around a view's place, with these species alone."""
    cover = scene.planet[pf.Cover]
    before = {key: getattr(cover, key) for key in ("species", *changes)}
    try:
        for key, value in {"species": species, **changes}.items():
            setattr(cover, key, value)
        eye = pf.view(view, scene.planet).camera.resolve(scene).position_m
        return pf.CoverSampler(scene).within(eye, radius_m)
    finally:
        for key, value in before.items():
            setattr(cover, key, value)


def test_earth_has_saguaros_in_deserts_and_ferns_in_forests(scene):
    own = scene.planet[pf.Cover].species
    names = np.array([each.name for each in own])
    desert, forest = around(scene, "desert", own), around(scene, "forest", own)
    assert set(names[of_own(desert.species)]) == {"saguaro", "agave"} and (of_own(desert.species) >= 0).all()
    assert set(names[of_own(forest.species)[of_own(forest.species) >= 0]]) == {"fern"}
    assert len(around(scene, "desert", ())) == 0
    saguaro = desert.only(desert.forms == Species.COLUMN)
    assert len(saguaro) > 20 and (saguaro.heights_m < 1.1 * 9.0).all()


FERN = pf.CoverSpecies(name="fern", form="rosette", share=0.3, height_m=0.8, crown=0.9, driest=0.62, coldest=0.18)
REED = pf.CoverSpecies(name="reed", form="rosette", share=1.0, height_m=2.0, crown=0.3, driest=0.0, waterside_m=8.0)


@pytest.mark.parametrize("view", ["river", "lake"])
def test_reeds_stand_along_water_and_in_its_shallows_alone(scene, view):
    found = around(scene, view, (REED,), 250.0)
    reeds = found.only(of_own(found.species) == 0)
    assert len(reeds) > 30
    ground = pf.TerrainSampler(scene)
    water = ground.water(reeds.up)
    deep_m = np.where(np.isfinite(water.level_m), water.level_m - ground.height(reeds.up), 0.0)
    assert deep_m.max() < 0.31 and (deep_m > 0.0).any() and (deep_m <= 0.0).any()
    field = TerrainField(ground_params(scene.planet[pf.Terrain], scene.planet.radius_m, True))
    assert field.from_water_m(reeds.up).max() < 8.0 + 1e-3
    # All others stay: only within that distance some are reeds now.
    plain = around(scene, view, (), 250.0)
    kinds = {tuple(name): kind for name, kind in zip(found.names.tolist(), found.species, strict=True)}
    away_m = field.from_water_m(plain.up)
    assert (away_m < 30.0).sum() > 5
    for name, kind, away in zip(plain.names.tolist(), plain.species, away_m, strict=True):
        assert kinds[tuple(name)] == kind or (away < 8.0 and of_own(kinds[tuple(name)]) == 0)


MANGROVE = pf.CoverSpecies(name="mangrove", share=1.0, height_m=8.0, driest=0.5, coldest=0.7, shore_m=1.2)


def test_mangroves_stand_in_the_seas_shallows_alone(scene):
    found = around(scene, "mangroves", (MANGROVE, REED), 250.0)
    mangroves = found.only(of_own(found.species) == 0)
    assert len(mangroves) > 100
    above_m = pf.TerrainSampler(scene).height(mangroves.up) - scene.planet[pf.Ocean].sea_level_m
    assert above_m.min() > -1.2 and above_m.max() < 0.05 * scene.planet[pf.Terrain].beach_height_m + 1e-6
    assert (above_m < -0.5).any()
    # All others stay.
    plain = around(scene, "mangroves", (REED,), 250.0)
    others = found.only(of_own(found.species) != 0)
    assert len(plain) > 0 and np.array_equal(plain.names, others.names)


def test_without_a_sea_nothing_stands_in_it():
    with pf.load_scene("earth") as scene:
        eye = pf.view("mangroves", scene.planet).camera.resolve(scene).position_m
        scene.planet[pf.Cover].species = (MANGROVE,)
        assert (of_own(pf.CoverSampler(scene).within(eye, 250.0).species) == 0).any()
        scene.planet.remove(pf.Ocean)
        assert not (of_own(pf.CoverSampler(scene).within(eye, 250.0).species) == 0).any()


@pytest.mark.parametrize("form", ["broadleaf", "conifer", "flat", "palm", "column", "shrub", "rosette"])
def test_others_neither_move_nor_lose_their_names(scene, form):
    """Some become one of the planet's own, in places that all had before; new ones stand between."""
    plain = around(scene, "forest", ())
    found = around(scene, "forest", (replace(TREE, form=form, share=0.3),))
    before = {tuple(name): place for name, place in zip(plain.names.tolist(), plain.positions_m, strict=True)}
    after = {tuple(name): k for k, name in enumerate(found.names.tolist())}
    assert before.keys() <= after.keys()
    for name, place in before.items():
        assert np.array_equal(found.positions_m[after[name]], place)
    own = of_own(found.species) >= 0
    assert own.any() and not own.all()
    others = {tuple(name): kind for name, kind in zip(found.names[~own].tolist(), found.species[~own], strict=True)}
    kinds = {tuple(name): kind for name, kind in zip(plain.names.tolist(), plain.species, strict=True)}
    assert others.items() <= kinds.items()


def test_shares_are_those_of_places(scene):
    """In a climate that suits both: 0.3 and 0.1 of the places, whatever grows there besides."""
    wide = {"spacing_m": 10.0, "steepest_deg": 89.0}
    places = len(around(scene, "desert", (replace(TREE, share=1.0),), 400.0, **wide))
    found = around(scene, "desert", (replace(TREE, share=0.3), replace(TREE, share=0.1)), 400.0, **wide)
    counts = [np.count_nonzero(of_own(found.species) == k) for k in range(2)]
    assert places > 4000
    for count, share in zip(counts, (0.3, 0.1), strict=True):
        assert abs(count - share * places) < 5.0 * np.sqrt(places * share)


def test_climate_ends_them(scene):
    for changes in ({"wettest": 0.05}, {"driest": 1.5}, {"coldest": 1.9}, {"warmest": 0.01}):
        found = around(scene, "forest", (replace(TREE, **changes),))
        assert not (of_own(found.species) >= 0).any(), changes


def test_a_column_is_touched_at_its_stem_and_a_rosette_nowhere(scene):
    saguaro = around(scene, "desert", scene.planet[pf.Cover].species, 60.0)
    column, low = saguaro.forms == Species.COLUMN, saguaro.forms == Species.ROSETTE
    trunks = Trunks.of(saguaro.only(column))
    assert np.allclose(trunks.foot_radii_m, COLUMN_TRUNK * saguaro.radii_m[column])
    assert (trunks.foot_radii_m > TREE_TRUNK * saguaro.heights_m[column]).all()
    sampler = pf.CoverSampler(scene)
    eye = pf.view("desert", scene.planet).camera.resolve(scene).position_m
    place, tall = saguaro.positions_m[column][0], saguaro.heights_m[column][0]
    depth, normal = sampler.sphere_contact((place * (1.0 + 0.1 * tall / np.linalg.norm(place)))[None], 0.2)
    assert depth[0] > 0.2 and abs(normal[0] @ (place / np.linalg.norm(place))) < 0.3
    bodies = sampler.bodies(eye, 60.0)
    assert len(bodies.names) == column.sum() and low.any()


def test_scene_files_keep_them(scene, tmp_path):
    scene.save(tmp_path / "own.toml")
    with pf.load_scene(tmp_path / "own.toml") as again:
        assert again.planet[pf.Cover].species == scene.planet[pf.Cover].species
    text = (tmp_path / "own.toml").read_text().replace('form = "column"', 'form = "cactus"')
    (tmp_path / "own.toml").write_text(text)
    with pytest.raises(pf.PresetError, match=r"cover\.species\[0\]\.form: expected one of .*column.*cactus"):
        pf.load_scene(tmp_path / "own.toml")


def test_shaders_know_nothing_of_them_where_there_are_none():
    assert own_defines(()) == {} and own_defines((TREE,))["COVER_SPECIES"] == 1
    rows = packed((TREE, replace(TREE, translucency=0.9, sheds=True)), WAVELENGTHS)
    assert rows.shape == (36, 4) and rows[0, 3] == 1.0 and rows[4, 3] == np.float32(0.9) and rows[5, 0] == 1.0


@pytest.mark.gpu
def test_leaves_of_their_own_go_through_eight_bits_and_others_are_none(run_compute):
    """Each of 7 steps of translucency exactly, open within half of a step of 15, the root of the albedo within 2 of
    255; and no code of bark (open to 0.87) or of other leaves is taken for one."""
    k = np.arange(7 * 200)
    values = {"through": (0.15 * (k % 7)).astype("f4"), "root": ((k // 7) / 199.0).astype("f4")}
    out = run_compute(
        "vec4 stored = round(255.0 * coded_leaf(vec3(root, 1.0 - root, 0.5 * root), through, root)) / 255.0;"
        "o = decoded_leaf(stored).x; l = decoded_leaf(stored).y; r = stored.r; g = stored.g; b = stored.b;"
        "own = float(is_coded_leaf(stored)) - float(is_coded_leaf(vec4(0.5, 0.5, 0.5, 0.5 + 0.5 * root)))"
        " - float(is_coded_leaf(vec4(0.5, 0.5, 0.5, 0.5 * 0.87 * root)));",
        values, dict.fromkeys(("o", "l", "r", "g", "b", "own"), "float"),
        header='#include "cover/translucency.glsl"\n', count=len(k),
    )  # fmt: skip
    assert (out["own"] == 1.0).all()
    np.testing.assert_allclose(out["l"], values["through"], atol=1e-6)
    np.testing.assert_allclose(out["o"], values["root"], atol=0.5 / 15.0 + 1e-6)
    for name, wanted in (("r", values["root"]), ("g", 1.0 - values["root"]), ("b", 0.5 * values["root"])):
        assert np.abs(out[name] - wanted).max() < 2.01 / 255.0 and out[name].min() >= 0.0 and out[name].max() <= 1.0


@pytest.mark.gpu
def test_each_form_is_seen_and_its_colour_is_its_own(scene):
    """A red one of each form stands in the desert; without it nothing is red."""
    cover = scene.planet[pf.Cover]
    before = cover.species

    def red(species) -> float:
        cover.species = species
        picture = renderer.snapshot(pf.view("desert", scene.planet)).array.astype(float)
        return float((picture[..., 0] > 2.0 * picture[..., 1]).mean())

    try:
        with pf.Renderer(scene, SIZE, "low") as renderer:
            assert red(()) < 1e-4
            for form in ("broadleaf", "conifer", "flat", "palm", "column", "shrub", "rosette"):
                own = replace(
                    TREE, form=form, share=0.5, height_m=8.0, crown=0.3, albedo=(0.6, 0.01, 0.01), translucency=0.0
                )
                assert red((own,)) > 0.003, form
    finally:
        cover.species = before


def test_more_than_twelve_are_refused(scene):
    cover = scene.planet[pf.Cover]
    with pytest.raises(pf.SettingError, match=r"species.*at most 12, found 13"):
        cover.species = (TREE,) * 13


def test_a_mask_takes_away_and_brings_nothing(scene):
    """With half of the places left, of others exactly some of those that stood."""
    half = around(scene, "savanna", (replace(TREE, share=0.2),), mask=lambda d: np.full(len(d), 0.5))
    whole = around(scene, "savanna", (replace(TREE, share=0.2),))
    assert set(map(tuple, half.names.tolist())) <= set(map(tuple, whole.names.tolist()))
    for own in (True, False):
        share = (of_own(half.species) >= 0 if own else of_own(half.species) < 0).sum()
        among = (of_own(whole.species) >= 0 if own else of_own(whole.species) < 0).sum()
        assert 0.35 * among < share < 0.65 * among


def test_a_sampler_keeps_the_species_that_it_was_made_with(scene):
    cover, eye = scene.planet[pf.Cover], pf.view("desert", scene.planet).camera.resolve(scene).position_m
    before = cover.species
    sampler, share = pf.CoverSampler(scene), before[0].share
    try:
        count = len(sampler.within(eye, 50.0))
        before[0].share = 1.0
        assert len(sampler.within(-eye, 10.0)) >= 0 and len(sampler.within(eye, 50.0)) == count
        assert len(pf.CoverSampler(scene).within(eye, 50.0)) > count
    finally:
        before[0].share = share


@pytest.mark.gpu
def test_seen_from_above_a_rosette_stands_on_the_ground(scene):
    """And so does all that is labelled: every leaf has an instance, and is one of leaves."""
    cover = scene.planet[pf.Cover]
    before = cover.species
    cover.species = (replace(FERN, driest=0.0, coldest=0.0, share=1.0, height_m=2.0),)
    eye = pf.view("desert", scene.planet).camera.resolve(scene).position_m
    up = eye / np.linalg.norm(eye)
    latitude, longitude = np.degrees(np.arcsin(up[2])), np.degrees(np.arctan2(up[1], up[0]))
    try:
        with pf.Renderer(scene, SIZE, "low") as renderer:
            camera = pf.Camera.at(latitude, longitude, 12.0, pitch_deg=-80.0, above="ground")
            found = renderer.render(camera, outputs=("color", "distance", "instance", "material"))
            cover.species = ()
            bare = renderer.render(camera, outputs=("color", "distance"))
    finally:
        cover.species = before
    plants = found["instance"] > 0
    assert plants.mean() > 0.1
    above = bare["distance"][plants] - found["distance"][plants]
    assert np.median(above) > 0.1 and (above > -0.3).mean() > 0.98 and above.max() < 4.0
    assert len(np.unique(found["material"][plants])) == 1
