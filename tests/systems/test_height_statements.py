"""A statement of the height function is written once; heights and derivatives on both sides have it."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from planetfall.systems.terrain import crater_form, height_steps, height_surface
from planetfall.systems.terrain.height import TerrainParams
from planetfall.systems.terrain.height_octaves import model_of
from planetfall.systems.terrain.height_statements import Statements
from planetfall.systems.terrain.height_table import octave_table

EARTH = TerrainParams()
INPUTS = ("w1x", "w1y", "w1z", "c", "b", "sa", "sb", "z", "added", "rougher")
GROUND = "    ground = base + (rough + rougher) * z + added\n"
DUNES = "    dunes = 300.0 * smoothstep(w1x * b + 0.5) / (1.0 + c * c) ** 0.5 - k.hill_m * bump(-sa) * rough\n"


@pytest.fixture(scope="module")
def changed(tmp_path_factory):
    """The module, copied, with one statement more."""
    text = Path(height_surface.__file__).read_text(encoding="utf-8")
    assert text.count(GROUND) == 1
    file = tmp_path_factory.mktemp("statements") / "height_surface.py"
    file.write_text(text.replace(GROUND, DUNES + GROUND.replace("+ added", "+ added + dunes")), encoding="utf-8")
    spec = importlib.util.spec_from_file_location(f"{height_surface.__package__}.changed", file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def inputs():
    """Places of all kinds, in numbers that floats hold: {input: (N,)}."""
    rng = np.random.default_rng(3)
    spread = (0.5, 0.5, 0.5, 1.0, 0.05, 1.0, 1.0, 2000.0, 500.0, 0.3)
    return {name: (s * rng.normal(size=400)).astype(np.float32) for name, s in zip(INPUTS, spread, strict=True)}


def exact(inputs):
    return [inputs[name].astype(np.float64) for name in INPUTS]


@pytest.mark.parametrize("share", [1.0, 0.4])
def test_derivatives_are_those_of_the_heights(changed, inputs, share):
    """share: of z that is seen. Heights, and how far the limit bends them, have all of it."""
    k, values = model_of(EARTH).constants, exact(inputs)
    straight = replace(k, knee_high_m=1e9, knee_low_m=-1e9)
    for module in (height_surface, changed):
        value, *by, on_land = module.surface_slopes(k, *values, share * values[7])
        assert np.array_equal(value, module.surface(k, *values)), "to the bit"
        assert np.array_equal(on_land, module.surface_parts(k, *values[:7])[2])
        give = module.limit_slope(k, module.surface(straight, *values))
        for i, found in enumerate(by):
            ends, step = [], 1e-6 * np.abs(values[i]).max()
            for change in (-step, step):
                there = values.copy()
                there[7] = share * values[7]
                there[i] = there[i] + change
                ends.append(module.surface(straight, *there))
            expected = give * (ends[1] - ends[0]) / (2.0 * step)
            np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-5 * np.abs(expected).max())
    assert np.abs(changed.surface(k, *values) - height_surface.surface(k, *values)).max() > 100.0


def test_shaders_have_the_same(changed, inputs, run_compute, gpu):
    k, scope = model_of(EARTH).constants, gpu.scope("test")
    block = scope.buffer(octave_table(EARTH, np.array([0.0, 0.6, 0.8])).tobytes())
    names = ", ".join(INPUTS)
    body = f"""TerrainConstants k = terrain_table.constants;
        h = terrain_surface(k, {names});
        TerrainSurfaceSlopes t = terrain_surface_slopes(k, {names}, 0.4 * z);
        {" ".join(f"by_{name} = t.by_{name};" for name in INPUTS)}"""
    outputs = dict.fromkeys(["h", *(f"by_{name}" for name in INPUTS)], "float")
    pairs = f"""Pair exact = terrain_surface(terrain_table.constants, {", ".join(f"pair({name})" for name in INPUTS)});
        high = exact.high;
        low = exact.low;"""
    step = ", ".join(f"size * d_{name}" for name in INPUTS)
    change = f"change = terrain_surface_change(terrain_table.constants, {names}, {step});"
    turned = {f"d_{name}": np.roll(values, 1) for name, values in inputs.items()}

    def run(body, outputs, defines=None, **more):
        return run_compute(
            body, {**inputs, **more}, outputs, '#include "terrain/height.glsl"', defines,
            setup=lambda _: block.bind_to_uniform_block(4),
        )  # fmt: skip

    try:
        for module in (height_surface, changed):
            gpu.shaders.add_virtual("generated/terrain_surface.glsl", module.shader())
            out = run(body, outputs)
            value, *by, _ = module.surface_slopes(k, *exact(inputs), 0.4 * exact(inputs)[7])
            assert np.abs(out["h"] - value).max() <= 0.02
            for name, expected in zip(INPUTS, by, strict=True):
                assert np.abs(out[f"by_{name}"] - expected).max() <= 1e-5 * np.abs(expected).max()
            out = run(pairs, {"high": "float", "low": "float"}, {"TERRAIN_CANONICAL": 1})
            # Each of 40 steps is within 2^-46 of terms of up to 20 km, which some multiply by tens.
            assert np.abs(out["high"].astype(np.float64) + out["low"] - value).max() <= 1e-7
            for size in (1e-6, 1e-3, 1.0):  # of the inputs' own spread
                steps = [np.float32(size) * turned[f"d_{name}"] for name in INPUTS]
                there = [a + b.astype(np.float64) for a, b in zip(exact(inputs), steps, strict=True)]
                found = run(change, {"change": "float"}, size=np.float32(size), **turned)["change"]
                error = np.abs(found - (module.surface(k, *there) - value))
                assert error.max() <= 5e-2 * size + 1e-11, "as exact as the change is small"
    finally:
        gpu.shaders.add_virtual("generated/terrain_surface.glsl", height_surface.shader())
        scope.release()


def made_of(module):
    return Statements(Path(module.__file__).read_text(encoding="utf-8"), {**vars(height_steps), **vars(module)})


@pytest.mark.parametrize("name", ["smoothstep", "bump", "positive", "ridge"])
def test_changes_of_steps_are_as_exact_as_they_are_small(name):
    made, rng = made_of(height_steps), np.random.default_rng(5)
    f = made[name]
    change, value, share = (
        made.python(f.change(f.inputs[:1])),
        getattr(height_steps, name),
        [np.float32(0.5)] * (len(f.inputs) - 1),
    )
    for size in (1e-6, 1e-3, 3.0):
        t = rng.uniform(-1.5, 1.5, 4000).astype(np.float32)
        d = (size * rng.normal(size=4000)).astype(np.float32)
        exact = t.astype(np.float64)
        expected = value(exact + d, *share) - value(exact, *share)
        found = change(t, *share, d)
        assert found.dtype == np.float32
        assert (np.abs(found - expected) <= 2e-6 * np.abs(d) + 1e-15).all()


def test_changes_of_craters_are_those_of_their_form():
    made, rng, count = made_of(crater_form), np.random.default_rng(6), 4000
    names = ("d_form", "d_covered", "new_slope", "new_covered_slope")
    change = made.python(made["crater_form"].change(["aside"], names))
    shape, curve = crater_form.CraterShape(0.2, 0.35, 0.07, 0.05), 0.1
    draws = rng.random((2, count))
    foot = rng.uniform(0.0, 0.2, count)
    along = 0.5 * foot * curve + rng.uniform(-0.3, 0.3, count) * foot**0.5  # up to 0.3 above the sphere
    z, root = crater_form.crater_above(foot, along, curve)
    for size in (1e-10, 1e-4, 0.1):
        aside, d = foot - z * z, size * rng.random(count)
        found = change(shape, aside, z, root, 1.0, *draws, d)
        before, after = (crater_form.crater_form(shape, v, z, root, 1.0, *draws) for v in (aside, aside + d))
        for name, i in (("d_form", 0), ("d_covered", 3)):
            error = found[names.index(name)] - (after[i] - before[i])
            assert np.abs(error).max() <= 1e-12
        for name, i in (("new_slope", 5), ("new_covered_slope", 6)):
            np.testing.assert_allclose(found[names.index(name)], after[i], atol=1e-9)


def test_what_is_no_statement_is_named():
    made = Statements("def f(k, t):\n    if t > 0:\n        return t\n    return 0.0\n", {})
    with pytest.raises(ValueError, match=r"f, line 2: if t > 0"):
        made["f"]
