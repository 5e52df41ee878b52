"""A few orders of scattering stand for all, in thick air as well."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.measure.air_speed import probe_scope
from planetfall.benchmarks.measure.air_thick import thick_errors, thick_truth
from planetfall.engine.gpu import Gpu
from planetfall.quality import resolve_quality
from planetfall.systems.atmosphere import tables as tables_module
from planetfall.systems.atmosphere.closing import closing_weights, moved
from planetfall.systems.atmosphere.sizes import table_sizes
from planetfall.systems.atmosphere.tables import QUICK, AirTables

Floats = NDArray[np.float64]


def slab(depth: float, albedo: float, cells: int = 60) -> tuple[Floats, Floats]:
    """A layer that scatters evenly (Milne's problem): its operator K (cells, cells) and its first order, by depth."""
    edges = np.linspace(0.0, depth, cells + 1)
    middle, step = 0.5 * (edges[1:] + edges[:-1]), depth / cells
    mu, weight = np.polynomial.legendre.leggauss(48)
    mu, weight = 0.5 * mu + 0.5, 0.5 * weight
    apart = np.abs(middle[:, None] - middle[None])
    # The mean of exp(-t / mu) / mu over a cell, for light up and down: half of each.
    kernel = (np.exp(-np.maximum(apart - 0.5 * step, 0.0)[..., None] / mu)
              - np.exp(-(apart + 0.5 * step)[..., None] / mu))  # fmt: skip
    own = 2.0 * (1.0 - np.exp(-0.5 * step / mu))
    kernel[np.arange(cells), np.arange(cells)] = own
    return 0.5 * albedo * (kernel * weight).sum(axis=-1), np.exp(-middle / 0.8)


def orders_of(operator: Floats, first: Floats, count: int) -> Floats:
    """(count, cells, 3): the same light in all colours."""
    found = [first]
    for _ in range(count - 1):
        found.append(operator @ found[-1])
    return np.repeat(np.array(found)[..., None], 3, axis=-1)


@pytest.mark.parametrize(("depth", "albedo", "count", "most"), [
    (0.3, 1.0, 4, 1e-3), (1.0, 0.9, 5, 3e-3), (5.0, 0.98, 8, 2e-2), (8.0, 1.0, 12, 3e-2)])  # fmt: skip
def test_a_few_orders_of_a_slab_give_the_solution_of_its_equation(
    depth: float, albedo: float, count: int, most: float
) -> None:
    operator, first = slab(depth, albedo)
    true = np.linalg.solve(np.eye(len(first)) - operator, first)
    means = orders_of(operator, first, count)
    found = (closing_weights(means) * means).sum(axis=0)[:, 0]
    assert np.quantile(np.abs(found / true - 1.0), 0.95) < most


def test_light_is_never_less_than_what_is_known_and_darkness_stays_dark() -> None:
    rng = np.random.default_rng(1)
    means = rng.uniform(0.0, 1.0, (6, 7, 5, 3)) * np.geomspace(1.0, 1e-12, 7)[None, :, None, None]
    means[..., 1] = 0.0
    found = (closing_weights(means) * means).sum(axis=0)
    assert np.isfinite(found).all()
    assert (found >= means.sum(axis=0) * (1.0 - 1e-12)).all()
    assert (found[..., 1] == 0.0).all()
    assert moved(np.zeros((3, 2, 2, 3))) == 0.0
    assert moved(means[:1]) == float("inf")
    assert (closing_weights(means[:1]) == 1.0).all()


def table(gpu: Gpu, scene: Any, quality: str, orders: int) -> tuple[Floats, int]:
    """The mean light (altitude, sun, 3) of the moments, and how many orders were gathered. orders: 0 for all."""
    with probe_scope(gpu, scene) as scope:
        tables = AirTables(scope, table_sizes(resolve_quality(quality)), orders)
        most = 0
        while not tables.done:
            tables.step(1 << 21)
            most = max(most, tables.sums)
        assert not tables.sums, "the sums of single orders are given back"
        found = tables.arrays()["moments"][4, ..., :3].astype(np.float64) ** 4
        tables.release()
    return found, most


@pytest.mark.parametrize(("preset", "gathered", "most"), [("earth", 4, 1e-3), ("mars", 4, 2e-3), ("hazy", 8, 1e-2)])
def test_tables_hold_the_light_of_all_orders(gpu: Gpu, preset: str, gathered: int, most: float) -> None:
    """Against 40 orders that are added up; the sun above the horizon."""
    scene = pf.load_scene(preset)
    found, orders = table(gpu, scene, "low", 0)
    true, _ = table(gpu, scene, "low", 41)
    day = slice(found.shape[1] // 2 + 1, None)
    assert np.quantile(np.abs(found[:, day] / true[:, day] - 1.0), 0.95) < most
    assert orders == gathered, "more where they are needed, and nowhere else"


def test_a_hazy_world_is_as_bright_and_as_orange_as_paths_say() -> None:
    """At `low`, beyond the noise of 1024 paths: a series of the last orders was off by several times that."""
    truth = thick_truth(1024)
    for name, error in thick_errors(truth, "low").items():
        assert error.all_colors < 0.1 + 2.0 * error.noise, name
        assert error.worst_color < 0.3 + 2.0 * error.noise, name


def test_work_that_raises_begins_anew_and_never_passes_for_done(gpu: Gpu, monkeypatch: pytest.MonkeyPatch) -> None:
    with probe_scope(gpu, pf.load_scene("earth")) as scope:
        tables = AirTables(scope, QUICK)

        def broken(_: Floats) -> Floats:
            raise ArithmeticError("on purpose")

        monkeypatch.setattr(tables_module, "closing_weights", broken)
        with pytest.raises(ArithmeticError):
            while not tables.done:
                tables.step(1 << 21)
        assert not tables.done
        assert not tables.sums
        monkeypatch.undo()
        while not tables.done:
            tables.step(1 << 21)
        assert tables.arrays()["moments"][4, ..., :3].max() > 0.0
        tables.release()
