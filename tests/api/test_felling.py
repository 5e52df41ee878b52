"""Trees that a game fells: gone from answers, pictures and shadows, kept in a scene's file, and cheap."""

from __future__ import annotations

import numpy as np
import pytest
from cover_kit import PLACE, names_of, woods

import planetfall as pf
from planetfall.engine.frame.gbuffer import Surface
from planetfall.systems.cover.felling import Felled
from planetfall.systems.cover.growth import Growing
from planetfall.systems.cover.near import Near
from planetfall.systems.cover.shadow_map import ShadowMap
from planetfall.systems.cover.stand import Plot

OVERRIDES = {"cover.reach_m": 80.0, "composite.antialiasing": "none"}


@pytest.fixture
def scene():
    with woods() as found:
        yield found


@pytest.fixture
def sampler(scene):
    return pf.CoverSampler(scene)


# -- answers ---------------------------------------------------------------------------------------------------------


def test_a_felled_tree_is_in_no_answer(scene, sampler):
    before = sampler.within(PLACE, 40.0)
    other = pf.CoverSampler(scene)
    k = int(before.heights_m.argmax())
    breast = before.positions_m[k] * (1.0 + 1.0 / np.linalg.norm(before.positions_m[k]))
    assert sampler.sphere_contact(breast, 0.1)[0][0] > 0.1
    assert sampler.fell(before.names[k]) == 1 and sampler.fell(before.names[k : k + 1]) == 0
    for each in (sampler, other, pf.CoverSampler(scene)):
        assert names_of(before) - names_of(each.within(PLACE, 40.0)) == {tuple(before.names[k].tolist())}
        assert each.sphere_contact(breast, 0.1)[0][0] < 0.0
        assert before.names[k].tolist() not in each.bodies(PLACE, 40.0).names.tolist()
    assert scene.planet[pf.Cover].felled == (tuple(before.names[k].tolist()),)


def test_trees_stand_again(scene, sampler):
    before = sampler.within(PLACE, 40.0)
    assert sampler.fell(before.names) == len(before)
    assert len(sampler.within(PLACE, 40.0)) == 0
    scene.planet[pf.Cover].felled = before.names[:10]
    after = sampler.within(PLACE, 40.0)
    assert names_of(before) - names_of(after) == names_of(before.only(np.arange(10)))
    scene.planet[pf.Cover].felled = ()
    again = sampler.within(PLACE, 40.0)
    np.testing.assert_array_equal(again.names, before.names)
    np.testing.assert_array_equal(again.positions_m, before.positions_m)


def test_none_at_all_may_be_felled(sampler):
    assert sampler.fell(np.zeros((0, 5), int)) == 0 and sampler.fell([]) == 0


@pytest.mark.parametrize(
    ("names", "message"),
    [
        ([1, 2, 3], r"names: expected whole numbers \(N, 5\), .* found shape \(3,\)"),
        (np.zeros((2, 5)), r"names: expected whole numbers \(N, 5\), .* of float64"),
        (
            [[0, 3, 1, 1, 1]],
            r"names\[0\]: expected a name that within\(\) gives on this planet, .* found \[0, 3, 1, 1, 1\]",
        ),
    ],
)
def test_names_that_are_none_are_refused(sampler, names, message):
    with pytest.raises(ValueError, match=message):
        sampler.fell(names)


def test_a_negative_number_is_no_name(sampler):
    wrong = sampler.within(PLACE, 20.0).names[:3].copy()
    wrong[2, 4] = -1
    with pytest.raises(ValueError, match=r"names\[2\]: expected a name"):
        sampler.fell(wrong)


def test_a_sampler_of_a_cover_that_was_replaced_says_so(scene, sampler):
    names = sampler.within(PLACE, 20.0).names
    scene.planet.add(pf.Cover())
    with pytest.raises(ValueError, match="another Cover by now; make a new CoverSampler"):
        sampler.fell(names)
    assert scene.planet[pf.Cover].felled == ()


# -- files -----------------------------------------------------------------------------------------------------------


def test_a_scenes_file_keeps_them(scene, sampler, tmp_path):
    sampler.fell(sampler.within(PLACE, 30.0).names[:7])
    scene.save(tmp_path / "felled.toml")
    with pf.load_scene(tmp_path / "felled.toml") as again:
        assert again.planet[pf.Cover] == scene.planet[pf.Cover]
        np.testing.assert_array_equal(
            pf.CoverSampler(again).within(PLACE, 40.0).names, sampler.within(PLACE, 40.0).names
        )


def test_a_bad_row_in_a_file_is_named(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text('base = "woods"\n[cover]\nfelled = [[0, 17, 3, 4, 5], [0, 17, 3]]\n')
    with pytest.raises(
        pf.PresetError, match=r"cover\.felled\[1\]: expected 5 whole numbers from 0 to .* found \[0, 17, 3\]"
    ):
        pf.load_scene(path)


# -- the list by plot ------------------------------------------------------------------------------------------------


def test_changes_are_told_by_plot():
    felled = Felled()
    first, second, third = (0, 17, 5, 6, 1), (0, 17, 5, 6, 2), (3, 17, 9, 9, 1)
    plots = Plot(0, 17, 5, 6), Plot(3, 17, 9, 9)
    assert felled.refresh((first,)) == {plots[0]} and first in felled and second not in felled
    assert felled.refresh((first, second, third)) == set(plots) and third in felled
    assert felled.refresh((first, third)) == {plots[0]} and second not in felled
    assert felled.refresh((third, first)) == set()
    assert felled.refresh(()) == set(plots) and first not in felled and third not in felled


def test_nothing_is_made_anew_for_a_felled_tree(scene, monkeypatch):
    """Near: the plot's trees are filtered, and made no second time."""
    import planetfall.systems.cover.near as module

    made = []
    plants_in = module.plants_in
    monkeypatch.setattr(module, "plants_in", lambda plots, *more: made.append(len(plots)) or plants_in(plots, *more))
    cover, terrain = scene.planet[pf.Cover], scene.planet[pf.Terrain]
    near = Near()

    def refresh() -> None:
        near.refresh("key", PLACE, 100.0, scene.height_field(), Growing.of(terrain, 0.0), cover, terrain.seed, None)

    refresh()
    count, before, revision = sum(made), near.plants, near.revision
    assert count > 5 and near.other_since(revision - 1) is None
    refresh()
    assert near.revision == revision and near.plants is before
    cover.felled = before.names[:3]
    refresh()
    assert sum(made) == count and names_of(before) - names_of(near.plants) == names_of(before.only(np.arange(3)))
    assert names_of(near.other_since(revision)) == names_of(before.only(np.arange(3)))
    cover.felled = before.names[1:40]
    refresh()
    assert names_of(near.plants) == names_of(before.only(np.arange(len(before)) % len(before) >= 0)) - names_of(
        before.only(np.arange(1, 40))
    )
    other = near.other_since(revision)
    assert other is not None and len(other) == 3 + 1 + 37 and sum(made) == count
    cover.felled = ()
    refresh()
    assert names_of(near.plants) == names_of(before) and sum(made) == count


# -- pictures --------------------------------------------------------------------------------------------------------


def ahead(scene, sampler):
    """A camera two metres before a trunk of view forest, and its tree's name."""
    eye = pf.view("forest", scene.planet).camera.resolve(scene).position_m
    trees = sampler.within(eye, 60.0)
    trees = trees.only(trees.heights_m > 5.0)
    k = int(np.linalg.norm(trees.positions_m - eye, axis=1).argmin())
    foot = trees.positions_m[k]
    up = foot / np.linalg.norm(foot)
    east = np.cross((0.0, 0.0, 1.0), up)
    east /= np.linalg.norm(east)
    latitude, longitude = (float(v) for v in pf.latitude_longitude(foot + 2.0 * east))
    return pf.Camera.at(latitude, longitude, 1.5, above="ground", heading_deg=-90.0), trees.names[k]


def test_the_next_frame_shows_it_gone(scene, sampler):
    camera, name = ahead(scene, sampler)
    with pf.Renderer(scene, size=(96, 54), quality="low", overrides=OVERRIDES) as renderer:
        renderer.settle(camera)

        def near_ahead() -> float:
            out = renderer.render(camera, outputs=("surface", "distance"))
            part = np.s_[24:30, 46:50]
            return float(((out["surface"][part] == Surface.COVER) & (out["distance"][part] < 3.0)).mean())

        assert near_ahead() == 1.0
        sampler.fell(name)
        assert near_ahead() == 0.0
        scene.planet[pf.Cover].felled = ()
        assert near_ahead() == 1.0


def test_the_shadow_map_is_drawn_anew_where_the_tree_was(scope, sampler):
    """To the bit as one that is drawn whole, for trees in its middle and at its edge, low suns and high."""
    trees = sampler.within(PLACE, 150.0)
    middle = PLACE * float(np.linalg.norm(trees.positions_m, axis=1).mean())
    up = PLACE
    east = np.cross((0.0, 0.0, 1.0), up)
    east /= np.linalg.norm(east)
    away = np.linalg.norm(np.cross(trees.positions_m, up), axis=1)
    tall = np.argsort(-trees.heights_m)
    edge = np.where(trees.heights_m < 5.0, np.inf, np.abs(away - 100.0))
    gone = np.concatenate([tall[away[tall] < 30.0][:3], np.argsort(edge)[:4]])
    left = trees.only(np.setdiff1d(np.arange(len(trees)), gone))
    for height in (0.2, 0.6, 1.5):
        sun = np.cos(height) * east + np.sin(height) * up
        parts, whole = ShadowMap(scope, 256), ShadowMap(scope, 256)
        assert parts.draw(trees, (1,), middle, sun, 100.0)
        first = np.frombuffer(parts.heights.read(), np.float32).copy()
        assert parts.draw(left, (2,), middle, sun, 100.0, other=trees.only(gone)) and parts.revision == (2,)
        assert not parts.draw(left, (2,), middle, sun, 100.0)
        whole.draw(left, (2,), middle, sun, 100.0)
        second, expected = (np.frombuffer(m.heights.read(), np.float32) for m in (parts, whole))
        np.testing.assert_array_equal(second, expected)
        changed = (first != second).mean()
        assert 0.002 < changed < 0.3


def test_their_shadow_goes_with_them(scene, sampler):
    """In the frame itself: with all trees of a meadow felled, as without trees."""
    view = pf.view("meadow", scene.planet)
    with pf.Renderer(scene, size=(96, 54), quality="low", overrides=OVERRIDES) as renderer:
        renderer.settle(view)
        eye = renderer.camera_state(view).position_m
        shaded = renderer.render(view, outputs=("radiance",))["radiance"].copy()
        assert sampler.fell(sampler.within(eye, 400.0).names) > 100
        felled = renderer.render(view, outputs=("radiance", "surface"))
        assert (felled["surface"] != Surface.COVER).all()
        bare = felled["radiance"].copy()
        scene.planet[pf.Cover].density = 0.0
        renderer.settle(view)
        none = renderer.render(view, outputs=("radiance",))["radiance"]
    ground = felled["surface"] == Surface.TERRAIN
    near = ground & (np.arange(54)[:, None] > 40)  # farther away the ground has the colour of forests
    np.testing.assert_allclose(bare[near], none[near], rtol=0.02, atol=1e-4)
    assert (shaded.sum(axis=-1) < 0.7 * bare.sum(axis=-1))[ground].mean() > 0.02
