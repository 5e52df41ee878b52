"""The table of slabs on disk: computed once, the same bits from the file."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.systems.clouds import slab


def test_a_table_is_solved_once_and_then_read(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path))
    slab.slab_table.cache_clear()
    first = slab.slab_table(0.99, 0.8, 3, 3, 3)
    slab.slab_table.cache_clear()

    def none(*_: object) -> None:
        raise AssertionError("solved again")

    with monkeypatch.context() as patched:
        patched.setattr(slab, "solve", none)
        np.testing.assert_array_equal(slab.slab_table(0.99, 0.8, 3, 3, 3).values, first.values)
        with pytest.raises(AssertionError, match="solved again"):
            slab.slab_table(0.99, 0.7, 3, 3, 3)
    slab.slab_table.cache_clear()


@pytest.mark.parametrize(("albedo", "asymmetry"), [(1.1, 0.5), (float("nan"), 0.5), (1.0, 1.0), (1.0, -1.0)])
def test_droplets_that_cannot_be_are_refused(albedo: float, asymmetry: float) -> None:
    with pytest.raises(ValueError, match=r"expected an albedo from 0 to 1"):
        slab.slab_table(albedo, asymmetry)
