"""Bench ocean: the sea."""

from __future__ import annotations

from collections.abc import Mapping

from ..session import Bench
from .ocean_sampler import SAMPLER_BENCHES

BENCHES: Mapping[str, Bench] = {**SAMPLER_BENCHES}
